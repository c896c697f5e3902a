!> Products of matrices and triangular systems: dgemm, sgemm, dtrsm and strsm of BLAS.
!!
!! The linker finds these procedures before those of OpenBLAS, so that MUMPS calls them too. They
!! differ from those of OpenBLAS in two respects.
!!
!! A single column is a vector, for which OpenBLAS has procedures that read the matrix once. MUMPS
!! solves for one right-hand side by the procedures for matrices, and these copy the matrix first.
!!
!! Large products are formed by several threads. Each thread computes some columns of the product by
!! OpenBLAS, which is set to use one thread. A column has the same bits as in one call for the whole
!! product: OpenBLAS sums over k in an order that depends neither on the number of columns nor on
!! their position, as long as every part starts at a multiple of the width of its kernels, has more
!! than one column, and is not small, since small products have kernels of their own. The threads
!! of OpenBLAS itself would sum in another order, and they wait forever if a limit refuses their
!! memory.
module blas_products
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_float, c_int
  use base_threads, only: idle_threads
  implicit none
  private

  !> Numbers of CBLAS.
  integer(c_int), parameter :: COLUMN_MAJOR = 102, PLAIN = 111, TRANSPOSED = 112, UPPER = 121, &
                               LOWER = 122, GENERAL = 131, UNIT = 132, LEFT = 141, RIGHT = 142
  integer, parameter :: WIDTH = 48 !! a multiple of the widths of all kernels
  !> Multiplications of a part, at least: fewer take less time than waking a thread.
  real(c_double), parameter :: LEAST = 4e6_c_double

  ! allow(assumed-size)
  interface
    subroutine cblas_dgemm(order, transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc) &
      bind(c, name='cblas_dgemm')
      import :: c_int, c_double
      implicit none
      integer(c_int), value :: order, transa, transb, m, n, k, lda, ldb, ldc
      real(c_double), value :: alpha, beta
      real(c_double), intent(in) :: a(*), b(*)
      real(c_double), intent(inout) :: c(*)
    end subroutine cblas_dgemm

    subroutine cblas_dgemv(order, trans, m, n, alpha, a, lda, x, incx, beta, y, incy) &
      bind(c, name='cblas_dgemv')
      import :: c_int, c_double
      implicit none
      integer(c_int), value :: order, trans, m, n, lda, incx, incy
      real(c_double), value :: alpha, beta
      real(c_double), intent(in) :: a(*), x(*)
      real(c_double), intent(inout) :: y(*)
    end subroutine cblas_dgemv

    subroutine cblas_dtrsm(order, side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb) &
      bind(c, name='cblas_dtrsm')
      import :: c_int, c_double
      implicit none
      integer(c_int), value :: order, side, uplo, transa, diag, m, n, lda, ldb
      real(c_double), value :: alpha
      real(c_double), intent(in) :: a(*)
      real(c_double), intent(inout) :: b(*)
    end subroutine cblas_dtrsm

    subroutine cblas_dtrsv(order, uplo, trans, diag, n, a, lda, x, incx) &
      bind(c, name='cblas_dtrsv')
      import :: c_int, c_double
      implicit none
      integer(c_int), value :: order, uplo, trans, diag, n, lda, incx
      real(c_double), intent(in) :: a(*)
      real(c_double), intent(inout) :: x(*)
    end subroutine cblas_dtrsv

    subroutine cblas_sgemm(order, transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc) &
      bind(c, name='cblas_sgemm')
      import :: c_int, c_float
      implicit none
      integer(c_int), value :: order, transa, transb, m, n, k, lda, ldb, ldc
      real(c_float), value :: alpha, beta
      real(c_float), intent(in) :: a(*), b(*)
      real(c_float), intent(inout) :: c(*)
    end subroutine cblas_sgemm

    subroutine cblas_sgemv(order, trans, m, n, alpha, a, lda, x, incx, beta, y, incy) &
      bind(c, name='cblas_sgemv')
      import :: c_int, c_float
      implicit none
      integer(c_int), value :: order, trans, m, n, lda, incx, incy
      real(c_float), value :: alpha, beta
      real(c_float), intent(in) :: a(*), x(*)
      real(c_float), intent(inout) :: y(*)
    end subroutine cblas_sgemv

    subroutine cblas_strsm(order, side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb) &
      bind(c, name='cblas_strsm')
      import :: c_int, c_float
      implicit none
      integer(c_int), value :: order, side, uplo, transa, diag, m, n, lda, ldb
      real(c_float), value :: alpha
      real(c_float), intent(in) :: a(*)
      real(c_float), intent(inout) :: b(*)
    end subroutine cblas_strsm

    subroutine cblas_strsv(order, uplo, trans, diag, n, a, lda, x, incx) &
      bind(c, name='cblas_strsv')
      import :: c_int, c_float
      implicit none
      integer(c_int), value :: order, uplo, trans, diag, n, lda, incx
      real(c_float), intent(in) :: a(*)
      real(c_float), intent(inout) :: x(*)
    end subroutine cblas_strsv
  end interface

