!> Makes OpenBLAS use the vector unit of the processor, and start no threads that are not used.
!!
!! OpenBLAS chooses its kernels when it is loaded, according to the model number of the processor.
!! If the processor is newer than the library, the library chooses its oldest kernels. For example,
!! version 0.3.21 of Debian 12 runs dgemm at 9 instead of 70 GFLOP/s on a processor of 2023.
!! Therefore this program then restarts itself with OPENBLAS_CORETYPE set to faster kernels that the
!! processor supports.
!!
!! When the library is loaded, it also starts a thread for each processor. These threads wait
!! forever if a limit refuses the memory that they need. Therefore this program restarts itself with
!! OPENBLAS_NUM_THREADS set to 1; `set_threads` starts further threads if there is memory for them.
!! Neither variable is changed if the user has set it.
module blas_choice
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use base_cpu, only: vector_level
  use base_system, only: clock_text, keep_signals_waiting, set_variable, CLOCK_NAME
  use blas_threads, only: blas_kernel
  implicit none
  private
  public :: prepare_blas

  ! allow(assumed-size)
  interface
    integer(c_int) function c_execv(path, argv) bind(c, name='execv')
      import :: c_char, c_int, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(in) :: argv(*)
    end function c_execv
  end interface

contains

  !> Restart this program if the library has chosen its oldest kernels although the processor
  !! supports faster ones, or if OPENBLAS_NUM_THREADS is not set.
  subroutine prepare_blas()
    character(:), allocatable :: kernel
    integer :: status
    logical :: again

    again = .false.
    kernel = blas_kernel()
    call get_environment_variable('OPENBLAS_CORETYPE', status=status)
    if (status == 1 .and. any(kernel == [character(8) :: 'Prescott', 'Generic', 'Core2'])) then
      select case (vector_level())
      case (4)
        call set_variable('OPENBLAS_CORETYPE', 'SkylakeX', again)
      case (3)
        call set_variable('OPENBLAS_CORETYPE', 'Haswell', again)
      case default ! the oldest kernels are right
      end select
    end if
    call get_environment_variable('OPENBLAS_NUM_THREADS', status=status)
    if (status == 1) call set_variable('OPENBLAS_NUM_THREADS', '1', again)
    if (again) call start_again()
  end subroutine prepare_blas

  !> Start this program again in the same process, with the same arguments. The procedure returns
  !! only if this fails.
  subroutine start_again()
    integer, parameter :: LONGEST = 4096
    character(kind=c_char, len=1), allocatable, target :: text(:, :)
    type(c_ptr), allocatable :: argv(:)
    character(LONGEST - 1) :: argument
    integer :: i, j, length, n, status
    logical :: done

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
    call set_variable(CLOCK_NAME, clock_text(), done)
    call keep_signals_waiting()
    status = c_execv('/proc/self/exe'//c_null_char, argv)
  end subroutine start_again

end module blas_choice
