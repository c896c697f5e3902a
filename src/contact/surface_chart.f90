!> Charts of surface elements: coordinates in which positions are smooth, even where an edge of the
!! element is collapsed to a point, as on the triangles of tetrahedra, wedges and pyramids.
!!
!! The parameters of a triangle are singular at the vertex to which an edge is collapsed: a straight
!! line in the plane is a hyperbola in the parameters, which is steep near the vertex. Let h be the
!! distance from the vertex, 0 there and 1 at the opposite edge, xi_f the parameter along that edge
!! and xi_g the other one. The chart is
!!
!!   u_f = h xi_f,   u_g = xi_g.
!!
!! Positions are polynomials of u, of degree one on a plane triangle with straight edges. The chart
!! of an element without a collapsed edge is its parameters.
module surface_chart
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use projection_type, only: shape_t
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: collapsed_side, to_chart, from_chart, chart_point

  !> Below this height above the vertex, tangents are replaced by their limits.
  real(wp), parameter :: AT_VERTEX = 1.0e-8_wp
  !> Below this height, points beyond the sides of the triangle are moved to the sides.
  real(wp), parameter :: NEAR_VERTEX = 1.0e-3_wp

contains

  !> The side (1 to 4, as in surface%neighbour) of an element that is collapsed to a point; 0: none.
  pure integer function collapsed_side(surface, e) result(side)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    side = 0
    if (allocated(surface%point)) side = findloc(surface%point(:, e), .true., 1)
  end function collapsed_side

  !> Distance from the collapsed side, relative to the element.
  pure real(wp) function height(side, xi_g)
    integer, intent(in) :: side
    real(wp), intent(in) :: xi_g         !! the parameter that is constant on the side

    height = 0.5_wp*(1.0_wp - sign_of(side)*xi_g)
  end function height

  pure real(wp) function sign_of(side)
    integer, intent(in) :: side

    sign_of = merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
  end function sign_of

  !> Convert parameters to coordinates of the chart.
  pure function to_chart(side, xi) result(u)
    integer, intent(in) :: side          !! see collapsed_side
    real(wp), intent(in) :: xi(2)
    real(wp) :: u(2)
    integer :: g

    u = xi
    if (side == 0) return
    g = (side + 1)/2
    u(3 - g) = height(side, xi(g))*xi(3 - g)
  end function to_chart

  !> Convert coordinates of the chart to parameters. At the vertex, the parameter along the
  !! collapsed edge is set to zero.
  pure function from_chart(side, u) result(xi)
    integer, intent(in) :: side
    real(wp), intent(in) :: u(2)
    real(wp) :: xi(2), h
    integer :: f, g

    xi = u
    if (side == 0) return
    g = (side + 1)/2
    f = 3 - g
    h = height(side, u(g))
    if (abs(u(f)) < abs(h) .or. abs(h) > NEAR_VERTEX) then
      xi(f) = u(f)/h
    else if (abs(u(f)) > 0.0_wp) then
      xi(f) = sign(1.0_wp, u(f))*sign(1.0_wp, h)
    end if
  end function from_chart

  !> Find a position and its derivatives with respect to the coordinates of the chart.
  pure subroutine chart_point(surface, shape, e, side, u, x, a)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e, side
    real(wp), intent(in) :: u(2)
    real(wp), intent(out) :: x(3)        !! [L]
    real(wp), intent(out) :: a(3, 2)     !! [L]
    real(wp) :: xi(2), b(3, 3), h
    integer :: f, g

    xi = from_chart(side, u)
    call surface_point(surface, shape, e, xi, x, a, b)
    if (side == 0) return
    g = (side + 1)/2
    f = 3 - g
    h = height(side, xi(g))
    if (abs(h) > AT_VERTEX) then
      a(:, f) = a(:, f)/h
    else ! a_f vanishes with h: the limit of a_f/h
      a(:, f) = -2.0_wp*sign_of(side)*b(:, 3)
    end if
    a(:, g) = a(:, g) + 0.5_wp*sign_of(side)*xi(f)*a(:, f)
  end subroutine chart_point

end module surface_chart
