!> How near the two surfaces of a contact are, and whether they face each other: all integration
!! points are projected onto the other surface, usually at the start.
module contact_nearness
  use base_kinds, only: wp
  use contact_pair, only: contact_t
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use self_search, only: nearness_t, search_itself
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: start_t, look_at_start, look_farther

  !> A gap that is smaller than this fraction of the size of an element is due to rounding.
  real(wp), parameter :: INSIDE = 1.0e-6_wp
  !> Elements count as nearest if their gaps exceed the smallest one by at most this fraction of the
  !! width of the element with the smallest gap.
  real(wp), parameter :: NEAREST = 0.01_wp
  !> Normals point the same way if the cosine of their angle exceeds this value. The mean normal at
  !! the edge of a box is at 45 degrees to the faces that meet there, so more is required at ridges.
  real(wp), parameter :: SAME_WAY = 0.5_wp, SAME_AT_RIDGE = 0.9_wp

  !> Position of two surfaces relative to each other at the start.
  type :: start_t
    !> Number of points of both sides, or of a rigid side alone if no point of the other side faces
    !! it.
    integer :: npoint = 0
    integer :: ninside = 0               !! number of these that penetrate
    real(wp) :: deepest = 0.0_wp         !! largest penetration [L]
    real(wp) :: x(3) = 0.0_wp            !! point with the largest penetration [L]
    integer :: nnear = 0                 !! number of points about as near as the nearest
    integer :: naway(2) = 0              !! numbers of these where side 1 and side 2 face away
    real(wp) :: overlap = 0.0_wp         !! largest penetration between DEPTh and the thickness [L]
    real(wp) :: x_overlap(3) = 0.0_wp    !! point with this penetration [L]
    integer :: nbehind = 0               !! number of the near points behind the whole other body
    !> No integration point is opposite the other side, but points of the rigid side are.
    logical :: unseen = .false.
    real(wp) :: width(2) = 0.0_wp        !! mean width of the elements that are nearest [L]
    real(wp) :: gap = huge(1.0_wp)       !! smallest gap of a point outside the other body [L]
    real(wp) :: x_gap(3) = 0.0_wp        !! point with the smallest gap [L]
    !> Self-contact: number of points no farther than DEPTh from the far side of the body, and one
    !! of these points.
    integer :: nthrough = 0
    real(wp) :: x_through(3) = 0.0_wp
  end type start_t

  !> What the integration points see of the other surface.
  type :: view_t
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    real(wp) :: width = huge(1.0_wp)     !! mean extent of the elements of the finer side [L]
    real(wp) :: thin = huge(1.0_wp)      !! thickness of the thinner body [L]; huge: unknown
    real(wp) :: reach = 0.0_wp           !! points that are farther away see nothing [L]
    integer :: n = 0                     !! number of points that see the other surface
    real(wp), allocatable :: gap(:)      !! (n) [L]
    integer, allocatable :: away(:)      !! (n) side that faces away there; 0: none
    logical, allocatable :: behind(:)    !! (n) the point is behind the other body
    real(wp), allocatable :: distance(:, :) !! (nelem, 2) of an element to the other surface [L]
  end type view_t

