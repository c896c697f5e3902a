!> The mesh: nodes, blocks of elements, spline patches and named surfaces.
!!
!! The blocks of rigid bodies have faces and appear in result files, but have neither stiffness nor
!! material.
module mesh
  use base_error, only: place_t
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use constraint, only: constraint_t
  use element_type, only: element_t, cell_t, rule_t
  implicit none
  private
  public :: mesh_t, block_t, operator_t, body_t, body_face_t, group_t, block_cell, append_nodes, &
            append_blocks, append_body, is_rigid, solid_nodes, mark_rigid, place_origin, &
            body_faces, body_boundary, ALL_FACES, INSIDE

  !> Bezier extraction operator of one knot span, or of a whole surface element.
  type :: operator_t
    real(wp), allocatable :: c(:, :) !! (functions, Bernstein polynomials): N = C B
  end type operator_t

  !> Spline data of a block: each distinct operator is stored once.
  type :: extraction_t
    integer :: degree(3) = 1
    type(operator_t), allocatable :: op(:)  !! distinct operators; not allocated: Lagrange functions
    integer, allocatable :: iop(:, :)       !! (3, nelem) operator of each direction; 0: none
    real(wp), allocatable :: w(:, :)        !! (ncp, nelem) weights; not allocated: all one
    !> Distinct operators of whole surface elements (cell%c), and the index of the operator of each
    !! element; not allocated if there are none.
    type(operator_t), allocatable :: surface(:)
    integer, allocatable :: isurface(:)     !! (nelem)
  end type extraction_t

  !> Elements with the same type, material and number of nodes.
  type :: block_t
    character(16) :: name = ''     !! as reported: Q1, Q1E9, Q1N2.1, IGA2, ...
    type(element_t) :: row
    integer :: material = 0        !! index into the model's materials
    integer :: body = 0            !! index into mesh%body; 0: a FEAP mesh
    integer :: nen = 0, nelem = 0
    integer, allocatable :: conn(:, :) !! (nen, nelem) nodes; a collapsed prism repeats some of them
    integer, allocatable :: number(:)    !! (nelem) number of the element as shown to the user
    type(extraction_t) :: ext
    type(rule_t) :: rule
    type(basis_t), allocatable :: basis(:) !! functions of each class of elements (model_basis)
    integer, allocatable :: ibasis(:)      !! (nelem) class of each element
    !> (6, nelem) faces of a body that do not bound it (mesh_seam); not allocated: none.
    logical, allocatable :: inner(:, :)
  end type block_t

  !> One face of a body: the element faces that make it up.
  type :: body_face_t
    integer, allocatable :: block(:)   !! block of each element face
    integer, allocatable :: elem(:)    !! element in the block
    integer, allocatable :: side(:)    !! local face of that element (element_type, topology_t)
    real(wp) :: deviation = 0.0_wp     !! largest distance from the geometry of a patch [L]
  end type body_face_t

  !> A named set of a mesh file.
  type :: group_t
    character(:), allocatable :: name
    integer, allocatable :: node(:)    !! nodes, in ascending order
    type(body_face_t) :: face          !! element faces of the set on the boundary; may be none
    integer :: inner = 0               !! number of surface elements of the set inside the body
  end type group_t

  !> A body made by PATCh, MESH or SPLIne. Its faces 1 to 6 are called 1- 1+ 2- 2+ 3- 3+ in the
  !! deck.
  type :: body_t
    character(:), allocatable :: name
    type(place_t) :: place
    integer, allocatable :: node(:)    !! nodes and control points of the body
    integer, allocatable :: mask(:)    !! bit f-1 is set if node(i) lies on face f; bit INSIDE
    type(body_face_t) :: face(6)       !! the six faces; face 1 of a mesh is its whole boundary
    type(group_t), allocatable :: group(:) !! sets of a mesh or spline; not allocated: a patch
    integer, allocatable :: label(:)   !! (size(node)) mesh: node numbers in the file, ascending
    real(wp) :: thickness = 0.0_wp     !! mesh: 2 (volume)/(surface area) [L]
    character(:), allocatable :: note  !! mesh: summary of the file
  end type body_t

  !> The nodes, and the blocks, bodies and constraints that refer to them.
  type :: mesh_t
    integer :: nnode = 0
    real(wp), allocatable :: xr(:, :) !! (3, nnode) reference positions of nodes and control points
    !! [L]
    !> The origin to which contact refers positions [L]. If the model is far from zero, this is its
    !! centre, because the rounding error of a position grows with its distance from the origin;
    !! otherwise it is zero.
    real(wp) :: origin(3) = 0.0_wp
    logical, allocatable :: is_control(:) !! (nnode) the node is a control point of a spline
    logical, allocatable :: used(:)        !! (nnode) the node belongs to an element
    type(block_t), allocatable :: block(:)
    type(body_t), allocatable :: body(:)
    type(constraint_t) :: constraint       !! hanging nodes
  end type mesh_t

  !> A model is far from zero if the distance of its centre from zero exceeds its extent by this
  !! factor.
  real(wp), parameter :: FAR_AWAY = 100.0_wp

  integer, parameter :: ALL_FACES = 63 !! mask of all faces of a body
  !> Bit of body%mask: the node lies on faces of the body, but none of them bounds it.
  integer, parameter :: INSIDE = 6

