!> Q1: eight-node hexahedron, trilinear Lagrange functions.
!!
!! Nodes:  counter-clockwise from (-,-), lower plane first (FEAP and VTK order)
!! Rule:   2 x 2 x 2 Gauss points
!! Source: Corbett and Sauer 2015, section 4.1
!! Limits: shear locking in bending, volumetric locking for nu above 0.49
module elmt_q1
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: corner_functions, tensor_rule, join_faces, CORNER_MARKS
  use solid_form, only: form
  use solid_simd, only: choose_batch
  implicit none
  private
  public :: describe, set_rule, functions, set_topology

  integer, parameter :: VTK_HEXAHEDRON = 12

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q1', deck_nodes=8, degree=1, source='trilinear hexahedron', &
                    rule=set_rule, functions=functions, topology=set_topology, form=form)
    call choose_batch(row%form_batch)
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    associate (unused => cell); end associate
    call tensor_rule([2, 2, 2], q, qz, rule)
  end subroutine set_rule

  !> Evaluate the products of linear functions.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (8)
    real(wp), intent(out) :: dshp(:, :) !! (3, 8)

    associate (unused => cell); end associate
    call corner_functions(1, 8, xi, shp, dshp)
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    associate (unused => cell); end associate
    call join_faces(CORNER_MARKS, topology)
    topology%vtk = VTK_HEXAHEDRON
    topology%vtk_node = [1, 2, 3, 4, 5, 6, 7, 8]
    topology%shape = 'hexahedron'
    topology%corner = topology%vtk_node
    topology%xr = transpose(merge(1.0_wp, 0.0_wp, CORNER_MARKS(:, [2, 4, 6])))
    topology%gmsh = 5
  end subroutine set_topology

end module elmt_q1
