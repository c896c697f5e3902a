!> Cells of a surface: its elements, cut along the borders of the elements of the other surface.
!!
!! An integrand that depends on both surfaces has kinks at the borders of the elements of the other
!! surface. Gauss points of whole elements integrate it badly: blocks with different meshes then
!! fail the patch test (Puso and Laursen 2004; Farah, Popp and Wall 2015). Here both surfaces are
!! divided into facets that are nearly flat (contact_facets). Each facet of the integrated side is
!! clipped, in its own plane, by the facets of the other side that face it. The pieces are mapped
!! back to the chart of the element (surface_chart), whose coordinates are the parameters or, on a
!! triangle, coordinates of the triangle. Parts of a facet beyond the border of the other surface
!! belong to no cell. Where a facet faces several layers of the other side, points that face a layer
!! farther away than DEPTh behind a nearer one are left out (cell_cover).
!!
!! The points of the cells have reference areas as weights, so that only the positions vary as long
!! as the cells are kept.
module contact_cells
  use base_kinds, only: wp
  use base_threads, only: thread_count
  use cell_border, only: part_t, find_border, bend_functions, NBEND
  use cell_cover, only: view_t, find_covers, is_hidden
  use contact_facets, only: facets_t, find_near, FACING
  use contact_pair, only: contact_t, surface_t
  use polygon, only: clip, signed_area, integrate_polygon, MOST_CORNERS
  use projection_type, only: foot_t, shape_t
  use quadrature, only: gauss
  use self_contact, only: may_touch
  use surface_chart, only: collapsed_side, to_chart, from_chart, chart_point
  use tensor, only: cross
  implicit none
  private
  public :: cells_t, cut_cells

  real(wp), parameter :: NO_AREA = 1.0e-12_wp  !! negligible area of a piece, relative to its facet
  real(wp), parameter :: ON_EDGE = 1.0e-10_wp  !! distance to an edge, relative to its length
  real(wp), parameter :: ROUNDING = 1.0e-9_wp  !! tolerance for rounding up a number of points
  !> Permitted relative error of the integration over a cell where the functions of a side are not
  !! polynomials.
  real(wp), parameter :: ACCURACY = 1.0e-10_wp
  real(wp), parameter :: EVEN = 1.0e-8_wp !! a smaller change of the tangents is due to rounding
  real(wp), parameter :: MOST_UNEVEN = 0.9_wp !! a larger change is treated like this one
  integer, parameter :: MOST_STEPS = 20        !! largest number of Newton steps
  integer, parameter :: USUAL_POINTS = 5       !! default of QUADrature
  !> By default, a piece whose map is not a polynomial has one more point in each direction. If it
  !! needed more than MANY further points for ACCURACY, as on strongly deformed surfaces, it has
  !! none, because they would cost more than the accuracy is worth.
  integer, parameter :: MANY = 5
  !> Most Gauss points of a piece in one direction, unless QUADrature gives more.
  integer, parameter :: USUAL_MOST = 12

  !> Gauss points of every order, and the functions that bend the edges of cells, evaluated at these
  !! points.
  type :: rule_t
    integer :: most = 0 !! most points in one direction
    real(wp), allocatable :: g(:, :), w(:, :)         !! (:n, n) rule of order n; (most, most)
    real(wp), allocatable :: f(:, :, :), df(:, :, :)  !! (NBEND, most, most)
    integer :: least = 1 !! points in one direction for polynomials of both surfaces
    integer :: further = 0 !! further points that QUADrature permits, in one direction
    integer :: whole = 1 !! points of a whole element in one direction
  end type rule_t

  !> Points of cells.
  type :: points_t
    integer :: n = 0
    integer, allocatable :: elem(:)         !! (n)
    real(wp), allocatable :: xi(:, :)       !! (2, n)
    real(wp), allocatable :: weight(:)      !! (n) reference area [L^2]
    type(foot_t), allocatable :: foot(:)    !! (n) projection
    !> Element of the other side whose facet a point faces, and the parameters of the middle of this
    !! facet. The first projection of the point starts there.
    integer, allocatable :: faced(:)        !! (n)
    real(wp), allocatable :: faced_xi(:, :) !! (2, n)
  end type points_t

  !> Points of the cells of one side, in the order of its elements.
  type, extends(points_t) :: cells_t
    type(rule_t) :: rule
    integer, allocatable :: first(:)        !! (nelem+1) first point of each element
  end type cells_t

