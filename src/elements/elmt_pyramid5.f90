!> PYRAMID5: five-node pyramid, the trilinear hexahedron whose upper face is collapsed to a point.
!!
!! Nodes:  base counter-clockwise seen from the apex, then the apex (FEAP, VTK and Gmsh order)
!! Rule:   2 x 2 x 2 Gauss points: none at the apex, where the map is singular; 3 x 3 x 3 for masses
!! Source: the functions of Q1, with the four of the upper face added up. They are rational in the
!!         pyramid's own coordinates, bilinear on the base and linear on the triangles, so that the
!!         pyramid joins hexahedra and tetrahedra
!! Limits: locks like Q1; must not be evaluated at zeta = +1
module elmt_pyramid5
  use base_kinds, only: wp
  use collapsed_shape, only: collapsed_rule
  use element_type, only: element_t, cell_t, topology_t
  use hexa_shape, only: linear, corner_functions, join_faces, CORNER_MARKS
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_PYRAMID = 14

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='PYRAMID5', deck_nodes=5, degree=1, mass_points=3, &
                    source='linear pyramid, 5 nodes: Q1 with its upper face collapsed to a point', &
                    rule=collapsed_rule, functions=functions, topology=set_topology, form=form)
  end function describe

  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (5)
    real(wp), intent(out) :: dshp(:, :) !! (3, 5)
    real(wp) :: f(2), d(2)

    associate (unused => cell); end associate
    call corner_functions(1, 4, xi, shp, dshp)
    call linear(xi(3), f, d)
    shp(5) = f(2)
    dshp(:, 5) = [0.0_wp, 0.0_wp, d(2)]
  end subroutine functions

  !> Set the faces: four triangles, the base, and the apex.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology
    logical :: on(5, 6)

    associate (unused => cell); end associate
    on(:4, :) = CORNER_MARKS(:4, :)
    on(5, :) = .true.
    on(5, 5) = .false.
    call join_faces(on, topology)
    topology%vtk = VTK_PYRAMID
    topology%vtk_node = [1, 2, 3, 4, 5]
    topology%shape = 'pyramid'
    topology%corner = topology%vtk_node
    topology%xr = transpose(merge(1.0_wp, 0.0_wp, CORNER_MARKS(:5, [2, 4, 6])))
    topology%gmsh = 7
  end subroutine set_topology

end module elmt_pyramid5
