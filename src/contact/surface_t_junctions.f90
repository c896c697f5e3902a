!> T-junctions of surfaces: edges that are a part of an edge of another element.
module surface_t_junctions
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index
  use contact_pair, only: surface_t, edge_part_t
  use surface_basis, only: surface_functions_at, make_rational
  implicit none
  private
  public :: edge_point, match_t_junctions

  integer, parameter :: NSAMPLE = 33, MOST_STEPS = 30
  !> Parameters that differ by less than SAME are equal; a parameter that is this close to a
  !! multiple of 1/FRACTION is rounded to it.
  real(wp), parameter :: SAME = 1.0e-9_wp, FRACTION = 40320.0_wp

contains

  !> Find the position at parameter t of an edge, and its derivative, in the reference
  !! configuration.
  subroutine edge_point(xr, surface, e, k, t, x, slope)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    real(wp), intent(in) :: t
    real(wp), intent(out) :: x(3), slope(3) !! [L]
    real(wp) :: shp(surface%first(e + 1) - surface%first(e)), xi(2)
    real(wp) :: dshp(2, size(shp))
    integer :: a, d

    d = merge(2, 1, k < 3)
    xi = merge(-1.0_wp, 1.0_wp, mod(k, 2) == 1)
    xi(d) = t
    associate (first => surface%first(e), last => surface%first(e + 1) - 1)
      call surface_functions_at(surface%basis(surface%ibasis(e)), xi, shp, dshp)
      if (allocated(surface%w)) call make_rational(surface%w(first:last), shp, dshp)
      x = 0.0_wp
      slope = 0.0_wp
      do a = first, last
        x = x + xr(:, surface%node(a))*shp(a - first + 1)
        slope = slope + xr(:, surface%node(a))*dshp(d, a - first + 1)
      end do
    end associate
  end subroutine edge_point

  !> Find the T-junctions among edges without a neighbour, and set surface%part, neighbour and edge
  !! there. An edge that its parts do not cover completely stays on the outer boundary. Edge k of
  !! element e has the number 4(e-1)+k.
  subroutine match_t_junctions(xr, edge, key, near, surface)
    real(wp), intent(in) :: xr(:, :)
    integer, intent(in) :: edge(:)       !! edges without a neighbour
    integer(i8), intent(in) :: key(:)    !! (size(edge)) keys, equal for edges with the same nodes
    real(wp), intent(in) :: near(:)      !! (nelem) distance below which points are equal [L]
    type(surface_t), intent(inout) :: surface
    !> Edge fine(i) lies in edge coarse(i) from its parameter at(1, i) to at(2, i).
    integer, allocatable :: fine(:), coarse(:)
    real(wp), allocatable :: at(:, :)
    integer :: order(size(edge)), count(4*surface%nelem)
    integer :: i, j, a, b, from
    real(wp) :: t(2)

    allocate (fine(0), coarse(0), at(2, 0))
    call sort_index(key, order)
    from = 1
    do i = 1, size(edge)
      if (key(order(i)) /= key(order(from))) from = i
      do j = from, size(edge)
        if (key(order(j)) /= key(order(from))) exit
        a = edge(order(i))
        b = edge(order(j))
        if (a == b) cycle
        if (.not. is_part(xr, surface, a, b, min(near((a + 3)/4), near((b + 3)/4)), t)) cycle
        fine = [fine, a]
        coarse = [coarse, b]
        at = reshape([at, t], [2, size(fine)])
      end do
    end do
    if (size(fine) == 0) return
    count = 0
    count(fine) = 1
    do i = 1, size(coarse)
      b = coarse(i)
      if (sum(abs(at(2, :) - at(1, :)), coarse == b) < 2.0_wp - SAME) cycle
      count(b) = count(b) + 1
    end do
    allocate (surface%part_first(4*surface%nelem + 1), surface%part(sum(count)))
    surface%part_first(1) = 1
    do i = 1, size(count)
      surface%part_first(i + 1) = surface%part_first(i) + count(i)
      if (count(i) > 0) call set_parts(fine, coarse, at, i, surface)
    end do
  end subroutine match_t_junctions

  !> Does edge a lie on edge b, with a parameter that is a linear function of that of b? If so, it
  !! extends from t(1) to t(2) on edge b.
  logical function is_part(xr, surface, a, b, near, t)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: a, b          !! edge k of element e at 4(e-1)+k
    real(wp), intent(in) :: near         !! distance below which points are equal [L]
    real(wp), intent(out) :: t(2)
    real(wp) :: at(3), x(3), y(3), slope(3)
    integer :: i

    do i = 1, 3
      call edge_point(xr, surface, (a + 3)/4, a - 4*((a - 1)/4), real(2*i - 4, wp)*0.5_wp, x, slope)
      call project_on_edge(xr, surface, (b + 3)/4, b - 4*((b - 1)/4), x, at(i), y)
      is_part = norm2(x - y) <= near
      if (.not. is_part) return
    end do
    t = at([1, 3])
    is_part = abs(at(3) - at(1)) <= 2.0_wp - SAME .and. abs(at(3) - at(1)) >= SAME &
              .and. abs(at(1) + at(3) - 2*at(2)) <= 1.0e3_wp*SAME
  end function is_part

  !> Find the closest point of an edge by a Gauss-Newton iteration from the best of some samples.
  subroutine project_on_edge(xr, surface, e, k, x, t, y)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    real(wp), intent(in) :: x(3)
    real(wp), intent(out) :: t, y(3)
    real(wp) :: slope(3), best, step, s
    integer :: i

    best = huge(best)
    t = -1.0_wp
    do i = 1, NSAMPLE
      s = -1.0_wp + 2.0_wp*(i - 1)/(NSAMPLE - 1)
      call edge_point(xr, surface, e, k, s, y, slope)
      if (norm2(y - x) >= best) cycle
      best = norm2(y - x)
      t = s
    end do
    do i = 1, MOST_STEPS
      call edge_point(xr, surface, e, k, t, y, slope)
      step = dot_product(x - y, slope)/max(dot_product(slope, slope), tiny(1.0_wp))
      t = max(-1.0_wp, min(1.0_wp, t + step))
      if (abs(step) <= 4*epsilon(1.0_wp)) exit
    end do
    s = anint(t*FRACTION)/FRACTION
    if (abs(t - s) <= SAME) t = s
    call edge_point(xr, surface, e, k, t, y, slope)
  end subroutine project_on_edge

  !> Set the parts of each edge in the order of the edge's parameter; an edge that is itself a part
  !! has one part.
  subroutine set_parts(fine, coarse, at, edge, surface)
    integer, intent(in) :: fine(:), coarse(:)
    real(wp), intent(in) :: at(:, :)
    integer, intent(in) :: edge
    type(surface_t), intent(inout) :: surface
    type(edge_part_t) :: p
    integer, allocatable :: own(:), order(:)
    integer :: i, j, n

    n = surface%part_first(edge) - 1
    own = pack([(i, i=1, size(fine))], fine == edge)
    if (size(own) > 0) then
      p%own = [-1.0_wp, 1.0_wp]
      p%other = at(:, own(1))
      p%elem = (coarse(own(1)) + 3)/4
      p%edge = coarse(own(1)) - 4*(p%elem - 1)
      surface%part(n + 1) = p
    else
      own = pack([(i, i=1, size(fine))], coarse == edge)
      allocate (order(size(own)))
      call sort_index(minval(at(:, own), 1), order)
      do i = 1, size(own)
        j = own(order(i))
        p%own = [minval(at(:, j)), maxval(at(:, j))]
        p%other = merge([-1.0_wp, 1.0_wp], [1.0_wp, -1.0_wp], at(1, j) < at(2, j))
        p%elem = (fine(j) + 3)/4
        p%edge = fine(j) - 4*(p%elem - 1)
        surface%part(n + i) = p
      end do
    end if
    i = (edge + 3)/4
    j = edge - 4*(i - 1)
    surface%neighbour(j, i) = surface%part(n + 1)%elem
    surface%edge(j, i) = surface%part(n + 1)%edge
  end subroutine set_parts

end module surface_t_junctions
