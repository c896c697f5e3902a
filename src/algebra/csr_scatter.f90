!> Adds element matrices to a sparse matrix through precomputed block positions.
module csr_scatter
  use base_kinds, only: wp
  use element_type, only: NB
  use csr_pattern, only: block_matrix_t
  implicit none
  private
  public :: add_element, add_batch

contains

  !> Add one element matrix. A symmetric matrix takes what lies on and above its diagonal: k must
  !! then be symmetric.
  pure subroutine add_element(a, map, k)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: map(:, :)  !! (nen, nen) block positions, 0: not stored (element_map)
    real(wp), intent(in) :: k(:, :)   !! (3*nen, 3*nen)

    integer :: b1, b2, j, p

    do b2 = 1, size(map, 2)
      do b1 = 1, size(map, 1)
        p = map(b1, b2)
        if (p == 0) cycle
        do j = 1, 3
          a%val(1, j, p) = a%val(1, j, p) + k(3*b1 - 2, 3*b2 - 3 + j)
          a%val(2, j, p) = a%val(2, j, p) + k(3*b1 - 1, 3*b2 - 3 + j)
          a%val(3, j, p) = a%val(3, j, p) + k(3*b1, 3*b2 - 3 + j)
        end do
      end do
    end do
  end subroutine add_element

  !> Add a batch of elements, the last one perhaps not full.
  pure subroutine add_batch(a, map, k)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: map(:, :, :)      !! (nen, nen, n) positions, n <= NB elements in use
    real(wp), intent(in) :: k(:, :, :, :, :) !! (NB, 3, 3, nen, nen), see element_batch_i

    call add_batch_to(size(map, 1), size(map, 3), size(a%val, 3), map, k, a%val)
  end subroutine add_batch

  !> Explicit shapes: the addresses are then known to the compiler.
  pure subroutine add_batch_to(nen, n, nblock, map, k, val)
    integer, intent(in) :: nen, n, nblock
    integer, intent(in) :: map(nen, nen, n)
    real(wp), intent(in) :: k(NB, 3, 3, nen, nen)
    real(wp), intent(inout) :: val(3, 3, nblock)

    integer :: b1, b2, e, j, p

    do e = 1, n
      do b2 = 1, nen
        do b1 = 1, nen
          p = map(b1, b2, e)
          if (p == 0) cycle
          do j = 1, 3
            val(1, j, p) = val(1, j, p) + k(e, 1, j, b1, b2)
            val(2, j, p) = val(2, j, p) + k(e, 2, j, b1, b2)
            val(3, j, p) = val(3, j, p) + k(e, 3, j, b1, b2)
          end do
        end do
      end do
    end do
  end subroutine add_batch_to

end module csr_scatter
