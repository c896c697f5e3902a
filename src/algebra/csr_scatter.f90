!> Adds element matrices to a sparse matrix through precomputed block positions.
module csr_scatter
  use base_kinds, only: wp
  use element_type, only: NB
  use csr_pattern, only: block_matrix_t
  implicit none
  private
  public :: add_element, add_batch

contains

  !> Add one element matrix. A symmetric matrix takes what lies on and above its diagonal: k must be symmetric.
  pure subroutine add_element(a, map, k)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: map(:, :)  !! (nen, nen) block positions, 0: not stored (csr, element_map)
    real(wp), intent(in) :: k(:, :)   !! (3*nen, 3*nen)

    integer :: b1, b2, p

    do b2 = 1, size(map, 2)
      do b1 = 1, size(map, 1)
        p = map(b1, b2)
        if (p == 0) cycle
        a%val(:, 1, p) = a%val(:, 1, p) + k(3 * b1 - 2:3 * b1, 3 * b2 - 2)
        a%val(:, 2, p) = a%val(:, 2, p) + k(3 * b1 - 2:3 * b1, 3 * b2 - 1)
        a%val(:, 3, p) = a%val(:, 3, p) + k(3 * b1 - 2:3 * b1, 3 * b2)
      end do
    end do
  end subroutine add_element

  !> Add a batch of elements, the last one perhaps not full.
  pure subroutine add_batch(a, map, k)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: map(:, :, :)        !! (nen, nen, n) block positions of the n <= NB elements in use
    real(wp), intent(in) :: k(:, :, :, :, :)   !! (NB, 3, 3, nen, nen), see element_batch_i

    real(wp) :: block(9, NB)
    integer :: b1, b2, e

    do b2 = 1, size(map, 2)
      do b1 = 1, size(map, 1)
        ! Symmetric matrices skip pairs element by element: node numbers decide.
        if (all(map(b1, b2, :) == 0)) cycle
        block = reshape(transpose(reshape(k(:, :, :, b1, b2), [NB, 9])), [9, NB])
        do e = 1, size(map, 3)
          if (map(b1, b2, e) > 0) call add_block(a%val(:, :, map(b1, b2, e)), block(:, e))
        end do
      end do
    end do
  end subroutine add_batch

  !> val = val + block.
  pure subroutine add_block(val, block)
    real(wp), intent(inout) :: val(9)
    real(wp), intent(in) :: block(9)

    val = val + block
  end subroutine add_block

end module csr_scatter
