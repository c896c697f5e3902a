!> Threads of the BLAS.
module blas_threads
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_null_char, c_ptr
  use base_kinds, only: wp
  use lapack, only: dgemm
  implicit none
  private
  public :: set_threads, blas_kernel

  interface
    subroutine openblas_set_num_threads(n) bind(c, name='openblas_set_num_threads')
      import :: c_int
      implicit none
      integer(c_int), value :: n
    end subroutine openblas_set_num_threads

    type(c_ptr) function openblas_get_corename() bind(c, name='openblas_get_corename')
      import :: c_ptr
      implicit none
    end function openblas_get_corename
  end interface

contains

  !> Use n threads in factorisations.
  subroutine set_threads(n)
    integer, intent(in) :: n

    call openblas_set_num_threads(int(max(n, 1), c_int))
    call claim_buffer()
  end subroutine set_threads

  !> Let OpenBLAS take its buffer while there is memory: it keeps it, and asks for ever where there
  !! is none. Products of small matrices need no buffer.
  subroutine claim_buffer()
    integer, parameter :: LARGE = 128
    real(wp), allocatable :: a(:, :), c(:, :)

    allocate (a(LARGE, LARGE), c(LARGE, LARGE))
    a = 0.0_wp
    c = 0.0_wp
    call dgemm('N', 'N', LARGE, LARGE, LARGE, 1.0_wp, a, LARGE, a, LARGE, 0.0_wp, c, LARGE)
  end subroutine claim_buffer

  !> The processor OpenBLAS was tuned for, to stand beside every measured time.
  function blas_kernel() result(name)
    character(:), allocatable :: name

    integer, parameter :: LONGEST = 64
    character(kind=c_char), pointer :: text(:)
    integer :: i

    call c_f_pointer(openblas_get_corename(), text, [LONGEST])
    name = ''
    do i = 1, LONGEST
      if (text(i) == c_null_char) exit
      name = name//text(i)
    end do
  end function blas_kernel

end module blas_threads
