!> Sums over integration points as products of panels (functions by points), computed by BLAS.
module solid_panel
  use base_kinds, only: wp
  use lapack, only: dgemm
  implicit none
  private
  public :: add_moduli, add_general, add_symmetric, fold

  integer, parameter, public :: CHUNK = 27 !! points in a panel, which must fit in the cache

contains

  !> Add G_i w lam G_j^T + G_j w mus G_i^T to p_ij, i <= j, where G_i is the panel of direction i.
  !! These are the parts lam g_a x g_b + mus g_b x g_a of the tangent.
  pure subroutine add_moduli(first, n, nq, g, w, lam, mus, p)
    logical, intent(in) :: first !! set the sums instead of adding to them
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(n, 3, nq) !! gradients
    real(wp), intent(in) :: w(nq), lam(nq), mus(nq)
    real(wp), intent(inout) :: p(n, 3, n, 3) !! function, direction, function, direction

    real(wp) :: gl(n, 3, nq), gm(n, 3, nq), keep
    integer :: q, i, j, ld

    ld = 3*n ! a direction has n rows of the panel
    keep = merge(0.0_wp, 1.0_wp, first)
    do q = 1, nq
      gl(:, :, q) = (w(q)*lam(q))*g(:, :, q)
      gm(:, :, q) = (w(q)*mus(q))*g(:, :, q)
    end do
    do j = 1, 3
      do i = 1, j - 1
        call dgemm('N', 'T', n, n, nq, 1.0_wp, gl(1, i, 1), ld, g(1, j, 1), ld, &
                   keep, p(1, i, 1, j), ld)
        call dgemm('N', 'T', n, n, nq, 1.0_wp, gm(1, j, 1), ld, g(1, i, 1), ld, &
                   1.0_wp, p(1, i, 1, j), ld)
      end do
    end do
    gl = gl + gm
    do i = 1, 3
      call dgemm('N', 'T', n, n, nq, 1.0_wp, gl(1, i, 1), ld, g(1, i, 1), ld, &
                 keep, p(1, i, 1, i), ld)
    end do
  end subroutine add_moduli

  !> Add sum_q w B^T c B to p (all blocks), where c is a full 6 x 6 tangent.
  pure subroutine add_general(first, n, nq, g, w, c, p)
    logical, intent(in) :: first !! set the sums instead of adding to them
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(n, 3, nq), w(nq), c(6, 6, nq)
    real(wp), intent(inout) :: p(n, 3, n, 3)

    real(wp) :: b(n, 3, 6), cb(n, 3, 6)
    integer :: q, i, j

    do q = 1, nq
      b = 0.0_wp
      b(:, 1, 1) = g(:, 1, q)
      b(:, 2, 2) = g(:, 2, q)
      b(:, 3, 3) = g(:, 3, q)
      b(:, 1, 4) = g(:, 2, q)
      b(:, 2, 4) = g(:, 1, q)
      b(:, 2, 5) = g(:, 3, q)
      b(:, 3, 5) = g(:, 2, q)
      b(:, 3, 6) = g(:, 1, q)
      b(:, 1, 6) = g(:, 3, q)
      cb = 0.0_wp
      do j = 1, 6
        do i = 1, 6
          cb(:, :, j) = cb(:, :, j) + (w(q)*c(j, i, q))*b(:, :, i)
        end do
      end do
      call dgemm('N', 'T', 3*n, 3*n, 6, 1.0_wp, b, 3*n, cb, 3*n, &
                 merge(0.0_wp, 1.0_wp, first .and. q == 1), p, 3*n)
    end do
  end subroutine add_general

  !> Add sum_q w g_a . (tau + mus 1) g_b to s(a, b).
  pure subroutine add_symmetric(first, n, nq, g, w, tau, mus, s)
    logical, intent(in) :: first !! set the sums instead of adding to them
    integer, intent(in) :: n, nq
    real(wp), intent(in) :: g(n, 3, nq), w(nq), tau(6, nq), mus(nq)
    real(wp), intent(inout) :: s(n, n)

    real(wp) :: t(n, 3, nq), x(6)
    integer :: q

    do q = 1, nq
      x = w(q)*tau(:, q)
      x(:3) = x(:3) + w(q)*mus(q)
      t(:, 1, q) = x(1)*g(:, 1, q) + x(4)*g(:, 2, q) + x(6)*g(:, 3, q)
      t(:, 2, q) = x(4)*g(:, 1, q) + x(2)*g(:, 2, q) + x(5)*g(:, 3, q)
      t(:, 3, q) = x(6)*g(:, 1, q) + x(5)*g(:, 2, q) + x(3)*g(:, 3, q)
    end do
    call dgemm('N', 'T', n, n, 3*nq, 1.0_wp, g, n, t, n, merge(0.0_wp, 1.0_wp, first), s, n)
  end subroutine add_symmetric

  !> Build the element matrix from the blocks p, and from s, which is added for each direction; the
  !! dofs of a function are adjacent.
  pure subroutine fold(n, upper, p, s, k)
    integer, intent(in) :: n
    logical, intent(in) :: upper !! only p_ij with i <= j are set, and the result is symmetric
    real(wp), intent(in) :: p(n, 3, n, 3), s(n, n)
    real(wp), intent(out) :: k(:, :) !! (3n, 3n)

    integer :: a, b, i, j

    do b = 1, n
      do a = 1, merge(b, n, upper)
        do j = 1, 3
          do i = 1, 3
            if (upper .and. i > j) then
              k(3*a - 3 + i, 3*b - 3 + j) = p(b, j, a, i)
            else
              k(3*a - 3 + i, 3*b - 3 + j) = p(a, i, b, j)
            end if
          end do
          k(3*a - 3 + j, 3*b - 3 + j) = k(3*a - 3 + j, 3*b - 3 + j) + s(a, b)
        end do
      end do
    end do
    if (.not. upper) return
    do b = 1, 3*n
      k(b, :b - 1) = k(:b - 1, b)
    end do
  end subroutine fold

end module solid_panel
