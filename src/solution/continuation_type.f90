!> Continuation of the equilibrium path when load control fails: the methods, and the changes
!! between them.
!!
!! Load control is used as long as it works. If even a small step fails, the release of the bonds is
!! prescribed instead of the load. If that fails too, the arc length of the step is prescribed
!! (LENGth does this at once), or the model snaps through with inertia. Load control is tried again
!! after some full steps of the deck in which the load has increased, or when the motion has died
!! down. After each failed trial, the number of steps before the next trial doubles, up to 64.
!!
!! Under control of the release or of the arc length, a step is constrained: a measure of the step
!! is prescribed, and the time at its end is unknown (constrained_newton).
module continuation_type
  use base_kinds, only: wp
  use constraint, only: fold_force
  use contact_release, only: bonded_area, find_release
  use model, only: model_t, state_t
  implicit none
  private
  public :: continuation_t, may_leave, leave_load_control, is_quiet, is_forward, begin_trial, &
            end_trial, fail_trial, controls_release, adapt_release, cut_release, controls_arc, &
            begin_arc, set_multiple, adapt_arc, note_release, runs_back, opens_again, cut_arc
  public :: path_constraint_t, constrain_release, constrain_arc, find_measure, turns_away, &
            is_all_released

  !> The methods that the deck allows when load control fails (OFF, DYNAmic, LOCAl, LENGth). With
  !! PATH_RELEASE the release is controlled if possible, otherwise the arc length; if neither is
  !! possible, inertia is used.
  integer, parameter, public :: PATH_OFF = 0, PATH_INERTIA = 1, PATH_RELEASE = 2, PATH_ARC = 3
  !> The method by which the path is followed.
  integer, parameter, public :: BY_LOAD = 0, BY_INERTIA = 1, BY_RELEASE = 2, BY_ARC = 3

  real(wp), parameter :: SMALL = 0.6_wp            !! load control ends when a step of at most this
  !! size, relative to dt, fails
  integer, parameter :: FIRST_WAIT = 4             !! steps with inertia before the first trial
  integer, parameter :: FIRST_FORWARD = 2          !! whole steps of the deck before the first trial
  integer, parameter :: LONGEST_WAIT = 64          !! largest number of steps before a trial
  real(wp), parameter :: QUIET = 1.0e-3_wp         !! force of inertia of a motion that has died
  !! down, relative to the largest nodal force
  real(wp), parameter :: LARGEST_RELEASE = 0.01_wp !! largest fraction of the bonds released by a
  !! step
  real(wp), parameter :: SMALLEST_RELEASE = 1.0e-5_wp
  real(wp), parameter :: SMALLEST_ARC = 1.0e-3_wp  !! shortest arc length, relative to the first one
  real(wp), parameter :: LARGEST_ARC = 4.0_wp
  integer, parameter :: FEW = 5, MANY = 9          !! the next step is longer after at most FEW
  !! iterations, and shorter after at least MANY

  !> A fraction of the bonds that is smaller than this counts as zero.
  real(wp), parameter :: NO_BONDS = 1.0e-3_wp
  !> Smallest cosine of the angle between a step and the one before it.
  real(wp), parameter :: LEAST_COSINE = 0.5_wp

  type :: continuation_t
    integer :: method = PATH_OFF         !! method that the deck allows
    logical :: given = .false.           !! the deck gives the method
    integer :: active = BY_LOAD          !! method in use; BY_LOAD: load control has not ended
    logical :: trial = .false.           !! the current step tries load control again
    integer :: steps = 0                 !! steps since load control failed or was last tried
    integer :: wait = FIRST_WAIT         !! steps before the next trial
    integer :: next_wait = FIRST_WAIT    !! steps before the first trial when inertia is next added
    real(wp) :: density = -1.0_wp !! density of the deck [M/L^3]; negative: from the work done
    real(wp) :: release = 0.0_wp         !! fraction of the bonds that the next step releases
    real(wp) :: largest_release = LARGEST_RELEASE
    real(wp) :: length = 0.0_wp          !! arc length of the next step [L]
    real(wp) :: shortest = 0.0_wp, longest = 0.0_wp !! limits of the arc length [L]
    real(wp) :: multiple = LARGEST_ARC   !! longest arc length, relative to the first one
    real(wp) :: released = 0.0_wp        !! fraction of the bonds released under arc length control
    integer :: opening = 0  !! consecutive steps with arc length control that released bonds
    integer :: patience = FIRST_WAIT !! number of such steps before the release is controlled again
    logical :: warned_length = .false.   !! a warning has said that the arc length has no effect
    logical :: warned_inertia = .false.  !! a warning has said that the run continues with inertia
    logical :: warned_energy = .false.   !! a warning has said that the kinetic energy is too large
  end type continuation_t

  !> A step with a prescribed measure: the release of the bonds, or the arc length, which is the
  !! component of the displacement increment (all nodes) along the previous one.
  type :: path_constraint_t
    logical :: on = .false.
    real(wp) :: increment = 0.0_wp       !! increment of the measure: [L^2] or [L]
    real(wp) :: goal = 0.0_wp            !! value of the measure at the end of the step
    real(wp), allocatable :: direction(:, :) !! (3, nnode) unit vector along the previous step; not
    !! allocated if the release is prescribed
    real(wp) :: start = 0.0_wp           !! time at which the step begins
    real(wp) :: limit = 0.0_wp           !! time that the step must not pass
    logical :: at_limit = .false. !! the step ends at the limit, before the measure reaches its goal
  end type path_constraint_t

