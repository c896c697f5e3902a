!> How the path of equilibria is continued where load control ends: methods and their changes.
!!
!! Load control goes as far as it can. Where a small step fails, the release of the bonds is
!! prescribed instead of the load; where that fails, the arc length of the step (LENGth: from the
!! start); or inertia carries the model over the snap. Load control is tried again after whole steps
!! of the deck in which the load has risen, or when the motion has died down; after each failed
!! trial the number of steps before the next one doubles.
!!
!! Under control of the release or of the arc length a step is constrained: a measure of it is
!! prescribed and its time is unknown (constrained_newton).
module continuation_type
  use base_kinds, only: wp
  use contact_forces, only: bonded_area, find_release
  use model, only: model_t, state_t
  implicit none
  private
  public :: continuation_t, may_leave, leave_load_control, is_quiet, is_forward, begin_trial, &
            end_trial, fail_trial, controls_release, adapt_release, cut_release, controls_arc, &
            begin_arc, adapt_arc, note_release, runs_back, opens_again, cut_arc
  public :: path_constraint_t, constrain_release, constrain_arc, find_measure, turns_away, &
            is_all_released

  !> What the deck allows where load control ends (OFF, DYNAmic, LOCAl, LENGth). PATH_RELEASE:
  !! control of the release where it is possible, else of the arc length, else inertia.
  integer, parameter, public :: PATH_OFF = 0, PATH_INERTIA = 1, PATH_RELEASE = 2, PATH_ARC = 3
  !> The method that the path is followed with.
  integer, parameter, public :: BY_LOAD = 0, BY_INERTIA = 1, BY_RELEASE = 2, BY_ARC = 3

  real(wp), parameter :: SMALL = 0.6_wp            !! step of load control, relative to dt
  integer, parameter :: FIRST_WAIT = 4             !! steps with inertia before the first trial
  integer, parameter :: FIRST_FORWARD = 2          !! whole steps of the deck before it
  integer, parameter :: LONGEST_WAIT = 64          !! steps
  real(wp), parameter :: QUIET = 1.0e-3_wp         !! inertia, relative to the largest nodal force
  real(wp), parameter :: LARGEST_RELEASE = 0.01_wp !! fraction of the bonds released by a step
  real(wp), parameter :: SMALLEST_RELEASE = 1.0e-5_wp
  real(wp), parameter :: SMALLEST_ARC = 1.0e-3_wp  !! arc length, relative to the first one
  real(wp), parameter :: LARGEST_ARC = 4.0_wp
  integer, parameter :: FEW = 5, MANY = 9          !! iterations: the next step grows, or shrinks

  !> Fraction of the bonds that counts as none.
  real(wp), parameter :: NO_BONDS = 1.0e-3_wp
  !> Least cosine between a step and the one before it.
  real(wp), parameter :: LEAST_COSINE = 0.5_wp

  type :: continuation_t
    integer :: method = PATH_OFF         !! what the deck allows
    logical :: given = .false.           !! the deck chose it
    integer :: active = BY_LOAD          !! method in use; BY_LOAD: load control has not ended
    logical :: trial = .false.           !! the step under way tries load control again
    integer :: steps = 0                 !! since load control ended, or was last tried
    integer :: wait = FIRST_WAIT         !! steps before the next trial
    integer :: next_wait = FIRST_WAIT    !! steps before the first trial of the next motion
    real(wp) :: density = -1.0_wp        !! of the deck [M/L^3]; negative: from the work done
    real(wp) :: release = 0.0_wp         !! fraction of the bonds that the next step releases
    real(wp) :: largest_release = LARGEST_RELEASE
    real(wp) :: length = 0.0_wp          !! arc length of the next step [L]
    real(wp) :: shortest = 0.0_wp, longest = 0.0_wp !! arc lengths [L]
    real(wp) :: multiple = LARGEST_ARC   !! longest arc length, relative to the first one
    real(wp) :: released = 0.0_wp        !! fraction of the bonds released under arc length control
    integer :: opening = 0               !! consecutive such steps that have released bonds
    integer :: patience = FIRST_WAIT     !! of them before the release is controlled again
    logical :: warned = .false.          !! the warning that load control ended was issued
    logical :: warned_energy = .false.   !! and the one that the motion has too much energy
  end type continuation_t

  !> A step whose measure is prescribed: the release of the bonds, or the arc length in the tangent
  !! plane (the component along the increment before).
  type :: path_constraint_t
    logical :: on = .false.
    real(wp) :: increment = 0.0_wp       !! of the measure in the step: [L^2], or [L]
    real(wp) :: goal = 0.0_wp            !! the measure at its end
    real(wp), allocatable :: direction(:, :) !! (3, nnode) of the last increment, of length one; not
    !! allocated: release
    real(wp) :: start = 0.0_wp           !! time at which it begins
    real(wp) :: limit = 0.0_wp           !! time that it may not pass
    logical :: at_limit = .false.        !! it ends there, with less of the measure than prescribed
  end type path_constraint_t

