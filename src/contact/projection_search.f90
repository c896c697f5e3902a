!> Starting points of projections: a bucket grid finds the nearest of some sample points of a
!! surface.
module projection_search
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use contact_pair, only: contact_t, surface_t, is_integrated
  use projection_type, only: shape_t
  use surface_geometry, only: surface_point, update_shape
  implicit none
  private
  public :: grid_t, place_surfaces, update_grid, nearest_start, is_near

  integer, parameter :: MOST_CELLS = 4            !! largest number of cells per sample
  real(wp), parameter :: FAR = sqrt(huge(1.0_wp)) !! the squares of larger numbers overflow
  real(wp), parameter :: PER_SPACING = 2.0_wp     !! width of a cell, relative to the spacing of the
  !! samples

  !> Samples of a surface, sorted by the cells in which they lie.
  type :: grid_t
    real(wp) :: low(3) = 0.0_wp, high(3) = 0.0_wp !! box around the surface [L]
    real(wp) :: width = 1.0_wp                    !! width of a cell [L]
    integer :: n(3) = 0  !! number of cells; 0: the surface is empty or not finite
    integer, allocatable :: first(:)              !! first sample of each cell
    integer, allocatable :: elem(:)               !! (ns) element of a sample
    real(wp), allocatable :: xi(:, :)             !! (2, ns) parameters of a sample
    real(wp), allocatable :: x(:, :)              !! (3, ns) position of a sample [L]
    !> Work arrays for the sorting.
    integer, allocatable :: cell(:)               !! (ns)
    real(wp), allocatable :: sample(:, :)         !! (3, ns)
  end type grid_t

