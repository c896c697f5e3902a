!> Threads (OpenMP) of this process.
!!
!! The number of threads is the one that use_threads sets; the environment variable OMP_NUM_THREADS
!! has no effect. No result may depend on this number: threads compute what belongs to different
!! elements or different rows, and every sum is formed in the same order as by one thread.
module base_threads
  use omp_lib, only: omp_get_max_threads, omp_get_num_procs, omp_get_num_threads, &
                     omp_get_thread_num, omp_in_parallel, omp_set_dynamic, omp_set_num_threads
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private
  public :: use_threads, thread_count, team_size, this_thread, idle_threads, own_cores, &
            machine_cores

  interface
    integer(c_int) function get_nprocs() bind(C, name='get_nprocs')
      import :: c_int
      implicit none
    end function get_nprocs
  end interface

contains

  !> Use n threads from now on. The threads are started when they are first needed.
  subroutine use_threads(n)
    integer, intent(in) :: n

    call omp_set_dynamic(.false.)
    call omp_set_num_threads(n)
  end subroutine use_threads

  !> Largest number of threads of the next parallel region.
  integer function thread_count()

    thread_count = omp_get_max_threads()
  end function thread_count

  !> Number of threads that a procedure may use: one if it is called by a thread of a parallel
  !! region.
  integer function idle_threads()

    idle_threads = 1
    if (.not. omp_in_parallel()) idle_threads = omp_get_max_threads()
  end function idle_threads

  !> Number of threads of the parallel region from which this function is called; it may be less
  !! than thread_count if the system limits it.
  integer function team_size()

    team_size = omp_get_num_threads()
  end function team_size

  !> Number of the calling thread in its parallel region, from 1.
  integer function this_thread()

    this_thread = omp_get_thread_num() + 1
  end function this_thread

  !> Number of cores that this process may use.
  integer function own_cores()

    own_cores = omp_get_num_procs()
  end function own_cores

  !> Number of cores of the machine.
  integer function machine_cores()

    machine_cores = int(get_nprocs())
  end function machine_cores

end module base_threads
