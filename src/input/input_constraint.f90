!> Constraints of nodes, made ready: chains of slaves resolved, geometry and supports checked.
module input_constraint
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_sort, only: find
  use base_text, only: to_text, quoted
  use boundary, only: boundary_t
  use constraint, only: constraint_t, add_constraint, follow, slave_marks
  use mesh, only: mesh_t
  use input_draft, only: build_t
  implicit none
  private
  public :: close_constraints, release_slaves

  real(wp), parameter :: ON_PLACE = 1.0e-6_wp !! of the masters' extent: a slave is where they say
  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! of a sum of coefficients, of a prescribed value

contains

  !> Of slaves whose elements are there: masters that are no slaves, and positions that fit exactly.
  subroutine close_constraints(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(inout) :: mesh
    type(constraint_t) :: closed
    type(error_t), allocatable :: error
    integer :: mark(mesh%nnode)
    integer :: i

    if (mesh%constraint%n == 0) return
    call mark_slaves(mesh, mark, error)
    if (allocated(error)) call build%errors%add(error)
    if (allocated(error)) return
    do i = 1, mesh%constraint%n
      if (.not. mesh%used(mesh%constraint%slave(i))) cycle
      call close_one(mesh, mark, i, closed, error)
      if (.not. allocated(error)) call check_place(mesh, closed, error)
      if (.not. allocated(error)) cycle
      call build%errors%add(error)
      return
    end do
    mesh%constraint = closed
    call follow(closed, mesh%xr)
    do i = 1, closed%n
      mesh%used(closed%master(closed%first(i):closed%first(i + 1) - 1)) = .true.
    end do
  end subroutine close_constraints

  !> Constraint of each slave; a node is slave once.
  subroutine mark_slaves(mesh, mark, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(out) :: mark(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, s

    mark = slave_marks(mesh%constraint, mesh%nnode)
    do i = 1, mesh%constraint%n
      s = mesh%constraint%slave(i)
      if (mark(s) == i) cycle
      call fail(error, DECK_ERROR, named(mesh, s)//' is the slave of two constraints', &
                mesh%constraint%place(mark(s)), 'a node hangs on others once')
      return
    end do
  end subroutine mark_slaves

  !> Append constraint i with masters that are free.
  subroutine close_one(mesh, mark, i, closed, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: mark(:), i
    type(constraint_t), intent(inout) :: closed
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: master(:)
    real(wp), allocatable :: c(:)
    integer :: j, s, depth

    associate (list => mesh%constraint)
      allocate (master, source=list%master(list%first(i):list%first(i + 1) - 1))
      allocate (c, source=list%c(list%first(i):list%first(i + 1) - 1))
      depth = 0
      do while (any(mark(master) > 0))
        depth = depth + 1
        if (depth > list%n .or. any(master == list%slave(i))) then
          call fail(error, DECK_ERROR, named(mesh, list%slave(i)) &
                    //' hangs on itself', list%place(i), 'masters of a slave lead back to it')
          return
        end if
        j = findloc(mark(master) > 0, .true., 1)
        s = mark(master(j))
        associate (next => list%master(list%first(s):list%first(s + 1) - 1), &
                   share => list%c(list%first(s):list%first(s + 1) - 1))
          master = [master(:j - 1), next, master(j + 1:)]
          c = [c(:j - 1), c(j)*share, c(j + 1:)]
        end associate
      end do
      call join_equal(master, c)
      call add_constraint(closed, list%slave(i), master, c, list%place(i))
    end associate
  end subroutine close_one

  !> Each master once.
  subroutine join_equal(master, c)
    integer, allocatable, intent(inout) :: master(:)
    real(wp), allocatable, intent(inout) :: c(:)
    integer :: i, j, n

    n = 0
    do i = 1, size(master)
      j = findloc(master(:n), master(i), 1)
      if (j == 0) then
        n = n + 1
        master(n) = master(i)
        c(n) = c(i)
      else
        c(j) = c(j) + c(i)
      end if
    end do
    master = master(:n)
    c = c(:n)
  end subroutine join_equal

  !> The last constraint holds for the positions as they are, and for any rigid motion.
  subroutine check_place(mesh, list, error)
    type(mesh_t), intent(in) :: mesh
    type(constraint_t), intent(in) :: list
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(3), extent, off
    integer :: j, s

    associate (from => list%first(list%n), to => list%first(list%n + 1) - 1)
      s = list%slave(list%n)
      if (.not. abs(sum(list%c(from:to)) - 1.0_wp) <= ROUNDING) then
        call fail(error, DECK_ERROR, 'the coefficients of '//named(mesh, s)//' sum up to ' &
                  //to_text(sum(list%c(from:to))), list%place(list%n), &
                  'they sum up to 1: a rigid motion of the masters moves the slave with them')
        return
      end if
      x = 0.0_wp
      extent = 0.0_wp
      do j = from, to
        x = x + list%c(j)*mesh%xr(:, list%master(j))
        extent = max(extent, norm2(mesh%xr(:, list%master(j)) - mesh%xr(:, s)))
      end do
      off = norm2(x - mesh%xr(:, s))
    end associate
    if (off <= ON_PLACE*extent) return
    call fail(error, DECK_ERROR, named(mesh, s)//' lies '//to_text(off) &
              //' off the place that its masters give it', list%place(list%n), &
              'a hanging node lies on the edge or face between its masters')
  end subroutine check_place

  !> Supports of slaves: their masters must be supported alike; the slave then follows.
  subroutine release_slaves(build, mesh, bc)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(inout) :: bc
    type(error_t), allocatable :: error
    logical, allocatable :: held(:, :)
    integer :: i, j, m

    if (mesh%constraint%n == 0) return
    held = bc%fixed /= 0
    do m = 1, size(bc%motion)
      do j = 1, size(bc%motion(m)%node)
        where (bc%motion(m)%acts) held(:, bc%motion(m)%node(j)) = .true.
      end do
    end do
    do i = 1, mesh%constraint%n
      call check_support(mesh, mesh%constraint, i, held, bc, error)
      if (allocated(error)) call build%errors%add(error)
      bc%fixed(:, mesh%constraint%slave(i)) = 0
      bc%value(:, mesh%constraint%slave(i)) = 0.0_wp
    end do
  end subroutine release_slaves

  !> What is prescribed of a slave is what its masters make of it.
  subroutine check_support(mesh, list, i, held, bc, error)
    type(mesh_t), intent(in) :: mesh
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: i
    logical, intent(in) :: held(:, :)
    type(boundary_t), intent(in) :: bc
    type(error_t), allocatable, intent(out) :: error
    integer :: d, j, m
    real(wp) :: value, largest

    associate (s => list%slave(i), from => list%first(i), to => list%first(i + 1) - 1)
      do d = 1, 3
        if (.not. held(d, s)) cycle
        value = 0.0_wp
        largest = abs(bc%value(d, s))
        do j = from, to
          m = list%master(j)
          if (.not. held(d, m)) then
            call fail(error, DECK_ERROR, named(mesh, s)//' is restrained, but it hangs on ' &
                      //named(mesh, m)//', which is free', list%place(i), &
                      'restrain all nodes on which it hangs; it follows them')
            return
          end if
          value = value + list%c(j)*bc%value(d, m)
          largest = max(largest, abs(bc%value(d, m)))
        end do
        if (abs(value - bc%value(d, s)) <= ROUNDING*largest) cycle
        call fail(error, DECK_ERROR, 'the displacement of '//named(mesh, s) &
                  //' differs from that of the nodes on which it hangs', list%place(i), &
                  'prescribe it at those nodes alone')
        return
      end do
    end associate
  end subroutine check_support

  !> A node as the user knows it: by its number in the file of its MESH, or in the deck.
  function named(mesh, n) result(name)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: n
    character(:), allocatable :: name
    integer :: b, i

    name = 'node '//to_text(n)
    do b = 1, size(mesh%body)
      if (.not. allocated(mesh%body(b)%label)) cycle
      i = find(mesh%body(b)%node, n)
      if (i == 0) cycle
      name = 'node '//to_text(mesh%body(b)%label(i))//' of '//quoted(mesh%body(b)%name)
      return
    end do
  end function named

end module input_constraint
