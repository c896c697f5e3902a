!> A place in an expression while it is read, and what is wrong there.
module deck_cursor
  use base_kinds, only: wp
  use base_text, only: quoted
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: parser_t, trouble_t
  public :: next_character, character_at, close_parenthesis, check_end
  public :: descend, check_size, complain

  integer, parameter :: DEEPEST = 100   !! nesting of parentheses and powers

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
      call complain(p, "unclosed '('", first, 1, &
                    'a blank ends an expression, except in PARAmeters')
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
    if (p%depth > DEEPEST) call complain(p, 'parentheses and powers are nested more than 100 deep', at, 1, &
                                         'split the expression with PARAmeters')
  end subroutine descend

  subroutine check_size(p, value, at, width)
    type(parser_t), intent(inout) :: p
    real(wp), intent(in) :: value
    integer, intent(in) :: at, width

    if (.not. ieee_is_finite(value)) call complain(p, 'the value is too large', at, width)
  end subroutine check_size

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

end module deck_cursor
