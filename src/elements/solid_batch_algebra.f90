!> Maps and sums over points for NB elements side by side; see solid_batch.
module solid_batch_algebra
  use base_kinds, only: wp
  use element_type, only: NB
  implicit none
  private
  public :: set_map, invert, scale_group, set_column, set_force, symmetrise, clear_failed

  integer, parameter, public :: NEN = 8 !! nodes
  integer, parameter, public :: NM = 3  !! enhanced modes, if any
  integer, parameter, public :: NC = 8  !! points in a group; a constant, so that loops vectorise

contains

  !> Multiply stress and moduli by the weights w of the points, and set y = w (tau + mus 1).
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

  !> Compute the blocks (a, b), a = 1 to n, of one function b:
  !! sum_q (g_a . y g_b) 1 + lam g_a x g_b + mus g_b x g_a, with the weights in y, lam and mus. All
  !! nine sums of a block are formed in one loop body, so that they stay in registers.
  pure subroutine set_column(n, g, gb, y, lam, mus, k)
    integer, intent(in) :: n
    real(wp), intent(in) :: g(NB, 3, NC, n), gb(NB, 3, NC)
    real(wp), intent(in) :: y(NB, 6, NC), lam(NB, NC), mus(NB, NC)
    real(wp), intent(out) :: k(NB, 3, 3, n)

    real(wp), dimension(NB, 3, NC) :: t, gl, gm, gs
    real(wp) :: s1, s2, s3, k11, k21, k31, k12, k22, k32, k13, k23, k33
    integer :: a, q, l

    call weigh(gb, y, lam, mus, t, gl, gm, gs)
    do a = 1, n
      !$omp simd private(s1, s2, s3, k11, k21, k31, k12, k22, k32, k13, k23, k33)
      do l = 1, NB
        s1 = 0.0_wp; s2 = 0.0_wp; s3 = 0.0_wp
        k11 = 0.0_wp; k12 = 0.0_wp; k13 = 0.0_wp
        k21 = 0.0_wp; k22 = 0.0_wp; k23 = 0.0_wp
        k31 = 0.0_wp; k32 = 0.0_wp; k33 = 0.0_wp
        do q = 1, NC ! independent sums shorten the chains of dependent additions
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
        k(l, 1, 1, a) = k11 + s1; k(l, 1, 2, a) = k12; k(l, 1, 3, a) = k13
        k(l, 2, 1, a) = k21; k(l, 2, 2, a) = k22 + s1; k(l, 2, 3, a) = k23
        k(l, 3, 1, a) = k31; k(l, 3, 2, a) = k32; k(l, 3, 3, a) = k33 + s1
      end do
    end do
  end subroutine set_column

  !> Compute the products that set_column needs for function b: y g_b, lam g_b, mus g_b, and the sum
  !! of the last two.
  pure subroutine weigh(gb, y, lam, mus, t, gl, gm, gs)
    real(wp), intent(in) :: gb(NB, 3, NC), y(NB, 6, NC), lam(NB, NC), mus(NB, NC)
    real(wp), intent(out), dimension(NB, 3, NC) :: t, gl, gm, gs

    integer :: q, l

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
  end subroutine weigh

  !> Compute r_a = sum_q x g_a for n functions, with x = w tau.
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

  !> Compute map(:, i, j) = sum_a x(:, i, a) dshp(j, a).
  pure subroutine set_map(dshp, x, map)
    real(wp), intent(in) :: dshp(3, NEN), x(NB, 3, NEN)
    real(wp), intent(out) :: map(NB, 3, 3)

    real(wp) :: m11, m21, m31, m12, m22, m32, m13, m23, m33
    integer :: a, l

    !$omp simd private(m11, m21, m31, m12, m22, m32, m13, m23, m33)
    do l = 1, NB
      m11 = 0.0_wp
      m21 = 0.0_wp
      m31 = 0.0_wp
      m12 = 0.0_wp
      m22 = 0.0_wp
      m32 = 0.0_wp
      m13 = 0.0_wp
      m23 = 0.0_wp
      m33 = 0.0_wp
      do a = 1, NEN
        m11 = m11 + x(l, 1, a)*dshp(1, a)
        m21 = m21 + x(l, 2, a)*dshp(1, a)
        m31 = m31 + x(l, 3, a)*dshp(1, a)
        m12 = m12 + x(l, 1, a)*dshp(2, a)
        m22 = m22 + x(l, 2, a)*dshp(2, a)
        m32 = m32 + x(l, 3, a)*dshp(2, a)
        m13 = m13 + x(l, 1, a)*dshp(3, a)
        m23 = m23 + x(l, 2, a)*dshp(3, a)
        m33 = m33 + x(l, 3, a)*dshp(3, a)
      end do
      map(l, 1, 1) = m11
      map(l, 2, 1) = m21
      map(l, 3, 1) = m31
      map(l, 1, 2) = m12
      map(l, 2, 2) = m22
      map(l, 3, 2) = m32
      map(l, 1, 3) = m13
      map(l, 2, 3) = m23
      map(l, 3, 3) = m33
    end do
  end subroutine set_map

  !> Invert in place. If a determinant is not positive and finite, `ok` becomes .false., and the
  !! results stay finite.
  pure subroutine invert(a, det, ok)
    real(wp), intent(inout) :: a(NB, 3, 3)
    real(wp), intent(out) :: det(NB)
    logical, intent(inout) :: ok(NB)

    real(wp) :: c(NB, 3, 3), s(NB), bad
    integer :: i, j, l

    !$omp simd
    do l = 1, NB
      c(l, 1, 1) = a(l, 2, 2)*a(l, 3, 3) - a(l, 2, 3)*a(l, 3, 2)
      c(l, 2, 1) = a(l, 2, 3)*a(l, 3, 1) - a(l, 2, 1)*a(l, 3, 3)
      c(l, 3, 1) = a(l, 2, 1)*a(l, 3, 2) - a(l, 2, 2)*a(l, 3, 1)
      c(l, 1, 2) = a(l, 1, 3)*a(l, 3, 2) - a(l, 1, 2)*a(l, 3, 3)
      c(l, 2, 2) = a(l, 1, 1)*a(l, 3, 3) - a(l, 1, 3)*a(l, 3, 1)
      c(l, 3, 2) = a(l, 1, 2)*a(l, 3, 1) - a(l, 1, 1)*a(l, 3, 2)
      c(l, 1, 3) = a(l, 1, 2)*a(l, 2, 3) - a(l, 1, 3)*a(l, 2, 2)
      c(l, 2, 3) = a(l, 1, 3)*a(l, 2, 1) - a(l, 1, 1)*a(l, 2, 3)
      c(l, 3, 3) = a(l, 1, 1)*a(l, 2, 2) - a(l, 1, 2)*a(l, 2, 1)
      det(l) = a(l, 1, 1)*c(l, 1, 1) + a(l, 1, 2)*c(l, 2, 1) + a(l, 1, 3)*c(l, 3, 1)
    end do
    bad = 0.0_wp
    !$omp simd reduction(+:bad)
    do l = 1, NB
      bad = bad + merge(0.0_wp, 1.0_wp, det(l) > 0.0_wp .and. det(l) <= huge(bad))
    end do
    if (bad > 0.0_wp) then
      ok = ok .and. det > 0.0_wp .and. det <= huge(det)
      where (.not. (det > 0.0_wp .and. det <= huge(det))) det = 1.0_wp
    end if
    s = 1.0_wp/det
    do j = 1, 3
      do i = 1, 3
        !$omp simd
        do l = 1, NB
          a(l, i, j) = c(l, i, j)*s(l)
        end do
      end do
    end do
  end subroutine invert

  !> Make a diagonal block symmetric to the last bit.
  pure subroutine symmetrise(k)
    real(wp), intent(inout) :: k(NB, 3, 3)

    integer :: l

    !$omp simd
    do l = 1, NB
      k(l, 2, 1) = k(l, 1, 2)
      k(l, 3, 1) = k(l, 1, 3)
      k(l, 3, 2) = k(l, 2, 3)
    end do
  end subroutine symmetrise

  !> Set residual and tangent to zero for elements that are not ok.
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
