!> Threads of the linear algebra, and the processor for which OpenBLAS is tuned.
module blas_threads
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_int, c_null_char, c_ptr
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_kinds, only: wp, i8
  use base_system, only: return_memory
  use base_threads, only: use_threads
  use base_text, only: to_text
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

  !> Use n threads: those of OpenMP, each of which calls OpenBLAS as if it were the only one (see
  !! blas_products).
  !!
  !! OpenBLAS allocates a buffer for each thread that is in one of its procedures. If memory is
  !! short, it repeats the attempt forever, so the available memory is tested first. The products at
  !! the end make the threads start and allocate the buffers; smaller matrices would not need them.
  subroutine set_threads(n, error)
    integer, intent(in) :: n
    type(error_t), allocatable, intent(out) :: error
    integer, parameter :: LARGE = 128, BUFFER_MB = 192, FURTHER_MB = 400
    !! Address space in MB: the first thread takes a little more than 128, each further thread up to
    !! 400.
    real(wp), allocatable :: a(:, :), c(:, :)
    character(:), allocatable :: room !! never written to, so that it takes no memory
    integer :: megabytes, status

    megabytes = BUFFER_MB + FURTHER_MB*max(n - 1, 0)
    allocate (character(int(megabytes, i8)*2**20) :: room, stat=status)
    if (status /= 0) then
      call fail(error, SYSTEM_ERROR, 'not enough memory to start the linear algebra library, ' &
                //'which needs '//to_text(megabytes)//' MB', hint='raise the limits that ' &
                //'''ulimit -a'' shows' &
                //trim(merge(', or use fewer threads', '                      ', n > 1)))
      return
    end if
    deallocate (room)
    call return_memory()
    call use_threads(max(n, 1))
    call openblas_set_num_threads(1_c_int)
    !$omp parallel private(a, c)
    allocate (a(LARGE, LARGE), c(LARGE, LARGE), source=0.0_wp)
    call dgemm('N', 'N', LARGE, LARGE, LARGE, 1.0_wp, a, LARGE, a, LARGE, 0.0_wp, c, LARGE)
    !$omp end parallel
  end subroutine set_threads

  !> Name of the processor for which OpenBLAS is tuned; it is reported with measured times.
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
