!> A record of a deck: its fields and their places.
module deck_record
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_file, only: folder_of
  use base_text, only: key_of, quoted, to_text
  implicit none
  private
  public :: record_t, check_count, check_numbers, mixed_comma, get_word, resolve_path

  integer, parameter, public :: RECORD_WORDS = 1   !! has fields
  integer, parameter, public :: RECORD_BLANK = 2   !! empty
  integer, parameter, public :: RECORD_COMMENT = 3 !! only a comment
  integer, parameter, public :: RECORD_END = 4     !! end of the deck

  character(*), parameter :: BLANKS = ' '//achar(9)

  !> One logical record, which may extend over several lines of the file.
  type :: record_t
    integer :: kind = RECORD_END
    integer :: n = 0                       !! number of fields
    character(:), allocatable :: file      !! path as messages show it
    integer :: line = 0                    !! number of its first line
    character(:), allocatable :: raw       !! its lines as they are in the file
    integer, allocatable :: start(:)       !! first character of each line in `raw`
    integer, allocatable :: first(:), last(:) !! (at least n) characters of each field in `raw`
  contains
    procedure :: key
    procedure :: text
    procedure :: place
    procedure :: spot
    procedure :: is_empty
    procedure :: assigns
    procedure :: has_digits_only
    procedure :: is_end
    procedure :: is_blank
  end type record_t

