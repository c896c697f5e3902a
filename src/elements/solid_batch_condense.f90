!> Elimination of the enhanced parameters of NB elements side by side, as in solid_condense.
module solid_batch_condense
  use base_kinds, only: wp
  use element_type, only: form_report_t, NB
  use solid_batch_algebra, only: symmetrise, NEN, NM
  implicit none
  private
  public :: advance_batch, condense_batch

  integer, parameter :: NP = 3*NM  !! enhanced parameters
  integer, parameter :: ND = 3*NEN !! dofs of the nodes

contains

  !> Update the enhanced parameters after the nodes have moved by du: a - scale m - L du.
  pure subroutine advance_batch(h, du, scale, a)
    real(wp), intent(in) :: h(:, :) !! (history, NB)
    real(wp), intent(in) :: du(NB, ND), scale
    real(wp), intent(out) :: a(NB, NP)

    real(wp) :: s(NP)
    integer :: l, j

    do l = 1, NB
      s = h(:NP, l) - scale*h(NP + 1:2*NP, l)
      do j = 1, ND
        s = s - h(NP*(j + 1) + 1:NP*(j + 2), l)*du(l, j)
      end do
      a(l, :) = s
    end do
  end subroutine advance_batch

  !> Eliminate the enhanced parameters as `condense` does, but in the upper blocks of k and kaa
  !! only.
  pure subroutine condense_batch(a, ra, kua, kaa, r, k, h_new, report)
    real(wp), intent(in) :: a(NB, NP), ra(NB, NP)
    real(wp), intent(in) :: kua(NB, 3, 3, NEN, NM) !! node direction, mode direction, node, mode
    real(wp), intent(in) :: kaa(NB, 3, 3, NM, NM)      !! upper blocks
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)
    real(wp), intent(out) :: h_new(:, :) !! (history, NB)
    type(form_report_t), intent(inout) :: report(NB)

    ! Right-hand sides in groups of three: one group for K_au of each node, and a last one with r_a
    ! and two columns of zeros.
    real(wp) :: y(NB, NP, 3, NEN + 1), x(NB, NP, 3, NEN + 1)
    real(wp) :: f(NB, NP, NP)
    logical :: ok(NB)
    integer :: i, j, b, n, l

    do n = 1, NM
      do b = 1, n
        do j = 1, 3
          do i = 1, 3
            f(:, 3*n - 3 + j, 3*b - 3 + i) = kaa(:, i, j, b, n)
            f(:, 3*b - 3 + i, 3*n - 3 + j) = kaa(:, i, j, b, n)
          end do
        end do
      end do
    end do
    ok = report%ok
    call invert_block(f, report%negative, ok)
    report%ok = ok
    do n = 1, NM
      do j = 1, 3
        y(:, 3*n - 3 + j, :, :NEN) = kua(:, :, j, :, n)
      end do
    end do
    y(:, :, :, NEN + 1) = 0.0_wp
    y(:, :, 1, NEN + 1) = ra
    do b = 1, NEN + 1
      call multiply(f, y(:, :, :, b), x(:, :, :, b))
    end do
    do l = 1, NB
      report(l)%enhanced = abs(dot_product(x(l, :, 1, NEN + 1), ra(l, :)))
    end do
    call subtract_forces(y, x(:, :, 1, NEN + 1), r)
    call subtract_blocks(y, x, k)
    call keep_history(a, x, h_new)
  end subroutine condense_batch

  !> Write the history that advance_batch reads: a, m and L.
  pure subroutine keep_history(a, x, h_new)
    real(wp), intent(in) :: a(NB, NP)
    real(wp), intent(in) :: x(NB, NP, 3, NEN + 1) !! L, and m in the last group
    real(wp), intent(out) :: h_new(:, :) !! (history, NB)

    integer :: i, b, l, p

    do l = 1, NB
      h_new(:NP, l) = a(l, :)
      h_new(NP + 1:2*NP, l) = x(l, :, 1, NEN + 1)
      do b = 1, NEN
        do i = 1, 3
          p = NP*(3*b + i - 2)
          h_new(p + 1:p + NP, l) = x(l, :, i, b)
        end do
      end do
    end do
  end subroutine keep_history

  !> Invert by Gauss-Jordan elimination without pivoting; its pivots are the D of L D L^T
  !! (ldl_factor). A factorisation would need loops of varying length, which are not vectorised.
  pure subroutine invert_block(f, negative, ok)
    real(wp), intent(inout) :: f(NB, NP, NP)
    integer, intent(out) :: negative(NB)
    logical, intent(inout) :: ok(NB)

    real(wp) :: scale(NB, NP), g(NB, NP), c(NB)
    logical :: lost(NB)
    integer :: i, j, k, l

    negative = 0
    do j = 1, NP
      scale(:, j) = abs(f(:, j, j))
    end do
    do j = 1, NP
      lost = .not. abs(f(:, j, j)) > NP*epsilon(1.0_wp)*scale(:, j)
      if (any(lost)) then
        ok = ok .and. .not. lost
        where (lost) f(:, j, j) = 1.0_wp ! harmless, because the element is rejected
      end if
      where (f(:, j, j) < 0.0_wp) negative = negative + 1
      c = 1.0_wp/f(:, j, j)
      do i = 1, NP
        g(:, i) = f(:, i, j)*c
      end do
      g(:, j) = -c
      do k = 1, NP
        if (k == j) cycle
        c = f(:, j, k)
        f(:, j, k) = 0.0_wp
        do i = 1, NP
          !$omp simd
          do l = 1, NB
            f(l, i, k) = f(l, i, k) - g(l, i)*c(l)
          end do
        end do
      end do
      f(:, :, j) = -g
    end do
  end subroutine invert_block

  !> Compute x = K_aa^-1 y for three right-hand sides.
  pure subroutine multiply(f, y, x)
    real(wp), intent(in) :: f(NB, NP, NP) !! K_aa^-1
    real(wp), intent(in) :: y(NB, NP, 3)
    real(wp), intent(out) :: x(NB, NP, 3)

    real(wp) :: v1, v2, v3
    integer :: i, j, l

    do j = 1, NP
      !$omp simd private(v1, v2, v3)
      do l = 1, NB
        v1 = 0.0_wp
        v2 = 0.0_wp
        v3 = 0.0_wp
        do i = 1, NP
          v1 = v1 + f(l, i, j)*y(l, i, 1)
          v2 = v2 + f(l, i, j)*y(l, i, 2)
          v3 = v3 + f(l, i, j)*y(l, i, 3)
        end do
        x(l, j, 1) = v1
        x(l, j, 2) = v2
        x(l, j, 3) = v3
      end do
    end do
  end subroutine multiply

  !> Compute r - K_ua m.
  pure subroutine subtract_forces(y, m, r)
    real(wp), intent(in) :: y(NB, NP, 3, NEN + 1) !! K_au
    real(wp), intent(in) :: m(NB, NP)
    real(wp), intent(inout) :: r(NB, 3, NEN)

    real(wp) :: r1, r2, r3
    integer :: a, p, l

    do a = 1, NEN
      !$omp simd private(r1, r2, r3)
      do l = 1, NB
        r1 = r(l, 1, a)
        r2 = r(l, 2, a)
        r3 = r(l, 3, a)
        do p = 1, NP
          r1 = r1 - y(l, p, 1, a)*m(l, p)
          r2 = r2 - y(l, p, 2, a)*m(l, p)
          r3 = r3 - y(l, p, 3, a)*m(l, p)
        end do
        r(l, 1, a) = r1
        r(l, 2, a) = r2
        r(l, 3, a) = r3
      end do
    end do
  end subroutine subtract_forces

  !> Compute the upper blocks of K - K_ua L. All nine sums of a block are formed in
  !! one loop body, so that they stay in registers.
  pure subroutine subtract_blocks(y, x, k)
    real(wp), intent(in) :: y(NB, NP, 3, NEN + 1) !! K_au
    real(wp), intent(in) :: x(NB, NP, 3, NEN + 1) !! L
    real(wp), intent(inout) :: k(NB, 3, 3, NEN, NEN)

    real(wp) :: k11, k21, k31, k12, k22, k32, k13, k23, k33
    integer :: a, b, p, l

    do b = 1, NEN
      do a = 1, b
        !$omp simd private(k11, k21, k31, k12, k22, k32, k13, k23, k33)
        do l = 1, NB
          k11 = k(l, 1, 1, a, b); k12 = k(l, 1, 2, a, b); k13 = k(l, 1, 3, a, b)
          k21 = k(l, 2, 1, a, b); k22 = k(l, 2, 2, a, b); k23 = k(l, 2, 3, a, b)
          k31 = k(l, 3, 1, a, b); k32 = k(l, 3, 2, a, b); k33 = k(l, 3, 3, a, b)
          do p = 1, NP
            k11 = k11 - y(l, p, 1, a)*x(l, p, 1, b)
            k21 = k21 - y(l, p, 2, a)*x(l, p, 1, b)
            k31 = k31 - y(l, p, 3, a)*x(l, p, 1, b)
            k12 = k12 - y(l, p, 1, a)*x(l, p, 2, b)
            k22 = k22 - y(l, p, 2, a)*x(l, p, 2, b)
            k32 = k32 - y(l, p, 3, a)*x(l, p, 2, b)
            k13 = k13 - y(l, p, 1, a)*x(l, p, 3, b)
            k23 = k23 - y(l, p, 2, a)*x(l, p, 3, b)
            k33 = k33 - y(l, p, 3, a)*x(l, p, 3, b)
          end do
          k(l, 1, 1, a, b) = k11; k(l, 1, 2, a, b) = k12; k(l, 1, 3, a, b) = k13
          k(l, 2, 1, a, b) = k21; k(l, 2, 2, a, b) = k22; k(l, 2, 3, a, b) = k23
          k(l, 3, 1, a, b) = k31; k(l, 3, 2, a, b) = k32; k(l, 3, 3, a, b) = k33
        end do
      end do
      call symmetrise(k(:, :, :, b, b))
    end do
  end subroutine subtract_blocks

end module solid_batch_condense
