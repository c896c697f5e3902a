!> Whole numbers among the fields of a command.
module command_number
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted
  use command_type, only: command_t
  implicit none
  private
  public :: whole_field

contains

  !> The i-th number of a command, which must be a whole one.
  subroutine whole_field(command, i, n, error)
    type(command_t), intent(in) :: command
    integer, intent(in) :: i
    integer, intent(out) :: n
    type(error_t), allocatable, intent(inout) :: error !! one that is there stays

    n = 0
    if (allocated(error)) return
    if (abs(command%x(i)) > huge(n) .or. abs(command%x(i) - anint(command%x(i))) > 0) then
      call fail(error, DECK_ERROR, quoted(command%record%text(i + 2)) &
                //' is not a whole number that can be counted to', command%record%place(i + 2))
    else
      n = nint(command%x(i))
    end if
  end subroutine whole_field

end module command_number