contains

  !> The procedure of BLAS with this name: C = alpha op(A) op(B) + beta C.
  ! allow(assumed-size)
  subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc) &
    bind(c, name='dgemm_')
    character(kind=c_char), intent(in) :: transa, transb
    integer(c_int), intent(in) :: m, n, k, lda, ldb, ldc
    real(c_double), intent(in) :: alpha, beta
    real(c_double), intent(in) :: a(*)
    real(c_double), intent(in) :: b(ldb, *)
    real(c_double), intent(inout) :: c(ldc, *)
    integer :: i, j, parts

    if (n == 1 .and. k > 0) then
      if (.not. abs(beta) > 0) c(:m, 1) = 0 ! which need not be set
      call cblas_dgemv(COLUMN_MAJOR, code(transa), merge(m, k, code(transa) == PLAIN), &
                       merge(k, m, code(transa) == PLAIN), alpha, a, lda, b, &
                       merge(1_c_int, ldb, code(transb) == PLAIN), beta, c, 1_c_int)
      return
    end if
    parts = number_of_parts(m, n, k)
    if (parts <= 1) then
      call cblas_dgemm(COLUMN_MAJOR, code(transa), code(transb), m, n, k, alpha, a, lda, b, ldb, &
                       beta, c, ldc)
      return
    end if
    !$omp parallel do num_threads(parts) schedule(static, 1) private(j)
    do i = 1, parts
      j = first(i, n, parts)
      if (code(transb) == PLAIN) then
        call cblas_dgemm(COLUMN_MAJOR, code(transa), PLAIN, m, first(i + 1, n, parts) - j, k, &
                         alpha, a, lda, b(1, j), ldb, beta, c(1, j), ldc)
      else
        call cblas_dgemm(COLUMN_MAJOR, code(transa), TRANSPOSED, m, first(i + 1, n, parts) - j, &
                         k, alpha, a, lda, b(j, 1), ldb, beta, c(1, j), ldc)
      end if
    end do
    !$omp end parallel do
  end subroutine dgemm

  !> The procedure of BLAS with this name: op(A) X = alpha B or X op(A) = alpha B, X in place of B.
  ! allow(assumed-size)
  subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb) bind(c, name='dtrsm_')
    character(kind=c_char), intent(in) :: side, uplo, transa, diag
    integer(c_int), intent(in) :: m, n, lda, ldb
    real(c_double), intent(in) :: alpha, a(*)
    real(c_double), intent(inout) :: b(*)
    integer(c_int) :: part, edge

    part = merge(UPPER, LOWER, uplo == 'U' .or. uplo == 'u')
    edge = merge(UNIT, GENERAL, diag == 'U' .or. diag == 'u')
    if (n == 1 .and. is_left(side) .and. .not. abs(alpha - 1) > 0) then
      call cblas_dtrsv(COLUMN_MAJOR, part, code(transa), edge, m, a, lda, b, 1_c_int)
    else
      call cblas_dtrsm(COLUMN_MAJOR, merge(LEFT, RIGHT, is_left(side)), part, code(transa), edge, &
                       m, n, alpha, a, lda, b, ldb)
    end if
  end subroutine dtrsm

  !> The procedure of BLAS with this name, in single precision.
  ! allow(assumed-size)
  subroutine sgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc) &
    bind(c, name='sgemm_')
    character(kind=c_char), intent(in) :: transa, transb
    integer(c_int), intent(in) :: m, n, k, lda, ldb, ldc
    real(c_float), intent(in) :: alpha, beta
    real(c_float), intent(in) :: a(*)
    real(c_float), intent(in) :: b(ldb, *)
    real(c_float), intent(inout) :: c(ldc, *)
    integer :: i, j, parts

    if (n == 1 .and. k > 0) then
      if (.not. abs(beta) > 0) c(:m, 1) = 0 ! which need not be set
      call cblas_sgemv(COLUMN_MAJOR, code(transa), merge(m, k, code(transa) == PLAIN), &
                       merge(k, m, code(transa) == PLAIN), alpha, a, lda, b, &
                       merge(1_c_int, ldb, code(transb) == PLAIN), beta, c, 1_c_int)
      return
    end if
    parts = number_of_parts(m, n, k)
    if (parts <= 1) then
      call cblas_sgemm(COLUMN_MAJOR, code(transa), code(transb), m, n, k, alpha, a, lda, b, ldb, &
                       beta, c, ldc)
      return
    end if
    !$omp parallel do num_threads(parts) schedule(static, 1) private(j)
    do i = 1, parts
      j = first(i, n, parts)
      if (code(transb) == PLAIN) then
        call cblas_sgemm(COLUMN_MAJOR, code(transa), PLAIN, m, first(i + 1, n, parts) - j, k, &
                         alpha, a, lda, b(1, j), ldb, beta, c(1, j), ldc)
      else
        call cblas_sgemm(COLUMN_MAJOR, code(transa), TRANSPOSED, m, first(i + 1, n, parts) - j, &
                         k, alpha, a, lda, b(j, 1), ldb, beta, c(1, j), ldc)
      end if
    end do
    !$omp end parallel do
  end subroutine sgemm

  !> The procedure of BLAS with this name, in single precision.
  ! allow(assumed-size)
  subroutine strsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb) bind(c, name='strsm_')
    character(kind=c_char), intent(in) :: side, uplo, transa, diag
    integer(c_int), intent(in) :: m, n, lda, ldb
    real(c_float), intent(in) :: alpha, a(*)
    real(c_float), intent(inout) :: b(*)
    integer(c_int) :: part, edge

    part = merge(UPPER, LOWER, uplo == 'U' .or. uplo == 'u')
    edge = merge(UNIT, GENERAL, diag == 'U' .or. diag == 'u')
    if (n == 1 .and. is_left(side) .and. .not. abs(alpha - 1) > 0) then
      call cblas_strsv(COLUMN_MAJOR, part, code(transa), edge, m, a, lda, b, 1_c_int)
    else
      call cblas_strsm(COLUMN_MAJOR, merge(LEFT, RIGHT, is_left(side)), part, code(transa), edge, &
                       m, n, alpha, a, lda, b, ldb)
    end if
  end subroutine strsm

  !> Number of parts into which the columns of a product are divided; 1 inside a parallel region.
  integer function number_of_parts(m, n, k) result(parts)
    integer(c_int), intent(in) :: m, n, k

    parts = 1
    if (real(m, c_double)*real(n, c_double)*real(k, c_double) < 2*LEAST) return
    parts = min(idle_threads(), n/WIDTH, &
                int(real(m, c_double)*real(n, c_double)*real(k, c_double)/LEAST))
    do while (parts > 1) ! the smallest part has at least LEAST multiplications
      if (real(m, c_double)*real(k, c_double)*smallest(n, parts) >= LEAST) exit
      parts = parts - 1
    end do
  end function number_of_parts

  !> First column of a part. Parts start at multiples of WIDTH.
  pure integer function first(i, n, parts)
    integer, intent(in) :: i     !! from 1; parts + 1: n + 1
    integer(c_int), intent(in) :: n
    integer, intent(in) :: parts

    first = 1 + WIDTH*((n/WIDTH)*(i - 1)/parts)
    if (i > parts) first = n + 1
  end function first

  !> Number of columns of the smallest part.
  pure real(c_double) function smallest(n, parts)
    integer(c_int), intent(in) :: n
    integer, intent(in) :: parts

    smallest = real(WIDTH*((n/WIDTH)/parts), c_double)
  end function smallest

  !> The number by which CBLAS denotes a matrix or its transpose.
  pure integer(c_int) function code(trans)
    character(kind=c_char), intent(in) :: trans

    code = merge(PLAIN, TRANSPOSED, trans == 'N' .or. trans == 'n')
  end function code

  !> Does the triangular matrix stand on the left?
  pure logical function is_left(side)
    character(kind=c_char), intent(in) :: side

    is_left = side == 'L' .or. side == 'l'
  end function is_left

end module blas_products
