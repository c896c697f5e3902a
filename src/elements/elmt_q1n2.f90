!> Q1N: linear hexahedron whose face zeta = -1 is isogeometric: Q1Np.t for any p and t.
!!
!! Nodes:  control points of zeta = -1, xi fastest, or in the order of an operator of the whole
!!         element (any number of them); then the corners of zeta = +1, counter-clockwise from (-,-)
!! Rule:   (p+1) x (p+1) x 2 Gauss points, p the degrees of the surface, raised ones too
!! Source: Corbett and Sauer 2015, section 2.3, eq. (15)
!! Limits: locks like Q1; a collapsed face zeta = +1 (prism) must not be evaluated at zeta = +1
module elmt_q1n2
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: linear, tensor_rule, join_faces, CORNER
  use solid_form, only: form
  use surface_shape, only: surface_functions, surface_count, surface_touches
  implicit none
  private
  public :: describe, set_rule, functions, set_topology

  integer, parameter :: VTK_BEZIER_HEXAHEDRON = 79

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'Q1N'
    row%source = 'linear bulk, isogeometric surface; Corbett and Sauer 2015, eq. (15)'
    row%spline = .true.
    row%rule => set_rule
    row%functions => functions
    row%topology => set_topology
    row%form => form
  end function describe

  subroutine set_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    call tensor_rule([cell%degree(1) + 1, cell%degree(2) + 1, 2], q, qz, rule)
  end subroutine set_rule

  !> Surface functions times (1 - zeta)/2, and the upper half of the tri-linear functions.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (ncp+4)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp+4)

    real(wp) :: f(2, 3), d(2, 3)
    integer :: a, i, j, ncp

    do a = 1, 3
      call linear(xi(a), f(:, a), d(:, a))
    end do
    ncp = surface_count(cell)
    call surface_functions(cell, xi(:2), shp(:ncp), dshp(:2, :ncp))
    dshp(3, :ncp) = shp(:ncp)*d(1, 3)
    dshp(:2, :ncp) = dshp(:2, :ncp)*f(1, 3)
    shp(:ncp) = shp(:ncp)*f(1, 3)
    do a = 1, 4
      i = (CORNER(1, a) + 3)/2
      j = (CORNER(2, a) + 3)/2
      shp(ncp + a) = f(i, 1)*f(j, 2)*f(2, 3)
      dshp(1, ncp + a) = d(i, 1)*f(j, 2)*f(2, 3)
      dshp(2, ncp + a) = f(i, 1)*d(j, 2)*f(2, 3)
      dshp(3, ncp + a) = f(i, 1)*f(j, 2)*d(2, 3)
    end do
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical, allocatable :: on(:, :)
    integer :: i, ncp

    ncp = surface_count(cell)
    allocate (on(ncp + 4, 6), source=.false.)
    call surface_touches(cell, on(:ncp, :4))
    on(:ncp, 5) = .true.
    do i = 1, 4
      on(ncp + i, :) = [CORNER(1, i) < 0, CORNER(1, i) > 0, CORNER(2, i) < 0, CORNER(2, i) > 0, &
                        .false., .true.]
    end do
    call join_faces(on, topology)
    topology%vtk = VTK_BEZIER_HEXAHEDRON
  end subroutine set_topology

end module elmt_q1n2
