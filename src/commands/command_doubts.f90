!> Warnings about commands that are probably not intended; they are issued when the whole deck has
!! been read.
module command_doubts
  use base_log, only: warn
  use command_type, only: run_t
  use table_use, only: warn_tables
  implicit none
  private
  public :: warn_commands

contains

  !> Warn about load tables without loads, and about commands that have no effect without others.
  subroutine warn_commands(run)
    type(run_t), intent(in) :: run

    call warn_tables(run)
    if (first(run, 'tran') == 0) then
      call warn_idle(run, 'mass', 'MASS has no effect without TRANsient', &
                     'TRANsient computes with inertia')
    else if (first(run, 'time') == 0) then
      call warn_idle(run, 'tran', 'TRANsient without TIME: a single step at t = 0 has no inertia', &
                     'put DT,,dt and a loop with TIME among the commands')
    end if
  end subroutine warn_commands

  !> Warn at the first command with a given name, if there is one.
  subroutine warn_idle(run, key, message, hint)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key
    character(*), intent(in) :: message, hint
    integer :: i

    i = first(run, key)
    if (i > 0) call warn(message, run%program%command(i)%record%place(1), hint)
  end subroutine warn_idle

  !> Position of the first command with a given name; 0: there is none.
  pure integer function first(run, key) result(i)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key

    do i = 1, size(run%program%command)
      if (run%program%command(i)%record%key(1) == key) return
    end do
    i = 0
  end function first

end module command_doubts
