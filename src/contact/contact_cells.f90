!> Cells of a surface: its elements, cut along the borders of the elements that they touch.
!!
!! A function of both surfaces has kinks where an element of the other one begins. Gauss points of
!! whole elements integrate it badly: blocks with different meshes then miss the patch test (Puso
!! and Laursen 2004; Farah, Popp and Wall 2015). Here both surfaces are divided into facets that are
!! nearly flat; each facet of the integrated side is clipped, in its own plane, by the facets of the
!! other side that face it, and the pieces are mapped back to the parameters of the element. What
!! lies beyond the border of the other surface belongs to no cell.
!!
!! The points of the cells have reference areas as weights, so that only positions vary while the
!! cells are kept.
module contact_cells
  use base_kinds, only: wp
  use cell_border, only: part_t, find_border, bend_functions, NBEND
  use contact_pair, only: contact_t, surface_t
  use polygon, only: clip, signed_area, integrate_polygon, MOST_CORNERS
  use projection_type, only: foot_t, shape_t
  use quadrature, only: gauss
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: cells_t, facets_t, divide_surface, cut_cells

  !> A facet is divided while its normals differ by more than the angle with this cosine,
  real(wp), parameter :: NEARLY_FLAT = 0.7_wp
  !> or while its edges deviate from straight ones by more than this fraction of their length.
  real(wp), parameter :: NEARLY_STRAIGHT = 0.1_wp
  !> or while its tangents change by more than this fraction from the middle to the corners.
  real(wp), parameter :: NEARLY_EVEN = 0.4_wp
  integer, parameter :: MOST_DIVISIONS = 4     !! of an element, in one direction
  !> Facets face each other up to this cosine of their normals.
  real(wp), parameter :: FACING = -0.1_wp
  real(wp), parameter :: NO_AREA = 1.0e-12_wp  !! of a piece, relative to its facet
  real(wp), parameter :: ON_EDGE = 1.0e-10_wp  !! distance to an edge, relative to its length
  !> Error of the points of a cell where functions of both sides are no polynomials, relative.
  real(wp), parameter :: ACCURACY = 1.0e-10_wp
  real(wp), parameter :: EVEN = 1.0e-8_wp      !! change of tangents that is none
  real(wp), parameter :: MOST_UNEVEN = 0.9_wp
  integer, parameter :: MOST_STEPS = 20        !! of Newton's method
  real(wp), parameter :: NEARLY = 0.9_wp       !! largest fraction of the way to a collapsed edge
  integer, parameter :: USUAL_POINTS = 5       !! of QUADrature
  !> Maps that are no polynomials have a further point in each direction by default, unless they
  !! need more than MANY for an exact result, as those of strongly deformed surfaces do: points
  !! would then cost more than they give.
  integer, parameter :: MANY = 5
  integer, parameter :: MOST_ORDER = 12        !! Gauss points of a piece in one direction
  integer, parameter :: MOST_POINTS = MOST_CORNERS/2*MOST_ORDER**2

  !> Nearly flat quadrilaterals that cover a surface.
  type :: facets_t
    integer :: n = 0
    integer, allocatable :: elem(:)         !! (n)
    real(wp), allocatable :: from(:, :), to(:, :) !! (2, n) ranges of the parameters
    !> (3, 4, n) corners, counter-clockwise about the outward normal [L]
    real(wp), allocatable :: x(:, :, :)
    real(wp), allocatable :: normal(:, :)   !! (3, n) unit normals
    real(wp), allocatable :: low(:, :), high(:, :) !! (3, n) boxes [L]
    !> (n) Relative change of the tangents from the middle to the corners; 0: the map is affine.
    real(wp), allocatable :: uneven(:)
    real(wp) :: size = 0.0_wp               !! of the largest box [L]
    real(wp) :: least = huge(1.0_wp)        !! of the smallest one [L]
    !> Buckets along the longest axis of the surface, for the search.
    integer :: axis = 1
    real(wp) :: span(2) = 0.0_wp            !! range of `low` along the axis [L]
    integer, allocatable :: bucket(:)       !! (n+1) where the facets of each bucket begin
    integer, allocatable :: order(:)        !! (n)
  end type facets_t

  !> Points of the cells of one side.
  type :: cells_t
    integer :: n = 0
    integer, allocatable :: first(:)        !! (nelem+1) where the points of an element begin
    integer, allocatable :: elem(:)         !! (n)
    real(wp), allocatable :: xi(:, :)       !! (2, n)
    real(wp), allocatable :: weight(:)      !! (n) reference area [L^2]
    type(foot_t), allocatable :: foot(:)    !! (n) projection
  end type cells_t

