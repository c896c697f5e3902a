!> Curves as tables of columns for gnuplot, numpy and pandas: `<stem>_<curve>.dat`.
!!
!! The first line is `# name name ...`. A row follows for each step (TPLOt may leave out steps); its
!! real numbers have 16 digits. Each row is handed to the operating system before the next step
!! begins.
module curve_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_error, only: error_t, fail, BUG
  use base_kinds, only: wp
  use base_text, only: to_text
  use byte_file, only: byte_file_t, open_bytes, write_text, flush_bytes, close_bytes, write_whole
  implicit none
  private
  public :: curve_file_t, open_curve, write_row, close_curve, curve_names

  integer, parameter :: WIDTH = 25  !! width of a column of reals
  integer, parameter :: NARROW = 12 !! width of a column of integers

  type :: curve_file_t
    type(byte_file_t) :: file
    integer :: ncolumn = 0 !! columns after those for step, time, factors, iterations, cutbacks and
    !! converged
    integer :: nfactor = 0 !! number of load factors
  end type curve_file_t

contains

  !> Begin a table. If `keep` is present, the old table keeps its rows up to that step.
  subroutine open_curve(curve, path, columns, nfactor, error, keep)
    type(curve_file_t), intent(out) :: curve
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:) !! names; trailing blanks are ignored
    integer, intent(in) :: nfactor         !! number of load factors
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep  !! last step whose row is kept
    character(len(columns) + 12), allocatable :: names(:)
    character(:), allocatable :: text
    integer :: i

    curve%ncolumn = size(columns)
    curve%nfactor = nfactor
    text = '#'//right('step', NARROW - 1)//right('time', WIDTH)
    do i = 1, nfactor
      text = text//right('factor_'//to_text(i), WIDTH)
    end do
    text = text//right('iterations', NARROW)//right('cutbacks', NARROW)//right('converged', NARROW)
    allocate (names(size(columns)))
    call curve_names(columns, names)
    do i = 1, size(names)
      text = text//right(trim(names(i)), WIDTH)
    end do
    text = text//new_line('a')
    if (present(keep)) text = text//rows_up_to(path, keep)
    call write_whole(path, text, error)
    if (.not. allocated(error)) call open_bytes(curve%file, path, .true., error)
  end subroutine open_curve

  !> Write the row of a step that converged or was closed.
  subroutine write_row(curve, step, time, factor, iterations, cutbacks, converged, values, error)
    type(curve_file_t), intent(in) :: curve
    integer, intent(in) :: step
    real(wp), intent(in) :: time
    real(wp), intent(in) :: factor(:)    !! (nfactor)
    integer, intent(in) :: iterations, cutbacks
    logical, intent(in) :: converged
    real(wp), intent(in) :: values(:)    !! (ncolumn)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: line
    integer :: i

    if (.not. all(ieee_is_finite([time, factor, values]))) then
      call fail(error, BUG, 'a value for '''//curve%file%path//''' is not finite')
      return
    end if
    if (size(values) /= curve%ncolumn .or. size(factor) /= curve%nfactor) then
      call fail(error, BUG, 'expected '//to_text(curve%nfactor)//' factors and ' &
                //to_text(curve%ncolumn)//' values for '''//curve%file%path//''', found ' &
                //to_text(size(factor))//' and '//to_text(size(values)))
      return
    end if
    line = whole(step)//number(time)
    do i = 1, size(factor)
      line = line//number(factor(i))
    end do
    line = line//whole(iterations)//whole(cutbacks)//whole(merge(1, 0, converged))
    do i = 1, size(values)
      line = line//number(values(i))
    end do
    call write_text(curve%file, line//new_line('a'), error)
    if (.not. allocated(error)) call flush_bytes(curve%file, error)
  end subroutine write_row

  subroutine close_curve(curve, error)
    type(curve_file_t), intent(inout) :: curve
    type(error_t), allocatable, intent(out) :: error

    call close_bytes(curve%file, error)
  end subroutine close_curve

  !> Make the names of columns distinct: the second column with the same name gets the suffix _2,
  !! the third _3.
  pure subroutine curve_names(columns, names)
    character(*), intent(in) :: columns(:)
    ! allow(C072)
    character(*), intent(out) :: names(:)
    integer :: i, k

    do i = 1, size(columns)
      names(i) = columns(i)
      k = 1
      do while (any(names(:i - 1) == names(i)))
        k = k + 1
        names(i) = trim(columns(i))//'_'//to_text(k)
      end do
    end do
  end subroutine curve_names

  !> Rows of the old file up to step `keep`; empty if there is no file. If the last line has no line
  !! end, it was cut off when a run was killed, and is dropped.
  function rows_up_to(path, keep) result(text)
    character(*), intent(in) :: path
    integer, intent(in) :: keep
    character(:), allocatable :: text
    character(:), allocatable :: old
    integer :: unit, status, step, first, last, n

    text = ''
    open (newunit=unit, file=path, action='read', status='old', access='stream', iostat=status)
    if (status /= 0) return
    inquire (unit, size=n)
    allocate (character(n) :: old)
    read (unit, iostat=status) old
    close (unit)
    if (status /= 0) return
    first = 1
    n = 0 ! the rows to keep move to the front
    do
      last = first + index(old(first:), new_line('a')) - 1
      if (last < first) exit
      read (old(first:last - 1), *, iostat=status) step
      if (status == 0 .and. step <= keep) then
        old(n + 1:n + 1 + last - first) = old(first:last)
        n = n + 1 + last - first
      end if
      first = last + 1
    end do
    text = old(:n)
  end function rows_up_to

  !> Text aligned to the right of its column, with at least one blank before it.
  pure function right(text, width) result(field)
    character(*), intent(in) :: text
    integer, intent(in) :: width
    character(:), allocatable :: field

    field = repeat(' ', max(1, width - len(text)))//text
  end function right

  pure function number(x) result(field)
    real(wp), intent(in) :: x
    character(WIDTH) :: field

    write (field, '(es25.15e3)') x
  end function number

  pure function whole(i) result(field)
    integer, intent(in) :: i
    character(NARROW) :: field

    write (field, '(i12)') i
  end function whole

end module curve_file
