!> Q1: eight-node hexahedron, tri-linear Lagrange functions.
!!
!! Nodes:  counter-clockwise from (-,-), lower plane first (FEAP and VTK order)
!! Rule:   2 x 2 x 2 Gauss points
!! Source: Corbett and Sauer 2015, section 4.1
!! Limits: locks in bending and above nu = 0.49
module elmt_q1
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: linear, tensor_rule, join_faces, CORNER
  use solid_form, only: form
  use solid_simd, only: choose_batch
  implicit none
  private
  public :: describe, set_rule, functions, set_topology

  integer, parameter :: VTK_HEXAHEDRON = 12

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'Q1'
    row%deck_nodes = 8
    row%degree = 1
    row%source = 'tri-linear hexahedron'
    row%rule => set_rule
    row%functions => functions
    row%topology => set_topology
    row%form => form
    call choose_batch(row%form_batch)
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    associate (unused => cell); end associate
    call tensor_rule([2, 2, 2], q, qz, rule)
  end subroutine set_rule

  !> Products of linear functions.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (8)
    real(wp), intent(out) :: dshp(:, :) !! (3, 8)

    real(wp) :: f(2, 3), d(2, 3)
    integer :: a, n(3)

    associate (unused => cell); end associate
    do a = 1, 3
      call linear(xi(a), f(:, a), d(:, a))
    end do
    do a = 1, 8
      n = (CORNER(:, a) + 3)/2
      shp(a) = f(n(1), 1)*f(n(2), 2)*f(n(3), 3)
      dshp(1, a) = d(n(1), 1)*f(n(2), 2)*f(n(3), 3)
      dshp(2, a) = f(n(1), 1)*d(n(2), 2)*f(n(3), 3)
      dshp(3, a) = f(n(1), 1)*f(n(2), 2)*d(n(3), 3)
    end do
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical :: on(8, 6)
    integer :: a

    associate (unused => cell); end associate
    do a = 1, 3
      on(:, 2*a - 1) = CORNER(a, :) < 0
      on(:, 2*a) = CORNER(a, :) > 0
    end do
    call join_faces(on, topology)
    topology%vtk = VTK_HEXAHEDRON
    topology%vtk_node = [1, 2, 3, 4, 5, 6, 7, 8]
  end subroutine set_topology

end module elmt_q1
