!> A deck as a stream of records, and the numbers in them.
module deck_stream
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: key_of, lower, quoted, to_text
  use deck_expression, only: compute, params_t, set_parameter, trouble_t
  use deck_params, only: is_name, note_spelling
  use deck_reader, only: reader_t, open_reader, next_record, next_unrolled, include_file, &
                         cancel_loops, check_loops, source_text
  use deck_record, only: record_t, check_count, mixed_comma, RECORD_WORDS, RECORD_COMMENT
  use deck_settings, only: setting_t, read_settings, use_setting, check_used, settings_text
  implicit none
  private
  public :: deck_t, open_deck, check_settings, warn_of_comma, deck_text
  public :: get_real, get_integer, get_assignment, read_parameters

  type :: deck_t
    type(params_t) :: params          !! current parameters
    integer :: consumed = 0           !! records returned to callers since the last END
    integer, private :: set_line = huge(1) !! first line of the PARAmeter that is being read
    type(reader_t), private :: reader
    type(setting_t), allocatable, private :: setting(:)
    type(record_t), private :: returned
    logical, private :: has_returned = .false.
    type(record_t), private :: comma  !! first record with a number like 1,5; n = 0: there is none
  contains
    procedure :: next
    procedure :: next_of_set
    procedure :: next_in_block
    procedure :: next_command
    procedure :: include => include_in_deck
    procedure :: skip
    procedure :: stop_loops
    procedure :: put_back
  end type deck_t

