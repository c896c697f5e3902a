!> Numbers as they are written in a deck: 1 1. .5 1.0d0 1e-3.
module deck_number
  use base_kinds, only: wp, i8
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: ieee_exceptions, only: ieee_get_status, ieee_set_status, ieee_status_type
  use, intrinsic :: ieee_exceptions, only: ieee_set_halting_mode, ieee_usual
  implicit none
  private
  public :: scan_number, whole_number

  character(*), parameter :: DIGITS = '0123456789'
  real(wp), parameter :: TEN(0:22) = [1e0_wp, 1e1_wp, 1e2_wp, 1e3_wp, 1e4_wp, 1e5_wp, 1e6_wp, &
                                      1e7_wp, 1e8_wp, 1e9_wp, 1e10_wp, 1e11_wp, 1e12_wp, 1e13_wp, &
                                      1e14_wp, 1e15_wp, 1e16_wp, 1e17_wp, 1e18_wp, 1e19_wp, &
                                      1e20_wp, 1e21_wp, 1e22_wp]

contains

  !> Read the unsigned number at the start of a text.
  subroutine scan_number(text, n, value, trouble)
    character(*), intent(in) :: text
    integer, intent(out) :: n     !! length of the number in characters; 0: there is none
    real(wp), intent(out) :: value
    character(:), allocatable, intent(out) :: trouble !! why the number has no value
    integer :: whole, fraction, power, at, i
    integer(i8) :: mantissa

    value = 0.0_wp
    call measure(text, whole, fraction, n)
    if (n == 0) return
    power = 0
    if (whole + fraction <= 15) then
      mantissa = 0
      call collect(text(:whole), mantissa)
      if (fraction > 0) call collect(text(whole + 2:whole + 1 + fraction), mantissa)
      at = scan(text(:n), 'eEdD')
      if (at > 0) then
        do i = at + 1, n
          if (scan(text(i:i), '+-') > 0) cycle
          power = min(10*power + iachar(text(i:i)) - 48, 100000) ! no overflow
        end do
        if (text(at + 1:at + 1) == '-') power = -power
      end if
      power = power - fraction
      ! Both operands are exact, so the result is correctly rounded.
      if (abs(power) <= ubound(TEN, 1)) then
        if (power >= 0) value = real(mantissa, wp)*TEN(power)
        if (power < 0) value = real(mantissa, wp)/TEN(-power)
        return
      end if
    end if
    call read_slowly(text(:n), value, trouble)
  end subroutine scan_number

  !> Read a word of a mesh or spline file, which must be a single number with or without a sign; ok
  !! is .false. if it is not a number or is too large.
  subroutine whole_number(word, value, ok)
    character(*), intent(in) :: word
    real(wp), intent(out) :: value
    logical, intent(out) :: ok
    type(ieee_status_type) :: status
    character(:), allocatable :: trouble
    integer :: n, sign

    value = 0.0_wp
    sign = 0
    if (len(word) > 0) sign = merge(1, 0, scan(word(1:1), '+-') > 0)
    call ieee_get_status(status)           ! a number out of range must not trap
    call ieee_set_halting_mode(ieee_usual, .false.)
    call scan_number(word(sign + 1:), n, value, trouble)
    call ieee_set_status(status)
    ok = n > 0 .and. n == len(word) - sign .and. ieee_is_finite(value)
    if (ok .and. allocated(trouble)) ok = index(trouble, 'large') == 0
    if (sign == 1) value = merge(-value, value, word(1:1) == '-')
  end subroutine whole_number

  !> Count the digits before and after the point, and find the length including the exponent.
  pure subroutine measure(text, whole, fraction, n)
    character(*), intent(in) :: text
    integer, intent(out) :: whole, fraction, n
    integer :: at, sign, nexp

    whole = count_digits(text)
    fraction = 0
    n = whole
    if (n < len(text)) then
      if (text(n + 1:n + 1) == '.') then
        fraction = count_digits(text(n + 2:))
        n = n + 1 + fraction
      end if
    end if
    if (whole + fraction == 0) n = 0
    if (n == 0 .or. n >= len(text)) return
    at = n + 1
    if (scan(text(at:at), 'eEdD') == 0) return
    sign = 0
    if (at < len(text)) sign = merge(1, 0, scan(text(at + 1:at + 1), '+-') > 0)
    if (at + sign >= len(text)) return
    nexp = count_digits(text(at + sign + 1:))
    if (nexp > 0) n = at + sign + nexp
  end subroutine measure

  pure function count_digits(text) result(n)
    character(*), intent(in) :: text
    integer :: n

    n = verify(text, DIGITS) - 1
    if (n < 0) n = len(text)
  end function count_digits

  pure subroutine collect(text, mantissa)
    character(*), intent(in) :: text
    integer(i8), intent(inout) :: mantissa
    integer :: i

    do i = 1, len(text)
      mantissa = 10*mantissa + (iachar(text(i:i)) - 48)
    end do
  end subroutine collect

  !> Read a number with the Fortran library, which rounds correctly but is slow.
  subroutine read_slowly(text, value, trouble)
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    character(:), allocatable, intent(out) :: trouble
    character(len(text) + 2) :: plain
    integer :: io, at

    plain = text
    at = scan(plain, 'dD')
    if (at > 0) plain(at:at) = 'e'
    if (scan(plain, '.eE') == 0) plain = trim(plain)//'.'
    value = 0.0_wp
    read (plain, *, iostat=io) value
    if (io /= 0 .or. .not. ieee_is_finite(value)) then
      value = 0.0_wp
      trouble = 'the number is too large'
      if (index(text, '-') > 0) trouble = 'the number is too small'
    else if (.not. abs(value) > 0.0_wp &
             .and. scan(text(:scan(text//'e', 'eEdD') - 1), '123456789') > 0) then
      trouble = 'the number is too small'
    end if
  end subroutine read_slowly

end module deck_number