contains

  !> May another method replace load control after a failed step?
  pure logical function may_leave(path, size)
    type(continuation_t), intent(in) :: path
    real(wp), intent(in) :: size         !! size of the step, relative to dt

    may_leave = path%method /= PATH_OFF .and. path%active == BY_LOAD .and. size <= SMALL
  end function may_leave

  pure subroutine leave_load_control(path, active)
    type(continuation_t), intent(inout) :: path
    integer, intent(in) :: active        !! BY_INERTIA, BY_RELEASE, BY_ARC

    path%active = active
    path%steps = 0
    path%wait = FIRST_FORWARD
    if (active == BY_INERTIA) then
      path%wait = path%next_wait
      path%next_wait = min(2*path%next_wait, LONGEST_WAIT)
    end if
    path%release = 0.5_wp*path%largest_release
  end subroutine leave_load_control

  !> Is the current step controlled by the release of the bonds?
  pure logical function controls_release(path)
    type(continuation_t), intent(in) :: path

    controls_release = path%active == BY_RELEASE .and. .not. path%trial
  end function controls_release

  !> Is the current step controlled by its arc length?
  pure logical function controls_arc(path)
    type(continuation_t), intent(in) :: path

    controls_arc = path%active == BY_ARC .and. .not. path%trial
  end function controls_arc

  !> After a step with inertia, has the motion died down, and is a trial due?
  logical function is_quiet(path, inertia, largest)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: inertia      !! largest force of inertia at a node [F]
    real(wp), intent(in) :: largest      !! largest nodal force [F]

    path%steps = path%steps + 1
    is_quiet = path%steps >= path%wait .and. inertia <= QUIET*largest
  end function is_quiet

  !> After a constrained step, has the load risen for long enough?
  logical function is_forward(path, whole)
    type(continuation_t), intent(inout) :: path
    logical, intent(in) :: whole         !! the step was a whole step of the deck

    path%steps = merge(path%steps + 1, 0, whole)
    is_forward = path%steps >= path%wait
  end function is_forward

  !> Set the release of the next step from the number of iterations of the previous one.
  pure subroutine adapt_release(path, iterations)
    type(continuation_t), intent(inout) :: path
    integer, intent(in) :: iterations

    if (iterations <= FEW) path%release = min(1.5_wp*path%release, path%largest_release)
    if (iterations >= MANY) path%release = max(0.7_wp*path%release, SMALLEST_RELEASE)
  end subroutine adapt_release

  !> Halve the release of a failed step. The result is false if the halved release is too small.
  logical function cut_release(path) result(possible)
    type(continuation_t), intent(inout) :: path

    path%release = 0.5_wp*path%release
    possible = path%release >= SMALLEST_RELEASE
  end function cut_release

  !> Begin arc length control with the length of the previous step.
  pure subroutine begin_arc(path, length)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: length       !! [L]

    call leave_load_control(path, BY_ARC)
    path%length = length
    path%shortest = SMALLEST_ARC*length
    path%longest = path%multiple*length
    path%released = 0.0_wp
    path%opening = 0
  end subroutine begin_arc

  !> Set the longest arc length as a multiple of the first one, which remains if arc length control
  !! acts already.
  pure subroutine set_multiple(path, multiple)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: multiple

    path%longest = multiple*path%shortest/SMALLEST_ARC
    if (path%active == BY_ARC) path%length = min(path%length, path%longest)
    path%multiple = multiple
  end subroutine set_multiple

  !> Set the arc length of the next step from the number of iterations of the previous one and the
  !! fraction of the bonds that it released.
  pure subroutine adapt_arc(path, iterations, released)
    type(continuation_t), intent(inout) :: path
    integer, intent(in) :: iterations
    real(wp), intent(in) :: released

    if (iterations <= FEW) path%length = min(1.5_wp*path%length, path%longest)
    if (iterations >= MANY) path%length = 0.7_wp*path%length
    if (abs(released) > path%largest_release) then
      path%length = path%length*path%largest_release/abs(released)
    end if
    path%length = max(path%length, path%shortest)
  end subroutine adapt_arc

  !> Record the fraction of the bonds that a step with arc length control has released.
  pure subroutine note_release(path, released)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: released

    path%opening = merge(path%opening + 1, 0, released > SMALLEST_RELEASE)
    path%released = path%released + released
  end subroutine note_release

  !> Is the path followed backwards? This is the case if more bonds have closed than a step may
  !! open.
  pure logical function runs_back(path)
    type(continuation_t), intent(in) :: path

    runs_back = path%released < -path%largest_release
  end function runs_back

  !> Do bonds open along the path again, so that their release can be controlled?
  logical function opens_again(path, released)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: released     !! fraction of the bonds released by the previous step

    opens_again = path%opening >= path%patience
    if (.not. opens_again) return
    path%patience = min(2*path%patience, LONGEST_WAIT)
    call leave_load_control(path, BY_RELEASE)
    path%release = min(released, path%largest_release)
  end function opens_again

  !> Halve the arc length of a failed step. The result is false if the halved length is too short.
  logical function cut_arc(path) result(possible)
    type(continuation_t), intent(inout) :: path

    path%length = 0.5_wp*path%length
    possible = path%length >= path%shortest
  end function cut_arc

  pure subroutine begin_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .true.
  end subroutine begin_trial

  !> Return to load control, because a trial has converged or the other method has ended.
  pure subroutine end_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .false.
    path%active = BY_LOAD
  end subroutine end_trial

  !> End a trial that has failed: the previous method continues.
  pure subroutine fail_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .false.
    path%steps = 0
    path%wait = min(2*path%wait, LONGEST_WAIT)
  end subroutine fail_trial

  !> Begin a step with a given release; `state` is the state at the start of the step.
  subroutine constrain_release(constraint, model, state, increment, limit)
    type(path_constraint_t), intent(out) :: constraint
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: increment    !! [L^2]; at most half of the remaining bonds are released
    real(wp), intent(in) :: limit        !! time that the step must not pass
    real(wp), allocatable :: slope(:, :)
    real(wp) :: left, part, released

    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u, released, slope)
    left = bonded_area(model, state) - released
    part = min(increment, 0.5_wp*left)
    constraint = path_constraint_t(on=.true., increment=part, goal=released + part, &
                                   start=state%time, limit=limit)
  end subroutine constrain_release

  !> Begin a step with a given arc length. It is measured along the increment of the previous step.
  subroutine constrain_arc(constraint, state, length, limit)
    type(path_constraint_t), intent(out) :: constraint
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: length       !! [L]
    real(wp), intent(in) :: limit        !! time that the step must not pass

    constraint = path_constraint_t(on=.true., increment=length, goal=length, start=state%time, &
                                   limit=limit)
    constraint%direction = state%last_increment/norm2(state%last_increment)
  end subroutine constrain_arc

  !> Find the measure at the current displacements, and its derivative.
  subroutine find_measure(constraint, model, state, measure, slope)
    type(path_constraint_t), intent(in) :: constraint
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: measure     !! [L^2] or [L]
    real(wp), intent(out) :: slope(:, :) !! (3, nnode)

    if (allocated(constraint%direction)) then
      slope = constraint%direction
      measure = sum(slope*(state%u - state%u_step))
      call fold_force(model%mesh%constraint, slope) ! slaves follow their masters
    else
      call find_release(model, state, state%u, measure, slope)
    end if
  end subroutine find_measure

  !> Does a step under arc length control deviate from the direction of the previous step? It then
  !! leads to a later part of the path or to another path.
  pure logical function turns_away(constraint, state) result(yes)
    type(path_constraint_t), intent(in) :: constraint
    type(state_t), intent(in) :: state

    yes = allocated(constraint%direction)
    if (yes) yes = sum(constraint%direction*(state%u - state%u_step)) &
                   < LEAST_COSINE*norm2(state%u - state%u_step)
  end function turns_away

  !> Did the model have bonds, all of which had been released by the end of the previous step?
  function is_all_released(model, state) result(yes)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical :: yes
    real(wp), allocatable :: slope(:, :)
    real(wp) :: area, released

    yes = .false.
    area = bonded_area(model, state)
    if (.not. area > 0.0_wp) return
    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u_step, released, slope)
    yes = released >= (1.0_wp - NO_BONDS)*area
  end function is_all_released

end module continuation_type
