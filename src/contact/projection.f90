!> Closest-point projection onto a surface: Newton's method from element to element.
!!
!! Within an element the distance is minimised under the bounds -1 <= xi <= 1. If it would decrease
!! further beyond an edge, the search continues in the neighbour if the distance decreases there
!! too; otherwise the surface has a ridge there, and the projection is a point of the edge. At a
!! vertex, all elements around it are tried. Projections onto the outer boundary are rejected.
!!
!! Read on: projection_type (the result of a projection), projection_iterate (one Newton step),
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
  use surface_traversal, only: step_across, corner_at, corner_xi
  use tensor, only: cross
  implicit none
  private
  public :: project

  integer, parameter :: MOST_STEPS = 100
  !> Limit of the changes of the element without a step: as many as a ring of elements may need.
  integer, parameter :: MOST_CHANGES = 12
  !> Number of changes of the element with steps after which a better start is looked for.
  integer, parameter :: FAR_AWAY = 3
  !> A push beyond an edge that is smaller than this cannot distinguish a ridge from a smooth edge.
  real(wp), parameter :: NO_PUSH = 1.0e-10_wp
  !> Steps shorter than this that no longer become shorter are due to rounding.
  real(wp), parameter :: STALLED = 1.0e-8_wp
  !> A step shorter than this, which squares the error, is the last one and needs no further
  !! evaluation.
  real(wp), parameter :: LAST_STEP = 3.0e-8_wp
  !> If an iterate is closer than this to a collapsed edge, the other elements around the edge are
  !! tried.
  real(wp), parameter :: BESIDE = 1.0e-3_wp
  !> Ways in which an iteration ends.
  integer, parameter :: LOST = 0, OUTER = 1, SMOOTH = 2, ON_EDGE = 3, ON_VERTEX = 4

contains

  !> Project the point x onto a surface whose grid is up to date. The iteration starts at foot%elem
  !! and foot%xi; it starts from the grid if there is no such element, or if it ends farther away
  !! than `reach`. There is no projection (element 0) if x lies beyond the outer boundary, if it is
  !! farther than `reach` from the box around the surface, or if the tangents are parallel.
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
      call minimise(surface, shape, x, first, ending, edge, changes)
      if (ending >= SMOOTH .and. changes < FAR_AWAY .and. first%f <= far**2) then
        call set_foot(surface, shape, x, first, ending, edge, foot)
        return
      end if
    end if
    call nearest_start(grid, x, elem, xi)
    if (elem == 0) return
    call evaluate(surface, shape, elem, xi, x, second)
    call minimise(surface, shape, x, second, ending_2, edge_2, changes)
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

  !> Minimise the distance, beginning from an iterate.
  pure subroutine minimise(surface, shape, x, iterate, ending, edge, changes)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: iterate
    integer, intent(out) :: ending
    integer, intent(out) :: edge(2)    !! active bounds; 0: none
    integer, intent(out) :: changes    !! number of changes of the element
    real(wp) :: d(2), push(2), size, last
    integer :: i, step, idle
    logical :: moved, definite, squares

    ending = LOST
    idle = 0
    changes = 0
    last = huge(1.0_wp)
    do step = 1, MOST_STEPS
      if (.not. iterate%regular) return
      call find_active(iterate, edge, push)
      if (idle < MOST_CHANGES) then
        call change_element(surface, shape, x, edge, iterate, moved)
        if (moved) then
          if (idle == 0) changes = changes + 1
          idle = idle + 1
          cycle
        end if
      end if
      call find_step(iterate, edge > 0, d, definite, squares)
      size = max(abs(d(1)), abs(d(2)))
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
      if (any(edge == 0 .and. abs(iterate%xi) >= 1.0_wp)) last = huge(1.0_wp) ! cut short
      idle = 0
    end do
  end subroutine minimise

  !> Change to an element across an active edge, around a vertex or around a collapsed edge if the
  !! distance decreases there.
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
      call evaluate(surface, shape, elem, xi, x, other)
      moved = falls_inwards(other, (behind + 1)/2)
      if (moved) then
        iterate = other
        return
      end if
    end do
    if (all(edge > 0)) call try_ring(surface, shape, x, iterate, moved)
    if (moved .or. .not. allocated(surface%point)) return
    do i = 1, 2
      if (1.0_wp - abs(iterate%xi(i)) > BESIDE) cycle
      if (.not. surface%point(merge(2*i - 1, 2*i, iterate%xi(i) < 0.0_wp), iterate%elem)) cycle
      call try_ring(surface, shape, x, iterate, moved)
      return
    end do
  end subroutine change_element

  !> Change to an element around the nearest vertex if the distance decreases there.
  pure subroutine try_ring(surface, shape, x, iterate, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: iterate
    logical, intent(out) :: moved
    type(iterate_t) :: other
    integer :: vertex, r, elem

    moved = .false.
    vertex = surface%vertex(corner_at(iterate%xi), iterate%elem)
    do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
      elem = surface%ring_elem(r)
      if (elem == iterate%elem) cycle
      call evaluate(surface, shape, elem, corner_xi(surface%ring_corner(r)), x, other)
      moved = falls_inwards(other, 1) .or. falls_inwards(other, 2)
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

  !> Kind of a stationary point with these active bounds.
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

  !> Mean of the normals of the elements at an edge or around a vertex.
  pure function mean_normal(surface, shape, x, iterate, ending, edge) result(n)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: ending, edge(2)
    real(wp) :: n(3), xi(2)
    type(iterate_t) :: other
    integer :: elem, vertex, r, behind

    n = normal(iterate)
    if (ending == ON_EDGE) then
      elem = iterate%elem
      xi = iterate%xi
      call step_across(surface, maxval(edge), elem, xi, behind)
      call evaluate(surface, shape, elem, xi, x, other)
      if (other%regular) n = n + normal(other)
    else
      vertex = surface%vertex(corner_at(iterate%xi), iterate%elem)
      do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
        if (surface%ring_elem(r) == iterate%elem) cycle
        call evaluate(surface, shape, surface%ring_elem(r), corner_xi(surface%ring_corner(r)), x, &
                      other)
        if (other%regular) n = n + normal(other)
      end do
    end if
    n = n/max(norm2(n), tiny(1.0_wp))
  end function mean_normal

end module projection
