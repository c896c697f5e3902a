!> A whole analysis on one page: read the deck, execute its commands, say how it went.
module run
  use base_error, only: error_t, fail, NO_SOLUTION, STOPPED, error_list_t
  use command_check, only: check_tables
  use command_close, only: close_step
  use command_files, only: close_files, set_restart_point, open_files
  use command_line, only: options_t
  use command_program, only: read_program, refresh
  use command_stop, only: stop_wanted, stop_run
  use command_type, only: run_t, command_t
  use deck_stream, only: open_deck, check_settings, deck_text
  use dof_map, only: number_equations
  use input_model, only: build_model
  use solution_state, only: new_state
  implicit none
  private
  public :: read_deck, execute

contains

  !> The deck, to the end: nothing is solved and no file is touched.
  subroutine read_deck(options, job, errors, error)
    type(options_t), intent(in) :: options
    type(run_t), intent(inout) :: job
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error

    call open_deck(job%deck, options%deck, options%settings, error)
    if (allocated(error)) return
    call build_model(job%deck, job%model, errors, error)
    if (allocated(error) .or. errors%count() > 0) return
    call number_equations(job%model%mesh, job%model%bc, job%model%eq, job%model%neq, job%model%ndof)
    call read_program(job, errors, error)
    if (allocated(error) .or. errors%count() > 0) return
    call check_settings(job%deck, error)
    if (allocated(error)) return
    call check_tables(job%model%bc, job%nfactor, error)
    if (allocated(error)) return
    job%deck_text = deck_text(job%deck)
    call new_state(job%model, job%state)
  end subroutine read_deck

  !> Command after command; a failed step moves the counter back to its TIME (command_loop,
  !! cut_back).
  subroutine execute(job, error)
    type(run_t), intent(inout) :: job
    type(error_t), allocatable, intent(out) :: error
    type(command_t) :: command
    logical :: closed

    if (job%restarted) call open_files(job, error) ! cuts back what a killed run has written
    if (allocated(error)) return
    call set_restart_point(job)
    do
      if (stop_wanted(job)) then
        call stop_run(job, error)
        return
      end if
      if (job%pc > size(job%command)) then
        call close_step(job, closed, error)
        if (allocated(error) .or. closed) exit
      else
        call refresh(job, error)
        if (allocated(error)) exit
        command = job%command(job%pc)
        call job%row(command%row)%run(job, command, error)
        if (allocated(error)) exit
      end if
      job%pc = job%pc + 1
    end do
    if (allocated(error)) return
    call close_files(job, error)
    if (allocated(error)) return
    if (job%failed_step) then
      call fail(error, NO_SOLUTION, 'some steps were closed before they converged', &
                hint='see the warnings in the log')
    end if
  end subroutine execute

end module run
