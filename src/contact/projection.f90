!> Closest point of a surface: Newton from element to element, started from the last foot.
!!
!! In an element the distance falls under bounds -1 <= xi <= 1. At a border where it falls further
!! outwards the search goes on behind the border if it falls there too; if not, the border is an
!! edge between facets and the foot stays on it. A vertex asks all elements round it.
module projection
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use surface_traversal, only: change_element, leave_point, corner_at, corner_xi, step_across
  use projection_type, only: foot_t, shape_t
  use contact_pair, only: surface_t
  use projection_search, only: grid_t, nearest_start, is_near
  use projection_iterate, only: iterate_t, look_at, find_step, find_push, move_spot, shift_spot, &
      is_rounding
  implicit none
  private
  public :: project

  integer, parameter :: MOST_STEPS = 100
  !> Changes of the element without a step: as many as a ring of elements may need.
  integer, parameter :: MOST_CHANGES = 12
  !> Changes of the element with steps after which a better start is looked for.
  integer, parameter :: FAR_AWAY = 3
  !> A push over a border that is less than this does not tell an edge from a smooth border.
  real(wp), parameter :: NO_PUSH = 1.0e-10_wp
  !> Steps below this that no longer fall are rounding.
  real(wp), parameter :: STALLED = 1.0e-8_wp
  !> The last step, which squares an error of this size, needs no evaluation.
  real(wp), parameter :: LAST_STEP = 3.0e-8_wp
  !> Ends of a descent.
  integer, parameter :: LOST = 0, OFF = 1, SMOOTH = 2, ON_EDGE = 3, ON_VERTEX = 4

