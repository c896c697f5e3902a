!> Sums over the integration points of one element, with NV functions side by side in a vector
!! register.
!!
!! A panel contains the gradients of all functions at up to CHUNK points: (function of a group,
!! direction, point, group). The last group is filled up with functions whose gradients are zero.
module solid_panel
  use base_kinds, only: wp
  use lapack, only: dgemm
  implicit none
  private
  public :: add_residual, add_moduli, add_general, mirror, groups

  integer, parameter, public :: NV = 4     !! functions in a group
  integer, parameter, public :: CHUNK = 32 !! points in a panel, which must fit in the cache

contains

  !> Number of groups of n functions.
  pure integer function groups(n)
    integer, intent(in) :: n

    groups = (n + NV - 1)/NV
  end function groups

  !> Add r_a = sum_q x g_a, with x = w tau.
  pure subroutine add_residual(first, n, nq, g, x, r)
    logical, intent(in) :: first !! set the sums instead of adding to them
    integer, intent(in) :: n, nq !! functions, points
    real(wp), intent(in) :: g(NV, 3, CHUNK, groups(n)), x(6, CHUNK)
    real(wp), intent(inout) :: r(3, n)

    real(wp), dimension(NV) :: f1, f2, f3
    integer :: a, b, l, q

    do b = 1, groups(n)
      f1 = 0.0_wp; f2 = 0.0_wp; f3 = 0.0_wp
      do q = 1, nq
        !$omp simd
        do l = 1, NV
          f1(l) = f1(l) + (x(1, q)*g(l, 1, q, b) + x(4, q)*g(l, 2, q, b) + x(6, q)*g(l, 3, q, b))
          f2(l) = f2(l) + (x(4, q)*g(l, 1, q, b) + x(2, q)*g(l, 2, q, b) + x(5, q)*g(l, 3, q, b))
          f3(l) = f3(l) + (x(6, q)*g(l, 1, q, b) + x(5, q)*g(l, 2, q, b) + x(3, q)*g(l, 3, q, b))
        end do
      end do
      do l = 1, min(NV, n - NV*(b - 1))
        a = NV*(b - 1) + l
        if (first) r(:, a) = 0.0_wp
        r(:, a) = r(:, a) + [f1(l), f2(l), f3(l)]
      end do
    end do
  end subroutine add_residual

  !> Add sum_q (g_a . y g_b) 1 + lam g_a x g_b + mus g_b x g_a to the blocks (a, b), a <= b, with
  !! the weights in y, lam and mus.
  pure subroutine add_moduli(first, n, nq, g, y, lam, mus, k)
    logical, intent(in) :: first
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(NV, 3, CHUNK, groups(n))
    real(wp), intent(in) :: y(6, CHUNK), lam(CHUNK), mus(CHUNK)
    real(wp), intent(inout) :: k(3, n, 3, n)

    real(wp), dimension(NV, 3, CHUNK) :: t, gl, gm, gs
    real(wp) :: block(NV, 3, 3)
    integer :: ga, gb, b, m, a, j, l

    do gb = 1, groups(n)
      call weigh(nq, g(:, :, :, gb), y, lam, mus, t, gl, gm, gs)
      do m = 1, min(NV, n - NV*(gb - 1))
        b = NV*(gb - 1) + m
        do ga = 1, gb
          call sum_blocks(nq, m, g(:, :, :, ga), t, gl, gm, gs, block)
          a = NV*(ga - 1)
          if (first) then
            do j = 1, 3
              do l = 1, min(NV, n - a)
                k(1, a + l, j, b) = block(l, 1, j)
                k(2, a + l, j, b) = block(l, 2, j)
                k(3, a + l, j, b) = block(l, 3, j)
              end do
            end do
          else
            do j = 1, 3
              do l = 1, min(NV, n - a)
                k(1, a + l, j, b) = k(1, a + l, j, b) + block(l, 1, j)
                k(2, a + l, j, b) = k(2, a + l, j, b) + block(l, 2, j)
                k(3, a + l, j, b) = k(3, a + l, j, b) + block(l, 3, j)
              end do
            end do
          end if
        end do
      end do
    end do
  end subroutine add_moduli

  !> Compute the products that sum_blocks needs for the functions b of a group: y g_b, lam g_b,
  !! mus g_b, and the sum of the last two.
  pure subroutine weigh(nq, g, y, lam, mus, t, gl, gm, gs)
    integer, intent(in) :: nq
    real(wp), intent(in) :: g(NV, 3, CHUNK), y(6, CHUNK), lam(CHUNK), mus(CHUNK)
    real(wp), intent(out), dimension(NV, 3, CHUNK) :: t, gl, gm, gs

    integer :: q, l

    do q = 1, nq
      !$omp simd
      do l = 1, NV
        t(l, 1, q) = y(1, q)*g(l, 1, q) + y(4, q)*g(l, 2, q) + y(6, q)*g(l, 3, q)
        t(l, 2, q) = y(4, q)*g(l, 1, q) + y(2, q)*g(l, 2, q) + y(5, q)*g(l, 3, q)
        t(l, 3, q) = y(6, q)*g(l, 1, q) + y(5, q)*g(l, 2, q) + y(3, q)*g(l, 3, q)
        gl(l, 1, q) = lam(q)*g(l, 1, q)
        gl(l, 2, q) = lam(q)*g(l, 2, q)
        gl(l, 3, q) = lam(q)*g(l, 3, q)
        gm(l, 1, q) = mus(q)*g(l, 1, q)
        gm(l, 2, q) = mus(q)*g(l, 2, q)
        gm(l, 3, q) = mus(q)*g(l, 3, q)
        gs(l, 1, q) = gl(l, 1, q) + gm(l, 1, q)
        gs(l, 2, q) = gl(l, 2, q) + gm(l, 2, q)
        gs(l, 3, q) = gl(l, 3, q) + gm(l, 3, q)
      end do
    end do
  end subroutine weigh

  !> Compute the blocks of a group of functions a with one function b. The compiler keeps the sums,
  !! which have the length of a register, in registers.
  pure subroutine sum_blocks(nq, m, g, t, gl, gm, gs, k)
    integer, intent(in) :: nq, m !! points, position of b in its group
    real(wp), intent(in), dimension(NV, 3, CHUNK) :: g, t, gl, gm, gs !! t to gs: from weigh
    real(wp), intent(out) :: k(NV, 3, 3)

    real(wp), dimension(NV) :: s1, s2, s3, k11, k21, k31, k12, k22, k32, k13, k23, k33
    integer :: q, l

    s1 = 0.0_wp; s2 = 0.0_wp; s3 = 0.0_wp
    k11 = 0.0_wp; k12 = 0.0_wp; k13 = 0.0_wp
    k21 = 0.0_wp; k22 = 0.0_wp; k23 = 0.0_wp
    k31 = 0.0_wp; k32 = 0.0_wp; k33 = 0.0_wp
    do q = 1, nq ! independent sums shorten the chains of dependent additions
      !$omp simd
      do l = 1, NV
        s1(l) = s1(l) + g(l, 1, q)*t(m, 1, q)
        s2(l) = s2(l) + g(l, 2, q)*t(m, 2, q)
        s3(l) = s3(l) + g(l, 3, q)*t(m, 3, q)
        k11(l) = k11(l) + g(l, 1, q)*gs(m, 1, q)
        k22(l) = k22(l) + g(l, 2, q)*gs(m, 2, q)
        k33(l) = k33(l) + g(l, 3, q)*gs(m, 3, q)
        k12(l) = k12(l) + g(l, 1, q)*gl(m, 2, q) + g(l, 2, q)*gm(m, 1, q)
        k21(l) = k21(l) + g(l, 2, q)*gl(m, 1, q) + g(l, 1, q)*gm(m, 2, q)
        k13(l) = k13(l) + g(l, 1, q)*gl(m, 3, q) + g(l, 3, q)*gm(m, 1, q)
        k31(l) = k31(l) + g(l, 3, q)*gl(m, 1, q) + g(l, 1, q)*gm(m, 3, q)
        k23(l) = k23(l) + g(l, 2, q)*gl(m, 3, q) + g(l, 3, q)*gm(m, 2, q)
        k32(l) = k32(l) + g(l, 3, q)*gl(m, 2, q) + g(l, 2, q)*gm(m, 3, q)
      end do
    end do
    s1 = s1 + s2 + s3
    k(:, 1, 1) = k11 + s1; k(:, 1, 2) = k12; k(:, 1, 3) = k13
    k(:, 2, 1) = k21; k(:, 2, 2) = k22 + s1; k(:, 2, 3) = k23
    k(:, 3, 1) = k31; k(:, 3, 2) = k32; k(:, 3, 3) = k33 + s1
  end subroutine sum_blocks

  !> Add sum_q w B^T c B + (g_a . y g_b) 1 to all blocks, where c is a full 6 x 6 tangent and y
  !! contains the weights.
  pure subroutine add_general(first, n, nq, g, w, y, c, k)
    logical, intent(in) :: first
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(NV, 3, CHUNK, groups(n))
    real(wp), intent(in) :: w(CHUNK), y(6, CHUNK), c(6, 6, CHUNK)
    real(wp), intent(inout) :: k(3, n, 3, n)

    real(wp) :: b(3, n, 6), cb(3, n, 6), p(NV*groups(n), 3), t(n, 3)
    real(wp), allocatable :: s(:, :) ! too large for the stack in splines of high degree
    integer :: q, i, j

    allocate (s(n, n))
    if (first) k = 0.0_wp
    do q = 1, nq
      do i = 1, groups(n)
        p(NV*(i - 1) + 1:NV*i, :) = g(:, :, q, i)
      end do
      b = 0.0_wp
      b(1, :, 1) = p(:n, 1)
      b(2, :, 2) = p(:n, 2)
      b(3, :, 3) = p(:n, 3)
      b(1, :, 4) = p(:n, 2)
      b(2, :, 4) = p(:n, 1)
      b(2, :, 5) = p(:n, 3)
      b(3, :, 5) = p(:n, 2)
      b(3, :, 6) = p(:n, 1)
      b(1, :, 6) = p(:n, 3)
      cb = 0.0_wp
      do j = 1, 6
        do i = 1, 6
          cb(:, :, j) = cb(:, :, j) + (w(q)*c(j, i, q))*b(:, :, i)
        end do
      end do
      call dgemm('N', 'T', 3*n, 3*n, 6, 1.0_wp, b, 3*n, cb, 3*n, 1.0_wp, k, 3*n)
      t(:, 1) = y(1, q)*p(:n, 1) + y(4, q)*p(:n, 2) + y(6, q)*p(:n, 3)
      t(:, 2) = y(4, q)*p(:n, 1) + y(2, q)*p(:n, 2) + y(5, q)*p(:n, 3)
      t(:, 3) = y(6, q)*p(:n, 1) + y(5, q)*p(:n, 2) + y(3, q)*p(:n, 3)
      call dgemm('N', 'T', n, n, 3, 1.0_wp, p, size(p, 1), t, n, &
                 merge(0.0_wp, 1.0_wp, q == 1), s, n)
    end do
    do i = 1, 3
      k(i, :, i, :) = k(i, :, i, :) + s
    end do
  end subroutine add_general

  !> Copy the upper triangle of a matrix to the lower one.
  pure subroutine mirror(n, k)
    integer, intent(in) :: n
    real(wp), intent(inout) :: k(n, n)

    integer :: b

    do b = 1, n
      k(b, :b - 1) = k(:b - 1, b)
    end do
  end subroutine mirror

end module solid_panel
