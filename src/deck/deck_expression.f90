!> Expressions wherever a number may stand.
!!
!!   sum     = product { (+|-) product }
!!   product = factor { (*|/) factor }
!!   factor  = { +|- } power
!!   power   = primary [ ^ factor ]          so -2^2 is -4 and 2^3^2 is 512
!!   primary = number | name | name ( sum {, sum} ) | ( sum )
module deck_expression
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: lower, nearest, quoted
  use deck_function, only: apply_function, function_index, function_names
  use deck_number, only: scan_number
  use deck_params, only: params_t, set_parameter, find_parameter, parameter_names
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: ieee_exceptions, only: ieee_get_status, ieee_set_status, ieee_set_halting_mode, &
    ieee_status_type, ieee_usual
  implicit none
  private
  public :: evaluate, compute, trouble_t
  public :: params_t, set_parameter

  integer, parameter :: DEEPEST = 100   !! nesting of parentheses and powers
  integer, parameter :: MOST_ARGUMENTS = 32
  character(*), parameter :: NAME_CHARACTERS = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789'

  !> What is wrong with an expression, and where in it.
  type :: trouble_t
    character(:), allocatable :: message, hint
    integer :: at = 0, width = 0
  end type trouble_t

  !> An expression being read.
  type :: parser_t
    character(:), allocatable :: text
    integer :: at = 1    !! next character
    integer :: depth = 0
    type(trouble_t), allocatable :: trouble
  end type parser_t

