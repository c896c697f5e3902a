!> Divides the lines of a deck into fields.
!!
!! Blanks, a comma or `=` separate fields. Two commas in a row enclose an empty field; a comma
!! inside parentheses belongs to its field. `!` starts a comment, text in "..." is one field, and a
!! line that ends with `&` continues on the next one.
module deck_lexer
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: key_of
  use deck_record, only: record_t, RECORD_WORDS, RECORD_BLANK, RECORD_COMMENT
  use deck_source, only: source_t
  implicit none
  private
  public :: read_record

  integer, parameter :: OTHER = 0, BLANK = 1, COMMA = 2, COMMENT = 3, QUOTE = 4, OPENING = 5, &
                        CLOSING = 6
  character(*), parameter :: QUOTES = 'quotes enclose a whole field: "..."'
  character(*), parameter :: BLANKS = ' '//achar(9)

  !> State of the procedures that divide the lines of a record into fields. Positions refer to the
  !! text of the whole file.
  type :: cutter_t
    integer :: at = 1              !! next character
    integer :: last = 0            !! last character of the line
    logical :: expects = .true.    !! a field is expected; a comma here means that it is empty
    logical :: continues = .false. !! the line ends with &
    logical :: commented = .false.
    integer :: wrong = 0           !! position of the first error; 0: there is none
    character(:), allocatable :: why, hint
  end type cutter_t

