!> Processes (MPI ranks) that compute one model together. `make MPI=1` compiles this file instead of
!! base_comm_serial.f90, which explains each procedure.
module base_comm
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
  use base_kinds, only: wp, i8
  use base_system, only: finish
  use mpi_f08, only: mpi_init_thread, mpi_thread_funneled, mpi_finalize, mpi_abort, &
                     mpi_comm_rank, mpi_comm_size, mpi_comm_split_type, mpi_comm_free, &
                     mpi_ibarrier, mpi_test, mpi_bcast, &
                     mpi_allreduce, mpi_allgather, mpi_allgatherv, mpi_alltoallv, mpi_comm, &
                     mpi_request, mpi_comm_world, mpi_comm_type_shared, mpi_info_null, &
                     mpi_status_ignore, mpi_in_place, mpi_max, mpi_integer, mpi_character, &
                     mpi_double_precision
  implicit none
  private
  public :: start_comm, stop_comm, rank_count, this_rank, owns, is_root, communicator, ranks_here, &
            largest, total, share, gather_blocks

  interface share
    module procedure share_integers, share_reals, share_text
  end interface share

  interface largest
    module procedure largest_integer, largest_real
  end interface largest

  interface total
    module procedure total_scalar, total_matrix
  end interface total

  ! allow(assumed-size)
  interface
    integer(c_int) function c_open(path, flags) bind(C, name='open')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: flags
    end function c_open

    integer(c_int) function c_dup(fd) bind(C, name='dup')
      import :: c_int
      implicit none
      integer(c_int), value :: fd
    end function c_dup

    integer(c_int) function c_dup2(fd, copy) bind(C, name='dup2')
      import :: c_int
      implicit none
      integer(c_int), value :: fd, copy
    end function c_dup2

    integer(c_size_t) function c_write(fd, text, n) bind(C, name='write')
      import :: c_char, c_int, c_size_t
      implicit none
      integer(c_int), value :: fd
      character(kind=c_char), intent(in) :: text(*)
      integer(c_size_t), value :: n
    end function c_write
  end interface

  integer(c_int), parameter :: WRITE_ONLY = 1, STDOUT = 1, STDERR = 2
  integer, parameter :: PATIENCE = 20 !! seconds that ranks wait for each other after an error

  integer :: rank0 = 0, nrank = 1, nhere = 1
  integer(c_int) :: screen = STDERR   !! where a rank writes an error that it alone has met

