!> How the elements of a surface hang together: who is behind which edge.
!!
!! Edges meet where the same nodes have a trace on them and they lie at the same place in the
!! reference configuration; an edge that is collapsed to a point (prisms) meets nothing. At a
!! T-junction an edge meets several that each are a part of it.
!!
!! Vertices of a surface, the elements round them, and which lie on the outer boundary.
module surface_topology
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index, unique, hash
  use base_text, only: to_text
  use contact_pair, only: surface_t
  use surface_t_junctions, only: edge_point, part_list_t, try_part, set_parts
  implicit none
  private
  public :: connect_elements, number_vertices

  !> Corners at the ends of the edges xi-, xi+, eta-, eta+, from - to +.
  integer, parameter :: END_OF(2, 4) = reshape([1, 3, 2, 4, 1, 2, 3, 4], [2, 4])

  !> Shares of an element's size: edges as close as this are one, as short as this a point.
  real(wp), parameter :: NEAR = 1.0e-6_wp, COLLAPSED = 1.0e-9_wp
  integer, parameter :: NPOINT = 4

  !> Edges of all elements, edge k of element e at 4(e-1)+k.
  type :: edges_t
    integer, allocatable :: first(:)     !! where the nodes of an edge begin in `node`
    integer, allocatable :: node(:)      !! nodes with a trace on it, rising
    integer(i8), allocatable :: key(:)   !! the same for the same nodes
    real(wp), allocatable :: x(:, :, :)  !! (3, NPOINT, nedge) points of it [L]
    real(wp), allocatable :: length(:)   !! (nelem) size of an element [L]
  end type edges_t

