!> Makes OpenBLAS use the vector unit of the processor.
!!
!! OpenBLAS chooses its kernels when it is loaded, according to the model number of the processor. A
!! processor that is newer than the library gets the oldest kernels (version 0.3.21 of Debian 12 on
!! a processor of 2023 runs dgemm at 9 instead of 70 GFLOP/s). In that case this program restarts
!! itself with OPENBLAS_CORETYPE set to the best kernels that the processor supports. A value that
!! the user has set is never changed.
module blas_choice
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use base_cpu, only: vector_level
  use blas_threads, only: blas_kernel
  implicit none
  private
  public :: choose_blas_kernel

  ! allow(assumed-size)
  interface
    integer(c_int) function c_setenv(name, value, overwrite) bind(c, name='setenv')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: name(*), value(*)
      integer(c_int), value :: overwrite
    end function c_setenv

    integer(c_int) function c_execv(path, argv) bind(c, name='execv')
      import :: c_char, c_int, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(in) :: argv(*)
    end function c_execv
  end interface

contains

  !> Restart with better kernels if the library does not know the processor.
  subroutine choose_blas_kernel()
    character(:), allocatable :: wanted
    integer :: length, status

    call get_environment_variable('OPENBLAS_CORETYPE', length=length, status=status)
    if (status == 0) return
    if (all(blas_kernel() /= [character(8) :: 'Prescott', 'Generic', 'Core2'])) return
    select case (vector_level())
    case (4)
      wanted = 'SkylakeX'
    case (3)
      wanted = 'Haswell'
    case default
      return
    end select
    if (c_setenv('OPENBLAS_CORETYPE'//c_null_char, wanted//c_null_char, 0_c_int) /= 0) return
    call start_again()
  end subroutine choose_blas_kernel

  !> Replace this process by the same program with the same arguments. It returns only on failure.
  subroutine start_again()
    integer, parameter :: LONGEST = 4096
    character(kind=c_char, len=1), allocatable, target :: text(:, :)
    type(c_ptr), allocatable :: argv(:)
    character(LONGEST - 1) :: argument
    integer :: i, j, length, n, status

    n = command_argument_count()
    allocate (text(LONGEST, 0:n), argv(0:n + 1))
    do i = 0, n
      call get_command_argument(i, argument, length, status)
      if (status /= 0) return
      do j = 1, length
        text(j, i) = argument(j:j)
      end do
      text(length + 1, i) = c_null_char
      argv(i) = c_loc(text(1, i))
    end do
    argv(n + 1) = c_null_ptr
    status = c_execv('/proc/self/exe'//c_null_char, argv)
  end subroutine start_again

end module blas_choice
