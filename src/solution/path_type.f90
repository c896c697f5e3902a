!> How the path of equilibria is followed, and when the way is changed.
!!
!! Load control goes as far as it can. Where a small step fails, inertia carries the
!! model over the snap; when the motion has died down a step of load control is tried again, each
!! time after twice as many steps as the last time it failed.
module path_type
  use base_kinds, only: wp
  implicit none
  private
  public :: path_t, may_leave, leave_statics, is_quiet, begin_trial, end_trial, fail_trial

  integer, parameter, public :: PATH_OFF = 0, PATH_DYNAMIC = 1

  real(wp), parameter :: SMALL = 0.6_wp          !! a step of load control, relative to dt
  integer, parameter :: FIRST_WAIT = 4           !! steps with inertia before load control is tried
  integer, parameter :: LONGEST_WAIT = 64
  real(wp), parameter :: QUIET = 1.0e-3_wp       !! inertia, relative to the largest nodal force

  type :: path_t
    integer :: method = PATH_OFF       !! what follows where load control ends
    logical :: given = .false.         !! the deck chose it
    logical :: told = .false.          !! the user was warned that load control was left
    real(wp) :: density = -1.0_wp      !! the deck's [M/L^3]; negative: from the work done
    logical :: away = .false.          !! load control was left
    logical :: trial = .false.         !! the step under way tries it again
    integer :: wait = FIRST_WAIT       !! steps before the next trial
    integer :: steps = 0               !! since load control was left, or last tried
  end type path_t

contains

  !> A step of load control has failed: is it time for another way?
  pure logical function may_leave(path, size)
    type(path_t), intent(in) :: path
    real(wp), intent(in) :: size       !! of the step, relative to dt

    may_leave = path%method /= PATH_OFF .and. .not. path%away .and. size <= SMALL
  end function may_leave

  pure subroutine leave_statics(path)
    type(path_t), intent(inout) :: path

    path%away = .true.
    path%steps = 0
    path%wait = FIRST_WAIT
  end subroutine leave_statics

  !> A step with inertia is done: has the motion died down, and is a trial due?
  logical function is_quiet(path, inertia, largest)
    type(path_t), intent(inout) :: path
    real(wp), intent(in) :: inertia    !! largest force of inertia at a node [F]
    real(wp), intent(in) :: largest    !! largest nodal force [F]

    path%steps = path%steps + 1
    is_quiet = path%steps >= path%wait .and. inertia <= QUIET*largest
  end function is_quiet

  pure subroutine begin_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .true.
  end subroutine begin_trial

  !> It has converged: load control goes on.
  pure subroutine end_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .false.
    path%away = .false.
    path%wait = FIRST_WAIT
  end subroutine end_trial

  !> It has failed: on with inertia.
  pure subroutine fail_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .false.
    path%steps = 0
    path%wait = min(2*path%wait, LONGEST_WAIT)
  end subroutine fail_trial

end module path_type
