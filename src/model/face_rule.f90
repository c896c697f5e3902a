!> Points on a face of a hexahedral parent cell.
module face_rule
  use base_kinds, only: wp
  use quadrature, only: gauss_quad
  use tensor, only: cross
  implicit none
  private
  public :: face_points, face_normal, face_directions

contains

  !> Set the Gauss points of local face `side` (xi-, xi+, eta-, eta+, zeta-, zeta+). On a polynomial
  !! face of degree p, they integrate a constant pressure exactly: the integrand has degree 3p - 1
  !! in each direction. If `order` is given, they integrate exactly any pressure that is a
  !! polynomial of this degree in the position; the integrand then has degree 3p - 1 + order*p. If
  !! the rule of the element has more points in a direction, as for rational elements or with
  !! QUADrature, the face gets as many.
  subroutine face_points(degree, inner, side, xi, w, order)
    integer, intent(in) :: degree(3)               !! degrees of the cell
    real(wp), intent(in) :: inner(:, :)            !! (3, n) points of the element's rule
    integer, intent(in) :: side
    real(wp), allocatable, intent(out) :: xi(:, :) !! (3, nq)
    real(wp), allocatable, intent(out) :: w(:)     !! (nq)
    integer, intent(in), optional :: order         !! degree of the pressure in the position
    real(wp), allocatable :: plane(:, :)
    integer :: d, a, b, n1, n2, m

    call face_directions(side, d, a, b)
    m = 3
    if (present(order)) m = m + order
    n1 = max((m*degree(a) + 1)/2, levels(inner(a, :)))
    n2 = max((m*degree(b) + 1)/2, levels(inner(b, :)))
    allocate (plane(2, n1*n2), xi(3, n1*n2), w(n1*n2))
    call gauss_quad(n1, n2, plane, w)
    xi(d, :) = merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
    xi(a, :) = plane(1, :)
    xi(b, :) = plane(2, :)
  end subroutine face_points

  !> Number of distinct coordinates in [-1,1].
  pure integer function levels(x)
    real(wp), intent(in) :: x(:)
    real(wp), parameter :: SAME = 1.0e-6_wp
    integer :: i

    levels = 0
    do i = 1, size(x)
      if (all(abs(x(:i - 1) - x(i)) > SAME)) levels = levels + 1
    end do
  end function levels

  !> Find the direction d normal to a face and the directions a and b in it; (a, b, d) is
  !! right-handed.
  pure subroutine face_directions(side, d, a, b)
    integer, intent(in) :: side
    integer, intent(out) :: d, a, b

    d = (side + 1)/2
    a = mod(d, 3) + 1
    b = mod(d + 1, 3) + 1
  end subroutine face_directions

  !> Compute the outward normal times the ratio of the area to the parent area, and both tangents.
  pure subroutine face_normal(side, x, dshp, area, ta, tb)
    integer, intent(in) :: side
    real(wp), intent(in) :: x(:, :)    !! (3, nen) positions [L]
    real(wp), intent(in) :: dshp(:, :) !! (3, nen) parent derivatives
    real(wp), intent(out) :: area(3)   !! [L^2]
    real(wp), intent(out) :: ta(3), tb(3)
    integer :: d, a, b

    call face_directions(side, d, a, b)
    ta = matmul(x, dshp(a, :))
    tb = matmul(x, dshp(b, :))
    area = cross(ta, tb)
    if (mod(side, 2) == 1) area = -area
  end subroutine face_normal

end module face_rule