contains

  !> Cut the elements of side k along the borders of the facets of the other side. Each thread cuts
  !! some facets; the points are listed in the order of the facets.
  subroutine cut_cells(contact, k, shape, reference, facets, reach, cells)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)   !! shapes of both sides
    type(shape_t), intent(in) :: reference  !! shape of side k before it deformed
    type(facets_t), intent(in) :: facets(2) !! facets of both sides
    real(wp), intent(in) :: reach           !! facets farther apart than this do not touch [L]
    type(cells_t), intent(inout) :: cells   !! replaces the earlier cells
    integer, parameter :: SHARES = 8        !! parts of the work of a thread, for an even load
    type(points_t), allocatable :: share(:)
    integer :: e, i, n, nshare

    if (.not. allocated(cells%first)) then
      allocate (cells%first(contact%side(k)%nelem + 1))
      call find_rule(contact, cells%rule)
    end if
    nshare = 1
    if (thread_count() > 1) nshare = max(1, min(facets(k)%n, SHARES*thread_count()))
    allocate (share(nshare))
    if (nshare == 1) call move_points(cells%points_t, share(1)) ! its memory is used again
    !$omp parallel do schedule(dynamic) if (nshare > 1)
    do i = 1, nshare
      call cut_facets(contact, k, shape, reference, facets, reach, cells%rule, &
                      facets(k)%n*(i - 1)/nshare + 1, facets(k)%n*i/nshare, share(i))
    end do
    !$omp end parallel do
    if (nshare == 1) then
      call move_points(share(1), cells%points_t)
    else
      n = sum(share%n)
      cells%n = 0
      call reserve(cells%points_t, n)
      do i = 1, nshare
        call append_points(share(i), cells%points_t)
      end do
    end if
    n = 1
    do e = 1, contact%side(k)%nelem
      cells%first(e) = n
      do while (n <= cells%n)
        if (cells%elem(n) /= e) exit
        n = n + 1
      end do
    end do
    cells%first(e) = n
  end subroutine cut_cells

  !> Cut the facets `from` to `to` of side k.
  subroutine cut_facets(contact, k, shape, reference, facets, reach, rule, from, to, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, from, to
    type(shape_t), intent(in) :: shape(2), reference
    type(facets_t), intent(in) :: facets(2)
    real(wp), intent(in) :: reach
    type(rule_t), intent(in) :: rule
    type(points_t), intent(inout) :: points !! replaces the earlier points
    real(wp) :: corner(2, MOST_CORNERS), zeta(2, MOST_CORNERS), bend(2, NBEND, MOST_CORNERS)
    real(wp), allocatable :: point(:, :), weight(:)
    real(wp) :: frame(3, 3), quad(2, 4), x(3), a(3, 2)
    integer, allocatable :: near(:), cover(:)
    integer :: tag(MOST_CORNERS)
    integer :: e, flat, i, j, m, n, ncover, nnear, npoint, q
    type(part_t) :: part
    type(view_t) :: view
    logical :: mapped

    associate (own => contact%side(k), mine => facets(k), theirs => facets(3 - k))
      n = MOST_CORNERS/2*rule%most**2
      allocate (near(theirs%n), cover(theirs%n), point(2, n), weight(n))
      points%n = 0
      call reserve(points, 16*rule%least**2)
      e = 0
      do i = from, to
        if (mine%elem(i) /= e) then
          e = mine%elem(i)
          flat = collapsed_side(own, e)
        end if
        call find_near(mine, i, theirs, reach, near, nnear)
        call keep_facing(contact, shape(k), reference, mine, i, theirs, near, nnear)
        if (nnear == 0) cycle
        view%n = 0
        call make_frame(mine%x(:, :, i), mine%normal(:, i), frame)
        quad = matmul(transpose(frame(:, :2)), mine%x(:, :, i) - spread(mine%x(:, 1, i), 2, 4))
        if (.not. signed_area(quad) > 0.0_wp) cycle
        part = part_t(e, mine%from(:, i), mine%to(:, i))
        do j = 1, nnear
          call overlap(mine%x(:, 1, i), frame, quad, theirs%x(:, :, near(j)), &
                       contact%depth, reach, m, corner, tag, zeta)
          if (m == 0) cycle
          call map_corners(own, shape(k), e, flat, mine, i, frame, quad, m, corner, mapped)
          if (.not. mapped) cycle
          associate (first => theirs%from(:, near(j)), last => theirs%to(:, near(j)))
            do q = 1, m
              zeta(:, q) = first + zeta(:, q)*(last - first)
            end do
            call find_border(own, shape(k), part, contact%side(3 - k), shape(3 - k), &
                             part_t(theirs%elem(near(j)), first, last), m, tag, corner, zeta, bend)
          end associate
          do q = 1, m
            corner(:, q) = to_chart(flat, corner(:, q))
          end do
          call drop_short_edges(ON_EDGE*maxval(part%to - part%from), m, corner, bend)
          if (m < 3) cycle
          n = order_of_piece(rule, corner(:, :m), part, mine, i, theirs, near(j))
          call integrate_polygon(corner(:, :m), bend(:, :, :m), rule%g(:n, n), rule%w(:n, n), &
                                 rule%f(:, :n, n), rule%df(:, :n, n), npoint, point, weight)
          ! When its borders are corrected, a piece can lose its area. It is dropped, because
          ! otherwise rounding would decide whether its points have a history of friction.
          if (abs(sum(weight(:npoint))) <= NO_AREA*product(part%to - part%from)) cycle
          call find_covers(view, mine%x(:, 1, i), frame, theirs, near(:nnear), j, contact%depth, &
                           cover, ncover)
          call reserve(points, npoint)
          do q = 1, npoint
            if (.not. abs(weight(q)) > 0.0_wp) cycle
            if (ncover > 0) then
              call chart_point(own, shape(k), e, flat, point(:, q), x, a)
              x = matmul(x - mine%x(:, 1, i), frame)
              if (is_hidden(view, j, cover(:ncover), x, contact%depth)) cycle
            end if
            points%n = points%n + 1
            n = points%n
            points%elem(n) = e
            points%xi(:, n) = max(-1.0_wp, min(1.0_wp, from_chart(flat, point(:, q))))
            call chart_point(own, reference, e, flat, to_chart(flat, points%xi(:, n)), x, a)
            points%weight(n) = weight(q)*norm2(cross(a(:, 1), a(:, 2)))
            points%faced(n) = theirs%elem(near(j))
            points%faced_xi(:, n) = 0.5_wp*(theirs%from(:, near(j)) + theirs%to(:, near(j)))
            points%foot(n)%elem = points%faced(n)
            points%foot(n)%xi = points%faced_xi(:, n)
          end do
        end do
      end do
    end associate
  end subroutine cut_facets

  !> Keep those of the nearby facets that face facet i and may touch it.
  pure subroutine keep_facing(contact, shape, reference, mine, i, theirs, near, nnear)
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape, reference !! of this side, now and before it deformed
    type(facets_t), intent(in) :: mine, theirs
    integer, intent(in) :: i
    integer, intent(inout) :: near(:), nnear
    integer :: j, n

    n = 0
    do j = 1, nnear
      if (dot_product(mine%normal(:, i), theirs%normal(:, near(j))) > FACING) cycle
      if (contact%self) then
        if (.not. may_touch(contact%side(1), reference, shape, mine%elem(i), &
                            theirs%elem(near(j)))) cycle
      end if
      n = n + 1
      near(n) = near(j)
    end do
    nnear = n
  end subroutine keep_facing

  !> The quadrature rule of a contact.
  subroutine find_rule(contact, rule)
    type(contact_t), intent(in) :: contact
    type(rule_t), intent(out) :: rule
    integer :: n, q

    rule%most = max(USUAL_MOST, maxval(contact%ngauss))
    allocate (rule%g(rule%most, rule%most), rule%w(rule%most, rule%most))
    allocate (rule%f(NBEND, rule%most, rule%most), rule%df(NBEND, rule%most, rule%most))
    do n = 1, rule%most
      call gauss(n, rule%g(:n, n), rule%w(:n, n))
      do q = 1, n
        call bend_functions(rule%g(q, n), rule%f(:, q, n), rule%df(:, q, n))
      end do
    end do
    rule%least = 1 + max(highest_degree(contact%side(1)), highest_degree(contact%side(2)))
    rule%further = 2*max(0, maxval(contact%ngauss) - USUAL_POINTS)
    rule%whole = maxval(contact%ngauss)
  end subroutine find_rule

  !> Number of Gauss points, in each direction, of a piece of facet i that faces facet j of the
  !! other side. A whole element has as many points as QUADrature gives; a small piece has only as
  !! many as it needs.
  pure integer function order_of_piece(rule, corner, part, mine, i, theirs, j) result(n)
    type(rule_t), intent(in) :: rule
    real(wp), intent(in) :: corner(:, :)    !! (2, m) corners in the chart of the element
    type(part_t), intent(in) :: part        !! facet i
    type(facets_t), intent(in) :: mine, theirs
    integer, intent(in) :: i, j
    real(wp) :: fraction, other_fraction    ! width of the piece, relative to the facets
    integer :: order

    n = ceiling(rule%whole*sqrt(0.25_wp*max(0.0_wp, signed_area(corner))) - ROUNDING)
    fraction = maxval((maxval(corner, 2) - minval(corner, 2))/(part%to - part%from))
    other_fraction = fraction*maxval(mine%high(:, i) - mine%low(:, i)) &
                     /maxval(theirs%high(:, j) - theirs%low(:, j))
    order = further_order(max(mine%uneven(i)*min(1.0_wp, fraction), &
                              theirs%uneven(j)*min(1.0_wp, other_fraction)))
    order = min(order, merge(1, 0, order <= MANY) + rule%further)
    n = min(max(n, rule%least + order), rule%most)
  end function order_of_piece

  !> Number of Gauss points, in each direction, that a cell over which the tangents change by the
  !! fraction r needs in addition to those for polynomials. If n points integrate 1/(1 + r t), their
  !! error decreases with rho^(-2n), where rho = (1 + sqrt(1 - r^2))/r.
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
  subroutine reserve(points, more)
    type(points_t), intent(inout) :: points
    integer, intent(in) :: more
    type(points_t) :: big
    integer :: n

    if (allocated(points%elem)) then
      if (points%n + more <= size(points%elem)) return
    end if
    n = 2*(points%n + more)
    allocate (big%elem(n), big%xi(2, n), big%weight(n), big%foot(n), big%faced(n), &
              big%faced_xi(2, n))
    if (allocated(points%elem)) call append_points(points, big)
    call move_points(big, points)
  end subroutine reserve

  !> Append points to a list that has room for them.
  pure subroutine append_points(points, list)
    type(points_t), intent(in) :: points
    type(points_t), intent(inout) :: list
    integer :: m, n

    m = list%n
    n = points%n
    list%elem(m + 1:m + n) = points%elem(:n)
    list%xi(:, m + 1:m + n) = points%xi(:, :n)
    list%weight(m + 1:m + n) = points%weight(:n)
    list%foot(m + 1:m + n) = points%foot(:n)
    list%faced(m + 1:m + n) = points%faced(:n)
    list%faced_xi(:, m + 1:m + n) = points%faced_xi(:, :n)
    list%n = m + n
  end subroutine append_points

  !> Move a list of points and its memory.
  pure subroutine move_points(from, to)
    type(points_t), intent(inout) :: from, to

    to%n = from%n
    call move_alloc(from%elem, to%elem)
    call move_alloc(from%xi, to%xi)
    call move_alloc(from%weight, to%weight)
    call move_alloc(from%foot, to%foot)
    call move_alloc(from%faced, to%faced)
    call move_alloc(from%faced_xi, to%faced_xi)
  end subroutine move_points

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

  !> Find the overlap of a facet of this side with a facet of the other side, seen along the normal
  !! of the facet of this side. The corners are given in the plane of this facet.
  pure subroutine overlap(origin, frame, quad, x, deep, high, m, corner, tag, zeta)
    real(wp), intent(in) :: origin(3), frame(3, 3)
    real(wp), intent(in) :: quad(2, 4)    !! the facet of this side in its plane
    real(wp), intent(in) :: x(3, 4)       !! the other facet
    real(wp), intent(in) :: deep, high    !! depth and height beyond which facets do not touch [L]
    integer, intent(out) :: m             !! number of corners; 0: no overlap
    real(wp), intent(out) :: corner(2, MOST_CORNERS)
    !> The edge after each corner is edge -tag of the facet of this side if `tag` is negative, or
    !! else edge `tag` of the other facet.
    integer, intent(out) :: tag(MOST_CORNERS)
    !> Parameters, on [0,1], of the corners that lie on edges of the other facet.
    real(wp), intent(out) :: zeta(2, MOST_CORNERS)
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
    corner(:, :4) = seen(:, 4:1:-1)       ! reversed: seen from here, the other facet is clockwise
    tag(:4) = [3, 2, 1, 4]
    if (.not. signed_area(corner(:, :4)) > 0.0_wp) return
    m = 4
    call clip(quad, m, corner, tag)
    if (m == 0) return
    if (signed_area(corner(:, :m)) < NO_AREA*signed_area(quad)) m = 0
    call join_corners(ON_EDGE*maxval(abs(quad)), m, corner, tag)
    call settle_edges(seen, m, corner, tag)
    zeta = 0.5_wp
    do c = 1, m
      i = tag(mod(c + m - 2, m) + 1)
      if (i < 0) i = tag(c)
      if (i < 0) cycle
      j = mod(i, 4) + 1
      along = seen(:, j) - seen(:, i)
      ! at a corner of the other facet, which is the beginning of its edge i
      if ((tag(c) > 0 .and. tag(c) /= i) .or. .not. any(abs(along) > 0.0_wp)) then
        zeta(:, c) = UNIT(:, i)
      else
        zeta(:, c) = UNIT(:, i) + dot_product(corner(:, c) - seen(:, i), along) &
                     /dot_product(along, along)*(UNIT(:, j) - UNIT(:, i))
      end if
      zeta(:, c) = max(0.0_wp, min(1.0_wp, zeta(:, c)))
    end do
  end subroutine overlap

  !> Join corners that are nearer to each other than `same`. Such corners occur where a facet has a
  !! collapsed edge, and where a corner lies on an edge of the other side.
  pure subroutine join_corners(same, m, corner, tag)
    real(wp), intent(in) :: same            !! [L]
    integer, intent(inout) :: m             !! corners; 0: nothing is left
    integer, intent(inout) :: tag(MOST_CORNERS)
    real(wp), intent(inout) :: corner(2, MOST_CORNERS)
    integer :: c, kept(MOST_CORNERS)

    call find_long_edges(same, corner(:, :m), m, kept)
    do c = 1, m
      corner(:, c) = corner(:, kept(c))
      tag(c) = tag(kept(c))
    end do
    if (m < 3) m = 0
  end subroutine join_corners

  !> Drop edges that have lost their length when the borders of a cell were corrected. Otherwise,
  !! rounding would decide how many corners, and hence how many integration points, a cell has.
  pure subroutine drop_short_edges(short, m, corner, bend)
    real(wp), intent(in) :: short           !! in the chart of the element
    integer, intent(inout) :: m             !! corners
    real(wp), intent(inout) :: corner(2, MOST_CORNERS), bend(2, NBEND, MOST_CORNERS)
    integer :: c, kept(MOST_CORNERS)

    call find_long_edges(short, corner(:, :m), m, kept)
    do c = 1, m
      corner(:, c) = corner(:, kept(c))
      bend(:, :, c) = bend(:, :, kept(c))
    end do
  end subroutine drop_short_edges

  !> Find the edges of a polygon that are longer than `short`. Edge c begins at corner c. The edge
  !! from the last corner ends at the first one whose edge is long.
  pure subroutine find_long_edges(short, corner, n, long)
    real(wp), intent(in) :: short
    real(wp), intent(in) :: corner(:, :)    !! (2, m)
    integer, intent(out) :: n               !! number of these edges
    integer, intent(out) :: long(:)         !! (>= m) the edges, in ascending order
    integer :: c, m, next

    m = size(corner, 2)
    n = 0
    do c = 1, m
      next = min(c + 1, m)
      if (c == m .and. n > 0) next = long(1)
      if (.not. norm2(corner(:, next) - corner(:, c)) > short) cycle
      n = n + 1
      long(n) = c
    end do
  end subroutine find_long_edges

  pure subroutine remove_corner(c, m, corner, tag)
    integer, intent(in) :: c
    integer, intent(inout) :: m, tag(MOST_CORNERS)
    real(wp), intent(inout) :: corner(2, MOST_CORNERS)

    corner(:, c:m - 1) = corner(:, c + 1:m)
    tag(c:m - 1) = tag(c + 1:m)
    m = m - 1
  end subroutine remove_corner

  !> Where edges of both facets lie on one line, rounding decides which of them the clipping keeps,
  !! whether it adds a corner between them, and which corner is the first. To avoid this, such an
  !! edge is counted as an edge of the other facet, corners within it are removed, and the corners
  !! get the order that clipping with distinct lines would give.
  pure subroutine settle_edges(seen, m, corner, tag)
    real(wp), intent(in) :: seen(2, 4)      !! the other facet
    integer, intent(inout) :: m             !! corners
    integer, intent(inout) :: tag(MOST_CORNERS)
    real(wp), intent(inout) :: corner(2, MOST_CORNERS)
    integer, parameter :: ORDER(4) = [3, 2, 1, 4]
    integer :: c, first, i

    do c = 1, m
      do i = 1, merge(4, 0, tag(c) < 0)
        if (.not. is_on(i, corner(:, c))) cycle
        if (is_on(i, corner(:, mod(c, m) + 1))) tag(c) = i
      end do
    end do
    c = 1
    do while (c <= m .and. m > 3)
      if (tag(c) == tag(mod(c + m - 2, m) + 1)) then
        call remove_corner(c, m, corner, tag)
      else
        c = c + 1
      end if
    end do
    do i = 1, 4
      first = findloc(tag(:m), ORDER(i), 1)
      if (first == 0) cycle
      corner(:, :m) = cshift(corner(:, :m), first - 1, 2)
      tag(:m) = cshift(tag(:m), first - 1)
      exit
    end do

  contains

    pure logical function is_on(i, x)
      integer, intent(in) :: i
      real(wp), intent(in) :: x(2)
      real(wp) :: edge(2), r(2)

      edge = seen(:, mod(i, 4) + 1) - seen(:, i)
      r = x - seen(:, i)
      is_on = abs(edge(1)*r(2) - edge(2)*r(1)) < ON_EDGE*dot_product(edge, edge)
    end function is_on
  end subroutine settle_edges

  !> Map corners from the plane of a facet to the parameters of its element. Corners on an edge of
  !! the facet stay on that edge. `mapped` is false if the map has no inverse there.
  pure subroutine map_corners(own, shape, e, flat, facets, i, frame, quad, m, corner, mapped)
    type(surface_t), intent(in) :: own
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e, flat               !! element, its collapsed side
    type(facets_t), intent(in) :: facets
    integer, intent(in) :: i
    real(wp), intent(in) :: frame(3, 3), quad(2, 4)
    integer, intent(in) :: m
    real(wp), intent(inout) :: corner(2, MOST_CORNERS)
    logical, intent(out) :: mapped
    real(wp) :: edge(2), u(2), xi(2), x(3), a(3, 2), r(2), j(2, 2), d(2), det
    real(wp) :: bound(4), image(2, MOST_CORNERS)
    integer :: c, k, step

    mapped = .true.
    bound = [facets%from(2, i), facets%to(1, i), facets%to(2, i), facets%from(1, i)]
    do c = 1, m
      u = to_chart(flat, 0.5_wp*(facets%from(:, i) + facets%to(:, i)))
      do step = 1, MOST_STEPS
        call chart_point(own, shape, e, flat, u, x, a)
        x = x - facets%x(:, 1, i)
        r = corner(:, c) - [dot_product(x, frame(:, 1)), dot_product(x, frame(:, 2))]
        j = matmul(transpose(frame(:, :2)), a)
        det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
        if (.not. det > 0.0_wp) exit
        d = [j(2, 2)*r(1) - j(1, 2)*r(2), j(1, 1)*r(2) - j(2, 1)*r(1)]/det
        d = max(-1.0_wp, min(1.0_wp, d))
        u = max(-1.5_wp, min(1.5_wp, u + d))
        if (maxval(abs(d)) < 1.0e-13_wp) exit
      end do
      if (.not. det > 0.0_wp) then
        mapped = .false.
        return
      end if
      xi = max(facets%from(:, i), min(facets%to(:, i), from_chart(flat, u)))
      do k = 1, 4
        edge = quad(:, mod(k, 4) + 1) - quad(:, k)
        r = corner(:, c) - quad(:, k)
        if (.not. abs(edge(1)*r(2) - edge(2)*r(1)) < ON_EDGE*dot_product(edge, edge)) cycle
        xi(merge(2, 1, mod(k, 2) == 1)) = bound(k)
      end do
      corner(:, c) = xi
      image(:, c) = to_chart(flat, xi)
    end do
    mapped = signed_area(image(:, :m)) > 0.0_wp
  end subroutine map_corners

end module contact_cells
