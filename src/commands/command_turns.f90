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
  use patch_spec, only: rotation
  use rigid_modes, only: find_bodies
  use tensor, only: cross, inv3
  implicit none
  private
  public :: watch_turns, watch_turned

  real(wp), parameter :: HALF_TURN = acos(-1.0_wp), DEGREE = HALF_TURN/180.0_wp
  real(wp), parameter :: TURNED = sqrt(2.0e-3_wp) !! angle that causes false strains of 1e-3 [rad]
  !> A body turns as a whole if the root mean square of its other displacements, relative to that of
  !! the rotation, is less than this. That of a cantilever under a force at its end is 0.19, and
  !! under a uniform load 0.14.
  real(wp), parameter :: NEARLY_RIGID = 0.1_wp
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
    call watch_neighbours(run)
  end subroutine watch_turned

  !> Warn if a block of elements with small strains turns as a whole, although MOVE rotates only
  !! bodies beside it.
  subroutine watch_neighbours(run)
    type(run_t), intent(inout) :: run
    real(wp) :: angle, largest
    integer :: b, i, motion

    motion = 0
    largest = 0.0_wp
    do i = 1, size(run%model%bc%motion)
      associate (m => run%model%bc%motion(i))
        if (.not. m%rotates) cycle
        angle = abs(m%angle*load_factor(run%state%factor, m%table))
        if (.not. angle > largest) cycle
        largest = angle
        motion = i
      end associate
    end do
    if (motion == 0) return
    do b = 1, size(run%model%mesh%block)
      associate (block => run%model%mesh%block(b))
        if (is_rigid(block) .or. block%nelem == 0) cycle
        associate (material => run%model%material(block%material))
          if (material%row%finite) cycle
          angle = rigid_turn(run%model%mesh%xr, run%state%u, block%conn)
          if (angle <= TURNED) cycle
          call warn('a body of material '//to_text(material%number)//' turns with its ' &
                    //'neighbours by '//to_text(angle/DEGREE, 3)//' degrees in step ' &
                    //to_text(run%state%step)//', but this material is for small strains ' &
                    //'(SMALl): without any deformation, the rotation causes strains of ' &
                    //to_text(1.0_wp - cos(angle), 2), run%model%bc%motion(motion)%place, &
                    'use NEOHook with FINIte, for which a rotation causes no stress')
          run%plan%strain_warned = .true.
          return
        end associate
      end associate
    end do
  end subroutine watch_neighbours

  !> Angle of the rotation of elements that move nearly as a rigid body; 0 if they deform [rad]. The
  !! rotation is the best fit to the displacements of their nodes.
  function rigid_turn(xr, u, conn) result(angle)
    real(wp), intent(in) :: xr(:, :)     !! (3, nnode) positions [L]
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) displacements [L]
    integer, intent(in) :: conn(:, :)    !! (nen, nelem)
    real(wp) :: angle
    integer, parameter :: NPASS = 20
    logical, allocatable :: used(:)
    integer, allocatable :: node(:)
    real(wp), allocatable :: from(:, :), to(:, :), y(:, :)
    real(wp) :: r(3, 3), inertia(3, 3), inverse(3, 3), moment(3), w(3), det, sine
    integer :: e, i, pass

    angle = 0.0_wp
    allocate (used(size(xr, 2)), source=.false.)
    do e = 1, size(conn, 2)
      used(conn(:, e)) = .true.
    end do
    node = pack([(i, i=1, size(used))], used)
    from = centred(xr(:, node))
    to = from + centred(u(:, node))
    r = rotation([0.0_wp, 0.0_wp, 1.0_wp], 0.0_wp)
    do pass = 1, NPASS
      y = matmul(r, from)
      inertia = -matmul(y, transpose(y))
      moment = 0.0_wp
      do i = 1, 3
        inertia(i, i) = inertia(i, i) + sum(y**2)
      end do
      do i = 1, size(node)
        moment = moment + cross(y(:, i), to(:, i))
      end do
      call inv3(inertia, inverse, det)
      if (.not. det > 0.0_wp) return
      w = matmul(inverse, moment)
      if (.not. norm2(w) > epsilon(1.0_wp)) exit
      r = matmul(rotation(w/norm2(w), norm2(w)), r)
    end do
    y = matmul(r, from)
    if (.not. norm2(to - y) < NEARLY_RIGID*norm2(y - from)) return
    sine = 0.5_wp*norm2([r(3, 2) - r(2, 3), r(1, 3) - r(3, 1), r(2, 1) - r(1, 2)])
    angle = atan2(sine, 0.5_wp*(r(1, 1) + r(2, 2) + r(3, 3) - 1.0_wp))
  end function rigid_turn

  !> Vectors minus their mean.
  pure function centred(x) result(d)
    real(wp), intent(in) :: x(:, :)      !! (3, n)
    real(wp) :: d(size(x, 1), size(x, 2))

    d = x - spread(sum(x, 2)/size(x, 2), 2, size(x, 2))
  end function centred

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
