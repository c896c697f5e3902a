!> WEDGE6: six-node wedge, linear on its triangles and along its height.
!!
!! Nodes:  lower triangle counter-clockwise seen from the upper one, then the upper (FEAP and Gmsh)
!! Parent: cube whose face eta+ is an edge, see collapsed_shape
!! Rule:   2 x 2 x 2 points of the cube
!! Source: Zienkiewicz and Taylor 2005
!! Limits: locks like Q1
module elmt_wedge6
  use base_kinds, only: wp
  use collapsed_shape, only: fold_triangle, cube_rule
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: linear, join_faces
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_WEDGE = 13

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'WEDGE6'
    row%deck_nodes = 6
    row%degree = 1
    row%source = 'linear wedge, 6 nodes'
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
    real(wp), intent(out) :: shp(:)     !! (6)
    real(wp), intent(out) :: dshp(:, :) !! (3, 6)
    real(wp) :: t(3), dt(2, 3), f(2), d(2)
    integer :: a, k

    associate (unused => cell); end associate
    call fold_triangle(xi(:2), t(2:3), dt(:, 2:3))
    t(1) = 1.0_wp - t(2) - t(3)
    dt(:, 1) = -dt(:, 2) - dt(:, 3)
    call linear(xi(3), f, d)
    do k = 1, 2
      do a = 1, 3
        shp(3*k - 3 + a) = t(a)*f(k)
        dshp(:2, 3*k - 3 + a) = dt(:, a)*f(k)
        dshp(3, 3*k - 3 + a) = t(a)*d(k)
      end do
    end do
  end subroutine functions

  !> Three quadrilaterals, an edge and two triangles. VTK's triangles turn the other way.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology
    logical :: on(6, 6)

    associate (unused => cell); end associate
    on = .false.
    on([1, 3, 4, 6], 1) = .true.
    on([2, 3, 5, 6], 2) = .true.
    on([1, 2, 4, 5], 3) = .true.
    on([3, 6], 4) = .true.
    on([1, 2, 3], 5) = .true.
    on([4, 5, 6], 6) = .true.
    call join_faces(on, topology)
    topology%vtk = VTK_WEDGE
    topology%vtk_node = [1, 3, 2, 4, 6, 5]
  end subroutine set_topology

end module elmt_wedge6
