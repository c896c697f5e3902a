!> Reads JSON files as a tree of values; error messages give the line of the file.
!!
!! Values are numbered in the order of the file: i + 1 is the first member or element of value i, if
!! it has any.
!! Names and strings are not decoded; they keep their escape sequences. The depth of nesting and the
!! number of values are limited.
!! Source: RFC 8259
module format_json
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp
  use base_text, only: to_text, quoted
  use deck_number, only: whole_number
  use format_text, only: text_t, fail_in_file
  implicit none
  private
  public :: json_t, parse_json, member, first_of, get, get_integer, to_integer, get_reals, &
            check_number

  integer, parameter, public :: JSON_NULL = 0, JSON_FALSE = 1, JSON_TRUE = 2, JSON_NUMBER = 3, &
                                JSON_STRING = 4, JSON_LIST = 5, JSON_OBJECT = 6
  integer, parameter :: DEEPEST = 64, MOST = 100000000

  type :: json_t
    integer :: n = 0
    integer, allocatable :: type(:)      !! JSON_NULL to JSON_OBJECT
    integer, allocatable :: at(:)        !! position in the file
    integer, allocatable :: key(:)       !! position of a member's name in the file; 0: no name
    integer, allocatable :: next(:)      !! the next member or element of the same parent; 0: none
    integer, allocatable :: length(:)    !! number of members or elements
    real(wp), allocatable :: number(:)
  end type json_t

