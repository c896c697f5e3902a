!> Files `MFEM NURBS mesh v1.0`: NURBS blocks whose control points have a common numbering.
!!
!! The reader uses the dimension, elements (cubes), edges, vertices, knotvectors, weights and
!! positions. The positions are not multiplied by the weights. The boundary is skipped. A knot
!! vector runs along its edge from the first vertex given to the second one.
!!
!! The control points are numbered in this order:
!!
!! 1. the vertices;
!! 2. the inner points of the edges, in the order of the section `edges`, and on each edge from the
!!    vertex with the lower number to the other one;
!! 3. the inner points of the faces, in the order in which the faces first occur in the elements,
!!    and on each face first along the edge between its first two vertices;
!! 4. the inner points of the elements, and in each element first along direction 1, then 2, then 3.
!!
!! Source: mfem.org, mesh format; the files in the data folder of MFEM
module format_mfem
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use bspline, only: spline_t, nfunction
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_integers, next_count, &
                         next_reals
  use nurbs, only: nurbs_t, new_nurbs
  implicit none
  private
  public :: read_mfem

  !> Positions of the eight vertices of an element, 0 or 1 in each of its directions.
  integer, parameter :: CORNER(3, 0:7) = reshape([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, &
                                                  0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1], [3, 8])
  !> Vertices of the faces of an element, in the order that determines the numbering of the inner
  !! points of a face.
  integer, parameter :: QUAD(4, 6) = reshape([3, 2, 1, 0, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, &
                                              3, 0, 4, 7, 4, 5, 6, 7], [4, 6])
  !> Indices, in the list of an element's vertices, of the neighbours of the first vertex in the
  !! three directions.
  integer, parameter :: NEIGHBOUR(3) = [2, 4, 5]

  !> The content of a file.
  type :: mfem_t
    integer :: nvertex = 0
    integer, allocatable :: vertex(:, :)  !! (8, nelem) from 0, as in the file
    integer, allocatable :: edge(:, :)    !! (3, nedge) knot vector and two vertices, from 0
    type(spline_t), allocatable :: dir(:) !! knot vectors
    real(wp), allocatable :: w(:), x(:, :) !! (n), (3, n)
    integer, allocatable :: face(:, :)    !! (4, nface) vertices, as in its first element
    !> (>= nedge), (>= nface), (nelem+1) Number of points before those of an edge, face or element;
    !! the last entry of first_elem is the number of all points.
    integer, allocatable :: first_edge(:), first_face(:), first_elem(:)
  end type mfem_t

