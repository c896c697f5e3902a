!> SURFACE: an element of a spline surface without a body, for rigid surfaces. It has no unknowns.
!!
!! Nodes:  control points, in the order of the operator of the element
!! Faces:  only zeta+ (6) is used; its outward normal is a_1 x a_2, where a_1 and a_2 are the
!!         tangents along xi and eta
!! Cell:   a Bezier quadrilateral of VTK, which represents the surface exactly
module elmt_surface
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: tensor_rule, join_faces
  use surface_shape, only: surface_functions, surface_count, surface_touches
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_BEZIER_QUADRILATERAL = 77

contains

  !> Row of this element. It is not in the table of elements, and has no `form`.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='SURFACE', source='rigid spline surface with prescribed motion', &
                    spline=.true., rule=set_rule, functions=functions, topology=set_topology)
  end function describe

  !> Set a rule of one point, because nothing is integrated.
  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    call tensor_rule([1, 1, cell%degree(3) + 1], q, qz, rule)
  end subroutine set_rule

  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (nf)
    real(wp), intent(out) :: dshp(:, :) !! (3, nf)

    call surface_functions(cell, xi(:2), shp, dshp(:2, :))
    dshp(3, :) = 0.0_wp
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical, allocatable :: on(:, :)

    allocate (on(surface_count(cell), 6), source=.false.)
    call surface_touches(cell, on(:, :4))
    on(:, 5:6) = .true.
    call join_faces(on, topology)
    topology%vtk = VTK_BEZIER_QUADRILATERAL
  end subroutine set_topology

end module elmt_surface
