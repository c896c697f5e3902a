!> Surface traversal: moves a point along a surface from element to element.
module surface_traversal
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use projection_type, only: shape_t
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: walk, step_across, corner_at, corner_xi

  integer, parameter :: MOST_CROSSINGS = 100
  real(wp), parameter :: FLAT = 1.0e-12_wp !! squared sine of an angle between parallel tangents

contains

  !> Move (elem, xi) by the tangential vector v: dxi = v . a^alpha. Beyond an edge, the remainder of
  !! v is taken in the tangent plane of the next element; at the outer boundary, the point slides
  !! along the edge.
  pure subroutine walk(surface, shape, elem, xi, v, clamped)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(inout) :: elem
    real(wp), intent(inout) :: xi(2)
    real(wp), intent(in) :: v(3)      !! [L]
    logical, intent(out) :: clamped   !! the outer boundary stopped the point
    real(wp) :: rest, fraction, distance, d(2)
    integer :: crossing, i, j, k, next, behind
    logical :: held(2), ok

    clamped = .false.
    held = .false.
    behind = 0 ! the edge that the point has crossed last
    rest = 1.0_wp
    do crossing = 1, MOST_CROSSINGS
      call tangential_step(surface, shape, elem, xi, rest*v, held, d, ok)
      if (.not. ok) return
      fraction = 1.0_wp ! fraction of the step at which parameter i reaches the first edge
      i = 0
      do j = 1, 2
        distance = sign(1.0_wp, d(j)) - xi(j)
        if (.not. abs(d(j)) > abs(distance)*(1.0_wp + epsilon(1.0_wp))) cycle
        if (abs(distance) <= fraction*abs(d(j))) then
          fraction = abs(distance/d(j))
          i = j
        end if
      end do
      xi = max(-1.0_wp, min(1.0_wp, xi + fraction*d))
      if (i == 0) return
      rest = rest*(1.0_wp - fraction)
      k = 2*i - merge(1, 0, d(i) < 0.0_wp)
      xi(i) = sign(1.0_wp, d(i))
      next = surface%neighbour(k, elem)
      if (next == 0) clamped = .true.
      if (next == 0 .or. k == behind) then ! a fold sends the point back: slide along the edge
        held(i) = .true.
        if (all(held)) return
      else
        call step_across(surface, k, elem, xi, behind)
        held = .false.
      end if
    end do
  end subroutine walk

  !> Find the parameters that a point of an edge has in the element on the other side of the edge.
  pure subroutine step_across(surface, k, elem, xi, behind)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: k            !! an edge that has a neighbour
    integer, intent(inout) :: elem
    real(wp), intent(inout) :: xi(2)
    integer, intent(out) :: behind      !! the edge in the other element
    integer :: m, i, from, to
    real(wp) :: t

    t = xi(merge(2, 1, k < 3))
    from = 1
    to = 0
    if (allocated(surface%part_first)) then
      from = surface%part_first(4*(elem - 1) + k)
      to = surface%part_first(4*(elem - 1) + k + 1) - 1
    end if
    if (to >= from) then ! T-junction: the part of the edge at t
      do i = from, to - 1
        if (t <= surface%part(i)%own(2)) exit
      end do
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

  !> Find the step v . a^alpha; a parameter that is held does not change.
  pure subroutine tangential_step(surface, shape, elem, xi, v, held, d, ok)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), v(3)
    logical, intent(in) :: held(2)
    real(wp), intent(out) :: d(2)
    logical, intent(out) :: ok !! false if the tangents span no plane
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

  !> Corner of the element in the same quadrant as xi.
  pure integer function corner_at(xi)
    real(wp), intent(in) :: xi(2)

    corner_at = merge(2, 1, xi(1) > 0.0_wp) + merge(2, 0, xi(2) > 0.0_wp)
  end function corner_at

  !> Parameters of corner c.
  pure function corner_xi(c) result(xi)
    integer, intent(in) :: c
    real(wp) :: xi(2)

    xi = [merge(1.0_wp, -1.0_wp, mod(c, 2) == 0), merge(1.0_wp, -1.0_wp, c > 2)]
  end function corner_xi

end module surface_traversal
