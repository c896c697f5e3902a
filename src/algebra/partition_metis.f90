!> Fill-reducing ordering of the equations by METIS.
!!
!! The graph has one vertex for each node with free dofs. This graph has about a third of the
!! vertices of the graph of the equations, and it keeps the dofs of a node together. Several Linux
!! distributions build MUMPS without METIS, and MUMPS then silently replaces METIS by another
!! ordering. Therefore the ordering is computed here and passed to MUMPS.
!! Source: Karypis and Kumar 1998 [bib: karypis1998], METIS_NodeND
module partition_metis
  use, intrinsic :: iso_c_binding, only: c_int, c_int32_t, c_int64_t, c_loc, c_null_ptr, c_ptr
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_system, only: hold_signals, let_signals_in
  use base_text, only: to_text
  use csr, only: block_matrix_t
  implicit none
  private
  public :: elimination_order

  integer, parameter :: METIS_OK = 1
  integer, parameter :: NOPTION = 40   !! METIS_NOPTIONS
  integer, parameter :: SMALLEST = 8   !! smaller graphs keep their order

  interface
    integer(c_int) function metis_nodend(nvtxs, xadj, adjncy, vwgt, options, perm, iperm) &
      bind(c, name='METIS_NodeND')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: nvtxs, xadj, adjncy, vwgt, options, perm, iperm
    end function metis_nodend

    integer(c_int) function metis_setdefaultoptions(options) bind(c, name='METIS_SetDefaultOptions')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: options
    end function metis_setdefaultoptions
  end interface

contains

  !> Find the position of every equation in the order of elimination.
  subroutine elimination_order(a, eq, order, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)               !! (3, nnode) equation numbers, 0: prescribed
    integer, allocatable, intent(out) :: order(:) !! (neq) order(i): position of equation i, from 1
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: vertex(:) !! (nnode) number of a node with free dofs, else 0
    integer, allocatable :: first(:), neighbour(:), place(:), node(:)
    integer :: i, n, next, nvertex, v

    allocate (vertex(size(eq, 2)), source=0)
    nvertex = 0
    do n = 1, size(eq, 2)
      if (all(eq(:, n) == 0)) cycle
      nvertex = nvertex + 1
      vertex(n) = nvertex
    end do
    call build_graph(a, vertex, nvertex, first, neighbour)
    call order_graph(nvertex, first, neighbour, place, error)
    if (allocated(error)) return
    allocate (node(nvertex))
    do n = 1, size(vertex)
      if (vertex(n) > 0) node(place(vertex(n)) + 1) = n
    end do
    allocate (order(count(eq > 0)))
    next = 0
    do v = 1, nvertex
      do i = 1, 3 ! the three dofs of a node are consecutive
        if (eq(i, node(v)) == 0) cycle
        next = next + 1
        order(eq(i, node(v))) = next
      end do
    end do
  end subroutine elimination_order

  !> Build the adjacency lists of the vertices, in both directions and without loops. Vertices are
  !! numbered from 0, as METIS expects.
  subroutine build_graph(a, vertex, nvertex, first, neighbour)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: vertex(:)
    integer, intent(in) :: nvertex
    integer, allocatable, intent(out) :: first(:)     !! (nvertex+1)
    integer, allocatable, intent(out) :: neighbour(:)
    integer, allocatable :: next(:)
    integer :: n, p, v, w

    allocate (first(nvertex + 1), next(nvertex))
    next = 0
    do n = 1, a%nnode
      do p = a%row(n), a%row(n + 1) - 1
        v = vertex(n)
        w = vertex(a%col(p))
        if (v == 0 .or. w == 0 .or. v == w) cycle
        next(v) = next(v) + 1
        if (a%symmetric) next(w) = next(w) + 1
      end do
    end do
    first(1) = 0
    do v = 1, nvertex
      first(v + 1) = first(v) + next(v)
      next(v) = first(v)
    end do
    allocate (neighbour(max(1, first(nvertex + 1))))
    do n = 1, a%nnode
      do p = a%row(n), a%row(n + 1) - 1
        v = vertex(n)
        w = vertex(a%col(p))
        if (v == 0 .or. w == 0 .or. v == w) cycle
        next(v) = next(v) + 1
        neighbour(next(v)) = w - 1
        if (.not. a%symmetric) cycle
        next(w) = next(w) + 1
        neighbour(next(w)) = v - 1
      end do
    end do
  end subroutine build_graph

  !> Find the position of each vertex in the order of elimination, from 0.
  subroutine order_graph(nvertex, first, neighbour, place, error)
    integer, intent(in) :: nvertex
    integer, intent(in) :: first(:), neighbour(:)
    integer, allocatable, intent(out) :: place(:) !! (nvertex)
    type(error_t), allocatable, intent(out) :: error
    integer :: v, status

    allocate (place(nvertex))
    if (nvertex < SMALLEST .or. first(nvertex + 1) == 0) then
      place = [(v - 1, v=1, nvertex)]
      return
    end if
    call hold_signals() ! METIS would catch a SIGTERM and return an error
    if (has_long_integers()) then
      call order_long(nvertex, first, neighbour, place, status)
    else
      call order_short(nvertex, first, neighbour, place, status)
    end if
    call let_signals_in()
    if (status == METIS_OK) return
    call fail(error, SYSTEM_ERROR, 'METIS_NodeND failed with status '//to_text(status), &
              hint='there may be too little memory')
  end subroutine order_graph

  !> Does METIS use integers of 64 bits, rather than 32? A library is built for one of the two
  !! sizes, and has no function that tells which. However, it fills an array of options, and the
  !! length of the filled part shows the size of its integers.
  logical function has_long_integers()
    integer(c_int32_t), target :: buffer(2*NOPTION)
    integer(c_int) :: status

    buffer = 0
    status = metis_setdefaultoptions(c_loc(buffer))
    has_long_integers = status == METIS_OK .and. buffer(2*NOPTION) /= 0
  end function has_long_integers

  subroutine order_short(nvertex, first, neighbour, place, status)
    integer, intent(in) :: nvertex, first(:), neighbour(:)
    integer, intent(out) :: place(:), status
    integer(c_int32_t), allocatable, target :: xadj(:), adjncy(:), perm(:), iperm(:)
    integer(c_int32_t), target :: n

    n = int(nvertex, c_int32_t)
    allocate (xadj(nvertex + 1), adjncy(size(neighbour)), perm(nvertex), iperm(nvertex))
    xadj(:) = int(first, c_int32_t)
    adjncy(:) = int(neighbour, c_int32_t)
    status = metis_nodend(c_loc(n), c_loc(xadj), c_loc(adjncy), c_null_ptr, c_null_ptr, &
                          c_loc(perm), c_loc(iperm))
    place(:) = int(iperm)
  end subroutine order_short

  subroutine order_long(nvertex, first, neighbour, place, status)
    integer, intent(in) :: nvertex, first(:), neighbour(:)
    integer, intent(out) :: place(:), status
    integer(c_int64_t), allocatable, target :: xadj(:), adjncy(:), perm(:), iperm(:)
    integer(c_int64_t), target :: n

    n = int(nvertex, c_int64_t)
    allocate (xadj(nvertex + 1), adjncy(size(neighbour)), perm(nvertex), iperm(nvertex))
    xadj(:) = int(first, c_int64_t)
    adjncy(:) = int(neighbour, c_int64_t)
    status = metis_nodend(c_loc(n), c_loc(xadj), c_loc(adjncy), c_null_ptr, c_null_ptr, &
                          c_loc(perm), c_loc(iperm))
    place(:) = int(iperm)
  end subroutine order_long

end module partition_metis