contains

  !> Facets of a surface at its current positions.
  subroutine divide_surface(surface, shape, facets)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(facets_t), intent(out) :: facets
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
                           facets%x(:, :, n), facets%normal(:, n), facets%uneven(n))
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

  !> Corners and normal of the part of an element between two parameters.
  pure subroutine place_facet(surface, shape, e, from, to, x, normal, uneven)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp), intent(in) :: from(2), to(2)
    real(wp), intent(out) :: x(3, 4), normal(3), uneven
    real(wp) :: y(3), a(3, 2), b(3, 3), middle(3, 2), at(2, 4)
    integer :: c

    at = reshape([from, to(1), from(2), to, from(1), to(2)], [2, 4])
    call surface_point(surface, shape, e, 0.5_wp*(from + to), y, middle, b)
    uneven = 0.0_wp
    do c = 1, 4
      call surface_point(surface, shape, e, at(:, c), x(:, c), a, b)
      uneven = max(uneven, change(middle, a))
    end do
    if (is_triangle(surface, e)) uneven = 0.0_wp
    normal = cross(x(:, 3) - x(:, 1), x(:, 4) - x(:, 2))
    normal = normal/max(norm2(normal), tiny(1.0_wp))
  end subroutine place_facet

  !> Does an element have a collapsed edge? If it is flat, its functions are polynomials of the
  !! position.
  pure logical function is_triangle(surface, e)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    is_triangle = .false.
    if (allocated(surface%point)) is_triangle = any(surface%point(:, e))
  end function is_triangle

  !> Change of tangents, in those of the middle.
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

  !> Divisions of an element in each direction that make its parts flat and their edges straight.
  pure integer function divisions(surface, shape, e) result(m)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp) :: x(3), a(3, 2), b(3, 3), n(3, 9), p(3, 9), bend, turn, length, uneven, middle(3, 2)
    integer :: i, j, q
    !> Ends and middles of the edges and of the lines through the middle, among the 3 x 3 points.
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
    if (is_triangle(surface, e)) uneven = 0.0_wp
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
      x = x - dot_product(x, n(:, 5))*n(:, 5) ! within the tangent plane
      bend = max(bend, norm2(x)/length)
    end do
    ! the deviation falls with the square of the divisions, the angle with their number
    m = ceiling(max(sqrt(bend/NEARLY_STRAIGHT), acos(max(-1.0_wp, turn))/acos(NEARLY_FLAT), &
                    uneven/NEARLY_EVEN) - 1.0e-9_wp)
    m = max(1, min(m, MOST_DIVISIONS))
  end function divisions

  !> Cut the elements of side k along the borders of the facets of the other side.
  subroutine cut_cells(contact, k, shape, reference, facets, reach, cells)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)   !! of both sides
    type(shape_t), intent(in) :: reference  !! of side k, before it deformed
    type(facets_t), intent(in) :: facets(2) !! of both sides
    real(wp), intent(in) :: reach           !! [L] facets farther apart do not touch
    type(cells_t), intent(out) :: cells
    real(wp) :: g(MOST_ORDER, MOST_ORDER), w(MOST_ORDER, MOST_ORDER)
    real(wp) :: f(NBEND, MOST_ORDER, MOST_ORDER), df(NBEND, MOST_ORDER, MOST_ORDER)
    real(wp) :: corner(2, MOST_CORNERS), zeta(2, MOST_CORNERS), bend(2, NBEND, MOST_CORNERS)
    real(wp) :: point(2, MOST_POINTS), weight(MOST_POINTS)
    real(wp) :: frame(3, 3), quad(2, 4), x(3), a(3, 2), b(3, 3)
    integer, allocatable :: near(:)
    integer :: tag(MOST_CORNERS), ray(MOST_CORNERS)
    integer :: e, further, order, i, j, least, m, n, nnear, npoint, q
    type(part_t) :: part
    logical :: mapped

    associate (own => contact%side(k), mine => facets(k), theirs => facets(3 - k))
      further = 2*max(0, maxval(contact%ngauss) - USUAL_POINTS)
      least = 1 + max(highest_degree(contact%side(1)), highest_degree(contact%side(2)))
      do n = 1, MOST_ORDER
        call gauss(n, g(:n, n), w(:n, n))
        do q = 1, n
          call bend_functions(g(q, n), f(:, q, n), df(:, q, n))
        end do
      end do
      allocate (near(theirs%n))
      allocate (cells%first(own%nelem + 1))
      call reserve(cells, 16*least**2)
      e = 0
      do i = 1, mine%n
        do while (e < mine%elem(i))
          e = e + 1
          cells%first(e) = cells%n + 1
        end do
        call find_near(mine, i, theirs, reach, near, nnear)
        if (nnear == 0) cycle
        call make_frame(mine%x(:, :, i), mine%normal(:, i), frame)
        quad = matmul(transpose(frame(:, :2)), mine%x(:, :, i) - spread(mine%x(:, 1, i), 2, 4))
        if (.not. signed_area(quad) > 0.0_wp) cycle
        part = part_t(e, mine%from(:, i), mine%to(:, i))
        do j = 1, nnear
          if (dot_product(mine%normal(:, i), theirs%normal(:, near(j))) > FACING) cycle
          call overlap(mine%x(:, 1, i), frame, quad, theirs%x(:, :, near(j)), &
                       contact%depth, reach, m, corner, tag, zeta)
          if (m == 0) cycle
          call split_vertex(quad, m, corner, tag, zeta, ray)
          call map_corners(own, shape(k), e, mine, i, frame, quad, m, ray, corner, mapped)
          if (.not. mapped) cycle
          associate (from => theirs%from(:, near(j)), to => theirs%to(:, near(j)))
            do q = 1, m
              zeta(:, q) = from + zeta(:, q)*(to - from)
            end do
            call find_border(own, shape(k), part, contact%side(3 - k), shape(3 - k), &
                             part_t(theirs%elem(near(j)), from, to), m, tag, corner, zeta, bend)
          end associate
          ! a whole element has the points of QUADrature, a small piece those that it needs
          n = ceiling(maxval(contact%ngauss)*sqrt(0.25_wp*max(0.0_wp, signed_area(corner(:, :m)))))
          x(1) = maxval((maxval(corner(:, :m), 2) - minval(corner(:, :m), 2))/(part%to - part%from))
          x(2) = x(1)*maxval(mine%high(:, i) - mine%low(:, i)) &
                 /maxval(theirs%high(:, near(j)) - theirs%low(:, near(j)))
          x(3) = max(mine%uneven(i)*min(1.0_wp, x(1)), theirs%uneven(near(j))*min(1.0_wp, x(2)))
          order = further_order(x(3))
          order = min(order, merge(1, 0, order <= MANY) + further)
          n = min(max(n, least + order), MOST_ORDER)
          call integrate_polygon(corner(:, :m), bend(:, :, :m), g(:n, n), w(:n, n), f(:, :n, n), &
                                 df(:, :n, n), npoint, point, weight)
          call reserve(cells, npoint)
          do q = 1, npoint
            if (.not. abs(weight(q)) > 0.0_wp) cycle
            cells%n = cells%n + 1
            cells%elem(cells%n) = e
            cells%xi(:, cells%n) = max(-1.0_wp, min(1.0_wp, point(:, q)))
            call surface_point(own, reference, e, cells%xi(:, cells%n), x, a, b)
            cells%weight(cells%n) = weight(q)*norm2(cross(a(:, 1), a(:, 2)))
            cells%foot(cells%n)%elem = theirs%elem(near(j))
            cells%foot(cells%n)%xi = 0.5_wp*(theirs%from(:, near(j)) + theirs%to(:, near(j)))
          end do
        end do
      end do
      cells%first(e + 1:) = cells%n + 1
    end associate
  end subroutine cut_cells

  !> Gauss points beyond those of polynomials where tangents change by the fraction r over a cell:
  !! the error of n points for 1/(1 + r t) falls with rho^(-2n).
  pure integer function further_order(r) result(n)
    real(wp), intent(in) :: r
    real(wp) :: q

    n = 0
    if (r < EVEN) return
    q = 1.0_wp/min(r, MOST_UNEVEN)
    n = ceiling(-0.5_wp*log(ACCURACY)/log(q + sqrt(q*q - 1.0_wp)))
  end function further_order

  pure integer function highest_degree(surface) result(p)
    type(surface_t), intent(in) :: surface
    integer :: i

    p = 1
    do i = 1, size(surface%basis)
      p = max(p, maxval(surface%basis(i)%degree))
    end do
  end function highest_degree

  !> Make room for further points.
  subroutine reserve(cells, more)
    type(cells_t), intent(inout) :: cells
    integer, intent(in) :: more
    type(cells_t) :: big
    integer :: n

    if (allocated(cells%elem)) then
      if (cells%n + more <= size(cells%elem)) return
    end if
    n = 2*(cells%n + more)
    allocate (big%elem(n), big%xi(2, n), big%weight(n), big%foot(n))
    if (allocated(cells%elem)) then
      big%elem(:cells%n) = cells%elem(:cells%n)
      big%xi(:, :cells%n) = cells%xi(:, :cells%n)
      big%weight(:cells%n) = cells%weight(:cells%n)
      big%foot(:cells%n) = cells%foot(:cells%n)
    end if
    call move_alloc(big%elem, cells%elem)
    call move_alloc(big%xi, cells%xi)
    call move_alloc(big%weight, cells%weight)
    call move_alloc(big%foot, cells%foot)
  end subroutine reserve

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
    do i = n, 1, -1 ! bucket(b + 1) moves from the end of bucket b to its beginning
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

  !> Facets of the other side whose boxes are no farther than `reach` from that of facet i.
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

  !> Orthonormal frame of a facet: two directions of its plane, and its normal.
  pure subroutine make_frame(x, normal, frame)
    real(wp), intent(in) :: x(3, 4), normal(3)
    real(wp), intent(out) :: frame(3, 3)
    real(wp) :: t(3)

    t = x(:, 3) - x(:, 1)
    t = t - dot_product(t, normal)*normal
    frame(:, 1) = t/max(norm2(t), tiny(1.0_wp))
    frame(:, 2) = cross(normal, frame(:, 1))
    frame(:, 3) = normal
  end subroutine make_frame

  !> Overlap of a facet with one of the other side, seen along the normal of the first.
  pure subroutine overlap(origin, frame, quad, x, deep, high, m, corner, tag, zeta)
    real(wp), intent(in) :: origin(3), frame(3, 3)
    real(wp), intent(in) :: quad(2, 4)    !! the facet in its plane
    real(wp), intent(in) :: x(3, 4)       !! the other facet
    real(wp), intent(in) :: deep, high    !! [L] distances at which they do not touch
    integer, intent(out) :: m             !! corners; 0: no overlap
    real(wp), intent(out) :: corner(2, MOST_CORNERS)
    !> The edge after each corner is edge -tag of the facet, or edge tag of the other one.
    integer, intent(out) :: tag(MOST_CORNERS)
    real(wp), intent(out) :: zeta(2, MOST_CORNERS) !! corners on edges of the other facet: on [0,1]
    real(wp) :: y(3), seen(2, 4), along(2)
    real(wp) :: height(4)
    integer :: c, i, j
    !> Corners of the unit square.
    real(wp), parameter :: UNIT(2, 4) = reshape(real([0, 0, 1, 0, 1, 1, 0, 1], wp), [2, 4])

    do i = 1, 4
      y = x(:, i) - origin
      seen(:, i) = [dot_product(y, frame(:, 1)), dot_product(y, frame(:, 2))]
      height(i) = dot_product(y, frame(:, 3))
    end do
    m = 0
    if (all(height > high) .or. all(height < -deep)) return
    corner(:, :4) = seen(:, 4:1:-1)       ! seen from the facet, the other one turns clockwise
    tag(:4) = [3, 2, 1, 4]
    if (.not. signed_area(corner(:, :4)) > 0.0_wp) return
    m = 4
    call clip(quad, m, corner, tag)
    if (m == 0) return
    if (signed_area(corner(:, :m)) < NO_AREA*signed_area(quad)) m = 0
    zeta = 0.5_wp
    do c = 1, m
      i = tag(mod(c + m - 2, m) + 1)
      if (i < 0) i = tag(c)
      if (i < 0) cycle
      j = mod(i, 4) + 1
      along = seen(:, j) - seen(:, i)
      ! at a corner of the other facet edge i begins
      if ((tag(c) > 0 .and. tag(c) /= i) .or. .not. any(abs(along) > 0.0_wp)) then
        zeta(:, c) = UNIT(:, i)
      else
        zeta(:, c) = UNIT(:, i) + dot_product(corner(:, c) - seen(:, i), along) &
                     /dot_product(along, along)*(UNIT(:, j) - UNIT(:, i))
      end if
      zeta(:, c) = max(0.0_wp, min(1.0_wp, zeta(:, c)))
    end do
  end subroutine overlap

  !> The edge of a facet that is collapsed to a point; 0: none.
  pure integer function collapsed_edge(quad) result(k)
    real(wp), intent(in) :: quad(2, 4)

    do k = 4, 1, -1
      if (norm2(quad(:, mod(k, 4) + 1) - quad(:, k)) <= ON_EDGE*maxval(abs(quad))) return
    end do
  end function collapsed_edge

  !> A corner at a collapsed edge becomes two, one for each edge of the cell that ends there: lines
  !! to it are lines of one parameter. ray(c) is the corner that has the parameter of corner c; 0: c
  !! is not such a corner.
  pure subroutine split_vertex(quad, m, corner, tag, zeta, ray)
    real(wp), intent(in) :: quad(2, 4)
    integer, intent(inout) :: m, tag(MOST_CORNERS)
    real(wp), intent(inout) :: corner(2, MOST_CORNERS), zeta(2, MOST_CORNERS)
    integer, intent(out) :: ray(MOST_CORNERS)
    integer :: c, d, k

    ray = 0
    k = collapsed_edge(quad)
    if (k == 0) return
    d = 0
    do c = m, 1, -1                      ! corners there are neighbours: the last one remains
      if (norm2(corner(:, c) - quad(:, k)) > ON_EDGE*maxval(abs(quad))) cycle
      if (d > 0) then
        corner(:, c:m - 1) = corner(:, c + 1:m)
        zeta(:, c:m - 1) = zeta(:, c + 1:m)
        tag(c:m - 1) = tag(c + 1:m)
        m = m - 1
        if (d > m + 1) d = m + 1
        d = d - 1
      else
        d = c
      end if
    end do
    if (d == 0 .or. m < 3 .or. m == MOST_CORNERS) return
    corner(:, d + 1:m + 1) = corner(:, d:m)
    zeta(:, d + 1:m + 1) = zeta(:, d:m)
    tag(d + 1:m + 1) = tag(d:m)
    m = m + 1
    tag(d) = -k
    ray(d) = mod(d + m - 2, m) + 1
    ray(d + 1) = mod(d + 1, m) + 1
  end subroutine split_vertex

  !> From the plane of a facet to the parameters of its element. Corners on an edge of the facet
  !! stay on it.
  pure subroutine map_corners(own, shape, e, facets, i, frame, quad, m, ray, corner, mapped)
    type(surface_t), intent(in) :: own
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e, i
    type(facets_t), intent(in) :: facets
    real(wp), intent(in) :: frame(3, 3), quad(2, 4)
    integer, intent(in) :: m, ray(MOST_CORNERS)  !! see split_vertex
    real(wp), intent(inout) :: corner(2, MOST_CORNERS)
    logical, intent(out) :: mapped
    real(wp) :: edge(2), xi(2), x(3), a(3, 2), b(3, 3), r(2), j(2, 2), d(2), det
    real(wp) :: bound(4)
    integer :: c, flat, k, step

    mapped = .true.
    flat = collapsed_edge(quad)
    bound = [facets%from(2, i), facets%to(1, i), facets%to(2, i), facets%from(1, i)]
    do c = 1, m
      if (ray(c) > 0) cycle
      xi = 0.5_wp*(facets%from(:, i) + facets%to(:, i))
      do step = 1, MOST_STEPS
        call surface_point(own, shape, e, xi, x, a, b)
        x = x - facets%x(:, 1, i)
        r = corner(:, c) - [dot_product(x, frame(:, 1)), dot_product(x, frame(:, 2))]
        j = matmul(transpose(frame(:, :2)), a)
        det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
        if (.not. det > 0.0_wp) exit
        d = [j(2, 2)*r(1) - j(1, 2)*r(2), j(1, 1)*r(2) - j(2, 1)*r(1)]/det
        d = max(-1.0_wp, min(1.0_wp, d))
        if (flat > 0) then ! a tangent vanishes at the collapsed edge: not beyond it
          r(1) = NEARLY*(bound(flat) - xi(merge(2, 1, mod(flat, 2) == 1)))
          det = d(merge(2, 1, mod(flat, 2) == 1))/r(1)
          if (det > 1.0_wp) d = d/det
          det = 1.0_wp
        end if
        xi = max(facets%from(:, i) - 0.5_wp, min(facets%to(:, i) + 0.5_wp, xi + d))
        if (maxval(abs(d)) < 1.0e-13_wp) exit
      end do
      if (.not. det > 0.0_wp) then
        mapped = .false.
        return
      end if
      xi = max(facets%from(:, i), min(facets%to(:, i), xi))
      do k = 1, 4
        edge = quad(:, mod(k, 4) + 1) - quad(:, k)
        r = corner(:, c) - quad(:, k)
        if (.not. abs(edge(1)*r(2) - edge(2)*r(1)) < ON_EDGE*dot_product(edge, edge)) cycle
        xi(merge(2, 1, mod(k, 2) == 1)) = bound(k)
      end do
      corner(:, c) = xi
    end do
    do c = 1, m
      if (ray(c) == 0) cycle
      corner(:, c) = corner(:, ray(c))
      corner(merge(2, 1, mod(flat, 2) == 1), c) = bound(flat)
    end do
    mapped = signed_area(corner(:, :m)) > 0.0_wp
  end subroutine map_corners

end module contact_cells
