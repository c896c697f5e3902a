!> Constraints of hanging nodes: resolves chains of slaves, and checks positions and supports.
module input_constraint
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_sort, only: find
  use base_text, only: to_text, quoted
  use boundary, only: boundary_t, moved_dofs
  use constraint, only: constraint_t, add_constraint, follow, slave_marks
  use input_draft, only: draft_t
  use mesh, only: mesh_t
  use model, only: model_t
  use prescribed, only: prescribed_values
  implicit none
  private
  public :: close_constraints, release_slaves, named

  real(wp), parameter :: ON_PLACE = 1.0e-6_wp !! largest distance of a slave from the place that its
  !! masters give it, relative to its distance from the farthest master
  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! tolerance of a sum of coefficients, or of a
  !! component of a prescribed displacement relative to the largest such component
  real(wp), parameter :: CANCELLED = 1.0e-13_wp !! tolerance of a component of a prescribed
  !! displacement relative to the largest such displacement

contains

  !> Keep the constraints of the slaves that elements use, express these slaves by masters that are
  !! not slaves, and move the slaves exactly to the positions that their masters give. A node may be
  !! the slave of only one constraint.
  subroutine close_constraints(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(inout) :: mesh
    type(constraint_t) :: closed
    type(error_t), allocatable :: error
    integer :: mark(mesh%nnode)
    integer :: i, s

    if (mesh%constraint%n == 0) return
    mark = slave_marks(mesh%constraint, mesh%nnode)
    do i = 1, mesh%constraint%n
      s = mesh%constraint%slave(i)
      if (mark(s) == i) cycle
      call fail(error, DECK_ERROR, named(mesh, s)//' is the slave of two constraints', &
                mesh%constraint%place(mark(s)), 'keep one of them')
      call draft%errors%add(error)
      return
    end do
    do i = 1, mesh%constraint%n
      if (.not. mesh%used(mesh%constraint%slave(i))) cycle
      call close_one(mesh, mark, i, closed, error)
      if (.not. allocated(error)) call check_place(mesh, closed, error)
      if (.not. allocated(error)) cycle
      call draft%errors%add(error)
      return
    end do
    mesh%constraint = closed
    call follow(closed, mesh%xr)
    do i = 1, closed%n
      mesh%used(closed%master(closed%first(i):closed%first(i + 1) - 1)) = .true.
    end do
  end subroutine close_constraints

  !> Append constraint i. Masters that are slaves themselves are replaced by their own masters, and
  !! equal masters are merged.
  subroutine close_one(mesh, mark, i, closed, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: mark(:) !! (nnode) constraint of each slave; 0: the node is not a slave
    integer, intent(in) :: i
    type(constraint_t), intent(inout) :: closed
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: master(:)
    real(wp), allocatable :: c(:)
    integer :: j, k, n, s, depth

    associate (list => mesh%constraint)
      allocate (master, source=list%master(list%first(i):list%first(i + 1) - 1))
      allocate (c, source=list%c(list%first(i):list%first(i + 1) - 1))
      depth = 0
      do while (any(mark(master) > 0))
        depth = depth + 1
        if (depth > list%n .or. any(master == list%slave(i))) then
          call fail(error, DECK_ERROR, named(mesh, list%slave(i))//' depends on itself through ' &
                    //'its masters', list%place(i), 'remove one of the constraints that form ' &
                    //'this cycle')
          return
        end if
        j = findloc(mark(master) > 0, .true., 1)
        s = mark(master(j))
        associate (next => list%master(list%first(s):list%first(s + 1) - 1), &
                   weight => list%c(list%first(s):list%first(s + 1) - 1))
          master = [master(:j - 1), next, master(j + 1:)]
          c = [c(:j - 1), c(j)*weight, c(j + 1:)]
        end associate
      end do
      n = 0
      do k = 1, size(master)
        j = findloc(master(:n), master(k), 1)
        if (j == 0) then
          n = n + 1
          master(n) = master(k)
          c(n) = c(k)
        else
          c(j) = c(j) + c(k)
        end if
      end do
      call add_constraint(closed, list%slave(i), master(:n), c(:n), list%place(i))
    end associate
  end subroutine close_one

  !> Fail unless the last constraint holds for the given positions and for any rigid motion.
  subroutine check_place(mesh, list, error)
    type(mesh_t), intent(in) :: mesh
    type(constraint_t), intent(in) :: list
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(3), extent, off
    integer :: j, s

    associate (from => list%first(list%n), to => list%first(list%n + 1) - 1)
      s = list%slave(list%n)
      if (.not. abs(sum(list%c(from:to)) - 1.0_wp) <= ROUNDING) then
        call fail(error, DECK_ERROR, 'the coefficients of '//named(mesh, s)//' sum to ' &
                  //to_text(sum(list%c(from:to))), list%place(list%n), &
                  'the sum must be 1, so that the slave follows a rigid motion of its masters')
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
              //' away from the position that its masters give it', list%place(list%n), &
              'a hanging node must lie on the edge or face between its masters')
  end subroutine check_place

  !> Remove the supports of slaves, which follow their masters. Fail if a master of a restrained
  !! slave is free in the same direction, or if the displacement that the deck prescribes at the
  !! slave (DISP, MOVE and other words; zero with FIX alone) does not follow from those of its
  !! masters at any load factors of the tables in use.
  subroutine release_slaves(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    logical, allocatable :: held(:, :)
    real(wp), allocatable :: up(:, :) ! (3, nnode) prescribed displacements [L]
    real(wp) :: u, largest, longest
    integer :: i, j, m, d

    if (model%mesh%constraint%n == 0) return
    held = model%bc%fixed /= 0 .or. moved_dofs(model%bc, model%mesh%nnode)
    allocate (up(3, model%mesh%nnode))
    call prescribed_values(model, unequal_factors(model%bc), up)
    do i = 1, model%mesh%constraint%n
      associate (mesh => model%mesh, list => model%mesh%constraint, &
                 s => model%mesh%constraint%slave(i))
        directions: do d = 1, 3
          if (.not. held(d, s)) cycle directions
          u = 0.0_wp
          largest = abs(up(d, s))
          longest = norm2(up(:, s))
          do j = list%first(i), list%first(i + 1) - 1
            m = list%master(j)
            if (.not. held(d, m)) then
              call fail(error, DECK_ERROR, named(mesh, s)//' is restrained, but its master ' &
                        //named(mesh, m)//' is free in direction '//to_text(d), list%place(i), &
                        'restrain all masters of this hanging node, which follows them')
              exit directions
            end if
            u = u + list%c(j)*up(d, m)
            largest = max(largest, abs(up(d, m)))
            longest = max(longest, norm2(up(:, m)))
          end do
          if (abs(u - up(d, s)) <= ROUNDING*largest + CANCELLED*longest) cycle directions
          call fail(error, DECK_ERROR, 'the displacement prescribed at '//named(mesh, s) &
                    //' does not follow from those of its masters in direction '//to_text(d), &
                    list%place(i), 'leave this node free, or give it the displacement that ' &
                    //'follows from its masters')
          exit directions
        end do directions
        if (allocated(error)) then
          call draft%errors%add(error)
          deallocate (error)
        end if
        model%bc%fixed(:, s) = 0
        model%bc%value(:, s) = 0.0_wp
      end associate
    end do
  end subroutine release_slaves

  !> Unequal factors for the load tables that nodes and motions follow. If they follow only table 1,
  !! it has the factor of the sum of all tables: the commands, which may define further tables, are
  !! not known here.
  pure function unequal_factors(bc) result(factor)
    type(boundary_t), intent(in) :: bc
    real(wp), allocatable :: factor(:)
    integer, parameter :: MOST = 1000 !! tables with higher numbers have the factor 0
    integer :: k, n

    n = 0
    if (size(bc%table) > 0) n = max(n, maxval(bc%table))
    if (size(bc%motion) > 0) n = max(n, maxval(bc%motion%table))
    factor = [(1.0_wp + 0.5_wp*sin(real(k, wp)), k=1, min(n, MOST))]
  end function unequal_factors

  !> Name of a node as the user knows it: its number in the file of its MESH, or in the deck.
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
