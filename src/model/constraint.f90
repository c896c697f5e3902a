!> Linear constraints between nodes: x_s = sum_i c_i x_i, in the reference and in the current
!! configuration (hanging nodes). The slave s has no unknowns: its displacement follows from those
!! of its masters, and the forces on the slave act on the masters.
module constraint
  use base_error, only: place_t
  use base_grow, only: grow
  use base_kinds, only: wp
  implicit none
  private
  public :: constraint_t, add_constraint, join_constraints, follow, fold_force, slave_marks

  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! coefficients that differ by no more are equal

  !> All constraints of a mesh. The masters of constraint i are master(first(i):first(i+1)-1). Once
  !! the mesh is complete, no master is itself a slave, and the coefficients of each slave sum to
  !! one.
  type :: constraint_t
    integer :: n = 0
    integer, allocatable :: slave(:)       !! (n)
    integer, allocatable :: first(:)       !! (n+1)
    integer, allocatable :: master(:)
    real(wp), allocatable :: c(:)          !! (size(master)) [-]
    type(place_t), allocatable :: place(:) !! (n) place of the constraint in the deck
  end type constraint_t

contains

  !> Add a constraint.
  subroutine add_constraint(list, slave, master, c, place)
    type(constraint_t), intent(inout) :: list
    integer, intent(in) :: slave
    integer, intent(in) :: master(:)  !! (m)
    real(wp), intent(in) :: c(:)      !! (m)
    type(place_t), intent(in) :: place
    integer :: last, m

    m = size(master)
    call grow(list%first, list%n + 2)
    if (list%n == 0) list%first(1) = 1
    last = list%first(list%n + 1) + m - 1
    list%n = list%n + 1
    call grow(list%slave, list%n)
    call grow(list%place, list%n)
    call grow(list%master, last)
    call grow(list%c, last)
    list%slave(list%n) = slave
    list%master(last - m + 1:last) = master
    list%c(last - m + 1:last) = c
    list%first(list%n + 1) = last + 1
    list%place(list%n) = place
  end subroutine add_constraint

  !> Replace nodes by those that TIE joins them to. Of equal constraints whose slaves become one
  !! node, the first is kept, as on the common face of two meshes with the same hanging nodes.
  subroutine join_constraints(list, new)
    type(constraint_t), intent(inout) :: list
    integer, intent(in) :: new(:) !! (nnode)
    type(constraint_t) :: joined
    integer :: first(size(new)) ! first constraint of each slave; 0: none
    integer :: i, j

    if (list%n == 0) return
    first = 0
    do i = 1, list%n
      associate (s => list%slave(i), &
                 master => list%master(list%first(i):list%first(i + 1) - 1), &
                 c => list%c(list%first(i):list%first(i + 1) - 1))
        j = first(new(s))
        if (j > 0) then
          if (list%slave(j) /= s .and. are_equal(list, new, i, j)) cycle
        else
          first(new(s)) = i
        end if
        call add_constraint(joined, new(s), new(master), c, list%place(i))
      end associate
    end do
    list = joined
  end subroutine join_constraints

  !> Do two constraints have the same masters and coefficients after TIE?
  pure logical function are_equal(list, new, i, j) result(equal)
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: new(:) !! (nnode)
    integer, intent(in) :: i, j
    integer :: k, m

    equal = .false.
    associate (a => list%first(i), b => list%first(i + 1) - 1, &
               c => list%first(j), d => list%first(j + 1) - 1)
      do k = 1, b - a + d - c + 2
        m = new(list%master(merge(a + k - 1, c + k - (b - a + 2), k <= b - a + 1)))
        if (abs(sum(list%c(a:b), new(list%master(a:b)) == m) &
                - sum(list%c(c:d), new(list%master(c:d)) == m)) > ROUNDING) return
      end do
    end associate
    equal = .true.
  end function are_equal

  !> Compute displacements or positions of the slaves from those of their masters.
  pure subroutine follow(list, u)
    type(constraint_t), intent(in) :: list
    real(wp), intent(inout) :: u(:, :) !! (3, nnode) displacements or positions
    integer :: i, j
    real(wp) :: v(3)

    do i = 1, list%n
      v = 0.0_wp
      do j = list%first(i), list%first(i + 1) - 1
        v = v + list%c(j)*u(:, list%master(j))
      end do
      u(:, list%slave(i)) = v
    end do
  end subroutine follow

  !> Move the forces on slaves to their masters.
  pure subroutine fold_force(list, f)
    type(constraint_t), intent(in) :: list
    real(wp), intent(inout) :: f(:, :) !! (3, nnode)
    integer :: i, j

    do i = 1, list%n
      do j = list%first(i), list%first(i + 1) - 1
        f(:, list%master(j)) = f(:, list%master(j)) + list%c(j)*f(:, list%slave(i))
      end do
      f(:, list%slave(i)) = 0.0_wp
    end do
  end subroutine fold_force

  !> Index of the constraint of each node; 0: the node is not a slave.
  pure function slave_marks(list, nnode) result(mark)
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: nnode
    integer :: mark(nnode)
    integer :: i

    mark = 0
    do i = 1, list%n
      mark(list%slave(i)) = i
    end do
  end function slave_marks

end module constraint
