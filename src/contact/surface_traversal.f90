!> Moving a point along a surface.
!!
!! From element to element of a surface: where the distance to a point falls further.
module surface_traversal
  use base_kinds, only: wp
  use projection_type, only: shape_t
  use contact_pair, only: surface_t
  use surface_geometry, only: surface_point
  use projection_iterate, only: iterate_t, look_at, is_rounding
  implicit none
  private
  public :: walk, step_across, change_element, leave_point, corner_at, corner_xi

  integer, parameter :: MOST_CROSSINGS = 100
  real(wp), parameter :: FLAT = 1.0e-12_wp !! squared sine between tangents that have no plane

  !> So close to an edge that is a point other elements round it are asked.
  real(wp), parameter :: BESIDE = 1.0e-3_wp

contains

  !> Move (elem, xi) by the tangential vector v: dxi = v . a^alpha, on the next element's tangent
  !! plane behind a border with what is left; along the outer border where v leads over it.
  pure subroutine walk(surface, shape, elem, xi, v, clamped)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(inout) :: elem
    real(wp), intent(inout) :: xi(2)
    real(wp), intent(in) :: v(3)      !! [L]
    logical, intent(out) :: clamped   !! the outer border held it
    real(wp) :: left, share, d(2)
    integer :: crossing, i, k, next, behind
    logical :: held(2), ok

    clamped = .false.
    held = .false.
    behind = 0 ! the edge it came over
    left = 1.0_wp
    do crossing = 1, MOST_CROSSINGS
      call tangential_step(surface, shape, elem, xi, left*v, held, d, ok)
      if (.not. ok) return
      call first_border(xi, d, share, i)
      xi = max(-1.0_wp, min(1.0_wp, xi + share*d))
      if (i == 0) return
      left = left*(1.0_wp - share)
      k = 2*i - merge(1, 0, d(i) < 0.0_wp)
      xi(i) = sign(1.0_wp, d(i))
      next = surface%neighbour(k, elem)
      if (next == 0) clamped = .true.
      if (next == 0 .or. k == behind) then ! a fold sends it back: along the edge
        held(i) = .true.
        if (all(held)) return
      else
        call step_across(surface, k, elem, xi, behind)
        held = .false.
      end if
    end do
  end subroutine walk

  !> The point of an edge in the element behind it.
  pure subroutine step_across(surface, k, elem, xi, behind)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: k            !! edge, with a neighbour
    integer, intent(inout) :: elem
    real(wp), intent(inout) :: xi(2)
    integer, intent(out) :: behind      !! the edge there
    integer :: m, i
    real(wp) :: t

    t = xi(merge(2, 1, k < 3))
    i = part_at(surface, elem, k, t)
    if (i > 0) then
      associate (p => surface%part(i))
        t = p%other(1) + (t - p%own(1))*(p%other(2) - p%other(1))/(p%own(2) - p%own(1))
        t = max(-1.0_wp, min(1.0_wp, t))
        elem = p%elem
        behind = p%edge
      end associate
    else
      m = surface%edge(k, elem)
      t = sign(1.0_wp, real(m, wp))*t
      elem = surface%neighbour(k, elem)
      behind = abs(m)
    end if
    xi = merge(-1.0_wp, 1.0_wp, mod(behind, 2) == 1)
    xi(merge(2, 1, behind < 3)) = t
  end subroutine step_across

  !> The part of an edge at t; 0: the edge has no parts.
  pure integer function part_at(surface, elem, k, t) result(i)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: elem, k
    real(wp), intent(in) :: t
    integer :: last

    i = 0
    if (.not. allocated(surface%part_first)) return
    last = surface%part_first(4*(elem - 1) + k + 1) - 1
    if (last < surface%part_first(4*(elem - 1) + k)) return
    do i = surface%part_first(4*(elem - 1) + k), last - 1
      if (t <= surface%part(i)%own(2)) return
    end do
    i = last
  end function part_at

  !> v . a^alpha; a parameter that is held does not move.
  pure subroutine tangential_step(surface, shape, elem, xi, v, held, d, ok)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), v(3)
    logical, intent(in) :: held(2)
    real(wp), intent(out) :: d(2)
    logical, intent(out) :: ok
    real(wp) :: x(3), a(3, 2), b(3, 3), m11, m22, m12, g(2), det

    call surface_point(surface, shape, elem, xi, x, a, b)
    m11 = dot_product(a(:, 1), a(:, 1))
    m22 = dot_product(a(:, 2), a(:, 2))
    m12 = dot_product(a(:, 1), a(:, 2))
    g = [dot_product(v, a(:, 1)), dot_product(v, a(:, 2))]
    det = m11*m22 - m12*m12
    d = 0.0_wp
    ok = det > FLAT*m11*m22
    if (.not. ok) return
    if (held(1)) then
      d(2) = g(2)/m22
    else if (held(2)) then
      d(1) = g(1)/m11
    else
      d = [m22*g(1) - m12*g(2), m11*g(2) - m12*g(1)]/det
    end if
  end subroutine tangential_step

  !> Share of the step up to the first border, and the parameter that meets it; 0: none.
  pure subroutine first_border(xi, d, share, i)
    real(wp), intent(in) :: xi(2), d(2)
    real(wp), intent(out) :: share
    integer, intent(out) :: i
    real(wp) :: way
    integer :: j

    share = 1.0_wp
    i = 0
    do j = 1, 2
      way = sign(1.0_wp, d(j)) - xi(j) ! to the border ahead
      if (.not. abs(d(j)) > abs(way)*(1.0_wp + epsilon(1.0_wp))) cycle
      if (abs(way) <= share*abs(d(j))) then
        share = abs(way/d(j))
        i = j
      end if
    end do
  end subroutine first_border

  !> To an element behind the edges, or round the vertex, where the distance falls.
  pure subroutine change_element(surface, shape, x, edge, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: edge(2)
    type(iterate_t), intent(inout) :: spot
    logical, intent(out) :: moved
    type(iterate_t) :: other
    integer :: i, elem, behind
    real(wp) :: xi(2)

    do i = 1, 2
      if (edge(i) == 0) cycle
      elem = spot%elem
      xi = spot%xi
      if (surface%neighbour(edge(i), elem) == 0) cycle
      call step_across(surface, edge(i), elem, xi, behind)
      call look_at(surface, shape, elem, xi, x, other)
      moved = falls_inwards(other, (behind + 1)/2)
      if (moved) then
        spot = other
        return
      end if
    end do
    moved = .false.
    if (all(edge > 0)) call look_round(surface, shape, x, corner_at(spot%xi), spot, moved)
  end subroutine change_element

  !> Beside an edge that is a point: to an element round it where the distance falls.
  pure subroutine leave_point(surface, shape, x, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(iterate_t), intent(inout) :: spot
    logical, intent(out) :: moved
    integer :: i

    moved = .false.
    if (.not. allocated(surface%point)) return
    do i = 1, 2
      if (1.0_wp - abs(spot%xi(i)) > BESIDE) cycle
      if (.not. surface%point(merge(2*i - 1, 2*i, spot%xi(i) < 0.0_wp), spot%elem)) cycle
      call look_round(surface, shape, x, corner_at(spot%xi), spot, moved)
      return
    end do
  end subroutine leave_point

  !> To an element round a corner of the spot's element where the distance falls.
  pure subroutine look_round(surface, shape, x, c, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: c
    type(iterate_t), intent(inout) :: spot
    logical, intent(out) :: moved
    type(iterate_t) :: other
    integer :: vertex, r, elem

    moved = .false.
    vertex = surface%vertex(c, spot%elem)
    do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
      elem = surface%ring_elem(r)
      if (elem == spot%elem) cycle
      call look_at(surface, shape, elem, corner_xi(surface%ring_corner(r)), x, other)
      moved = falls_inwards(other, 1) .or. falls_inwards(other, 2)
      if (moved) then
        spot = other
        return
      end if
    end do
  end subroutine look_round

  !> Does the distance fall from a border inwards, in direction i?
  pure logical function falls_inwards(spot, i)
    type(iterate_t), intent(in) :: spot
    integer, intent(in) :: i

    falls_inwards = spot%regular .and. spot%g(i)*spot%xi(i) < 0.0_wp
    if (falls_inwards) falls_inwards = .not. is_rounding(spot, i, spot%g(i)/spot%m(i))
  end function falls_inwards

  pure integer function corner_at(xi)
    real(wp), intent(in) :: xi(2)

    corner_at = merge(2, 1, xi(1) > 0.0_wp) + merge(2, 0, xi(2) > 0.0_wp)
  end function corner_at

  pure function corner_xi(c) result(xi)
    integer, intent(in) :: c
    real(wp) :: xi(2)

    xi = [merge(1.0_wp, -1.0_wp, mod(c, 2) == 0), merge(1.0_wp, -1.0_wp, c > 2)]
  end function corner_xi

end module surface_traversal