contains

  !> The significant part of field i as a word: its first four letters in lower case; blank if the
  !! field is empty.
  pure function key(record, i) result(four)
    class(record_t), intent(in) :: record
    integer, intent(in) :: i
    character(4) :: four

    four = ''
    if (.not. record%is_empty(i)) four = key_of(record%raw(record%first(i):record%last(i)))
  end function key

  !> Field i as written, without quotes; '' if it is empty.
  pure function text(record, i) result(field)
    class(record_t), intent(in) :: record
    integer, intent(in) :: i
    character(:), allocatable :: field

    field = ''
    if (.not. record%is_empty(i)) field = record%raw(record%first(i):record%last(i))
  end function text

  !> Is field i missing, or is it empty, as between two commas?
  pure function is_empty(record, i) result(yes)
    class(record_t), intent(in) :: record
    integer, intent(in) :: i
    logical :: yes

    yes = i < 1 .or. i > record%n
    if (.not. yes) yes = record%last(i) < record%first(i)
  end function is_empty

  !> Does the record have the form `name = ...` of the records of PARAmeters?
  pure function assigns(record) result(yes)
    class(record_t), intent(in) :: record
    logical :: yes

    yes = record%n > 1
    if (yes) yes = index(record%raw(record%last(1) + 1:record%first(2) - 1), '=') > 0
  end function assigns

  !> Are the fields from number `first` to `last` (by default to the end) empty or written with
  !! digits, signs and points only, so that no parameter decides on their values?
  pure function has_digits_only(record, first, last) result(yes)
    class(record_t), intent(in) :: record
    integer, intent(in) :: first
    integer, intent(in), optional :: last
    logical :: yes
    integer :: k, n

    n = record%n
    if (present(last)) n = min(n, last)
    yes = .true.
    do k = first, n
      yes = yes .and. verify(record%text(k), '0123456789.+-') == 0
    end do
  end function has_digits_only

  !> Has the deck ended?
  pure function is_end(record) result(yes)
    class(record_t), intent(in) :: record
    logical :: yes

    yes = record%kind == RECORD_END
  end function is_end

  !> Does the record have no fields, because it is blank or only a comment?
  pure function is_blank(record) result(yes)
    class(record_t), intent(in) :: record
    logical :: yes

    yes = record%kind == RECORD_BLANK .or. record%kind == RECORD_COMMENT
  end function is_blank

  !> The place of field i. It is the end of the record if this field is missing, and the whole line
  !! if the record has no fields.
  pure function place(record, i) result(at)
    class(record_t), intent(in) :: record
    integer, intent(in) :: i
    type(place_t) :: at

    if (record%n == 0 .or. i < 1) then
      at = record%spot(1, 0)
      at%column = 0
    else if (i > record%n) then
      at = record%spot(record%last(record%n) + 1, 1)
    else
      at = record%spot(record%first(i), max(record%last(i) - record%first(i) + 1, 1))
    end if
  end function place

  !> The place of `width` characters of `raw`, from character `first` on.
  pure function spot(record, first, width) result(at)
    class(record_t), intent(in) :: record
    integer, intent(in) :: first, width
    type(place_t) :: at
    integer :: k, last

    if (allocated(record%file)) at%file = record%file
    at%line = record%line
    if (.not. allocated(record%raw)) return
    k = 1
    do while (k < size(record%start))
      if (first < record%start(k + 1)) exit
      k = k + 1
    end do
    last = len(record%raw)
    if (k < size(record%start)) last = record%start(k + 1) - 1
    do while (last > record%start(k))
      if (record%raw(last:last) /= achar(10) .and. record%raw(last:last) /= achar(13)) exit
      last = last - 1
    end do
    at%line = record%line + k - 1
    at%text = record%raw(record%start(k):last)
    at%column = first - record%start(k) + 1
    at%width = width
  end function spot

  !> Check that a record has nmin to nmax fields; `usage` shows the user how the record is written.
  subroutine check_count(record, nmin, nmax, usage, error)
    type(record_t), intent(in) :: record
    integer, intent(in) :: nmin, nmax
    character(*), intent(in) :: usage
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: expected

    if (record%n >= nmin .and. record%n <= nmax) return
    expected = to_text(nmin)
    if (nmax == huge(nmax)) then
      expected = 'at least '//expected
    else if (nmax > nmin) then
      expected = expected//merge(' or ', ' to ', nmax == nmin + 1)//to_text(nmax)
    end if
    expected = expected//' field'
    if (nmax > 1) expected = expected//'s'
    call fail(error, DECK_ERROR, 'expected '//expected//', found '//to_text(record%n), &
              record%place(min(record%n, nmax) + 1), usage)
    if (record%n > nmax) call hint_at_comma(record, error)
  end subroutine check_count

  !> Check that no field from `first` on is a number; explanatory words, which FEAP allows, may
  !! follow.
  subroutine check_numbers(record, first, usage, error, last)
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    character(*), intent(in) :: usage
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: last !! last field to check; default: the last of the record
    integer :: i, n

    n = record%n
    if (present(last)) n = min(last, n)
    do i = first, n
      if (.not. begins_number(record%text(i))) cycle
      call fail(error, DECK_ERROR, 'unexpected '//quoted(record%text(i)), record%place(i), usage)
      call hint_at_comma(record, error)
      return
    end do
  end subroutine check_numbers

  !> If a record with too many fields seems to have a decimal comma, put a remark about the comma in
  !! front of the hint.
  subroutine hint_at_comma(record, error)
    type(record_t), intent(in) :: record
    type(error_t), intent(inout) :: error
    character(:), allocatable :: whole, part
    integer :: i

    i = comma_field(record, 2)
    if (i == 0) i = comma_field(record, 1) ! fields 1 and 2 are often a node and an increment
    if (i == 0) return
    whole = record%text(i)
    part = record%text(i + 1)
    error%hint = quoted(whole//','//part)//' is read as two numbers: if one number is meant, ' &
                 //'write '//whole//'.'//part//'; usage: '//error%hint
  end subroutine hint_at_comma

  !> Field that contains the integer part of the first number that seems to be written with a
  !! decimal comma, such as 1,5: digits on both sides of a comma without a blank. The result is 0 if
  !! there is none.
  pure integer function comma_field(record, first) result(i)
    type(record_t), intent(in) :: record
    integer, intent(in) :: first !! the field from which the search begins

    do i = first, record%n - 1
      if (record%is_empty(i) .or. record%is_empty(i + 1)) cycle
      associate (last => record%last(i))
        if (record%first(i + 1) /= last + 2 .or. record%raw(last + 1:last + 1) /= ',') cycle
      end associate
      if (is_digits(record%text(i + 1)) .and. is_whole(record%text(i))) return
    end do
    i = 0
  end function comma_field

  !> Field that contains the integer part of a number that is probably written with a decimal comma,
  !! because other numbers of the record are separated by blanks. The result is 0 if there is none.
  !! The first two fields may be a node and its increment.
  pure integer function mixed_comma(record) result(i)
    type(record_t), intent(in) :: record
    integer :: j

    i = 0
    if (record%n < 4) return
    i = comma_field(record, 2)
    if (i == 0) return
    if (record%raw(record%first(i) - 1:record%first(i) - 1) == ',') i = 0
    if (i == 0) return
    j = record%last(i + 1) + 1
    if (j <= len(record%raw)) then
      if (record%raw(j:j) == ',') i = 0
    end if
    do j = 1, record%n - 1
      if (i == 0 .or. j == i) cycle
      if (.not. (begins_number(record%text(j)) .and. begins_number(record%text(j + 1)))) cycle
      if (verify(record%raw(record%last(j) + 1:record%first(j + 1) - 1), BLANKS) == 0) return
    end do
    i = 0
  end function mixed_comma

  !> Is the text a whole number, with or without a sign?
  pure logical function is_whole(text)
    character(*), intent(in) :: text

    is_whole = is_digits(text)
    if (len(text) > 1 .and. scan(text, '+-') == 1) is_whole = is_digits(text(2:))
  end function is_whole

  pure logical function is_digits(text)
    character(*), intent(in) :: text

    is_digits = len(text) > 0 .and. verify(text, '0123456789') == 0
  end function is_digits

  pure logical function begins_number(text)
    character(*), intent(in) :: text

    begins_number = scan(text, '+-.0123456789') == 1 .and. scan(text, '0123456789') > 0
  end function begins_number

  !> Get field i as written; it must not be empty.
  subroutine get_word(record, i, word, error)
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    character(:), allocatable, intent(out) :: word
    type(error_t), allocatable, intent(out) :: error

    word = record%text(i)
    if (record%is_empty(i)) call fail(error, DECK_ERROR, 'expected a word in field ' &
                                      //to_text(i), record%place(i))
  end subroutine get_word

  !> The path in field i; a relative path starts from the folder of the record's file.
  pure function resolve_path(record, i) result(path)
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    character(:), allocatable :: path

    path = record%text(i)
    if (len(path) == 0) return
    if (path(1:1) /= '/') path = folder_of(record%file)//path
  end function resolve_path

end module deck_record
