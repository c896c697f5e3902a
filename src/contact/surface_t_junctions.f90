!> T-junctions of surfaces: edges that are parts of others.
module surface_t_junctions
  use base_kinds, only: wp
  use base_sort, only: sort_index
  use surface_basis, only: surface_functions_at, make_rational
  use contact_pair, only: surface_t, edge_part_t
  implicit none
  private
  public :: part_list_t, edge_point, try_part, set_parts

  integer, parameter :: NSAMPLE = 33, MOST_STEPS = 30
  real(wp), parameter :: SAME = 1.0e-9_wp        !! parameters that differ by less are one
  real(wp), parameter :: FRACTION = 40320.0_wp   !! parameters near such fractions are these

  !> Edge fine(i) lies in edge coarse(i) from its parameter at(1, i) to at(2, i).
  type :: part_list_t
    integer :: n = 0
    integer, allocatable :: fine(:), coarse(:)   !! edge k of element e at 4(e-1)+k
    real(wp), allocatable :: at(:, :)
  end type part_list_t

contains

  !> Reference position and slope at parameter t of an edge.
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

  !> Note edge a where it is a part of edge b.
  subroutine try_part(xr, surface, a, b, near, list)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: a, b          !! edge k of element e at 4(e-1)+k
    real(wp), intent(in) :: near         !! points as close as this are one [L]
    type(part_list_t), intent(inout) :: list
    real(wp) :: t(3), x(3), y(3), slope(3)
    integer :: i
    logical :: on

    do i = 1, 3
      call edge_point(xr, surface, (a + 3)/4, a - 4*((a - 1)/4), real(2*i - 4, wp)*0.5_wp, x, slope)
      call locate(xr, surface, (b + 3)/4, b - 4*((b - 1)/4), x, t(i), y)
      on = norm2(x - y) <= near
      if (.not. on) return
    end do
    if (abs(t(3) - t(1)) > 2.0_wp - SAME .or. abs(t(3) - t(1)) < SAME) return
    if (abs(t(1) + t(3) - 2*t(2)) > 1.0e3_wp*SAME) return ! another parametrization
    if (.not. allocated(list%fine)) allocate (list%fine(0), list%coarse(0), list%at(2, 0))
    list%n = list%n + 1
    list%fine = [list%fine, a]
    list%coarse = [list%coarse, b]
    list%at = reshape([list%at, t(1), t(3)], [2, list%n])
  end subroutine try_part

  !> Nearest point of an edge: Gauss-Newton from the best of some samples.
  subroutine locate(xr, surface, e, k, x, t, y)
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
  end subroutine locate

  !> Both sides of each part. An edge that its parts do not cover stays a border.
  subroutine set_parts(list, surface)
    type(part_list_t), intent(in) :: list
    type(surface_t), intent(inout) :: surface
    integer, allocatable :: count(:)
    integer :: i, b

    if (list%n == 0) return
    allocate (count(4*surface%nelem), source=0)
    do i = 1, list%n
      count(list%fine(i)) = 1
    end do
    do i = 1, list%n
      b = list%coarse(i)
      if (sum(abs(list%at(2, :) - list%at(1, :)), list%coarse == b) < 2.0_wp - SAME) cycle
      count(b) = count(b) + 1
    end do
    allocate (surface%part_first(4*surface%nelem + 1), surface%part(sum(count)))
    surface%part_first(1) = 1
    do i = 1, size(count)
      surface%part_first(i + 1) = surface%part_first(i) + count(i)
    end do
    do i = 1, 4*surface%nelem
      if (count(i) > 0) call fill_edge(list, i, surface)
    end do
  end subroutine set_parts

  !> The parts of one edge, rising; a part of another edge has itself for its only one.
  subroutine fill_edge(list, edge, surface)
    type(part_list_t), intent(in) :: list
    integer, intent(in) :: edge
    type(surface_t), intent(inout) :: surface
    type(edge_part_t) :: p
    integer, allocatable :: own(:), order(:)
    integer :: i, j, n

    n = surface%part_first(edge) - 1
    own = pack([(i, i=1, list%n)], list%fine == edge)
    if (size(own) > 0) then
      p%own = [-1.0_wp, 1.0_wp]
      p%other = list%at(:, own(1))
      p%elem = (list%coarse(own(1)) + 3)/4
      p%edge = list%coarse(own(1)) - 4*(p%elem - 1)
      surface%part(n + 1) = p
    else
      own = pack([(i, i=1, list%n)], list%coarse == edge)
      allocate (order(size(own)))
      call sort_index(minval(list%at(:, own), 1), order)
      do i = 1, size(own)
        j = own(order(i))
        p%own = [minval(list%at(:, j)), maxval(list%at(:, j))]
        p%other = merge([-1.0_wp, 1.0_wp], [1.0_wp, -1.0_wp], list%at(1, j) < list%at(2, j))
        p%elem = (list%fine(j) + 3)/4
        p%edge = list%fine(j) - 4*(p%elem - 1)
        surface%part(n + i) = p
      end do
    end if
    i = (edge + 3)/4
    j = edge - 4*(i - 1)
    surface%neighbour(j, i) = surface%part(n + 1)%elem
    surface%edge(j, i) = surface%part(n + 1)%edge
  end subroutine fill_edge

end module surface_t_junctions