contains

  !> Value of the expression `text`, which stands at `place`.
  subroutine evaluate(params, text, value, place, error)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t), allocatable :: trouble
    type(place_t) :: spot

    call compute(params, text, value, trouble)
    if (.not. allocated(trouble)) return
    spot = place
    if (spot%column > 0) then
      spot%column = place%column + trouble%at - 1
      spot%width = trouble%width
    end if
    if (allocated(trouble%hint)) then
      call fail(error, DECK_ERROR, trouble%message, spot, trouble%hint)
    else
      call fail(error, DECK_ERROR, trouble%message, spot)
    end if
  end subroutine evaluate

  !> Value of an expression; what is wrong with it is told by position.
  subroutine compute(params, text, value, trouble)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    type(trouble_t), allocatable, intent(out) :: trouble
    type(parser_t) :: parser
    type(ieee_status_type) :: status
    logical :: done

    call read_plain(text, value, done)
    if (done) return
    ! Overflow and the like are found by their results, so no trap may fire meanwhile.
    call ieee_get_status(status)
    call ieee_set_halting_mode(ieee_usual, .false.)
    parser%text = text
    call parse_sum(parser, params, value)
    if (.not. allocated(parser%trouble)) call check_end(parser)
    call ieee_set_status(status)
    if (.not. allocated(parser%trouble)) return
    value = 0.0_wp
    call move_alloc(parser%trouble, trouble)
  end subroutine compute

  !> The common case fast: up to 15 digits with at most a sign in front.
  subroutine read_plain(text, value, done)
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    logical, intent(out) :: done
    character(:), allocatable :: trouble
    integer :: n, first

    value = 0.0_wp
    done = .false.
    if (len(text) == 0 .or. len(text) > 16 .or. scan(text, 'eEdD') > 0) return
    first = merge(2, 1, scan(text(1:1), '+-') > 0)
    call scan_number(text(first:), n, value, trouble)
    done = n > 0 .and. n == len(text) - first + 1 .and. .not. allocated(trouble)
    if (text(1:1) == '-') value = -value
  end subroutine read_plain

  recursive subroutine parse_sum(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    real(wp) :: right
    integer :: operator

    call parse_product(p, params, value)
    do while (.not. allocated(p%trouble))
      if (scan(next_character(p), '+-') == 0) return
      operator = p%at
      p%at = p%at + 1
      call parse_product(p, params, right)
      if (allocated(p%trouble)) return
      if (p%text(operator:operator) == '+') value = value + right
      if (p%text(operator:operator) == '-') value = value - right
      call check_size(p, value, operator, 1)
    end do
  end subroutine parse_sum

  recursive subroutine parse_product(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    real(wp) :: right
    integer :: operator

    call parse_factor(p, params, value)
    do while (.not. allocated(p%trouble))
      if (scan(next_character(p), '*/') == 0) return
      operator = p%at
      p%at = p%at + 1
      if (next_character(p) == '*' .and. p%text(operator:operator) == '*') then
        call complain(p, "unexpected '**'", operator, 2, 'write ^ for a power')
        return
      end if
      call parse_factor(p, params, right)
      if (allocated(p%trouble)) return
      if (p%text(operator:operator) == '*') then
        value = value*right
      else if (.not. abs(right) > 0.0_wp) then
        call complain(p, 'division by zero', operator + 1, p%at - operator - 1)
      else
        value = value/right
      end if
      call check_size(p, value, operator, 1)
    end do
  end subroutine parse_product

  recursive subroutine parse_factor(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    real(wp) :: exponent
    integer :: operator
    logical :: negative

    negative = .false.
    do while (scan(next_character(p), '+-') > 0)
      negative = negative .neqv. p%text(p%at:p%at) == '-'
      p%at = p%at + 1
    end do
    call parse_primary(p, params, value)
    if (allocated(p%trouble)) return
    if (next_character(p) == '^') then
      operator = p%at
      call descend(p, operator)
      if (allocated(p%trouble)) return
      p%at = p%at + 1
      call parse_factor(p, params, exponent)
      if (allocated(p%trouble)) return
      p%depth = p%depth - 1
      call raise(p, value, exponent, operator)
      if (allocated(p%trouble)) return
    end if
    if (negative) value = -value
  end subroutine parse_factor

  recursive subroutine parse_primary(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    character(:), allocatable :: trouble
    integer :: first, n

    value = 0.0_wp
    select case (next_character(p))
    case ('(')
      first = p%at
      call parse_parentheses(p, params, value)
    case ('0':'9', '.')
      call scan_number(p%text(p%at:), n, value, trouble)
      first = p%at
      p%at = p%at + n
      if (n == 0) call complain(p, 'a point without digits', first, 1)
      if (allocated(trouble)) call complain(p, trouble, first, n)
    case ('a':'z', 'A':'Z')
      call parse_name(p, params, value)
    case default
      if (p%at > len(p%text)) then
        call complain(p, 'a number is missing at the end of the expression', max(p%at - 1, 1), 1)
      else
        call complain(p, 'a number is missing before '//quoted(character_at(p)), p%at, 1)
      end if
    end select
  end subroutine parse_primary

  recursive subroutine parse_parentheses(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    integer :: first

    value = 0.0_wp
    first = p%at
    call descend(p, first)
    if (allocated(p%trouble)) return
    p%at = p%at + 1
    call parse_sum(p, params, value)
    if (allocated(p%trouble)) return
    call close_parenthesis(p, first)
    p%depth = p%depth - 1
  end subroutine parse_parentheses

  !> A parameter, or a function and its arguments.
  recursive subroutine parse_name(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    integer :: first, n
    logical :: known

    first = p%at
    n = verify(p%text(first:), NAME_CHARACTERS) - 1
    if (n < 0) n = len(p%text) - first + 1
    p%at = first + n
    value = 0.0_wp
    if (next_character(p) == '(') then
      call parse_call(p, params, first, n, value)
      return
    end if
    call find_parameter(params, lower(p%text(first:first + n - 1)), value, known)
    if (.not. known) call complain_of_name(p, params, first, n)
  end subroutine parse_name

  recursive subroutine parse_call(p, params, first, n, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    integer, intent(in) :: first, n !! the name
    real(wp), intent(out) :: value
    real(wp) :: x(MOST_ARGUMENTS)
    character(:), allocatable :: trouble
    integer :: f, narg, open

    value = 0.0_wp
    f = function_index(lower(p%text(first:first + n - 1)))
    if (f == 0) then
      call complain(p, 'unknown function '//quoted(p%text(first:first + n - 1)), first, n, &
        'nearest known: '//nearest(p%text(first:first + n - 1), function_names()))
      return
    end if
    open = p%at
    call descend(p, open)
    narg = 0
    do while (.not. allocated(p%trouble))
      p%at = p%at + 1
      if (narg == MOST_ARGUMENTS) call complain(p, 'more than 32 arguments', first, n)
      if (allocated(p%trouble)) return
      narg = narg + 1
      call parse_sum(p, params, x(narg))
      if (allocated(p%trouble)) return
      if (next_character(p) /= ',') exit
    end do
    if (.not. allocated(p%trouble)) call close_parenthesis(p, open)
    if (allocated(p%trouble)) return
    p%depth = p%depth - 1
    call apply_function(f, x(:narg), value, trouble)
    if (allocated(trouble)) then
      call complain(p, trouble, first, p%at - first)
    else
      call check_size(p, value, first, p%at - first)
    end if
  end subroutine parse_call

  subroutine raise(p, base, exponent, operator)
    type(parser_t), intent(inout) :: p
    real(wp), intent(inout) :: base
    real(wp), intent(in) :: exponent
    integer, intent(in) :: operator
    logical :: whole

    whole = abs(exponent - anint(exponent)) <= 0.0_wp
    if (.not. abs(base) > 0.0_wp .and. exponent < 0.0_wp) then
      call complain(p, 'division by zero: 0 to a negative power', operator, 1)
    else if (base < 0.0_wp .and. .not. whole) then
      call complain(p, 'a broken power of a negative number', operator, 1)
    else if (whole .and. abs(exponent) <= 64.0_wp) then
      base = base**nint(exponent)
    else if (base < 0.0_wp) then
      base = sign(abs(base)**exponent, merge(1.0_wp, -1.0_wp, .not. abs(mod(exponent, 2.0_wp)) > 0.0_wp))
    else
      base = base**exponent
    end if
    call check_size(p, base, operator, 1)
  end subroutine raise

  ! --- characters and complaints ---------------------------------------------------------------

  !> The character at hand, blanks skipped; a blank at the end of the text.
  function next_character(p) result(c)
    type(parser_t), intent(inout) :: p
    character :: c

    do while (p%at <= len(p%text))
      if (p%text(p%at:p%at) /= ' ' .and. p%text(p%at:p%at) /= achar(9)) exit
      p%at = p%at + 1
    end do
    c = ' '
    if (p%at <= len(p%text)) c = p%text(p%at:p%at)
  end function next_character

  !> The character at hand with all its bytes.
  pure function character_at(p) result(text)
    type(parser_t), intent(in) :: p
    character(:), allocatable :: text
    integer :: last

    last = p%at
    do while (last < len(p%text))
      if (iand(ichar(p%text(last + 1:last + 1)), 192) /= 128) exit
      last = last + 1
    end do
    text = p%text(p%at:last)
  end function character_at

  subroutine close_parenthesis(p, first)
    type(parser_t), intent(inout) :: p
    integer, intent(in) :: first

    if (next_character(p) == ')') then
      p%at = p%at + 1
    else if (p%at > len(p%text)) then
      call complain(p, "this '(' is not closed", first, 1, 'a blank ends an expression, except behind PARAmeter')
    else
      call complain(p, 'unexpected '//quoted(character_at(p)), p%at, 1)
    end if
  end subroutine close_parenthesis

  subroutine check_end(p)
    type(parser_t), intent(inout) :: p

    if (next_character(p) == ')') then
      call complain(p, "')' without '('", p%at, 1)
    else if (p%at <= len(p%text)) then
      call complain(p, 'unexpected '//quoted(character_at(p))//' in an expression', p%at, 1)
    end if
  end subroutine check_end

  subroutine descend(p, at)
    type(parser_t), intent(inout) :: p
    integer, intent(in) :: at

    p%depth = p%depth + 1
    if (p%depth > DEEPEST) call complain(p, 'nested deeper than 100', at, 1, 'split the expression by PARAmeter')
  end subroutine descend

  subroutine check_size(p, value, at, width)
    type(parser_t), intent(inout) :: p
    real(wp), intent(in) :: value
    integer, intent(in) :: at, width

    if (.not. ieee_is_finite(value)) call complain(p, 'the value is too large', at, width)
  end subroutine check_size

  subroutine complain_of_name(p, params, first, n)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    integer, intent(in) :: first, n
    character(:), allocatable :: name, hint

    name = p%text(first:first + n - 1)
    if (function_index(lower(name)) > 0) then
      call complain(p, quoted(name)//' is a function: its argument is missing', first, n, 'write '//name//'(...)')
      return
    end if
    hint = nearest(name, parameter_names(params))
    if (len(hint) > 0) then
      hint = 'nearest known: '//hint
    else
      hint = 'parameters are set by PARAmeter before they are used'
    end if
    call complain(p, 'unknown parameter '//quoted(name), first, n, hint)
  end subroutine complain_of_name

  !> The first complaint counts.
  subroutine complain(p, message, at, width, hint)
    type(parser_t), intent(inout) :: p
    character(*), intent(in) :: message
    integer, intent(in) :: at, width
    character(*), intent(in), optional :: hint

    if (allocated(p%trouble)) return
    allocate (p%trouble)
    p%trouble%message = message
    p%trouble%at = at
    p%trouble%width = width
    if (present(hint)) p%trouble%hint = hint
  end subroutine complain

end module deck_expression
