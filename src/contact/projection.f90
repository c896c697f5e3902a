!> Closest-point projection onto a surface, by a Newton iteration that passes from element to
!! element.
!!
!! Within an element the distance is minimised under the bounds -1 <= xi <= 1. If the distance would
!! decrease further beyond an edge, the search examines the neighbour. If the distance decreases in
!! the neighbour too, the search continues there; otherwise the edge is a ridge of the surface, and
!! the projection is a point of the edge. At a vertex, all elements around it are tried; in a
!! triangle, the vertex may be a collapsed edge, at which a tangent vanishes (surface_chart).
!! Projections onto the outer boundary are rejected.
!!
!! See also projection_type (the result of a projection), projection_iterate (one Newton step),
!! projection_search (starting points), then contact_point (gap, traction and tangent at a
!! projection).
module projection
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use projection_iterate, only: iterate_t, evaluate, find_step, find_active, take_step, &
                                take_last_step, is_rounding
  use projection_search, only: grid_t, nearest_start, is_near
  use projection_type, only: foot_t, shape_t
  use surface_chart, only: collapsed_side
  use surface_traversal, only: step_across, corner_at, corner_xi
  use tensor, only: cross
  implicit none
  private
  public :: project, project_from

  integer, parameter :: MOST_STEPS = 100
  !> Largest number of times that the element may change without a step in between; this is enough
  !! for all elements around a vertex.
  integer, parameter :: MOST_CHANGES = 12
  !> If the element has changed this many times with steps in between, a better start is sought.
  integer, parameter :: FAR_AWAY = 3
  !> If the step beyond an edge is smaller than this, a ridge cannot be distinguished from a smooth
  !! edge.
  real(wp), parameter :: NO_PUSH = 1.0e-10_wp
  !> If steps shorter than this no longer become shorter, they are due to rounding.
  real(wp), parameter :: STALLED = 1.0e-8_wp
  !> A step that squares the error and is shorter than this is the last one; no further evaluation
  !! is needed.
  real(wp), parameter :: LAST_STEP = 3.0e-8_wp
  !> If an iterate is closer than BESIDE to a collapsed edge and its step would pass this edge, the
  !! other elements around this vertex are tried. An iterate that is closer than ARRIVED counts as
  !! lying on the edge. These numbers, and INSIDE, are differences of a parameter.
  real(wp), parameter :: BESIDE = 1.0e-3_wp, ARRIVED = 1.0e-9_wp
  !> On its collapsed edge, an element is evaluated at this distance from the edge instead.
  real(wp), parameter :: INSIDE = 1.0e-6_wp
  !> Ways in which an iteration ends.
  integer, parameter :: LOST = 0, OUTER = 1, SMOOTH = 2, ON_EDGE = 3, ON_VERTEX = 4

