!> TET4: four-node tetrahedron, linear functions.
!!
!! Nodes:  1, 2, 3 counter-clockwise seen from 4 (FEAP, VTK and Gmsh order)
!! Parent: cube, see collapsed_shape
!! Rule:   one point; QUADrature q > 1: q x q x q points of the cube; for masses q is at least 3
!! Source: Zienkiewicz and Taylor 2005
!! Limits: shear locking in bending, volumetric locking for nu above 0.4, unlike TET10
module elmt_tet4
  use base_kinds, only: wp
  use collapsed_shape, only: fold_tetrahedron, unfold_rule, collapsed_rule
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: join_faces
  use solid_form, only: form
  implicit none
  private
  public :: describe, tetrahedron_faces, TETRAHEDRON

  integer, parameter :: VTK_TETRA = 10
  !> Corners of the reference tetrahedron.
  real(wp), parameter :: TETRAHEDRON(3, 4) = &
                         reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 4])*1.0_wp

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='TET4', deck_nodes=4, degree=1, mass_points=3, &
                    source='linear tetrahedron, 4 nodes; it locks, so use it only inside bodies', &
                    rule=set_rule, functions=functions, topology=set_topology, form=form)
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule
    real(wp), parameter :: MIDDLE(3, 1) = 0.25_wp

    if (max(q, qz) > 1) then
      call collapsed_rule(cell, q, qz, rule)
    else
      call unfold_rule(MIDDLE, [1.0_wp/6.0_wp], rule)
    end if
  end subroutine set_rule

  !> Evaluate the volume coordinates.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (4)
    real(wp), intent(out) :: dshp(:, :) !! (3, 4)

    associate (unused => cell); end associate
    call fold_tetrahedron(xi, shp, dshp)
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology
    integer :: i

    associate (unused => cell); end associate
    call join_faces(tetrahedron_faces(), topology)
    topology%vtk = VTK_TETRA
    topology%vtk_node = [(i, i=1, 4)]
    topology%shape = 'tetrahedron'
    topology%corner = topology%vtk_node
    topology%xr = TETRAHEDRON
    topology%gmsh = 4
  end subroutine set_topology

  !> Nodes on each face of the parent cube; the faces become four triangles, an edge and a point.
  pure function tetrahedron_faces() result(on)
    logical :: on(4, 6)

    on = .false.
    on([1, 3, 4], 1) = .true.
    on([2, 3, 4], 2) = .true.
    on([1, 2, 4], 3) = .true.
    on([3, 4], 4) = .true.
    on([1, 2, 3], 5) = .true.
    on(4, 6) = .true.
  end function tetrahedron_faces

end module elmt_tet4