contains

  subroutine start_comm()
    type(mpi_comm) :: here
    integer(c_int) :: fd, ignored
    integer :: level

    call mpi_init_thread(mpi_thread_funneled, level) ! only the first thread of a rank calls MPI
    call mpi_comm_rank(mpi_comm_world, rank0)
    call mpi_comm_size(mpi_comm_world, nrank)
    call mpi_comm_split_type(mpi_comm_world, mpi_comm_type_shared, 0, mpi_info_null, here)
    call mpi_comm_size(here, nhere)
    call mpi_comm_free(here)
    if (rank0 == 0) return
    screen = c_dup(STDERR)
    fd = c_open('/dev/null'//c_null_char, WRITE_ONLY)
    ignored = c_dup2(fd, STDOUT)
    ignored = c_dup2(fd, STDERR)
  end subroutine start_comm

  subroutine stop_comm(code, text)
    integer, intent(in) :: code
    character(*), intent(in) :: text
    type(mpi_request) :: request
    character(:), allocatable :: line
    integer(c_size_t) :: written
    integer(i8) :: now, rate, start
    logical :: met

    call mpi_ibarrier(mpi_comm_world, request)
    call system_clock(start, rate)
    do
      call mpi_test(request, met, mpi_status_ignore)
      if (met) exit
      call system_clock(now)
      if (code == 0 .or. now - start < PATIENCE*rate) cycle
      line = text//new_line('a')
      if (rank0 > 0) written = c_write(screen, line, len(line, c_size_t))
      call mpi_abort(mpi_comm_world, code)
    end do
    call mpi_finalize()
    call finish(code)
  end subroutine stop_comm

  pure integer function rank_count()

    rank_count = nrank
  end function rank_count

  pure integer function this_rank()

    this_rank = rank0 + 1
  end function this_rank

  pure logical function owns(i)
    integer, intent(in) :: i

    owns = mod(i, nrank) == rank0
  end function owns

  pure logical function is_root()

    is_root = rank0 == 0
  end function is_root

  integer function communicator()

    communicator = mpi_comm_world%mpi_val
  end function communicator

  pure integer function ranks_here()

    ranks_here = nhere
  end function ranks_here

  integer function largest_integer(i) result(largest)
    integer, intent(in) :: i

    largest = i
    if (nrank > 1) call mpi_allreduce(i, largest, 1, mpi_integer, mpi_max, mpi_comm_world)
  end function largest_integer

  real(wp) function largest_real(x) result(largest)
    real(wp), intent(in) :: x

    largest = x
    if (nrank > 1) call mpi_allreduce(x, largest, 1, mpi_double_precision, mpi_max, mpi_comm_world)
  end function largest_real

  subroutine total_scalar(x)
    real(wp), intent(inout) :: x
    real(wp) :: part(nrank)

    if (nrank == 1) return
    call mpi_allgather(x, 1, mpi_double_precision, part, 1, mpi_double_precision, mpi_comm_world)
    x = sum(part)
  end subroutine total_scalar

  !> Each rank receives its share of the columns from all other ranks, adds them up, and sends the
  !! sums to all ranks.
  subroutine total_matrix(x)
    real(wp), intent(inout), contiguous :: x(:, :)
    real(wp), allocatable :: part(:, :, :)
    integer :: count(nrank), first(nrank + 1), r

    if (nrank == 1) return
    first = [(int(int(size(x, 2), i8)*r/nrank), r=0, nrank)]
    count = size(x, 1)*(first(2:) - first(:nrank))
    allocate (part(size(x, 1), first(rank0 + 2) - first(rank0 + 1), nrank))
    call mpi_alltoallv(x, count, size(x, 1)*first(:nrank), mpi_double_precision, part, &
                       spread(size(part, 1)*size(part, 2), 1, nrank), &
                       [(size(part, 1)*size(part, 2)*r, r=0, nrank - 1)], mpi_double_precision, &
                       mpi_comm_world)
    associate (mine => x(:, first(rank0 + 1) + 1:first(rank0 + 2)))
      mine = part(:, :, 1)
      do r = 2, nrank
        mine = mine + part(:, :, r)
      end do
    end associate
    call gather_blocks(x, first)
  end subroutine total_matrix

  subroutine share_integers(x, rank)
    integer, intent(inout), contiguous :: x(:)
    integer, intent(in) :: rank

    call mpi_bcast(x, size(x), mpi_integer, rank - 1, mpi_comm_world)
  end subroutine share_integers

  subroutine share_reals(x, rank)
    real(wp), intent(inout), contiguous :: x(:)
    integer, intent(in) :: rank

    call mpi_bcast(x, size(x), mpi_double_precision, rank - 1, mpi_comm_world)
  end subroutine share_reals

  subroutine share_text(text, rank)
    character(:), allocatable, intent(inout) :: text
    integer, intent(in) :: rank
    integer :: length(1)

    length = len(text)
    call share_integers(length, rank)
    if (rank0 /= rank - 1) text = repeat(' ', length(1))
    call mpi_bcast(text, length(1), mpi_character, rank - 1, mpi_comm_world)
  end subroutine share_text

  subroutine gather_blocks(x, first)
    real(wp), intent(inout), contiguous :: x(:, :)
    integer, intent(in) :: first(:)
    integer :: count(nrank)

    if (nrank == 1) return
    count = size(x, 1)*(first(2:) - first(:nrank))
    call mpi_allgatherv(mpi_in_place, 0, mpi_double_precision, x, count, size(x, 1)*first(:nrank), &
                        mpi_double_precision, mpi_comm_world)
  end subroutine gather_blocks

end module base_comm
