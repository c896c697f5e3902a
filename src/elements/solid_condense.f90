!> Elimination of the enhanced parameters of an element.
module solid_condense
  use base_kinds, only: wp
  use element_type, only: form_report_t
  use lapack, only: dgemm
  use tensor, only: ldl_factor, ldl_solve
  implicit none
  private
  public :: condense

contains

  !> Condense the last np unknowns of a symmetric system.
  !!
  !! L = K_aa^-1 K_au,  m = K_aa^-1 r_a,  K = K_uu - K_ua L,  r = r_u - K_ua m.
  pure subroutine condense(nd, np, full, rfull, k, r, m, l, report)
    integer, intent(in) :: nd, np
    real(wp), intent(in) :: full(nd + np, nd + np)
    real(wp), intent(in) :: rfull(nd + np)
    real(wp), intent(out) :: k(nd, nd)
    real(wp), intent(out) :: r(nd)
    real(wp), intent(out) :: m(np)
    real(wp), intent(out) :: l(np, nd)
    type(form_report_t), intent(inout) :: report

    real(wp) :: f(np, np), x(nd, np)
    integer :: i, j
    logical :: ok

    f = full(nd + 1:, nd + 1:)
    m = rfull(nd + 1:)
    x = full(:nd, nd + 1:)
    call ldl_factor(np, f, report%negative, ok)
    report%ok = report%ok .and. ok
    if (.not. ok) then
      k = 0.0_wp
      r = 0.0_wp
      l = 0.0_wp
      return
    end if
    call ldl_solve(np, f, 1, m)
    call solve_rows(nd, np, f, x)
    l = transpose(x)
    report%enhanced = abs(dot_product(m, rfull(nd + 1:)))
    r = rfull(:nd)
    do i = 1, np
      r = r - full(:nd, nd + i)*m(i)
    end do
    x = full(:nd, nd + 1:)
    k = full(:nd, :nd)
    call dgemm('N', 'N', nd, nd, np, -1.0_wp, x, nd, l, np, 1.0_wp, k, nd)
    do j = 1, nd ! makes the matrix symmetric to the last bit
      k(j, :j - 1) = k(:j - 1, j)
    end do
  end subroutine condense

  !> Compute x K_aa^-1 with the factors that ldl_factor computed. Unlike ldl_solve, this procedure
  !! treats all rows of x at once.
  pure subroutine solve_rows(nd, np, f, x)
    integer, intent(in) :: nd, np
    real(wp), intent(in) :: f(np, np)
    real(wp), intent(inout) :: x(nd, np)

    integer :: i, j

    do j = 1, np
      do i = 1, j - 1
        x(:, j) = x(:, j) - x(:, i)*f(j, i)
      end do
    end do
    do j = np, 1, -1
      x(:, j) = x(:, j)/f(j, j)
      do i = j + 1, np
        x(:, j) = x(:, j) - x(:, i)*f(i, j)
      end do
    end do
  end subroutine solve_rows

end module solid_condense
