!> Constraints of hanging nodes: resolves chains of slaves, and checks positions and supports.
module input_constraint
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_sort, only: find, unique
  use base_text, only: to_text, quoted
  use boundary, only: boundary_t, motion_t, moved_dofs
  use constraint, only: constraint_t, add_constraint, follow, slave_marks
  use input_draft, only: draft_t
  use mesh, only: mesh_t
  implicit none
  private
  public :: close_constraints, release_slaves, named

  real(wp), parameter :: ON_PLACE = 1.0e-6_wp !! largest distance of a slave from the place that its
  !! masters give it, relative to its distance from the farthest master
  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! tolerance of a sum of coefficients or of a
  !! prescribed value

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
  !! slave is free in the same direction, or if the displacement that MOVE, DISPlacement and similar
  !! words prescribe at the slave does not follow from those of its masters.
  subroutine release_slaves(draft, mesh, bc)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(inout) :: bc
    type(error_t), allocatable :: error
    logical, allocatable :: held(:, :)
    real(wp), allocatable :: move(:, :, :) ! (3, nnode, ntable)
    integer, allocatable :: turn(:) ! (nnode)
    logical :: follows
    integer :: i, j, m, d

    if (mesh%constraint%n == 0) return
    held = bc%fixed /= 0 .or. moved_dofs(bc, mesh%nnode)
    call find_moves(bc, mesh%nnode, move, turn)
    do i = 1, mesh%constraint%n
      associate (list => mesh%constraint, s => mesh%constraint%slave(i))
        directions: do d = 1, 3
          if (.not. held(d, s)) cycle directions
          follows = .true.
          do j = list%first(i), list%first(i + 1) - 1
            m = list%master(j)
            if (.not. held(d, m)) then
              call fail(error, DECK_ERROR, named(mesh, s)//' is restrained, but its master ' &
                        //named(mesh, m)//' is free in direction '//to_text(d), list%place(i), &
                        'restrain all masters of this hanging node, which follows them')
              exit directions
            end if
            follows = follows .and. turn(m) == turn(s)
          end do
          associate (from => list%first(i), to => list%first(i + 1) - 1)
            do j = 1, size(move, 3)
              follows = follows .and. is_mean(move(d, s, j), move(d, list%master(from:to), j), &
                                              list%c(from:to))
            end do
          end associate
          if (follows) cycle directions
          call fail(error, DECK_ERROR, 'the displacement prescribed at '//named(mesh, s) &
                    //' does not follow from those of its masters', list%place(i), &
                    'prescribe displacements at the masters only')
          exit directions
        end do directions
        if (allocated(error)) then
          call draft%errors%add(error)
          deallocate (error)
        end if
        bc%fixed(:, s) = 0
        bc%value(:, s) = 0.0_wp
      end associate
    end do
  end subroutine release_slaves

  !> Find what moves each node: for each load table, the sum of its displacements and translations
  !! at factor 1, and a number that is the same for nodes with the same rotations.
  pure subroutine find_moves(bc, nnode, move, turn)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: nnode
    real(wp), allocatable, intent(out) :: move(:, :, :) !! (3, nnode, ntable) [L]
    integer, allocatable, intent(out) :: turn(:)        !! (nnode)
    integer, allocatable :: table(:), before(:), rotation(:)
    logical :: mark(nnode)
    integer :: i, j, k, n

    allocate (table, source=unique([0, bc%motion%table, pack(bc%table, bc%fixed /= 0 .and. &
                                                             abs(bc%value) > 0.0_wp)]))
    allocate (move(3, nnode, size(table)), source=0.0_wp)
    allocate (turn(nnode), source=0)
    allocate (before(0), rotation(0)) ! what each number stands for: a number and one more rotation
    do k = 1, size(table)
      where (bc%fixed /= 0 .and. bc%table == table(k)) move(:, :, k) = bc%value
    end do
    do i = 1, size(bc%motion)
      associate (motion => bc%motion(i))
        if (motion%rotates) then
          mark = .false.
          mark(motion%node) = .true.
          j = findloc([(is_same(motion, bc%motion(k)), k=1, i)], .true., 1)
          do n = 1, nnode
            if (.not. mark(n)) cycle
            k = findloc(before == turn(n) .and. rotation == j, .true., 1)
            if (k == 0) then
              before = [before, turn(n)]
              rotation = [rotation, j]
              k = size(before)
            end if
            turn(n) = k
          end do
        else
          k = findloc(table, motion%table, 1)
          do j = 1, size(motion%node)
            where (motion%acts) move(:, motion%node(j), k) = move(:, motion%node(j), k) &
                                                             + motion%vector
          end do
        end if
      end associate
    end do
  end subroutine find_moves

  !> Are two motions the same rotation, of any nodes?
  pure logical function is_same(one, other)
    type(motion_t), intent(in) :: one, other

    is_same = one%rotates .and. other%rotates .and. one%table == other%table .and. .not. &
              (any(abs(one%vector - other%vector) > 0.0_wp) .or. &
               any(abs(one%axis - other%axis) > 0.0_wp) .or. abs(one%angle - other%angle) > 0.0_wp)
  end function is_same

  !> Is a displacement the mean of those of the masters?
  pure logical function is_mean(slave, master, c)
    real(wp), intent(in) :: slave
    real(wp), intent(in) :: master(:)  !! (m)
    real(wp), intent(in) :: c(:)       !! (m) weights

    is_mean = abs(sum(c*master) - slave) <= ROUNDING*max(abs(slave), maxval(abs(master)))
  end function is_mean

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
