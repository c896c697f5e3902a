!> Reads a mesh or spline file as a stream of words; error messages give the line of the file.
module format_text
  use base_kinds, only: wp, i8
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_file, only: file_t, inspect, note_input, FILE_ABSENT, FILE_REGULAR
  use base_text, only: to_text, quoted
  use deck_number, only: whole_number
  implicit none
  private
  public :: text_t, load_text, fail_in_file, next_word, next_integer, next_integers, next_count, &
            next_real, next_reals, words_left, next_line

  integer(i8), parameter :: MAX_SIZE = 1000000000_i8 !! bytes
  character(*), parameter :: MARK = char(239)//char(187)//char(191) !! byte order mark

  !> A file in memory and a position in it.
  type :: text_t
    character(:), allocatable :: path
    character(:), allocatable :: all
    integer :: at = 1            !! next character; 0: error messages give no line
    type(place_t) :: place       !! the deck's record that names the file
    character :: comment = ' '   !! character that starts a comment; blank: none
  end type text_t

contains

  !> Read a whole file.
  subroutine load_text(path, place, text, error)
    character(*), intent(in) :: path
    type(place_t), intent(in) :: place
    type(text_t), intent(out) :: text
    type(error_t), allocatable, intent(out) :: error
    type(file_t) :: file
    integer :: unit, status

    call inspect(path, file)
    if (file%kind == FILE_ABSENT) then
      call fail(error, DECK_ERROR, 'cannot read '//quoted(path)//': '//file%reason, place)
    else if (file%kind /= FILE_REGULAR) then
      call fail(error, DECK_ERROR, 'cannot read '//quoted(path)//': it is not a regular file', &
                place)
    else if (file%size > MAX_SIZE) then
      call fail(error, DECK_ERROR, 'cannot read '//quoted(path)//': its size is ' &
                //to_text(file%size)//' bytes', place, 'the file must be a text file of at most ' &
                //'1 GB')
    end if
    if (allocated(error)) return
    call note_input(path)
    text%path = path
    text%place = place
    allocate (character(int(file%size)) :: text%all)
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
          action='read', iostat=status)
    if (status == 0 .and. file%size > 0) read (unit, iostat=status) text%all
    if (status /= 0) then
      call fail(error, DECK_ERROR, 'cannot read '//quoted(path), place, 'check its permissions')
      return
    end if
    close (unit)
    if (index(text%all, MARK) == 1) text%all = text%all(len(MARK) + 1:)
  end subroutine load_text

  !> Report an error at the current position.
  subroutine fail_in_file(text, message, error, hint)
    type(text_t), intent(in) :: text
    character(*), intent(in) :: message
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in), optional :: hint
    integer :: i, line

    if (text%at < 1) then
      call fail(error, DECK_ERROR, quoted(text%path)//': '//message, text%place, hint)
      return
    end if
    line = 1
    do i = 1, min(text%at - 1, len(text%all))
      if (text%all(i:i) == achar(10)) line = line + 1
    end do
    call fail(error, DECK_ERROR, quoted(text%path)//', line '//to_text(line)//': '//message, &
              text%place, hint)
  end subroutine fail_in_file

  !> Read the next word; it is empty at the end of the file.
  subroutine next_word(text, word)
    type(text_t), intent(inout) :: text
    character(:), allocatable, intent(out) :: word
    integer :: first

    do while (text%at <= len(text%all))
      if (text%comment /= ' ' .and. text%all(text%at:text%at) == text%comment) then
        do while (text%at <= len(text%all))
          if (text%all(text%at:text%at) == achar(10)) exit
          text%at = text%at + 1
        end do
      else if (.not. is_blank(text%all(text%at:text%at))) then
        exit
      else
        text%at = text%at + 1
      end if
    end do
    first = text%at
    do while (text%at <= len(text%all))
      if (is_blank(text%all(text%at:text%at))) exit
      if (text%comment /= ' ' .and. text%all(text%at:text%at) == text%comment) exit
      text%at = text%at + 1
    end do
    word = text%all(first:text%at - 1)
  end subroutine next_word

  !> Go to the next line that has a word, unless there are words left on this line.
  subroutine next_line(text)
    type(text_t), intent(inout) :: text
    integer :: length

    do while (words_left(text) == 0)
      length = index(text%all(text%at:), achar(10))
      if (length == 0) exit
      text%at = text%at + length
    end do
  end subroutine next_line

  !> Number of words between the current position and the end of its line.
  pure integer function words_left(text) result(n)
    type(text_t), intent(in) :: text
    integer :: i
    logical :: inside

    n = 0
    inside = .false.
    do i = text%at, len(text%all)
      if (text%all(i:i) == achar(10)) exit
      if (text%comment /= ' ' .and. text%all(i:i) == text%comment) exit
      if (.not. (inside .or. is_blank(text%all(i:i)))) n = n + 1
      inside = .not. is_blank(text%all(i:i))
    end do
  end function words_left

  pure logical function is_blank(c)
    character, intent(in) :: c

    is_blank = iachar(c) <= 32
  end function is_blank

  !> Read the next word as an integer; `what` describes the number in error messages.
  subroutine next_integer(text, what, n, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: what
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer :: status

    n = 0
    call next_word(text, word)
    status = 1
    if (len(word) > 0 .and. verify(word, '+-0123456789') == 0) read (word, *, iostat=status) n
    if (status /= 0) call fail_word(text, what, word, error)
  end subroutine next_integer

  !> Read the next word as a number of items. It must not exceed the size of the file in bytes,
  !! because each item takes at least one byte.
  subroutine next_count(text, what, n, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: what
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error

    call next_integer(text, what, n, error)
    if (allocated(error)) return
    if (n >= 0 .and. n <= len(text%all)) return
    call fail_in_file(text, 'expected '//what//' between 0 and '//to_text(len(text%all)) &
                      //' (the size of the file in bytes), found '//to_text(n), error)
  end subroutine next_count

  !> Read the next word as a real number.
  subroutine next_real(text, what, x, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: what
    real(wp), intent(out) :: x
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    logical :: ok

    call next_word(text, word)
    call whole_number(word, x, ok)
    if (.not. ok) call fail_word(text, what, word, error)
  end subroutine next_real

  !> Read the next words as real numbers.
  subroutine next_reals(text, what, x, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: what
    real(wp), intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(x)
      call next_real(text, what, x(i), error)
      if (allocated(error)) return
    end do
  end subroutine next_reals

  !> Read the next words as integers.
  subroutine next_integers(text, what, n, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: what
    integer, intent(out) :: n(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    n = 0
    do i = 1, size(n)
      call next_integer(text, what, n(i), error)
      if (allocated(error)) return
    end do
  end subroutine next_integers

  subroutine fail_word(text, what, word, error)
    type(text_t), intent(in) :: text
    character(*), intent(in) :: what, word
    type(error_t), allocatable, intent(out) :: error

    if (len(word) == 0) then
      call fail_in_file(text, 'expected '//what//', found the end of the file', error)
    else
      call fail_in_file(text, 'expected '//what//', found '//quoted(word), error)
    end if
  end subroutine fail_word

end module format_text