contains

  !> Place the origin of contact at the centre of a mesh that is far from zero.
  pure subroutine place_origin(mesh)
    type(mesh_t), intent(inout) :: mesh
    real(wp) :: high(3), low(3)

    mesh%origin = 0.0_wp
    if (mesh%nnode == 0) return
    high = maxval(mesh%xr, 2)
    low = minval(mesh%xr, 2)
    if (norm2(high + low)/2 > FAR_AWAY*norm2(high - low)) mesh%origin = (high + low)/2
  end subroutine place_origin

  !> Set the cell to the degrees, operators and weights of element e of a block.
  subroutine block_cell(block, e, cell)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    type(cell_t), intent(out) :: cell

    cell%degree = block%ext%degree
    if (allocated(block%ext%op)) then
      if (block%ext%iop(1, e) > 0) allocate (cell%c1, source=block%ext%op(block%ext%iop(1, e))%c)
      if (block%ext%iop(2, e) > 0) allocate (cell%c2, source=block%ext%op(block%ext%iop(2, e))%c)
      if (block%ext%iop(3, e) > 0) allocate (cell%c3, source=block%ext%op(block%ext%iop(3, e))%c)
    end if
    if (allocated(block%ext%surface)) then
      allocate (cell%c, source=block%ext%surface(block%ext%isurface(e))%c)
    end if
    if (allocated(block%ext%w)) cell%w = block%ext%w(:, e)
  end subroutine block_cell

  !> Append nodes of elements to the nodes of the mesh.
  subroutine append_nodes(mesh, xr, is_control)
    type(mesh_t), intent(inout) :: mesh
    real(wp), intent(in) :: xr(:, :)       !! (3, n) [L]
    logical, intent(in) :: is_control(:)   !! (n)
    real(wp), allocatable :: all_xr(:, :)
    logical, allocatable :: all_control(:), all_used(:)
    integer :: n, m

    n = mesh%nnode
    m = size(is_control)
    allocate (all_xr(3, n + m), all_control(n + m), all_used(n + m))
    if (n > 0) then
      all_xr(:, :n) = mesh%xr(:, :n)
      all_control(:n) = mesh%is_control(:n)
      all_used(:n) = mesh%used(:n)
    end if
    all_xr(:, n + 1:) = xr
    all_control(n + 1:) = is_control
    all_used(n + 1:) = .true.
    call move_alloc(all_xr, mesh%xr)
    call move_alloc(all_control, mesh%is_control)
    call move_alloc(all_used, mesh%used)
    mesh%nnode = n + m
  end subroutine append_nodes

  !> Append blocks to a list, which may be unallocated.
  subroutine append_blocks(list, block)
    type(block_t), allocatable, intent(inout) :: list(:)
    type(block_t), intent(in) :: block(:)
    type(block_t), allocatable :: longer(:)
    integer :: i, n

    n = 0
    if (allocated(list)) n = size(list)
    allocate (longer(n + size(block)))
    do i = 1, n
      longer(i) = list(i)
    end do
    do i = 1, size(block)
      longer(n + i) = block(i)
    end do
    call move_alloc(longer, list)
  end subroutine append_blocks

  subroutine append_body(mesh, body)
    type(mesh_t), intent(inout) :: mesh
    type(body_t), intent(in) :: body

    if (.not. allocated(mesh%body)) allocate (mesh%body(0))
    mesh%body = [mesh%body, body]
  end subroutine append_body

  !> List the element faces of those faces of a body that a mask chooses.
  pure subroutine body_faces(mesh, b, mask, block, elem, side)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b               !! index of the body
    integer, intent(in) :: mask            !! bit f-1 for each face f
    integer, allocatable, intent(out) :: block(:), elem(:), side(:) !! as in body_face_t
    integer :: f

    allocate (block(0), elem(0), side(0))
    do f = 1, 6
      if (.not. btest(mask, f - 1)) cycle
      associate (face => mesh%body(b)%face(f))
        block = [block, face%block]
        elem = [elem, face%elem]
        side = [side, face%side]
      end associate
    end do
  end subroutine body_faces

  !> List all faces of a body except those inside it.
  pure subroutine body_boundary(mesh, b, block, elem, side)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b               !! index of the body
    integer, allocatable, intent(out) :: block(:), elem(:), side(:) !! as in body_face_t
    logical, allocatable :: bounds(:)
    integer :: f

    call body_faces(mesh, b, ALL_FACES, block, elem, side)
    allocate (bounds(size(elem)), source=.true.)
    do f = 1, size(elem)
      associate (list => mesh%block(block(f)))
        if (allocated(list%inner)) bounds(f) = .not. list%inner(side(f), elem(f))
      end associate
    end do
    block = pack(block, bounds)
    elem = pack(elem, bounds)
    side = pack(side, bounds)
  end subroutine body_boundary

  !> Does the block belong to a rigid body, whose elements have no unknowns?
  elemental logical function is_rigid(block)
    type(block_t), intent(in) :: block

    is_rigid = .not. (associated(block%row%form) .or. associated(block%row%form_batch))
  end function is_rigid

  !> Mark the nodes of all elements except those of rigid bodies, which have no unknowns.
  pure subroutine solid_nodes(mesh, solid)
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: solid(:) !! (nnode)
    integer :: b, e

    allocate (solid(mesh%nnode), source=.false.)
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        solid(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
  end subroutine solid_nodes

  !> Mark the nodes that belong to rigid bodies only.
  pure subroutine mark_rigid(mesh, rigid)
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: rigid(:) !! (nnode)
    logical, allocatable :: solid(:)
    integer :: b, e

    call solid_nodes(mesh, solid)
    allocate (rigid(mesh%nnode), source=.false.)
    do b = 1, size(mesh%block)
      if (.not. is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        rigid(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
    rigid = rigid .and. .not. solid
  end subroutine mark_rigid

end module mesh
