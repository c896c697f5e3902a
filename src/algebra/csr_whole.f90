!> Collects, on the first rank, the whole pattern of a matrix that the ranks share.
module csr_whole
  use base_agreement, only: agree
  use base_comm, only: is_root, rank_count, share, this_rank
  use base_error, only: error_t
  use csr, only: block_matrix_t, clique_t, new_pattern
  implicit none
  private
  public :: gather_pattern

contains

  !> Join the patterns of all ranks in a matrix of zeros. All ranks must call this procedure.
  subroutine gather_pattern(a, whole, error)
    type(block_matrix_t), intent(in) :: a
    type(block_matrix_t), intent(out) :: whole !! empty on the other ranks
    type(error_t), allocatable, intent(out) :: error
    type(clique_t) :: pairs(rank_count()) ! pairs of nodes with a block
    integer, allocatable :: row(:), col(:)
    integer :: i, n(1), p, r

    do r = 1, rank_count()
      n = size(a%col)
      call share(n, r)
      allocate (row(a%nnode + 1), col(n(1)))
      if (this_rank() == r) then
        row(:) = a%row
        col(:) = a%col
      end if
      call share(row, r)
      call share(col, r)
      if (is_root()) then
        allocate (pairs(r)%conn(2, n(1)))
        do i = 1, a%nnode
          do p = row(i), row(i + 1) - 1
            pairs(r)%conn(:, p) = [i, col(p)]
          end do
        end do
      end if
      deallocate (row, col)
    end do
    if (is_root()) call new_pattern(whole, a%nnode, pairs, a%symmetric, error)
    call agree(error)
  end subroutine gather_pattern

end module csr_whole
