!> Splines through given points.
module interpolation
  use base_kinds, only: wp
  use bspline, only: spline_t, nfunction, find_span, basis_functions, greville
  use lapack, only: dgbsv
  implicit none
  private
  public :: interpolate

contains

  !> Coefficients of the spline that takes given values at its Greville points.
  subroutine interpolate(s, v, ok)
    type(spline_t), intent(in) :: s
    real(wp), intent(inout) :: v(:, :) !! (n, m) values of m quantities; out: coefficients
    logical, intent(out) :: ok         !! .false.: no such spline
    real(wp), allocatable :: band(:, :)
    real(wp) :: g(nfunction(s)), b(s%degree + 1)
    integer :: pivot(nfunction(s)), i, k, a, p, info

    p = s%degree
    g = greville(s)
    allocate (band(3*p + 1, size(g)), source=0.0_wp)
    do i = 1, size(g)
      k = find_span(s, g(i))
      call basis_functions(s, k, g(i), b)
      do a = 1, p + 1
        associate (j => k - p + a - 1)
          if (abs(i - j) <= p) band(2*p + 1 + i - j, j) = b(a)
        end associate
      end do
    end do
    call dgbsv(size(g), p, p, size(v, 2), band, 3*p + 1, pivot, v, size(v, 1), info)
    ok = info == 0
  end subroutine interpolate

end module interpolation
