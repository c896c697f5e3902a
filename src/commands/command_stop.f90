!> Signals and the time limit: stop with a checkpoint.
module command_stop
  use base_kinds, only: wp
  use base_error, only: error_t, fail, STOPPED
  use base_system, only: stop_requested, wall_seconds
  use base_text, only: to_text
  use command_files, only: write_restart_point, close_files
  use command_loop, only: rewind_step
  use command_type, only: run_t
  implicit none
  private
  public :: stop_wanted, stop_run

contains

  !> A signal came, or the time is over.
  function stop_wanted(run) result(yes)
    type(run_t), intent(in) :: run
    logical :: yes

    yes = stop_requested()
    if (yes .or. run%time_limit <= 0.0_wp) return
    yes = wall_seconds() > run%time_limit
  end function stop_wanted

  !> Forget the step under way, write a checkpoint of the one before, and end with code 4.
  subroutine stop_run(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    if (run%plan%open) then
      call rewind_step(run)
      run%plan%retry = run%plan%cutbacks > 0 ! its cuts are counted on
    end if
    call write_restart_point(run, error)
    if (allocated(error)) return
    call close_files(run, error)
    if (allocated(error)) return
    call fail(error, STOPPED, 'stopped after step '//to_text(run%state%step) &
              //'; the checkpoint is of step '//to_text(run%restart_point%state%step), &
              hint='go on with --restart '//run%stem//'.restart.h5')
  end subroutine stop_run

end module command_stop
