!> A body while it is being meshed. Its nodes and blocks are numbered from 1 until append_draft adds
!! them to the end of the mesh.
module patch_draft
  use base_error, only: error_t, fail, DECK_ERROR
  use base_grow, only: grow
  use base_kinds, only: wp
  use bspline, only: spline_t, extraction
  use element_table, only: load_elements
  use element_type, only: element_t
  use mesh, only: mesh_t, block_t, body_t, body_face_t, operator_t, append_nodes, append_blocks, &
                  append_body
  use patch_spec, only: patch_spec_t
  implicit none
  private
  public :: draft_t, span_t, add_node, new_block, add_face, add_operators, append_draft, find_row

  !> A body under construction.
  type :: draft_t
    integer :: nnode = 0
    real(wp), allocatable :: xr(:, :)      !! (3, >= nnode) [L]
    logical, allocatable :: is_control(:)
    integer, allocatable :: mask(:)        !! bit f-1 is set if the node lies on face f
    type(block_t), allocatable :: block(:)
    type(operator_t), allocatable :: op(:) !! distinct extraction operators
    type(body_face_t) :: face(6)           !! element faces, of which nface are in use
    integer :: nface(6) = 0
  end type draft_t

  !> The elements of a spline in one direction.
  type :: span_t
    integer, allocatable :: first(:) !! (n) first function of each element
    integer, allocatable :: iop(:)   !! (n) extraction operator of each element, index into draft%op
  end type span_t