contains

  !> Read the element `name` (its number, from 1) of a file; if the name is blank, read the only
  !! element.
  subroutine read_mfem(text, name, patch, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    type(nurbs_t), intent(out) :: patch
    type(error_t), allocatable, intent(out) :: error
    type(mfem_t) :: mfem
    type(spline_t) :: dir(3)
    integer, allocatable :: at(:)
    integer :: d, e, i, j, k, n(3), nelem, status, last

    text%comment = '#'
    call read_topology(text, mfem, error)
    if (allocated(error)) return
    nelem = size(mfem%vertex, 2)
    e = 1
    status = merge(0, 1, nelem == 1)
    if (len_trim(name) > 0) then
      status = 1
      if (verify(trim(name), '0123456789') == 0) read (name, *, iostat=status) e
    end if
    if (status /= 0 .or. e < 1 .or. e > nelem) then
      text%at = 0
      if (len_trim(name) == 0) then
        call fail_in_file(text, 'the file has '//to_text(nelem) &
                          //' patches, but the deck names none of them', &
                          error, 'name a patch by its number, for example ''FILE path 1''')
      else
        call fail_in_file(text, 'the file has no patch '//quoted(trim(name)), error, &
                          'the file has patches 1 to '//to_text(nelem))
      end if
      return
    end if
    call number_points(text, mfem, error)
    if (.not. allocated(error)) call read_points(text, mfem, error)
    if (allocated(error)) return
    do d = 1, 3
      associate (a => mfem%vertex(1, e), b => mfem%vertex(NEIGHBOUR(d), e))
        i = find_edge(mfem, a, b)
        dir(d) = mfem%dir(mfem%edge(1, i) + 1)
        if (mfem%edge(2, i) == b) then ! the edge is written in the opposite direction
          last = size(dir(d)%knots)
          dir(d)%knots = dir(d)%knots(1) + dir(d)%knots(last) - dir(d)%knots(last:1:-1)
        end if
      end associate
      n(d) = nfunction(dir(d))
    end do
    allocate (at(product(n)))
    do k = 1, n(3)
      do j = 1, n(2)
        do i = 1, n(1)
          call find_point(text, mfem, e, n, [i, j, k], at(i + n(1)*(j - 1 + n(2)*(k - 1))), error)
          if (allocated(error)) return
        end do
      end do
    end do
    call new_nurbs(patch, dir, mfem%x(:, at), mfem%w(at))
  end subroutine read_mfem

  !> Read everything up to the end of the knot vectors.
  subroutine read_topology(text, mfem, error)
    type(text_t), intent(inout) :: text
    type(mfem_t), intent(inout) :: mfem
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer :: e, n, skip(6)

    do
      call next_word(text, word)
      select case (word)
      case ('dimension')
        call next_integer(text, 'the dimension', n, error)
        if (.not. allocated(error) .and. n /= 3) then
          call fail_in_file(text, 'the mesh has dimension '//to_text(n)//', expected 3', error)
        end if
      case ('elements')
        call read_elements(text, mfem, error)
      case ('boundary')
        call next_count(text, 'the number of boundary faces', n, error)
        if (allocated(error)) return
        do e = 1, n
          call next_integers(text, 'an integer of a boundary face', skip, error)
          if (allocated(error)) return
        end do
      case ('edges')
        call read_edges(text, mfem, error)
      case ('vertices')
        call next_count(text, 'the number of vertices', mfem%nvertex, error)
      case ('knotvectors')
        call read_knots(text, mfem%dir, error)
        exit
      case ('')
        call fail_in_file(text, 'expected ''knotvectors'', found the end of the file', error)
      case default
        call fail_in_file(text, 'section '//quoted(word)//' is not supported', error, 'known ' &
                          //'sections: dimension elements boundary edges vertices knotvectors ' &
                          //'weights')
      end select
      if (allocated(error)) return
    end do
    if (.not. allocated(error)) call check_topology(text, mfem, error)
  end subroutine read_topology

  subroutine read_elements(text, mfem, error)
    type(text_t), intent(inout) :: text
    type(mfem_t), intent(inout) :: mfem
    type(error_t), allocatable, intent(out) :: error
    integer :: e, i, n, type

    call next_count(text, 'the number of elements', n, error)
    if (allocated(error)) return
    if (allocated(mfem%vertex)) deallocate (mfem%vertex)
    allocate (mfem%vertex(8, n))
    do e = 1, n
      call next_integer(text, 'an attribute', type, error)
      if (.not. allocated(error)) call next_integer(text, 'an element type', type, error)
      if (allocated(error)) return
      if (type /= 5) then
        call fail_in_file(text, 'expected element type 5 (cube), found '//to_text(type), error)
        return
      end if
      do i = 1, 8
        call next_count(text, 'a vertex number', mfem%vertex(i, e), error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_elements

  subroutine read_edges(text, mfem, error)
    type(text_t), intent(inout) :: text
    type(mfem_t), intent(inout) :: mfem
    type(error_t), allocatable, intent(out) :: error
    integer :: e, i, n

    call next_count(text, 'the number of edges', n, error)
    if (allocated(error)) return
    if (allocated(mfem%edge)) deallocate (mfem%edge)
    allocate (mfem%edge(3, n))
    do e = 1, n
      do i = 1, 3
        call next_count(text, 'the number of a knot vector or vertex', mfem%edge(i, e), error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_edges

  !> Check that the vertices and knot vectors to which elements and edges refer exist, and that no
  !! element has a vertex twice.
  subroutine check_topology(text, mfem, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(in) :: mfem
    type(error_t), allocatable, intent(out) :: error
    integer :: e, i

    if (.not. (allocated(mfem%vertex) .and. allocated(mfem%edge))) then
      call fail_in_file(text, 'the sections ''elements'' and ''edges'' must come before ' &
                        //'''knotvectors''', error)
    else if (size(mfem%vertex) == 0 .or. size(mfem%edge) == 0) then
      call fail_in_file(text, 'the section ''elements'' or ''edges'' is empty', error)
    else if (max(maxval(mfem%vertex), maxval(mfem%edge(2:3, :))) >= mfem%nvertex) then
      call fail_in_file(text, 'an element or edge refers to a vertex outside the range 0 to ' &
                        //to_text(mfem%nvertex - 1), error)
    else if (any([((any(mfem%vertex(i + 1:, e) == mfem%vertex(i, e)), i=1, 7), &
                   e=1, size(mfem%vertex, 2))])) then
      call fail_in_file(text, 'an element lists the same vertex twice', error)
    else if (maxval(mfem%edge(1, :)) >= size(mfem%dir)) then
      call fail_in_file(text, 'an edge refers to a knot vector outside the range 0 to ' &
                        //to_text(size(mfem%dir) - 1), error)
    end if
  end subroutine check_topology

  subroutine read_knots(text, dir, error)
    type(text_t), intent(inout) :: text
    type(spline_t), allocatable, intent(out) :: dir(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: n, i, ncp

    call next_count(text, 'the number of knot vectors', n, error)
    if (allocated(error)) return
    allocate (dir(n))
    do i = 1, n
      call next_count(text, 'a degree', dir(i)%degree, error)
      if (allocated(error)) return
      call next_count(text, 'the number of control points', ncp, error)
      if (allocated(error)) return
      if (ncp <= dir(i)%degree) then
        call fail_in_file(text, 'degree '//to_text(dir(i)%degree)//' needs at least ' &
                          //to_text(dir(i)%degree + 1)//' control points, found '//to_text(ncp), &
                          error)
        return
      end if
      allocate (dir(i)%knots(ncp + dir(i)%degree + 1))
      call next_reals(text, 'a knot', dir(i)%knots, error)
      if (allocated(error)) return
    end do
  end subroutine read_knots

  !> Read weights and positions.
  subroutine read_points(text, mfem, error)
    type(text_t), intent(inout) :: text
    type(mfem_t), intent(inout) :: mfem
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    integer :: n, i, ordering, dimension

    n = mfem%first_elem(size(mfem%first_elem))
    allocate (mfem%w(n), mfem%x(3, n))
    ordering = -1
    dimension = 0
    call next_word(text, word)
    if (word /= 'weights') then
      call fail_in_file(text, 'expected ''weights'', found '//quoted(word), error)
      return
    end if
    call next_reals(text, 'a weight', mfem%w, error)
    if (allocated(error)) return
    do while (ordering < 0)
      call next_word(text, word)
      select case (word)
      case ('FiniteElementSpace', 'FiniteElementCollection:')
        if (word == 'FiniteElementCollection:') call next_word(text, word)
      case ('VDim:')
        call next_integer(text, 'the dimension', dimension, error)
      case ('Ordering:')
        call next_count(text, 'the ordering', ordering, error)
      case default
        call fail_in_file(text, 'expected ''FiniteElementSpace'', found '//quoted(word), error)
      end select
      if (allocated(error)) return
    end do
    if (dimension /= 3 .or. ordering > 1) then
      call fail_in_file(text, 'expected VDim 3 and Ordering 0 or 1, found VDim ' &
                        //to_text(dimension)//' and Ordering '//to_text(ordering), error)
      return
    end if
    do i = 1, merge(n, 3, ordering == 1)
      if (ordering == 1) then
        call next_reals(text, 'a coordinate', mfem%x(:, i), error)
      else
        call next_reals(text, 'a coordinate', mfem%x(i, :), error)
      end if
      if (allocated(error)) return
    end do
  end subroutine read_points

  !> Find the number of points before those of each edge, face and element.
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
    if (total > len(text%all)) then
      call fail_in_file(text, 'the file is too short for its '//to_text(total)//' control points', &
                        error)
    end if
  end subroutine number_points

  !> Find the number of control points of an element in each direction.
  subroutine directions(text, mfem, e, n, error)
    type(text_t), intent(in) :: text
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: e
    integer, intent(out) :: n(3)
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i

    do d = 1, 3
      i = find_edge(mfem, mfem%vertex(1, e), mfem%vertex(NEIGHBOUR(d), e))
      if (i == 0) then
        call fail_in_file(text, 'element '//to_text(e) &
                          //' has an edge that the section ''edges'' does not list', error)
        return
      end if
      n(d) = nfunction(mfem%dir(mfem%edge(1, i) + 1))
    end do
  end subroutine directions

  !> The edge between two vertices; 0 if there is none.
  pure integer function find_edge(mfem, a, b) result(i)
    type(mfem_t), intent(in) :: mfem
    integer, intent(in) :: a, b

    do i = 1, size(mfem%edge, 2)
      if (mfem%edge(2, i) == a .and. mfem%edge(3, i) == b) return
      if (mfem%edge(2, i) == b .and. mfem%edge(3, i) == a) return
    end do
    i = 0
  end function find_edge

  !> The face that has the four given vertices, in any order; 0 if there is none.
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

  !> Find the number of the control point (i,j,k) of an element.
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
        i = find_edge(mfem, vertex(local(1) + 1), vertex(local(2) + 1))
        if (i == 0) then
          call fail_in_file(text, 'element '//to_text(e) &
                            //' has an edge that the section ''edges'' does not list', error)
          return
        else if (nfunction(mfem%dir(mfem%edge(1, i) + 1)) /= n(axis(local(1), local(2)))) then
          call fail_in_file(text, 'opposite edges of element '//to_text(e) &
                            //' have different numbers of control points', error)
          return
        end if
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

    !> Index of the point among the inner points from vertex p to vertex q, from 1.
    pure integer function inner_index(p, q)
      integer, intent(in) :: p, q
      integer :: d

      d = axis(p, q)
      inner_index = merge(ijk(d) - 1, n(d) - ijk(d), CORNER(d, p) == 0)
    end function inner_index

  end subroutine find_point

end module format_mfem
