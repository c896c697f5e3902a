!> Faces of a body that are joined with each other, by TIE or because they have the same nodes from
!! the start (a closed ring). They lie inside the body, so that ALL does not contain them.
module input_seam
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
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), node(:)
    integer :: f, i, n, given

    given = size(elem)
    n = given + sum([(size(mesh%body(body)%face(f)%elem), f=1, 6)])
    allocate (yes(given), source=.false.)
    allocate (key(n), order(n))
    do i = 1, given
      call face_nodes(mesh, block(i), elem(i), side(i), node)
      key(i) = hash(node)
      yes(i) = size(node) < 3
    end do
    n = given
    do f = 1, 6
      associate (face => mesh%body(body)%face(f))
        do i = 1, size(face%elem)
          n = n + 1
          call face_nodes(mesh, face%block(i), face%elem(i), face%side(i), node)
          key(n) = hash(node)
        end do
      end associate
    end do
    call sort_index(key, order)
    i = 1
    do while (i <= n)
      f = i
      do while (f < n)
        if (key(order(f + 1)) /= key(order(i))) exit
        f = f + 1
      end do
      ! Each given face is among those of the body, too.
      if (count(order(i:f) > given) > 1) yes(pack(order(i:f), order(i:f) <= given)) = .true.
      i = f + 1
    end do
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
