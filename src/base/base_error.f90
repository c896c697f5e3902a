!> Errors as values: what went wrong, where in the deck, and what to do about it.
module base_error
  use base_text, only: to_text
  implicit none
  private
  public :: place_t, error_t, fail, render, render_note, error_list_t

  integer, parameter, public :: DECK_ERROR = 1    !! the deck is wrong; nothing is written
  integer, parameter, public :: NO_SOLUTION = 2   !! the solution failed
  integer, parameter, public :: SYSTEM_ERROR = 3  !! library, memory or disk
  integer, parameter, public :: STOPPED = 4       !! stopped with a checkpoint
  integer, parameter, public :: BUG = 70          !! a mistake in the program

  integer, parameter :: WINDOW = 160 !! a line with more bytes than this is shown only in part

  !> A place in a deck.
  type :: place_t
    character(:), allocatable :: file !! path as the user wrote it; not allocated: no place
    character(:), allocatable :: text !! the line as it is in the file
    integer :: line = 0   !! line number, from 1
    integer :: column = 0 !! first character (byte of the text), from 1; 0: the whole line
    integer :: width = 0  !! bytes to underline
  end type place_t

  !> An error in the deck, or a failure of the program.
  type :: error_t
    integer :: code = 0                   !! exit code of the program
    character(:), allocatable :: message  !! one sentence, lower case, no full stop
    character(:), allocatable :: hint     !! what to do; not allocated: no hint
    type(place_t) :: place
  end type error_t

  integer, parameter :: MOST = 10 !! errors that are kept and shown; any others are only counted

  !> Independent errors of one deck.
  type :: error_list_t
    private
    type(error_t) :: kept(MOST)
    integer :: n = 0
  contains
    procedure :: add => add_error
    procedure :: count => count_errors
    procedure :: code => exit_code
    procedure :: render => render_list
  end type error_list_t

contains

  !> Make an error.
  subroutine fail(error, code, message, place, hint)
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in) :: code
    character(*), intent(in) :: message
    type(place_t), intent(in), optional :: place
    character(*), intent(in), optional :: hint

    allocate (error)
    error%code = code
    error%message = message
    if (present(hint)) error%hint = hint
    if (present(place)) error%place = place
  end subroutine fail

  !> Text of an error as the user sees it, with no line end after the last line.
  pure function render(error) result(text)
    type(error_t), intent(in) :: error
    character(:), allocatable :: text

    text = head('error', error%message, error%place)
    if (allocated(error%hint)) text = text//new_line('a')//'hint: '//visible(error%hint)
  end function render

  !> Text of a warning or a note in the form of an error message; `kind` replaces the word `error`.
  pure function render_note(kind, message, place, hint) result(text)
    character(*), intent(in) :: kind, message
    type(place_t), intent(in), optional :: place
    character(*), intent(in), optional :: hint
    character(:), allocatable :: text

    if (present(place)) then
      text = head(kind, message, place)
    else
      text = kind//': '//visible(message)
    end if
    if (present(hint)) text = text//new_line('a')//'hint: '//visible(hint)
  end function render_note

  !> A message without its hint: the place and the text, the line of the deck, and a marker (^~~~)
  !! under the place.
  pure function head(kind, message, place) result(text)
    character(*), intent(in) :: kind, message
    type(place_t), intent(in) :: place
    character(:), allocatable :: text, source, number
    integer :: margin, column, nchar, first, last, i, n

    text = kind//': '//visible(message)
    if (.not. allocated(place%file)) return
    if (place%line <= 0) then
      text = place%file//': '//text
      return
    end if
    number = to_text(place%line)
    if (.not. allocated(place%text)) then
      text = place%file//':'//number//': '//text
      return
    end if
    margin = max(5 - len(number), 0)
    n = len(place%text)
    column = min(place%column, n + 1)
    source = place%text
    if (n > WINDOW) then ! only the part around the place is shown
      first = max(1, column - WINDOW/2)
      last = min(n, first + WINDOW - 1)
      source = place%text(first:last)
      column = merge(column - first + 1, 0, column > 0)
      if (last < n) source = source//' ...'
      if (first > 1) then
        source = '... '//source
        if (column > 0) column = column + 4
      end if
    end if
    source = visible(source)
    nchar = 0
    if (place%column > 0) nchar = characters(place%text(:min(place%column - 1, len(place%text)))) &
                                  + max(place%column - 1 - len(place%text), 0) + 1
    if (place%column > 0) then
      text = place%file//':'//number//':'//to_text(nchar)//': '//text
    else
      text = place%file//':'//number//': '//text
    end if
    text = text//new_line('a')//repeat(' ', margin)//number//' | '//source
    if (place%column <= 0) return
    text = text//new_line('a')//repeat(' ', margin + len(number))//' | '
    do i = 1, min(column - 1, len(source)) ! tabs are kept to align the caret
      if (source(i:i) == achar(9)) then
        text = text//achar(9)
      else if (.not. continues(source(i:i))) then
        text = text//' '
      end if
    end do
    last = min(column + max(place%width, 1) - 1, len(source))
    n = 1
    if (last > column) n = max(characters(source(column:last)), 1)
    text = text//'^'//repeat('~', n - 1)
  end function head

  !> The text with `?` in place of each control character, which could disturb the terminal; tabs
  !! are kept.
  pure function visible(text) result(plain)
    character(*), intent(in) :: text
    character(len(text)) :: plain
    integer :: i

    plain = text
    do i = 1, len(text)
      if (text(i:i) == achar(9)) cycle
      if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) == 127) plain(i:i) = '?'
    end do
  end function visible

  !> Number of characters in a UTF-8 text.
  pure function characters(text) result(n)
    character(*), intent(in) :: text
    integer :: n, i

    n = 0
    do i = 1, len(text)
      if (.not. continues(text(i:i))) n = n + 1
    end do
  end function characters

  !> Does this byte continue a UTF-8 character?
  pure function continues(c) result(yes)
    character, intent(in) :: c
    logical :: yes

    yes = iand(ichar(c), 192) == 128
  end function continues

  !> Add an error to the list, which stores the first MOST errors and only counts the others.
  subroutine add_error(list, error)
    class(error_list_t), intent(inout) :: list
    type(error_t), intent(in) :: error

    list%n = list%n + 1
    if (list%n <= MOST) list%kept(list%n) = error
  end subroutine add_error

  pure function count_errors(list) result(n)
    class(error_list_t), intent(in) :: list
    integer :: n

    n = list%n
  end function count_errors

  !> Exit code: that of the first error, or 0 if there is none.
  pure function exit_code(list) result(code)
    class(error_list_t), intent(in) :: list
    integer :: code

    code = 0
    if (list%n > 0) code = list%kept(1)%code
  end function exit_code

  !> Text of the first ten errors as the user sees them, and the number of further ones.
  pure function render_list(list) result(text)
    class(error_list_t), intent(in) :: list
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, min(list%n, MOST)
      if (i > 1) text = text//new_line('a')
      text = text//render(list%kept(i))
    end do
    if (list%n > MOST) text = text//new_line('a')//'and '//to_text(list%n - MOST)//' more'
  end function render_list

end module base_error
