!> Q2N: quadratic hexahedron whose face zeta = -1 is isogeometric: Q2Np.t for any p and t.
!!
!! Nodes:  control points of zeta = -1, xi fastest; then 9 nodes of zeta = 0 and 9 of zeta = +1,
!!         each in tensor order, xi fastest
!! Rule:   (p+1) x (p+1) x 3 Gauss points, where p is the degree of the surface in each direction;
!!         at least 3 points in each direction
!! Source: Corbett and Sauer 2015, section 2.3, eq. (16)
module elmt_q2n2
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: quadratic, tensor_functions, tensor_rule, tensor_marks
  use solid_form, only: form
  use surface_shape, only: surface_count, layer_functions, layer_faces
  implicit none
  private
  public :: describe

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q2N', spline=.true., rule=set_rule, functions=functions, &
                    topology=set_topology, form=form, &
                    source='quadratic bulk, isogeometric surface; Corbett and Sauer 2015, ' &
                    //'eq. (16)')
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    call tensor_rule([max(cell%degree(1), 2) + 1, max(cell%degree(2), 2) + 1, 3], q, qz, rule)
  end subroutine set_rule

  !> Evaluate the surface functions times the quadratic function of zeta = -1, and the triquadratic
  !! functions of the planes zeta = 0 and zeta = +1.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (ncp+18)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp+18)

    real(wp) :: f(3, 3), d(3, 3)
    integer :: i, ncp

    do i = 1, 3
      call quadratic(xi(i), f(:, i), d(:, i))
    end do
    ncp = surface_count(cell)
    call layer_functions(cell, xi, f(1, 3), d(1, 3), shp(:ncp), dshp(:, :ncp))
    call tensor_functions(f(:, 1), d(:, 1), f(:, 2), d(:, 2), f(2:, 3), d(2:, 3), &
                          shp(ncp + 1:), dshp(:, ncp + 1:))
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    type(cell_t) :: tensor
    logical :: on(27, 6)

    tensor%degree = 2
    on = tensor_marks(tensor)
    call layer_faces(cell, on(10:, :), topology)
  end subroutine set_topology

end module elmt_q2n2
