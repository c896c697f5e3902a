!> TET10: ten-node tetrahedron, quadratic Lagrange functions.
!!
!! Nodes:  corners 1 to 4, then middles of 12 23 31 14 24 34 (FEAP and VTK order)
!! Parent: cube, see collapsed_shape
!! Rule:   4 points, exact to degree 2; QUADrature q > 2: q x q x q points of the cube; for masses q
!!         is at least 4
!! Source: Zienkiewicz and Taylor 2005
module elmt_tet10
  use base_kinds, only: wp
  use collapsed_shape, only: fold_tetrahedron, unfold_rule, collapsed_rule
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use elmt_tet4, only: tetrahedron_faces, TETRAHEDRON
  use hexa_shape, only: join_faces
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_QUADRATIC_TETRA = 24
  integer, parameter :: EDGE(2, 6) = reshape([1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6])

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='TET10', deck_nodes=10, degree=2, mass_points=4, &
                    source='quadratic tetrahedron, 10 nodes', rule=set_rule, &
                    functions=functions, topology=set_topology, form=form)
  end function describe

  !> Set four points of the tetrahedron, or the Gauss points of the cube.
  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    real(wp) :: a, b

    if (max(q, qz) > 2) then
      call collapsed_rule(cell, q, qz, rule)
      return
    end if
    a = (5.0_wp + 3.0_wp*sqrt(5.0_wp))/20.0_wp
    b = (5.0_wp - sqrt(5.0_wp))/20.0_wp
    call unfold_rule(reshape([b, b, b, a, b, b, b, a, b, b, b, a], [3, 4]), &
                     [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp]/24.0_wp, rule)
  end subroutine set_rule

  !> Evaluate the quadratic functions of the four volume coordinates v.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (10)
    real(wp), intent(out) :: dshp(:, :) !! (3, 10)

    real(wp) :: v(4), dv(3, 4)
    integer :: i, j, a

    associate (unused => cell); end associate
    call fold_tetrahedron(xi, v, dv)
    do i = 1, 4
      shp(i) = v(i)*(2.0_wp*v(i) - 1.0_wp)
      dshp(:, i) = (4.0_wp*v(i) - 1.0_wp)*dv(:, i)
    end do
    do a = 1, 6
      i = EDGE(1, a)
      j = EDGE(2, a)
      shp(4 + a) = 4.0_wp*v(i)*v(j)
      dshp(:, 4 + a) = 4.0_wp*(v(i)*dv(:, j) + v(j)*dv(:, i))
    end do
  end subroutine functions

  !> Set the faces: corners as in TET4; a mid-edge node lies on a face if both ends of its edge do.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical :: on(10, 6)
    integer :: i

    associate (unused => cell); end associate
    on(:4, :) = tetrahedron_faces()
    do i = 1, 6
      on(4 + i, :) = on(EDGE(1, i), :) .and. on(EDGE(2, i), :)
    end do
    call join_faces(on, topology)
    topology%vtk = VTK_QUADRATIC_TETRA
    topology%vtk_node = [(i, i=1, 10)]
    topology%shape = 'tetrahedron'
    topology%corner = [1, 2, 3, 4]
    allocate (topology%xr(3, 10))
    topology%xr(:, :4) = TETRAHEDRON
    topology%xr(:, 5:) = 0.5_wp*(TETRAHEDRON(:, EDGE(1, :)) + TETRAHEDRON(:, EDGE(2, :)))
    topology%gmsh = 11
    topology%gmsh_node = [1, 2, 3, 4, 5, 6, 7, 8, 10, 9]
  end subroutine set_topology

end module elmt_tet10
