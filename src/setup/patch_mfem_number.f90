!> Topology of an MFEM NURBS mesh and the numbering of its control points.
!!
!! Numbering: vertices; the inner points of the edges, in the order of the section `edges`, each
!! from its lower vertex to its higher; those of the faces, in the order in which the elements
!! bring them, along the face's first vertices; those of the elements.
module patch_mfem_number
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use base_text, only: to_text
  use bspline, only: spline_t, nfunction
  use patch_text, only: text_t, complain
  implicit none
  private
  public :: mfem_t, number_points, find_point, find_edge

  !> Where the eight vertices of an element stand in its directions.
  integer, parameter :: CORNER(3, 0:7) = reshape([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, &
                                                  0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1], [3, 8])
  !> Vertices of its faces, in the order that numbers the inner points.
  integer, parameter :: QUAD(4, 6) = reshape([3, 2, 1, 0, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, &
                                              3, 0, 4, 7, 4, 5, 6, 7], [4, 6])

  !> A file as read.
  type :: mfem_t
    integer :: nvertex = 0
    integer, allocatable :: vertex(:, :)  !! (8, nelem) from 0, as in the file
    integer, allocatable :: edge(:, :)    !! (3, nedge) knot vector, two vertices, from 0
    type(spline_t), allocatable :: dir(:) !! knot vectors
    real(wp), allocatable :: w(:), x(:, :) !! (n), (3, n)
    integer, allocatable :: face(:, :)    !! (4, nface) vertices in the order of the first element
    integer, allocatable :: first_edge(:) !! (nedge+1) points before those of the edge
    integer, allocatable :: first_face(:) !! (nface+1)
    integer, allocatable :: first_elem(:) !! (nelem+1)
  end type mfem_t

