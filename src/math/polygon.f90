!> Convex polygons in a plane: clipping, area and integration points.
module polygon
  use base_kinds, only: wp
  implicit none
  private
  public :: clip, signed_area, integrate_polygon, MOST_CORNERS

  integer, parameter :: MOST_CORNERS = 16 !! corners of a polygon clipped by a quadrilateral

contains

  !> Clip a polygon by a convex one (Sutherland and Hodgman 1974). The corners of both are in
  !! counter-clockwise order.
  pure subroutine clip(by, n, x)
    real(wp), intent(in) :: by(:, :)     !! (2, :) corners of the convex polygon
    integer, intent(inout) :: n          !! number of corners of the polygon; 0: nothing is left
    real(wp), intent(inout) :: x(2, MOST_CORNERS)
    real(wp) :: y(2, MOST_CORNERS), d(MOST_CORNERS), edge(2), s
    integer :: i, j, k, m

    do k = 1, size(by, 2)
      edge = by(:, mod(k, size(by, 2)) + 1) - by(:, k)
      do i = 1, n
        d(i) = edge(1)*(x(2, i) - by(2, k)) - edge(2)*(x(1, i) - by(1, k)) ! inside: positive
      end do
      m = 0
      do i = 1, n
        j = mod(i, n) + 1
        if (d(i) >= 0.0_wp .and. m < MOST_CORNERS) then
          m = m + 1
          y(:, m) = x(:, i)
        end if
        if ((d(i) >= 0.0_wp) .eqv. (d(j) >= 0.0_wp)) cycle
        if (m == MOST_CORNERS) cycle
        ! also where rounding puts the crossing on a corner: a corner that is left out costs its area
        s = d(i)/(d(i) - d(j))
        m = m + 1
        y(:, m) = x(:, i) + s*(x(:, j) - x(:, i))
      end do
      n = m
      x(:, :n) = y(:, :n)
      if (n < 3) then
        n = 0
        return
      end if
    end do
  end subroutine clip

  !> Area of a polygon, positive if its corners are in counter-clockwise order.
  pure real(wp) function signed_area(x) result(area)
    real(wp), intent(in) :: x(:, :)      !! (2, n)
    integer :: i, j

    area = 0.0_wp
    do i = 1, size(x, 2)
      j = mod(i, size(x, 2)) + 1
      area = area + 0.5_wp*(x(1, i)*x(2, j) - x(1, j)*x(2, i))
    end do
  end function signed_area

  !> Compute integration points and weights of a convex polygon. It is divided into quadrilaterals
  !! that share its first corner, each with Gauss points; the last one is collapsed to a triangle if
  !! the number of corners is odd.
  pure subroutine integrate_polygon(x, g, w, npoint, xi, weight)
    real(wp), intent(in) :: x(:, :)      !! (2, n) corners
    real(wp), intent(in) :: g(:), w(:)   !! (order) Gauss points on [-1,1] and their weights
    integer, intent(out) :: npoint
    real(wp), intent(out) :: xi(:, :)    !! (2, :) points; at most MOST_CORNERS/2*order**2
    real(wp), intent(out) :: weight(:)
    real(wp) :: q(2, 4), shp(4), dx(2, 2)
    integer :: i, j, k

    npoint = 0
    i = 2
    do while (i < size(x, 2))
      q(:, 1) = x(:, 1)
      q(:, 2) = x(:, i)
      q(:, 3) = x(:, i + 1)
      q(:, 4) = x(:, min(i + 2, size(x, 2)))
      i = i + 2
      do k = 1, size(g)
        do j = 1, size(g)
          shp = 0.25_wp*[(1 - g(j))*(1 - g(k)), (1 + g(j))*(1 - g(k)), (1 + g(j))*(1 + g(k)), &
                         (1 - g(j))*(1 + g(k))]
          dx(:, 1) = 0.25_wp*((1 - g(k))*(q(:, 2) - q(:, 1)) + (1 + g(k))*(q(:, 3) - q(:, 4)))
          dx(:, 2) = 0.25_wp*((1 - g(j))*(q(:, 4) - q(:, 1)) + (1 + g(j))*(q(:, 3) - q(:, 2)))
          npoint = npoint + 1
          xi(:, npoint) = matmul(q, shp)
          weight(npoint) = w(j)*w(k)*(dx(1, 1)*dx(2, 2) - dx(1, 2)*dx(2, 1))
        end do
      end do
    end do
  end subroutine integrate_polygon

end module polygon
