!> Q1E9: eight-node hexahedron with nine enhanced modes, condensed in the element.
!!
!!   F = F_u + (j0/j) [sum_i a_i x xi_i e_i] J0^-1
!!
!! F_u is the deformation gradient of the displacements, J the derivative of the reference position
!! with respect to the parent coordinates xi, and j = det J; J0 and j0 are J and j at the centre.
!!
!! Nodes, functions, rule: as Q1
!! History: nine parameters, then m and L (element_form_i)
!! Source:  Simo and Armero 1992; Corbett and Sauer 2015, section 4.1
!! Limits:  hourglass modes in strong compression, which cause negative pivots
module elmt_q1e9
  use element_type, only: element_t
  use elmt_q1, only: set_rule, functions, set_topology
  use hexa_shape, only: nine_modes
  use solid_form, only: form
  use solid_simd, only: choose_batch
  implicit none
  private
  public :: describe

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q1E9', deck_nodes=8, degree=1, &
                    source='trilinear hexahedron, nine enhanced modes (Simo and Armero 1992)', &
                    nmode=3, rule=set_rule, functions=functions, topology=set_topology, &
                    modes=nine_modes, form=form)
    call choose_batch(row%form_batch)
  end function describe

end module elmt_q1e9
