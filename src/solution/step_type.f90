!> The current step, as seen by the modules that control it.
module step_type
  use base_kinds, only: wp
  use continuation_type, only: continuation_t
  use newton_type, only: newton_t, pass_t
  use step_control, only: step_control_t
  implicit none
  private
  public :: step_t

  !> Outcome of a step.
  integer, parameter, public :: STEP_IDLE = 0      !! there was no step, or nothing was solved in it
  integer, parameter, public :: STEP_GOES_ON = 1   !! the iteration is not complete
  integer, parameter, public :: STEP_CONVERGED = 2 !! the iteration has passed the convergence test
  integer, parameter, public :: STEP_ACCEPTED = 3  !! the step is closed
  integer, parameter, public :: STEP_REWOUND = 4   !! the step failed, and the state at its start is
  !! restored

  !> Totals of the whole run.
  type :: step_totals_t
    integer :: iterations = 0
    integer :: cutbacks = 0
    integer :: negative_pivots = 0       !! negative pivots of the last converged state
    logical :: unconverged = .false.     !! a step was closed before it converged
    logical :: inertia = .false.         !! a step with inertia was accepted
    logical :: unstable = .false.        !! the warning about an unstable state was issued
    logical :: jumped = .false.          !! the warning about a jump was issued
    logical :: uneven = .false.          !! the warning about steps of changing length was issued
    logical :: lost_time = .false.       !! the warning about a TIME without a solve was issued
    logical :: untimed = .false. !! the warning about VISCous in a step without time was issued
    logical :: still = .false. !! the warning about a motion after a static step was issued
    real(wp) :: load = 0.0_wp            !! largest load or reaction, see force_rounding [F]
    real(wp) :: rounding = 0.0_wp        !! largest rounding error of an internal force [F]
    integer :: rounding_step = 0         !! the step with this error
  end type step_totals_t

  type :: step_t
    type(step_control_t) :: control      !! length of the step in time
    type(continuation_t) :: continuation !! the method that follows the path
    type(newton_t) :: newton
    type(pass_t) :: pass                 !! outcome of the last Newton iteration
    logical :: open = .false.            !! a step is in progress
    logical :: timed = .false.           !! a TIME began the step
    logical :: reloaded = .false.        !! its start is a checkpoint with other loads (RESTart)
    logical :: retry = .false.           !! the next step repeats a step that was cut back
    logical :: solved = .false.          !! at least one system was solved in the step
    logical :: searches = .false.        !! the last solve had the line search of the deck
    integer :: cutbacks = 0              !! cut-backs of this step, except changes of method
    logical :: needs_secant = .false.    !! some step failed at every size without secants
    logical :: secant = .false.          !! the next attempt of the step has secants of friction
    integer :: secant_attempts = 0       !! attempts of the step with secants of friction
    logical :: exhausted = .false.       !! the step has been cut to dtmin without secants
    integer :: start_step = 0            !! number and time of the state at the start of the step
    real(wp) :: start_time = 0.0_wp
    real(wp) :: loop_end = 0.0_wp        !! time of the last target of the loop over time
    real(wp) :: next_dt = 0.0_wp         !! DT given in the step, for the targets after it; 0: none
    integer :: start_iterations = 0      !! total number of iterations when the step began
    logical :: start_held = .false.      !! `active` of the stabilisation when the step began
    logical :: start_fell = .false.      !! `fell` of the stabilisation when the step began
    type(step_totals_t) :: total
  end type step_t

end module step_type
