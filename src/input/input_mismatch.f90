!> Finds element faces that share nodes but not functions, such as a quadratic face and linear ones.
!! Their displacements agree at the common nodes only, and stresses near such faces are wrong. If
!! two such faces share only their corners, nothing holds the other nodes, and the body is far too
!! soft.
module input_mismatch
  use base_error, only: place_t
  use base_kinds, only: i8
  use base_log, only: warn
  use base_sort, only: hash, sort_index, unique
  use base_text, only: to_text
  use constraint, only: slave_marks
  use element_type, only: cell_t, topology_t
  use input_draft, only: draft_t
  use mesh, only: mesh_t, block_cell, is_rigid
  implicit none
  private
  public :: warn_mismatch

  integer, parameter :: MOST = 9 !! largest number of nodes of a face

  !> Faces of elements.
  type :: faces_t
    integer :: n = 0
    integer, allocatable :: block(:), elem(:) !! (n) block and element of each face
    integer, allocatable :: node(:, :)        !! (MOST, n) nodes in ascending order, then zeros
    logical, allocatable :: corner(:, :)      !! (MOST, n) is the node a corner?
    integer, allocatable :: first(:), at(:)   !! faces of each node: at(first(i):first(i + 1) - 1)
  end type faces_t

  !> Faces of one kind that do not match.
  type :: mismatch_t
    integer :: n = 0 !! number of larger faces
    integer :: larger = 0, smaller = 0 !! the first larger face, and a smaller one that has some of
    !! its nodes and no others
  end type mismatch_t

