!> Products of a block matrix with vectors.
module csr_product
  use base_kinds, only: wp
  use csr_pattern, only: block_matrix_t
  implicit none
  private
  public :: multiply, multiply_free, row_sums

contains

  !> y = A x over all nodes, prescribed dofs included.
  !!
  !! With x = 0 at the free dofs this is what prescribed motion asks of them: the tangent predictor.
  pure subroutine multiply(a, x, y)
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: x(:, :)   !! (3, nnode)
    real(wp), intent(out) :: y(:, :)  !! (3, nnode)

    if (a%symmetric) then
      call multiply_symmetric(a%nnode, a%row, a%col, a%val, x, y)
    else
      call multiply_full(a%nnode, a%row, a%col, a%val, x, y)
    end if
  end subroutine multiply

  !> Both halves of a symmetric matrix from its upper one.
  pure subroutine multiply_symmetric(nnode, row, col, val, x, y)
    integer, intent(in) :: nnode
    integer, intent(in) :: row(:), col(:)
    real(wp), intent(in) :: val(:, :, :), x(:, :)
    real(wp), intent(out) :: y(:, :)

    real(wp) :: s1, s2, s3, x1, x2, x3
    integer :: i, j, p

    y = 0.0_wp
    do i = 1, nnode
      p = row(i) ! the diagonal block leads its row; its upper triangle counts
      x1 = x(1, i); x2 = x(2, i); x3 = x(3, i)
      s1 = val(1, 1, p)*x1 + val(1, 2, p)*x2 + val(1, 3, p)*x3
      s2 = val(1, 2, p)*x1 + val(2, 2, p)*x2 + val(2, 3, p)*x3
      s3 = val(1, 3, p)*x1 + val(2, 3, p)*x2 + val(3, 3, p)*x3
      do p = row(i) + 1, row(i + 1) - 1
        j = col(p)
        s1 = s1 + val(1, 1, p)*x(1, j) + val(1, 2, p)*x(2, j) + val(1, 3, p)*x(3, j)
        s2 = s2 + val(2, 1, p)*x(1, j) + val(2, 2, p)*x(2, j) + val(2, 3, p)*x(3, j)
        s3 = s3 + val(3, 1, p)*x(1, j) + val(3, 2, p)*x(2, j) + val(3, 3, p)*x(3, j)
        y(1, j) = y(1, j) + val(1, 1, p)*x1 + val(2, 1, p)*x2 + val(3, 1, p)*x3
        y(2, j) = y(2, j) + val(1, 2, p)*x1 + val(2, 2, p)*x2 + val(3, 2, p)*x3
        y(3, j) = y(3, j) + val(1, 3, p)*x1 + val(2, 3, p)*x2 + val(3, 3, p)*x3
      end do
      y(1, i) = y(1, i) + s1
      y(2, i) = y(2, i) + s2
      y(3, i) = y(3, i) + s3
    end do
  end subroutine multiply_symmetric

  !> Product with a matrix stored in full.
  pure subroutine multiply_full(nnode, row, col, val, x, y)
    integer, intent(in) :: nnode
    integer, intent(in) :: row(:), col(:)
    real(wp), intent(in) :: val(:, :, :), x(:, :)
    real(wp), intent(out) :: y(:, :)

    real(wp) :: s1, s2, s3
    integer :: i, j, p

    do i = 1, nnode
      s1 = 0.0_wp; s2 = 0.0_wp; s3 = 0.0_wp
      do p = row(i), row(i + 1) - 1
        j = col(p)
        s1 = s1 + val(1, 1, p)*x(1, j) + val(1, 2, p)*x(2, j) + val(1, 3, p)*x(3, j)
        s2 = s2 + val(2, 1, p)*x(1, j) + val(2, 2, p)*x(2, j) + val(2, 3, p)*x(3, j)
        s3 = s3 + val(3, 1, p)*x(1, j) + val(3, 2, p)*x(2, j) + val(3, 3, p)*x(3, j)
      end do
      y(1, i) = s1; y(2, i) = s2; y(3, i) = s3
    end do
  end subroutine multiply_full

  !> y = A x over the free dofs only.
  pure subroutine multiply_free(a, eq, x, y, xn, yn)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)      !! (3, nnode) equation numbers, 0: prescribed
    real(wp), intent(in) :: x(:)         !! (neq)
    real(wp), intent(inout) :: y(:)      !! (neq)
    real(wp), intent(inout) :: xn(:, :)  !! (3, nnode) work
    real(wp), intent(inout) :: yn(:, :)  !! (3, nnode) work

    integer :: i, n

    do n = 1, a%nnode
      do i = 1, 3
        xn(i, n) = 0.0_wp
        if (eq(i, n) > 0) xn(i, n) = x(eq(i, n))
      end do
    end do
    call multiply(a, xn, yn)
    do n = 1, a%nnode
      do i = 1, 3
        if (eq(i, n) > 0) y(eq(i, n)) = yn(i, n)
      end do
    end do
  end subroutine multiply_free

  !> Sums of absolute values of each row, over free rows and columns.
  pure subroutine row_sums(a, eq, total)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)       !! (3, nnode)
    real(wp), intent(out) :: total(:)     !! (neq)

    integer :: i, j, n, m, p

    total = 0.0_wp
    do n = 1, a%nnode
      do p = a%row(n), a%row(n + 1) - 1
        m = a%col(p)
        do j = 1, 3
          do i = 1, 3
            if (eq(i, n) == 0 .or. eq(j, m) == 0) cycle
            total(eq(i, n)) = total(eq(i, n)) + abs(a%val(i, j, p))
            if (.not. a%symmetric .or. n == m) cycle
            total(eq(j, m)) = total(eq(j, m)) + abs(a%val(i, j, p))
          end do
        end do
      end do
    end do
  end subroutine row_sums

end module csr_product