contains

  !> Fill neighbour, edge, vertex, rings and outer.
  subroutine connect_elements(xr, surface, error)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(edges_t) :: edges
    logical :: point(4, surface%nelem)

    call find_edges(xr, surface, edges)
    point = collapsed_edges(edges)
    call match_edges(edges, point, surface, error)
    if (allocated(error)) return
    call match_parts(xr, edges, point, surface)
    call number_vertices(surface, point)
    if (any(point)) surface%point = point
  end subroutine connect_elements

  !> Nodes and points of all edges.
  subroutine find_edges(xr, surface, edges)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    type(edges_t), intent(out) :: edges
    integer, allocatable :: list(:)
    integer :: e, k, i, d, n

    n = 4*surface%nelem
    allocate (edges%first(n + 1), edges%key(n), edges%x(3, NPOINT, n), edges%length(surface%nelem))
    allocate (edges%node(4*size(surface%node)))
    edges%first(1) = 1
    do e = 1, surface%nelem
      do k = 1, 4
        i = 4*(e - 1) + k
        list = trace_nodes(surface, e, k)
        edges%first(i + 1) = edges%first(i) + size(list)
        edges%node(edges%first(i):edges%first(i + 1) - 1) = list
        edges%key(i) = hash(list)
        call edge_points(xr, surface, e, k, edges%x(:, :, i))
      end do
      edges%length(e) = 0.0_wp
      do d = 1, 3
        associate (x => edges%x(d, :, 4*e - 3:4*e))
          edges%length(e) = max(edges%length(e), maxval(x) - minval(x))
        end associate
      end do
    end do
  end subroutine find_edges

  !> Nodes whose functions do not vanish on an edge: some coefficient there is not zero.
  function trace_nodes(surface, e, k) result(list)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    integer, allocatable :: list(:)
    logical :: on(surface%first(e + 1) - surface%first(e))
    integer :: n(2), i, from, to, step

    associate (basis => surface%basis(surface%ibasis(e)))
      n = basis%degree + 1
      step = merge(n(1), 1, k < 3)
      from = 1
      if (k == 2) from = n(1)
      if (k == 4) from = n(1)*(n(2) - 1) + 1
      to = from + step*(merge(n(2), n(1), k < 3) - 1)
      on = [(any(abs(basis%c(i, from:to:step)) > 0.0_wp), i=1, basis%nsf)]
    end associate
    list = unique(pack(surface%node(surface%first(e):surface%first(e + 1) - 1), on))
  end function trace_nodes

  subroutine edge_points(xr, surface, e, k, x)
    real(wp), intent(in) :: xr(:, :)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    real(wp), intent(out) :: x(:, :) !! (3, NPOINT)
    real(wp) :: slope(3)
    integer :: q

    do q = 1, NPOINT
      call edge_point(xr, surface, e, k, -1.0_wp + 2.0_wp*(q - 1)/(NPOINT - 1), x(:, q), slope)
    end do
  end subroutine edge_points

  !> Is an edge a point?
  pure function collapsed_edges(edges) result(yes)
    type(edges_t), intent(in) :: edges
    logical :: yes(4, size(edges%length))
    integer :: e, k

    do e = 1, size(edges%length)
      do k = 1, 4
        associate (x => edges%x(:, :, 4*(e - 1) + k))
          yes(k, e) = maxval(abs(x(:, 2:) - spread(x(:, 1), 2, NPOINT - 1))) &
                      <= COLLAPSED*edges%length(e)
        end associate
      end do
    end do
  end function collapsed_edges

  !> Pairs of edges.
  subroutine match_edges(edges, point, surface, error)
    type(edges_t), intent(in) :: edges
    logical, intent(in) :: point(:, :) !! (4, nelem) the edge is a point
    type(surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    integer :: order(size(edges%key))
    integer :: i, j, from

    allocate (surface%neighbour(4, surface%nelem), surface%edge(4, surface%nelem), source=0)
    call sort_index(edges%key, order)
    from = 1
    do i = 1, size(order)
      if (edges%key(order(i)) /= edges%key(order(from))) from = i
      do j = from, i - 1
        call try_pair(order(j), order(i))
        if (allocated(error)) return
      end do
    end do

  contains

    !> Join two edges if they are one.
    subroutine try_pair(a, b)
      integer, intent(in) :: a, b
      integer :: ea, eb, ka, kb
      logical :: same, reverse

      ea = (a + 3)/4
      eb = (b + 3)/4
      ka = a - 4*(ea - 1)
      kb = b - 4*(eb - 1)
      if (point(ka, ea) .or. point(kb, eb)) return
      call compare_edges(edges, a, b, min(edges%length(ea), edges%length(eb)), same, reverse)
      if (.not. same) return
      if (surface%neighbour(ka, ea) > 0 .or. surface%neighbour(kb, eb) > 0) then
        call fail_joint(surface%name, edges%node(edges%first(a)), error)
        return
      end if
      surface%neighbour(ka, ea) = eb
      surface%neighbour(kb, eb) = ea
      surface%edge(ka, ea) = merge(-kb, kb, reverse)
      surface%edge(kb, eb) = merge(-ka, ka, reverse)
    end subroutine try_pair
  end subroutine match_edges

  !> Edges without a neighbour that lie in others: T-junctions.
  subroutine match_parts(xr, edges, point, surface)
    real(wp), intent(in) :: xr(:, :)
    type(edges_t), intent(in) :: edges
    logical, intent(in) :: point(:, :)
    type(surface_t), intent(inout) :: surface
    type(part_list_t) :: list
    integer, allocatable :: open (:), order(:)
    integer :: i, j, from, to

    open = pack([(i, i=1, size(edges%key))], reshape(surface%neighbour == 0 .and. .not. point, &
                                                     [size(edges%key)]))
    allocate (order(size(open)))
    call sort_index(edges%key(open), order)
    open = open (order)
    from = 1
    do while (from <= size(open))
      to = from
      do while (to < size(open))
        if (edges%key(open (to + 1)) /= edges%key(open (from))) exit
        to = to + 1
      end do
      do i = from, to
        do j = from, to
          if (i /= j) call try_part(xr, surface, open (i), open (j), NEAR &
                                    *minval(edges%length(([open (i), open (j)] + 3)/4)), list)
        end do
      end do
      from = to + 1
    end do
    call set_parts(list, surface)
  end subroutine match_parts

  subroutine fail_joint(name, node, error)
    character(*), intent(in) :: name
    integer, intent(in) :: node
    type(error_t), allocatable, intent(out) :: error

    call fail(error, DECK_ERROR, 'more than two element faces of surface '//name//' of a ' &
              //'contact meet at the edge at node '//to_text(node), &
              hint='name each face of a side only once')
  end subroutine fail_joint

  !> The same nodes at the same places, in either direction.
  pure subroutine compare_edges(edges, a, b, length, same, reverse)
    type(edges_t), intent(in) :: edges
    integer, intent(in) :: a, b
    real(wp), intent(in) :: length
    logical, intent(out) :: same, reverse
    real(wp) :: forward, back

    same = edges%first(a + 1) - edges%first(a) == edges%first(b + 1) - edges%first(b)
    reverse = .false.
    if (.not. same) return
    same = all(edges%node(edges%first(a):edges%first(a + 1) - 1) &
               == edges%node(edges%first(b):edges%first(b + 1) - 1))
    if (.not. same) return
    forward = maxval(abs(edges%x(:, :, a) - edges%x(:, :, b)))
    back = maxval(abs(edges%x(:, :, a) - edges%x(:, NPOINT:1:-1, b)))
    reverse = back < forward
    same = min(forward, back) <= NEAR*length
  end subroutine compare_edges

  !> Corners that matched edges join are one vertex, and so are the ends of a collapsed edge.
  subroutine number_vertices(surface, point)
    type(surface_t), intent(inout) :: surface
    logical, intent(in) :: point(:, :) !! (4, nelem) the edge is collapsed
    integer :: root(4*surface%nelem), number(4*surface%nelem)
    integer :: e, k, i, m, n

    root = [(i, i=1, 4*surface%nelem)]
    do e = 1, surface%nelem
      do k = 1, 4
        if (point(k, e)) call join(root, corner(e, END_OF(1, k)), corner(e, END_OF(2, k)))
        n = surface%neighbour(k, e)
        if (n == 0) cycle
        if (has_parts(surface, e, k)) then
          call join_parts(surface, e, k, root)
          cycle
        end if
        m = abs(surface%edge(k, e))
        do i = 1, 2
          call join(root, corner(e, END_OF(i, k)), &
                    corner(n, END_OF(merge(3 - i, i, surface%edge(k, e) < 0), m)))
        end do
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
    call find_rings(surface, number, n)
    allocate (surface%outer(n), source=.false.)
    do e = 1, surface%nelem
      do k = 1, 4
        if (surface%neighbour(k, e) > 0 .or. point(k, e)) cycle
        surface%outer(surface%vertex(END_OF(:, k), e)) = .true.
      end do
    end do
  end subroutine number_vertices

  !> Does an edge meet several, or a part of one?
  pure logical function has_parts(surface, e, k)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k

    has_parts = .false.
    if (.not. allocated(surface%part_first)) return
    has_parts = surface%part_first(4*(e - 1) + k + 1) > surface%part_first(4*(e - 1) + k)
  end function has_parts

  !> Ends of parts that are corners on both sides.
  pure subroutine join_parts(surface, e, k, root)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e, k
    integer, intent(inout) :: root(:)
    integer :: i, j

    do j = surface%part_first(4*(e - 1) + k), surface%part_first(4*(e - 1) + k + 1) - 1
      associate (p => surface%part(j))
        do i = 1, 2
          if (abs(p%own(i)) < 1.0_wp .or. abs(p%other(i)) < 1.0_wp) cycle
          call join(root, corner(e, END_OF(merge(2, 1, p%own(i) > 0.0_wp), k)), &
                    corner(p%elem, END_OF(merge(2, 1, p%other(i) > 0.0_wp), p%edge)))
        end do
      end associate
    end do
  end subroutine join_parts

  pure integer function corner(e, c)
    integer, intent(in) :: e, c

    corner = 4*(e - 1) + c
  end function corner

  pure integer function top(root, i)
    integer, intent(in) :: root(:), i

    top = i
    do while (root(top) /= top)
      top = root(top)
    end do
  end function top

  pure subroutine join(root, i, j)
    integer, intent(inout) :: root(:)
    integer, intent(in) :: i, j
    integer :: a, b

    a = top(root, i)
    b = top(root, j)
    root(max(a, b)) = min(a, b)
  end subroutine join

  !> Elements round each vertex, in the order of their numbers.
  subroutine find_rings(surface, number, n)
    type(surface_t), intent(inout) :: surface
    integer, intent(in) :: number(:) !! (4*nelem) vertex of each corner
    integer, intent(in) :: n
    integer :: next(n), i

    next = 0
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
  end subroutine find_rings

end module surface_topology
