!> B-splines in one direction: functions, Bezier extraction, knot insertion, degree elevation,
!! interpolation.
!!
!! Everything follows from the blossom (polar form) f(t_1, ..., t_p) of a polynomial segment of
!! degree p: `blossom` gives the weights of the p+1 local control points in the value of f. With
!! equal arguments, the blossom evaluates the spline; with new knots as arguments, it inserts these
!! knots or raises the degree; with the ends of a span as arguments, it gives the Bezier points of
!! the span. All of these operations are exact up to rounding.
!! Source: Ramshaw 1989; Goldman and Lyche 1993; Borden et al. 2011 (Bezier extraction).
module bspline
  use base_kinds, only: wp
  use lapack, only: dgbsv
  implicit none
  private
  public :: spline_t, new_spline, nfunction, nspan, span_list, find_span, basis_functions, &
            basis_derivatives, bernstein, greville, extraction, with_knots, elevated, &
            insertion_row, elevation_row, interpolate

  !> A spline space in one direction.
  type :: spline_t
    integer :: degree = 0              !! 0: the direction is not used and has one function
    real(wp), allocatable :: knots(:)  !! non-decreasing; each end is repeated degree+1 times
  end type spline_t

contains

  !> Open knot vector with simple interior knots.
  function new_spline(degree, breaks) result(s)
    integer, intent(in) :: degree
    real(wp), intent(in) :: breaks(:) !! ends of the spans, increasing
    type(spline_t) :: s
    integer :: n

    n = size(breaks)
    s%degree = degree
    allocate (s%knots(n + 2*degree))
    s%knots(:degree) = breaks(1)
    s%knots(degree + 1:degree + n) = breaks
    s%knots(degree + n + 1:) = breaks(n)
  end function new_spline

  pure integer function nfunction(s)
    type(spline_t), intent(in) :: s

    nfunction = size(s%knots) - s%degree - 1
  end function nfunction

  !> Number of spans that are not empty.
  pure integer function nspan(s)
    type(spline_t), intent(in) :: s

    nspan = count(s%knots(2:) > s%knots(:size(s%knots) - 1))
  end function nspan

  !> List the spans that are not empty, in order: span e goes from knots(k(e)) to knots(k(e)+1), and
  !! its functions are k(e)-p to k(e).
  pure subroutine span_list(s, k)
    type(spline_t), intent(in) :: s
    integer, allocatable, intent(out) :: k(:) !! (nspan)
    integer :: i

    k = pack([(i, i=1, size(s%knots) - 1)], s%knots(2:) > s%knots(:size(s%knots) - 1))
  end subroutine span_list

  !> The span of u, for which knots(k) <= u < knots(k+1); at the upper end, the last span.
  pure integer function find_span(s, u) result(k)
    type(spline_t), intent(in) :: s
    real(wp), intent(in) :: u
    integer :: high, mid

    k = s%degree + 1
    high = size(s%knots) - s%degree
    do while (high - k > 1)
      mid = (k + high)/2
      if (u >= s%knots(mid)) then
        k = mid
      else
        high = mid
      end if
    end do
    ! The span found is empty only at the upper end, if the last knot is repeated too often.
    do while (k > s%degree + 1 .and. s%knots(k + 1) <= s%knots(k))
      k = k - 1
    end do
  end function find_span

  !> Compute the weights of the local control points k-p to k in the blossom of span k.
  pure subroutine blossom(knots, p, k, t, n)
    real(wp), intent(in) :: knots(:)
    integer, intent(in) :: p, k    !! degree, span (not empty)
    real(wp), intent(in) :: t(p)   !! arguments
    real(wp), intent(out) :: n(p + 1)
    real(wp) :: saved, quotient
    integer :: j, r

    n(1) = 1.0_wp
    do j = 1, p
      saved = 0.0_wp
      do r = 1, j
        quotient = n(r)/(knots(k + r) - knots(k + r - j))
        n(r) = saved + (knots(k + r) - t(j))*quotient
        saved = (t(j) - knots(k + r - j))*quotient
      end do
      n(j + 1) = saved
    end do
  end subroutine blossom

  !> Evaluate the p+1 functions k-p to k at u in span k (Cox-de Boor).
  pure subroutine basis_functions(s, k, u, n)
    type(spline_t), intent(in) :: s
    integer, intent(in) :: k
    real(wp), intent(in) :: u
    real(wp), intent(out) :: n(:) !! (p+1)
    real(wp) :: t(s%degree)

    t = u
    call blossom(s%knots, s%degree, k, t, n)
  end subroutine basis_functions

  !> Evaluate the p+1 functions k-p to k and their first derivatives at u in span k.
  pure subroutine basis_derivatives(s, k, u, n, dn)
    type(spline_t), intent(in) :: s
    integer, intent(in) :: k
    real(wp), intent(in) :: u
    real(wp), intent(out) :: n(:), dn(:) !! (p+1)
    real(wp) :: t(s%degree), low(s%degree), quotient
    integer :: r, p

    p = s%degree
    call basis_functions(s, k, u, n)
    dn = 0.0_wp
    if (p == 0) return
    t = u
    call blossom(s%knots, p - 1, k, t(:p - 1), low)
    do r = 1, p
      quotient = p*low(r)/(s%knots(k + r) - s%knots(k + r - p))
      dn(r) = dn(r) - quotient
      dn(r + 1) = dn(r + 1) + quotient
    end do
  end subroutine basis_derivatives

  !> Evaluate the Bernstein polynomials of degree p on [-1,1] and their derivatives.
  pure subroutine bernstein(p, xi, b, db, d2b)
    integer, intent(in) :: p
    real(wp), intent(in) :: xi
    real(wp), intent(out) :: b(p + 1), db(p + 1)
    real(wp), intent(out), optional :: d2b(p + 1)
    real(wp) :: low(p + 1)
    integer :: q

    if (p == 2 .and. .not. present(d2b)) then ! the usual degree: the same operations without loops
      low(1) = 0.5_wp*(1.0_wp - xi)
      low(2) = 0.5_wp*(1.0_wp + xi)
      db = [-low(1), low(1) - low(2), low(2)]
      b = [low(1)*low(1), low(1)*low(2) + low(2)*low(1), low(2)*low(2)]
      return
    end if
    b = 0.0_wp
    b(1) = 1.0_wp
    low = 0.0_wp
    db = 0.0_wp
    if (present(d2b)) d2b = 0.0_wp
    do q = 1, p
      if (q == p) then
        db(1) = -0.5_wp*p*b(1)
        db(2:p) = 0.5_wp*p*(b(1:p - 1) - b(2:p))
        db(p + 1) = 0.5_wp*p*b(p)
        if (present(d2b) .and. p > 1) call second_differences(p, low, d2b) ! low: degree p-2
      end if
      low = b
      b(1) = 0.5_wp*(1.0_wp - xi)*low(1)
      b(2:q + 1) = 0.5_wp*(1.0_wp - xi)*low(2:q + 1) + 0.5_wp*(1.0_wp + xi)*low(1:q)
    end do
  end subroutine bernstein

  !> Compute the second derivatives of the Bernstein polynomials of degree p from the polynomials of
  !! degree p-2.
  pure subroutine second_differences(p, low, d2b)
    integer, intent(in) :: p
    real(wp), intent(in) :: low(p + 1)
    real(wp), intent(out) :: d2b(p + 1)
    real(wp) :: w(-1:p + 1)
    integer :: i

    w = 0.0_wp
    w(1:p - 1) = low(1:p - 1)
    do i = 1, p + 1
      d2b(i) = 0.25_wp*p*(p - 1)*(w(i - 2) - 2.0_wp*w(i - 1) + w(i))
    end do
  end subroutine second_differences

  !> Greville abscissae, which are the coefficients of the identity map.
  pure function greville(s) result(g)
    type(spline_t), intent(in) :: s
    real(wp) :: g(size(s%knots) - s%degree - 1)
    integer :: i

    do i = 1, size(g)
      if (s%degree == 0) then
        g(i) = 0.5_wp*(s%knots(i) + s%knots(i + 1))
      else
        g(i) = sum(s%knots(i + 1:i + s%degree))/s%degree
      end if
    end do
    if (s%degree == 0 .or. size(g) < 2) return
    g(1) = s%knots(1)
    g(size(g)) = s%knots(size(s%knots)) ! exact to the last bit
  end function greville

  !> Compute the Bezier extraction operators of all spans that are not empty: N = C B, with the
  !! Bernstein polynomials B on [-1,1].
  pure subroutine extraction(s, c, first)
    type(spline_t), intent(in) :: s
    real(wp), allocatable, intent(out) :: c(:, :, :) !! (p+1, p+1, nspan)
    integer, allocatable, intent(out) :: first(:)    !! (nspan) first function of the span
    real(wp) :: t(s%degree)
    integer, allocatable :: k(:)
    integer :: e, b, p

    p = s%degree
    call span_list(s, k)
    first = k - p
    allocate (c(p + 1, p + 1, size(k)))
    do e = 1, size(k)
      do b = 0, p
        t(:p - b) = s%knots(k(e))
        t(p - b + 1:) = s%knots(k(e) + 1)
        call blossom(s%knots, p, k(e), t, c(:, b + 1, e))
      end do
    end do
  end subroutine extraction

  !> The space with additional knots.
  pure function with_knots(s, list) result(fine)
    type(spline_t), intent(in) :: s
    real(wp), intent(in) :: list(:) !! knots to insert, inside the range, in any order
    type(spline_t) :: fine
    integer :: i, j

    fine%degree = s%degree
    allocate (fine%knots(size(s%knots) + size(list)))
    fine%knots(:size(s%knots)) = s%knots
    do i = 1, size(list)
      j = size(s%knots) + i
      do while (fine%knots(j - 1) > list(i))
        fine%knots(j) = fine%knots(j - 1)
        j = j - 1
      end do
      fine%knots(j) = list(i)
    end do
  end function with_knots

  !> The space of the next higher degree with the same continuity.
  pure function elevated(s) result(high)
    type(spline_t), intent(in) :: s
    type(spline_t) :: high
    integer :: i, n

    high%degree = s%degree + 1
    allocate (high%knots(size(s%knots) + nspan(s) + 1))
    n = 0
    do i = 1, size(s%knots)
      n = n + 1
      high%knots(n) = s%knots(i)
      if (i < size(s%knots)) then
        if (.not. s%knots(i + 1) > s%knots(i)) cycle
      end if
      n = n + 1
      high%knots(n) = s%knots(i)
    end do
  end function elevated

  !> Express control point i of the space `fine` by the control points of `s`; `fine` contains all
  !! knots of `s`.
  pure subroutine insertion_row(s, fine, i, first, w)
    type(spline_t), intent(in) :: s, fine
    integer, intent(in) :: i
    integer, intent(out) :: first  !! first control point of s
    real(wp), intent(out) :: w(:)  !! (p+1)
    integer :: k

    ! The blossom is taken in the span of knot i, and its arguments increase from there. In this
    ! order no term is negative, so that no digits cancel.
    k = find_span(s, fine%knots(i))
    first = k - s%degree
    call blossom(s%knots, s%degree, k, fine%knots(i + 1:i + s%degree), w)
  end subroutine insertion_row

  !> Express control point i of `high`, which is `elevated(s)`, by the control points of `s`. This
  !! point is the mean of p + 1 blossoms, each of which leaves out one knot.
  pure subroutine elevation_row(s, high, i, first, w)
    type(spline_t), intent(in) :: s, high
    integer, intent(in) :: i
    integer, intent(out) :: first
    real(wp), intent(out) :: w(:) !! (p+1)
    real(wp) :: t(s%degree + 1), n(s%degree + 1)
    integer :: j, k, p

    p = s%degree
    k = find_span(s, high%knots(i))
    first = k - p
    t = high%knots(i + 1:i + p + 1)
    w = 0.0_wp
    do j = 1, p + 1
      call blossom(s%knots, p, k, [t(:j - 1), t(j + 1:)], n)
      w = w + n
    end do
    w = w/(p + 1)
  end subroutine elevation_row

  !> Compute the coefficients of the spline that takes given values at its Greville points.
  subroutine interpolate(s, v, ok)
    type(spline_t), intent(in) :: s
    real(wp), intent(inout) :: v(:, :) !! (n, m) values of m quantities; on exit, the coefficients
    logical, intent(out) :: ok         !! .false. if there is no such spline
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

end module bspline