contains

  !> A step of load control has failed: may another method take over?
  pure logical function may_leave(path, size)
    type(continuation_t), intent(in) :: path
    real(wp), intent(in) :: size         !! of the step, relative to dt

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

  !> The step under way is controlled by the release of the bonds.
  pure logical function controls_release(path)
    type(continuation_t), intent(in) :: path

    controls_release = path%active == BY_RELEASE .and. .not. path%trial
  end function controls_release

  !> The step under way is controlled by its arc length.
  pure logical function controls_arc(path)
    type(continuation_t), intent(in) :: path

    controls_arc = path%active == BY_ARC .and. .not. path%trial
  end function controls_arc

  !> After a step with inertia: has the motion died down, and is a trial due?
  logical function is_quiet(path, inertia, largest)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: inertia      !! largest force of inertia at a node [F]
    real(wp), intent(in) :: largest      !! largest nodal force [F]

    path%steps = path%steps + 1
    is_quiet = path%steps >= path%wait .and. inertia <= QUIET*largest
  end function is_quiet

  !> After a constrained step: has the load risen for long enough?
  logical function is_forward(path, whole)
    type(continuation_t), intent(inout) :: path
    logical, intent(in) :: whole         !! it was a whole step of the deck

    path%steps = merge(path%steps + 1, 0, whole)
    is_forward = path%steps >= path%wait
  end function is_forward

  !> Release of the next step, after one that took this many iterations.
  pure subroutine adapt_release(path, iterations)
    type(continuation_t), intent(inout) :: path
    integer, intent(in) :: iterations

    if (iterations <= FEW) path%release = min(1.5_wp*path%release, path%largest_release)
    if (iterations >= MANY) path%release = max(0.7_wp*path%release, SMALLEST_RELEASE)
  end subroutine adapt_release

  !> The step has failed: half of its release. .false.: that is too little.
  logical function cut_release(path) result(possible)
    type(continuation_t), intent(inout) :: path

    path%release = 0.5_wp*path%release
    possible = path%release >= SMALLEST_RELEASE
  end function cut_release

  !> Arc length control begins with the length of the last step.
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

  !> Arc length of the next step, after one that took so many iterations and released such a
  !! fraction of the bonds.
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

  !> A step under arc length control has released such a fraction of the bonds.
  pure subroutine note_release(path, released)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: released

    path%opening = merge(path%opening + 1, 0, released > SMALLEST_RELEASE)
    path%released = path%released + released
  end subroutine note_release

  !> Bonds have closed by more than one step may open: the path is followed backwards.
  pure logical function runs_back(path)
    type(continuation_t), intent(in) :: path

    runs_back = path%released < -path%largest_release
  end function runs_back

  !> Bonds open along the path again: their release can be controlled.
  logical function opens_again(path, released)
    type(continuation_t), intent(inout) :: path
    real(wp), intent(in) :: released     !! fraction of the bonds, by the last step

    opens_again = path%opening >= path%patience
    if (.not. opens_again) return
    path%patience = min(2*path%patience, LONGEST_WAIT)
    call leave_load_control(path, BY_RELEASE)
    path%release = min(released, path%largest_release)
  end function opens_again

  !> The step under arc length control has failed: half of its length. .false.: that is too short.
  logical function cut_arc(path) result(possible)
    type(continuation_t), intent(inout) :: path

    path%length = 0.5_wp*path%length
    possible = path%length >= path%shortest
  end function cut_arc

  pure subroutine begin_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .true.
  end subroutine begin_trial

  !> The trial has converged: load control continues.
  pure subroutine end_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .false.
    path%active = BY_LOAD
  end subroutine end_trial

  !> The trial has failed: the previous method continues.
  pure subroutine fail_trial(path)
    type(continuation_t), intent(inout) :: path

    path%trial = .false.
    path%steps = 0
    path%wait = min(2*path%wait, LONGEST_WAIT)
  end subroutine fail_trial

  !> A step of given release begins: `state` is that of its start.
  subroutine constrain_release(constraint, model, state, increment, limit)
    type(path_constraint_t), intent(out) :: constraint
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: increment    !! [L^2]; at most half of what is left is released
    real(wp), intent(in) :: limit        !! time
    real(wp), allocatable :: slope(:, :)
    real(wp) :: left, part, released

    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u, released, slope)
    left = bonded_area(model, state) - released
    part = min(increment, 0.5_wp*left)
    constraint = path_constraint_t(on=.true., increment=part, goal=released + part, &
                                   start=state%time, limit=limit)
  end subroutine constrain_release

  !> A step of given arc length begins along the last increment; lengths are those of the vector of
  !! all displacements.
  subroutine constrain_arc(constraint, state, length, limit)
    type(path_constraint_t), intent(out) :: constraint
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: length       !! [L]
    real(wp), intent(in) :: limit        !! time

    constraint = path_constraint_t(on=.true., increment=length, goal=length, start=state%time, &
                                   limit=limit)
    constraint%direction = state%last_increment/norm2(state%last_increment)
  end subroutine constrain_arc

  !> The measure at the current displacements, and its derivative.
  subroutine find_measure(constraint, model, state, measure, slope)
    type(path_constraint_t), intent(in) :: constraint
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: measure     !! [L^2], or [L]
    real(wp), intent(out) :: slope(:, :) !! (3, nnode)

    if (allocated(constraint%direction)) then
      slope = constraint%direction
      measure = sum(slope*(state%u - state%u_step))
    else
      call find_release(model, state, state%u, measure, slope)
    end if
  end subroutine find_measure

  !> The increment under arc length control turns away from the one before it: to a later part of
  !! the path, or to another path.
  pure logical function turns_away(constraint, state) result(yes)
    type(path_constraint_t), intent(in) :: constraint
    type(state_t), intent(in) :: state

    yes = allocated(constraint%direction)
    if (yes) yes = sum(constraint%direction*(state%u - state%u_step)) &
                   < LEAST_COSINE*norm2(state%u - state%u_step)
  end function turns_away

  !> There were bonds, and none was left at the end of the last step.
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
