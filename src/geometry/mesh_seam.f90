!> Faces of a body that lie inside it. Where the body meets itself and its nodes are joined, by TIE
!! or because the control points of a closed patch are repeated, two faces with the same nodes lie
!! on each other. A side that has collapsed to an edge or a point has no area. Neither bounds the
!! body.
module mesh_seam
  use base_kinds, only: i8, wp
  use base_sort, only: hash, sort_index, unique
  use element_type, only: cell_t, topology_t
  use face_rule, only: face_normal, face_points
  use mesh, only: INSIDE, body_boundary, body_face_t, block_cell, group_t, mesh_t
  implicit none
  private
  public :: leave_inner_faces

  real(wp), parameter :: FLAT = 1.0e-9_wp !! a smaller area is zero, relative to the squared extent
  real(wp), parameter :: NEAR = 0.01_wp   !! largest distance between the centroids of faces that
  !! lie on each other, relative to the root of their area

  !> What is compared of a face.
  type :: size_t
    real(wp) :: area = 0.0_wp         !! [L^2]
    real(wp) :: centroid(3) = 0.0_wp  !! [L]
    real(wp) :: normal(3) = 0.0_wp    !! integral of the outward normal [L^2]
  end type size_t

contains

  !> Mark the faces inside each body and the nodes that only they contain, once all nodes are
  !! joined.
  subroutine leave_inner_faces(mesh)
    type(mesh_t), intent(inout) :: mesh
    type(body_face_t) :: face ! all faces of a body
    logical, allocatable :: inner(:)
    type(size_t) :: size_of
    real(wp) :: area(2)       ! of all faces, and of those on the boundary [L^2]
    integer :: b, f, g

    do b = 1, size(mesh%body)
      call body_boundary(mesh, b, face%block, face%elem, face%side)
      call find_inner(mesh, face, inner)
      if (.not. any(inner)) cycle
      call mark_nodes(mesh, face, inner, b)
      area = 0.0_wp
      do f = 1, size(inner)
        size_of = face_size(mesh, face, f)
        associate (block => mesh%block(face%block(f)))
          if (.not. allocated(block%inner)) allocate (block%inner(6, block%nelem), source=.false.)
          if (inner(f)) block%inner(face%side(f), face%elem(f)) = .true.
          area = area + [size_of%area, merge(0.0_wp, size_of%area, inner(f))]
        end associate
      end do
      associate (body => mesh%body(b))
        if (area(2) > 0.0_wp) body%thickness = body%thickness*area(1)/area(2)
        if (.not. allocated(body%group)) cycle
        do g = 1, size(body%group)
          call leave_inner(mesh, body%group(g))
        end do
      end associate
    end do
  end subroutine leave_inner_faces

  !> Find the faces that lie on another one with the same nodes, or have no area. The nodes alone do
  !! not decide: the two elements of a closed surface may have the same ones.
  subroutine find_inner(mesh, face, inner)
    type(mesh_t), intent(in) :: mesh
    type(body_face_t), intent(in) :: face
    logical, allocatable, intent(out) :: inner(:)
    integer(i8) :: key(size(face%elem))
    integer :: order(size(face%elem)), i, j
    integer, allocatable :: node(:)

    allocate (inner(size(key)), source=.false.)
    do i = 1, size(key)
      node = face_nodes(mesh, face, i)
      key(i) = hash(unique(node))
      if (size(unique(node)) < size(node)) inner(i) = has_no_area(mesh, face, i, node)
    end do
    call sort_index(key, order)
    do i = 2, size(key)
      do j = i - 1, 1, -1
        if (key(order(j)) /= key(order(i))) exit
        if (.not. lie_on_each_other(mesh, face, order(i), order(j))) cycle
        inner(order([i, j])) = .true.
      end do
    end do
  end subroutine find_inner

  !> Nodes or control points of face f, in the order of its element.
  function face_nodes(mesh, face, f) result(node)
    type(mesh_t), intent(in) :: mesh
    type(body_face_t), intent(in) :: face
    integer, intent(in) :: f
    integer, allocatable :: node(:)
    type(topology_t) :: topology
    type(cell_t) :: cell

    associate (block => mesh%block(face%block(f)), e => face%elem(f), s => face%side(f))
      call block_cell(block, e, cell)
      call block%row%topology(cell, topology)
      node = block%conn(topology%node(topology%first(s):topology%first(s + 1) - 1), e)
    end associate
  end function face_nodes

  logical function has_no_area(mesh, face, f, node)
    type(mesh_t), intent(in) :: mesh
    type(body_face_t), intent(in) :: face
    integer, intent(in) :: f
    integer, intent(in) :: node(:)
    type(size_t) :: size_of

    size_of = face_size(mesh, face, f)
    associate (x => mesh%xr(:, node))
      has_no_area = .not. size_of%area > FLAT*sum((maxval(x, 2) - minval(x, 2))**2)
    end associate
  end function has_no_area

  !> Are two faces with equal keys the two sides of one surface?
  logical function lie_on_each_other(mesh, face, f, g) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(body_face_t), intent(in) :: face
    integer, intent(in) :: f, g
    integer, allocatable :: node(:), other(:)
    type(size_t) :: a, b

    allocate (node, source=unique(face_nodes(mesh, face, f)))
    allocate (other, source=unique(face_nodes(mesh, face, g)))
    yes = size(node) == size(other)
    if (yes) yes = all(node == other)
    if (.not. yes) return
    a = face_size(mesh, face, f)
    b = face_size(mesh, face, g)
    yes = norm2(a%centroid - b%centroid) <= NEAR*sqrt(a%area) .and. &
          dot_product(a%normal, b%normal) < 0.0_wp
  end function lie_on_each_other

  !> Measure face f.
  type(size_t) function face_size(mesh, face, f) result(size_of)
    type(mesh_t), intent(in) :: mesh
    type(body_face_t), intent(in) :: face
    integer, intent(in) :: f
    real(wp), parameter :: NONE(3, 1) = 0.0_wp
    type(cell_t) :: cell
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :), x(:, :)
    real(wp) :: part(3), ta(3), tb(3)
    integer :: q

    associate (block => mesh%block(face%block(f)), e => face%elem(f), s => face%side(f))
      allocate (shp(block%nen), dshp(3, block%nen))
      x = mesh%xr(:, block%conn(:, e))
      call block_cell(block, e, cell)
      call face_points(cell%degree, NONE, s, xi, w)
      do q = 1, size(w)
        call block%row%functions(cell, xi(:, q), shp, dshp)
        call face_normal(s, x, dshp, part, ta, tb)
        size_of%area = size_of%area + w(q)*norm2(part)
        size_of%normal = size_of%normal + w(q)*part
        size_of%centroid = size_of%centroid + w(q)*norm2(part)*matmul(x, shp)
      end do
    end associate
    if (size_of%area > 0.0_wp) size_of%centroid = size_of%centroid/size_of%area
  end function face_size

  !> Mark the nodes of a body that belong to faces inside it, but to none on its boundary.
  subroutine mark_nodes(mesh, face, inner, b)
    type(mesh_t), intent(inout) :: mesh
    type(body_face_t), intent(in) :: face
    logical, intent(in) :: inner(:)      !! (size(face%elem))
    integer, intent(in) :: b             !! the body
    logical, allocatable :: on(:), off(:)
    integer :: f, i

    allocate (on(mesh%nnode), off(mesh%nnode), source=.false.)
    do f = 1, size(inner)
      if (inner(f)) then
        off(face_nodes(mesh, face, f)) = .true.
      else
        on(face_nodes(mesh, face, f)) = .true.
      end if
    end do
    associate (body => mesh%body(b))
      do i = 1, size(body%node)
        if (on(body%node(i)) .or. .not. off(body%node(i))) cycle
        body%mask(i) = ibset(body%mask(i), INSIDE)
      end do
    end associate
  end subroutine mark_nodes

  !> Count the faces of a group that lie inside the body as such, and remove them from its faces.
  pure subroutine leave_inner(mesh, group)
    type(mesh_t), intent(in) :: mesh
    type(group_t), intent(inout) :: group
    logical :: keep(size(group%face%elem))
    integer :: f

    do f = 1, size(keep)
      associate (block => mesh%block(group%face%block(f)))
        keep(f) = .true.
        if (allocated(block%inner)) keep(f) = .not. block%inner(group%face%side(f), &
                                                                group%face%elem(f))
      end associate
    end do
    group%inner = group%inner + count(.not. keep)
    group%face%block = pack(group%face%block, keep)
    group%face%elem = pack(group%face%elem, keep)
    group%face%side = pack(group%face%side, keep)
  end subroutine leave_inner

end module mesh_seam
