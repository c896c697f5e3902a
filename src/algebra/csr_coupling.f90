!> Rectangular blocks of a sparse matrix that couple rows of some nodes with columns of other nodes,
!! as contact does. If the matrix is symmetric, only the symmetric part of the coupling is added.
module csr_coupling
  use base_kinds, only: wp
  use csr, only: block_matrix_t, block_position
  implicit none
  private
  public :: coupling_map, add_coupling

contains

  !> Find the block positions of pairs of a row node and a column node. A negative position means
  !! that the matrix stores the transpose of the block, and 0 that the pair is not in the pattern.
  pure subroutine coupling_map(a, rows, cols, map)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: rows(:), cols(:) !! nodes
    integer, intent(out) :: map(:, :)       !! (size(rows), size(cols))
    integer :: i, j

    do j = 1, size(cols)
      do i = 1, size(rows)
        if (a%symmetric .and. rows(i) > cols(j)) then
          map(i, j) = -block_position(a, cols(j), rows(i))
        else
          map(i, j) = block_position(a, rows(i), cols(j))
        end if
      end do
    end do
  end subroutine coupling_map

  !> Add the derivatives of the forces on the row nodes with respect to the column nodes.
  pure subroutine add_coupling(a, rows, cols, map, k)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: rows(:), cols(:)
    integer, intent(in) :: map(:, :)  !! (size(rows), size(cols)), see coupling_map
    real(wp), intent(in) :: k(:, :)   !! (>= 3*size(rows), >= 3*size(cols))
    real(wp) :: block(3, 3)
    integer :: i, j, p

    do j = 1, size(cols)
      do i = 1, size(rows)
        p = map(i, j)
        block = k(3*i - 2:3*i, 3*j - 2:3*j)
        if (a%symmetric) then
          if (rows(i) == cols(j)) then
            block = 0.5_wp*(block + transpose(block))
          else if (p < 0) then
            block = 0.5_wp*transpose(block)
          else
            block = 0.5_wp*block
          end if
        end if
        p = abs(p)
        a%val(:, :, p) = a%val(:, :, p) + block
      end do
    end do
  end subroutine add_coupling

end module csr_coupling
