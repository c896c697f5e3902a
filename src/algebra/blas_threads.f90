!> Threads of the BLAS.
module blas_threads
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_null_char, c_ptr
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
  end subroutine set_threads

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
