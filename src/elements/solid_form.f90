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
!! products of panels (functions by points), computed by BLAS. Enhanced modes are treated like
!! additional functions.
module solid_form
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use element_type, only: form_report_t
  use lapack, only: dgemm
  use material_type, only: material_t
  use solid_condense, only: condense
  use solid_panel, only: add_moduli, add_general, add_symmetric, fold, CHUNK
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
    real(wp) :: rfull(3, basis%nen + basis%nmode)
    real(wp) :: full(3*(basis%nen + basis%nmode), 3*(basis%nen + basis%nmode))
    integer :: nd, np

    nd = 3*basis%nen
    np = 3*basis%nmode
    if (np == 0) then
      call integrate(basis, material, prop, xr, u, a, r, k, report%ok)
      return
    end if
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
  end subroutine form

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
    real(wp), intent(out) :: r(:, :) !! (3, nen+nmode)
    real(wp), intent(out) :: k(:, :) !! (3*(nen+nmode), 3*(nen+nmode))
    logical, intent(out) :: ok

    real(wp) :: g(basis%nen + basis%nmode, 3, CHUNK)          ! gradients
    real(wp) :: p(size(g, 1), 3, size(g, 1), 3), s(size(g, 1), size(g, 1)), f(size(g, 1), 3)
    real(wp) :: centre(3, 3), jac0, w(CHUNK), tau(6, CHUNK), lam(CHUNK), mus(CHUNK), c(6, 6, CHUNK)
    real(wp) :: xu(6, basis%nen)
    integer :: q, n, nall

    nall = size(g, 1)
    xu(:3, :) = xr
    xu(4:, :) = u
    centre = 0.0_wp
    jac0 = 0.0_wp
    ok = .true.
    if (basis%nmode > 0) call centre_map(basis%nen, basis%dshp0, xr, centre, jac0, ok)
    n = 0
    do q = 1, basis%nq
      if (.not. ok) exit
      n = n + 1
      call evaluate_point(basis, material, prop, q, xu, a, centre, jac0, &
                          g(:, :, n), w(n), tau(:, n), lam(n), mus(n), c(:, :, n), ok)
      if (n < CHUNK .and. q < basis%nq .or. .not. ok) cycle
      call add_residual(q <= CHUNK, nall, n, g, w, tau, f)
      if (.not. material%finite) tau(:, :n) = 0.0_wp ! no geometric part
      if (associated(material%moduli)) then
        call add_moduli(q <= CHUNK, nall, n, g, w, lam, mus, p)
      else
        mus(:n) = 0.0_wp
        call add_general(q <= CHUNK, nall, n, g, w, c, p)
      end if
      call add_symmetric(q <= CHUNK, nall, n, g, w, tau, mus, s)
      n = 0
    end do
    if (ok) then
      r = transpose(f)
      call fold(nall, associated(material%moduli), p, s, k)
    else
      r = 0.0_wp
      k = 0.0_wp
    end if
  end subroutine integrate

  !> Compute gradients, volume, stress and tangent at one point.
  pure subroutine evaluate_point(basis, material, prop, q, xu, a, centre, jac0, &
                                 g, w, tau, lam, mus, c, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    integer, intent(in) :: q
    real(wp), intent(in) :: xu(6, basis%nen), a(3, basis%nmode), centre(3, 3), jac0
    real(wp), intent(out) :: g(basis%nen + basis%nmode, 3)
    real(wp), intent(out) :: w, tau(6), lam, mus, c(6, 6)
    logical, intent(out) :: ok

    real(wp) :: dg(3, 3), t(3, 3), back(3, 3), jac, det, m(3, basis%nmode)
    integer :: j

    call deform(basis%nen, basis%nmode, basis%dshp(:, :, q), basis%mode(:, :, q), xu, a, &
                centre, jac0, dg, t, jac, m, ok)
    if (.not. ok) return
    w = basis%wgt(q)*jac
    if (associated(material%moduli)) then
      call material%moduli(prop, dg, tau, lam, mus, ok)
    else
      call material%stress(prop, dg, tau, c, ok)
    end if
    if (.not. ok) return
    if (material%finite) then
      call invert_map(dg, back, det, ok)
      if (.not. ok) return
      t = matmul(t, back)
      m = matmul(transpose(back), m)
    end if
    do j = 1, 3
      g(:basis%nen, j) = t(1, j)*basis%dshp(1, :, q) + t(2, j)*basis%dshp(2, :, q) &
                         + t(3, j)*basis%dshp(3, :, q)
      g(basis%nen + 1:, j) = m(j, :)
    end do
  end subroutine evaluate_point

  !> Add r_a = sum_q w tau g_a.
  pure subroutine add_residual(first, n, nq, g, w, tau, r)
    logical, intent(in) :: first !! set the sums instead of adding to them
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(n, 3, nq), w(nq), tau(6, nq)
    real(wp), intent(inout) :: r(n, 3)

    real(wp) :: t(3, nq, 3) ! w tau, one column of tau after the other
    integer :: q

    do q = 1, nq
      t(:, q, 1) = w(q)*tau([1, 4, 6], q)
      t(:, q, 2) = w(q)*tau([4, 2, 5], q)
      t(:, q, 3) = w(q)*tau([6, 5, 3], q)
    end do
    call dgemm('N', 'N', n, 3, 3*nq, 1.0_wp, g, n, t, 3*nq, merge(0.0_wp, 1.0_wp, first), r, n)
  end subroutine add_residual

end module solid_form
