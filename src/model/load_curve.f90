!> Load tables (PROP).
module load_curve
  use base_kinds, only: wp
  implicit none
  private
  public :: load_table_t, table_factor, table_slope, load_factor, next_corner, next_extremum

  !> A factor p that depends on the time t. Kind 0 (a blank record in the deck): p = t; kind 1:
  !! FEAP's formula; kind 2: linear interpolation between pairs (t, p), constant before the first
  !! pair and after the last one.
  type :: load_table_t
    integer :: kind = 0
    integer :: power = 1
    real(wp) :: tmin = 0.0_wp, tmax = 0.0_wp
    real(wp) :: a(5) = 0.0_wp
    real(wp), allocatable :: t(:), p(:) !! (n) times, increasing, and factors
  end type load_table_t

contains

  !> The first time after `time` at which a table has a corner or a jump; huge if there is none.
  pure real(wp) function next_corner(table, time) result(corner)
    type(load_table_t), intent(in) :: table(:)
    real(wp), intent(in) :: time
    real(wp) :: past
    integer :: i

    corner = huge(corner)
    past = time + 8*epsilon(time)*abs(time)
    do i = 1, size(table)
      select case (table(i)%kind)
      case (1)
        if (table(i)%tmin > past) corner = min(corner, table(i)%tmin)
        if (table(i)%tmax > past) corner = min(corner, table(i)%tmax)
      case (2)
        corner = min(corner, minval(table(i)%t, mask=table(i)%t > past))
      case default                   ! it has no corners
      end select
    end do
  end function next_corner

  !> The first time after `time` at which the sine of a formula (kind 1) has a maximum or a minimum,
  !! or at which an even power of it is zero; huge if there is none.
  elemental real(wp) function next_extremum(table, time) result(extremum)
    type(load_table_t), intent(in) :: table
    real(wp), intent(in) :: time
    real(wp), parameter :: QUARTER = 0.5_wp*acos(-1.0_wp)
    real(wp) :: from, past, phase, rate
    integer :: n                           ! quarter periods up to the extremum
    integer :: spacing                     ! quarter periods between extrema

    extremum = huge(extremum)
    if (table%kind /= 1 .or. .not. abs(table%a(3)*table%a(4)) > 0.0_wp) return
    rate = abs(table%a(4))                 ! the sine of the opposite angle has the same extrema
    phase = sign(1.0_wp, table%a(4))*table%a(5)
    spacing = merge(1, 2, mod(max(table%power, 1), 2) == 0)
    from = max(time, table%tmin)
    past = from + 8*epsilon(from)*abs(from)
    n = floor((rate*(past - table%tmin) + phase)/QUARTER) + 1
    if (modulo(n, 2) == 0) n = n + spacing - 1
    extremum = table%tmin + (n*QUARTER - phase)/rate
    if (extremum <= past) extremum = extremum + spacing*QUARTER/rate
    if (extremum > table%tmax) extremum = huge(extremum)
  end function next_extremum

  !> Factor of one load table at a given time.
  pure function table_factor(table, time) result(factor)
    type(load_table_t), intent(in) :: table
    real(wp), intent(in) :: time
    real(wp) :: factor
    real(wp) :: s, gap
    integer :: i, n

    factor = 0.0_wp
    select case (table%kind)
    case (0)
      factor = time
    case (1)
      ! the range has a tolerance for rounding, so that 3 x 0.1 is not taken to exceed 0.3
      gap = 8*epsilon(time)*max(abs(time), abs(table%tmin), abs(table%tmax))
      if (time < table%tmin - gap .or. time > table%tmax + gap) return
      s = time - table%tmin
      factor = table%a(1) + table%a(2)*s &
               + table%a(3)*sin(table%a(4)*s + table%a(5))**max(table%power, 1)
    case (2)
      n = size(table%t)
      factor = table%p(n)
      do i = 1, n
        if (time >= table%t(i)) cycle
        factor = table%p(i)
        if (i > 1) factor = table%p(i - 1) + (table%p(i) - table%p(i - 1)) &
                            *((time - table%t(i - 1))/(table%t(i) - table%t(i - 1)))
        exit
      end do
    case default                     ! no table
      return
    end select
  end function table_factor

  !> Derivative of the factor with respect to time. At the ends of its range, a formula is
  !! differentiated as in the interior.
  pure function table_slope(table, time, ahead) result(slope)
    type(load_table_t), intent(in) :: table
    real(wp), intent(in) :: time
    logical, intent(in) :: ahead !! at a corner, take the slope after it, not before it
    real(wp) :: slope
    real(wp) :: gap, s
    integer :: i, k

    slope = 0.0_wp
    select case (table%kind)
    case (0)
      slope = 1.0_wp
    case (1)
      gap = 8*epsilon(time)*max(abs(time), abs(table%tmin), abs(table%tmax))
      if (time < table%tmin - gap .or. time > table%tmax + gap) return
      s = table%a(4)*(time - table%tmin) + table%a(5)
      k = max(table%power, 1)
      slope = table%a(2) + table%a(3)*k*sin(s)**(k - 1)*cos(s)*table%a(4)
    case (2)
      ! because of rounding, a target time may miss the corner at which it should lie
      gap = 8*epsilon(time)*max(abs(time), maxval(abs(table%t)))
      do i = 2, size(table%t)
        if (time > table%t(i) + gap .or. (ahead .and. time >= table%t(i) - gap)) cycle
        if (time < table%t(1) - gap) exit
        slope = (table%p(i) - table%p(i - 1))/(table%t(i) - table%t(i - 1))
        exit
      end do
    case default
      return
    end select
  end function table_slope

  !> Factor of a load number. The factor of number 0 is the sum of all tables (as in FEAP), and that
  !! of a number without a table is 0. If there are no tables at all, all factors are 1.
  pure function load_factor(factor, number) result(f)
    real(wp), intent(in) :: factor(:)  !! (ntable) current factors
    integer, intent(in) :: number
    real(wp) :: f

    if (size(factor) == 0) then
      f = 1.0_wp
    else if (number == 0) then
      f = sum(factor)
    else if (number > size(factor)) then
      f = 0.0_wp
    else
      f = factor(number)
    end if
  end function load_factor

end module load_curve
