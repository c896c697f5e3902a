!> Outer faces of all elements. The outer faces of bodies are already known, except those between
!! two materials of one MESH. For elements that belong to no body (BLOCk, ELEMents), a face is an
!! outer face unless another one of these elements has a face with the same corners.
module mesh_boundary
  use base_kinds, only: i8
  use base_sort, only: hash, sort_index, unique
  use element_type, only: cell_t, topology_t
  use mesh, only: mesh_t, block_cell, body_boundary, is_rigid
  implicit none
  private
  public :: find_outer_faces

  integer, parameter :: MOST = 4 !! largest number of corners of a face

contains

  !> Find the outer faces of all elements; those of bodies come last.
  subroutine find_outer_faces(mesh, block, elem, side, by_material)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: block(:), elem(:), side(:) !! as in body_face_t
    logical, intent(in), optional :: by_material !! faces between two materials are outer faces too
    integer, allocatable :: corner(:, :) ! (MOST, n) in ascending order; a triangle begins with 0
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), node(:), own_block(:), own_elem(:), own_side(:)
    logical, allocatable :: outer(:)
    logical :: searched(size(mesh%block)) ! the others have known outer faces only
    type(topology_t) :: topology
    type(cell_t) :: cell
    integer :: b, e, f, i, j, n

    searched = mesh%block%body == 0
    if (present(by_material)) then
      if (by_material) call add_mixed(mesh, searched)
    end if
    n = 6*sum([(mesh%block(b)%nelem, b=1, size(mesh%block))], searched)
    allocate (block(n), elem(n), side(n), corner(MOST, n), key(n))
    n = 0
    do b = 1, size(mesh%block)
      associate (set => mesh%block(b))
        if (set%nelem == 0 .or. .not. searched(b)) cycle
        call block_cell(set, 1, cell)
        call set%row%topology(cell, topology)
        do e = 1, set%nelem
          do f = 1, topology%nface
            node = topology%node(topology%first(f):topology%first(f + 1) - 1)
            node = pack(node, [(any(topology%corner == node(i)), i=1, size(node))])
            node = unique(set%conn(node, e))
            if (size(node) < 3) cycle ! the face is collapsed
            n = n + 1
            block(n) = b
            elem(n) = e
            side(n) = f
            corner(:, n) = 0
            corner(MOST - size(node) + 1:, n) = node
            key(n) = hash(node)
          end do
        end do
      end associate
    end do
    allocate (order(n), outer(n))
    outer = mesh%block(block(:n))%body == 0
    call sort_index(key(:n), order)
    do i = 2, n
      do j = i - 1, 1, -1
        if (key(order(j)) /= key(order(i))) exit
        if (any(corner(:, order(j)) /= corner(:, order(i)))) cycle
        if (present(by_material)) then
          if (by_material .and. mesh%block(block(order(i)))%material &
              /= mesh%block(block(order(j)))%material) then
            outer(order([i, j])) = .true.
            cycle
          end if
        end if
        outer(order([i, j])) = .false.
      end do
    end do
    block = pack(block(:n), outer)
    elem = pack(elem(:n), outer)
    side = pack(side(:n), outer)
    do b = 1, size(mesh%body)
      call body_boundary(mesh, b, own_block, own_elem, own_side)
      block = [block, own_block]
      elem = [elem, own_elem]
      side = [side, own_side]
    end do
  end subroutine find_outer_faces

  !> Mark the blocks of bodies that consist of several materials.
  pure subroutine add_mixed(mesh, searched)
    type(mesh_t), intent(in) :: mesh
    logical, intent(inout) :: searched(:) !! (nblock)
    logical :: own(size(searched))
    integer :: b

    do b = 1, size(mesh%body)
      own = mesh%block%body == b .and. .not. is_rigid(mesh%block)
      if (maxval(mesh%block%material, own) > minval(mesh%block%material, own)) then
        searched = searched .or. own
      end if
    end do
  end subroutine add_mixed

end module mesh_boundary
