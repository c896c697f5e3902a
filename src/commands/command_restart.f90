!> RESTart: go on from the state in a checkpoint, with the commands of this deck.
module command_restart
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: log_line
  use base_text, only: to_text
  use bag, only: bag_t
  use command_type, only: run_t, command_t, command_row_t, new_row
  use load_curve, only: load_table_t
  use program_version, only: VERSION
  use restart_file, only: fingerprint_t, make_fingerprint, read_checkpoint
  use solution_state, only: set_factors
  use step_control, only: set_dt
  implicit none
  private
  public :: describe_rest

contains

  function describe_rest() result(row)
    type(command_row_t) :: row

    row = new_row('RESTart', 'RESTart [file]', 1, run_restart)
  end function describe_rest

  !> Displacements, history, time and step number come from the checkpoint; load tables stay those of
  !! this deck, and the next target of DT is counted from there. The mesh must be the same.
  subroutine run_restart(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(load_table_t), allocatable :: table(:)
    type(fingerprint_t) :: print
    type(bag_t) :: bag
    character(:), allocatable :: path

    if (run%dry) return
    if (run%plan%open .or. run%files_open) then
      call fail(error, DECK_ERROR, 'RESTart behind a step', command%record%place(1), 'put it before the first TIME or TANG')
      return
    end if
    path = run%stem//'.restart.h5'
    if (command%record%n > 1) path = command%record%text(2)
    call make_fingerprint(VERSION, run%deck_text, run%model, print)
    table = run%state%table
    call read_checkpoint(path, print, run%state, bag, error, any_deck=.true.)
    if (allocated(error)) return
    call move_alloc(table, run%state%table)
    call set_factors(run%state)
    if (run%control%dt > 0.0_8) call set_dt(run%control, run%state%time, run%control%dt)
    run%restarted = .true.
    run%kept = run%state%step
    call log_line('goes on after step '//to_text(run%state%step)//' of '//path)
  end subroutine run_restart

end module command_restart
