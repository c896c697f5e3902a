!> Commands that change nothing here: FEAP's graphics and tuning.
module command_misc
  use base_error, only: error_t
  use base_log, only: log_line
  use command_type, only: run_t, command_t, command_row_t
  implicit none
  private
  public :: describe_note

contains

  !> A command of FEAP's that is accepted with one note.
  function describe_note(key, word) result(row)
    character(*), intent(in) :: key, word
    type(command_row_t) :: row

    row%key = key
    row%word = word
    row%usage = word//': accepted, does nothing here'
    row%nmax = 16
    row%run => run_note
  end function describe_note

  subroutine run_note(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (allocated(error) .or. run%dry) return
    if (run%noted(command%row)) return
    run%noted(command%row) = .true.
    call log_line("note: '"//command%record%text(1)//"' is accepted and does nothing here")
  end subroutine run_note

end module command_misc
