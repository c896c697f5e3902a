!> TET10: ten-node tetrahedron, quadratic Lagrange functions.
!!
!! Nodes:  corners 1 to 4, then middles of 12 23 31 14 24 34 (FEAP and VTK order)
!! Parent: corners (0,0,0), (1,0,0), (0,1,0), (0,0,1)
!! Rule:   4 points, exact to degree 2; QUADrature q > 2: q x q x q points of a collapsed cube
!! Source: Zienkiewicz and Taylor 2005
module elmt_tet10
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: tensor_rule, join_faces
  use solid_form, only: form
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_QUADRATIC_TETRA = 24
  integer, parameter :: EDGE(2, 6) = reshape([1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6])

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'TET10'
    row%deck_nodes = 10
    row%source = 'quadratic tetrahedron, 10 nodes'
    row%rule => set_rule
    row%functions => functions
    row%topology => set_topology
    row%form => form
  end function describe

  !> Four points, or a Gauss cube folded onto the tetrahedron.
  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    real(wp) :: a, b, t(3)
    integer :: i

    associate (unused => cell); end associate
    if (max(q, qz) > 2) then
      call tensor_rule([max(q, qz), max(q, qz), max(q, qz)], 0, 0, rule)
      do i = 1, rule%nq
        t = 0.5_wp*(1.0_wp + rule%xi(:, i))
        rule%wgt(i) = rule%wgt(i)*0.125_wp*(1.0_wp - t(3))**2*(1.0_wp - t(2))
        rule%xi(:, i) = [t(1)*(1.0_wp - t(2))*(1.0_wp - t(3)), t(2)*(1.0_wp - t(3)), t(3)]
      end do
      return
    end if
    a = (5.0_wp + 3.0_wp*sqrt(5.0_wp))/20.0_wp
    b = (5.0_wp - sqrt(5.0_wp))/20.0_wp
    rule%nq = 4
    rule%xi = reshape([b, b, b, a, b, b, b, a, b, b, b, a], [3, 4])
    rule%wgt = [(1.0_wp/24.0_wp, i=1, 4)]
  end subroutine set_rule

  !> Quadratic functions in the four volume coordinates v.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (10)
    real(wp), intent(out) :: dshp(:, :) !! (3, 10)

    real(wp) :: v(4), dv(3, 4)
    integer :: i, j, a

    associate (unused => cell); end associate
    v = [1.0_wp - xi(1) - xi(2) - xi(3), xi(1), xi(2), xi(3)]
    dv = 0.0_wp
    dv(:, 1) = -1.0_wp
    do i = 1, 3
      dv(i, i + 1) = 1.0_wp
    end do
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

  !> Face i lies opposite corner 5 - i: 123, 124, 134, 234.
  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical :: on(10, 4)
    integer :: i

    associate (unused => cell); end associate
    on = .true.
    do i = 1, 4
      on(5 - i, i) = .false.
      on(5:, i) = all(EDGE /= 5 - i, dim=1)
    end do
    call join_faces(on, topology)
    topology%vtk = VTK_QUADRATIC_TETRA
    topology%vtk_node = [(i, i=1, 10)]
  end subroutine set_topology

end module elmt_tet10
