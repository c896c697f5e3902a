!> One process: the communicator of a build without MPI.
module base_comm
  implicit none
  private
  public :: begin_parallel, end_parallel, process_rank, process_count, is_first

contains

  subroutine begin_parallel()
  end subroutine begin_parallel

  subroutine end_parallel()
  end subroutine end_parallel

  !> Number of this process, from 0.
  pure function process_rank() result(r)
    integer :: r

    r = 0
  end function process_rank

  pure function process_count() result(n)
    integer :: n

    n = 1
  end function process_count

  !> The process that writes.
  pure function is_first() result(yes)
    logical :: yes

    yes = process_rank() == 0
  end function is_first

end module base_comm
