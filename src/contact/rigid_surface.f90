!> Forces on a rigid surface, which is not integrated itself: its supports bear the tractions of the
!! other side.
module rigid_surface
  use base_kinds, only: wp
  use contact_pair, only: surface_t, contact_points_t
  use contact_work, only: element_functions
  use projection_type, only: foot_t
  implicit none
  private
  public :: react, split_force

contains

  !> Add the forces that the points of one element of the other side exert.
  subroutine react(rigid, feet, points, before, f)
    type(surface_t), intent(in) :: rigid
    type(foot_t), intent(in) :: feet(:)          !! (nq) projections of points of one element
    type(contact_points_t), intent(in) :: points !! points of the other side
    integer, intent(in) :: before                !! number of points before those of the element
    real(wp), intent(inout) :: f(:, :)           !! (3, nnode) internal forces [F]
    real(wp) :: at_partner(3), at_closest(3)
    integer :: i, q

    do q = 1, size(feet)
      i = before + q
      call split_force(points, i, at_partner, at_closest)
      if (points%bond(i) > 0) then
        call put_force(rigid, points%bond(i), points%bond_xi(:, i), at_partner, f)
      end if
      if (feet(q)%elem > 0) call put_force(rigid, feet(q)%elem, feet(q)%xi, at_closest, f)
    end do
  end subroutine react

  !> Split the force of point i on the other side into two parts. The force of the bond acts at the
  !! partner, and all other forces act at the projection.
  pure subroutine split_force(points, i, at_partner, at_closest)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    real(wp), intent(out) :: at_partner(3), at_closest(3) !! [F]

    at_partner = 0.0_wp
    if (points%bond(i) > 0) at_partner = points%area0(i)*points%bond_traction(:, i)
    at_closest = points%area(i)*points%traction(:, i) - at_partner
  end subroutine split_force

  !> Distribute a force to the nodes of element e.
  subroutine put_force(rigid, e, xi, force, f)
    type(surface_t), intent(in) :: rigid
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), force(3)
    real(wp), intent(inout) :: f(:, :)
    real(wp) :: shp(rigid%first(e + 1) - rigid%first(e))
    real(wp) :: dshp(2, rigid%first(e + 1) - rigid%first(e))
    integer :: b

    call element_functions(rigid, e, xi, shp, dshp)
    do b = 1, size(shp)
      associate (node => rigid%node(rigid%first(e) + b - 1))
        f(:, node) = f(:, node) + shp(b)*force
      end associate
    end do
  end subroutine put_force

end module rigid_surface
