!> Sets what the libraries of the linear algebra and of threads read when they are loaded: the
!! vector unit that OpenBLAS uses, its threads, and the threads of OpenMP.
!!
!! OpenBLAS chooses its kernels when it is loaded, according to the model number of the processor.
!! If the processor is newer than the library, the library chooses its oldest kernels. For example,
!! version 0.3.21 of Debian 12 runs dgemm at 9 instead of 70 GFLOP/s on a processor of 2023.
!! Therefore this program then restarts itself with OPENBLAS_CORETYPE set to faster kernels that the
!! processor supports.
!!
!! When the library is loaded, it also starts a thread for each processor. These threads wait
!! forever if a limit refuses the memory that they need. Therefore this program restarts itself with
!! OPENBLAS_NUM_THREADS set to 1.
!!
!! With `--threads`, the threads get a stack of OMP_STACKSIZE, because by default it may have only
!! 2 MB, too little for the matrices of a spline element of high degree. A thread that waits for
!! another one sleeps after GOMP_SPINCOUNT attempts. By default it would try for some milliseconds,
!! which delays the thread that it waits for if other programs use the same processors.
!!
!! None of these variables is changed if the user has set it.
module blas_choice
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use base_cpu, only: vector_level
  use base_system, only: clock_text, keep_signals_waiting, set_variable, CLOCK_NAME
  use blas_threads, only: blas_kernel
  implicit none
  private
  public :: prepare_blas

  character(*), parameter :: STACK = '16M'   !! stack of each further thread
  character(*), parameter :: SPINS = '1000' !! a few microseconds

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
  !! supports faster ones, or if a variable is not set.
  subroutine prepare_blas()
    character(:), allocatable :: kernel
    logical :: again

    again = .false.
    kernel = blas_kernel()
    if (any(kernel == [character(8) :: 'Prescott', 'Generic', 'Core2'])) then
      select case (vector_level())
      case (4)
        call set_missing('OPENBLAS_CORETYPE', 'SkylakeX', again)
      case (3)
        call set_missing('OPENBLAS_CORETYPE', 'Haswell', again)
      case default ! the oldest kernels are right
      end select
    end if
    call set_missing('OPENBLAS_NUM_THREADS', '1', again)
    if (wants_threads()) then
      call set_missing('OMP_STACKSIZE', STACK, again)
      call set_missing('GOMP_SPINCOUNT', SPINS, again)
    end if
    if (again) call start_again()
  end subroutine prepare_blas

  !> Set an environment variable that is not set; `again` becomes true if this succeeds.
  subroutine set_missing(name, value, again)
    character(*), intent(in) :: name, value
    logical, intent(inout) :: again
    integer :: status

    call get_environment_variable(name, status=status)
    if (status == 1) call set_variable(name, value, again)
  end subroutine set_missing

  !> Is `--threads` one of the arguments?
  logical function wants_threads()
    character(*), parameter :: NAME = '--threads'
    character(len(NAME)) :: argument
    integer :: i

    wants_threads = .false.
    do i = 1, command_argument_count()
      call get_command_argument(i, argument)
      wants_threads = wants_threads .or. argument == NAME
    end do
  end function wants_threads

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
