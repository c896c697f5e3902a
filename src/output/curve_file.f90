!> Curves as tables of columns for gnuplot, numpy and pandas: `<stem>_<curve>.dat`.
!!
!! The first line is `# name name ...`. A row follows for each step (TPLOt may leave out steps); its
!! real numbers have 16 digits. Each row is handed to the operating system before the next step
!! begins.
module curve_file
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_error, only: error_t, fail, BUG
  use base_file, only: replace_file
  use base_kinds, only: wp
  use base_text, only: to_text
  use byte_file, only: byte_file_t, open_bytes, write_text, flush_bytes, close_bytes, write_whole
  implicit none
  private
  public :: curve_file_t, open_curve, write_row, close_curve, curve_names, find_row, first_step
  public :: cut_curve

  integer, parameter :: WIDTH = 25  !! width of a column of reals
  integer, parameter :: NARROW = 12 !! width of a column of integers
  integer, parameter :: FACTORS = NARROW + WIDTH !! characters of a line before the load factors

  type :: curve_file_t
    type(byte_file_t) :: file
    integer :: ncolumn = 0 !! columns after those for step, time, factors, iterations, cutbacks and
    !! converged
    integer :: nfactor = 0 !! number of load factors
  end type curve_file_t

contains

  !> Begin a table. If `keep` is present, the old table keeps its rows up to that step, with all of
  !! its load factors. If it has other quantities or belongs to another run, it gets the name
  !! `<path>.old` instead, and the new table begins without rows.
  subroutine open_curve(curve, path, columns, nfactor, error, keep, own, moved)
    type(curve_file_t), intent(out) :: curve
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:) !! names; trailing blanks are ignored
    integer, intent(in) :: nfactor         !! number of load factors
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep  !! last step whose row is kept
    logical, intent(in), optional :: own   !! does the old table belong to this run? Default: yes
    logical, intent(out), optional :: moved !! the old table has another name now
    character(:), allocatable :: old, text
    integer :: n

    curve%ncolumn = size(columns)
    curve%nfactor = nfactor
    if (present(moved)) moved = .false.
    text = header(columns, nfactor)
    if (present(keep)) then
      call read_table(path, columns, old, n)
      if (present(own)) n = merge(n, -1, own)
      if (n >= 0) then
        curve%nfactor = max(n, nfactor)
        text = header(columns, curve%nfactor)//rows_up_to(keep, old, n, curve%nfactor)
      else if (row_step(old) <= keep) then
        call replace_file(path, path//'.old', error)
        if (allocated(error)) return
        if (present(moved)) moved = .true.
      end if
    end if
    call write_whole(path, text, error)
    if (.not. allocated(error)) call open_bytes(curve%file, path, .true., error)
  end subroutine open_curve

  !> The first line of a table with its line end.
  pure function header(columns, nfactor) result(text)
    character(*), intent(in) :: columns(:)
    integer, intent(in) :: nfactor
    character(:), allocatable :: text
    character(len(columns) + 12), allocatable :: names(:)
    integer :: i

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
  end function header

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

  !> Find the row of a step in an old table with the same quantities. It is missing if there are
  !! only rows of other steps, at least one of which comes before it.
  subroutine find_row(path, columns, step, value, found, missing)
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:)
    integer, intent(in) :: step
    real(wp), intent(out) :: value(:) !! (size(columns) + 1) time and quantities
    logical, intent(out) :: found
    logical, intent(out) :: missing
    character(:), allocatable :: old
    integer :: first, last, n, status

    value = 0.0_wp
    found = .false.
    missing = .false.
    call read_table(path, columns, old, n)
    if (n < 0) return
    first = 1
    do
      last = first + index(old(first:), new_line('a')) - 1
      if (last < first) return
      if (row_step(old(first:last)) == step) then
        status = 1
        if (last - first >= FACTORS + (n + size(columns))*WIDTH) then
          read (old(first + NARROW:last - 1), *, iostat=status) value(1)
        end if
        if (status == 0 .and. size(columns) > 0) then
          read (old(last - size(columns)*WIDTH:last - 1), *, iostat=status) value(2:)
        end if
        found = status == 0
        missing = .not. found
        return
      end if
      missing = missing .or. row_step(old(first:last)) < step
      first = last + 1
    end do
  end subroutine find_row

  !> Step of the first row of an old table with any quantities; the largest integer without one.
  integer function first_step(path) result(step)
    character(*), intent(in) :: path
    character(:), allocatable :: rows
    character(1) :: none(0)
    integer :: n

    call read_table(path, none, rows, n)
    step = row_step(rows)
  end function first_step

  !> Remove the rows after step `keep`, and all lines behind the first of them, from the table of a
  !! curve with any quantities. `cut` tells whether there were such rows. Lines that do not begin
  !! with a step, such as comments, count as part of the rows before them.
  subroutine cut_curve(path, keep, cut, error)
    character(*), intent(in) :: path
    integer, intent(in) :: keep
    logical, intent(out) :: cut
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: old
    integer :: first, last, step

    cut = .false.
    call read_whole(path, old)
    first = index(old, new_line('a')) + 1
    do
      last = first + index(old(first:), new_line('a')) - 1
      if (last < first) return
      step = row_step(old(first:last))
      if (step > keep .and. step < huge(step)) exit
      first = last + 1
    end do
    cut = .true.
    call write_whole(path, old(:first - 1), error)
  end subroutine cut_curve

  !> Read the rows of an old table. Its number of load factors is -1 if its quantities are not these
  !! columns; without a file there are no rows.
  subroutine read_table(path, columns, rows, nfactor)
    character(*), intent(in) :: path
    character(*), intent(in) :: columns(:)
    character(:), allocatable, intent(out) :: rows !! lines with their line ends
    integer, intent(out) :: nfactor
    character(:), allocatable :: old
    integer :: first

    rows = ''
    nfactor = 0
    call read_whole(path, old)
    if (len(old) == 0) return
    first = index(old, new_line('a')) + 1
    rows = old(first:)
    do
      if (index(old(:first - 1), right('factor_'//to_text(nfactor + 1), WIDTH)) == 0) exit
      nfactor = nfactor + 1
    end do
    if (old(:first - 1) /= header(columns, nfactor)) nfactor = -1
  end subroutine read_table

  !> Read the text of an old table, which is empty if there is none.
  subroutine read_whole(path, text)
    character(*), intent(in) :: path
    character(:), allocatable, intent(out) :: text
    integer :: unit, status, n

    text = ''
    open (newunit=unit, file=path, action='read', status='old', access='stream', iostat=status)
    if (status /= 0) return
    inquire (unit, size=n)
    deallocate (text)
    allocate (character(n) :: text)
    read (unit, iostat=status) text
    close (unit)
    if (status /= 0) text = ''
  end subroutine read_whole

  !> Step of the first of some rows; the largest integer if there is none.
  pure integer function row_step(rows) result(step)
    character(*), intent(in) :: rows
    integer :: status

    status = 1
    if (len(rows) >= NARROW) read (rows(:NARROW), *, iostat=status) step
    if (status /= 0) step = huge(1)
  end function row_step

  !> Rows of an old table up to step `keep`. Factors of load tables that the old run did not have
  !! are 0 or, if it had none at all, 1. If the last line has no line end, it was cut off when a run
  !! was killed, and is dropped.
  function rows_up_to(keep, old, nold, nnew) result(text)
    integer, intent(in) :: keep
    character(*), intent(in) :: old
    integer, intent(in) :: nold, nnew !! numbers of load factors; nnew is not smaller
    character(:), allocatable :: text
    character(:), allocatable :: missing
    integer :: first, last, n, pass, same

    same = FACTORS + nold*WIDTH
    missing = repeat(number(merge(1.0_wp, 0.0_wp, nold == 0)), nnew - nold)
    text = ''
    do pass = 1, 2 ! measure, then copy
      first = 1
      n = 0
      do
        last = first + index(old(first:), new_line('a')) - 1
        if (last < first) exit
        if (row_step(old(first:last)) <= keep .and. last - first >= same) then
          if (pass == 2) then
            text(n + 1:n + same) = old(first:first + same - 1)
            text(n + same + 1:n + same + len(missing)) = missing
            text(n + same + len(missing) + 1:n + len(missing) + last - first + 1) &
              = old(first + same:last)
          end if
          n = n + len(missing) + last - first + 1
        end if
        first = last + 1
      end do
      if (pass == 1) text = repeat(' ', n)
    end do
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
