!> Q1N: linear hexahedron whose face zeta = -1 is isogeometric: Q1Np.t for any p and t.
!!
!! Nodes:  control points of zeta = -1, xi fastest, or in the order of an operator of the whole
!!         element (any number of them); then the corners of zeta = +1, counter-clockwise from (-,-)
!! Rule:   (p+1) x (p+1) x 2 Gauss points, where p is the degree of the surface in each direction
!!         after RAISe
!! Source: Corbett and Sauer 2015, section 2.3, eq. (15)
!! Limits: locks like Q1; a collapsed face zeta = +1 (prism) must not be evaluated at zeta = +1
module elmt_q1n2
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: linear, corner_functions, tensor_rule, CORNER_MARKS
  use solid_form, only: form
  use surface_shape, only: surface_count, layer_functions, layer_faces
  implicit none
  private
  public :: describe, set_rule, functions, set_topology

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q1N', &
                    source='linear bulk, isogeometric surface; Corbett and Sauer 2015, eq. (15)', &
                    spline=.true., rule=set_rule, functions=functions, topology=set_topology, &
                    form=form)
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    call tensor_rule([cell%degree(1) + 1, cell%degree(2) + 1, 2], q, qz, rule)
  end subroutine set_rule

  !> Evaluate the surface functions times (1 - zeta)/2, and the trilinear functions of the four
  !! upper corners.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (ncp+4)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp+4)

    real(wp) :: f(2), d(2)
    integer :: ncp

    ncp = surface_count(cell)
    call linear(xi(3), f, d)
    call layer_functions(cell, xi, f(1), d(1), shp(:ncp), dshp(:, :ncp))
    call corner_functions(5, 8, xi, shp(ncp + 1:), dshp(:, ncp + 1:))
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    call layer_faces(cell, CORNER_MARKS(5:, :), topology)
  end subroutine set_topology

end module elmt_q1n2
