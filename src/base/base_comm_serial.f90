!> Processes (ranks) that compute one model together: the version for a single process.
!!
!! `make MPI=1` compiles base_comm_mpi.f90 instead. Both files contain the same module with the same
!! names, and the comments here say what each procedure does with any number of ranks. With a single
!! rank, each of them does nothing or returns the value of that rank.
module base_comm
  use base_kinds, only: wp
  use base_system, only: finish
  implicit none
  private
  public :: start_comm, stop_comm, rank_count, this_rank, owns, is_root, communicator, ranks_here, &
            largest, total, share, gather_blocks

  !> share(x, rank) gives all ranks the value that x has on the given rank.
  interface share
    module procedure share_integers, share_reals, share_text
  end interface share

  !> The largest value that the argument has on any rank.
  interface largest
    module procedure largest_integer, largest_real
  end interface largest

  !> total(x) replaces x by its sum over all ranks. The terms are added in the order of the ranks,
  !! so that the sum does not depend on which rank is ready first.
  interface total
    module procedure total_scalar, total_matrix
  end interface total

contains

  !> Join the other ranks. From then on, only the first rank writes to the screen.
  subroutine start_comm()
  end subroutine start_comm

  !> End the process when the other ranks end too. After an error, ranks that do not end within a
  !! given time are aborted.
  subroutine stop_comm(code, text)
    integer, intent(in) :: code      !! exit code
    character(*), intent(in) :: text !! shown if the other ranks do not end

    associate (unused => text); end associate
    call finish(code)
  end subroutine stop_comm

  !> Number of ranks.
  pure integer function rank_count()

    rank_count = 1
  end function rank_count

  !> Number of this rank, from 1.
  pure integer function this_rank()

    this_rank = 1
  end function this_rank

  !> Is item i of a list assigned to this rank? Each item is assigned to one rank, for work that the
  !! ranks share.
  pure logical function owns(i)
    integer, intent(in) :: i !! from 1

    associate (unused => i); end associate
    owns = .true.
  end function owns

  !> Is this the first rank, which writes all files and the screen output?
  pure logical function is_root()

    is_root = .true.
  end function is_root

  !> Communicator of all ranks, to be passed to MUMPS, which ignores it in a build without MPI.
  integer function communicator()

    communicator = 0
  end function communicator

  !> Number of ranks on the machine of this rank, which share its memory.
  pure integer function ranks_here()

    ranks_here = 1
  end function ranks_here

  integer function largest_integer(i) result(largest)
    integer, intent(in) :: i

    largest = i
  end function largest_integer

  real(wp) function largest_real(x) result(largest)
    real(wp), intent(in) :: x

    largest = x
  end function largest_real

  subroutine total_scalar(x)
    real(wp), intent(inout) :: x

    associate (unused => x); end associate
  end subroutine total_scalar

  subroutine total_matrix(x)
    real(wp), intent(inout), contiguous :: x(:, :)

    associate (unused => x); end associate
  end subroutine total_matrix

  subroutine share_integers(x, rank)
    integer, intent(inout), contiguous :: x(:)
    integer, intent(in) :: rank !! from 1

    associate (unused => x, unused_too => rank); end associate
  end subroutine share_integers

  subroutine share_reals(x, rank)
    real(wp), intent(inout), contiguous :: x(:)
    integer, intent(in) :: rank !! from 1

    associate (unused => x, unused_too => rank); end associate
  end subroutine share_reals

  !> On entry, the length of the text may differ from rank to rank.
  subroutine share_text(text, rank)
    character(:), allocatable, intent(inout) :: text
    integer, intent(in) :: rank !! from 1

    associate (unused => text, unused_too => rank); end associate
  end subroutine share_text

  !> Give every rank all columns of x. On entry, each rank r has set only its columns, first(r) + 1
  !! to first(r + 1).
  subroutine gather_blocks(x, first)
    real(wp), intent(inout), contiguous :: x(:, :)
    integer, intent(in) :: first(:)  !! (rank_count() + 1) ascending from 0

    associate (unused => x, unused_too => first); end associate
  end subroutine gather_blocks

end module base_comm