contains

  !> Project the point x onto a surface whose grid is up to date. The iteration starts at foot%elem
  !! and foot%xi; if there is no such element, or if the iteration ends farther away than `reach`,
  !! it starts from the grid. There is no projection (element 0) if x lies beyond the outer
  !! boundary, if it is farther than `reach` from the box around the surface, if the tangents are
  !! parallel, or if the iteration does not converge.
  pure subroutine project(surface, shape, grid, x, foot, reach)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    type(foot_t), intent(inout) :: foot
    real(wp), intent(in), optional :: reach !! [L]
    type(iterate_t) :: first, second
    integer :: elem, ending, ending_2, changes, edge(2), edge_2(2)
    real(wp) :: xi(2), far

    elem = foot%elem
    foot%elem = 0
    foot%outer = 0
    foot%gap = huge(1.0_wp)
    if (.not. all(ieee_is_finite(x)) .or. any(grid%n == 0)) return
    far = 0.5_wp*sqrt(huge(1.0_wp))
    if (maxval(abs(x)) > far) return
    if (present(reach)) then
      if (.not. is_near(grid, x, reach)) return
      far = min(far, reach)
    end if
    ending = LOST
    first%f = huge(1.0_wp)
    if (elem >= 1 .and. elem <= surface%nelem) then
      xi = max(-1.0_wp, min(1.0_wp, foot%xi))
      call evaluate(surface, shape, elem, xi, x, first)
      call minimise(surface, shape, x, .false., first, ending, edge, changes)
      if (ending >= SMOOTH .and. changes < FAR_AWAY .and. first%f <= far**2) then
        call set_foot(surface, shape, x, first, ending, edge, foot)
        return
      end if
    end if
    call nearest_start(grid, x, elem, xi)
    if (elem == 0) return
    call evaluate(surface, shape, elem, xi, x, second)
    call minimise(surface, shape, x, .false., second, ending_2, edge_2, changes)
    if (ending_2 >= SMOOTH .and. (ending < SMOOTH .or. second%f < first%f)) then
      call set_foot(surface, shape, x, second, ending_2, edge_2, foot)
    else if (ending >= SMOOTH) then
      call set_foot(surface, shape, x, first, ending, edge, foot)
    else if (ending_2 == OUTER .and. second%f <= far**2) then
      foot%outer = second%elem
      foot%outer_xi = second%xi
      foot%outer_gap = dot_product(second%r, normal(second))
    end if
  end subroutine project

  !> Project the point x onto the part of a surface on which foot%elem and foot%xi lie. The search
  !! starts only there, so the projection is a local minimum of the distance. There is no projection
  !! (element 0) if the search ends at the outer boundary or fails. If `stays` is true, the search
  !! does not leave the element.
  pure subroutine project_from(surface, shape, x, foot, stays)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(foot_t), intent(inout) :: foot
    logical, intent(in), optional :: stays
    type(iterate_t) :: iterate
    integer :: elem, ending, changes, edge(2)
    logical :: within

    elem = foot%elem
    foot%elem = 0
    foot%outer = 0
    foot%gap = huge(1.0_wp)
    if (elem < 1 .or. elem > surface%nelem) return
    if (.not. all(abs(x) < 0.5_wp*sqrt(huge(1.0_wp)))) return
    call evaluate(surface, shape, elem, max(-1.0_wp, min(1.0_wp, foot%xi)), x, iterate)
    within = .false.
    if (present(stays)) within = stays
    call minimise(surface, shape, x, within, iterate, ending, edge, changes)
    if (ending >= SMOOTH) then
      call set_foot(surface, shape, x, iterate, ending, edge, foot)
    else if (ending == OUTER) then
      foot%outer = iterate%elem
      foot%outer_xi = iterate%xi
      foot%outer_gap = dot_product(iterate%r, normal(iterate))
    end if
  end subroutine project_from

  !> Minimise the distance, starting from an iterate.
  pure subroutine minimise(surface, shape, x, stays, iterate, ending, edge, changes)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    logical, intent(in) :: stays       !! do not leave the element
    type(iterate_t), intent(inout) :: iterate
    integer, intent(out) :: ending
    integer, intent(out) :: edge(2)    !! active bounds; 0: none
    integer, intent(out) :: changes    !! number of changes of the element
    real(wp) :: d(2), push(2), size, last
    integer :: i, side, step, idle
    logical :: moved, definite, squares, leaves

    ending = LOST
    if (.not. stays) call leave_vertex(surface, shape, x, iterate)
    idle = 0
    changes = 0
    last = huge(1.0_wp)
    do step = 1, MOST_STEPS
      if (.not. iterate%regular) return
      call find_active(iterate, edge, push)
      leaves = idle < MOST_CHANGES .and. .not. stays
      if (leaves) then
        call change_element(surface, shape, x, edge, iterate, moved)
        if (moved) then
          call count_change(idle, changes)
          cycle
        end if
      end if
      call find_step(iterate, edge > 0, d, definite, squares)
      side = vertex_ahead(surface, iterate, d)
      if (side > 0 .and. leaves) then
        call try_ring(surface, shape, x, iterate, moved)
        if (moved) then
          call count_change(idle, changes)
          cycle
        end if
      end if
      if (side > 0) then
        i = (side + 1)/2
        if (1.0_wp - abs(iterate%xi(i)) < ARRIVED) then
          edge(i) = side
          edge(3 - i) = merge(2, 1, iterate%xi(3 - i) > 0.0_wp) + 2*(2 - i)
          ending = ON_VERTEX
          if (surface%outer(surface%vertex(corner_at(iterate%xi), iterate%elem))) ending = OUTER
          return
        end if
      end if
      size = max(abs(d(1)), abs(d(2)))
      if (size < LAST_STEP .and. leaves) then
        call leave_edge(surface, shape, x, edge, iterate, moved)
        if (moved) then
          call count_change(idle, changes)
          cycle
        end if
      end if
      if (squares .and. size < LAST_STEP) then
        if (all(abs(iterate%xi + d) < 1.0_wp)) then
          call take_last_step(x, d, iterate)
          ending = SMOOTH
          return
        end if
      end if
      if ((is_rounding(iterate, 1, d(1)) .and. is_rounding(iterate, 2, d(2))) .or. &
          (size < STALLED .and. size > 0.25_wp*last)) then
        if (.not. definite) return
        do i = 1, 2
          if (push(i) < NO_PUSH .or. is_rounding(iterate, i, 0.1_wp*push(i))) edge(i) = 0
        end do
        ending = ending_at(surface, iterate, edge)
        return
      end if
      call take_step(surface, shape, x, d, iterate, moved)
      if (.not. moved) return
      last = size
      if (any(edge == 0 .and. abs(iterate%xi) >= 1.0_wp)) last = huge(1.0_wp) ! cut at an edge
      idle = 0
    end do
  end subroutine minimise

  !> Count a change of the element. Several changes without a step in between count once.
  pure subroutine count_change(idle, changes)
    integer, intent(inout) :: idle     !! changes since the last step
    integer, intent(inout) :: changes

    if (idle == 0) changes = changes + 1
    idle = idle + 1
  end subroutine count_change

  !> At the end of an iteration, try the neighbour across an edge that the iterate has reached but
  !! beyond which the distance does not decrease. An example is a point on one face of a block: its
  !! closest point on the adjacent face lies on the edge between the two faces.
  pure subroutine leave_edge(surface, shape, x, edge, iterate, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: edge(2)     !! active bounds, whose neighbours were tried
    type(iterate_t), intent(inout) :: iterate
    logical, intent(out) :: moved
    integer :: i, reached(2)

    reached = edge
    do i = 1, 2
      if (1.0_wp - abs(iterate%xi(i)) >= ARRIVED) cycle
      reached(i) = 2*i - merge(0, 1, iterate%xi(i) > 0.0_wp)
    end do
    moved = any(reached > edge)
    if (moved) call change_element(surface, shape, x, reached, iterate, moved)
  end subroutine leave_edge

  !> Start beside a collapsed edge instead of on it.
  pure subroutine leave_vertex(surface, shape, x, iterate)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: iterate
    real(wp) :: xi(2)

    if (.not. allocated(surface%point)) return
    xi = iterate%xi
    call move_inside(surface, iterate%elem, xi)
    if (any(abs(xi - iterate%xi) > 0.0_wp)) then
      call evaluate(surface, shape, iterate%elem, xi, x, iterate)
    end if
  end subroutine leave_vertex

  !> Move a point off the collapsed edge of its element.
  pure subroutine move_inside(surface, elem, xi)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: elem
    real(wp), intent(inout) :: xi(2)
    integer :: g, side

    side = vertex_at(surface, elem, xi)
    if (side == 0) return
    g = (side + 1)/2
    xi(g) = (1.0_wp - INSIDE)*xi(g)
  end subroutine move_inside

  !> The collapsed side on which a point of an element lies; 0: none.
  pure integer function vertex_at(surface, elem, xi) result(side)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2)

    side = collapsed_side(surface, elem)
    if (side == 0) return
    if (abs(xi((side + 1)/2) - merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)) >= ARRIVED) side = 0
  end function vertex_at

  !> The collapsed side that is close to the iterate and that the step d would pass before any other
  !! edge; 0: there is none.
  pure integer function vertex_ahead(surface, iterate, d) result(side)
    type(surface_t), intent(in) :: surface
    type(iterate_t), intent(in) :: iterate
    real(wp), intent(in) :: d(2)
    real(wp) :: way, distance
    integer :: f, g

    side = collapsed_side(surface, iterate%elem)
    if (side == 0) return
    g = (side + 1)/2
    f = 3 - g
    way = d(g)*merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
    distance = 1.0_wp - iterate%xi(g)*merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
    if (distance > BESIDE .or. way < distance) then
      side = 0
    else if (abs(iterate%xi(f) + d(f)*(distance/way)) > 1.0_wp) then
      side = 0
    end if
  end function vertex_ahead

  !> Change to an element across an active edge or around a vertex if the distance decreases there.
  pure subroutine change_element(surface, shape, x, edge, iterate, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: edge(2)
    type(iterate_t), intent(inout) :: iterate
    logical, intent(out) :: moved
    type(iterate_t) :: other
    integer :: i, elem, behind
    real(wp) :: xi(2)

    moved = .false.
    do i = 1, 2
      if (edge(i) == 0) cycle
      elem = iterate%elem
      xi = iterate%xi
      if (surface%neighbour(edge(i), elem) == 0) cycle
      call step_across(surface, edge(i), elem, xi, behind)
      if (vertex_at(surface, elem, xi) > 0) cycle
      call evaluate(surface, shape, elem, xi, x, other)
      moved = falls_inwards(other, (behind + 1)/2)
      if (moved) then
        iterate = other
        return
      end if
    end do
    if (all(edge > 0)) call try_ring(surface, shape, x, iterate, moved)
  end subroutine change_element

  !> Change to an element around the nearest vertex if the distance decreases there. An element
  !! whose collapsed edge is the vertex is entered along each of the two edges that end there: both
  !! ends of the collapsed edge are in the ring.
  pure subroutine try_ring(surface, shape, x, iterate, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: iterate
    logical, intent(out) :: moved
    type(iterate_t) :: other
    real(wp) :: xi(2)
    integer :: vertex, r, elem, g, side

    moved = .false.
    vertex = surface%vertex(corner_at(iterate%xi), iterate%elem)
    do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
      elem = surface%ring_elem(r)
      if (elem == iterate%elem) cycle
      xi = corner_xi(surface%ring_corner(r))
      call evaluate(surface, shape, elem, xi, x, other)
      side = vertex_at(surface, elem, xi)
      if (side == 0) then
        moved = falls_inwards(other, 1) .or. falls_inwards(other, 2)
      else
        g = (side + 1)/2
        moved = other%g(g)*xi(g) < 0.0_wp .and. .not. is_rounding(other, g, other%g(g)/other%m(g))
        if (moved) then
          xi(g) = xi(g) + max(-1.0_wp, min(1.0_wp, other%g(g)/other%m(g)))
          call evaluate(surface, shape, elem, xi, x, other)
        end if
      end if
      if (moved) then
        iterate = other
        return
      end if
    end do
  end subroutine try_ring

  !> Does the distance decrease from an edge inwards, in direction i?
  pure logical function falls_inwards(iterate, i)
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: i

    falls_inwards = iterate%regular .and. iterate%g(i)*iterate%xi(i) < 0.0_wp
    if (falls_inwards) falls_inwards = .not. is_rounding(iterate, i, iterate%g(i)/iterate%m(i))
  end function falls_inwards

  !> How an iteration ends at a stationary point with these active bounds.
  pure integer function ending_at(surface, iterate, edge) result(ending)
    type(surface_t), intent(in) :: surface
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: edge(2)
    integer :: i

    ending = SMOOTH
    if (all(edge == 0)) return
    ending = ON_EDGE
    if (all(edge > 0)) then
      ending = ON_VERTEX
      if (surface%outer(surface%vertex(corner_at(iterate%xi), iterate%elem))) ending = OUTER
    end if
    do i = 1, 2
      if (edge(i) == 0) cycle
      if (surface%neighbour(edge(i), iterate%elem) == 0) ending = OUTER
    end do
  end function ending_at

  !> Set the projection from the last iterate.
  pure subroutine set_foot(surface, shape, x, iterate, ending, edge, foot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: ending, edge(2)
    type(foot_t), intent(inout) :: foot

    foot%elem = iterate%elem
    foot%xi = iterate%xi
    foot%x = iterate%x
    foot%a = iterate%a
    foot%b = iterate%b
    foot%free = edge == 0
    foot%n = normal(iterate)
    if (ending /= SMOOTH) foot%n = mean_normal(surface, shape, x, iterate, ending, edge)
    foot%gap = dot_product(iterate%r, foot%n)
    if (ending /= SMOOTH) foot%gap = sign(sqrt(iterate%f), foot%gap)
  end subroutine set_foot

  pure function normal(iterate) result(n)
    type(iterate_t), intent(in) :: iterate
    real(wp) :: n(3)

    n = cross(iterate%a(:, 1), iterate%a(:, 2))
    n = n/sqrt(n(1)**2 + n(2)**2 + n(3)**2)
  end function normal

  !> Mean of the normals of the elements at an edge or around a vertex. Around a vertex each normal
  !! has the angle of its element as its weight. Then the mean points to the side of the surface on
  !! which x lies, whatever the shape of the surface and the number of elements on each of its faces
  !! (Baerentzen and Aanaes 2005).
  pure function mean_normal(surface, shape, x, iterate, ending, edge) result(n)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: ending, edge(2)
    real(wp) :: n(3), xi(2)
    type(iterate_t) :: other
    integer :: elem, vertex, r, behind

    if (ending == ON_EDGE) then
      n = normal(iterate)
      elem = iterate%elem
      xi = iterate%xi
      call step_across(surface, maxval(edge), elem, xi, behind)
      call evaluate(surface, shape, elem, xi, x, other)
      if (other%regular) n = n + normal(other)
    else
      n = 0.0_wp
      vertex = surface%vertex(corner_at(iterate%xi), iterate%elem)
      do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
        xi = corner_xi(surface%ring_corner(r))
        call move_inside(surface, surface%ring_elem(r), xi)
        call evaluate(surface, shape, surface%ring_elem(r), xi, x, other)
        if (other%regular) n = n + angle_at(surface, shape, other)*normal(other)
      end do
      if (.not. norm2(n) > 0.0_wp) n = normal(iterate)
    end if
    n = n/max(norm2(n), tiny(1.0_wp))
  end function mean_normal

  !> Angle of an element at a corner. At each end of a collapsed edge it is half of the angle of the
  !! triangle at the vertex, because both ends are in the ring of the vertex.
  pure real(wp) function angle_at(surface, shape, iterate) result(angle)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(iterate_t), intent(in) :: iterate   !! at the corner, or beside a collapsed edge
    type(iterate_t) :: other
    real(wp) :: a(3, 2), xi(2)
    integer :: g, side

    a = iterate%a*spread(sign(1.0_wp, iterate%xi), 1, 3)
    side = collapsed_side(surface, iterate%elem)
    if (side > 0) then
      g = (side + 1)/2
      if (iterate%xi(g)*merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1) > 0.0_wp) then
        xi = iterate%xi
        xi(3 - g) = -xi(3 - g)
        call evaluate(surface, shape, iterate%elem, xi, iterate%x, other)
        a(:, 3 - g) = other%a(:, g)*sign(1.0_wp, iterate%xi(g))
        angle = 0.5_wp*atan2(norm2(cross(a(:, 1), a(:, 2))), dot_product(a(:, 1), a(:, 2)))
        return
      end if
    end if
    angle = atan2(norm2(cross(a(:, 1), a(:, 2))), dot_product(a(:, 1), a(:, 2)))
  end function angle_at

end module projection
