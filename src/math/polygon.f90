!> Convex polygons in a plane: clipping, area, and integration points.
module polygon
  use base_kinds, only: wp
  implicit none
  private
  public :: clip, signed_area, integrate_polygon, MOST_CORNERS

  integer, parameter :: MOST_CORNERS = 16 !! largest number of corners of a clipped polygon

contains

  !> Clip a polygon by a convex polygon (Sutherland and Hodgman 1974). Both are counter-clockwise.
  pure subroutine clip(by, n, x, tag)
    real(wp), intent(in) :: by(:, :)     !! (2, :) corners of the convex polygon
    integer, intent(inout) :: n          !! corners of the polygon; 0: nothing is left
    real(wp), intent(inout) :: x(2, MOST_CORNERS)
    !> Origin of the edge from each corner to the next one: -k if it lies on edge k of `by`;
    !! otherwise the value on entry.
    integer, intent(inout) :: tag(MOST_CORNERS)
    real(wp) :: y(2, MOST_CORNERS), d(MOST_CORNERS), edge(2), s
    integer :: i, j, k, m, new(MOST_CORNERS)
    logical :: inside

    do k = 1, size(by, 2)
      edge = by(:, mod(k, size(by, 2)) + 1) - by(:, k)
      do i = 1, n
        d(i) = edge(1)*(x(2, i) - by(2, k)) - edge(2)*(x(1, i) - by(1, k)) ! positive inside
      end do
      m = 0
      do i = 1, n
        j = mod(i, n) + 1
        inside = d(i) >= 0.0_wp
        if (inside .and. m < MOST_CORNERS) then
          m = m + 1
          y(:, m) = x(:, i)
          new(m) = tag(i)
        end if
        if (inside .eqv. d(j) >= 0.0_wp) cycle
        s = d(i)/(d(i) - d(j))
        ! An intersection that rounding has moved to the inner corner is left out, because that
        ! corner is in the list.
        if (merge(s > 0.0_wp, s < 1.0_wp, inside) .and. m < MOST_CORNERS) then
          m = m + 1
          y(:, m) = x(:, i) + s*(x(:, j) - x(:, i))
          new(m) = tag(i)
        end if
        if (inside .and. m > 0) new(m) = -k
      end do
      n = m
      x(:, :n) = y(:, :n)
      tag(:n) = new(:n)
      if (n < 3) then
        n = 0
        return
      end if
    end do
  end subroutine clip

  !> Area of a polygon, positive if its corners are counter-clockwise.
  pure real(wp) function signed_area(x) result(area)
    real(wp), intent(in) :: x(:, :)      !! (2, n)
    integer :: i, j

    area = 0.0_wp
    do i = 1, size(x, 2)
      j = mod(i, size(x, 2)) + 1
      area = area + 0.5_wp*(x(1, i)*x(2, j) - x(1, j)*x(2, i))
    end do
  end function signed_area

  !> Integration points and weights of a convex polygon. Lines from its first corner divide it into
  !! quadrilaterals, each with its own Gauss points. If the number of corners is odd, the last part
  !! is a triangle. The edges may be curved: at the parameter t, edge i deviates from the straight
  !! line by sum_k bend(:,k,i) f_k(t).
  pure subroutine integrate_polygon(x, bend, g, w, f, df, npoint, xi, weight)
    real(wp), intent(in) :: x(:, :)       !! (2, n) corners
    real(wp), intent(in) :: bend(:, :, :) !! (2, :, n)
    real(wp), intent(in) :: g(:), w(:)    !! (order) Gauss points on [-1,1] and their weights
    !> (:, order) f at the Gauss points, and its derivatives; column order+1-j belongs to the point
    !! -g(j).
    real(wp), intent(in) :: f(:, :), df(:, :)
    integer, intent(out) :: npoint
    real(wp), intent(out) :: xi(:, :)     !! (2, :) points; at most MOST_CORNERS/2*order**2
    real(wp), intent(out) :: weight(:)
    real(wp) :: q(2, 4), shp(4), dx(2, 2)
    real(wp) :: b(2, 4, size(g)), db(2, 4, size(g)) ! deviations of the edges and their derivatives
    integer :: edge(4), i, j, k, n, order

    n = size(x, 2)
    order = size(g)
    npoint = 0
    i = 2
    do while (i < n)
      q(:, 1) = x(:, 1)
      q(:, 2) = x(:, i)
      q(:, 3) = x(:, i + 1)
      q(:, 4) = x(:, min(i + 2, n))
      b = 0.0_wp
      db = 0.0_wp
      edge = [merge(1, 0, i == 2), i, merge(i + 1, 0, i + 1 < n), merge(n, 0, i + 2 >= n)]
      do k = 1, 4
        if (edge(k) == 0) cycle ! a diagonal
        b(:, k, :) = matmul(bend(:, :, edge(k)), f)
        db(:, k, :) = matmul(bend(:, :, edge(k)), df)
      end do
      i = i + 2
      do k = 1, order
        do j = 1, order
          shp = 0.25_wp*[(1 - g(j))*(1 - g(k)), (1 + g(j))*(1 - g(k)), (1 + g(j))*(1 + g(k)), &
                         (1 - g(j))*(1 + g(k))]
          dx(:, 1) = 0.25_wp*((1 - g(k))*(q(:, 2) - q(:, 1)) + (1 + g(k))*(q(:, 3) - q(:, 4))) &
                     + 0.5_wp*((1 - g(k))*db(:, 1, j) - (1 + g(k))*db(:, 3, order + 1 - j) &
                               + b(:, 2, k) - b(:, 4, order + 1 - k))
          dx(:, 2) = 0.25_wp*((1 - g(j))*(q(:, 4) - q(:, 1)) + (1 + g(j))*(q(:, 3) - q(:, 2))) &
                     + 0.5_wp*((1 + g(j))*db(:, 2, k) - (1 - g(j))*db(:, 4, order + 1 - k) &
                               + b(:, 3, order + 1 - j) - b(:, 1, j))
          npoint = npoint + 1
          xi(:, npoint) = matmul(q, shp) &
                          + 0.5_wp*((1 - g(k))*b(:, 1, j) + (1 + g(k))*b(:, 3, order + 1 - j) &
                                    + (1 + g(j))*b(:, 2, k) + (1 - g(j))*b(:, 4, order + 1 - k))
          weight(npoint) = w(j)*w(k)*(dx(1, 1)*dx(2, 2) - dx(1, 2)*dx(2, 1))
        end do
      end do
    end do
  end subroutine integrate_polygon

end module polygon
