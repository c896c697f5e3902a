!> The body that MESH makes from a mesh file: element blocks, boundary and named groups.
module mesh_body
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text, quoted, lower, nearest
  use constraint, only: constraint_t
  use format_text, only: text_t
  use mesh, only: mesh_t, block_t, body_t, body_face_t, group_t, append_nodes, append_blocks, &
                  append_body
  use mesh_check, only: check_shapes, check_elements
  use mesh_faces, only: faces_t, find_boundary, face_of, measure_face
  use mesh_file, only: mesh_file_t, mark_solids
  use mesh_hanging, only: leave_hanging_faces
  use mesh_shape, only: choose_row
  use patch_spec, only: patch_spec_t, compose
  implicit none
  private
  public :: mesh_spec_t, mesh_material_t, build_mesh, group_named, group_hint, check_case

  !> A record `MATErial m [group]`.
  type :: mesh_material_t
    integer :: number = 0                  !! the user's number
    integer :: index = 0                   !! index into the materials of the model
    character(:), allocatable :: group     !! a named group; not allocated: all elements
    type(place_t) :: place, group_place
  end type mesh_material_t

  !> The data of a MESH block.
  type :: mesh_spec_t
    type(patch_spec_t) :: spec             !! name, place, placement; TYPE of 8-node hexahedra
    type(mesh_file_t) :: file
    type(text_t) :: text                   !! its text, for error messages
    type(mesh_material_t), allocatable :: material(:)
    type(constraint_t) :: constraint       !! hanging nodes, with node numbers of the file
    type(place_t) :: constraint_place
    logical :: is_read = .false.           !! the file and all records were read without an error
  end type mesh_spec_t

