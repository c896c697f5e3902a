!> PYRAMID5: five-node pyramid, the tri-linear hexahedron whose upper face is collapsed to a point.
!!
!! Nodes:  base counter-clockwise seen from the top, then the top (FEAP, VTK and Gmsh order)
!! Rule:   2 x 2 x 2 Gauss points: none at the top, where the map is singular
!! Source: functions of Q1, the four upper ones added; rational in the pyramid's own coordinates,
!!         bilinear on the base and linear on the triangles: it joins hexahedra and tetrahedra
!! Limits: locks like Q1; must not be evaluated at zeta = +1
module elmt_pyramid5
  use base_kinds, only: wp
  use collapsed_shape, only: cube_rule
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: linear, join_faces, CORNER
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_PYRAMID = 14

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'PYRAMID5'
    row%deck_nodes = 5
    row%degree = 1
    row%source = 'linear pyramid, 5 nodes: Q1 with its upper face collapsed'
    row%rule => set_rule
    row%functions => functions
    row%topology => set_topology
    row%form => form
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    associate (unused => cell); end associate
    call cube_rule(max(q, qz, 2), rule)
  end subroutine set_rule

  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (5)
    real(wp), intent(out) :: dshp(:, :) !! (3, 5)
    real(wp) :: f(2, 3), d(2, 3)
    integer :: a, i, j

    associate (unused => cell); end associate
    do a = 1, 3
      call linear(xi(a), f(:, a), d(:, a))
    end do
    do a = 1, 4
      i = (CORNER(1, a) + 3)/2
      j = (CORNER(2, a) + 3)/2
      shp(a) = f(i, 1)*f(j, 2)*f(1, 3)
      dshp(1, a) = d(i, 1)*f(j, 2)*f(1, 3)
      dshp(2, a) = f(i, 1)*d(j, 2)*f(1, 3)
      dshp(3, a) = f(i, 1)*f(j, 2)*d(1, 3)
    end do
    shp(5) = f(2, 3)
    dshp(:, 5) = [0.0_wp, 0.0_wp, d(2, 3)]
  end subroutine functions

  !> Four triangles, the base, and the top.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology
    logical :: on(5, 6)
    integer :: a

    associate (unused => cell); end associate
    do a = 1, 2
      on(:4, 2*a - 1) = CORNER(a, :4) < 0
      on(:4, 2*a) = CORNER(a, :4) > 0
    end do
    on(:4, 5) = .true.
    on(:4, 6) = .false.
    on(5, :) = .true.
    on(5, 5) = .false.
    call join_faces(on, topology)
    topology%vtk = VTK_PYRAMID
    topology%vtk_node = [1, 2, 3, 4, 5]
  end subroutine set_topology

end module elmt_pyramid5
