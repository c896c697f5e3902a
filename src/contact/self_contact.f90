!> Contact of a surface with itself: decides which parts of it may touch, and projects points onto
!! these parts.
!!
!! The nearest point of the surface is the point itself. A projection therefore starts on a part
!! that faces the point (contact_cells) and follows the surface from there as long as the distance
!! decreases. It is accepted only if the surface where it ends faces the surface at the point. The
!! near side and the far side of a thin body face each other in the same way as two parts that have
!! passed through each other. Only the reference configuration distinguishes these cases, because
!! there the body lies between the near side and the far side.
module self_contact
  use base_kinds, only: wp
  use contact_facets, only: FACING
  use contact_pair, only: contact_t, surface_t
  use projection, only: project_from
  use projection_type, only: foot_t, shape_t
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: may_touch, project_on_itself

  !> Two elements with a common node meet at a corner or edge of the body if the cosine of the angle
  !! between their normals is smaller than this.
  real(wp), parameter :: CORNER = 0.9_wp
  !> At an edge of the body, two elements do not touch if each of them lies below the tangent plane
  !! of the other by more than this, relative to the width of an element.
  real(wp), parameter :: LEVEL = 1.0e-6_wp
  !> On a smooth surface, two elements do not touch if each of them lies below the tangent plane of
  !! the other by more than this, relative to their distance.
  real(wp), parameter :: FOLDED = 0.1_wp
  !> Parts that overlap at the start by less than this fraction of the width of an element count as
  !! touching, because curved surfaces whose meshes do not match overlap a little.
  real(wp), parameter :: MISFIT = 0.01_wp
  !> Smallest cosine of the angle between a line through the body and the normals at the ends of the
  !! line.
  real(wp), parameter :: ACROSS = 0.25_wp
  !> Assumption: no body is compressed to less than 1/MOST_COMPRESSED of its thickness.
  real(wp), parameter :: MOST_COMPRESSED = 4.0_wp

contains

  !> May two elements of a surface touch? An element does not touch itself. Two elements on opposite
  !! sides of a convex edge of the body do not touch each other, however sharp the edge becomes in
  !! the motion. Adjacent elements of a smooth surface touch only where it is folded inwards now.
  pure logical function may_touch(surface, reference, shape, e, f) result(may)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: reference, shape !! before the deformation, and now
    integer, intent(in) :: e, f
    real(wp) :: x(3), y(3), n(3), m(3), far

    may = e /= f
    if (.not. may) return
    if (.not. share_node(surface, e, f)) return
    call place(surface, reference, e, [0.0_wp, 0.0_wp], x, n)
    call place(surface, reference, f, [0.0_wp, 0.0_wp], y, m)
    if (dot_product(n, m) < CORNER) then
      far = maxval(reference%high(:, e) - reference%low(:, e))
      may = max(dot_product(y - x, n), dot_product(x - y, m)) > -LEVEL*far
    else ! a smooth surface: where it is folded inwards now, its parts touch
      call place(surface, shape, e, [0.0_wp, 0.0_wp], x, n)
      call place(surface, shape, f, [0.0_wp, 0.0_wp], y, m)
      may = max(dot_product(y - x, n), dot_product(x - y, m)) > -FOLDED*norm2(y - x)
    end if
  end function may_touch

  pure logical function share_node(surface, e, f) result(share)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, f
    integer :: i

    share = .true.
    do i = surface%first(e), surface%first(e + 1) - 1
      if (any(surface%node(surface%first(f):surface%first(f + 1) - 1) == surface%node(i))) return
    end do
    share = .false.
  end function share_node

  !> Position and unit normal of a point of an element.
  pure subroutine place(surface, shape, e, xi, x, n)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: x(3), n(3)
    real(wp) :: a(3, 2), b(3, 3)

    call surface_point(surface, shape, e, xi, x, a, b)
    n = cross(a(:, 1), a(:, 2))
    n = n/max(norm2(n), tiny(1.0_wp))
  end subroutine place

  !> Project the point xi of element e onto the part of its own surface on which `foot` lies. There
  !! is no projection (element 0) if the surface does not face the point where the search ends, or
  !! if the point and its projection are on opposite faces of the body.
  pure subroutine project_on_itself(contact, shape, reference, e, xi, foot, through)
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape, reference !! now, and before the deformation
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    type(foot_t), intent(inout) :: foot
    !> The point and its projection are on opposite faces, and the point is not deeper than DEPTh.
    logical, intent(out), optional :: through
    type(foot_t) :: start
    real(wp) :: x(3), n(3)
    logical :: touches

    if (present(through)) through = .false.
    call place(contact%side(1), shape, e, xi, x, n)
    start = foot
    call project_from(contact%side(1), shape, x, foot)
    if (foot%elem == 0) return
    touches = foot%elem /= e .and. dot_product(n, foot%n) < FACING
    if (.not. touches) then ! the search may have left the facing part over an edge of the body
      call project_from(contact%side(1), shape, x, start, stays=.true.)
      touches = start%elem > 0 .and. start%elem /= e .and. all(start%free)
      if (touches) touches = dot_product(n, start%n) < FACING
      if (touches) foot = start
    end if
    if (touches .and. foot%gap < 0.0_wp) then
      touches = .not. is_opposite(contact, reference, e, xi, foot)
      if (present(through)) through = .not. touches .and. foot%gap >= -contact%depth
    end if
    if (touches) return
    if (.not. all(foot%free)) then ! both parts end at the edge where they meet
      foot%outer = foot%elem
      foot%outer_xi = foot%xi
    end if
    foot%elem = 0
    foot%gap = huge(1.0_wp)
  end subroutine project_on_itself

  !> Were a point and its projection on opposite faces of the body before the deformation?
  pure logical function is_opposite(contact, reference, e, xi, foot) result(yes)
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: reference
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    type(foot_t), intent(in) :: foot
    real(wp) :: x(3), y(3), n(3), m(3), height(2), far

    call place(contact%side(1), reference, e, xi, x, n)
    call place(contact%side(1), reference, foot%elem, foot%xi, y, m)
    far = norm2(y - x)
    height = [dot_product(y - x, n), dot_product(x - y, m)] ! height of each point above the other
    yes = far < MOST_COMPRESSED*contact%depth .and. all(height < 0.0_wp) .and. &
          sum(height) < -2*ACROSS*far .and. &
          sum(height) < -2*MISFIT*maxval(reference%high(:, e) - reference%low(:, e))
  end function is_opposite

end module self_contact
