!> RESTart: continues from the state in a checkpoint, with the commands of this deck.
module command_restart
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: log_line
  use base_text, only: to_text, quoted
  use command_type, only: run_t, command_t, command_row_t, new_row
  use load_curve, only: load_table_t
  use model, only: state_t
  use named_values, only: named_values_t
  use program_version, only: VERSION
  use restart_file, only: fingerprint_t, make_fingerprint, read_checkpoint
  use solution_state, only: new_state, set_factors
  use step_control, only: set_dt
  implicit none
  private
  public :: restart_rows

contains

  function restart_rows() result(row)
    type(command_row_t) :: row(1)

    row(1) = new_row('RESTart', 'RESTart [file]', 1, run_restart)
  end function restart_rows

  !> Take displacements, history, time and step number from the checkpoint. The load tables remain
  !! those of this deck, and the next target of DT is counted from the time of the checkpoint. The
  !! mesh must be the same.
  subroutine run_restart(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(load_table_t), allocatable :: table(:)
    type(state_t) :: state
    integer :: i

    do i = 1, run%program%counter - 1
      associate (record => run%program%command(i)%record)
        if (all(record%key(1) /= ['time', 'tang', 'utan', 'form', 'plot', 'rest'])) cycle
        call fail(error, DECK_ERROR, 'RESTart after '//quoted(record%text(1)), &
                  command%record%place(1), 'put it before the first TIME or TANG')
      end associate
      return
    end do
    if (run%program%dry) then          ! report a wrong file before anything is written
      call new_state(run%model, state)
      call read_state(run, command, state, error)
      if (.not. allocated(error)) return
      if (error%code /= DECK_ERROR) deallocate (error) ! the real run reports this error
      return
    end if
    table = run%state%table
    call read_state(run, command, run%state, error)
    if (allocated(error)) return
    call move_alloc(table, run%state%table)
    call set_factors(run%state)
    associate (control => run%step%control)
      if (control%dt > 0) call set_dt(control, run%state%time, control%dt)
    end associate
    run%files%kept = run%state%step
    call log_line('restarted after step '//to_text(run%state%step)//' from '//path_of(run, command))
  end subroutine run_restart

  !> Read the state in the file that the command names.
  subroutine read_state(run, command, state, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print
    type(named_values_t) :: values

    call make_fingerprint(VERSION, '', run%model, print)
    call read_checkpoint(path_of(run, command), print, state, values, error, any_deck=.true.)
    if (.not. allocated(error)) return
    error%place = command%record%place(1)
    if (error%code == DECK_ERROR) error%hint = 'the file must come from the same mesh and version'
  end subroutine read_state

  function path_of(run, command) result(path)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    character(:), allocatable :: path

    path = run%files%stem//'.restart.h5'
    if (command%record%n > 1) path = command%record%text(2)
  end function path_of

end module command_restart
