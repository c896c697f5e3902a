!> The grammar of expressions.
!!
!!   sum     = product { (+|-) product }
!!   product = factor { (*|/) factor }
!!   factor  = { +|- } power
!!   power   = primary [ ^ factor ]          so -2^2 is -4 and 2^3^2 is 512
!!   primary = number | name | name ( sum {, sum} ) | ( sum )
module deck_parser
  use base_kinds, only: wp
  use base_text, only: lower, nearest, quoted
  use deck_cursor, only: parser_t, next_character, character_at, close_parenthesis, descend, &
                         check_size, complain
  use deck_function, only: apply_function, function_index, function_names
  use deck_number, only: scan_number
  use deck_params, only: params_t, find_parameter, parameter_names
  implicit none
  private
  public :: parse_sum

  integer, parameter :: MOST_ARGUMENTS = 32
  character(*), parameter :: NAME_CHARACTERS = &
                             'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789'

contains

  !> Value of what stands at the parser's place; p%trouble is allocated where there is none.
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
      if (n == 0) call complain(p, 'decimal point without digits', first, 1)
      if (allocated(trouble)) call complain(p, trouble, first, n)
    case ('a':'z', 'A':'Z')
      call parse_name(p, params, value)
    case default
      if (p%at > len(p%text)) then
        call complain(p, 'expected a number at the end of the expression', max(p%at - 1, 1), 1)
      else
        call complain(p, 'expected a number before '//quoted(character_at(p)), p%at, 1)
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
      call complain(p, 'fractional power of a negative number', operator, 1)
    else if (whole .and. abs(exponent) <= 64.0_wp) then
      base = base**nint(exponent)
    else if (base < 0.0_wp) then
      base = sign(abs(base)**exponent, merge(1.0_wp, -1.0_wp,.not. abs(mod(exponent, &
                                                                           2.0_wp)) > 0.0_wp))
    else
      base = base**exponent
    end if
    call check_size(p, base, operator, 1)
  end subroutine raise

  subroutine complain_of_name(p, params, first, n)
    type(parser_t), intent(inout) :: p
    type(params_t), intent(in) :: params
    integer, intent(in) :: first, n
    character(:), allocatable :: name, hint

    name = p%text(first:first + n - 1)
    if (function_index(lower(name)) > 0) then
      call complain(p, 'function '//quoted(name)//' has no argument', first, n, &
                    'write '//name//'(...)')
      return
    end if
    hint = nearest(name, parameter_names(params))
    if (len(hint) > 0) then
      hint = 'nearest known: '//hint
    else
      hint = 'set it in PARAmeters before it is used'
    end if
    call complain(p, 'unknown parameter '//quoted(name), first, n, hint)
  end subroutine complain_of_name

end module deck_parser