contains

  !> Append the body of a MESH to the mesh of the model, which is not changed if there is an error.
  subroutine build_mesh(spec, mesh, error)
    type(mesh_spec_t), intent(inout) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(block_t), allocatable :: block(:)
    type(faces_t) :: faces
    type(body_t) :: body
    integer, allocatable :: material(:), place(:, :)
    logical :: is_control(spec%file%nnode)
    real(wp) :: volume, turn(3, 3), shift(3)
    integer :: n

    associate (file => spec%file)
      call choose_row(file%shapes, spec%spec%type)
      if (size(spec%spec%placement) > 0) then
        call compose(spec%spec%placement, turn, shift)
        do n = 1, file%nnode
          file%x(:, n) = matmul(turn, file%x(:, n)) + shift
        end do
      end if
      call mark_solids(file, spec%text, error)
      if (.not. allocated(error)) call check_shapes(file, spec%text, error)
      if (.not. allocated(error)) call check_elements(file, spec%text, volume, error)
      if (.not. allocated(error)) call find_materials(spec, material, error)
      if (.not. allocated(error)) call find_boundary(file, spec%text, faces, error)
      if (allocated(error)) return
      call leave_hanging_faces(file, spec%constraint, faces)
      call make_blocks(file, material, mesh, block, place)
      body%name = spec%spec%name
      body%place = spec%spec%place
      call set_boundary(file, faces, place, volume, mesh%nnode, body)
      call set_groups(file, faces, place, mesh%nnode, body)
      call append_blocks(mesh%block, block)
      call append_body(mesh, body)
      is_control = .false.
      call append_nodes(mesh, file%x, is_control)
    end associate
  end subroutine build_mesh

  !> Find the index of the material of each element; a later MATErial replaces an earlier one. Warn
  !! about a MATErial of a group that has no effect.
  subroutine find_materials(spec, material, error)
    type(mesh_spec_t), intent(in) :: spec
    integer, allocatable, intent(out) :: material(:) !! (nelem)
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint
    logical, allocatable :: chosen(:)
    integer :: setter(spec%file%nelem) ! the record that gives each element its material
    integer :: e, i, m

    allocate (material(spec%file%nelem), source=0)
    setter = 0
    do i = 1, size(spec%material)
      associate (set => spec%material(i), file => spec%file)
        if (.not. allocated(set%group)) then
          material = set%index
          setter = i
          cycle
        end if
        chosen = group_named(file, set%group, dim=3)
        if (.not. any(chosen)) then
          hint = group_hint(file, set%group)
          if (.not. allocated(file%group)) hint = 'the mesh file has no groups; MATErial m ' &
                                                  //'without a group applies to all elements'
          call fail(error, DECK_ERROR, 'mesh '//quoted(spec%spec%name)//' has no group ' &
                    //quoted(set%group), set%group_place, hint)
          return
        end if
        call check_case(file, spec%spec%name, set%group, chosen, set%group_place, error)
        if (allocated(error)) return
        do m = 1, file%nmember
          if (.not. chosen(file%member(2, m))) cycle
          material(file%member(1, m)) = set%index
          setter(file%member(1, m)) = i
        end do
      end associate
    end do
    do e = 1, spec%file%nelem
      if (material(e) > 0 .or. .not. spec%file%solid(e)) cycle
      call fail(error, DECK_ERROR, 'element '//to_text(spec%file%label(e))//' of mesh ' &
                //quoted(spec%spec%name)//' has no material', spec%spec%place, &
                'write ''MATErial m'', which gives all elements a material, before the records ' &
                //'''MATErial m group''')
      return
    end do
    do i = 1, size(spec%material)
      associate (set => spec%material(i))
        if (.not. allocated(set%group) .or. any(setter == i .and. spec%file%solid)) cycle
        call warn('MATErial '//to_text(set%number)//' of group '//quoted(set%group)//' of mesh ' &
                  //quoted(spec%spec%name)//' has no effect: the group has no solid elements, or ' &
                  //'later records give all of them a material', set%place, &
                  'write ''MATErial m'', which gives all elements a material, before the records ' &
                  //'''MATErial m group''')
      end associate
    end do
  end subroutine find_materials

  !> Make a block for each combination of shape and material, in the order in which the combinations
  !! first occur in the file.
  subroutine make_blocks(file, material, mesh, block, place)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: material(:)               !! (nelem)
    type(mesh_t), intent(in) :: mesh
    type(block_t), allocatable, intent(out) :: block(:)
    !> (2, nelem) block of the mesh and element in it; 0: the element is not solid.
    integer, allocatable, intent(out) :: place(:, :)
    integer, allocatable :: shape(:), index(:), number(:)
    integer :: b, e

    allocate (place(2, file%nelem), source=0)
    allocate (shape(0), index(0), number(0))
    do e = 1, file%nelem
      if (.not. file%solid(e)) cycle
      do b = size(shape), 1, -1
        if (shape(b) == file%shape(e) .and. index(b) == material(e)) exit
      end do
      if (b == 0) then
        shape = [shape, file%shape(e)]
        index = [index, material(e)]
        number = [number, 0]
        b = size(shape)
      end if
      number(b) = number(b) + 1
      place(:, e) = [b, number(b)]
    end do
    allocate (block(size(shape)))
    do b = 1, size(block)
      block(b)%row = file%shapes(shape(b))%row
      block(b)%name = block(b)%row%name
      block(b)%material = index(b)
      block(b)%nen = file%shapes(shape(b))%nen
      block(b)%nelem = number(b)
      block(b)%ext%degree = block(b)%row%degree
      block(b)%body = size(mesh%body) + 1
      allocate (block(b)%conn(block(b)%nen, number(b)), block(b)%number(number(b)))
    end do
    do e = 1, file%nelem
      if (place(1, e) == 0) cycle
      associate (to => block(place(1, e)), i => place(2, e))
        to%conn(:, i) = mesh%nnode + file%node(file%first(e):file%first(e + 1) - 1)
        to%number(i) = file%label(e)
      end associate
      place(1, e) = size(mesh%block) + place(1, e)
    end do
  end subroutine make_blocks

  !> Mark the groups of a file that have a given name. A number names all groups that have it as
  !! their name; if there is none, it names the unnamed groups with this number, or, if `dim` is
  !! given and one of them has this dimension, only this one.
  pure function group_named(file, name, dim) result(yes)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in), optional :: dim
    logical, allocatable :: yes(:)
    integer :: g

    allocate (yes(0))
    if (.not. allocated(file%group)) return
    yes = [(file%group(g)%name == name, g=1, size(file%group))]
    if (.not. any(yes)) then
      yes = [(lower(file%group(g)%name) == lower(name), g=1, size(file%group))]
    end if
    if (any(yes .and. file%group%named)) then
      yes = yes .and. file%group%named
    else if (present(dim)) then
      if (any(yes .and. file%group%dim == dim)) yes = yes .and. file%group%dim == dim
    end if
  end function group_named

  !> Fail if the groups that a name chooses have different names.
  subroutine check_case(file, mesh, name, chosen, place, error)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: mesh, name !! as written in the deck
    logical, intent(in) :: chosen(:)       !! (size(file%group))
    type(place_t), intent(in) :: place     !! place of the name
    type(error_t), allocatable, intent(out) :: error
    integer :: first, g

    first = findloc(chosen, .true., 1)
    do g = first + 1, size(chosen)
      if (.not. chosen(g) .or. file%group(g)%name == file%group(first)%name) cycle
      call fail(error, DECK_ERROR, 'mesh '//quoted(mesh)//' has several groups whose names ' &
                //'differ from '//quoted(name)//' only in case', place, &
                'write the name as in the mesh file')
      return
    end do
  end subroutine check_case

  !> Make a hint for a group name that does not exist.
  function group_hint(file, name) result(hint)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    character(:), allocatable :: hint
    character(64), allocatable :: names(:)
    integer :: g

    hint = 'the mesh file has no groups; use ALL for the whole boundary'
    if (.not. allocated(file%group)) return
    allocate (names(size(file%group)))
    do g = 1, size(names)
      names(g) = file%group(g)%name
    end do
    hint = 'nearest known: '//trim(nearest(name, names))
  end function group_hint

  !> Set the named groups of a body: the nodes of all their elements, and the boundary faces of
  !! their surface elements. Groups with the same name are merged; of unnamed groups with the same
  !! number, the surface is taken.
  subroutine set_groups(file, faces, place, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :)   !! (2, nelem) block of the mesh and element in it
    integer, intent(in) :: nnode         !! number of nodes of the mesh before this body
    type(body_t), intent(inout) :: body
    type(group_t), allocatable :: group(:)
    logical, allocatable :: chosen(:), on(:), seen(:)
    integer, allocatable :: list(:)
    integer :: e, f, g, i, m, n, ngroup

    n = 0
    if (allocated(file%group)) n = size(file%group)
    allocate (group(n))
    ngroup = 0
    do g = 1, size(group)
      chosen = group_named(file, file%group(g)%name, dim=2)
      if (any(chosen(:g - 1)) .or. .not. chosen(g)) cycle
      ngroup = ngroup + 1
      group(ngroup)%name = file%group(g)%name
      on = [(.false., i=1, file%nnode)]
      seen = [(.false., i=1, faces%n)]
      n = 0
      list = [(0, m=1, count(chosen(file%member(2, :file%nmember))))]
      do m = 1, file%nmember
        if (.not. chosen(file%member(2, m))) cycle
        e = file%member(1, m)
        on(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
        if (file%shapes(file%shape(e))%dim /= 2) cycle
        f = face_of(faces, file, e)
        if (f == 0) then
          group(ngroup)%inner = group(ngroup)%inner + 1
          cycle
        end if
        if (seen(f)) cycle
        seen(f) = .true.
        n = n + 1
        list(n) = f
        call add_face_nodes(file, faces, f, on)
      end do
      group(ngroup)%node = nnode + pack([(i, i=1, file%nnode)], on)
      call take_faces(faces, place, list(:n), group(ngroup)%face)
    end do
    body%group = group(:ngroup)
  end subroutine set_groups

  !> Mark all nodes of a face: a surface element of a group may have only its corners.
  pure subroutine add_face_nodes(file, faces, f, on)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: f
    logical, intent(inout) :: on(:) !! (nnode of the file)

    associate (e => faces%elem(f), s => faces%side(f))
      associate (topology => file%shapes(file%shape(e))%topology)
        on(file%node(file%first(e) - 1 &
                     + topology%node(topology%first(s):topology%first(s + 1) - 1))) = .true.
      end associate
    end associate
  end subroutine add_face_nodes

  pure subroutine take_faces(faces, place, list, face)
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), list(:)
    type(body_face_t), intent(out) :: face

    face%block = place(1, faces%elem(list))
    face%elem = place(2, faces%elem(list))
    face%side = faces%side(list)
  end subroutine take_faces

  !> Set the nodes of the body, its face 1 (the whole boundary), its thickness 2 (volume)/(area),
  !! and the summary of its file.
  subroutine set_boundary(file, faces, place, volume, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), nnode
    real(wp), intent(in) :: volume          !! [L^3]
    type(body_t), intent(inout) :: body
    logical, allocatable :: used(:)
    real(wp) :: area, part, normal(3)
    integer :: e, f, i

    body%node = [(nnode + i, i=1, file%nnode)]
    body%label = file%number
    allocate (body%mask(file%nnode), source=0)
    call take_faces(faces, place, pack([(f, f=1, faces%n)], faces%bounds), body%face(1))
    do f = 2, 6
      allocate (body%face(f)%block(0), body%face(f)%elem(0), body%face(f)%side(0))
    end do
    area = 0.0_wp
    do f = 1, faces%n
      if (.not. faces%bounds(f)) cycle
      e = faces%elem(f)
      associate (shape => file%shapes(file%shape(e)), s => faces%side(f), &
                 node => file%node(file%first(e):file%first(e + 1) - 1))
        associate (face => shape%topology%first(s:s + 1))
          body%mask(node(shape%topology%node(face(1):face(2) - 1))) = 1
        end associate
      end associate
      call measure_face(file, faces, f, part, normal)
      area = area + part
    end do
    body%thickness = 2.0_wp*volume/area
    allocate (used(file%nnode), source=.false.)
    do e = 1, file%nelem
      if (file%solid(e)) used(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
    end do
    body%note = to_text(count(file%solid))//' elements, '//to_text(count(used))//' nodes, ' &
                //to_text(count(faces%bounds))//' faces on the boundary'
    if (.not. all(used)) body%note = body%note//'; nodes of the file that belong to no solid ' &
                                     //'element: '//to_text(count(.not. used))
  end subroutine set_boundary

end module mesh_body
