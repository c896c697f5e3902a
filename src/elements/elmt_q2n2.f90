!> Q2N: quadratic hexahedron whose face zeta = -1 is isogeometric: Q2Np.t for any p and t.
!!
!! Nodes:  control points of zeta = -1, xi fastest; then 9 nodes of zeta = 0 and 9 of zeta = +1,
!!         each in tensor order, xi fastest
!! Rule:   (p+1) x (p+1) x 3 Gauss points, p the degrees of the surface, at least 3 a direction
!! Source: Corbett and Sauer 2015, section 2.3, eq. (16)
module elmt_q2n2
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t, rule_t, topology_t
  use hexa_shape, only: quadratic, tensor_rule, join_faces
  use solid_form, only: form
  use surface_shape, only: surface_functions, surface_count, surface_touches
  implicit none
  private
  public :: describe

  integer, parameter :: VTK_BEZIER_HEXAHEDRON = 79

contains

  !> Row of the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row%name = 'Q2N'
    row%source = 'quadratic bulk, isogeometric surface; Corbett and Sauer 2015, eq. (16)'
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

    call tensor_rule([max(cell%degree(1), 2) + 1, max(cell%degree(2), 2) + 1, 3], q, qz, rule)
  end subroutine set_rule

  !> Surface functions times the quadratic of zeta = -1, and two planes of the tri-quadratics.
  pure subroutine functions(cell, xi, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(:)     !! (ncp+18)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp+18)

    real(wp) :: f(3, 3), d(3, 3)
    integer :: i, j, k, a, ncp

    do i = 1, 3
      call quadratic(xi(i), f(:, i), d(:, i))
    end do
    ncp = surface_count(cell)
    call surface_functions(cell, xi(:2), shp(:ncp), dshp(:2, :ncp))
    dshp(3, :ncp) = shp(:ncp)*d(1, 3)
    dshp(:2, :ncp) = dshp(:2, :ncp)*f(1, 3)
    shp(:ncp) = shp(:ncp)*f(1, 3)
    a = ncp
    do k = 2, 3
      do j = 1, 3
        do i = 1, 3
          a = a + 1
          shp(a) = f(i, 1)*f(j, 2)*f(k, 3)
          dshp(1, a) = d(i, 1)*f(j, 2)*f(k, 3)
          dshp(2, a) = f(i, 1)*d(j, 2)*f(k, 3)
          dshp(3, a) = f(i, 1)*f(j, 2)*d(k, 3)
        end do
      end do
    end do
  end subroutine functions

  subroutine set_topology(cell, topology)
    type(cell_t), intent(in) :: cell
    type(topology_t), intent(out) :: topology

    logical, allocatable :: on(:, :)
    integer :: i, j, k, a

    a = surface_count(cell)
    allocate (on(a + 18, 6), source=.false.)
    call surface_touches(cell, on(:a, :4))
    on(:a, 5) = .true.
    do k = 2, 3
      do j = 1, 3
        do i = 1, 3
          a = a + 1
          on(a, :) = [i == 1, i == 3, j == 1, j == 3, .false., k == 3]
        end do
      end do
    end do
    call join_faces(on, topology)
    topology%vtk = VTK_BEZIER_HEXAHEDRON
  end subroutine set_topology

end module elmt_q2n2
