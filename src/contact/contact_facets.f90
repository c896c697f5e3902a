!> Facets of a surface: its elements, divided until the parts are nearly flat. A search finds nearby
!! facets of another surface.
module contact_facets
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use projection_type, only: shape_t
  use surface_chart, only: collapsed_side, to_chart, chart_point
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: facets_t, divide_surface, find_near

  !> Surfaces face each other if the cosine of the angle between their normals is below this.
  real(wp), parameter, public :: FACING = -0.1_wp
  !> The number of facets of an element is chosen so that three limits hold approximately. The
  !! normals of a facet differ from that in its middle by at most the angle with this cosine.
  real(wp), parameter :: NEARLY_FLAT = 0.7_wp
  !> The edges of a facet deviate from straight lines by at most this fraction of their length.
  real(wp), parameter :: NEARLY_STRAIGHT = 0.1_wp
  !> The tangents of a facet change by at most this fraction from the middle to the corners.
  real(wp), parameter :: NEARLY_EVEN = 0.4_wp
  integer, parameter :: MOST_DIVISIONS = 4 !! largest number of parts of an element in one direction

  !> Nearly flat quadrilaterals that cover a surface.
  type :: facets_t
    integer :: n = 0
    integer, allocatable :: elem(:)         !! (n)
    real(wp), allocatable :: from(:, :), to(:, :) !! (2, n) first and last parameters
    !> (3, 4, n) corners, counter-clockwise about the outward normal [L]
    real(wp), allocatable :: x(:, :, :)
    real(wp), allocatable :: normal(:, :)   !! (3, n) unit normals
    real(wp), allocatable :: low(:, :), high(:, :) !! (3, n) bounding boxes [L]
    !> (n) Relative change of the tangents of the chart from the middle to the corners; 0: affine.
    real(wp), allocatable :: uneven(:)
    real(wp) :: size = 0.0_wp               !! size of the largest box [L]
    real(wp) :: least = huge(1.0_wp)        !! size of the smallest box [L]
    real(wp) :: bulge = 0.0_wp              !! largest distance of the surface from its facets [L]
    !> Buckets along the longest axis of the surface, for the search.
    integer :: axis = 1
    real(wp) :: span(2) = 0.0_wp            !! range of `low` along the axis [L]
    integer, allocatable :: bucket(:)       !! (n+1) first position of a bucket in `order`
    integer, allocatable :: order(:)        !! (n) facets, sorted by bucket
  end type facets_t

