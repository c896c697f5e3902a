!> Small tensors and matrices: pure kernels without allocation.
module tensor
  use base_kinds, only: wp
  implicit none
  private
  public :: trace, second_invariant, det3, inv3, cross, isotropic, ldl_factor, ldl_solve

contains

  pure real(wp) function trace(a)
    real(wp), intent(in) :: a(3, 3)

    trace = a(1, 1) + a(2, 2) + a(3, 3)
  end function trace

  !> The second invariant, which is the sum of the principal minors of order two.
  pure real(wp) function second_invariant(a)
    real(wp), intent(in) :: a(3, 3)

    second_invariant = (a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)) + (a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) &
                       + (a(3, 3)*a(1, 1) - a(3, 1)*a(1, 3))
  end function second_invariant

  pure real(wp) function det3(a)
    real(wp), intent(in) :: a(3, 3)

    det3 = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) &
           - a(1, 2)*(a(2, 1)*a(3, 3) - a(2, 3)*a(3, 1)) &
           + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
  end function det3

  !> Compute the inverse and the determinant; `b` must not be used if det = 0.
  pure subroutine inv3(a, b, det)
    real(wp), intent(in) :: a(3, 3)
    real(wp), intent(out) :: b(3, 3)
    real(wp), intent(out) :: det
    real(wp) :: r

    b(1, 1) = a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)
    b(2, 1) = a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3)
    b(3, 1) = a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1)
    b(1, 2) = a(1, 3)*a(3, 2) - a(1, 2)*a(3, 3)
    b(2, 2) = a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1)
    b(3, 2) = a(1, 2)*a(3, 1) - a(1, 1)*a(3, 2)
    b(1, 3) = a(1, 2)*a(2, 3) - a(1, 3)*a(2, 2)
    b(2, 3) = a(1, 3)*a(2, 1) - a(1, 1)*a(2, 3)
    b(3, 3) = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    det = a(1, 1)*b(1, 1) + a(1, 2)*b(2, 1) + a(1, 3)*b(3, 1)
    r = 0.0_wp
    if (abs(det) > 0.0_wp) r = 1.0_wp/det
    b = b*r
  end subroutine inv3

  pure function cross(a, b) result(c)
    real(wp), intent(in) :: a(3), b(3)
    real(wp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> The tangent lam 1 x 1 + 2 mu I of a law with two moduli, in the Voigt order 11 22 33 12 23 31.
  pure function isotropic(lam, mu) result(c)
    real(wp), intent(in) :: lam, mu
    real(wp) :: c(6, 6)
    integer :: i

    c = 0.0_wp
    c(1:3, 1:3) = lam
    do i = 1, 3
      c(i, i) = lam + 2.0_wp*mu
      c(i + 3, i + 3) = mu
    end do
  end function isotropic

  !> Factorise a symmetric matrix as L D L^T, in place (lower part). The number of negative entries
  !! of D equals the number of negative eigenvalues (Sylvester).
  pure subroutine ldl_factor(n, a, negative, ok)
    integer, intent(in) :: n
    real(wp), intent(inout) :: a(n, n) !! on exit, the unit lower factor, with D on the diagonal
    integer, intent(out) :: negative
    logical, intent(out) :: ok         !! .false.: `a` or a leading minor is singular up to rounding
    real(wp) :: scale(n), v
    integer :: i, j

    negative = 0
    ok = .true.
    do j = 1, n
      scale(j) = abs(a(j, j))
    end do
    do j = 1, n
      if (.not. abs(a(j, j)) > n*epsilon(1.0_wp)*scale(j)) then ! true also for a NaN
        ok = .false.
        return
      end if
      if (a(j, j) < 0.0_wp) negative = negative + 1
      do i = j + 1, n
        v = a(i, j)/a(j, j)
        a(i:n, i) = a(i:n, i) - v*a(i:n, j)
      end do
      a(j + 1:n, j) = a(j + 1:n, j)/a(j, j)
    end do
  end subroutine ldl_factor

  !> Solve a system in place with the factors that ldl_factor computed.
  pure subroutine ldl_solve(n, a, m, b)
    integer, intent(in) :: n, m
    real(wp), intent(in) :: a(n, n)
    real(wp), intent(inout) :: b(n, m) !! right-hand sides; on exit, the solutions
    integer :: i, j

    do j = 1, m
      do i = 1, n - 1
        b(i + 1:n, j) = b(i + 1:n, j) - a(i + 1:n, i)*b(i, j)
      end do
      do i = n, 1, -1
        b(i, j) = b(i, j)/a(i, i) - dot_product(a(i + 1:n, i), b(i + 1:n, j))
      end do
    end do
  end subroutine ldl_solve

end module tensor