contains

  !> Append a node or control point.
  subroutine add_node(draft, x, is_control, mask, node)
    type(draft_t), intent(inout) :: draft
    real(wp), intent(in) :: x(3)
    logical, intent(in) :: is_control
    integer, intent(in) :: mask  !! bit f-1 is set if the node lies on face f
    integer, intent(out) :: node !! number of the node in the draft

    draft%nnode = draft%nnode + 1
    node = draft%nnode
    call grow(draft%xr, 3, node)
    call grow(draft%is_control, node)
    call grow(draft%mask, node)
    draft%xr(:, node) = x
    draft%is_control(node) = is_control
    draft%mask(node) = mask
  end subroutine add_node

  !> Append a block with room for nelem elements; `block%nelem` is the number of elements added so
  !! far.
  subroutine new_block(draft, spec, name, row, degree, nen, nelem, ib)
    type(draft_t), intent(inout) :: draft
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: name
    type(element_t), intent(in) :: row
    integer, intent(in) :: degree(3), nen, nelem
    integer, intent(out) :: ib !! number of the block in the draft
    type(block_t) :: empty

    call append_blocks(draft%block, [empty])
    ib = size(draft%block)
    associate (b => draft%block(ib))
      b%name = name
      b%row = row
      b%material = spec%material
      b%nen = nen
      b%ext%degree = degree
      allocate (b%conn(nen, nelem))
      if (row%spline) allocate (b%ext%iop(3, nelem), source=0)
    end associate
  end subroutine new_block

  !> Record that local face `side` of element e of block ib lies on face f.
  subroutine add_face(draft, f, ib, e, side)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: f, ib, e, side
    integer :: n

    associate (list => draft%face(f))
      n = draft%nface(f) + 1
      draft%nface(f) = n
      call grow(list%block, n)
      call grow(list%elem, n)
      call grow(list%side, n)
      list%block(n) = ib
      list%elem(n) = e
      list%side(n) = side
    end associate
  end subroutine add_face

  !> Add the extraction operators of a spline; equal ones are stored once.
  subroutine add_operators(draft, s, span)
    type(draft_t), intent(inout) :: draft
    type(spline_t), intent(in) :: s
    type(span_t), intent(out) :: span
    real(wp), parameter :: SAME = 16*epsilon(1.0_wp) ! smaller differences come from rounding
    real(wp), allocatable :: c(:, :, :)
    type(operator_t), allocatable :: list(:)
    integer :: e, i, n, p

    p = s%degree
    call extraction(s, c, span%first)
    allocate (span%iop(size(span%first)), source=0)
    n = 0
    if (allocated(draft%op)) n = size(draft%op)
    allocate (list(n + size(span%first)))
    do i = 1, n
      list(i)%c = draft%op(i)%c
    end do
    do e = 1, size(span%first)
      do i = n, 1, -1
        if (size(list(i)%c, 1) /= p + 1) cycle
        if (maxval(abs(list(i)%c - c(:, :, e))) > SAME) cycle
        span%iop(e) = i
        exit
      end do
      if (span%iop(e) > 0) cycle
      n = n + 1
      list(n)%c = c(:, :, e)
      span%iop(e) = n
    end do
    if (allocated(draft%op)) deallocate (draft%op)
    allocate (draft%op(n))
    do i = 1, n
      call move_alloc(list(i)%c, draft%op(i)%c)
    end do
  end subroutine add_operators

  !> Append the draft to the mesh.
  subroutine append_draft(draft, spec, mesh)
    type(draft_t), intent(inout) :: draft
    type(patch_spec_t), intent(in) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(body_t) :: body
    integer, allocatable :: new(:)
    integer :: i, f, ib, n, nblock, nbody, number

    nblock = 0
    if (allocated(mesh%block)) nblock = size(mesh%block)
    nbody = 0
    if (allocated(mesh%body)) nbody = size(mesh%body)
    number = 0
    do i = 1, nblock
      if (allocated(mesh%block(i)%number)) number = max(number, maxval([0, mesh%block(i)%number]))
    end do
    do ib = 1, size(draft%block)
      associate (b => draft%block(ib))
        b%body = nbody + 1
        b%conn = b%conn + mesh%nnode
        b%number = [(number + i, i=1, b%nelem)]
        number = number + b%nelem
        if (.not. allocated(b%ext%iop)) cycle
        new = [(0, i=0, size(draft%op))] ! the block gets only the operators that it uses
        n = 0
        do i = 1, size(draft%op)
          if (.not. any(b%ext%iop == i)) cycle
          n = n + 1
          new(i + 1) = n
        end do
        allocate (b%ext%op(n))
        do i = 1, size(draft%op)
          if (new(i + 1) > 0) allocate (b%ext%op(new(i + 1))%c, source=draft%op(i)%c)
        end do
        do i = 1, b%nelem
          b%ext%iop(:, i) = new(b%ext%iop(:, i) + 1)
        end do
      end associate
    end do
    body%name = spec%name
    body%place = spec%place
    body%node = [(mesh%nnode + i, i=1, draft%nnode)]
    allocate (body%mask, source=draft%mask(:draft%nnode))
    do f = 1, 6
      associate (list => draft%face(f), nface => draft%nface(f))
        if (.not. allocated(list%block)) allocate (list%block(0), list%elem(0), list%side(0))
        body%face(f)%block = list%block(:nface) + nblock
        body%face(f)%elem = list%elem(:nface)
        body%face(f)%side = list%side(:nface)
        body%face(f)%deviation = list%deviation
      end associate
    end do
    call append_blocks(mesh%block, draft%block)
    call append_body(mesh, body)
    call append_nodes(mesh, draft%xr(:, :draft%nnode), draft%is_control(:draft%nnode))
  end subroutine append_draft

  !> Find the row of an element type that a patch uses.
  subroutine find_row(spec, name, row, error)
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: name
    type(element_t), intent(out) :: row
    type(error_t), allocatable, intent(out) :: error
    type(element_t), allocatable :: table(:)
    integer :: i

    call load_elements(table)
    do i = 1, size(table)
      if (table(i)%name /= name) cycle
      row = table(i)
      return
    end do
    call fail(error, DECK_ERROR, "patch '"//spec%name//"' needs elements of type '"//trim(name) &
              //"', which this program does not have", spec%place)
  end subroutine find_row

end module patch_draft
