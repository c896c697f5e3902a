!> Tables of columns for gnuplot, numpy and pandas: `<stem>_<curve>.dat`.
!!
!! One line `# name name ...`, then a row a step; numbers with 16 digits. Each row is with the
!! operating system before the next step begins.
module curve_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_error, only: error_t, fail, BUG
  use byte_file, only: byte_file_t, open_bytes, write_text, flush_bytes, close_bytes, write_whole
  implicit none
  private
  public :: curve_file_t, open_curve, write_row, close_curve, curve_names

  integer, parameter :: WIDTH = 25  !! of a column of reals
  integer, parameter :: NARROW = 12 !! of a column of integers

  type :: curve_file_t
    type(byte_file_t) :: file
    integer :: ncolumn = 0 !! columns after step, time, factors, iterations, cutbacks, converged
    integer :: nfactor = 0
  end type curve_file_t

contains

  !> Begin a table, or go on with the rows of steps up to `keep` where it is present.
  subroutine open_curve(curve, path, columns, nfactor, error, keep)
    type(curve_file_t), intent(out) :: curve
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:) !! blanks at the end do not count
    integer, intent(in) :: nfactor         !! load factors
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep  !! last step that stays
    character(:), allocatable :: text

    curve%ncolumn = size(columns)
    curve%nfactor = nfactor
    text = header(columns, nfactor)//new_line('a')
    if (present(keep)) text = text//rows_up_to(path, keep)
    call write_whole(path, text, error)
    if (.not. allocated(error)) call open_bytes(curve%file, path, .true., error)
  end subroutine open_curve

  !> One converged or closed step.
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
      call fail(error, BUG, 'a value for '''//curve%file%path//''' is not a number')
      return
    end if
    if (size(values) /= curve%ncolumn .or. size(factor) /= curve%nfactor) then
      call fail(error, BUG, 'a row for '''//curve%file%path//''' has the wrong length')
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

  !> Names of columns made distinct: the second of a name ends with _2, the third with _3.
  pure subroutine curve_names(columns, names)
    character(*), intent(in) :: columns(:)
    ! allow(C072)
    character(*), intent(out) :: names(:)
    character(12) :: suffix
    integer :: i, k

    do i = 1, size(columns)
      names(i) = columns(i)
      k = 1
      do while (any(names(:i - 1) == names(i)))
        k = k + 1
        write (suffix, '("_", i0)') k
        names(i) = trim(columns(i))//suffix
      end do
    end do
  end subroutine curve_names

  function header(columns, nfactor) result(line)
    character(*), intent(in) :: columns(:)
    integer, intent(in) :: nfactor
    character(:), allocatable :: line
    character(len(columns) + 12), allocatable :: names(:)
    character(12) :: digits
    integer :: i

    line = '#'//right('step', NARROW - 1)//right('time', WIDTH)
    do i = 1, nfactor
      write (digits, '(i0)') i
      line = line//right('factor_'//trim(digits), WIDTH)
    end do
    line = line//right('iterations', NARROW)//right('cutbacks', NARROW)// &
           right('converged', NARROW)
    allocate (names(size(columns)))
    call curve_names(columns, names)
    do i = 1, size(names)
      line = line//right(trim(names(i)), WIDTH)
    end do
  end function header

  !> Rows of the file that belong to steps up to `keep`; none where there is no file. A last line
  !! without its end was cut by a kill: it is dropped.
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
    n = 0 ! rows that stay move to the front
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

  !> Text at the right of its column, with a blank before it however long it is.
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
