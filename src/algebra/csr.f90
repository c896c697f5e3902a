!> Block matrices under one name, for the rest of the program.
module csr
  use csr_pattern, only: block_matrix_t, clique_t, new_pattern, element_map, block_position, &
                         set_zero
  use csr_scatter, only: add_element, add_batch
  use csr_product, only: multiply, multiply_free
  implicit none
  private
  public :: block_matrix_t, clique_t, new_pattern, element_map, block_position, set_zero
  public :: add_element, add_batch
  public :: multiply, multiply_free
end module csr
