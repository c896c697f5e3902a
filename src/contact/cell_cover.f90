!> Facets that lie behind others: decides which points of a facet face another part of the other
!! surface that is nearer.
!!
!! A large facet can face several layers of the other surface, one behind the other, such as both
!! legs of a clip or the sheets of a stack. Each layer gives cells (contact_cells). Only the cells
!! of the nearest layer matter: a point that faces a layer behind it would be projected onto the
!! nearest layer and be counted twice, or enter the mean gaps of control points with the gap of the
!! layer behind.
module cell_cover
  use base_kinds, only: wp
  use base_sort, only: sort_index
  use contact_facets, only: facets_t
  implicit none
  private
  public :: view_t, find_covers, is_hidden

  real(wp), parameter :: ON_EDGE = 1.0e-10_wp !! distance to an edge, relative to its length

  !> Facets of the other side, as seen along the normal of a facet of this side.
  type :: view_t
    integer :: n = 0                         !! facets in view; 0: not set yet
    real(wp), allocatable :: seen(:, :, :)   !! (2, 4, n) corners in the plane of the facet [L]
    real(wp), allocatable :: low(:, :), high(:, :) !! (2, n) bounds of the corners [L]
    real(wp) :: widest = 0.0_wp              !! largest high(1, :) - low(1, :) [L]
    integer, allocatable :: order(:)         !! (n) low(1, order) is in ascending order
    real(wp), allocatable :: middle(:, :)    !! (3, n) mean of the corners; 3: the height [L]
    real(wp), allocatable :: slope(:, :)     !! (2, n) slope of the height
    real(wp), allocatable :: nearest(:), farthest(:) !! (n) |height| of the corners [L]
  end type view_t

