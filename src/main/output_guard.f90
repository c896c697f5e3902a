!> Refuses to write results over a file that the run has read or over a curve of another deck, or
!! under names that are too long.
module output_guard
  use base_error, only: error_t, fail, DECK_ERROR
  use base_file, only: base_name, file_t, inspect, input_of, FILE_REGULAR
  use base_text, only: quoted, to_text
  use command_type, only: run_t
  use curve_type, only: curve_t
  use json_text, only: json_member
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
      if (.not. allocated(error)) call check_curve(job%files%stem, job%model%curve(i), error)
      if (allocated(error)) return
    end do
  end subroutine check_outputs

  !> Check that a curve is not the file of another name: the curve `y_z` of `x` and the curve `z` of
  !! `x_y` have the same one. The reports of earlier runs name their curves.
  subroutine check_curve(stem, curve, error)
    character(*), intent(in) :: stem
    type(curve_t), intent(in) :: curve
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: other, path
    type(file_t) :: file
    integer :: first, i

    path = stem//'_'//curve%name
    call inspect(path//'.dat', file)
    if (file%kind /= FILE_REGULAR) return
    if (has_curve(stem//'.report.json', curve%name)) return
    first = len(path) - len(base_name(path)) + 1
    do i = first + 1, len(path) - 1
      if (path(i:i) /= '_' .or. i == len(stem) + 1) cycle
      other = path(:i - 1)
      if (.not. has_curve(other//'.report.json', path(i + 1:))) cycle
      call fail(error, DECK_ERROR, 'the curve '//quoted(curve%name)//' would overwrite ' &
                //quoted(path//'.dat')//', the curve '//quoted(path(i + 1:))//' of ' &
                //quoted(base_name(other)), curve%place, 'give the results another folder (-o) ' &
                //'or name (--name), or rename the curve')
      return
    end do
  end subroutine check_curve

  !> Does a report contain the last row of a curve?
  logical function has_curve(path, name)
    character(*), intent(in) :: path, name
    character(:), allocatable :: text
    integer :: unit, status, n

    has_curve = .false.
    open (newunit=unit, file=path, action='read', status='old', access='stream', iostat=status)
    if (status /= 0) return
    inquire (unit, size=n)
    allocate (character(n) :: text)
    read (unit, iostat=status) text
    close (unit)
    if (status == 0) has_curve = index(text, json_member(name, '{"step": ')) > 0
  end function has_curve

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