contains

  !> Where the points of each edge, face and element begin.
  subroutine number_points(text, mfem, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(inout) :: mfem
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: list(:, :)
    integer(i8), allocatable :: inner(:)
    integer :: e, f, i, n(3), nface, v(4)
    integer(i8) :: total

    nface = 0
    allocate (list(4, 6*size(mfem%vertex, 2)), inner(6*size(mfem%vertex, 2)))
    allocate (mfem%first_edge(size(mfem%edge, 2) + 1), mfem%first_elem(size(mfem%vertex, 2) + 1))
    total = mfem%nvertex
    do e = 1, size(mfem%edge, 2)
      mfem%first_edge(e) = int(total)
      total = total + nfunction(mfem%dir(mfem%edge(1, e) + 1)) - 2
    end do
    do e = 1, size(mfem%vertex, 2)
      call directions(text, mfem, e, n, error)
      if (allocated(error)) return
      do f = 1, 6
        v = mfem%vertex(QUAD(:, f) + 1, e)
        if (find_face(list(:, :nface), v) > 0) cycle
        nface = nface + 1
        list(:, nface) = v
        i = axis(QUAD(1, f), QUAD(2, f))
        inner(nface) = int(n(i) - 2, i8)*(n(axis(QUAD(1, f), QUAD(4, f))) - 2)
      end do
    end do
    mfem%face = list(:, :nface)
    allocate (mfem%first_face(nface + 1))
    do f = 1, nface
      mfem%first_face(f) = int(min(total, int(huge(1), i8)))
      total = total + inner(f)
    end do
    do e = 1, size(mfem%vertex, 2)
      mfem%first_elem(e) = int(min(total, int(huge(1), i8)))
      call directions(text, mfem, e, n, error)
      total = total + product(int(n - 2, i8))
    end do
    mfem%first_elem(size(mfem%vertex, 2) + 1) = int(min(total, int(huge(1), i8)))
    if (total > len(text%all)) call complain(text, to_text(total) &
                                             //' control points cannot stand in this file', error)
  end subroutine number_points

  !> Control points of an element in its directions.
  subroutine directions(text, mfem, e, n, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: e
    integer, intent(out) :: n(3)
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i
    integer, parameter :: FAR(3) = [1, 3, 4] ! neighbours of vertex 0

    do d = 1, 3
      i = find_edge(mfem, mfem%vertex(1, e), mfem%vertex(FAR(d) + 1, e))
      if (i == 0) then
        call complain(text, 'element '//to_text(e)//' has an edge that the section edges lacks', &
                      error)
        return
      end if
      n(d) = nfunction(mfem%dir(mfem%edge(1, i) + 1))
    end do
  end subroutine directions

  pure integer function find_edge(mfem, a, b) result(i)
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: a, b

    do i = 1, size(mfem%edge, 2)
      if (mfem%edge(2, i) == a .and. mfem%edge(3, i) == b) return
      if (mfem%edge(2, i) == b .and. mfem%edge(3, i) == a) return
    end do
    i = 0
  end function find_edge

  pure integer function find_face(face, v) result(i)
    integer, intent(in) :: face(:, :), v(4)
    integer :: a

    do i = 1, size(face, 2)
      if (all([(any(face(:, i) == v(a)), a=1, 4)])) return
    end do
    i = 0
  end function find_face

  !> Direction in which two neighbouring vertices of an element differ.
  pure integer function axis(a, b)
    integer, intent(in) :: a, b

    axis = maxloc(abs(CORNER(:, a) - CORNER(:, b)), 1)
  end function axis

  !> Number of the control point (i,j,k) of an element.
  subroutine find_point(text, mfem, e, n, ijk, number, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: e, n(3), ijk(3)
    integer, intent(out) :: number !! from 1
    type(error_t), allocatable, intent(out) :: error
    logical :: inside(3), on(0:7)
    integer, allocatable :: local(:)
    integer :: a, i, v(4)

    inside = ijk > 1 .and. ijk < n
    on = [(all(inside .or. CORNER(:, a) == merge(1, 0, ijk == n)), a=0, 7)]
    local = pack([(a, a=0, 7)], on) ! vertices of the face, edge or vertex that the point lies on
    associate (vertex => mfem%vertex(:, e))
      select case (size(local))
      case (1)
        number = vertex(local(1) + 1) + 1
      case (2)
        if (vertex(local(1) + 1) > vertex(local(2) + 1)) local = local([2, 1])
        call edge_of(text, mfem, e, n, local, i, error)
        if (allocated(error)) return
        number = mfem%first_edge(i) + inner_index(local(1), local(2))
      case (4)
        i = find_face(mfem%face, vertex(local + 1))
        v = [(findloc(vertex, mfem%face(a, i), 1) - 1, a=1, 4)]
        number = mfem%first_face(i) + inner_index(v(1), v(2)) &
                 + (n(axis(v(1), v(2))) - 2)*(inner_index(v(1), v(4)) - 1)
      case default
        number = mfem%first_elem(e) + ijk(1) - 1 + (n(1) - 2)*(ijk(2) - 2 + (n(2) - 2)*(ijk(3) - 2))
      end select
    end associate

  contains

    !> Count along the direction from vertex p to vertex q, from 1.
    pure integer function inner_index(p, q)
      integer, intent(in) :: p, q
      integer :: d

      d = axis(p, q)
      inner_index = merge(ijk(d) - 1, n(d) - ijk(d), CORNER(d, p) == 0)
    end function inner_index
  end subroutine find_point

  !> The edge between two vertices of an element.
  subroutine edge_of(text, mfem, e, n, local, i, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: e, n(3), local(2)
    integer, intent(out) :: i
    type(error_t), allocatable, intent(out) :: error

    i = find_edge(mfem, mfem%vertex(local(1) + 1, e), mfem%vertex(local(2) + 1, e))
    if (i == 0) then
      call complain(text, 'element '//to_text(e)//' has an edge that the section edges lacks', &
                    error)
    else if (nfunction(mfem%dir(mfem%edge(1, i) + 1)) /= n(axis(local(1), local(2)))) then
      call complain(text, 'opposite edges of element '//to_text(e) &
                    //' have different numbers of control points', error)
    end if
  end subroutine edge_of

end module patch_mfem_number
