!> Vertices of a surface, the elements round them, and which lie on the outer boundary.
module contact_vertices
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  implicit none
  private
  public :: number_vertices

  !> Corners at the ends of the edges xi-, xi+, eta-, eta+, from - to +.
  integer, parameter :: END_OF(2, 4) = reshape([1, 3, 2, 4, 1, 2, 3, 4], [2, 4])

contains

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

end module contact_vertices
