!> Sums over points and condensation for NB elements side by side; see solid_batch.
module solid_batch_algebra
  use base_kinds, only: wp
  use element_type, only: form_report_t, NB
  implicit none
  private
  public :: advance_batch, condense_batch, set_column, set_force, mirror
  public :: scale_group, clear_failed

  integer, parameter, public :: NEN = 8 !! nodes
  integer, parameter, public :: NM = 3  !! enhanced modes, if any
  integer, parameter, public :: NC = 8  !! points in a group; a constant, or the loops would not become vectors
  integer, parameter :: NP = 3*NM       !! enhanced parameters
  integer, parameter :: ND = 3*NEN      !! dofs of the nodes

contains

  !> Weights into stress and moduli: x = w tau, y = w (tau + mus 1), lam = w lam, mus = w mus.
  pure subroutine scale_group(finite, w, tau, lam, mus, y)
    logical, intent(in) :: finite !! .false.: no geometric part in y
    real(wp), intent(in) :: w(NB, NC)
    real(wp), intent(inout) :: tau(NB, 6, NC), lam(NB, NC), mus(NB, NC)
    real(wp), intent(out) :: y(NB, 6, NC)

    real(wp) :: keep
    integer :: q, i, l

    keep = merge(1.0_wp, 0.0_wp, finite)
    do q = 1, NC
      !$omp simd
      do l = 1, NB
        lam(l, q) = w(l, q)*lam(l, q)
        mus(l, q) = w(l, q)*mus(l, q)
      end do
      do i = 1, 6
        !$omp simd
        do l = 1, NB
          tau(l, i, q) = w(l, q)*tau(l, i, q)
          y(l, i, q) = keep*tau(l, i, q)
        end do
      end do
      do i = 1, 3
        !$omp simd
        do l = 1, NB
          y(l, i, q) = y(l, i, q) + mus(l, q)
        end do
      end do
    end do
  end subroutine scale_group

  !> Blocks (a, b), a = 1 to n, of one function b:
  !! sum_q (g_a . y g_b) 1 + lam g_a x g_b + mus g_b x g_a, weights in y, lam and mus.
  pure subroutine set_column(n, g, gb, y, lam, mus, k)
    integer, intent(in) :: n
    real(wp), intent(in) :: g(NB, 3, NC, n), gb(NB, 3, NC)
    real(wp), intent(in) :: y(NB, 6, NC), lam(NB, NC), mus(NB, NC)
    real(wp), intent(out) :: k(NB, 3, 3, n)

    real(wp), dimension(NB, 3, NC) :: t, gl, gm, gs
    real(wp) :: s1, s2, s3, k11, k21, k31, k12, k22, k32, k13, k23, k33
    integer :: a, q, l

    do q = 1, NC
      !$omp simd
      do l = 1, NB
        gl(l, 1, q) = lam(l, q)*gb(l, 1, q)
        gl(l, 2, q) = lam(l, q)*gb(l, 2, q)
        gl(l, 3, q) = lam(l, q)*gb(l, 3, q)
        gm(l, 1, q) = mus(l, q)*gb(l, 1, q)
        gm(l, 2, q) = mus(l, q)*gb(l, 2, q)
        gm(l, 3, q) = mus(l, q)*gb(l, 3, q)
        gs(l, 1, q) = gl(l, 1, q) + gm(l, 1, q)
        gs(l, 2, q) = gl(l, 2, q) + gm(l, 2, q)
        gs(l, 3, q) = gl(l, 3, q) + gm(l, 3, q)
        t(l, 1, q) = y(l, 1, q)*gb(l, 1, q) + y(l, 4, q)*gb(l, 2, q) + y(l, 6, q)*gb(l, 3, q)
        t(l, 2, q) = y(l, 4, q)*gb(l, 1, q) + y(l, 2, q)*gb(l, 2, q) + y(l, 5, q)*gb(l, 3, q)
        t(l, 3, q) = y(l, 6, q)*gb(l, 1, q) + y(l, 5, q)*gb(l, 2, q) + y(l, 3, q)*gb(l, 3, q)
      end do
    end do
    do a = 1, n
      !$omp simd private(s1, s2, s3, k11, k21, k31, k12, k22, k32, k13, k23, k33)
      do l = 1, NB
        s1 = 0.0_wp
        s2 = 0.0_wp
        s3 = 0.0_wp
        k11 = 0.0_wp
        k21 = 0.0_wp
        k31 = 0.0_wp
        k12 = 0.0_wp
        k22 = 0.0_wp
        k32 = 0.0_wp
        k13 = 0.0_wp
        k23 = 0.0_wp
        k33 = 0.0_wp
        do q = 1, NC ! many sums side by side: short chains of dependent additions
          s1 = s1 + g(l, 1, q, a)*t(l, 1, q)
          s2 = s2 + g(l, 2, q, a)*t(l, 2, q)
          s3 = s3 + g(l, 3, q, a)*t(l, 3, q)
          k11 = k11 + g(l, 1, q, a)*gs(l, 1, q)
          k22 = k22 + g(l, 2, q, a)*gs(l, 2, q)
          k33 = k33 + g(l, 3, q, a)*gs(l, 3, q)
          k12 = k12 + g(l, 1, q, a)*gl(l, 2, q) + g(l, 2, q, a)*gm(l, 1, q)
          k21 = k21 + g(l, 2, q, a)*gl(l, 1, q) + g(l, 1, q, a)*gm(l, 2, q)
          k13 = k13 + g(l, 1, q, a)*gl(l, 3, q) + g(l, 3, q, a)*gm(l, 1, q)
          k31 = k31 + g(l, 3, q, a)*gl(l, 1, q) + g(l, 1, q, a)*gm(l, 3, q)
          k23 = k23 + g(l, 2, q, a)*gl(l, 3, q) + g(l, 3, q, a)*gm(l, 2, q)
          k32 = k32 + g(l, 3, q, a)*gl(l, 2, q) + g(l, 2, q, a)*gm(l, 3, q)
        end do
        s1 = s1 + s2 + s3
        k(l, 1, 1, a) = k11 + s1
        k(l, 2, 1, a) = k21
        k(l, 3, 1, a) = k31
        k(l, 1, 2, a) = k12
        k(l, 2, 2, a) = k22 + s1
        k(l, 3, 2, a) = k32
        k(l, 1, 3, a) = k13
        k(l, 2, 3, a) = k23
        k(l, 3, 3, a) = k33 + s1
      end do
    end do
  end subroutine set_column

  !> r_a = sum_q x g_a of n functions, x = w tau.
  pure subroutine set_force(n, g, x, r)
    integer, intent(in) :: n
    real(wp), intent(in) :: g(NB, 3, NC, n), x(NB, 6, NC)
    real(wp), intent(out) :: r(NB, 3, n)

    real(wp) :: r1, r2, r3
    integer :: a, q, l

    do a = 1, n
      !$omp simd private(r1, r2, r3)
      do l = 1, NB
        r1 = 0.0_wp
        r2 = 0.0_wp
        r3 = 0.0_wp
        do q = 1, NC
          r1 = r1 + (x(l, 1, q)*g(l, 1, q, a) + x(l, 4, q)*g(l, 2, q, a) + x(l, 6, q)*g(l, 3, q, a))
          r2 = r2 + (x(l, 4, q)*g(l, 1, q, a) + x(l, 2, q)*g(l, 2, q, a) + x(l, 5, q)*g(l, 3, q, a))
          r3 = r3 + (x(l, 6, q)*g(l, 1, q, a) + x(l, 5, q)*g(l, 2, q, a) + x(l, 3, q)*g(l, 3, q, a))
        end do
        r(l, 1, a) = r1
        r(l, 2, a) = r2
        r(l, 3, a) = r3
      end do
    end do
  end subroutine set_force

  !> Enhanced parameters after the nodes moved by du: a - scale m - L du.
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

  !> Eliminate the enhanced parameters as `condense` does, upper blocks only.
  pure subroutine condense_batch(a, ra, kua, kaa, r, k, h_new, report)
    real(wp), intent(in) :: a(NB, NP), ra(NB, NP)
    real(wp), intent(in) :: kua(NB, 3, 3, NEN, NM) !! node direction, mode direction, node, mode
    real(wp), intent(in) :: kaa(NB, 3, 3, NM, NM)      !! upper blocks
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)
    real(wp), intent(out) :: h_new(:, :) !! (history, NB)
    type(form_report_t), intent(inout) :: report(NB)

    ! Right-hand sides in threes: K_au of each node, and last r_a with two empty ones.
    real(wp) :: y(NB, NP, 3, NEN + 1), x(NB, NP, 3, NEN + 1)
    real(wp) :: f(NB, NP, NP), s(NB, NP)
    logical :: ok(NB)
    integer :: i, j, b, n, l, p

    do n = 1, NM
      do b = 1, n
        do j = 1, 3
          do i = 1, 3
            f(:, 3*n - 3 + j, 3*b - 3 + i) = kaa(:, i, j, b, n)
          end do
        end do
      end do
    end do
    ok = report%ok
    call factor_batch(f, s, report%negative, ok)
    report%ok = ok
    do n = 1, NM
      do j = 1, 3
        y(:, 3*n - 3 + j, :, :NEN) = kua(:, :, j, :, n)
      end do
    end do
    y(:, :, :, NEN + 1) = 0.0_wp
    y(:, :, 1, NEN + 1) = ra
    do b = 1, NEN + 1
      call solve_batch(f, s, y(:, :, :, b), x(:, :, :, b))
    end do
    do l = 1, NB
      report(l)%enhanced = abs(dot_product(x(l, :, 1, NEN + 1), ra(l, :)))
    end do
    call subtract(y, x, x(:, :, 1, NEN + 1), r, k)
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
  end subroutine condense_batch

  !> Factors L D L^T without pivoting, as ldl_factor; s holds 1/D.
  pure subroutine factor_batch(f, s, negative, ok)
    real(wp), intent(inout) :: f(NB, NP, NP) !! lower triangle; out: unit lower factor
    real(wp), intent(out) :: s(NB, NP)
    integer, intent(out) :: negative(NB)
    logical, intent(inout) :: ok(NB)

    real(wp) :: size_of(NB, NP), v(NB)
    logical :: lost(NB)
    integer :: i, j, p, l

    negative = 0
    do j = 1, NP
      size_of(:, j) = abs(f(:, j, j))
    end do
    do j = 1, NP
      lost = .not. abs(f(:, j, j)) > NP*epsilon(1.0_wp)*size_of(:, j)
      if (any(lost)) then
        ok = ok .and. .not. lost
        where (lost) f(:, j, j) = 1.0_wp ! harmless: the element is refused
      end if
      where (f(:, j, j) < 0.0_wp) negative = negative + 1
      s(:, j) = 1.0_wp/f(:, j, j)
      do i = j + 1, NP
        v = f(:, i, j)*s(:, j)
        do p = i, NP
          !$omp simd
          do l = 1, NB
            f(l, p, i) = f(l, p, i) - v(l)*f(l, p, j)
          end do
        end do
      end do
      do i = j + 1, NP
        f(:, i, j) = f(:, i, j)*s(:, j)
      end do
    end do
  end subroutine factor_batch

  !> x = K_aa^-1 y for three right-hand sides, with the factors of factor_batch.
  pure subroutine solve_batch(f, s, y, x)
    real(wp), intent(in) :: f(NB, NP, NP), s(NB, NP), y(NB, NP, 3)
    real(wp), intent(out) :: x(NB, NP, 3)

    real(wp) :: v1, v2, v3
    integer :: i, j, l

    do j = 1, NP
      !$omp simd private(v1, v2, v3)
      do l = 1, NB
        v1 = y(l, j, 1)
        v2 = y(l, j, 2)
        v3 = y(l, j, 3)
        do i = 1, j - 1
          v1 = v1 - f(l, j, i)*x(l, i, 1)
          v2 = v2 - f(l, j, i)*x(l, i, 2)
          v3 = v3 - f(l, j, i)*x(l, i, 3)
        end do
        x(l, j, 1) = v1
        x(l, j, 2) = v2
        x(l, j, 3) = v3
      end do
    end do
    do j = NP, 1, -1
      !$omp simd private(v1, v2, v3)
      do l = 1, NB
        v1 = x(l, j, 1)*s(l, j)
        v2 = x(l, j, 2)*s(l, j)
        v3 = x(l, j, 3)*s(l, j)
        do i = j + 1, NP
          v1 = v1 - f(l, i, j)*x(l, i, 1)
          v2 = v2 - f(l, i, j)*x(l, i, 2)
          v3 = v3 - f(l, i, j)*x(l, i, 3)
        end do
        x(l, j, 1) = v1
        x(l, j, 2) = v2
        x(l, j, 3) = v3
      end do
    end do
  end subroutine solve_batch

  !> r - K_ua m and the upper blocks of K - K_ua L.
  pure subroutine subtract(y, x, m, r, k)
    real(wp), intent(in) :: y(NB, NP, 3, NEN + 1) !! K_au
    real(wp), intent(in) :: x(NB, NP, 3, NEN + 1) !! L
    real(wp), intent(in) :: m(NB, NP)
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)

    real(wp) :: k11, k21, k31, k12, k22, k32, k13, k23, k33
    integer :: a, b, p, l

    do a = 1, NEN
      !$omp simd private(k11, k21, k31)
      do l = 1, NB
        k11 = r(l, 1, a)
        k21 = r(l, 2, a)
        k31 = r(l, 3, a)
        do p = 1, NP
          k11 = k11 - y(l, p, 1, a)*m(l, p)
          k21 = k21 - y(l, p, 2, a)*m(l, p)
          k31 = k31 - y(l, p, 3, a)*m(l, p)
        end do
        r(l, 1, a) = k11
        r(l, 2, a) = k21
        r(l, 3, a) = k31
      end do
    end do
    do b = 1, NEN
      do a = 1, b
        !$omp simd private(k11, k21, k31, k12, k22, k32, k13, k23, k33)
        do l = 1, NB
          k11 = k(l, 1, 1, a, b)
          k21 = k(l, 2, 1, a, b)
          k31 = k(l, 3, 1, a, b)
          k12 = k(l, 1, 2, a, b)
          k22 = k(l, 2, 2, a, b)
          k32 = k(l, 3, 2, a, b)
          k13 = k(l, 1, 3, a, b)
          k23 = k(l, 2, 3, a, b)
          k33 = k(l, 3, 3, a, b)
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
          k(l, 1, 1, a, b) = k11
          k(l, 2, 1, a, b) = k21
          k(l, 3, 1, a, b) = k31
          k(l, 1, 2, a, b) = k12
          k(l, 2, 2, a, b) = k22
          k(l, 3, 2, a, b) = k32
          k(l, 1, 3, a, b) = k13
          k(l, 2, 3, a, b) = k23
          k(l, 3, 3, a, b) = k33
        end do
      end do
      call mirror(b, k)
    end do
  end subroutine subtract

  !> Row b from column b, which is still in the cache: K_ba is the transpose of K_ab.
  pure subroutine mirror(b, k)
    integer, intent(in) :: b
    real(wp), intent(inout) :: k(NB, 3, 3, NEN, NEN)

    integer :: a, l

    do a = 1, b - 1
      !$omp simd
      do l = 1, NB
        k(l, 1, 1, b, a) = k(l, 1, 1, a, b)
        k(l, 2, 1, b, a) = k(l, 1, 2, a, b)
        k(l, 3, 1, b, a) = k(l, 1, 3, a, b)
        k(l, 1, 2, b, a) = k(l, 2, 1, a, b)
        k(l, 2, 2, b, a) = k(l, 2, 2, a, b)
        k(l, 3, 2, b, a) = k(l, 2, 3, a, b)
        k(l, 1, 3, b, a) = k(l, 3, 1, a, b)
        k(l, 2, 3, b, a) = k(l, 3, 2, a, b)
        k(l, 3, 3, b, a) = k(l, 3, 3, a, b)
      end do
    end do
    !$omp simd
    do l = 1, NB ! to the last bit
      k(l, 2, 1, b, b) = k(l, 1, 2, b, b)
      k(l, 3, 1, b, b) = k(l, 1, 3, b, b)
      k(l, 3, 2, b, b) = k(l, 2, 3, b, b)
    end do
  end subroutine mirror

  !> Nothing but zeros for elements that are not ok.
  pure subroutine clear_failed(ok, r, k)
    logical, intent(in) :: ok(NB)
    real(wp), intent(inout) :: r(NB, 3, NEN), k(NB, 3, 3, NEN, NEN)

    integer :: l

    do l = 1, NB
      if (ok(l)) cycle
      r(l, :, :) = 0.0_wp
      k(l, :, :, :, :) = 0.0_wp
    end do
  end subroutine clear_failed

end module solid_batch_algebra
