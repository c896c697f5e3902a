!> Topology of a surface: which element is the neighbour across each edge, and which elements share
!! a vertex.
!!
!! Two edges are the same if the same nodes have a trace on them and if they have the same position
!! in the reference configuration. An edge that is collapsed to a point (as on triangles) has no
!! neighbour.
!! At a T-junction, an edge meets several others, each of which is a part of it
!! (surface_t_junctions): the same control points of a spline have traces on all these edges, or the
!! nodes of the parts are hanging nodes on the whole edge.
module surface_topology
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index, unique, hash
  use base_text, only: to_text
  use constraint, only: constraint_t, slave_marks
  use contact_pair, only: surface_t
  use surface_t_junctions, only: edge_point, match_t_junctions
  implicit none
  private
  public :: connect_elements

  !> Corners at the ends of the edges xi-, xi+, eta-, eta+, from - to +.
  integer, parameter :: END_OF(2, 4) = reshape([1, 3, 2, 4, 1, 2, 3, 4], [2, 4])

  !> Fractions of the size of an element: edges closer than NEAR are the same, and an edge shorter
  !! than COLLAPSED is a point.
  real(wp), parameter :: NEAR = 1.0e-6_wp, COLLAPSED = 1.0e-9_wp
  integer, parameter :: NPOINT = 4

  !> Edges of all elements, edge k of element e at 4(e-1)+k.
  type :: edges_t
    integer, allocatable :: first(:)     !! position in `node` at which the nodes of an edge begin
    integer, allocatable :: node(:)      !! nodes with a trace on the edge, in ascending order
    integer(i8), allocatable :: key(:)   !! equal for edges with the same nodes
    real(wp), allocatable :: x(:, :, :)  !! (3, NPOINT, nedge) points of the edge [L]
    real(wp), allocatable :: length(:)   !! (nelem) size of an element [L]
    logical, allocatable :: point(:, :)  !! (4, nelem) the edge is collapsed to a point
  end type edges_t

