!> The table of solution commands. A new command needs one new file, and its rows here.
module command_table
  use base_error, only: error_t
  use base_log, only: log_line
  use command_augment, only: augment_rows
  use command_load, only: load_rows
  use command_loop, only: loop_rows
  use command_output, only: output_rows
  use command_path, only: path_rows
  use command_print, only: print_rows
  use command_restart, only: restart_rows
  use command_solve, only: solve_rows
  use command_time, only: time_rows
  use command_tplot, only: tplot_rows
  use command_type, only: run_t, command_t, command_row_t, new_row
  implicit none
  private
  public :: load_commands

contains

  subroutine load_commands(table)
    type(command_row_t), allocatable, intent(out) :: table(:)

    table = [time_rows(), loop_rows(), solve_rows(), augment_rows(), load_rows(), print_rows(), &
             tplot_rows(), output_rows(), restart_rows(), path_rows(), note_rows()]
  end subroutine load_commands

  !> Commands of FEAP without effect, whose fields are not looked at.
  function note_rows() result(row)
    type(command_row_t) :: row(2)

    row(1) = new_row('OPTImize', 'OPTImize: accepted, but has no effect here', 16, run_note)
    row(2) = new_row('OPTS', 'OPTS: accepted, but has no effect here', 16, run_note)
    row(:)%reads = .true.
  end function note_rows

  !> State in the log that a command of FEAP has no effect here.
  subroutine run_note(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (run%program%dry) return
    if (run%program%noted(command%row)) return
    run%program%noted(command%row) = .true.
    call log_line("note: '"//command%record%text(1)//"' is accepted, but has no effect here")
  end subroutine run_note

end module command_table