contains

  !> Read the whole text; the value that contains all others becomes value 1.
  subroutine parse_json(text, json, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(out) :: json
    type(error_t), allocatable, intent(out) :: error
    character :: c
    integer :: i

    text%at = 1
    call read_value(text, json, 0, i, error)
    if (allocated(error)) return
    call look(text, c)
    if (text%at <= len(text%all)) call fail_in_file(text, 'unexpected text after the end of the ' &
                                                    //'JSON value', error)
  end subroutine parse_json

  !> First member or element of value i; 0 if it has none.
  pure integer function first_of(json, i)
    type(json_t), intent(in) :: json
    integer, intent(in) :: i

    first_of = 0
    if (i > 0) then
      if (json%length(i) > 0) first_of = i + 1
    end if
  end function first_of

  !> Member of object i that has a given name; 0 if there is none.
  pure integer function member(text, json, i, name)
    type(text_t), intent(in) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i
    character(*), intent(in) :: name
    integer :: last

    member = first_of(json, i)
    do while (member > 0)
      if (json%key(member) > 0) then
        last = json%key(member) + len(name)
        if (last <= len(text%all)) then
          if (text%all(json%key(member):last) == name//'"') return
        end if
      end if
      member = json%next(member)
    end do
  end function member

  !> Append a value to the tree.
  subroutine append(json, type, at, i)
    type(json_t), intent(inout) :: json
    integer, intent(in) :: type, at
    integer, intent(out) :: i

    i = json%n + 1
    json%n = i
    call grow(json%type, i)
    call grow(json%at, i)
    call grow(json%key, i)
    call grow(json%next, i)
    call grow(json%length, i)
    call grow(json%number, i)
    json%type(i) = type
    json%at(i) = at
    json%key(i) = 0
    json%next(i) = 0
    json%length(i) = 0
    json%number(i) = 0.0_wp
  end subroutine append

  !> Find the next character that is not a blank; at the end of the file, the result is a blank.
  subroutine look(text, c)
    type(text_t), intent(inout) :: text
    character, intent(out) :: c

    do while (text%at <= len(text%all))
      if (iachar(text%all(text%at:text%at)) > 32) exit
      text%at = text%at + 1
    end do
    c = ' '
    if (text%at <= len(text%all)) c = text%all(text%at:text%at)
  end subroutine look

  !> Read a value with all its members or elements.
  recursive subroutine read_value(text, json, depth, i, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(inout) :: json
    integer, intent(in) :: depth
    integer, intent(out) :: i
    type(error_t), allocatable, intent(out) :: error
    character :: c
    integer :: key, length
    logical :: ok

    i = 0
    call look(text, c)
    if (depth > DEEPEST .or. json%n >= MOST) then
      call fail_in_file(text, 'the JSON value is too large or nested too deeply', error, &
                        'there may be at most '//to_text(MOST)//' values, each inside at most ' &
                        //to_text(DEEPEST)//' others')
      return
    end if
    select case (c)
    case ('{')
      call append(json, JSON_OBJECT, text%at, i)
      call read_list(text, json, depth, i, '}', error)
    case ('[')
      call append(json, JSON_LIST, text%at, i)
      call read_list(text, json, depth, i, ']', error)
    case ('"')
      call append(json, JSON_STRING, text%at, i)
      call read_string(text, key, error)
    case ('t')
      call read_word(text, json, 'true', JSON_TRUE, i, error)
    case ('f')
      call read_word(text, json, 'false', JSON_FALSE, i, error)
    case ('n')
      call read_word(text, json, 'null', JSON_NULL, i, error)
    case ('-', '0', '1', '2', '3', '4', '5', '6', '7', '8', '9')
      call append(json, JSON_NUMBER, text%at, i)
      length = verify(text%all(text%at:), '+-.0123456789eE') - 1
      if (length < 0) length = len(text%all) - text%at + 1
      associate (word => text%all(text%at:text%at + length - 1))
        call whole_number(word, json%number(i), ok)
        if (.not. ok) call fail_in_file(text, quoted(word)//' is not a valid number', error)
      end associate
      text%at = text%at + length
    case default
      call fail_expected(text, 'a value', error)
    end select
  end subroutine read_value

  !> Read elements, or members with their names, up to the closing bracket.
  recursive subroutine read_list(text, json, depth, list, close, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(inout) :: json
    integer, intent(in) :: depth, list
    character, intent(in) :: close
    type(error_t), allocatable, intent(out) :: error
    character :: c
    integer :: i, last, key

    text%at = text%at + 1
    last = 0
    key = 0
    call look(text, c)
    if (c == close) then
      text%at = text%at + 1
      return
    end if
    do
      if (close == '}') then
        call look(text, c)
        if (c /= '"') then
          call fail_expected(text, 'a name in quotes', error)
          return
        end if
        call read_string(text, key, error)
        if (allocated(error)) return
        call look(text, c)
        if (c /= ':') then
          call fail_expected(text, 'a colon', error)
          return
        end if
        text%at = text%at + 1
      end if
      call read_value(text, json, depth + 1, i, error)
      if (allocated(error)) return
      json%key(i) = key
      json%length(list) = json%length(list) + 1
      if (last > 0) json%next(last) = i
      last = i
      call look(text, c)
      if (c /= close .and. c /= ',') then
        call fail_expected(text, 'a comma or '//close, error)
        return
      end if
      text%at = text%at + 1
      if (c == close) return
    end do
  end subroutine read_list

  !> Go to the end of a string in quotes.
  subroutine read_string(text, key, error)
    type(text_t), intent(inout) :: text
    integer, intent(out) :: key  !! position of its first character
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    key = text%at + 1
    i = key
    do while (i <= len(text%all))
      if (text%all(i:i) == '"') then
        text%at = i + 1
        return
      end if
      i = i + merge(2, 1, text%all(i:i) == '\')
    end do
    call fail_in_file(text, 'the closing quote of a string is missing', error)
  end subroutine read_string

  !> Read true, false or null.
  subroutine read_word(text, json, word, type, i, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(inout) :: json
    character(*), intent(in) :: word
    integer, intent(in) :: type
    integer, intent(out) :: i
    type(error_t), allocatable, intent(out) :: error

    i = 0
    if (index(text%all(text%at:), word) /= 1) then
      call fail_expected(text, 'a value', error)
      return
    end if
    call append(json, type, text%at, i)
    text%at = text%at + len(word)
  end subroutine read_word

  subroutine fail_expected(text, what, error)
    type(text_t), intent(in) :: text
    character(*), intent(in) :: what
    type(error_t), allocatable, intent(out) :: error

    if (text%at > len(text%all)) then
      call fail_in_file(text, 'expected '//what//', found the end of the file', error, &
                        'the file seems to be truncated')
    else
      call fail_in_file(text, 'expected '//what//', found '//quoted(text%all(text%at:text%at)), &
                        error)
    end if
  end subroutine fail_expected

  !> Find the member `name` of value i; the member must have a given type.
  subroutine get(text, json, i, name, type, found, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i, type
    character(*), intent(in) :: name
    integer, intent(out) :: found
    type(error_t), allocatable, intent(out) :: error
    character(9), parameter :: NAMES(JSON_NULL:JSON_OBJECT) = &
                               [character(9) :: 'null', 'false', 'true', 'a number', 'a string', &
                                                 'a list', 'an object']

    found = member(text, json, i, name)
    text%at = json%at(i)
    if (found == 0) then
      call fail_in_file(text, 'member '//quoted(name)//' is missing', error)
      return
    end if
    text%at = json%at(found)
    if (json%type(found) == type) return
    call fail_in_file(text, 'expected '//trim(NAMES(type))//' for '//quoted(name)//', found ' &
                      //trim(NAMES(json%type(found))), error)
  end subroutine get

  subroutine get_integer(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i
    character(*), intent(in) :: name
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error
    integer :: found

    n = 0
    call get(text, json, i, name, JSON_NUMBER, found, error)
    if (.not. allocated(error)) call to_integer(text, json, found, name, n, error)
  end subroutine get_integer

  !> Get value i as an integer; `name` is the name of the list or member to which it belongs.
  subroutine to_integer(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i
    character(*), intent(in) :: name
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error

    n = 0
    text%at = json%at(i)
    if (json%type(i) == JSON_NUMBER .and. abs(json%number(i)) < huge(n) &
        .and. .not. abs(json%number(i) - anint(json%number(i))) > 0.0_wp) then
      n = nint(json%number(i))
    else
      call fail_in_file(text, 'expected a whole number in '//quoted(name), error)
    end if
  end subroutine to_integer

  !> Get all numbers of a list.
  subroutine get_reals(text, json, list, name, x, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: list
    character(*), intent(in) :: name
    real(wp), allocatable, intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, j

    allocate (x(json%length(list)), source=0.0_wp)
    j = first_of(json, list)
    do i = 1, size(x)
      if (json%type(j) /= JSON_NUMBER) then
        text%at = json%at(j)
        call fail_in_file(text, 'expected a number in '//quoted(name), error)
        return
      end if
      x(i) = json%number(j)
      j = json%next(j)
    end do
  end subroutine get_reals

  !> If object i has a member `name`, check that this member is the number n.
  subroutine check_number(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i, n
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error
    integer :: given

    if (member(text, json, i, name) == 0) return
    call get_integer(text, json, i, name, given, error)
    if (allocated(error) .or. given == n) return
    call fail_in_file(text, quoted(name)//' is '//to_text(given)//', but the file lists ' &
                      //to_text(n), error)
  end subroutine check_number

end module format_json