contains

  !> Set neighbour, edge, part, point, vertex, ring and outer of a surface.
  subroutine connect_elements(xr, hanging, surface, error)
    real(wp), intent(in) :: xr(:, :)
    type(constraint_t), intent(in) :: hanging
    type(surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(edges_t) :: edges
    integer, allocatable :: free(:) ! edges without a neighbour
    integer :: i

    call find_edges(xr, surface, edges)
    call match_edges(edges, surface, error)
    if (allocated(error)) return
    free = pack([(i, i=1, size(edges%key))], &
                reshape(surface%neighbour == 0 .and. .not. edges%point, [size(edges%key)]))
    call match_t_junctions(xr, free, master_keys(edges, free, hanging, size(xr, 2)), &
                           NEAR*edges%length, surface)
    call number_vertices(surface, edges%point)
    if (any(edges%point)) surface%point = edges%point
  end subroutine connect_elements

  !> Find the nodes and points of all edges. A node has a trace on an edge if one of the
  !! coefficients of its function does not vanish there.
  subroutine find_edges(xr, surface, edges)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    type(edges_t), intent(out) :: edges
    integer, allocatable :: list(:)
    logical, allocatable :: on(:)
    real(wp) :: slope(3)
    integer :: n(2), e, k, i, d, q, nedge, from, to, step

    nedge = 4*surface%nelem
    allocate (edges%first(nedge + 1), edges%key(nedge), edges%x(3, NPOINT, nedge))
    allocate (edges%node(4*size(surface%node)))
    allocate (edges%length(surface%nelem), edges%point(4, surface%nelem))
    edges%first(1) = 1
    do e = 1, surface%nelem
      associate (basis => surface%basis(surface%ibasis(e)), x => edges%x(:, :, 4*e - 3:4*e))
        do k = 1, 4
          i = 4*(e - 1) + k
          n = basis%degree + 1
          step = merge(n(1), 1, k < 3)
          from = 1
          if (k == 2) from = n(1)
          if (k == 4) from = n(1)*(n(2) - 1) + 1
          to = from + step*(merge(n(2), n(1), k < 3) - 1)
          on = [(any(abs(basis%c(d, from:to:step)) > 0.0_wp), d=1, basis%nsf)]
          list = unique(pack(surface%node(surface%first(e):surface%first(e + 1) - 1), on))
          edges%first(i + 1) = edges%first(i) + size(list)
          edges%node(edges%first(i):edges%first(i + 1) - 1) = list
          edges%key(i) = hash(list)
          do q = 1, NPOINT
            call edge_point(xr, surface, e, k, -1.0_wp + 2.0_wp*(q - 1)/(NPOINT - 1), x(:, q, k), &
                            slope)
          end do
        end do
        edges%length(e) = maxval([(maxval(x(d, :, :)) - minval(x(d, :, :)), d=1, 3)])
        do k = 1, 4
          edges%point(k, e) = maxval(abs(x(:, 2:, k) - spread(x(:, 1, k), 2, NPOINT - 1))) &
                              <= COLLAPSED*edges%length(e)
        end do
      end associate
    end do
  end subroutine find_edges

  !> Find keys that are equal for edges whose nodes depend on the same master nodes.
  pure function master_keys(edges, edge, hanging, nnode) result(key)
    type(edges_t), intent(in) :: edges
    integer, intent(in) :: edge(:)
    type(constraint_t), intent(in) :: hanging
    integer, intent(in) :: nnode
    integer(i8) :: key(size(edge))
    integer, allocatable :: list(:)
    integer :: mark(merge(nnode, 0, hanging%n > 0))
    integer :: e, i

    key = edges%key(edge)
    if (hanging%n == 0) return
    mark = slave_marks(hanging, nnode)
    do e = 1, size(edge)
      associate (node => edges%node(edges%first(edge(e)):edges%first(edge(e) + 1) - 1))
        if (all(mark(node) == 0)) cycle
        list = pack(node, mark(node) == 0)
        do i = 1, size(node)
          if (mark(node(i)) == 0) cycle
          list = [list, hanging%master(hanging%first(mark(node(i))): &
                                       hanging%first(mark(node(i)) + 1) - 1)]
        end do
        key(e) = hash(unique(list))
      end associate
    end do
  end function master_keys

  !> Find the pairs of edges that are the same: they have the same nodes at the same positions, in
  !! either direction.
  subroutine match_edges(edges, surface, error)
    type(edges_t), intent(in) :: edges
    type(surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    integer :: order(size(edges%key))
    integer :: a, b, ea, eb, ka, kb, i, j, from
    real(wp) :: forward, backward

    allocate (surface%neighbour(4, surface%nelem), surface%edge(4, surface%nelem), source=0)
    call sort_index(edges%key, order)
    from = 1
    do i = 1, size(order)
      if (edges%key(order(i)) /= edges%key(order(from))) from = i
      do j = from, i - 1
        a = order(j)
        b = order(i)
        ea = (a + 3)/4
        eb = (b + 3)/4
        ka = a - 4*(ea - 1)
        kb = b - 4*(eb - 1)
        if (edges%point(ka, ea) .or. edges%point(kb, eb)) cycle
        associate (nodes_a => edges%node(edges%first(a):edges%first(a + 1) - 1), &
                   nodes_b => edges%node(edges%first(b):edges%first(b + 1) - 1))
          if (size(nodes_a) /= size(nodes_b)) cycle
          if (any(nodes_a /= nodes_b)) cycle
        end associate
        forward = maxval(abs(edges%x(:, :, a) - edges%x(:, :, b)))
        backward = maxval(abs(edges%x(:, :, a) - edges%x(:, NPOINT:1:-1, b)))
        if (.not. min(forward, backward) <= NEAR*min(edges%length(ea), edges%length(eb))) cycle
        if (surface%neighbour(ka, ea) > 0 .or. surface%neighbour(kb, eb) > 0) then
          call fail(error, DECK_ERROR, 'more than two element faces of contact surface ' &
                    //surface%name//' share the edge at node ' &
                    //to_text(edges%node(edges%first(a))), &
                    hint='name each face of a side once, and no more than two faces with a ' &
                    //'common edge')
          return
        end if
        surface%neighbour(ka, ea) = eb
        surface%neighbour(kb, eb) = ea
        surface%edge(ka, ea) = merge(-kb, kb, backward < forward)
        surface%edge(kb, eb) = merge(-ka, ka, backward < forward)
      end do
    end do
  end subroutine match_edges

  !> Number the vertices and find the elements around each of them. Corners at which matching
  !! edges meet are one vertex, and so are the two ends of a collapsed edge.
  subroutine number_vertices(surface, point)
    type(surface_t), intent(inout) :: surface
    logical, intent(in) :: point(:, :) !! (4, nelem) the edge is collapsed to a point
    integer :: root(4*surface%nelem), number(4*surface%nelem)
    integer, allocatable :: next(:)
    integer :: e, k, i, n

    root = [(i, i=1, 4*surface%nelem)]
    do e = 1, surface%nelem
      do k = 1, 4
        if (point(k, e)) call join(root, corner(e, END_OF(1, k)), corner(e, END_OF(2, k)))
        if (surface%neighbour(k, e) > 0) call join_edges(surface, e, k, root)
      end do
    end do
    n = 0
    do i = 1, size(root)
      if (top(root, i) /= i) cycle
      n = n + 1
      number(i) = n
    end do
    number = number([(top(root, i), i=1, size(root))])
    surface%vertex = reshape(number, [4, surface%nelem])
    allocate (surface%outer(n), source=.false.)
    do e = 1, surface%nelem
      do k = 1, 4
        if (surface%neighbour(k, e) > 0 .or. point(k, e)) cycle
        surface%outer(surface%vertex(END_OF(:, k), e)) = .true.
      end do
    end do
    ! Sort the elements around each vertex in ascending order, by a counting sort.
    allocate (next(n), source=0)
    do i = 1, size(number)
      next(number(i)) = next(number(i)) + 1
    end do
    allocate (surface%ring_first(n + 1), surface%ring_elem(size(number)))
    allocate (surface%ring_corner(size(number)))
    surface%ring_first(1) = 1
    do i = 1, n
      surface%ring_first(i + 1) = surface%ring_first(i) + next(i)
    end do
    next = surface%ring_first(:n)
    do i = 1, size(number)
      surface%ring_elem(next(number(i))) = (i + 3)/4
      surface%ring_corner(next(number(i))) = i - 4*((i - 1)/4)
      next(number(i)) = next(number(i)) + 1
    end do
  end subroutine number_vertices

  !> Join the ends of an edge with those of its neighbour; at a T-junction, join the ends of parts
  !! that are corners on both sides.
  pure subroutine join_edges(surface, e, k, root)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    integer, intent(inout) :: root(:)
    integer :: i, j, m, from, to

    to = 0
    from = 1
    if (allocated(surface%part_first)) then
      from = surface%part_first(4*(e - 1) + k)
      to = surface%part_first(4*(e - 1) + k + 1) - 1
    end if
    do j = from, to
      associate (p => surface%part(j))
        do i = 1, 2
          if (abs(p%own(i)) < 1.0_wp .or. abs(p%other(i)) < 1.0_wp) cycle
          call join(root, corner(e, END_OF(merge(2, 1, p%own(i) > 0.0_wp), k)), &
                    corner(p%elem, END_OF(merge(2, 1, p%other(i) > 0.0_wp), p%edge)))
        end do
      end associate
    end do
    if (to >= from) return
    m = abs(surface%edge(k, e))
    do i = 1, 2
      call join(root, corner(e, END_OF(i, k)), &
                corner(surface%neighbour(k, e), &
                       END_OF(merge(3 - i, i, surface%edge(k, e) < 0), m)))
    end do
  end subroutine join_edges

  !> Number of corner c of element e among the corners of all elements.
  pure integer function corner(e, c)
    integer, intent(in) :: e, c

    corner = 4*(e - 1) + c
  end function corner

  !> The member that represents the set of corners to which corner i belongs.
  pure integer function top(root, i)
    integer, intent(in) :: root(:), i

    top = i
    do while (root(top) /= top)
      top = root(top)
    end do
  end function top

  !> Unite the sets of corners i and j.
  pure subroutine join(root, i, j)
    integer, intent(inout) :: root(:)
    integer, intent(in) :: i, j
    integer :: a, b

    a = top(root, i)
    b = top(root, j)
    root(max(a, b)) = min(a, b)
  end subroutine join

end module surface_topology