contains

  !> Project all points of a contact at the positions x, over a distance of at most the thickness of
  !! the thicker body plus the width of an element.
  subroutine look_at_start(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(view_t) :: view
    real(wp) :: near
    integer :: k

    if (contact%self) then
      call look_at_itself(contact, x, start)
      return
    end if
    call open_view(contact, x, view)
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      start%npoint = start%npoint + contact%side(k)%nelem*contact%nplain
      call look_from(contact, k, view, start)
    end do
    do k = 1, 2 ! a rigid side may lie between the points of the other side
      if (view%n > 0 .or. .not. contact%side(k)%rigid) cycle
      call update_grid(contact%side(3 - k), view%shape(3 - k), view%grid(3 - k))
      call look_from(contact, k, view, start)
      start%unseen = view%n > 0
      if (start%unseen) start%npoint = contact%side(k)%nelem*contact%nplain
    end do
    where (abs(start%x) < INSIDE*view%width) start%x = 0.0_wp ! only rounding error
    do k = 1, 2
      if (allocated(contact%side(k)%width)) then
        start%width(k) = nearest_width(contact%side(k)%width, view%distance(:, k))
      end if
    end do
    associate (gap => abs(view%gap(:view%n)), away => view%away(:view%n))
      ! surfaces must face each other only where they are nearest; the far side of a ball faces away
      near = minval(gap) + view%width
      start%nnear = count(gap <= near)
      start%nbehind = count(gap <= near .and. view%behind(:view%n))
      start%naway = [(count(gap <= near .and. away == k), k=1, 2)]
    end associate
  end subroutine look_at_start

  !> Prepare the projections, and find the lengths that decide what is near.
  subroutine open_view(contact, x, view)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)
    type(view_t), intent(out) :: view
    integer :: k, n

    call place_surfaces(contact, x, view%shape, view%grid)
    associate (side => contact%side)
      do k = 1, 2
        view%width = min(view%width, sum(maxval(view%shape(k)%high - view%shape(k)%low, dim=1)) &
                         /max(1, side(k)%nelem))
      end do
      if (any(side%thickness > 0.0_wp)) view%thin = minval(side%thickness, side%thickness > 0.0_wp)
      view%reach = view%width + maxval(side%thickness)
      allocate (view%distance(maxval(side%nelem), 2), source=huge(1.0_wp))
      n = contact%nplain*maxval(side%nelem)*2
      allocate (view%gap(n), view%away(n), view%behind(n))
    end associate
  end subroutine open_view

  !> Project the points of side k onto the other side.
  subroutine look_from(contact, k, view, start)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(view_t), intent(inout) :: view
    type(start_t), intent(inout) :: start
    type(foot_t) :: foot
    real(wp) :: xp(3), a(3, 2), b(3, 3), normal(3)
    integer :: e, q

    do e = 1, contact%side(k)%nelem
      do q = 1, contact%nplain
        call surface_point(contact%side(k), view%shape(k), e, contact%xi(:, q), xp, a, b)
        foot%elem = 0
        call project(contact%side(3 - k), view%shape(3 - k), view%grid(3 - k), xp, foot, view%reach)
        if (foot%elem == 0) cycle
        normal = cross(a(:, 1), a(:, 2))
        if (abs(foot%gap) <= view%reach) call note_near(k, e, normal, foot, view)
        if (foot%gap >= 0.0_wp .and. foot%gap < start%gap) then
          start%gap = foot%gap
          start%x_gap = xp
        end if
        if (foot%gap < -contact%depth .and. foot%gap > -view%thin*(1.0_wp - INSIDE) .and. &
            -foot%gap > start%overlap) then
          if (dot_product(normal, foot%n) < 0.0_wp) then
            start%overlap = -foot%gap
            start%x_overlap = xp
          end if
        end if
        if (.not. (foot%gap < -INSIDE*view%width .and. touches(foot, contact%depth))) cycle
        start%ninside = start%ninside + 1
        if (-foot%gap <= start%deepest) cycle
        start%deepest = -foot%gap
        start%x = xp
      end do
    end do
  end subroutine look_from

  !> Note a point of side k that is not far from the other surface, and whether one of the two sides
  !! faces away there.
  pure subroutine note_near(k, e, normal, foot, view)
    integer, intent(in) :: k, e          !! side and element of the point
    real(wp), intent(in) :: normal(3)    !! outward normal there, not of unit length
    type(foot_t), intent(in) :: foot
    type(view_t), intent(inout) :: view
    real(wp) :: same

    view%distance(e, k) = min(view%distance(e, k), abs(foot%gap))
    view%n = view%n + 1
    associate (n => view%n)
      view%gap(n) = foot%gap
      view%behind(n) = foot%gap < -view%thin*(1.0_wp - INSIDE)
      view%away(n) = 0
      same = merge(SAME_WAY, SAME_AT_RIDGE, all(foot%free))
      if (dot_product(normal, foot%n) > same*norm2(normal)) then
        ! outside the other body side k faces away, inside it the other side does
        view%away(n) = merge(3 - k, k, foot%gap < 0.0_wp)
      end if
    end associate
  end subroutine note_near

  !> Find the smallest gap between two surfaces that face each other but are farther apart than the
  !! distance within which look_at_start searches.
  subroutine look_farther(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(inout) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp) :: xp(3), a(3, 2), b(3, 3)
    integer :: e, k, q

    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      call update_grid(contact%side(k), shape(k), grid(k))
    end do
    do k = 1, 2
      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot)
          if (foot%elem == 0) cycle
          if (.not. (foot%gap >= 0.0_wp .and. foot%gap < start%gap)) cycle
          if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp) cycle
          start%gap = foot%gap
          start%x_gap = xp
        end do
      end do
    end do
    where (abs(start%x_gap) < INSIDE*start%gap) start%x_gap = 0.0_wp ! rounding
  end subroutine look_farther

  !> Do the same as look_at_start for self-contact.
  subroutine look_at_itself(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(nearness_t) :: near

    associate (surface => contact%side(1))
      call search_itself(contact, x, x, surface%thickness + maxval(surface%width), near)
      start%npoint = near%npoint
      start%ninside = near%ninside
      start%deepest = near%deepest
      start%x = near%x
      start%gap = near%gap
      start%x_gap = near%x_gap
      start%nthrough = near%nthrough
      start%x_through = near%x_through
      start%width = nearest_width(surface%width, near%reach_of)
    end associate
  end subroutine look_at_itself

  !> Mean width of those elements of a surface that are about as near to the other surface as the
  !! nearest element. On graded meshes, large elements far from the contact must not be included.
  pure real(wp) function nearest_width(width, reach) result(mean)
    real(wp), intent(in) :: width(:)     !! (nelem) [L]
    real(wp), intent(in) :: reach(:)     !! distance to the other surface [L]; huge: not near
    real(wp) :: band
    integer :: e

    associate (near => reach(:size(width)))
      band = huge(band)
      if (any(near < huge(near))) then
        e = minloc(near, dim=1)
        band = near(e) + NEAREST*width(e)
      end if
      mean = sqrt(sum(width**2, mask=near <= band)/max(1, count(near <= band)))
    end associate
  end function nearest_width

end module contact_nearness
