!> The part of the force of a contact that acts between faces which are not opposite each other.
!!
!! The outward normals of two faces that are pressed flat onto each other are opposite, whereas
!! those of a body's side face and of the ground are nearly perpendicular. If a contact acts between
!! such faces, an edge of one body bears on the other one.
module contact_oblique
  use base_kinds, only: wp
  use contact_assembly, only: contact_work_t
  use contact_pair, only: contact_t, contact_points_t, is_integrated, MORTAR
  use contact_point, only: traction_derivatives_t, vary_normal
  use contact_type, only: MU, OPEN
  use mortar_type, only: mortar_side_t
  use projection_type, only: foot_t, shape_t
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: oblique_t, find_oblique, oblique_share, exceeds_friction

  !> Faces count as opposite each other if the cosine of the angle between their outward normals is
  !! at most FLAT, and not at all if it is at least OBLIQUE. The part that does not count increases
  !! linearly between these, so that faces that turn slowly do not change it suddenly.
  real(wp), parameter :: FLAT = -0.8_wp, OBLIQUE = -0.5_wp
  !> Excess over the limit of friction that counts, relative to the sum of the magnitudes of forces.
  real(wp), parameter :: EXCESS = 0.02_wp

  !> Sums over the points of a contact [F].
  type :: oblique_t
    real(wp) :: whole = 0.0_wp           !! sum of the magnitudes of the forces
    real(wp) :: part = 0.0_wp            !! part between faces that are not opposite each other
    real(wp) :: force(3) = 0.0_wp        !! sum of the forces on side 1
    real(wp) :: flat(3) = 0.0_wp         !! sum of those of its normal forces that act between faces
    !! which are opposite each other
  end type oblique_t

contains

  !> The sums over the points of a contact. The forces are those that were formed last; bonded
  !! points are left out.
  pure function find_oblique(contact, work, points) result(sums)
    type(contact_t), intent(in) :: contact
    type(contact_work_t), intent(in) :: work
    type(contact_points_t), intent(in) :: points(2)
    type(oblique_t) :: sums
    integer :: k

    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      if (contact%scheme == MORTAR) then
        call add_cells(contact, k, work%shape(k), work%mortar%side(k), sums)
      else
        call add_points(contact, k, work%shape(k), work%feet(k)%at, points(k), sums)
      end if
    end do
  end function find_oblique

  !> The part of the force that acts between faces which are not opposite each other; 0: there is no
  !! force.
  pure real(wp) function oblique_share(sums) result(share)
    type(oblique_t), intent(in) :: sums

    share = 0.0_wp
    if (sums%whole > 0.0_wp) share = sums%part/sums%whole
  end function oblique_share

  !> Is the force along the surface larger than friction between faces that are opposite each other
  !! allows? Their normal forces define the normal of the surface.
  pure logical function exceeds_friction(contact, sums) result(yes)
    type(contact_t), intent(in) :: contact
    type(oblique_t), intent(in) :: sums
    real(wp) :: n(3), normal, limit

    yes = .true.
    if (.not. norm2(sums%flat) > 0.0_wp) return
    n = sums%flat/norm2(sums%flat)
    normal = dot_product(sums%force, n)
    limit = EXCESS*sums%whole
    if (contact%friction%given) limit = limit + contact%friction%prop(MU)*abs(normal)
    yes = norm2(sums%force - normal*n) > limit
  end function exceeds_friction

  !> Add the forces at the points of the cells of side k.
  pure subroutine add_cells(contact, k, shape, side, sums)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape           !! current shape of side k
    type(mortar_side_t), intent(in) :: side
    type(oblique_t), intent(inout) :: sums
    real(wp) :: fraction, n(3)
    integer :: i

    if (.not. allocated(side%p)) return
    do i = 1, side%cells%n
      if (.not. side%p(i) > 0.0_wp) cycle
      call compare(contact, k, shape, side%cells%elem(i), side%cells%xi(:, i), &
                   side%cells%foot(i), n, fraction)
      call add_force(k, side%cells%weight(i)*side%p(i)*n, &
                     side%cells%weight(i)*side%friction(:, i), fraction, sums)
    end do
  end subroutine add_cells

  !> Add the forces at the integration points of side k.
  pure subroutine add_points(contact, k, shape, feet, points, sums)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape           !! current shape of side k
    type(foot_t), intent(in) :: feet(:)          !! (np)
    type(contact_points_t), intent(in) :: points
    type(oblique_t), intent(inout) :: sums
    real(wp) :: fraction, n(3)
    integer :: e, i

    do i = 1, size(points%state)
      if (points%state(i) == OPEN .or. points%bond(i) > 0 .or. feet(i)%elem == 0) cycle
      e = (i - 1)/contact%nq + 1
      call compare(contact, k, shape, e, contact%xi(:, i - (e - 1)*contact%nq), feet(i), n, &
                   fraction)
      call add_force(k, points%area(i)*points%normal(:, i), &
                     points%area(i)*points%friction(:, i), fraction, sums)
    end do
  end subroutine add_points

  !> Add the force at a point of side k.
  pure subroutine add_force(k, normal, friction, fraction, sums)
    integer, intent(in) :: k
    real(wp), intent(in) :: normal(3), friction(3) !! forces on side k [F]
    real(wp), intent(in) :: fraction               !! see compare
    type(oblique_t), intent(inout) :: sums
    real(wp) :: towards

    towards = merge(1.0_wp, -1.0_wp, k == 1)
    sums%whole = sums%whole + norm2(normal + friction)
    sums%part = sums%part + fraction*norm2(normal + friction)
    sums%force = sums%force + towards*(normal + friction)
    sums%flat = sums%flat + towards*(1.0_wp - fraction)*normal
  end subroutine add_force

  !> Direction in which the pressure acts at the point xi of element e, and the fraction of its
  !! force that counts as oblique.
  pure subroutine compare(contact, k, shape, e, xi, foot, n, fraction)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: xi(2)
    type(foot_t), intent(in) :: foot             !! projection of the point
    real(wp), intent(out) :: n(3), fraction
    type(traction_derivatives_t) :: dn
    real(wp) :: x(3), a(3, 2), b(3, 3), own(3), cosine

    call surface_point(contact%side(k), shape, e, xi, x, a, b)
    call vary_normal(foot, x, n, dn)
    own = cross(a(:, 1), a(:, 2))
    cosine = dot_product(own, n)/max(norm2(own), tiny(1.0_wp))
    fraction = min(1.0_wp, max(0.0_wp, (cosine - FLAT)/(OBLIQUE - FLAT)))
  end subroutine compare

end module contact_oblique
