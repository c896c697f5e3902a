!> Elimination of the enhanced parameters of an element.
module solid_condense
  use base_kinds, only: wp
  use element_type, only: form_report_t
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
    real(wp), intent(out) :: k(:, :)      !! (nd, nd)
    real(wp), intent(out) :: r(nd)
    real(wp), intent(out) :: m(np)
    real(wp), intent(out) :: l(np, nd)
    type(form_report_t), intent(inout) :: report

    real(wp) :: f(np, np)
    integer :: i, j
    logical :: ok

    k = 0.0_wp
    r = 0.0_wp
    f = full(nd + 1:, nd + 1:)
    m = rfull(nd + 1:)
    l = full(nd + 1:, :nd)
    call ldl_factor(np, f, report%negative, ok)
    report%ok = report%ok .and. ok
    if (.not. ok) return
    call ldl_solve(np, f, 1, m)
    call ldl_solve(np, f, nd, l)
    report%enhanced = abs(dot_product(m, rfull(nd + 1:)))
    r = rfull(:nd)
    do i = 1, np
      r = r - full(:nd, nd + i)*m(i)
    end do
    do j = 1, nd
      k(:j, j) = full(:j, j)
      do i = 1, np
        k(:j, j) = k(:j, j) - full(:j, nd + i)*l(i, j)
      end do
      k(j, :j - 1) = k(:j - 1, j)
    end do
  end subroutine condense

end module solid_condense