contains

  !> Find the shapes of both surfaces at the positions x, and the grids of those surfaces onto which
  !! points are projected.
  subroutine place_surfaces(contact, x, shape, grid)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)               !! (3, nnode) [L]
    type(shape_t), intent(inout) :: shape(2)
    type(grid_t), intent(inout) :: grid(2)
    integer :: k

    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      if (.not. is_integrated(contact, 3 - k)) cycle ! no points are projected
      call update_grid(contact%side(k), shape(k), grid(k))
    end do
  end subroutine place_surfaces

  !> Sample a surface that has moved, and sort the samples into a grid whose cells are about
  !! PER_SPACING times as wide as the distance between samples.
  subroutine update_grid(surface, shape, grid)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(inout) :: grid
    real(wp) :: a(3, 2), b(3, 3), total
    integer :: d, e, i, n, s, ns

    ns = sum([(per_direction(surface, e)**2, e=1, surface%nelem)])
    if (.not. allocated(grid%first)) then
      allocate (grid%first(MOST_CELLS*ns + 2), grid%elem(ns), grid%cell(ns))
      allocate (grid%xi(2, ns), grid%x(3, ns), grid%sample(3, ns))
    end if
    grid%n = 0
    if (ns == 0) return
    if (.not. all(ieee_is_finite(shape%bez))) return
    do d = 1, 3
      grid%low(d) = minval(shape%low(d, :))
      grid%high(d) = maxval(shape%high(d, :))
    end do
    if (.not. all(max(abs(grid%low), abs(grid%high)) < FAR)) return
    s = 0
    total = 0.0_wp
    do e = 1, surface%nelem
      n = per_direction(surface, e)
      total = total + maxval(shape%high(:, e) - shape%low(:, e))/n
      do i = 1, n*n
        s = s + 1
        call surface_point(surface, shape, e, sample_xi(n, i), grid%sample(:, s), a, b)
      end do
    end do
    if (.not. all(ieee_is_finite(grid%sample))) return
    grid%width = max(PER_SPACING*total/surface%nelem, maxval(grid%high - grid%low)/(2*ns), &
                     tiny(1.0_wp)*1.0e3_wp)
    do
      grid%n = max(1, ceiling((grid%high - grid%low)/grid%width))
      if (product(real(grid%n, wp)) <= real(MOST_CELLS, wp)*ns) exit
      grid%width = 1.3_wp*grid%width
    end do
    call sort_samples(surface, ns, grid)
  end subroutine update_grid

  !> Number of samples in each direction of an element, which depends on its degree.
  pure integer function per_direction(surface, e)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    per_direction = min(maxval(surface%basis(surface%ibasis(e))%degree) + 1, 3)
  end function per_direction

  !> Parameters of sample i of the n*n samples.
  pure function sample_xi(n, i) result(xi)
    integer, intent(in) :: n, i
    real(wp) :: xi(2)

    xi = [2*mod(i - 1, n) + 1, 2*((i - 1)/n) + 1]/real(n, wp) - 1.0_wp
  end function sample_xi

  !> Sort the samples by cells (counting sort).
  subroutine sort_samples(surface, ns, grid)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: ns
    type(grid_t), intent(inout) :: grid
    integer :: e, i, s, n, at, nc

    nc = product(grid%n)
    grid%first(:nc + 2) = 0
    do s = 1, ns
      grid%cell(s) = cell_number(grid, cell_of(grid, grid%sample(:, s)))
      grid%first(grid%cell(s) + 2) = grid%first(grid%cell(s) + 2) + 1
    end do
    grid%first(1:2) = 1
    do i = 3, nc + 2
      grid%first(i) = grid%first(i) + grid%first(i - 1)
    end do
    s = 0
    do e = 1, surface%nelem
      n = per_direction(surface, e)
      do i = 1, n*n
        s = s + 1
        at = grid%first(grid%cell(s) + 1)
        grid%first(grid%cell(s) + 1) = at + 1
        grid%elem(at) = e
        grid%xi(:, at) = sample_xi(n, i)
        grid%x(:, at) = grid%sample(:, s)
      end do
    end do
  end subroutine sort_samples

  !> The cell of a point, or the nearest one if the point is outside the grid.
  pure function cell_of(grid, x) result(at)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    integer :: at(3)

    at = int((max(grid%low, min(grid%high, x)) - grid%low)/grid%width) + 1
    at = min(at, grid%n)
  end function cell_of

  pure integer function cell_number(grid, at)
    type(grid_t), intent(in) :: grid
    integer, intent(in) :: at(3)

    cell_number = at(1) + grid%n(1)*(at(2) - 1 + grid%n(2)*(at(3) - 1))
  end function cell_number

  !> Is a point within `reach` of the box around the surface?
  pure logical function is_near(grid, x, reach)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    real(wp), intent(in) :: reach !! [L]

    is_near = all(x >= grid%low - reach .and. x <= grid%high + reach)
  end function is_near

  !> Find the nearest sample; the element is 0 if the surface is empty or not finite.
  pure subroutine nearest_start(grid, x, elem, xi)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)       !! finite
    integer, intent(out) :: elem
    real(wp), intent(out) :: xi(2)
    real(wp) :: best, wall, from_low(3)
    integer :: at(3), ring, s

    elem = 0
    xi = 0.0_wp
    if (any(grid%n == 0)) return
    at = cell_of(grid, x)
    best = huge(1.0_wp)
    s = 0
    from_low = x - grid%low - (at - 1)*grid%width
    wall = max(0.0_wp, minval(min(from_low, grid%width - from_low)))
    do ring = 0, maxval(grid%n)
      if (ring > 0 .and. s > 0) then ! no sample of the ring is nearer than this
        if (((ring - 1)*grid%width + wall)**2 > best) exit
      end if
      call search_ring(grid, x, at, ring, best, s)
    end do
    if (s == 0) return
    elem = grid%elem(s)
    xi = grid%xi(:, s)
  end subroutine nearest_start

  !> Search the cells that form the surface of a cube around a given cell for the nearest sample.
  pure subroutine search_ring(grid, x, at, ring, best, nearest)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: at(3), ring
    real(wp), intent(inout) :: best      !! square of the distance [L^2]
    integer, intent(inout) :: nearest
    integer :: low(3), high(3), j, k, c

    low = max(at - ring, 1)
    high = min(at + ring, grid%n)
    do k = low(3), high(3)
      do j = low(2), high(2)
        c = cell_number(grid, [0, j, k])
        if (abs(k - at(3)) == ring .or. abs(j - at(2)) == ring) then
          call search_row(grid, x, c + low(1), c + high(1), best, nearest)
        else
          if (at(1) - ring >= 1) call search_row(grid, x, c + low(1), c + low(1), best, nearest)
          if (at(1) + ring > grid%n(1)) cycle
          call search_row(grid, x, c + high(1), c + high(1), best, nearest)
        end if
      end do
    end do
  end subroutine search_ring

  !> Search consecutive cells, whose samples are consecutive too.
  pure subroutine search_row(grid, x, from, to, best, nearest)
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: from, to
    real(wp), intent(inout) :: best
    integer, intent(inout) :: nearest
    real(wp) :: d
    integer :: s

    do s = grid%first(from), grid%first(to + 1) - 1
      d = (grid%x(1, s) - x(1))**2 + (grid%x(2, s) - x(2))**2 + (grid%x(3, s) - x(3))**2
      if (d < best) then
        best = d
        nearest = s
      end if
    end do
  end subroutine search_row

end module projection_search
