!> Q2: 27-node hexahedron, triquadratic Lagrange functions.
!!
!! Nodes:  tensor order, xi fastest, then eta, then zeta, each -1, 0, 1
!! Rule:   3 x 3 x 3 Gauss points
!! Source: Corbett and Sauer 2015, section 4.1
module elmt_q2
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: quadratic, tensor_functions, tensor_rule, tensor_marks, join_faces, &
                        VTK_BEZIER_HEXAHEDRON
  use solid_form, only: form
  implicit none
  private
  public :: describe, FEAP27

  !> Position of each of FEAP's 27 element nodes in the tensor order.
  integer, parameter :: FEAP27(27) = [1, 3, 9, 7, 19, 21, 27, 25, 2, 6, 8, 4, 20, 24, 26, 22, &
                                      10, 12, 18, 16, 5, 23, 13, 15, 11, 17, 14]

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q2', deck_nodes=27, degree=2, deck_order=FEAP27, &
                    source='triquadratic Lagrange hexahedron, 27 nodes', rule=set_rule, &
                    functions=functions, topology=set_topology, form=form)
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    associate (unused => cell); end associate
    call tensor_rule([3, 3, 3], q, qz, rule)
  end subroutine set_rule

  !> Evaluate the products of quadratic functions.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (27)
    real(wp), intent(out) :: dshp(:, :) !! (3, 27)

    real(wp) :: f(3, 3), d(3, 3)
    integer :: i

    associate (unused => cell); end associate
    do i = 1, 3
      call quadratic(xi(i), f(:, i), d(:, i))
    end do
    call tensor_functions(f(:, 1), d(:, 1), f(:, 2), d(:, 2), f(:, 3), d(:, 3), shp, dshp)
  end subroutine functions

  !> Set the faces and the order of the nodes in VTK: corners, edges, faces and middle, as in a VTK
  !! Lagrange or Bezier hexahedron of degree 2 (VTK files of version 2.2 and later).
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    type(cell_t) :: tensor
    integer :: i, j, k

    associate (unused => cell); end associate
    tensor%degree = 2
    call join_faces(tensor_marks(tensor), topology)
    topology%vtk = VTK_BEZIER_HEXAHEDRON
    topology%vtk_node = [1, 3, 9, 7, 19, 21, 27, 25, 2, 6, 8, 4, 20, 24, 26, 22, 10, 12, 18, 16, &
                         13, 15, 11, 17, 5, 23, 14]
    topology%shape = 'hexahedron'
    allocate (topology%corner, source=FEAP27(:8)) ! an assignment reads the bounds of unset arrays
    topology%xr = 0.5_wp*reshape([((([i, j, k], i=0, 2), j=0, 2), k=0, 2)], [3, 27])
    topology%gmsh = 12
    topology%gmsh_node = [1, 3, 9, 7, 19, 21, 27, 25, 2, 4, 10, 6, 12, 8, 18, 16, 20, 22, 24, 26, &
                          5, 11, 13, 15, 17, 23, 14]
  end subroutine set_topology

end module elmt_q2
