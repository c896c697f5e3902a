!> A record of a deck: its fields and their places.
module deck_record
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_file, only: folder_of
  use base_text, only: key_of, to_text
  implicit none
  private
  public :: record_t, check_count, get_word, resolve_path

  integer, parameter, public :: RECORD_WORDS = 1   !! has fields
  integer, parameter, public :: RECORD_BLANK = 2   !! empty
  integer, parameter, public :: RECORD_COMMENT = 3 !! only a comment
  integer, parameter, public :: RECORD_END = 4     !! end of the deck

  !> One logical record; it may run over several lines of the file.
  type :: record_t
    integer :: kind = RECORD_END
    integer :: n = 0                       !! number of fields
    character(:), allocatable :: file      !! path as messages show it
    integer :: line = 0                    !! number of its first line
    character(:), allocatable :: raw       !! its lines as they stand in the file
    integer, allocatable :: start(:)       !! first character of each line in `raw`
    integer, allocatable :: first(:), last(:) !! (at least n) characters of each field in `raw`
  contains
    procedure :: key
    procedure :: text
    procedure :: place
    procedure :: spot
    procedure :: is_empty
    procedure :: assigns
    procedure :: is_end
    procedure :: is_blank
  end type record_t

contains

  !> The significant part of field i as a word: four letters, lower case; blank if it is empty.
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

  !> Check that a record has nmin to nmax fields; `usage` shows how it is written.
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
      expected = expected//' to '//to_text(nmax)
    end if
    expected = expected//' field'
    if (nmax > 1) expected = expected//'s'
    call fail(error, DECK_ERROR, 'expected '//expected//', found '//to_text(record%n), &
              record%place(min(record%n, nmax) + 1), usage)
  end subroutine check_count

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

  !> The path that field i names, relative to the file in which the record stands.
  pure function resolve_path(record, i) result(path)
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    character(:), allocatable :: path

    path = record%text(i)
    if (len(path) == 0) return
    if (path(1:1) /= '/') path = folder_of(record%file)//path
  end function resolve_path

end module deck_record