contains

  !> Divide a surface, at the positions of `shape`, into facets.
  subroutine divide_surface(surface, shape, facets)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(facets_t), intent(out) :: facets
    real(wp) :: bulge
    integer :: e, i, j, m, n, total
    integer :: division(surface%nelem)

    do e = 1, surface%nelem
      division(e) = divisions(surface, shape, e)
    end do
    total = sum(division**2)
    allocate (facets%elem(total), facets%from(2, total), facets%to(2, total))
    allocate (facets%x(3, 4, total), facets%normal(3, total), facets%low(3, total), &
              facets%high(3, total), facets%uneven(total))
    n = 0
    do e = 1, surface%nelem
      m = division(e)
      do j = 1, m
        do i = 1, m
          n = n + 1
          facets%elem(n) = e
          facets%from(:, n) = real(2*[i - 1, j - 1], wp)/m - 1.0_wp
          facets%to(:, n) = real(2*[i, j], wp)/m - 1.0_wp
          call place_facet(surface, shape, e, facets%from(:, n), facets%to(:, n), &
                           facets%x(:, :, n), facets%normal(:, n), facets%uneven(n), bulge)
          facets%bulge = max(facets%bulge, bulge)
          facets%low(:, n) = minval(facets%x(:, :, n), 2)
          facets%high(:, n) = maxval(facets%x(:, :, n), 2)
          facets%size = max(facets%size, maxval(facets%high(:, n) - facets%low(:, n)))
          facets%least = min(facets%least, maxval(facets%high(:, n) - facets%low(:, n)))
        end do
      end do
    end do
    facets%n = n
    call sort_facets(facets)
  end subroutine divide_surface

  !> Corners, normal and unevenness of the part of an element between the parameters `from` and
  !! `to`, and the distance of its middle from the plane of the facet.
  pure subroutine place_facet(surface, shape, e, from, to, x, normal, uneven, bulge)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp), intent(in) :: from(2), to(2)
    real(wp), intent(out) :: x(3, 4), normal(3), uneven, bulge
    real(wp) :: y(3), a(3, 2), middle(3, 2), at(2, 4)
    integer :: c, flat

    flat = collapsed_side(surface, e)
    at = reshape([from, to(1), from(2), to, from(1), to(2)], [2, 4])
    call chart_point(surface, shape, e, flat, to_chart(flat, 0.5_wp*(from + to)), y, middle)
    uneven = 0.0_wp
    do c = 1, 4
      call chart_point(surface, shape, e, flat, to_chart(flat, at(:, c)), x(:, c), a)
      uneven = max(uneven, change(middle, a))
    end do
    normal = cross(x(:, 3) - x(:, 1), x(:, 4) - x(:, 2))
    normal = normal/max(norm2(normal), tiny(1.0_wp))
    bulge = abs(dot_product(y - sum(x, 2)/4, normal))
  end subroutine place_facet

  !> Change of the tangents relative to those in the middle, as components along the tangents in the
  !! middle.
  pure real(wp) function change(middle, a) result(r)
    real(wp), intent(in) :: middle(3, 2), a(3, 2)
    real(wp) :: m(2, 2), d(2, 2), det

    m = matmul(transpose(middle), middle)
    d = matmul(transpose(middle), a - middle)
    det = m(1, 1)*m(2, 2) - m(1, 2)**2
    r = huge(1.0_wp)
    if (.not. det > tiny(1.0_wp)) return
    r = max(sum(abs(m(2, 2)*d(1, :) - m(1, 2)*d(2, :))), &
            sum(abs(m(1, 1)*d(2, :) - m(1, 2)*d(1, :))))/det
  end function change

  !> Smallest number of divisions in each direction, up to MOST_DIVISIONS, that makes the parts of
  !! an element nearly flat, their edges nearly straight and their tangents nearly constant.
  pure integer function divisions(surface, shape, e) result(m)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp) :: x(3), a(3, 2), b(3, 3), n(3, 9), p(3, 9), bend, turn, length, uneven, middle(3, 2)
    integer :: i, j, q
    !> Indices, among the 3 x 3 points, of the beginning, the middle and the end of each edge and of
    !! each line through the middle.
    integer, parameter :: LINES(3, 6) = reshape([1, 2, 3, 4, 5, 6, 7, 8, 9, 1, 4, 7, 2, 5, 8, &
                                                 3, 6, 9], [3, 6])

    call surface_point(surface, shape, e, [0.0_wp, 0.0_wp], x, middle, b)
    uneven = 0.0_wp
    do j = -1, 1
      do i = -1, 1
        q = 5 + i + 3*j
        call surface_point(surface, shape, e, real([i, j], wp), x, a, b)
        if (abs(i*j) == 1) uneven = max(uneven, min(change(middle, a), real(MOST_DIVISIONS, wp)))
        p(:, q) = x
        n(:, q) = cross(a(:, 1), a(:, 2))
        n(:, q) = n(:, q)/max(norm2(n(:, q)), tiny(1.0_wp))
      end do
    end do
    if (collapsed_side(surface, e) > 0) uneven = 0.0_wp ! its parameters are uneven, not its shape
    turn = 1.0_wp
    bend = 0.0_wp
    do q = 1, 9
      if (norm2(n(:, q)) > 0.5_wp) turn = min(turn, dot_product(n(:, 5), n(:, q)))
    end do
    do q = 1, 6
      length = norm2(p(:, LINES(3, q)) - p(:, LINES(1, q)))
      if (.not. length > 0.0_wp) cycle
      x = p(:, LINES(2, q)) - 0.5_wp*(p(:, LINES(1, q)) + p(:, LINES(3, q)))
      a(:, 1) = (p(:, LINES(3, q)) - p(:, LINES(1, q)))/length
      x = x - dot_product(x, a(:, 1))*a(:, 1)
      x = x - dot_product(x, n(:, 5))*n(:, 5) ! component in the tangent plane
      bend = max(bend, norm2(x)/length)
    end do
    ! the deviation is inversely proportional to the square of m, the angle to m itself
    m = ceiling(max(sqrt(bend/NEARLY_STRAIGHT), acos(max(-1.0_wp, turn))/acos(NEARLY_FLAT), &
                    uneven/NEARLY_EVEN) - 1.0e-9_wp)
    m = max(1, min(m, MOST_DIVISIONS))
  end function divisions

  !> Sort facets into buckets along the longest axis of their surface.
  subroutine sort_facets(facets)
    type(facets_t), intent(inout) :: facets
    integer :: at(facets%n), b, i, n

    n = facets%n
    facets%axis = maxloc(maxval(facets%low, 2) - minval(facets%low, 2), 1)
    facets%span = [minval(facets%low(facets%axis, :)), maxval(facets%low(facets%axis, :))]
    allocate (facets%bucket(n + 1), facets%order(n))
    facets%bucket = 0
    do i = 1, n
      at(i) = bucket_of(facets, facets%low(facets%axis, i))
      facets%bucket(at(i) + 1) = facets%bucket(at(i) + 1) + 1
    end do
    facets%bucket(1) = 1
    do b = 2, n + 1
      facets%bucket(b) = facets%bucket(b) + facets%bucket(b - 1)
    end do
    do i = n, 1, -1 ! bucket(b + 1) is counted down from the end of bucket b to its beginning
      facets%bucket(at(i) + 1) = facets%bucket(at(i) + 1) - 1
      facets%order(facets%bucket(at(i) + 1)) = i
    end do
    facets%bucket(:n) = facets%bucket(2:)
    facets%bucket(n + 1) = n + 1
  end subroutine sort_facets

  pure integer function bucket_of(facets, x) result(b)
    type(facets_t), intent(in) :: facets
    real(wp), intent(in) :: x
    real(wp) :: width

    b = 1
    width = facets%span(2) - facets%span(1)
    if (.not. width > 0.0_wp) return
    b = 1 + int(facets%n*min(1.0_wp, max(0.0_wp, (x - facets%span(1))/width)))
    b = min(b, facets%n)
  end function bucket_of

  !> Facets of the other side whose boxes are no farther than `reach` from the box of facet i.
  pure subroutine find_near(mine, i, theirs, reach, near, nnear)
    type(facets_t), intent(in) :: mine, theirs
    integer, intent(in) :: i
    real(wp), intent(in) :: reach
    integer, intent(inout) :: near(:)
    integer, intent(out) :: nnear
    integer :: b, from, j, to

    from = bucket_of(theirs, mine%low(theirs%axis, i) - reach - theirs%size)
    to = bucket_of(theirs, mine%high(theirs%axis, i) + reach)
    nnear = 0
    do b = theirs%bucket(from), theirs%bucket(to + 1) - 1
      j = theirs%order(b)
      if (any(theirs%low(:, j) > mine%high(:, i) + reach) .or. &
          any(theirs%high(:, j) < mine%low(:, i) - reach)) cycle
      nnear = nnear + 1
      near(nnear) = j
    end do
  end subroutine find_near

end module contact_facets
