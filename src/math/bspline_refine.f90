!> B-splines in one direction: more knots, a higher degree.
!! Source: Goldman and Lyche 1993: new control points are values of the blossom.
module bspline_refine
  use base_kinds, only: wp
  use bspline, only: spline_t, nspan, find_span, blossom
  implicit none
  private
  public :: with_knots, elevated, insertion_row, elevation_row

contains

  !> The space with more knots.
  pure function with_knots(s, list) result(fine)
    type(spline_t), intent(in) :: s
    real(wp), intent(in) :: list(:) !! knots to insert, inside the range, any order
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

  !> The space of one degree more and the same continuity.
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

  !> Control point i of the space `fine` as a combination of those of `s`, whose knots it holds.
  pure subroutine insertion_row(s, fine, i, first, w)
    type(spline_t), intent(in) :: s, fine
    integer, intent(in) :: i
    integer, intent(out) :: first  !! first control point of s
    real(wp), intent(out) :: w(:)  !! (p+1)
    integer :: k

    ! The arguments rise from the span of knot i on: the order in which all factors stay positive.
    k = find_span(s, fine%knots(i))
    first = k - s%degree
    call blossom(s%knots, s%degree, k, fine%knots(i + 1:i + s%degree), w)
  end subroutine insertion_row

  !> The same where `high` is `elevated(s)`: the mean of the blossoms that leave one knot out.
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

end module bspline_refine
