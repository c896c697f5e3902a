!> Expressions, which may replace any number in a deck.
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
  use, intrinsic :: ieee_exceptions, only: ieee_get_status, ieee_set_status, ieee_status_type
  use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_usual
  implicit none
  private
  public :: evaluate, compute, trouble_t, params_t, set_parameter

  integer, parameter :: DEEPEST = 100 !! largest depth of nested parentheses and powers
  integer, parameter :: MOST_ARGUMENTS = 32
  character(*), parameter :: NAME_CHARACTERS = &
                             'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789'

  !> An error in an expression: a message, and the character at which it occurs.
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

  !> Evaluate the expression `text`, which is at `place` in the deck.
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
    call fail(error, DECK_ERROR, trouble%message, spot)
    if (allocated(trouble%hint)) error%hint = trouble%hint
  end subroutine evaluate

  !> Compute the value of an expression; `trouble` says what is wrong and where in the text.
  subroutine compute(params, text, value, trouble)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    type(trouble_t), allocatable, intent(out) :: trouble
    character(:), allocatable :: reason
    type(parser_t) :: p
    type(ieee_status_type) :: status
    integer :: n, first

    ! A fast path for the common case: up to 15 digits, with at most a sign in front.
    value = 0.0_wp
    if (len(text) > 0 .and. len(text) <= 16 .and. scan(text, 'eEdD') == 0) then
      first = merge(2, 1, scan(text(1:1), '+-') > 0)
      call scan_number(text(first:), n, value, reason)
      if (text(1:1) == '-') value = -value
      if (n > 0 .and. n == len(text) - first + 1 .and. .not. allocated(reason)) return
    end if
    ! Overflow and similar errors are recognised by their results, so floating-point traps are off
    ! while the expression is evaluated.
    call ieee_get_status(status)
    call ieee_set_halting_mode(ieee_usual, .false.)
    p%text = text
    call parse_sum(p, params, value)
    if (next_character(p) == ')') then
      call reject(p, "')' without '('", p%at, 1)
    else if (p%at <= len(p%text)) then
      call reject(p, 'unexpected '//quoted(character_at(p))//' in an expression', p%at, 1)
    end if
    call ieee_set_status(status)
    if (.not. allocated(p%trouble)) return
    value = 0.0_wp
    call move_alloc(p%trouble, trouble)
  end subroutine compute

  !> Evaluate the sum that begins at the next character; p%trouble is allocated if the sum has no
  !! value.
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
        call reject(p, "unexpected '**'", operator, 2, 'write ^ for a power')
        return
      end if
      call parse_factor(p, params, right)
      if (allocated(p%trouble)) return
      if (p%text(operator:operator) == '*') then
        value = value*right
      else if (.not. abs(right) > 0.0_wp) then
        call reject(p, 'division by zero', operator + 1, p%at - operator - 1)
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
    logical :: negative, whole, even

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
      whole = abs(exponent - anint(exponent)) <= 0.0_wp
      if (.not. abs(value) > 0.0_wp .and. exponent < 0.0_wp) then
        call reject(p, 'division by zero: 0 to a negative power', operator, 1)
      else if (value < 0.0_wp .and. .not. whole) then
        call reject(p, 'a negative number has no fractional power', operator, 1)
      else if (whole .and. abs(exponent) <= 64.0_wp) then ! a product
        value = value**nint(exponent)
      else if (value < 0.0_wp) then
        even = .not. abs(mod(exponent, 2.0_wp)) > 0.0_wp
        value = sign(abs(value)**exponent, merge(1.0_wp, -1.0_wp, even))
      else
        value = value**exponent
      end if
      call check_size(p, value, operator, 1)
      if (allocated(p%trouble)) return
    end if
    if (negative) value = -value
  end subroutine parse_factor

  recursive subroutine parse_primary(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    character(:), allocatable :: reason
    integer :: first, n

    value = 0.0_wp
    select case (next_character(p))
    case ('(')
      first = p%at
      call descend(p, first)
      if (allocated(p%trouble)) return
      p%at = p%at + 1
      call parse_sum(p, params, value)
      if (allocated(p%trouble)) return
      call close_parenthesis(p, first)
      p%depth = p%depth - 1
    case ('0':'9', '.')
      call scan_number(p%text(p%at:), n, value, reason)
      first = p%at
      p%at = p%at + n
      if (n == 0) call reject(p, 'decimal point without digits', first, 1)
      if (allocated(reason)) call reject(p, reason, first, n)
    case ('a':'z', 'A':'Z')
      call parse_name(p, params, value)
    case default
      if (p%at > len(p%text)) then
        call reject(p, 'expected a number at the end of the expression', max(p%at - 1, 1), 1)
      else
        call reject(p, 'expected a number before '//quoted(character_at(p)), p%at, 1)
      end if
    end select
  end subroutine parse_primary

  !> Evaluate a parameter, or a function with its arguments.
  recursive subroutine parse_name(p, params, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    real(wp), intent(out) :: value
    character(:), allocatable :: name, hint
    integer :: first, n
    logical :: known

    first = p%at
    n = verify(p%text(first:), NAME_CHARACTERS) - 1
    if (n < 0) n = len(p%text) - first + 1
    name = p%text(first:first + n - 1)
    p%at = first + n
    value = 0.0_wp
    if (next_character(p) == '(') then
      call parse_call(p, params, name, first, value)
      return
    end if
    call find_parameter(params, lower(name), value, known)
    if (known) return
    if (function_index(lower(name)) > 0) then
      call reject(p, 'function '//quoted(name)//' has no argument', first, n, &
                  'write '//name//'(...)')
      return
    end if
    hint = nearest(name, parameter_names(params))
    if (len(hint) > 0) then
      hint = 'nearest known: '//hint
    else
      hint = 'set it in PARAmeters before it is used'
    end if
    call reject(p, 'unknown parameter '//quoted(name), first, n, hint)
  end subroutine parse_name

  !> Evaluate a function: read its arguments from the opening parenthesis on, and compute its value.
  recursive subroutine parse_call(p, params, name, first, value)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    character(*), intent(in) :: name
    integer, intent(in) :: first !! character at which the name begins
    real(wp), intent(out) :: value
    real(wp) :: x(MOST_ARGUMENTS)
    character(:), allocatable :: reason
    integer :: f, narg, open

    value = 0.0_wp
    f = function_index(lower(name))
    if (f == 0) then
      call reject(p, 'unknown function '//quoted(name), first, len(name), &
                  'nearest known: '//nearest(name, function_names()))
      return
    end if
    open = p%at
    call descend(p, open)
    narg = 0
    do while (.not. allocated(p%trouble))
      p%at = p%at + 1
      if (narg == MOST_ARGUMENTS) call reject(p, 'a function has more than 32 arguments', first, &
                                              len(name))
      if (allocated(p%trouble)) return
      narg = narg + 1
      call parse_sum(p, params, x(narg))
      if (allocated(p%trouble)) return
      if (next_character(p) /= ',') exit
    end do
    if (.not. allocated(p%trouble)) call close_parenthesis(p, open)
    if (allocated(p%trouble)) return
    p%depth = p%depth - 1
    call apply_function(f, x(:narg), value, reason)
    if (allocated(reason)) then
      call reject(p, reason, first, p%at - first)
    else
      call check_size(p, value, first, p%at - first)
    end if
  end subroutine parse_call

  !> The next character that is not blank, or a blank at the end of the text.
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

  !> The next character, with all its bytes (UTF-8).
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
    integer, intent(in) :: first !! position of the opening parenthesis

    if (next_character(p) == ')') then
      p%at = p%at + 1
    else if (p%at > len(p%text)) then
      call reject(p, "unclosed '('", first, 1, 'add '')'', or remove blanks, which end ' &
                  //'an expression except in PARAmeters')
    else
      call reject(p, 'unexpected '//quoted(character_at(p)), p%at, 1)
    end if
  end subroutine close_parenthesis

  subroutine descend(p, at)
    type(parser_t), intent(inout) :: p
    integer, intent(in) :: at

    p%depth = p%depth + 1
    if (p%depth > DEEPEST) then
      call reject(p, 'parentheses and powers are nested more than 100 levels deep', at, 1, &
                  'compute parts of the expression in PARAmeters')
    end if
  end subroutine descend

  subroutine check_size(p, value, at, width)
    type(parser_t), intent(inout) :: p
    real(wp), intent(in) :: value
    integer, intent(in) :: at, width

    if (.not. ieee_is_finite(value)) call reject(p, 'the value is too large', at, width)
  end subroutine check_size

  !> Record an error in the expression; only the first one is kept.
  subroutine reject(p, message, at, width, hint)
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
  end subroutine reject

end module deck_expression