contains

  !> Warn about faces that have all nodes of another face and further nodes. Pairs of bodies that
  !! another warning has named are skipped, and so are faces with nodes that a constraint holds.
  subroutine warn_mismatch(draft, mesh, told)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: told(:, :)    !! (nbody, nbody) pairs of bodies a < b
    type(faces_t) :: faces
    type(mismatch_t) :: hanging, unequal ! faces with hanging nodes; other faces
    logical :: hangs(mesh%nnode), held(mesh%nnode), loose(MOST)
    integer :: f, g

    if (.not. has_different_faces(mesh)) return
    held = .false.
    if (mesh%constraint%n > 0) held = slave_marks(mesh%constraint, mesh%nnode) > 0
    call gather_faces(mesh, held, faces)
    hangs = .false.
    do f = 1, faces%n
      call find_parts(mesh, faces, told, f, g, loose)
      if (g == 0) cycle
      if (any(loose .and. .not. faces%corner(:, f)) &
          .and. .not. any(loose .and. faces%corner(:, f))) then
        hangs(pack(faces%node(:, f), loose)) = .true.
        call count_face(f, g, hanging)
      else
        call count_face(f, g, unequal)
      end if
    end do
    if (hanging%n > 0) then
      call warn(text_of(mesh, faces, hanging)//' elements only at corners, so that the nodes ' &
                //'between these corners (number: '//to_text(count(hangs))//') are not joined', &
                place_of(draft, mesh, faces, hanging), 'the faces come apart between their ' &
                //'corners: use elements of one degree, or bodies joined by CONTact with COHEsive')
    end if
    if (unequal%n > 0) then
      call warn(text_of(mesh, faces, unequal)//' elements that do not match them', &
                place_of(draft, mesh, faces, unequal), 'displacements agree only at the nodes, ' &
                //'and stresses near these faces are wrong: use elements whose faces have ' &
                //'the same nodes, or join the bodies by CONTact with COHEsive')
    end if
  end subroutine warn_mismatch

  !> Count a face that does not match.
  pure subroutine count_face(f, g, mismatch)
    integer, intent(in) :: f, g !! the larger face, and one that is a part of it
    type(mismatch_t), intent(inout) :: mismatch

    mismatch%n = mismatch%n + 1
    if (mismatch%n > 1) return
    mismatch%larger = f
    mismatch%smaller = g
  end subroutine count_face

  !> The beginning of a warning, such as: 4 faces of Q2 elements meet faces of Q1
  function text_of(mesh, faces, mismatch) result(text)
    type(mesh_t), intent(in) :: mesh
    type(faces_t), intent(in) :: faces
    type(mismatch_t), intent(in) :: mismatch
    character(:), allocatable :: text

    text = to_text(mismatch%n)//' faces of '
    if (mismatch%n == 1) text = '1 face of '
    text = text//trim(mesh%block(faces%block(mismatch%larger))%name)//' elements ' &
           //trim(merge('meets', 'meet ', mismatch%n == 1))//' faces of ' &
           //trim(mesh%block(faces%block(mismatch%smaller))%name)
  end function text_of

  !> The place in the deck of the first face that does not match.
  function place_of(draft, mesh, faces, mismatch) result(place)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(faces_t), intent(in) :: faces
    type(mismatch_t), intent(in) :: mismatch
    type(place_t) :: place

    associate (block => mesh%block(faces%block(mismatch%larger)), &
               e => faces%elem(mismatch%larger))
      if (block%body > 0) then
        place = mesh%body(block%body)%place
      else
        place = draft%places%at(draft%elements%place(block%number(e)))
      end if
    end associate
  end function place_of

  !> Are there element faces with different numbers of nodes?
  logical function has_different_faces(mesh) result(different)
    type(mesh_t), intent(in) :: mesh
    type(topology_t) :: topology
    integer, allocatable :: node(:)
    integer :: b, f, i, n

    different = .false.
    n = 0
    do b = 1, size(mesh%block)
      if (.not. set_topology(mesh, b, topology)) cycle
      do f = 1, topology%nface
        node = topology%node(topology%first(f):topology%first(f + 1) - 1)
        if (count([(any(topology%corner == node(i)), i=1, size(node))]) < 3) cycle
        if (n == 0) n = size(node)
        different = different .or. size(node) /= n
      end do
    end do
  end function has_different_faces

  !> Get the faces of a block. The result is .false. for rigid bodies and for splines, whose
  !! functions do not belong to nodes; their faces are not examined.
  logical function set_topology(mesh, b, topology) result(examined)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b
    type(topology_t), intent(out) :: topology
    type(cell_t) :: cell

    associate (block => mesh%block(b))
      examined = .not. (is_rigid(block) .or. block%row%spline .or. block%nelem == 0)
      if (.not. examined) return
      call block_cell(block, 1, cell)
      call block%row%topology(cell, topology)
      examined = allocated(topology%corner)
    end associate
  end function set_topology

  !> Gather the faces that no other element shares with the same nodes and that have no node held by
  !! a constraint.
  subroutine gather_faces(mesh, held, faces)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: held(:)       !! (nnode)
    type(faces_t), intent(out) :: faces
    type(topology_t) :: topology
    type(faces_t) :: all_faces
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), node(:)
    logical, allocatable :: single(:), corner(:)
    integer :: b, e, f, i, j, n

    n = 6*sum(mesh%block%nelem)
    allocate (all_faces%block(n), all_faces%elem(n), key(n))
    allocate (all_faces%node(MOST, n), source=0)
    allocate (all_faces%corner(MOST, n), source=.false.)
    n = 0
    do b = 1, size(mesh%block)
      if (.not. set_topology(mesh, b, topology)) cycle
      associate (conn => mesh%block(b)%conn)
        do e = 1, mesh%block(b)%nelem
          do f = 1, topology%nface
            node = unique(conn(topology%node(topology%first(f):topology%first(f + 1) - 1), e))
            corner = [(any(conn(topology%corner, e) == node(i)), i=1, size(node))]
            if (count(corner) < 3 .or. any(held(node))) cycle ! collapsed, or held by a constraint
            n = n + 1
            all_faces%block(n) = b
            all_faces%elem(n) = e
            all_faces%node(:size(node), n) = node
            all_faces%corner(:size(node), n) = corner
            key(n) = hash(node)
          end do
        end do
      end associate
    end do
    allocate (order(n))
    allocate (single(n), source=.true.)
    call sort_index(key(:n), order)
    do i = 2, n
      do j = i - 1, 1, -1
        if (key(order(j)) /= key(order(i))) exit
        if (all(all_faces%node(:, order(j)) == all_faces%node(:, order(i)))) then
          single(order([i, j])) = .false.
        end if
      end do
    end do
    order = pack([(i, i=1, n)], single)
    faces%n = size(order)
    faces%block = all_faces%block(order)
    faces%elem = all_faces%elem(order)
    faces%node = all_faces%node(:, order)
    faces%corner = all_faces%corner(:, order)
    call list_faces(mesh%nnode, faces)
  end subroutine gather_faces

  !> List the faces of each node.
  pure subroutine list_faces(nnode, faces)
    integer, intent(in) :: nnode
    type(faces_t), intent(inout) :: faces
    integer :: f, i, n

    allocate (faces%first(nnode + 2), source=0)
    allocate (faces%at(count(faces%node > 0)))
    do f = 1, faces%n
      do i = 1, count(faces%node(:, f) > 0)
        n = faces%node(i, f) + 2
        faces%first(n) = faces%first(n) + 1
      end do
    end do
    faces%first(:2) = 1
    do n = 3, size(faces%first)
      faces%first(n) = faces%first(n) + faces%first(n - 1)
    end do
    do f = 1, faces%n
      do i = 1, count(faces%node(:, f) > 0)
        n = faces%node(i, f) + 1
        faces%at(faces%first(n)) = f
        faces%first(n) = faces%first(n) + 1
      end do
    end do
  end subroutine list_faces

  !> Find the faces of other elements that have some of the nodes of face f and no others.
  subroutine find_parts(mesh, faces, told, f, part, loose)
    type(mesh_t), intent(in) :: mesh
    type(faces_t), intent(in) :: faces
    logical, intent(in) :: told(:, :)
    integer, intent(in) :: f
    integer, intent(out) :: part         !! one of these faces; 0: there is none
    logical, intent(out) :: loose(MOST)  !! nodes of face f that belong to none of these faces
    integer :: g, i, j, k, n

    part = 0
    n = count(faces%node(:, f) > 0)
    loose = [(i <= n, i=1, MOST)]
    do i = 1, n
      do j = faces%first(faces%node(i, f)), faces%first(faces%node(i, f) + 1) - 1
        g = faces%at(j)
        if (faces%node(1, g) /= faces%node(i, f)) cycle ! examine each face once
        if (count(faces%node(:, g) > 0) >= n) cycle
        if (faces%block(f) == faces%block(g) .and. faces%elem(f) == faces%elem(g)) cycle
        if (any([(all(faces%node(:n, f) /= faces%node(k, g)), &
                  k=1, count(faces%node(:, g) > 0))])) cycle
        associate (a => mesh%block(faces%block(f))%body, b => mesh%block(faces%block(g))%body)
          if (a > 0 .and. b > 0) then
            if (told(min(a, b), max(a, b))) cycle
          end if
        end associate
        part = g
        do k = 1, n
          if (any(faces%node(:, g) == faces%node(k, f))) loose(k) = .false.
        end do
      end do
    end do
  end subroutine find_parts

end module input_mismatch
