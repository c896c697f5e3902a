!> Faces of a body that are joined with each other, by TIE or because they have the same nodes from
!! the start (a closed ring). They lie inside the body, so that ALL does not contain them.
module input_seam
  use base_grow, only: grow
  use base_kinds, only: i8
  use base_sort, only: hash, sort_index, unique
  use element_type, only: cell_t, topology_t
  use mesh, only: mesh_t, block_cell
  implicit none
  private
  public :: find_seam, face_nodes

contains

  !> Mark those of some faces of a body that have the same nodes as another face of this body, or
  !! have collapsed to less than three nodes.
  subroutine find_seam(mesh, body, block, elem, side, yes)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body
    integer, intent(in) :: block(:), elem(:), side(:) !! as in body_face_t
    logical, allocatable, intent(out) :: yes(:)
    integer, allocatable :: first(:), list(:) ! where the nodes of each face begin, and these nodes
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:)
    integer :: f, given, i, j, last, n, same

    given = size(elem)
    n = given + sum([(size(mesh%body(body)%face(f)%elem), f=1, 6)])
    allocate (yes(given), source=.false.)
    ! A SPLIne has only the face 3-; several of its elements may have the same control points.
    if (n - given == size(mesh%body(body)%face(5)%elem)) return
    allocate (key(n), order(n), first(n + 1), list(0))
    first(1) = 1
    n = 0
    do i = 1, given
      call add(block(i), elem(i), side(i))
      yes(i) = first(n + 1) - first(n) < 3
    end do
    do f = 1, 6
      associate (face => mesh%body(body)%face(f))
        do i = 1, size(face%elem)
          call add(face%block(i), face%elem(i), face%side(i))
        end do
      end associate
    end do
    call sort_index(key, order)
    last = 0
    do while (last < n)
      i = last + 1
      do last = i, n - 1
        if (key(order(last + 1)) /= key(order(i))) exit
      end do
      do f = i, last
        if (order(f) > given) cycle
        same = 0 ! faces of the body with these nodes, one of which is the given face itself
        do j = i, last
          if (order(j) > given .and. equal(order(f), order(j))) same = same + 1
        end do
        if (same > 1) yes(order(f)) = .true.
      end do
    end do

  contains

    subroutine add(block, elem, side)
      integer, intent(in) :: block, elem, side
      integer, allocatable :: node(:)

      call face_nodes(mesh, block, elem, side, node)
      n = n + 1
      key(n) = hash(node)
      first(n + 1) = first(n) + size(node)
      call grow(list, first(n + 1) - 1)
      list(first(n):first(n + 1) - 1) = node
    end subroutine add

    !> Have two faces the same nodes? Different nodes may have the same key.
    pure logical function equal(one, other)
      integer, intent(in) :: one, other

      equal = first(one + 1) - first(one) == first(other + 1) - first(other)
      if (equal) equal = all(list(first(one):first(one + 1) - 1) &
                             == list(first(other):first(other + 1) - 1))
    end function equal

  end subroutine find_seam

  !> The different nodes of a face of an element, in ascending order.
  subroutine face_nodes(mesh, block, elem, side, node)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: block, elem, side
    integer, allocatable, intent(out) :: node(:)
    type(topology_t) :: topology
    type(cell_t) :: cell

    associate (set => mesh%block(block))
      call block_cell(set, 1, cell)
      call set%row%topology(cell, topology)
      associate (first => topology%first(side), last => topology%first(side + 1) - 1)
        node = unique(set%conn(topology%node(first:last), elem))
      end associate
    end associate
  end subroutine face_nodes

end module input_seam
