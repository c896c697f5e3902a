!> Sliding points of the mortar scheme: the points of the other side from which friction measures
!! the slip of the points of the cells.
!!
!! Friction acts at the points of the cells, so that its limit at a point is mu times the pressure
!! at this point. When cells are cut, each new point is given an elastic slip that is interpolated
!! from the points of the previous step in the same element. The sliding point of a new point is its
!! projection at the start of the step, moved back by this elastic slip.
module mortar_slide
  use base_kinds, only: wp
  use contact_facets, only: FACING
  use contact_history, only: direction, trail_behind, slide_beyond
  use contact_pair, only: contact_t, friction_points_t, surface_t
  use contact_work, only: sliding_functions
  use mortar_type, only: mortar_t, mortar_side_t
  use projection, only: project, project_from
  use projection_type, only: foot_t, shape_t
  use self_contact, only: project_on_itself
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: find_slides, last_friction

  !> Cosine of the largest angle by which the direction to the other surface turns in a step. If
  !! it turns by more, the point was beside the part of the surface that it meets.
  real(wp), parameter :: LEAST_COSINE = 0.5_wp
  !> Number of bisections after which an edge is known up to about the rounding error.
  integer, parameter :: BISECTIONS = 40

contains

  !> Find the sliding points that are not known yet of the points of side k in contact.
  subroutine find_slides(mortar, contact, k, rubbed)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(friction_points_t), intent(in) :: rubbed
    integer :: i

    associate (side => mortar%side(k))
      !$omp parallel do schedule(dynamic, 16)
      do i = 1, side%cells%n
        if (.not. (side%p(i) > 0.0_wp .or. side%dp(i) < 0.0_wp)) cycle
        if (side%slide(i) /= 0) cycle
        call find_slide(mortar, contact, k, i, rubbed)
        call find_slide_functions(contact%side(3 - k), side, i)
      end do
      !$omp end parallel do
    end associate
  end subroutine find_slides

  !> Find the sliding point of a point in contact. This is the position on the other side that the
  !! point faced at the start of the step, moved back by the elastic slip of the previous step. Also
  !! interpolate the friction limit and the rate of slip of the previous step.
  subroutine find_slide(mortar, contact, k, i, rubbed)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, i
    type(friction_points_t), intent(in) :: rubbed
    type(foot_t) :: foot
    real(wp) :: at(3), a(3, 2), b(3, 3), n(3), elastic(3), slip_rate, limit
    logical :: came_in

    associate (side => mortar%side(k), cells => mortar%side(k)%cells)
      call surface_point(contact%side(k), mortar%start(k), cells%elem(i), cells%xi(:, i), at, a, b)
      foot%elem = cells%foot(i)%elem
      foot%xi = cells%foot(i)%xi
      if (contact%self) then
        call project_on_itself(contact, mortar%start(3 - k), mortar%reference(k), cells%elem(i), &
                               cells%xi(:, i), foot)
        came_in = foot%elem == 0 .and. foot%outer == 0
      else
        call project(contact%side(3 - k), mortar%start(3 - k), mortar%start_grid(3 - k), at, foot)
        came_in = foot%elem > 0
        if (came_in) came_in = was_beside(contact%side(3 - k), mortar%start(3 - k), at, foot, &
                                          cells%foot(i))
      end if
      if (came_in) then ! the point came in over an edge of the body
        foot%elem = cells%foot(i)%elem
        foot%xi = cells%foot(i)%xi
        n = cross(a(:, 1), a(:, 2))
        call project_on_edge(contact%side(merge(1, 3 - k, contact%self)), mortar%start(3 - k), at, &
                             n/max(norm2(n), tiny(1.0_wp)), merge(cells%elem(i), 0, contact%self), &
                             foot)
        foot%outer = foot%elem
        foot%outer_xi = foot%xi
        foot%elem = 0
      end if
      side%slide(i) = -1
      if (foot%elem > 0) then
        side%slide(i) = foot%elem
        side%slide_xi(:, i) = foot%xi
      else if (foot%outer > 0) then ! the point was beyond the border
        side%slide(i) = foot%outer
        side%slide_xi(:, i) = slide_beyond(contact%side(3 - k), mortar%start(3 - k), foot, at)
        return
      else
        return
      end if
      call last_friction(rubbed, cells%elem(i), cells%xi(:, i), elastic, slip_rate, limit)
      side%limit(i) = limit
      side%ahead(i) = -1.0_wp
      if (slip_rate > 0.0_wp) side%ahead(i) = slip_rate
      if (.not. any(abs(elastic) > 0.0_wp)) return
      n = foot%n
      call trail_behind(contact%side(3 - k), mortar%start(3 - k), at, foot, &
                        elastic - dot_product(elastic, n)*n, side%slide(i), side%slide_xi(:, i))
    end associate
  end subroutine find_slide

  !> Was the point x, whose projection at the start of the step is `foot`, beside the part of the
  !! surface that it faces now? The normal at its present projection is taken as it is now, because
  !! that of an edge is a mean, and as it was at the start, because the surface may have turned.
  pure logical function was_beside(surface, start, x, foot, now) result(yes)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: start       !! shape of the surface at the start of the step
    real(wp), intent(in) :: x(3)             !! [L]
    type(foot_t), intent(in) :: foot, now    !! projections at the start of the step, and now
    real(wp) :: n(3), m(3), at(3), a(3, 2), b(3, 3)

    n = direction(foot, x)
    yes = dot_product(n, now%n) < LEAST_COSINE
    if (.not. yes) return
    call surface_point(surface, start, now%elem, now%xi, at, a, b)
    m = cross(a(:, 1), a(:, 2))
    yes = dot_product(n, m) < LEAST_COSINE*norm2(m)
  end function was_beside

  !> Find the position on a surface that is nearest to the point x, among those that face this point
  !! and can be reached from `foot` along the tangent plane at `foot`. If x lies beyond the edge of
  !! the part to which `foot` belongs, the position found is on that edge.
  pure subroutine project_on_edge(surface, shape, x, n, e, foot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape       !! shape of the surface
    real(wp), intent(in) :: x(3)             !! [L]
    real(wp), intent(in) :: n(3)             !! unit normal of the surface to which x belongs
    integer, intent(in) :: e                 !! element of x if it belongs to this surface; else 0
    type(foot_t), intent(inout) :: foot
    type(foot_t) :: trial
    real(wp) :: y(3), m(3), a(3, 2), b(3, 3), far(3), s, low, high
    integer :: i

    call surface_point(surface, shape, foot%elem, foot%xi, y, a, b)
    m = cross(a(:, 1), a(:, 2))
    m = m/max(norm2(m), tiny(1.0_wp))
    far = x - y - dot_product(m, x - y)*m
    low = 0.0_wp
    high = 1.0_wp
    s = 1.0_wp
    do i = 1, BISECTIONS
      trial%elem = foot%elem
      trial%xi = foot%xi
      call project_from(surface, shape, y + s*far, trial)
      if (faces(trial, n, e)) then
        foot = trial
        low = s
      else
        high = s
      end if
      if (.not. low < high) exit
      s = 0.5_wp*(low + high)
    end do
  end subroutine project_on_edge

  !> Does the element on which a projection lies face a point with the normal n? On an edge, the
  !! normal of this element counts, because slide_beyond continues its tangent plane.
  pure logical function faces(foot, n, e)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: n(3)
    integer, intent(in) :: e                 !! element of the point on the same surface; 0: none
    real(wp) :: m(3)

    faces = .false.
    if (foot%elem == 0 .or. foot%elem == e) return
    m = cross(foot%a(:, 1), foot%a(:, 2))
    faces = dot_product(n, m) < FACING*norm2(m)
  end function faces

  !> Functions of the other side at a sliding point.
  subroutine find_slide_functions(other, side, i)
    type(surface_t), intent(in) :: other
    type(mortar_side_t), intent(inout) :: side
    integer, intent(in) :: i
    real(wp) :: dshp(2, size(side%slide_shp, 1))
    integer :: n

    if (side%slide(i) <= 0) return
    n = other%first(side%slide(i) + 1) - other%first(side%slide(i))
    call sliding_functions(other, side%slide(i), side%slide_xi(:, i), side%slide_shp(:n, i), &
                           dshp(:, :n))
  end subroutine find_slide_functions

  !> Friction of the previous step at xi in element e, from the points of the element. A point that
  !! has not moved keeps its values, and values change continuously with the cells, so that they do
  !! not depend on rounding errors. All values are zero if the element had no points.
  pure subroutine last_friction(rubbed, e, xi, elastic, slip_rate, limit)
    type(friction_points_t), intent(in) :: rubbed
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: elastic(3)       !! [L]
    real(wp), intent(out) :: slip_rate        !! 0: most points near xi stuck [L/T]
    real(wp), intent(out) :: limit            !! [F/L^2]
    integer :: first, last

    elastic = 0.0_wp
    slip_rate = 0.0_wp
    limit = 0.0_wp
    first = first_of(rubbed%elem, e)
    last = first_of(rubbed%elem, e + 1) - 1
    if (last < first) return
    associate (w => interpolation_weights(rubbed%xi(:, first:last), xi), &
               rate => rubbed%slip_rate(first:last))
      elastic = matmul(rubbed%elastic(:, first:last), w)
      limit = max(0.0_wp, dot_product(rubbed%limit(first:last), w))
      if (sum(w, mask=rate > 0.0_wp) > 0.5_wp) slip_rate = max(0.0_wp, dot_product(rate, w))
    end associate
  end subroutine last_friction

  !> Weights with which values at points are added to obtain the value at xi of the linear function
  !! that fits them best, where the errors count with the inverse fourth power of the distance from
  !! xi (moving least squares, Lancaster and Salkauskas 1981). Linear functions are exact. Beyond
  !! the points, the linear function is mixed with the mean, such that the magnitudes of the weights
  !! have a sum of at most 2.
  pure function interpolation_weights(points, xi) result(w)
    real(wp), intent(in) :: points(:, :)      !! (2, n) parameters
    real(wp), intent(in) :: xi(2)
    real(wp) :: w(size(points, 2))
    real(wp), parameter :: SAME = 1.0e-24_wp  ! squared distance of coincident points
    real(wp), parameter :: ON_LINE = 1.0e-6_wp ! ratio of moments of points that lie on a line
    real(wp) :: d(size(points, 2), 2), slope(size(points, 2)), mean(2), xx, yy, xy, det
    integer :: nearest

    d(:, 1) = points(1, :) - xi(1)
    d(:, 2) = points(2, :) - xi(2)
    w = 1.0_wp/(d(:, 1)**2 + d(:, 2)**2 + SAME)**2
    w = w/sum(w)
    ! The mean nearly coincides with a point close to xi. To find the small distance between them,
    ! both are measured from this point.
    nearest = maxloc(w, 1)
    d(:, 1) = points(1, :) - points(1, nearest)
    d(:, 2) = points(2, :) - points(2, nearest)
    mean = matmul(w, d)
    d(:, 1) = d(:, 1) - mean(1)
    d(:, 2) = d(:, 2) - mean(2)
    mean = mean + (points(:, nearest) - xi)
    xx = sum(w*d(:, 1)**2)
    yy = sum(w*d(:, 2)**2)
    xy = sum(w*d(:, 1)*d(:, 2))
    det = xx*yy - xy**2
    if (.not. det > ON_LINE*(xx + yy)**2) return
    slope = -w*(d(:, 1)*(yy*mean(1) - xy*mean(2)) + d(:, 2)*(xx*mean(2) - xy*mean(1)))/det
    w = w + slope/max(1.0_wp, sum(abs(slope)))
  end function interpolation_weights

  !> Index of the first entry of a sorted list that is at least e; if there is none, one more than
  !! its size.
  pure integer function first_of(list, e) result(low)
    integer, intent(in) :: list(:), e
    integer :: high, middle

    low = 1
    high = size(list) + 1
    do while (low < high)
      middle = (low + high)/2
      if (list(middle) < e) then
        low = middle + 1
      else
        high = middle
      end if
    end do
  end function first_of

end module mortar_slide
