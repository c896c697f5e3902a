!> Residual and consistent tangent of any solid element.
!!
!! The shape functions come from a table of their values at the integration points (basis_t); the
!! stress and the tangent at a point come from the material law. With the spatial gradients g
!! (reference gradients at small strain) and the reference volumes w0,
!!
!!   r_a  = sum_q w0 tau g_a
!!   K_ab = sum_q w0 [(g_a . (tau + mus 1) g_b) 1 + lam g_a x g_b + mus g_b x g_a]
!!
!! if the tangent of the law is lam 1 x 1 + 2 mus I (x is the tensor product). Otherwise K_ab
!! consists of B^T c B and (g_a . tau g_b) 1. At small strains, the geometric part is left out: tau
!! in (tau + mus 1) is zero. For the neo-Hookean law, tau + mus 1 is mu b. The sums over points are
!! in solid_panel. Enhanced modes are treated like additional functions.
module solid_form
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use element_type, only: form_report_t
  use material_type, only: material_t
  use solid_condense, only: condense
  use solid_panel, only: add_residual, add_moduli, add_general, mirror, groups, NV, CHUNK
  use solid_point, only: deform, centre_map, invert_map
  implicit none
  private
  public :: form, history_length

contains

  !> Number of reals in an element's history: the parameters, then m and L (see element_form_i).
  pure integer function history_length(nen, nmode) result(n)
    integer, intent(in) :: nen, nmode

    n = 3*nmode*(2 + 3*nen)
  end function history_length

  !> Compute residual and tangent of one element; the interface is element_form_i.
  pure subroutine form(basis, material, prop, xr, u, du, scale, h_old, h_new, r, k, report)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(:, :)
    real(wp), intent(in) :: u(:, :)
    real(wp), intent(in) :: du(:, :)
    real(wp), intent(in) :: scale
    real(wp), intent(in) :: h_old(:)
    real(wp), intent(out) :: h_new(:)
    real(wp), intent(out) :: r(:, :)
    real(wp), intent(out) :: k(:, :)
    type(form_report_t), intent(out) :: report

    real(wp) :: a(3, basis%nmode)

    if (basis%nmode == 0) then
      call integrate(basis, material, prop, xr, u, a, r, k, report%ok)
    else
      call form_enhanced(basis, material, prop, xr, u, du, scale, h_old, h_new, r, k, report)
    end if
  end subroutine form

  !> Do the work of `form` for an element with enhanced modes. Such an element has few functions, so
  !! the stack has room for the system before the modes are condensed. It has none for that of a
  !! spline of high degree, which `form` therefore sums in k.
  pure subroutine form_enhanced(basis, material, prop, xr, u, du, scale, h_old, h_new, r, k, report)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(:, :)
    real(wp), intent(in) :: u(:, :)
    real(wp), intent(in) :: du(:, :)
    real(wp), intent(in) :: scale
    real(wp), intent(in) :: h_old(:)
    real(wp), intent(out) :: h_new(:)
    real(wp), intent(out) :: r(:, :)
    real(wp), intent(out) :: k(:, :)
    type(form_report_t), intent(out) :: report

    real(wp) :: a(3, basis%nmode)
    real(wp) :: rfull(3, basis%nen + basis%nmode)
    real(wp) :: full(3*(basis%nen + basis%nmode), 3*(basis%nen + basis%nmode))
    integer :: nd, np

    nd = 3*basis%nen
    np = 3*basis%nmode
    h_new = 0.0_wp
    call advance(nd, np, h_old, du, scale, a)
    h_new(:np) = reshape(a, [np])
    call integrate(basis, material, prop, xr, u, a, rfull, full, report%ok)
    if (report%ok) then
      call condense(nd, np, full, rfull, k, r, h_new(np + 1:2*np), &
                    h_new(2*np + 1:np*(2 + nd)), report)
    else
      r = 0.0_wp
      k = 0.0_wp
    end if
  end subroutine form_enhanced

  !> Update the enhanced parameters after the nodes have moved by du: a - scale m - L du.
  pure subroutine advance(nd, np, h, du, scale, a)
    integer, intent(in) :: nd, np
    real(wp), intent(in) :: h(np*(2 + nd)) !! parameters, m, L
    real(wp), intent(in) :: du(nd)
    real(wp), intent(in) :: scale
    real(wp), intent(out) :: a(np)

    integer :: j

    a = h(:np) - scale*h(np + 1:2*np)
    do j = 1, nd
      a = a - h(np*(j + 1) + 1:np*(j + 2))*du(j)
    end do
  end subroutine advance

  !> Sum the contributions of all points. In r and k, the modes follow the functions. If `ok` is
  !! .false., r and k are zero.
  pure subroutine integrate(basis, material, prop, xr, u, a, r, k, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(3, basis%nen), u(3, basis%nen), a(3, basis%nmode)
    real(wp), intent(out) :: r(3, basis%nen + basis%nmode)
    real(wp), intent(out) :: k(3*(basis%nen + basis%nmode), 3*(basis%nen + basis%nmode))
    logical, intent(out) :: ok

    real(wp) :: g(NV, 3, CHUNK, groups(basis%nen + basis%nmode)) ! gradients
    real(wp) :: w(CHUNK), tau(6, CHUNK), lam(CHUNK), mus(CHUNK), c(6, 6, CHUNK)
    real(wp) :: centre(3, 3), jac0, xu(6, basis%nen)
    integer :: q, n, nall

    nall = basis%nen + basis%nmode
    xu(:3, :) = xr
    xu(4:, :) = u
    centre = 0.0_wp
    jac0 = 0.0_wp
    ok = .true.
    if (basis%nmode > 0) call centre_map(basis%nen, basis%dshp0, xr, centre, jac0, ok)
    g(:, :, :, size(g, 4)) = 0.0_wp
    n = 0
    do q = 1, basis%nq
      if (.not. ok) exit
      n = n + 1
      call evaluate_point(basis, material, prop, q, xu, a, centre, jac0, &
                          n, g, w(n), tau(:, n), lam(n), mus(n), c(:, :, n), ok)
      if (n < CHUNK .and. q < basis%nq .or. .not. ok) cycle
      call add_points(material, q <= CHUNK, nall, n, g, w, tau, lam, mus, c, r, k)
      n = 0
    end do
    if (.not. ok) then
      r = 0.0_wp
      k = 0.0_wp
    else if (associated(material%moduli)) then
      call mirror(3*nall, k)
    end if
  end subroutine integrate

  !> Add the contributions of n points to r and k; of k, only the upper triangle if the law has
  !! `moduli`.
  pure subroutine add_points(material, first, nall, n, g, w, tau, lam, mus, c, r, k)
    type(material_t), intent(in) :: material
    logical, intent(in) :: first !! set r and k instead of adding to them
    integer, intent(in) :: nall, n
    real(wp), intent(in) :: g(NV, 3, CHUNK, groups(nall)), w(CHUNK), c(6, 6, CHUNK)
    real(wp), intent(inout) :: tau(6, CHUNK), lam(CHUNK), mus(CHUNK) !! are multiplied by w
    real(wp), intent(inout) :: r(3, nall), k(3*nall, 3*nall)

    integer :: q

    do q = 1, n
      tau(:, q) = w(q)*tau(:, q)
    end do
    call add_residual(first, nall, n, g, tau, r)
    if (.not. material%finite) tau(:, :n) = 0.0_wp ! no geometric part
    if (associated(material%moduli)) then
      do q = 1, n
        lam(q) = w(q)*lam(q)
        mus(q) = w(q)*mus(q)
        tau(:3, q) = tau(:3, q) + mus(q)
      end do
      call add_moduli(first, nall, n, g, tau, lam, mus, k)
    else
      call add_general(first, nall, n, g, w, tau, c, k)
    end if
  end subroutine add_points

  !> Compute gradients, volume, stress and tangent at one point.
  pure subroutine evaluate_point(basis, material, prop, q, xu, a, centre, jac0, &
                                 n, g, w, tau, lam, mus, c, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    integer, intent(in) :: q !! index of the point in the rule
    real(wp), intent(in) :: xu(6, basis%nen), a(3, basis%nmode), centre(3, 3), jac0
    integer, intent(in) :: n !! index of the point in the panel
    real(wp), intent(inout) :: g(NV, 3, CHUNK, groups(basis%nen + basis%nmode))
    real(wp), intent(out) :: w, tau(6), lam, mus, c(6, 6)
    logical, intent(out) :: ok

    real(wp) :: h(3, 3), t(3, 3), back(3, 3), jac, det, m(3, basis%nmode)
    integer :: b, i, j, l

    call deform(basis%nen, basis%nmode, basis%dshp(:, :, q), basis%mode(:, :, q), xu, a, &
                centre, jac0, h, t, jac, m, ok)
    if (.not. ok) return
    w = basis%wgt(q)*jac
    if (associated(material%moduli)) then
      call material%moduli(prop, h, tau, lam, mus, ok)
    else
      call material%stress(prop, h, tau, c, ok)
    end if
    if (.not. ok) return
    if (material%finite) then
      do i = 1, 3
        h(i, i) = h(i, i) + 1.0_wp
      end do
      call invert_map(h, back, det, ok)
      if (.not. ok) return
      t = matmul(t, back)
      m = matmul(transpose(back), m)
    end if
    do i = 1, basis%nen
      b = (i - 1)/NV + 1
      l = i - NV*(b - 1)
      do j = 1, 3
        g(l, j, n, b) = t(1, j)*basis%dshp(1, i, q) + t(2, j)*basis%dshp(2, i, q) &
                        + t(3, j)*basis%dshp(3, i, q)
      end do
    end do
    do i = 1, basis%nmode
      b = (basis%nen + i - 1)/NV + 1
      l = basis%nen + i - NV*(b - 1)
      g(l, :, n, b) = m(:, i)
    end do
  end subroutine evaluate_point

end module solid_form
