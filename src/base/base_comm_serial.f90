!> Processes (ranks) that compute one model together: the version for a single process.
!!
!! `make MPI=1` compiles base_comm_mpi.f90 instead. Both files contain the same module with the same
!! names, and the comments here say what a procedure does on any number of ranks. On one rank, each
!! procedure does nothing or returns the value of that rank.
module base_comm
  use base_kinds, only: wp
  use base_system, only: finish
  implicit none
  private
  public :: start_comm, stop_comm, rank_count, this_rank, owns, is_root, communicator, ranks_here, &
            largest, total, share, gather_blocks

  !> share(x, rank) gives all ranks the value of one rank.
  interface share
    module procedure share_integers, share_reals, share_text
  end interface share

  !> The largest of the numbers that the ranks have.
  interface largest
    module procedure largest_integer, largest_real
  end interface largest

  !> total(x) adds the values of all ranks in the order of the ranks, so that the sum does not
  !! depend on which rank is faster.
  interface total
    module procedure total_scalar, total_matrix
  end interface total

contains

  !> Join the other ranks. From then on, only the first rank writes on the screen.
  subroutine start_comm()
  end subroutine start_comm

  !> End the process together with the other ranks. Ranks that do not end are stopped after a while.
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

  !> Does this rank form the derivatives of item i of a list that is divided among the ranks?
  pure logical function owns(i)
    integer, intent(in) :: i !! from 1

    associate (unused => i); end associate
    owns = .true.
  end function owns

  !> Is this the first rank, which writes all files and writes on the screen?
  pure logical function is_root()

    is_root = .true.
  end function is_root

  !> The ranks, in the form in which MUMPS is told of them; without MPI it ignores this number.
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

  !> The length may differ on the other ranks.
  subroutine share_text(text, rank)
    character(:), allocatable, intent(inout) :: text
    integer, intent(in) :: rank !! from 1

    associate (unused => text, unused_too => rank); end associate
  end subroutine share_text

  !> Give all ranks the columns that each rank has found; rank r has found columns first(r) + 1 to
  !! first(r + 1).
  subroutine gather_blocks(x, first)
    real(wp), intent(inout), contiguous :: x(:, :)
    integer, intent(in) :: first(:)  !! (rank_count() + 1) ascending from 0

    associate (unused => x, unused_too => first); end associate
  end subroutine gather_blocks

end module base_comm