contains

  !> Find the facets that may cover a part of facet j of a view. If all of facet j lies within
  !! `depth`, there are none.
  subroutine find_covers(view, origin, frame, theirs, near, j, depth, cover, ncover)
    type(view_t), intent(inout) :: view
    real(wp), intent(in) :: origin(3), frame(3, 3) !! plane and normal of the facet of this side
    type(facets_t), intent(in) :: theirs
    integer, intent(in) :: near(:)           !! the facets of the other side that face it
    integer, intent(in) :: j                 !! position in `near`
    real(wp), intent(in) :: depth            !! [L]
    integer, intent(inout) :: cover(:)       !! positions in `near`
    integer, intent(out) :: ncover
    real(wp) :: height(4)
    integer :: i, k

    ncover = 0
    do i = 1, 4
      height(i) = dot_product(frame(:, 3), theirs%x(:, i, near(j)) - origin)
    end do
    if (.not. any(abs(height) > depth)) return
    if (view%n == 0) call look(origin, frame, theirs, near, view)
    do k = first_to_reach(view, view%low(1, j)), view%n
      i = view%order(k)
      if (.not. view%low(1, i) < view%high(1, j)) exit
      if (i == j .or. .not. view%nearest(i) < view%farthest(j)) cycle
      if (.not. all(view%low(:, i) < view%high(:, j) .and. view%low(:, j) < view%high(:, i))) cycle
      if (are_apart(view%seen(:, :, i), view%seen(:, :, j))) cycle
      if (are_apart(view%seen(:, :, j), view%seen(:, :, i))) cycle
      ncover = ncover + 1
      cover(ncover) = i
    end do
  end subroutine find_covers

  !> First position in `order` from which on facets may extend beyond x in direction 1.
  pure integer function first_to_reach(view, x) result(low)
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: x                !! [L]
    integer :: high, middle

    low = 1
    high = view%n + 1
    do while (low < high)
      middle = low + (high - low)/2
      if (view%low(1, view%order(middle)) + view%widest > x) then
        high = middle
      else
        low = middle + 1
      end if
    end do
  end function first_to_reach

  !> Set the view.
  pure subroutine look(origin, frame, theirs, near, view)
    real(wp), intent(in) :: origin(3), frame(3, 3)
    type(facets_t), intent(in) :: theirs
    integer, intent(in) :: near(:)
    type(view_t), intent(inout) :: view
    real(wp) :: y(3, 4), normal(3)
    integer :: i, j, n

    n = size(near)
    if (allocated(view%seen)) then
      if (size(view%seen, 3) < n) deallocate (view%seen, view%low, view%high, view%order, &
                                              view%middle, view%slope, view%nearest, view%farthest)
    end if
    if (.not. allocated(view%seen)) then
      allocate (view%seen(2, 4, n), view%low(2, n), view%high(2, n), view%order(n), &
                view%middle(3, n), view%slope(2, n), view%nearest(n), view%farthest(n))
    end if
    view%n = n
    do j = 1, n
      do i = 1, 4
        y(:, i) = matmul(theirs%x(:, i, near(j)) - origin, frame)
      end do
      normal = matmul(theirs%normal(:, near(j)), frame)
      view%seen(:, :, j) = y(:2, :)
      view%low(:, j) = minval(y(:2, :), 2)
      view%high(:, j) = maxval(y(:2, :), 2)
      view%middle(:, j) = 0.25_wp*sum(y, 2)
      view%slope(:, j) = -normal(:2)/normal(3) ! the facets face each other, so normal(3) < 0
      view%nearest(j) = minval(abs(y(3, :)))
      if (minval(y(3, :)) < 0.0_wp .and. maxval(y(3, :)) > 0.0_wp) view%nearest(j) = 0.0_wp
      view%farthest(j) = maxval(abs(y(3, :)))
    end do
    view%widest = maxval(view%high(1, :n) - view%low(1, :n))
    call sort_index(view%low(1, :n), view%order(:n))
  end subroutine look

  !> Does one of the edges of quadrilateral p separate it from q? Both are clockwise.
  pure logical function are_apart(p, q) result(apart)
    real(wp), intent(in) :: p(2, 4), q(2, 4)
    integer :: c, i

    do i = 1, 4
      apart = any(abs(p(:, mod(i, 4) + 1) - p(:, i)) > 0.0_wp)
      do c = 1, 4
        if (.not. apart) exit
        apart = outside(p, i, q(:, c)) > -ON_EDGE
      end do
      if (apart) return
    end do
  end function are_apart

  !> Signed distance of x from the line of edge i of a clockwise quadrilateral, relative to the
  !! length of this edge, positive outside; 0 if the edge has no length.
  pure real(wp) function outside(quad, i, x) result(d)
    real(wp), intent(in) :: quad(2, 4), x(2)
    integer, intent(in) :: i
    real(wp) :: edge(2), r(2)

    edge = quad(:, mod(i, 4) + 1) - quad(:, i)
    r = x - quad(:, i)
    d = (edge(1)*r(2) - edge(2)*r(1))/max(dot_product(edge, edge), tiny(1.0_wp))
  end function outside

  !> Is the facet j that a point faces farther away than `depth`, and does the point also face a
  !! nearer facet? The point must not lie deeper than `depth` below the nearer facet.
  pure logical function is_hidden(view, j, cover, y, depth) result(hidden)
    type(view_t), intent(in) :: view
    integer, intent(in) :: j
    integer, intent(in) :: cover(:)          !! see find_covers
    real(wp), intent(in) :: y(3)             !! position in the frame of the view [L]
    real(wp), intent(in) :: depth            !! [L]
    real(wp) :: far, height
    integer :: c, i

    hidden = .false.
    far = abs(height_at(view, j, y))
    if (.not. far > depth) return
    do c = 1, size(cover)
      height = height_at(view, cover(c), y)
      if (height < -depth .or. .not. abs(height) < far) cycle
      hidden = .true.
      do i = 1, 4
        if (outside(view%seen(:, :, cover(c)), i, y(:2)) > ON_EDGE) hidden = .false.
      end do
      if (hidden) return
    end do
  end function is_hidden

  !> Height of facet j above the point y [L].
  pure real(wp) function height_at(view, j, y) result(height)
    type(view_t), intent(in) :: view
    integer, intent(in) :: j
    real(wp), intent(in) :: y(3)

    height = view%middle(3, j) - y(3) + dot_product(view%slope(:, j), y(:2) - view%middle(:2, j))
  end function height_at

end module cell_cover
