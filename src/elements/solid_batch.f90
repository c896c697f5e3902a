!> Residual and tangent of NB eight-node elements at a time, side by side in the vector registers.
!!
!! The formulas are those of solid_form; the first index of every array is the element. The body of
!! each loop over the elements is straight-line code or a single inner loop, so that the compiler
!! vectorises the loop over the elements. Points are processed in groups of at most NC, so that the
!! gradients of a group stay in the first-level cache.
module solid_batch
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use element_type, only: form_report_t, NB
  use material_type, only: material_t
  use solid_batch_algebra, only: set_map, invert, scale_group, set_column, set_force, symmetrise, &
                                 clear_failed, NEN, NM, NC
  use solid_batch_condense, only: advance_batch, condense_batch
  implicit none
  private
  public :: form_batch

contains

  !> Compute residual and tangent of NB elements; the interface is element_batch_i. The law must
  !! have `moduli`.
  pure subroutine form_batch(basis, material, prop, xr, u, du, scale, h_old, h_new, r, k, report)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(:, :, :)
    real(wp), intent(in) :: u(:, :, :)
    real(wp), intent(in) :: du(:, :, :)
    real(wp), intent(in) :: scale
    real(wp), intent(in) :: h_old(:, :)
    real(wp), intent(out) :: h_new(:, :)
    real(wp), intent(out) :: r(:, :, :)
    real(wp), intent(out) :: k(:, :, :, :, :)
    type(form_report_t), intent(out) :: report(NB)

    real(wp) :: a(NB, 3, NM), ra(NB, 3, NM), kua(NB, 3, 3, NEN, NM), kaa(NB, 3, 3, NM, NM)
    logical :: ok(NB)

    if (basis%nmode == 0) then
      a = 0.0_wp
      call integrate(basis, material, prop, xr, u, a, r, k, ra, kua, kaa, ok)
      report%ok = ok
    else
      call advance_batch(h_old, du, scale, a)
      call integrate(basis, material, prop, xr, u, a, r, k, ra, kua, kaa, ok)
      report%ok = ok
      call condense_batch(a, ra, kua, kaa, r, k, h_new, report)
    end if
    if (.not. all(report%ok)) call clear_failed(report%ok, r, k)
  end subroutine form_batch

  !> Sum the contributions of all points; of k and kaa, only the upper triangle of blocks is
  !! computed.
  pure subroutine integrate(basis, material, prop, xr, u, a, r, k, ra, kua, kaa, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(NB, 3, NEN), u(NB, 3, NEN), a(NB, 3, NM)
    real(wp), intent(out) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)
    real(wp), intent(out) :: ra(NB, 3, NM), kua(NB, 3, 3, NEN, NM), kaa(NB, 3, 3, NM, NM)
    logical, intent(out) :: ok(NB)

    real(wp) :: g(NB, 3, NC, NEN), gm(NB, 3, NC, NM)   ! gradients of functions and modes
    real(wp) :: w(NB, NC), tau(NB, 6, NC), lam(NB, NC), mus(NB, NC), y(NB, 6, NC)
    real(wp) :: centre(NB, 3, 3), jac0(NB)
    integer :: q, q0, n

    ok = .true.
    if (basis%nmode > 0) then
      call set_map(basis%dshp0, xr, centre)
      call invert(centre, jac0, ok)
    end if
    do q0 = 0, basis%nq - 1, NC
      n = min(NC, basis%nq - q0)
      do q = 1, n
        call evaluate_point(basis, material, prop, q0 + q, xr, u, a, centre, jac0, q, &
                            g, gm, w(:, q), tau(:, :, q), lam(:, q), mus(:, q), ok)
      end do
      if (n < NC) then ! the last group may be short: missing points get zero weight
        g(:, :, n + 1:, :) = 0.0_wp
        gm(:, :, n + 1:, :) = 0.0_wp
        w(:, n + 1:) = 0.0_wp
        tau(:, :, n + 1:) = 0.0_wp
        lam(:, n + 1:) = 0.0_wp
        mus(:, n + 1:) = 0.0_wp
      end if
      call scale_group(material%finite, w, tau, lam, mus, y)
      if (q0 == 0) then
        call set_sums(basis%nmode, g, gm, tau, lam, mus, y, r, k, ra, kua, kaa)
      else
        call add_sums(basis%nmode, g, gm, tau, lam, mus, y, r, k, ra, kua, kaa)
      end if
    end do
  end subroutine integrate

  !> Set the sums to the contributions of the first group.
  pure subroutine set_sums(nmode, g, gm, tau, lam, mus, y, r, k, ra, kua, kaa)
    integer, intent(in) :: nmode
    real(wp), intent(in) :: g(NB, 3, NC, NEN), gm(NB, 3, NC, NM)
    real(wp), intent(in) :: tau(NB, 6, NC), lam(NB, NC), mus(NB, NC), y(NB, 6, NC)
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)
    real(wp), intent(inout) :: ra(NB, 3, NM), kua(NB, 3, 3, NEN, NM), kaa(NB, 3, 3, NM, NM)

    integer :: b

    call set_force(NEN, g, tau, r)
    do b = 1, NEN
      call set_column(b, g, g(:, :, :, b), y, lam, mus, k(:, :, :, :, b))
      call symmetrise(k(:, :, :, b, b))
    end do
    if (nmode == 0) return
    call set_force(NM, gm, tau, ra)
    do b = 1, NM
      call set_column(NEN, g, gm(:, :, :, b), y, lam, mus, kua(:, :, :, :, b))
      call set_column(b, gm, gm(:, :, :, b), y, lam, mus, kaa(:, :, :, :, b))
    end do
  end subroutine set_sums

  !> Add the contributions of a further group, for rules with more than NC points.
  pure subroutine add_sums(nmode, g, gm, tau, lam, mus, y, r, k, ra, kua, kaa)
    integer, intent(in) :: nmode
    real(wp), intent(in) :: g(NB, 3, NC, NEN), gm(NB, 3, NC, NM)
    real(wp), intent(in) :: tau(NB, 6, NC), lam(NB, NC), mus(NB, NC), y(NB, 6, NC)
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)
    real(wp), intent(inout) :: ra(NB, 3, NM), kua(NB, 3, 3, NEN, NM), kaa(NB, 3, 3, NM, NM)

    real(wp) :: f(NB, 3, NEN), column(NB, 3, 3, NEN)
    integer :: b

    call set_force(NEN, g, tau, f)
    r = r + f
    do b = 1, NEN
      call set_column(b, g, g(:, :, :, b), y, lam, mus, column)
      k(:, :, :, :b, b) = k(:, :, :, :b, b) + column(:, :, :, :b)
      call symmetrise(k(:, :, :, b, b))
    end do
    if (nmode == 0) return
    call set_force(NM, gm, tau, f)
    ra = ra + f(:, :, :NM)
    do b = 1, NM
      call set_column(NEN, g, gm(:, :, :, b), y, lam, mus, column)
      kua(:, :, :, :, b) = kua(:, :, :, :, b) + column
      call set_column(b, gm, gm(:, :, :, b), y, lam, mus, column)
      kaa(:, :, :, :b, b) = kaa(:, :, :, :b, b) + column(:, :, :, :b)
    end do
  end subroutine add_sums

  !> Compute gradients, volume, stress and moduli at one point of each element.
  pure subroutine evaluate_point(basis, material, prop, q, xr, u, a, centre, jac0, n, &
                                 g, gm, w, tau, lam, mus, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    integer, intent(in) :: q !! index of the point in the rule
    real(wp), intent(in) :: xr(NB, 3, NEN), u(NB, 3, NEN), a(NB, 3, NM), centre(NB, 3, 3), jac0(NB)
    integer, intent(in) :: n !! index of the point in the group
    real(wp), intent(inout) :: g(NB, 3, NC, NEN), gm(NB, 3, NC, NM)
    real(wp), intent(out) :: w(NB), tau(NB, 6), lam(NB), mus(NB)
    logical, intent(inout) :: ok(NB)

    real(wp) :: t(NB, 3, 3), h(NB, 3, 3), dg(NB, 3, 3), m(NB, 3, NM), jac(NB), det(NB)
    logical :: fine(NB)
    integer :: j, l

    call set_map(basis%dshp(:, :, q), xr, t)
    call invert(t, jac, ok)
    call set_map(basis%dshp(:, :, q), u, dg)
    call multiply(dg, t, h)
    if (basis%nmode > 0) call enhance(basis, q, centre, jac0, jac, a, m, h)
    if (associated(material%moduli_batch)) then
      call material%moduli_batch(prop, h, tau, lam, mus, fine)
    else
      do l = 1, NB
        call material%moduli(prop, h(l, :, :), tau(l, :), lam(l), mus(l), fine(l))
      end do
    end if
    ok = ok .and. fine
    w = basis%wgt(q)*jac
    if (material%finite) then
      dg = h
      do j = 1, 3
        dg(:, j, j) = dg(:, j, j) + 1.0_wp
      end do
      call invert(dg, det, ok)
      h = t
      call multiply(h, dg, t)
    end if
    call set_gradients(basis, material%finite, q, n, t, dg, m, g, gm)
  end subroutine evaluate_point

  !> Compute c = a b.
  pure subroutine multiply(a, b, c)
    real(wp), intent(in) :: a(NB, 3, 3), b(NB, 3, 3)
    real(wp), intent(out) :: c(NB, 3, 3)

    integer :: j, l

    do j = 1, 3
      !$omp simd
      do l = 1, NB
        c(l, 1, j) = a(l, 1, 1)*b(l, 1, j) + a(l, 1, 2)*b(l, 2, j) + a(l, 1, 3)*b(l, 3, j)
        c(l, 2, j) = a(l, 2, 1)*b(l, 1, j) + a(l, 2, 2)*b(l, 2, j) + a(l, 2, 3)*b(l, 3, j)
        c(l, 3, j) = a(l, 3, 1)*b(l, 1, j) + a(l, 3, 2)*b(l, 2, j) + a(l, 3, 3)*b(l, 3, j)
      end do
    end do
  end subroutine multiply

  !> Compute the covectors of the modes at a point, and add the contribution of the modes to the
  !! displacement gradient.
  pure subroutine enhance(basis, q, centre, jac0, jac, a, m, h)
    type(basis_t), intent(in) :: basis
    integer, intent(in) :: q
    real(wp), intent(in) :: centre(NB, 3, 3), jac0(NB), jac(NB), a(NB, 3, NM)
    real(wp), intent(out) :: m(NB, 3, NM)
    real(wp), intent(inout) :: h(NB, 3, 3)

    integer :: b, j, l

    do b = 1, basis%nmode
      do j = 1, 3
        !$omp simd
        do l = 1, NB
          m(l, j, b) = (jac0(l)/jac(l))*(centre(l, 1, j)*basis%mode(1, b, q) &
                                         + centre(l, 2, j)*basis%mode(2, b, q) &
                                         + centre(l, 3, j)*basis%mode(3, b, q))
          h(l, 1, j) = h(l, 1, j) + a(l, 1, b)*m(l, j, b)
          h(l, 2, j) = h(l, 2, j) + a(l, 2, b)*m(l, j, b)
          h(l, 3, j) = h(l, 3, j) + a(l, 3, b)*m(l, j, b)
        end do
      end do
    end do
  end subroutine enhance

  !> Compute the gradients of functions and modes, in the configuration to which the stress refers.
  pure subroutine set_gradients(basis, finite, q, n, t, dg, m, g, gm)
    type(basis_t), intent(in) :: basis
    logical, intent(in) :: finite
    integer, intent(in) :: q, n
    real(wp), intent(in) :: t(NB, 3, 3), dg(NB, 3, 3), m(NB, 3, NM)
    real(wp), intent(inout) :: g(NB, 3, NC, NEN), gm(NB, 3, NC, NM)

    integer :: b, i, l

    do b = 1, NEN
      do i = 1, 3
        !$omp simd
        do l = 1, NB
          g(l, i, n, b) = t(l, 1, i)*basis%dshp(1, b, q) + t(l, 2, i)*basis%dshp(2, b, q) &
                          + t(l, 3, i)*basis%dshp(3, b, q)
        end do
      end do
    end do
    do b = 1, basis%nmode
      do i = 1, 3
        if (finite) then
          !$omp simd
          do l = 1, NB
            gm(l, i, n, b) = dg(l, 1, i)*m(l, 1, b) + dg(l, 2, i)*m(l, 2, b) &
                             + dg(l, 3, i)*m(l, 3, b)
          end do
        else
          gm(:, i, n, b) = m(:, i, b)
        end if
      end do
    end do
  end subroutine set_gradients

end module solid_batch