contains

  !> Read the record that begins at `line`; afterwards `line` is the first line after it.
  subroutine read_record(source, line, record, error)
    type(source_t), intent(in) :: source
    integer, intent(inout) :: line
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error
    type(cutter_t) :: cutter
    integer :: shift, nline

    record%line = line
    shift = source%first(line) - 1
    allocate (record%first(12), record%last(12), record%start(2))
    nline = 0
    do
      call append(record%start, nline, source%first(line) - shift)
      cutter%continues = .false.
      cutter%commented = .false.
      cutter%at = source%first(line)
      cutter%last = source%last(line)
      call cut_line(source%text, record, cutter)
      ! Comment lines may stand between the lines of a record.
      if (nline > 1 .and. cutter%commented) cutter%continues = &
        verify(source%text(source%first(line):cutter%at - 1), BLANKS) == 0
      line = line + 1
      if (cutter%wrong > 0 .or. .not. cutter%continues) exit
      if (line <= source%nline) then
        if (verify(source%text(source%first(line):source%last(line)), BLANKS) > 0) cycle
      end if
      call reject(cutter, cutter%at, 'a record ends with ''&'', but the next line is blank or ' &
                  //'missing', 'remove the ''&'', or continue the record on the next line')
      exit
    end do
    record%file = source%path
    record%raw = source%text(shift + 1:cutter%last)
    record%start = record%start(:nline)
    record%first = record%first(:record%n) - shift
    record%last = record%last(:record%n) - shift
    record%kind = RECORD_WORDS
    if (record%n == 0) record%kind = merge(RECORD_COMMENT, RECORD_BLANK, cutter%commented)
    if (cutter%wrong > 0) call fail(error, DECK_ERROR, cutter%why, &
                                    record%spot(cutter%wrong - shift, 1), cutter%hint)
  end subroutine read_record

  !> Add the fields of one line to the record.
  subroutine cut_line(text, record, cutter)
    character(*), intent(in) :: text
    type(record_t), intent(inout) :: record
    type(cutter_t), intent(inout) :: cutter
    integer :: n

    associate (at => cutter%at)
      do while (at <= cutter%last .and. cutter%wrong == 0)
        select case (class_of(text(at:at)))
        case (BLANK)
          at = at + 1
        case (COMMA)
          if (cutter%expects) call add_field(record, at, at - 1)
          cutter%expects = .true.
          at = at + 1
        case (COMMENT)
          cutter%commented = .true.
          return
        case (QUOTE)
          n = index(text(at + 1:cutter%last), '"')
          if (n == 0) then
            call reject(cutter, at, 'unclosed quote', QUOTES)
            return
          end if
          call add_field(record, at + 1, at + n - 1)
          at = at + n + 1
          cutter%expects = .false.
          if (at > cutter%last) return
          if (any(class_of(text(at:at)) == [BLANK, COMMA, COMMENT])) cycle
          if (.not. ends_line(text(at:cutter%last))) then
            call reject(cutter, at, 'no separator after the quote', 'add a blank or a comma')
          end if
        case default
          cutter%continues = ends_line(text(at:cutter%last))
          if (cutter%continues) return
          call cut_plain(text, record, cutter)
          cutter%expects = .false.
          if (record%n == 1 .and. cutter%wrong == 0) call cut_title(text, record, cutter)
        end select
      end do
    end associate
  end subroutine cut_line

  !> Add an unquoted field to the record.
  subroutine cut_plain(text, record, cutter)
    character(*), intent(in) :: text
    type(record_t), intent(inout) :: record
    type(cutter_t), intent(inout) :: cutter
    integer :: depth, at

    depth = 0
    do at = cutter%at, cutter%last
      select case (class_of(text(at:at)))
      case (BLANK, COMMENT)
        exit
      case (COMMA)
        if (depth <= 0) exit
      case (OPENING)
        depth = depth + 1
      case (CLOSING)
        depth = depth - 1
      case (QUOTE)
        call reject(cutter, at, 'quote inside a word', QUOTES)
        return
      case default
        if (ends_line(text(at:cutter%last))) exit
      end select
    end do
    call add_field(record, cutter%at, at - 1)
    cutter%at = at
  end subroutine cut_plain

  !> Add FEAP's title: all that follows the word FEAP, up to a comment, is one field, even if
  !! it contains separators.
  subroutine cut_title(text, record, cutter)
    character(*), intent(in) :: text
    type(record_t), intent(inout) :: record
    type(cutter_t), intent(inout) :: cutter
    integer :: first, last

    if (key_of(text(record%first(1):record%last(1))) /= 'feap') return
    last = index(text(cutter%at:cutter%last), '!')
    last = merge(cutter%at + last - 2, cutter%last, last > 0)
    first = verify(text(cutter%at:last), ' ,='//achar(9))
    if (first > 0) then
      first = cutter%at + first - 1
      last = first - 1 + verify(text(first:last), BLANKS, back=.true.)
      call add_field(record, first, last)
    end if
    cutter%at = cutter%last + 1
  end subroutine cut_title

  !> Is the rest of a line an & that is followed by nothing but a comment?
  pure function ends_line(rest) result(yes)
    character(*), intent(in) :: rest
    logical :: yes
    integer :: next

    yes = .false.
    if (rest(1:1) /= '&') return
    next = verify(rest(2:), BLANKS)
    yes = next == 0
    if (.not. yes) yes = rest(next + 1:next + 1) == '!'
  end function ends_line

  subroutine reject(cutter, at, why, hint)
    type(cutter_t), intent(inout) :: cutter
    integer, intent(in) :: at
    character(*), intent(in) :: why, hint

    cutter%wrong = at
    cutter%why = why
    cutter%hint = hint
  end subroutine reject

  subroutine add_field(record, first, last)
    type(record_t), intent(inout) :: record
    integer, intent(in) :: first, last
    integer :: n

    n = record%n
    call append(record%first, n, first)
    call append(record%last, record%n, last)
  end subroutine add_field

  !> Append a number to a list of n numbers, whose size doubles when it is full.
  subroutine append(list, n, value)
    integer, allocatable, intent(inout) :: list(:)
    integer, intent(inout) :: n
    integer, intent(in) :: value
    integer, allocatable :: longer(:)

    if (n == size(list)) then
      allocate (longer(2*n))
      longer(:n) = list
      call move_alloc(longer, list)
    end if
    n = n + 1
    list(n) = value
  end subroutine append

  pure function class_of(c) result(class)
    character, intent(in) :: c
    integer :: class

    select case (c)
    case (' ', achar(9), achar(11), achar(12)); class = BLANK
    case (',', '='); class = COMMA
    case ('!'); class = COMMENT
    case ('"'); class = QUOTE
    case ('('); class = OPENING
    case (')'); class = CLOSING
    case default; class = OTHER
    end select
  end function class_of

end module deck_lexer
