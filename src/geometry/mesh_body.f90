!> What a MESH block says, before its body is made.
!!
!! From a mesh file to blocks, faces and named groups of a body.
!!
!! Named sets and the boundary of a body from a mesh file.
module mesh_body
  use base_error, only: place_t, error_t, fail, DECK_ERROR
  use constraint, only: constraint_t
  use mesh_file, only: mesh_file_t, SHAPE, mark_solids
  use patch_spec, only: patch_spec_t, compose
  use format_text, only: text_t
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, lower, nearest
  use element_table, only: load_elements
  use element_type, only: element_t, cell_t, topology_t
  use mesh, only: mesh_t, block_t, body_t, append_nodes, append_blocks, append_body, body_face_t, &
      group_t
  use mesh_check, only: check_shapes, check_elements
  use mesh_faces, only: faces_t, find_boundary, face_of
  use face_rule, only: face_points, face_normal
  implicit none
  private
  public :: mesh_spec_t, mesh_material_t, build_mesh, find_groups, group_named, group_hint, &
            put_boundary

  !> MATErial m [group].
  type :: mesh_material_t
    integer :: number = 0                  !! the user's number
    integer :: index = 0                   !! in the model's materials
    character(:), allocatable :: group     !! not allocated: all elements
    type(place_t) :: place, group_place
  end type mesh_material_t

  type :: mesh_spec_t
    type(patch_spec_t) :: spec             !! name, place, placement and type of the hexahedra
    type(mesh_file_t) :: file
    type(text_t) :: text                   !! of the file, for what is wrong with it
    type(mesh_material_t), allocatable :: material(:)
    type(constraint_t) :: constraint       !! hanging nodes, by their numbers in the file
    type(place_t) :: constraint_place
  end type mesh_spec_t

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

  !> Marks of the groups of a file that have a name.
  pure function group_named(file, name) result(yes)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    logical, allocatable :: yes(:)
    integer :: g

    allocate (yes(0))
    if (.not. allocated(file%group)) return
    yes = [(lower(file%group(g)%name) == lower(name), g=1, size(file%group))]
  end function group_named

  !> What a group that is not there could be.
  function group_hint(file, name) result(hint)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    character(:), allocatable :: hint
    character(64), allocatable :: names(:)
    integer :: g

    hint = 'its file has no physical groups; ALL is the whole boundary'
    if (.not. allocated(file%group)) return
    allocate (names(size(file%group)))
    do g = 1, size(names)
      names(g) = file%group(g)%name
    end do
    hint = 'nearest known: '//trim(nearest(name, names))
  end function group_hint

  !> Groups of one name are one.
  subroutine find_groups(file, faces, place, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :)   !! (2, nelem) block of the mesh and element there
    integer, intent(in) :: nnode         !! nodes of the mesh before this body
    type(body_t), intent(inout) :: body
    type(group_t), allocatable :: group(:)
    logical, allocatable :: chosen(:)
    integer :: g, n

    n = 0
    if (allocated(file%group)) n = size(file%group)
    allocate (group(n))
    n = 0
    do g = 1, size(group)
      chosen = group_named(file, file%group(g)%name)
      if (any(chosen(:g - 1))) cycle
      n = n + 1
      group(n)%name = file%group(g)%name
      call fill_group(file, faces, place, nnode, chosen, group(n))
    end do
    body%group = group(:n)
  end subroutine find_groups

  !> Nodes of all elements, faces of the surface elements.
  subroutine fill_group(file, faces, place, nnode, chosen, group)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), nnode
    logical, intent(in) :: chosen(:)
    type(group_t), intent(inout) :: group
    logical, allocatable :: on(:), seen(:)
    integer, allocatable :: list(:)
    integer :: e, f, i, m, n

    allocate (on(file%nnode), seen(faces%n), source=.false.)
    allocate (list(count(chosen(file%member(2, :file%nmember)))))
    n = 0
    do m = 1, file%nmember
      if (.not. chosen(file%member(2, m))) cycle
      e = file%member(1, m)
      on(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
      if (SHAPE(file%shape(e))%dim /= 2) cycle
      f = face_of(faces, file, e)
      if (f == 0) then
        group%inner = group%inner + 1
        cycle
      end if
      if (seen(f)) cycle
      seen(f) = .true.
      n = n + 1
      list(n) = f
    end do
    group%node = nnode + pack([(i, i=1, file%nnode)], on)
    call take_faces(faces, place, list(:n), group%face)
  end subroutine fill_group

  pure subroutine take_faces(faces, place, list, face)
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), list(:)
    type(body_face_t), intent(out) :: face

    face%block = place(1, faces%elem(list))
    face%elem = place(2, faces%elem(list))
    face%side = faces%side(list)
  end subroutine take_faces

  !> Nodes, the whole boundary as face 1, and how thick the body is.
  subroutine put_boundary(file, faces, rows, place, volume, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    type(element_t), intent(in) :: rows(:)  !! of each entry of SHAPE
    integer, intent(in) :: place(:, :), nnode
    real(wp), intent(in) :: volume          !! [L^3]
    type(body_t), intent(inout) :: body
    logical, allocatable :: used(:)
    integer :: e, f, i
    real(wp) :: area

    body%node = [(nnode + i, i=1, file%nnode)]
    body%label = file%number
    allocate (body%mask(file%nnode), source=0)
    call take_faces(faces, place, pack([(f, f=1, faces%n)], faces%bounds), body%face(1))
    do f = 2, 6
      allocate (body%face(f)%block(0), body%face(f)%elem(0), body%face(f)%side(0))
    end do
    area = 0.0_wp
    do f = 1, faces%n
      if (faces%bounds(f)) call add_face(file, faces, rows, f, body%mask, area)
    end do
    body%thickness = 2.0_wp*volume/area
    allocate (used(file%nnode), source=.false.)
    do e = 1, file%nelem
      if (file%solid(e)) used(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
    end do
    body%note = to_text(count(file%solid))//' elements, '//to_text(count(used))//' nodes, ' &
                //to_text(count(faces%bounds))//' faces on the boundary'
    if (.not. all(used)) body%note = body%note//'; '//to_text(count(.not. used)) &
                                     //' nodes of the file belong to no element of it'
  end subroutine put_boundary

  !> Nodes of a boundary face, and its area.
  subroutine add_face(file, faces, rows, f, mask, area)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    type(element_t), intent(in) :: rows(:)
    integer, intent(in) :: f
    integer, intent(inout) :: mask(:)
    real(wp), intent(inout) :: area
    type(topology_t) :: topology
    type(cell_t) :: cell
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :)
    real(wp) :: normal(3), ta(3), tb(3)
    real(wp), parameter :: NONE(3, 1) = 0.0_wp
    integer :: q, kind

    kind = file%shape(faces%elem(f))
    cell%degree = rows(kind)%degree
    call rows(kind)%topology(cell, topology)
    allocate (shp(topology%nen), dshp(3, topology%nen))
    associate (s => faces%side(f), first => file%first(faces%elem(f)))
      associate (node => file%node(first:first + topology%nen - 1))
        mask(node(topology%node(topology%first(s):topology%first(s + 1) - 1))) = 1
        call face_points(cell%degree, NONE, s, xi, w)
        do q = 1, size(w)
          call rows(kind)%functions(cell, xi(:, q), shp, dshp)
          call face_normal(s, file%x(:, node), dshp, normal, ta, tb)
          area = area + w(q)*norm2(normal)
        end do
      end associate
    end associate
  end subroutine add_face

end module mesh_body
