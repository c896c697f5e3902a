!> From a mesh file to blocks, faces and named groups of a body.
module mesh_body
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use element_table, only: load_elements
  use element_type, only: element_t
  use mesh, only: mesh_t, block_t, body_t, append_nodes, append_blocks, append_body
  use mesh_check, only: check_shapes, check_elements
  use mesh_faces, only: faces_t, find_boundary
  use mesh_file, only: SHAPE, mark_solids
  use mesh_group, only: find_groups, group_named, group_hint, put_boundary
  use mesh_spec, only: mesh_spec_t
  use patch_placement, only: compose
  implicit none
  private
  public :: build_mesh

contains

  !> Append the body of a MESH to the mesh; on an error the mesh is as it was.
  subroutine build_mesh(spec, mesh, error)
    type(mesh_spec_t), intent(inout) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(element_t), allocatable :: rows(:)
    type(block_t), allocatable :: block(:)
    type(faces_t) :: faces
    type(body_t) :: body
    integer, allocatable :: material(:), place(:, :)
    real(wp) :: volume

    call pick_rows(spec, rows)
    call place_nodes(spec)
    call mark_solids(spec%file)
    call check_shapes(spec%file, rows, spec%text, error)
    if (.not. allocated(error)) call check_elements(spec%file, rows, spec%text, volume, error)
    if (.not. allocated(error)) call find_materials(spec, material, error)
    if (.not. allocated(error)) call find_boundary(spec%file, rows, spec%text, faces, error)
    if (allocated(error)) return
    call make_blocks(spec, rows, material, mesh, block, place)
    body%name = spec%spec%name
    body%place = spec%spec%place
    call put_boundary(spec%file, faces, rows, place, volume, mesh%nnode, body)
    call find_groups(spec%file, faces, place, mesh%nnode, body)
    call append(spec, block, body, mesh)
  end subroutine build_mesh

  !> The row of each shape of a file; TYPE chooses that of the hexahedra.
  subroutine pick_rows(spec, rows)
    type(mesh_spec_t), intent(in) :: spec
    type(element_t), allocatable, intent(out) :: rows(:)
    type(element_t), allocatable :: table(:)
    character(16) :: name
    integer :: s, r

    call load_elements(table)
    allocate (rows(size(SHAPE)))
    do s = 1, size(SHAPE)
      name = SHAPE(s)%row
      if (name == 'Q1' .and. spec%spec%type /= '') name = spec%spec%type
      do r = 1, size(table)
        if (table(r)%name == name) rows(s) = table(r)
      end do
    end do
  end subroutine pick_rows

  !> SCALe, ROTAte and TRANslate.
  subroutine place_nodes(spec)
    type(mesh_spec_t), intent(inout) :: spec
    real(wp) :: turn(3, 3), shift(3)
    integer :: n

    if (size(spec%spec%placement) == 0) return
    call compose(spec%spec%placement, turn, shift)
    do n = 1, spec%file%nnode
      spec%file%x(:, n) = matmul(turn, spec%file%x(:, n)) + shift
    end do
  end subroutine place_nodes

  !> Index of the material of each element; a later record wins.
  subroutine find_materials(spec, material, error)
    type(mesh_spec_t), intent(in) :: spec
    integer, allocatable, intent(out) :: material(:) !! (nelem)
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: chosen(:)
    integer :: e, i, m

    allocate (material(spec%file%nelem), source=0)
    do i = 1, size(spec%material)
      associate (set => spec%material(i), file => spec%file)
        if (.not. allocated(set%group)) then
          material = set%index
          cycle
        end if
        chosen = group_named(file, set%group)
        if (.not. any(chosen)) then
          call fail(error, DECK_ERROR, 'mesh '//quoted(spec%spec%name)//' has no group ' &
                    //quoted(set%group), set%group_place, group_hint(file, set%group))
          return
        end if
        do m = 1, file%nmember
          if (chosen(file%member(2, m))) material(file%member(1, m)) = set%index
        end do
      end associate
    end do
    do e = 1, spec%file%nelem
      if (material(e) > 0 .or. .not. spec%file%solid(e)) cycle
      call fail(error, DECK_ERROR, 'element '//to_text(spec%file%label(e))//' of mesh ' &
                //quoted(spec%spec%name)//' has no material', spec%spec%place, &
                'its groups have none: give MATErial m for all elements first')
      return
    end do
  end subroutine find_materials

  !> A block for each shape and material.
  subroutine make_blocks(spec, rows, material, mesh, block, place)
    type(mesh_spec_t), intent(in) :: spec
    type(element_t), intent(in) :: rows(:)
    integer, intent(in) :: material(:)
    type(mesh_t), intent(in) :: mesh
    type(block_t), allocatable, intent(out) :: block(:)
    integer, allocatable, intent(out) :: place(:, :) !! (2, nelem) block of the mesh, element there
    integer, allocatable :: kind(:), index(:), number(:)
    integer :: b, e, i

    allocate (place(2, spec%file%nelem), source=0)
    allocate (kind(0), index(0), number(0))
    associate (file => spec%file)
      do e = 1, file%nelem
        if (.not. file%solid(e)) cycle
        do b = size(kind), 1, -1
          if (kind(b) == file%shape(e) .and. index(b) == material(e)) exit
        end do
        if (b == 0) then
          kind = [kind, file%shape(e)]
          index = [index, material(e)]
          number = [number, 0]
          b = size(kind)
        end if
        number(b) = number(b) + 1
        place(:, e) = [b, number(b)]
      end do
      allocate (block(size(kind)))
      do b = 1, size(kind)
        call fill_block(rows(kind(b)), SHAPE(kind(b))%nen, index(b), number(b), block(b))
        block(b)%body = size(mesh%body) + 1
      end do
      do e = 1, file%nelem
        if (place(1, e) == 0) cycle
        i = place(2, e)
        associate (to => block(place(1, e)))
          to%conn(:, i) = mesh%nnode + file%node(file%first(e):file%first(e + 1) - 1)
          to%number(i) = file%label(e)
        end associate
        place(1, e) = size(mesh%block) + place(1, e)
      end do
    end associate
  end subroutine make_blocks

  subroutine fill_block(row, nen, material, n, block)
    type(element_t), intent(in) :: row
    integer, intent(in) :: nen, material, n
    type(block_t), intent(inout) :: block

    block%row = row
    block%name = row%name
    block%material = material
    block%nen = nen
    block%nelem = n
    block%ext%degree = row%degree
    allocate (block%conn(nen, n), block%number(n))
  end subroutine fill_block

  !> Put blocks, body and nodes behind what the mesh has.
  subroutine append(spec, block, body, mesh)
    type(mesh_spec_t), intent(in) :: spec
    type(block_t), intent(in) :: block(:)
    type(body_t), intent(in) :: body
    type(mesh_t), intent(inout) :: mesh
    logical :: is_control(spec%file%nnode)

    is_control = .false.
    call append_blocks(mesh%block, block)
    call append_body(mesh, body)
    call append_nodes(mesh, spec%file%x, is_control)
  end subroutine append

end module mesh_body
