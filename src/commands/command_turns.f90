!> Warnings about rotations that MOVE prescribes: too large for a single step, or for small strains.
!!
!! Displacements depend only on the positions at the end of a step, so that a full turn moves
!! nothing, and two faces of a body that turn by more than half a turn relative to each other twist
!! it the shorter way.
module command_turns
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_type, only: run_t
  use load_curve, only: load_factor, table_factor
  use mesh, only: is_rigid
  use rigid_modes, only: find_bodies
  implicit none
  private
  public :: watch_turns, watch_turned

  real(wp), parameter :: HALF_TURN = acos(-1.0_wp), DEGREE = HALF_TURN/180.0_wp
  real(wp), parameter :: TURNED = sqrt(2.0e-3_wp) !! angle that causes false strains of 1e-3 [rad]
  real(wp), parameter :: LIMIT = HALF_TURN*(1.0_wp - 1.0e-9_wp)

contains

  !> Warn about half a turn or more of a node, or of two prescribed nodes of a body relative to each
  !! other, in the step that was closed. The rotation vectors of several MOVE of a node are added,
  !! which is exact for parallel axes.
  subroutine watch_turns(run)
    type(run_t), intent(inout) :: run
    real(wp), allocatable :: turn(:, :)  ! (3, nnode) rotation vectors [rad]
    integer, allocatable :: last(:)      ! (nnode) the last motion that rotates the node; 0: none
    real(wp) :: largest
    integer :: n, node

    if (.not. any(run%model%bc%motion%rotates)) return
    call add_turns(run, turn, last)
    node = 0
    largest = 0.0_wp
    do n = 1, size(last)
      if (last(n) == 0 .or. .not. norm2(turn(:, n)) > largest) cycle
      largest = norm2(turn(:, n))
      node = n
    end do
    if (largest >= LIMIT) then
      call warn_turn(run, 'MOVE turns by ', largest, '', last(node))
      return
    end if
    call find_twist(run, turn, last, largest, node)
    if (largest >= LIMIT) call warn_turn(run, 'MOVE turns two parts of a body by ', largest, &
                                         ' relative to each other', last(node))
  end subroutine watch_turns

  !> The rotation of each node in the step.
  subroutine add_turns(run, turn, last)
    type(run_t), intent(in) :: run
    real(wp), allocatable, intent(out) :: turn(:, :) !! (3, nnode) [rad]
    integer, allocatable, intent(out) :: last(:) !! (nnode)
    real(wp) :: before(size(run%state%table)), factor, start
    integer :: i

    allocate (turn(3, run%model%mesh%nnode), source=0.0_wp)
    allocate (last(run%model%mesh%nnode), source=0)
    associate (state => run%state)
      do i = 1, size(before)
        before(i) = 0.0_wp
        if (state%dt > 0.0_wp) before(i) = table_factor(state%table(i), run%plan%closed_at)
      end do
      do i = 1, size(run%model%bc%motion)
        associate (motion => run%model%bc%motion(i))
          if (.not. motion%rotates) cycle
          factor = load_factor(state%factor, motion%table)
          start = load_factor(before, motion%table)
          if (size(before) == 0) start = merge(0.0_wp, factor, state%step == 1)
          turn(:, motion%node) = turn(:, motion%node) &
                                 + spread(motion%angle*(factor - start)*motion%axis, 2, &
                                          size(motion%node))
          last(motion%node) = i
        end associate
      end do
    end associate
  end subroutine add_turns

  !> The largest turn of two prescribed nodes of a body relative to each other. The turns of a body
  !! have few values, and each node is compared with these.
  subroutine find_twist(run, turn, last, largest, node)
    type(run_t), intent(in) :: run
    real(wp), intent(in) :: turn(:, :)   !! (3, nnode) [rad]
    integer, intent(in) :: last(:)       !! (nnode)
    real(wp), intent(out) :: largest     !! [rad]
    integer, intent(out) :: node         !! one of the two nodes, which a MOVE rotates; 0: none
    integer, allocatable :: body(:), other(:) ! `other`: a node of each value of the turn
    integer :: b, i, n

    largest = 0.0_wp
    node = 0
    call find_bodies(run%model%mesh, body)
    do b = 1, maxval(body)
      if (.not. any(last > 0 .and. body == b)) cycle
      allocate (other(0))
      do n = 1, size(last)
        if (body(n) /= b .or. all(run%model%eq(:, n) /= 0)) cycle
        if (any([(all(abs(turn(:, n) - turn(:, other(i))) <= 0.0_wp), i=1, size(other))])) cycle
        do i = 1, size(other)
          if (.not. norm2(turn(:, n) - turn(:, other(i))) > largest) cycle
          largest = norm2(turn(:, n) - turn(:, other(i)))
          node = merge(n, other(i), last(n) > 0)
        end do
        other = [other, n]
      end do
      deallocate (other)
    end do
  end subroutine find_twist

  !> Warn if MOVE turns a body of small strains so far that the rotation itself causes stresses.
  subroutine watch_turned(run)
    type(run_t), intent(inout) :: run
    logical :: moves(run%model%mesh%nnode) ! nodes of a motion
    real(wp) :: angle
    integer :: b, e, i

    do i = 1, size(run%model%bc%motion)
      associate (motion => run%model%bc%motion(i))
        if (.not. motion%rotates) cycle
        angle = abs(motion%angle*load_factor(run%state%factor, motion%table))
        if (angle <= TURNED) cycle
        moves = .false.
        moves(motion%node) = .true.
        do b = 1, size(run%model%mesh%block)
          associate (block => run%model%mesh%block(b))
            if (is_rigid(block)) cycle
            associate (material => run%model%material(block%material))
              if (material%row%finite) cycle
              if (.not. any([(any(moves(block%conn(:, e))), e=1, block%nelem)])) cycle
              call warn('MOVE turns a body of material '//to_text(material%number)//' by ' &
                        //to_text(angle/DEGREE, 3)//' degrees in step ' &
                        //to_text(run%state%step)//', but this material is for small strains ' &
                        //'(SMALl): without any deformation, the rotation causes strains of ' &
                        //to_text(1.0_wp - cos(angle), 2), motion%place, 'use NEOHook with ' &
                        //'FINIte, for which a rotation causes no stress')
              run%plan%strain_warned = .true.
              return
            end associate
          end associate
        end do
      end associate
    end do
  end subroutine watch_turned

  subroutine warn_turn(run, what, angle, suffix, motion)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: what, suffix
    real(wp), intent(in) :: angle        !! [rad]
    integer, intent(in) :: motion

    call warn(what//to_text(angle/DEGREE, 5)//' degrees'//suffix//' in step ' &
              //to_text(run%state%step), run%model%bc%motion(motion)%place, 'only the positions ' &
              //'at the ends of steps matter, not the way between them: turn by less than 180 ' &
              //'degrees in each step, preferably by about 10')
    run%plan%turn_warned = .true.
  end subroutine warn_turn

end module command_turns
