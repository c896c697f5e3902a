!> TIE: nodes at one place become one node, the lowest of their numbers.
!!
!! The tolerance is FEAP's: 1e-3 of the mesh's extent in each direction over the square root of the
!! number of nodes. Restraints of tied nodes join, their forces add up.
!!
!! Source: FEAPpv's manual
module setup_tie
  use base_kinds, only: wp
  use base_sort, only: sort_index
  use boundary, only: boundary_t
  use mesh, only: mesh_t, body_t
  use rigid_block, only: is_rigid
  use setup_build, only: build_t, tie_t
  implicit none
  private
  public :: tie_nodes

  real(wp), parameter :: SHARE = 1.0e-3_wp
  integer, parameter :: PER_CELL = 4, MOST_CELLS = 200 !! of the search grid

contains

  !> Carry out all TIE records; `used` is set anew.
  subroutine tie_nodes(build, mesh, bc)
    type(build_t), intent(in) :: build
    type(mesh_t), intent(inout) :: mesh
    type(boundary_t), intent(inout) :: bc
    integer, allocatable :: new(:)
    integer :: i, n, b

    if (size(build%tie) == 0) return
    new = [(n, n=1, mesh%nnode)]
    do i = 1, size(build%tie)
      call find_pairs(build, build%tie(i), mesh, new)
    end do
    do n = 1, mesh%nnode
      new(n) = new(new(n)) ! numbers fall, so the target is final
    end do
    call join_conditions(new, bc)
    mesh%used = .false.
    do b = 1, size(mesh%block)
      do i = 1, mesh%block(b)%nelem
        mesh%block(b)%conn(:, i) = new(mesh%block(b)%conn(:, i))
        mesh%used(mesh%block(b)%conn(:, i)) = .true.
      end do
    end do
    do b = 1, size(mesh%body)
      call renumber_body(new, mesh%body(b))
    end do
  end subroutine tie_nodes

  !> new(n): the node that n becomes.
  subroutine find_pairs(build, tie, mesh, new)
    type(build_t), intent(in) :: build
    type(tie_t), intent(in) :: tie
    type(mesh_t), intent(in) :: mesh
    integer, intent(inout) :: new(:)
    integer, allocatable :: head(:, :, :), next(:), class(:)
    real(wp) :: low(3), high(3), tol(3), width(3)
    integer :: n, m, d, at(3), cells(3)

    if (.not. any(mesh%used)) return
    do d = 1, 3
      low(d) = minval(mesh%xr(d, :), mesh%used)
      high(d) = maxval(mesh%xr(d, :), mesh%used)
    end do
    tol = (high - low)*merge(tie%tolerance, SHARE/sqrt(real(mesh%nnode, wp)), &
                             tie%tolerance > 0.0_wp)
    call classify(build, tie, mesh, tol, class)
    cells = max(1, min(MOST_CELLS, int((real(mesh%nnode, wp)/PER_CELL)**(1.0_wp/3.0_wp))))
    width = (high - low)/cells
    where (width < 2.0_wp*tol .or. .not. width > 0.0_wp)
      cells = 1
      width = max(high - low, tiny(1.0_wp))
    end where
    allocate (head(cells(1), cells(2), cells(3)), next(mesh%nnode), source=0)
    do n = 1, mesh%nnode
      if (class(n) == 0 .or. new(n) /= n) cycle
      at = cell_of(mesh%xr(:, n))
      m = partner(n, at)
      if (m > 0) then
        new(n) = m
      else
        next(n) = head(at(1), at(2), at(3))
        head(at(1), at(2), at(3)) = n
      end if
    end do

  contains

    pure function cell_of(x) result(c)
      real(wp), intent(in) :: x(3)
      integer :: c(3)

      c = max(1, min(cells, int((x - low)/width) + 1))
    end function cell_of

    !> A node kept so far that is in reach; 0: none.
    pure integer function partner(n, at) result(m)
      integer, intent(in) :: n, at(3)
      integer :: i, j, k

      do k = max(1, at(3) - 1), min(cells(3), at(3) + 1)
        do j = max(1, at(2) - 1), min(cells(2), at(2) + 1)
          do i = max(1, at(1) - 1), min(cells(1), at(1) + 1)
            m = head(i, j, k)
            do while (m > 0)
              if (matches(n, m)) return
              m = next(m)
            end do
          end do
        end do
      end do
      m = 0
    end function partner

    pure logical function matches(a, b)
      integer, intent(in) :: a, b

      matches = all(abs(mesh%xr(:, a) - mesh%xr(:, b)) <= tol)
      if (matches .and. tie%material(1) /= tie%material(2)) matches = iand(class(a), class(b)) == 0
    end function matches
  end subroutine find_pairs

  !> Nodes that take part: 0 for none; of two materials bit 0 and bit 1.
  subroutine classify(build, tie, mesh, tol, class)
    type(build_t), intent(in) :: build
    type(tie_t), intent(in) :: tie
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: tol(3)
    integer, allocatable, intent(out) :: class(:)
    integer :: b, i, number

    allocate (class(mesh%nnode), source=0)
    do b = 1, size(mesh%block)
      number = 0 ! of rigid bodies
      if (.not. is_rigid(mesh%block(b))) then
        number = build%model%material(mesh%block(b)%material)%number
      end if
      if (tie%material(1) > 0 .and. all(tie%material /= number)) cycle
      do i = 1, mesh%block(b)%nelem
        class(mesh%block(b)%conn(:, i)) = merge(2, 1, number == tie%material(2))
      end do
    end do
    where ([(i < tie%from .or. i > tie%to, i=1, mesh%nnode)]) class = 0
    if (tie%direction == 0) return
    where (abs(mesh%xr(tie%direction, :) - tie%coordinate) > tol(tie%direction)) class = 0
  end subroutine classify

  subroutine join_conditions(new, bc)
    integer, intent(in) :: new(:)
    type(boundary_t), intent(inout) :: bc
    integer :: n

    do n = 1, size(new)
      associate (m => new(n))
        if (m == n) cycle
        where (bc%fixed(:, m) == 0 .and. bc%fixed(:, n) /= 0) bc%value(:, m) = bc%value(:, n)
        bc%fixed(:, m) = max(bc%fixed(:, m), bc%fixed(:, n))
        bc%force(:, m) = bc%force(:, m) + bc%force(:, n)
        bc%force(:, n) = 0.0_wp
      end associate
    end do
  end subroutine join_conditions

  !> A body's nodes, each once, with the faces of all that became one.
  subroutine renumber_body(new, body)
    integer, intent(in) :: new(:)
    type(body_t), intent(inout) :: body
    integer, allocatable :: order(:)
    integer :: i, n

    body%node = new(body%node)
    allocate (order(size(body%node)))
    call sort_index(body%node, order)
    body%mask = body%mask(order)
    body%node = body%node(order)
    n = min(1, size(order))
    do i = 2, size(order)
      if (body%node(i) == body%node(n)) then
        body%mask(n) = ior(body%mask(n), body%mask(i))
      else
        n = n + 1
        body%node(n) = body%node(i)
        body%mask(n) = body%mask(i)
      end if
    end do
    body%node = body%node(:n)
    body%mask = body%mask(:n)
  end subroutine renumber_body

end module setup_tie
