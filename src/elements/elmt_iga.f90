!> IGA: trivariate B-spline or NURBS element of any degree.
!!
!! Nodes:  control points in tensor order, direction 1 fastest
!! Rule:   (p+1) Gauss points in each direction
!! Source: Corbett and Sauer 2015, section 2.2, eqs (8) and (11) to (14)
module elmt_iga
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: spline, tensor_functions, make_rational, tensor_rule, tensor_marks, &
                        join_faces, MAX_DEGREE, VTK_BEZIER_HEXAHEDRON
  use solid_form, only: form
  implicit none
  private
  public :: describe

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='IGA', spline=.true., rule=set_rule, functions=functions, &
                    topology=set_topology, form=form, &
                    source='trivariate NURBS by Bezier extraction; Corbett and Sauer 2015, ' &
                    //'eqs (8) to (14)')
  end function describe

  !> Set p + 1 points in each direction. If q is given without qz, it is used in all three
  !! directions, because none of them is special.
  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    call tensor_rule(cell%degree + 1, q, merge(qz, q, qz > 0), rule)
  end subroutine set_rule

  !> Evaluate R_A = w_A N_A / W, where N_A is a product of functions of the three directions and W
  !! is the sum of all w_A N_A.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (ncp)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp)

    real(wp) :: f(MAX_DEGREE + 1, 3), d(MAX_DEGREE + 1, 3)
    integer :: n(3)

    n = cell%degree + 1
    call spline(cell%degree(1), cell%c1, xi(1), f(:, 1), d(:, 1))
    call spline(cell%degree(2), cell%c2, xi(2), f(:, 2), d(:, 2))
    call spline(cell%degree(3), cell%c3, xi(3), f(:, 3), d(:, 3))
    call tensor_functions(f(:n(1), 1), d(:n(1), 1), f(:n(2), 2), d(:n(2), 2), &
                          f(:n(3), 3), d(:n(3), 3), shp, dshp)
    if (allocated(cell%w)) call make_rational(cell%w, shp, dshp)
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    call join_faces(tensor_marks(cell), topology)
    topology%vtk = VTK_BEZIER_HEXAHEDRON
  end subroutine set_topology

end module elmt_iga