contains

  !> Foot of the point x on a surface whose grid is up to date. The search starts at foot%elem and
  !! foot%xi, or from the grid where that is no element or where what it leads to is farther away
  !! than `reach`. No foot, element 0: x lies beyond the outer boundary, farther than `reach` from
  !! the box round the surface, or where tangents are parallel.
  pure subroutine project(surface, shape, grid, x, foot, reach)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    type(foot_t), intent(inout) :: foot
    real(wp), intent(in), optional :: reach !! [L]
    type(iterate_t) :: spot, better
    integer :: elem, ending, again, changes, edge(2), other_edge(2)
    real(wp) :: xi(2), far

    elem = foot%elem
    foot%elem = 0
    foot%border = 0
    foot%gap = huge(1.0_wp)
    if (.not. all(ieee_is_finite(x)) .or. any(grid%n == 0)) return
    far = 0.5_wp*sqrt(huge(1.0_wp))
    if (maxval(abs(x)) > far) return
    if (present(reach)) then
      if (.not. is_near(grid, x, reach)) return
      far = min(far, reach)
    end if
    ending = LOST
    spot%f = huge(1.0_wp)
    if (elem >= 1 .and. elem <= surface%nelem) then
      xi = max(-1.0_wp, min(1.0_wp, foot%xi))
      call look_at(surface, shape, elem, xi, x, spot)
      call descend(surface, shape, x, spot, ending, edge, changes)
      if (ending >= SMOOTH .and. changes < FAR_AWAY .and. spot%f <= far**2) then
        call set_foot(surface, shape, x, spot, ending, edge, foot)
        return
      end if
    end if
    call nearest_start(grid, x, elem, xi)
    if (elem == 0) return
    call look_at(surface, shape, elem, xi, x, better)
    call descend(surface, shape, x, better, again, other_edge, changes)
    if (again >= SMOOTH .and. (ending < SMOOTH .or. better%f < spot%f)) then
      call set_foot(surface, shape, x, better, again, other_edge, foot)
    else if (ending >= SMOOTH) then
      call set_foot(surface, shape, x, spot, ending, edge, foot)
    else if (again == OFF .and. better%f <= far**2) then
      foot%border = better%elem
      foot%border_xi = better%xi
      foot%border_gap = dot_product(better%r, normal(better))
    end if
  end subroutine project

  !> From a spot to the closest point.
  pure subroutine descend(surface, shape, x, spot, ending, edge, changes)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: spot
    integer, intent(out) :: ending
    integer, intent(out) :: edge(2)    !! edges that the spot rests on; 0: none
    integer, intent(out) :: changes    !! of the element
    real(wp) :: d(2), push(2), size, last
    integer :: step, idle
    logical :: moved, definite, squares

    ending = LOST
    idle = 0
    changes = 0
    last = huge(1.0_wp)
    do step = 1, MOST_STEPS
      if (.not. spot%regular) return
      call find_push(spot, edge, push)
      if (idle < MOST_CHANGES) then
        moved = .false.
        if (any(edge > 0)) call change_element(surface, shape, x, edge, spot, moved)
        if (.not. moved) call leave_point(surface, shape, x, spot, moved)
        if (moved) then
          if (idle == 0) changes = changes + 1
          idle = idle + 1
          cycle
        end if
      end if
      call find_step(spot, edge > 0, d, definite, squares)
      size = max(abs(d(1)), abs(d(2)))
      if (squares .and. size < LAST_STEP) then
        if (all(abs(spot%xi + d) < 1.0_wp)) then
          call shift_spot(x, d, spot)
          ending = SMOOTH
          return
        end if
      end if
      if ((is_rounding(spot, 1, d(1)) .and. is_rounding(spot, 2, d(2))) .or. &
          (size < STALLED .and. size > 0.25_wp*last)) then
        if (definite) call find_ending(surface, push, spot, edge, ending)
        return
      end if
      call move_spot(surface, shape, x, d, spot, moved)
      if (.not. moved) return
      last = size
      if (any(edge == 0 .and. abs(spot%xi) >= 1.0_wp)) last = huge(1.0_wp) ! cut short
      idle = 0
    end do
  end subroutine descend

  !> What a spot is where nothing moves any more.
  pure subroutine find_ending(surface, push, spot, edge, ending)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: push(2)
    type(iterate_t), intent(in) :: spot
    integer, intent(inout) :: edge(2)
    integer, intent(out) :: ending
    integer :: i

    do i = 1, 2
      if (push(i) < NO_PUSH .or. is_rounding(spot, i, 0.1_wp*push(i))) edge(i) = 0
    end do
    ending = SMOOTH
    if (all(edge == 0)) return
    ending = ON_EDGE
    if (all(edge > 0)) then
      ending = ON_VERTEX
      if (surface%outer(surface%vertex(corner_at(spot%xi), spot%elem))) ending = OFF
    end if
    do i = 1, 2
      if (edge(i) == 0) cycle
      if (surface%neighbour(edge(i), spot%elem) == 0) ending = OFF
    end do
  end subroutine find_ending

  !> Hand the spot over.
  pure subroutine set_foot(surface, shape, x, spot, ending, edge, foot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(in) :: spot
    integer, intent(in) :: ending, edge(2)
    type(foot_t), intent(inout) :: foot

    foot%elem = spot%elem
    foot%xi = spot%xi
    foot%x = spot%x
    foot%a = spot%a
    foot%b = spot%b
    foot%free = edge == 0
    foot%n = normal(spot)
    if (ending /= SMOOTH) foot%n = mean_normal(surface, shape, x, spot, ending, edge)
    foot%gap = dot_product(spot%r, foot%n)
    if (ending /= SMOOTH) foot%gap = sign(sqrt(spot%f), foot%gap)
  end subroutine set_foot

  pure function normal(spot) result(n)
    type(iterate_t), intent(in) :: spot
    real(wp) :: n(3)

    associate (a => spot%a)
      n = [a(2, 1)*a(3, 2) - a(3, 1)*a(2, 2), a(3, 1)*a(1, 2) - a(1, 1)*a(3, 2), &
           a(1, 1)*a(2, 2) - a(2, 1)*a(1, 2)]
    end associate
    n = n/sqrt(n(1)**2 + n(2)**2 + n(3)**2)
  end function normal

  !> Mean of the normals of the elements at an edge or round a vertex.
  pure function mean_normal(surface, shape, x, spot, ending, edge) result(n)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(in) :: spot
    integer, intent(in) :: ending, edge(2)
    real(wp) :: n(3), xi(2)
    type(iterate_t) :: other
    integer :: elem, vertex, r, behind

    n = normal(spot)
    if (ending == ON_EDGE) then
      elem = spot%elem
      xi = spot%xi
      call step_across(surface, maxval(edge), elem, xi, behind)
      call look_at(surface, shape, elem, xi, x, other)
      if (other%regular) n = n + normal(other)
    else
      vertex = surface%vertex(corner_at(spot%xi), spot%elem)
      do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
        if (surface%ring_elem(r) == spot%elem) cycle
        call look_at(surface, shape, surface%ring_elem(r), corner_xi(surface%ring_corner(r)), x, &
                     other)
        if (other%regular) n = n + normal(other)
      end do
    end if
    n = n/max(norm2(n), tiny(1.0_wp))
  end function mean_normal

end module projection
