!> Large products of matrices by several threads: the procedures dgemm and sgemm of BLAS.
!!
!! The linker finds these procedures before those of OpenBLAS, so that MUMPS calls them too. Each
!! thread computes some columns of the product by OpenBLAS, which is set to use one thread. A column
!! has the same bits as in one call for the whole product: OpenBLAS sums over k in an order that
!! depends neither on the number of columns nor on their position, as long as every part starts at a
!! multiple of the width of its kernels and is not small, since small products have kernels of their
!! own. The threads of OpenBLAS itself would sum in another order, and they wait forever if a limit
!! refuses their memory.
module blas_products
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_float, c_int
  use base_threads, only: idle_threads
  implicit none
  private

  integer(c_int), parameter :: COLUMN_MAJOR = 102, PLAIN = 111, TRANSPOSED = 112 !! of CBLAS
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

    subroutine cblas_sgemm(order, transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc) &
      bind(c, name='cblas_sgemm')
      import :: c_int, c_float
      implicit none
      integer(c_int), value :: order, transa, transb, m, n, k, lda, ldb, ldc
      real(c_float), value :: alpha, beta
      real(c_float), intent(in) :: a(*), b(*)
      real(c_float), intent(inout) :: c(*)
    end subroutine cblas_sgemm
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

end module blas_products
