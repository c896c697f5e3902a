!> What a rigid surface feels: it is not integrated itself.
module rigid_surface
  use base_kinds, only: wp
  use projection_type, only: foot_t
  use contact_pair, only: surface_t, contact_points_t
  use contact_work, only: element_functions
  implicit none
  private
  public :: react, put_force, split_force

contains

  !> A rigid tool is not integrated: its supports bear the tractions of the other side.
  subroutine react(tool, feet, points, before, f)
    type(surface_t), intent(in) :: tool
    type(foot_t), intent(in) :: feet(:)          !! (nq) of an element of the other side
    type(contact_points_t), intent(in) :: points !! of the other side
    integer, intent(in) :: before                !! points before those of the element
    real(wp), intent(inout) :: f(:, :)           !! (3, nnode) internal forces [F]
    real(wp) :: at_partner(3), at_foot(3)
    integer :: i, q

    do q = 1, size(feet)
      i = before + q
      call split_force(points, i, at_partner, at_foot)
      if (points%bond(i) > 0) then
        call put_force(tool, points%bond(i), points%bond_xi(:, i), at_partner, f)
      end if
      if (feet(q)%elem > 0) call put_force(tool, feet(q)%elem, feet(q)%xi, at_foot, f)
    end do
  end subroutine react

  !> Where on the other side the force of point i acts: that of a bond at the partner, all else at
  !! the foot.
  pure subroutine split_force(points, i, at_partner, at_foot)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    real(wp), intent(out) :: at_partner(3), at_foot(3) !! [F]

    at_partner = 0.0_wp
    if (points%bond(i) > 0) at_partner = points%area0(i)*points%pull(:, i)
    at_foot = points%area(i)*points%traction(:, i) - at_partner
  end subroutine split_force

  !> A force on the nodes of element e.
  subroutine put_force(tool, e, xi, force, f)
    type(surface_t), intent(in) :: tool
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), force(3)
    real(wp), intent(inout) :: f(:, :)
    real(wp) :: shp(tool%first(e + 1) - tool%first(e))
    real(wp) :: dshp(2, tool%first(e + 1) - tool%first(e))
    integer :: b

    call element_functions(tool, e, xi, shp, dshp)
    do b = 1, size(shp)
      associate (node => tool%node(tool%first(e) + b - 1))
        f(:, node) = f(:, node) + shp(b)*force
      end associate
    end do
  end subroutine put_force

end module rigid_surface