contains

  !> Open a deck. The files that it includes are opened when they are reached.
  subroutine open_deck(deck, path, settings, error)
    type(deck_t), intent(out) :: deck
    character(*), intent(in) :: path
    character(*), intent(in) :: settings(:) !! name=value, as given by --set
    type(error_t), allocatable, intent(out) :: error

    call read_settings(deck%setting, settings, error)
    if (allocated(error)) return
    call open_reader(deck%reader, path, error)
  end subroutine open_deck

  !> Check, after the deck has been read, that it sets every parameter that the command line sets.
  subroutine check_settings(deck, error)
    type(deck_t), intent(in) :: deck
    type(error_t), allocatable, intent(out) :: error

    call check_used(deck%setting, deck%params, error)
  end subroutine check_settings

  !> After the deck has been read, warn about the first number that seems to be written with a
  !! decimal comma. A comma separates fields, so the record has one number more than intended.
  subroutine warn_of_comma(deck)
    type(deck_t), intent(in) :: deck
    character(:), allocatable :: whole, part
    integer :: i

    if (deck%comma%n == 0) return
    i = mixed_comma(deck%comma)
    whole = deck%comma%text(i)
    part = deck%comma%text(i + 1)
    call warn(quoted(whole//','//part)//' is read as two numbers', deck%comma%place(i), 'a comma ' &
              //'separates numbers: write '//whole//'.'//part//' for one number, or put a blank ' &
              //'between two; further such numbers are not reported')
  end subroutine warn_of_comma

  !> Text of the deck with all its files and the settings of the command line.
  function deck_text(deck) result(text)
    type(deck_t), intent(in) :: deck
    character(:), allocatable :: text

    text = source_text(deck%reader)//settings_text(deck%setting)
  end function deck_text

  !> Read the next record of any kind.
  subroutine next(deck, record, error)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    if (deck%has_returned) then
      record = deck%returned
      deck%has_returned = .false.
    else
      call next_unrolled(deck%reader, deck%params, record, error)
      if (allocated(error)) return
      if (deck%comma%n == 0) then
        if (mixed_comma(record) > 0) deck%comma = record
      end if
    end if
    deck%consumed = deck%consumed + 1
    if (record%key(1) /= 'end') return
    deck%consumed = 0
    call check_loops(deck%reader, error)
  end subroutine next

  !> Put a record back, so that it is read again next.
  subroutine put_back(deck, record)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record

    deck%returned = record
    deck%has_returned = .true.
    deck%consumed = deck%consumed - 1
  end subroutine put_back

  !> Read the next record of a data set of FEAP, in which a line with only a comment is treated as a
  !! blank line.
  subroutine next_of_set(deck, record, error)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    call deck%next(record, error)
  end subroutine next_of_set

  !> Read the next record of a block that FEAP does not have, such as PATCh, CONTact or CURVe, in
  !! which a line with only a comment is skipped.
  subroutine next_in_block(deck, record, error)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    do
      call deck%next(record, error)
      if (allocated(error) .or. record%kind /= RECORD_COMMENT) return
    end do
  end subroutine next_in_block

  !> Read the next command of BATCh. Blank records and comments are skipped; LOOP, NEXT and INCLude
  !! are returned as commands.
  subroutine next_command(deck, record, error)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    do
      call next_record(deck%reader, record, error)
      if (allocated(error)) return
      if (.not. record%is_blank()) exit
    end do
    deck%consumed = 0
  end subroutine next_command

  !> Continue reading in the file that an INCLude record names.
  subroutine include_in_deck(deck, record, error)
    class(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call include_file(deck%reader, record, error)
  end subroutine include_in_deck

  !> After an error in a record, make the current pass of every open loop its last one.
  subroutine stop_loops(deck)
    class(deck_t), intent(inout) :: deck

    call cancel_loops(deck%reader)
  end subroutine stop_loops

  !> Skip n records.
  subroutine skip(deck, n, error)
    class(deck_t), intent(inout) :: deck
    integer, intent(in) :: n
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: i

    do i = 1, n
      call deck%next(record, error)
      if (allocated(error) .or. record%is_end()) return
    end do
  end subroutine skip

  !> Get field i as a number. An empty or missing field gives `default`. Without a default, an empty
  !! field between two commas gives 0, and a missing field is an error.
  subroutine get_real(deck, record, i, x, error, default)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    real(wp), intent(out) :: x
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: default

    x = 0.0_wp
    if (.not. record%is_empty(i)) then
      call compute_at(deck%params, record, record%first(i), &
                      record%raw(record%first(i):record%last(i)), x, error)
    else if (present(default)) then
      x = default
    else if (i > record%n) then
      call fail(error, DECK_ERROR, 'expected a number in field '//to_text(i), record%place(i))
    end if
  end subroutine get_real

  !> Get field i as an integer. Empty and missing fields are treated as by get_real.
  subroutine get_integer(deck, record, i, n, error, default)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: default
    real(wp) :: x

    n = 0
    if (present(default) .and. record%is_empty(i)) then
      n = default
      return
    end if
    call get_real(deck, record, i, x, error)
    if (allocated(error)) return
    if (abs(x) > huge(n)) then
      call fail(error, DECK_ERROR, quoted(record%text(i))//' is outside the range of integers, -' &
                //to_text(huge(n))//' to '//to_text(huge(n)), record%place(i))
    else if (abs(x - anint(x)) > 4*epsilon(x)*abs(x)) then
      call fail(error, DECK_ERROR, quoted(record%text(i))//' is not a whole number: ' &
                //to_text(x, 10), record%place(i), 'int(...) truncates a number')
    else
      n = nint(x)
    end if
  end subroutine get_integer

  !> Read a record `name = expression` and set the parameter. A value from the command line takes
  !! precedence over the first value in the deck.
  subroutine get_assignment(deck, record, name, value, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    character(:), allocatable, intent(out) :: name
    real(wp), intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    logical :: found

    value = 0.0_wp
    name = lower(record%text(1))
    if (.not. is_name(name)) then
      call fail(error, DECK_ERROR, quoted(record%text(1))//' is not a valid name', &
                record%place(1), &
                'a name is a letter, followed by letters, digits or underscores')
      return
    end if
    call check_count(record, 2, huge(1), 'name = expression', error)
    if (allocated(error)) return
    call use_setting(deck%setting, name, record%place(1), mentions(record, name), value, found)
    if (found) then
      call set_parameter(deck%params, name, value)
      call warn_of_name(deck, record)
      return
    end if
    call compute_at(deck%params, record, record%first(2), expression_of(record), value, error)
    if (allocated(error)) value = 1.0_wp   ! so that later records find the name
    call set_parameter(deck%params, name, value)
    call warn_of_name(deck, record)
  end subroutine get_assignment

  !> The expression of a record `name = expression`: all that follows the name. It may contain
  !! blanks, and commas in parentheses.
  pure function expression_of(record) result(expression)
    type(record_t), intent(in) :: record
    character(:), allocatable :: expression
    integer :: depth, i

    associate (first => record%first(2))
      expression = repeat(' ', record%last(record%n) - first + 1)
      do i = 2, record%n
        associate (from => record%first(i), to => record%last(i))
          expression(from - first + 1:to - first + 1) = record%raw(from:to)
        end associate
      end do
      depth = 0
      do i = 1, len(expression)
        if (expression(i:i) == '(') depth = depth + 1
        if (expression(i:i) == ')') depth = depth - 1
        if (depth > 0 .and. record%raw(first + i - 1:first + i - 1) == ',') expression(i:i) = ','
      end do
    end associate
  end function expression_of

  !> Does the expression of a record `name = expression` contain this name?
  pure logical function mentions(record, name) result(yes)
    type(record_t), intent(in) :: record
    character(*), intent(in) :: name
    character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyz0123456789_'
    character(:), allocatable :: text
    integer :: i, n

    text = ' '//lower(record%raw(record%first(2):record%last(record%n)))//' '
    n = len(name)
    yes = .false.
    do i = 2, len(text) - n
      if (text(i:i + n - 1) /= lower(name)) cycle
      yes = yes .or. (scan(text(i - 1:i - 1), LETTERS) == 0 .and. &
                      scan(text(i + n:i + n), LETTERS) == 0)
    end do
  end function mentions

  !> Warn if a parameter has been set before under a name that differs in case, or by another record
  !! of the same PARAmeter, unless the new value is computed from the old one.
  subroutine warn_of_name(deck, record)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    character(:), allocatable :: name, earlier
    integer :: line

    name = record%text(1)
    call note_spelling(deck%params, name, record%line, earlier, line)
    if (.not. allocated(earlier)) return
    if (mentions(record, name) .or. line == record%line) return
    if (earlier /= name) then
      call warn(quoted(name)//' and '//quoted(earlier)//' are the same parameter, because case ' &
                //'is ignored', record%place(1), 'this value replaces that of line ' &
                //to_text(line)//' from here on; if another parameter is meant, use another name')
    else if (line >= deck%set_line .and. line < record%line) then
      call warn('parameter '//quoted(name)//' is set twice in one PARAmeter', record%place(1), &
                'this value replaces that of line '//to_text(line)//' from here on: remove one ' &
                //'of them')
    end if
  end subroutine warn_of_name

  !> Read the records after PARAmeters up to a blank one. If there are several errors, the first one
  !! is returned. If the blank record is missing, the records that follow are read as parameters
  !! too; therefore an error in a record without `=` says where a blank record may be missing. A
  !! record without `=` that begins with a word of the mesh part is always an error, because
  !! MATErial 1, for example, would otherwise set a parameter.
  subroutine read_parameters(deck, words, line, error)
    type(deck_t), intent(inout) :: deck
    character(*), intent(in) :: words(:) !! words of the mesh part
    integer, intent(out) :: line !! line number of the blank record
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: found
    type(record_t) :: record
    character(:), allocatable :: name
    real(wp) :: value
    integer :: bare !! first line of the current run of records without `=`; 0: there is none

    bare = 0
    do
      call deck%next_of_set(record, found)
      line = record%line
      if (.not. allocated(found)) then
        if (record%kind /= RECORD_WORDS) exit
        if (record%assigns()) bare = 0
        deck%set_line = min(deck%set_line, line)
        if (bare == 0 .and. .not. record%assigns()) bare = line
        if (.not. record%assigns() .and. is_word(record%text(1), words)) then
          if (allocated(error)) return
          call fail(error, DECK_ERROR, 'expected name = expression, found the word ' &
                    //quoted(record%text(1)), record%place(1), 'close PARAmeter with a blank ' &
                    //'record; or, if a parameter of this name is meant, write ''='' after it')
          return
        end if
        call get_assignment(deck, record, name, value, found)
        if (allocated(found) .and. bare > 0) then
          if (allocated(found%hint)) found%hint = found%hint//'; '
          if (.not. allocated(found%hint)) found%hint = ''
          found%hint = found%hint//'if the parameters end before line '//to_text(bare) &
                       //', put a blank record there'
        end if
      end if
      if (allocated(found) .and. .not. allocated(error)) call move_alloc(found, error)
    end do
    deck%set_line = huge(1)
  end subroutine read_parameters

  !> Is the text one of the words, either in full or as its first four letters?
  pure logical function is_word(text, words) result(yes)
    character(*), intent(in) :: text
    character(*), intent(in) :: words(:)
    integer :: i

    yes = .false.
    do i = 1, size(words)
      yes = yes .or. lower(text) == lower(trim(words(i))) .or. lower(text) == key_of(words(i))
    end do
  end function is_word

  !> Compute the value of an expression that begins at character `first` of the record.
  subroutine compute_at(params, record, first, expression, value, error)
    type(params_t), intent(in) :: params
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    character(*), intent(in) :: expression
    real(wp), intent(out) :: value
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t), allocatable :: trouble

    call compute(params, expression, value, trouble)
    if (.not. allocated(trouble)) return
    call fail(error, DECK_ERROR, trouble%message, record%spot(first + trouble%at - 1, &
                                                              trouble%width))
    if (allocated(trouble%hint)) error%hint = trouble%hint
  end subroutine compute_at

end module deck_stream
