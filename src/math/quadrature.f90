!> Gauss-Legendre rules on the line, the square and the cube [-1,1]^d.
module quadrature
  use base_kinds, only: wp
  implicit none
  private
  public :: gauss, gauss_quad, gauss_hex

contains

  !> Compute the rule with n points, which is exact up to degree 2n-1. The points are the roots of
  !! the Legendre polynomial, found by Newton's method.
  pure subroutine gauss(n, x, w)
    integer, intent(in) :: n
    real(wp), intent(out) :: x(n), w(n) !! points (ascending) and weights, symmetric to the last bit
    real(wp), parameter :: PI = acos(-1.0_wp)
    real(wp) :: z, p, low, slope
    integer :: i, it

    do i = 1, (n + 1)/2
      z = cos(PI*(i - 0.25_wp)/(n + 0.5_wp))
      if (2*i - 1 == n) z = 0.0_wp
      do it = 1, 8
        call legendre(n, z, p, low)
        slope = n*(low - z*p)/(1.0_wp - z*z)
        z = z - p/slope
      end do
      if (2*i - 1 == n) z = 0.0_wp
      call legendre(n, z, p, low)
      slope = n*(low - z*p)/(1.0_wp - z*z)
      x(n + 1 - i) = z
      x(i) = -z
      w(i) = 2.0_wp/((1.0_wp - z*z)*slope**2)
      w(n + 1 - i) = w(i)
    end do
  end subroutine gauss

  !> Evaluate the Legendre polynomials of degrees n and n-1 at z.
  pure subroutine legendre(n, z, p, low)
    integer, intent(in) :: n
    real(wp), intent(in) :: z
    real(wp), intent(out) :: p, low
    real(wp) :: older
    integer :: j

    p = 1.0_wp
    low = 0.0_wp
    do j = 1, n
      older = low
      low = p
      p = ((2*j - 1)*z*low - (j - 1)*older)/j
    end do
  end subroutine legendre

  !> Compute the tensor-product rule on the square; the first direction varies fastest.
  pure subroutine gauss_quad(n1, n2, xi, w)
    integer, intent(in) :: n1, n2
    real(wp), intent(out) :: xi(2, n1*n2), w(n1*n2)
    real(wp) :: x1(n1), w1(n1), x2(n2), w2(n2)
    integer :: i, j

    call gauss(n1, x1, w1)
    call gauss(n2, x2, w2)
    do j = 1, n2
      do i = 1, n1
        xi(:, i + n1*(j - 1)) = [x1(i), x2(j)]
        w(i + n1*(j - 1)) = w1(i)*w2(j)
      end do
    end do
  end subroutine gauss_quad

  !> Compute the tensor-product rule on the cube; the first direction varies fastest.
  pure subroutine gauss_hex(n1, n2, n3, xi, w)
    integer, intent(in) :: n1, n2, n3
    real(wp), intent(out) :: xi(3, n1*n2*n3), w(n1*n2*n3)
    real(wp) :: x2(2, n1*n2), w2(n1*n2), x3(n3), w3(n3)
    integer :: i, k, q

    call gauss_quad(n1, n2, x2, w2)
    call gauss(n3, x3, w3)
    do k = 1, n3
      do i = 1, n1*n2
        q = i + n1*n2*(k - 1)
        xi(:, q) = [x2(1, i), x2(2, i), x3(k)]
        w(q) = w2(i)*w3(k)
      end do
    end do
  end subroutine gauss_hex

end module quadrature
