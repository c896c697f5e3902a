!> Refuses to write results over a file that the run has read, or under names that are too long.
module output_guard
  use base_error, only: error_t, fail, DECK_ERROR
  use base_file, only: base_name, input_of
  use base_text, only: quoted, to_text
  use command_type, only: run_t
  implicit none
  private
  public :: check_outputs

  integer, parameter :: LONGEST = 255 !! most bytes in a file name on most file systems

contains

  !> Check the names under which the run may write, except those of the .vtu files, before it writes
  !! anything.
  subroutine check_outputs(job, error)
    type(run_t), intent(in) :: job
    type(error_t), allocatable, intent(out) :: error
    character(12), parameter :: ENDINGS(7) = ['.log        ', '.lock       ', '.out        ', &
                                              '.pvd        ', '.vtkhdf     ', '.restart.h5 ', &
                                              '.report.json']
    integer :: i

    do i = 1, size(ENDINGS)
      call check_name(job%files%stem//trim(ENDINGS(i)), error)
      if (allocated(error)) return
    end do
    do i = 1, size(job%model%curve)
      call check_name(job%files%stem//'_'//job%model%curve(i)%name//'.dat', error)
      if (allocated(error)) return
    end do
  end subroutine check_outputs

  !> Check the name of a result file. The names with the endings .part (the file until it is
  !! complete) and .probe (a file that finds the reason of a failure to write) are checked too.
  subroutine check_name(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name

    name = input_of(path, checkpoint=index(path, '.restart.h5') > 0)
    if (name == '') name = input_of(path//'.part')
    if (name == '') name = input_of(path//'.probe')
    if (name /= '') then
      call fail(error, DECK_ERROR, 'the results would overwrite '//quoted(name) &
                //', which this run reads', hint='give the results another folder (-o) or name ' &
                //'(--name)')
    else if (len(base_name(path)) + len('.probe') > LONGEST) then
      call fail(error, DECK_ERROR, 'the name of a result file would have ' &
                //to_text(len(base_name(path)) + len('.probe'))//' characters, more than ' &
                //to_text(LONGEST), hint='give the results a shorter name with --name')
    end if
  end subroutine check_name

end module output_guard
