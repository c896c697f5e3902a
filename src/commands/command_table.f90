!> The one list of solution commands. A new command is one file and one line here.
module command_table
  use base_error, only: error_t
  use base_log, only: log_line
  use command_augment, only: describe_augment
  use command_type, only: run_t, command_t, command_row_t, new_row
  implicit none
  private
  public :: load_commands

contains

  subroutine load_commands(table)
    type(command_row_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use command_time, only: describe_dt; table = [table, describe_dt()]; end block
    block; use command_time, only: describe_time; table = [table, describe_time()]; end block
    block; use command_time, only: describe_auto; table = [table, describe_auto()]; end block
    block; use command_loop, only: describe_loop; table = [table, describe_loop()]; end block
    block; use command_loop, only: describe_next; table = [table, describe_next()]; end block
    block; use command_solve, only: describe_tang; table = [table, describe_tang()]; end block
    block; use command_solve, only: describe_utan; table = [table, describe_utan()]; end block
    block; use command_solve, only: describe_form; table = [table, describe_form()]; end block
    block; use command_solve, only: describe_solv; table = [table, describe_solv()]; end block
    block; use command_solve, only: describe_tol; table = [table, describe_tol()]; end block
    block; use command_solve, only: describe_factor; table = [table, describe_factor()]; end block
    table = [table, describe_augment()]
    block; use command_load, only: describe_prop; table = [table, describe_prop()]; end block
    block; use command_load, only: describe_para; table = [table, describe_para()]; end block
    block; use command_print, only: describe_disp; table = [table, describe_disp()]; end block
    block; use command_print, only: describe_reac; table = [table, describe_reac()]; end block
    block; use command_print, only: describe_stre; table = [table, describe_stre()]; end block
    block; use command_print, only: describe_prin; table = [table, describe_prin()]; end block
    block; use command_print, only: describe_nopr; table = [table, describe_nopr()]; end block
    block; use command_tplot, only: describe_tplo; table = [table, describe_tplo()]; end block
    block; use command_output, only: describe_plot; table = [table, describe_plot()]; end block
    block; use command_output, only: describe_output; table = [table, describe_output()]; end block
    block; use command_output, only: describe_save; table = [table, describe_save()]; end block
    block; use command_restart, only: describe_rest; table = [table, describe_rest()]; end block
    block; use command_path, only: describe_arcl; table = [table, describe_arcl()]; end block
    block; use command_path, only: describe_tran; table = [table, describe_tran()]; end block
    block; use command_path, only: describe_mass; table = [table, describe_mass()]; end block
    table = [table, describe_note('OPTImize'), describe_note('OPTS')]
  end subroutine load_commands

  !> A command of FEAP that has no effect here.
  function describe_note(word) result(row)
    character(*), intent(in) :: word
    type(command_row_t) :: row

    row = new_row(word, word//': accepted, does nothing here', 16, run_note)
  end function describe_note

  subroutine run_note(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (run%program%dry) return
    if (run%program%noted(command%row)) return
    run%program%noted(command%row) = .true.
    call log_line("note: '"//command%record%text(1)//"' is accepted and does nothing here")
  end subroutine run_note

end module command_table
