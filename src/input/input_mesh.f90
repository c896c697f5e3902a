!> Nodes and blocks of a FEAP mesh, from the lists that the deck filled.
!!
!! MESH at the END of the mesh part: materials and node numbers of files become those of the model.
!!
!! SPLIne at the END of the mesh: numbers of its tables become nodes of the mesh.
module input_mesh
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR, place_t
  use base_text, only: to_text, quoted
  use element_table, only: load_elements
  use element_type, only: element_t
  use mesh, only: mesh_t, block_t
  use input_draft, only: build_t
  use word_material, only: material_index
  use base_sort, only: find
  use constraint, only: add_constraint
  use mesh_body, only: build_mesh
  use input_where, only: body_index
  use patch_spec, only: patch_spec_t
  use spline_body, only: build_spline
  implicit none
  private
  public :: make_mesh, count_mesh, make_mesh_body, find_label, make_spline

contains

  !> Counts against the control record; more than it says is an error, as in FEAP's manual.
  subroutine count_mesh(build)
    type(build_t), intent(inout) :: build

    associate (c => build%control)
      call compare(build, c%numnp, build%nodes%top, 'numnp', 'nodes')
      call compare(build, c%numel, build%elements%top, 'numel', 'elements')
      if (size(build%model%material) > 0) then
        call compare(build, c%nummat, maxval(build%model%material%number), 'nummat', 'materials')
      end if
      if (build%elements%top > 0) then
        call compare(build, c%nen, maxval(build%elements%nen), 'nen', 'nodes of an element')
      end if
    end associate
  end subroutine count_mesh

  subroutine compare(build, said, found, name, what)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: said, found
    character(*), intent(in) :: name, what
    type(error_t), allocatable :: error

    if (said == 0 .or. found <= said) return
    call fail(error, DECK_ERROR, 'the deck has '//to_text(found)//' '//what &
              //', its control record says ' &
              //to_text(said), build%control%place, name//' counts them; with '//name &
              //' = 0 they are counted here')
    call build%errors%add(error)
  end subroutine compare

  !> Nodes, then a block for each material and number of nodes; errors go to the list.
  subroutine make_mesh(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(inout) :: mesh
    integer, allocatable :: group(:), group_material(:), group_nen(:)
    type(element_t), allocatable :: rows(:)
    integer :: n, g

    n = build%nodes%top
    mesh%nnode = n
    allocate (mesh%xr(3, n), mesh%is_control(n), mesh%used(n), mesh%body(0))
    if (n > 0) then
      mesh%xr = build%nodes%x(:, :n)
      mesh%is_control = build%nodes%weight(:n) > 0.0_wp
    end if
    mesh%used = .false.
    call check_elements(build)
    call group_elements(build, group, group_material, group_nen)
    allocate (mesh%block(size(group_nen)))
    if (build%errors%count() > 0) return
    call load_elements(rows)
    do g = 1, size(group_nen)
      call make_block(build, pack([(n, n=1, build%elements%top)], group == g), group_material(g), &
                      group_nen(g), &
                      rows, mesh%block(g))
      if (build%errors%count() > 0) return
    end do
  end subroutine make_mesh

  !> Every element has nodes that exist.
  subroutine check_elements(build)
    type(build_t), intent(inout) :: build
    type(error_t), allocatable :: error
    integer :: e, a

    associate (list => build%elements, nodes => build%nodes)
      do e = 1, list%top
        do a = 1, list%nen(e)
          if (list%node(a, e) <= nodes%top) then
            if (nodes%given(list%node(a, e))) cycle
          end if
          call fail(error, DECK_ERROR, 'element '//to_text(e)//' refers to node ' &
                    //to_text(list%node(a, e)) &
                    //', which is not defined', build%places%at(list%place(e)), &
                    'define it by COORdinates or BLOCk; node numbers go to '//to_text(nodes%top))
          call build%errors%add(error)
          exit
        end do
      end do
    end associate
  end subroutine check_elements

  !> Elements of one material and one number of nodes make a group; groups in order of appearance.
  subroutine group_elements(build, group, material, nen)
    type(build_t), intent(in) :: build
    integer, allocatable, intent(out) :: group(:)    !! (nelem) 0: no element of this number
    integer, allocatable, intent(out) :: material(:) !! (ngroup) index into the model's materials
    integer, allocatable, intent(out) :: nen(:)      !! (ngroup)
    integer :: e, g, m

    allocate (group(build%elements%top), source=0)
    allocate (material(0), nen(0))
    do e = 1, build%elements%top
      if (build%elements%nen(e) == 0) cycle
      m = material_index(build, build%elements%material(e))
      do g = size(nen), 1, -1
        if (material(g) == m .and. nen(g) == build%elements%nen(e)) exit
      end do
      if (g == 0) then
        material = [material, m]
        nen = [nen, build%elements%nen(e)]
        g = size(nen)
      end if
      group(e) = g
    end do
  end subroutine group_elements

  !> The node count chooses the cell, the material's DISPlacement or ENHAnced the formulation.
  subroutine make_block(build, list, material, nen, rows, block)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: list(:)
    integer, intent(in) :: material, nen
    type(element_t), intent(in) :: rows(:)
    type(block_t), intent(inout) :: block
    type(error_t), allocatable :: error
    integer :: e, found

    associate (set => build%model%material(material))
      found = 0
      do e = size(rows), 1, -1 ! the first of the table counts
        if (rows(e)%deck_nodes == nen .and. (rows(e)%nmode > 0 .eqv. set%enhanced)) found = e
      end do
      if (found == 0) then
        call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                  //' is ENHAnced, but its elements have '//to_text(nen)//' nodes', &
                  set%place, 'enhanced modes belong to 8-node elements; '//to_text(nen) &
                  //'-node elements do not need them')
      else if (any(set%nurbs_points > 0)) then
        call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                  //' has NURB interp, but its elements are bricks', &
                  set%place, 'NURB interp belongs to an NPATch')
      end if
      if (allocated(error)) call build%errors%add(error)
      if (found == 0) return
      block%row = rows(found)
      block%name = block%row%name
    end associate
    block%material = material
    block%nen = nen
    block%nelem = size(list)
    block%number = list
    block%ext%degree = block%row%degree
    allocate (block%conn(nen, size(list)))
    do e = 1, size(list)
      if (block%row%deck_order(1) > 0) then
        block%conn(block%row%deck_order(:nen), e) = build%elements%node(:nen, list(e))
      else
        block%conn(:, e) = build%elements%node(:nen, list(e))
      end if
    end do
  end subroutine make_block

  !> Append the body of the i-th entry and its hanging nodes.
  subroutine make_mesh_body(build, i, mesh, error)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: i
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:)
    integer :: j, k

    associate (spec => build%patch(i)%mesh)
      do j = 1, size(spec%material)
        spec%material(j)%index = material_index(build, spec%material(j)%number)
      end do
      call build_mesh(spec, mesh, error)
      if (allocated(error)) return
      associate (list => spec%constraint)
        do j = 1, list%n
          node = [list%slave(j), list%master(list%first(j):list%first(j + 1) - 1)]
          do k = 1, size(node)
            call find_label(mesh, spec%spec%name, spec%constraint_place, node(k), error)
            if (allocated(error)) return
          end do
          call add_constraint(mesh%constraint, node(1), node(2:), &
                              list%c(list%first(j):list%first(j + 1) - 1), list%place(j))
        end do
      end associate
    end associate
  end subroutine make_mesh_body

  !> From a number in the file of a MESH to the node.
  subroutine find_label(mesh, name, place, node, error)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: name         !! of the mesh
    type(place_t), intent(in) :: place       !! of the table that refers to it
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error
    integer :: b, n

    b = body_index(mesh, name)
    n = 0
    if (b > 0) then
      if (allocated(mesh%body(b)%label)) n = find(mesh%body(b)%label, node)
    end if
    if (n == 0) then
      call fail(error, DECK_ERROR, 'node '//to_text(node)//' is not in mesh '//quoted(name), &
                place, 'tables name the nodes by their numbers in the file of the mesh')
    else
      node = mesh%body(b)%node(n)
    end if
  end subroutine find_label

  !> Append the body of a SPLIne and its hanging nodes.
  subroutine make_spline(build, spec, mesh, error)
    type(build_t), intent(in) :: build
    type(patch_spec_t), intent(inout) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: inner(:, :)
    integer :: c, e

    allocate (inner(4, 0))
    if (spec%spline%has_layer) then
      inner = spec%spline%inner
      do e = 1, size(inner, 2)
        do c = 1, 4
          call resolve_node(build, mesh, spec, spec%spline%layer_place, inner(c, e), error)
          if (allocated(error)) return
        end do
      end do
    end if
    call build_spline(spec, inner, mesh, error)
    if (.not. allocated(error)) call add_constraints(build, spec, mesh, error)
  end subroutine make_spline

  !> The hanging nodes of its mesh, and those that control points are.
  subroutine add_constraints(build, spec, mesh, error)
    type(build_t), intent(in) :: build
    type(patch_spec_t), intent(in) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:)
    integer :: i, j

    associate (list => spec%spline%constraint)
      do i = 1, list%n
        node = [list%slave(i), list%master(list%first(i):list%first(i + 1) - 1)]
        do j = 1, size(node)
          if (node(j) < 0) then
            call resolve_control(mesh, spec, node(j), error)
          else
            call resolve_node(build, mesh, spec, spec%spline%constraint_place, node(j), error)
          end if
          if (allocated(error)) return
        end do
        call add_constraint(mesh%constraint, node(1), node(2:), &
                            list%c(list%first(i):list%first(i + 1) - 1), list%place(i))
      end do
    end associate
  end subroutine add_constraints

  !> From -k to the node that is control point k of the surface, whose body is the last.
  subroutine resolve_control(mesh, spec, node, error)
    type(mesh_t), intent(in) :: mesh
    type(patch_spec_t), intent(in) :: spec
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: has(:)

    associate (s => spec%spline%surface)
      allocate (has(max(s%nnode, -node)), source=.false.)
      has(s%node(:s%first(s%nelem + 1) - 1)) = .true.
      if (has(-node)) then
        node = mesh%body(size(mesh%body))%node(count(has(:-node)))
        return
      end if
    end associate
    call fail(error, DECK_ERROR, 'control point '//to_text(-node)//' of spline ' &
              //quoted(spec%name)//' has no function', spec%spline%constraint_place, &
              'a master -k is control point k of the surface, which has 1 to ' &
              //to_text(spec%spline%surface%nnode))
  end subroutine resolve_control

  !> From the number in a table to the node.
  subroutine resolve_node(build, mesh, spec, place, node, error)
    type(build_t), intent(in) :: build
    type(mesh_t), intent(in) :: mesh
    type(patch_spec_t), intent(in) :: spec
    type(place_t), intent(in) :: place
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error

    if (allocated(spec%spline%mesh)) then
      if (body_index(mesh, spec%spline%mesh) == 0) then
        call fail(error, DECK_ERROR, 'mesh '//quoted(spec%spline%mesh)//' is not defined', &
                  spec%spline%mesh_place, 'its MESH stands before this SPLIne; leave the name ' &
                  //'out where the nodes are those of the deck')
      else
        call find_label(mesh, spec%spline%mesh, place, node, error)
      end if
      return
    end if
    if (node <= build%nodes%top) then
      if (build%nodes%given(node)) return
    end if
    call fail(error, DECK_ERROR, 'a table of spline '//quoted(spec%name)//' refers to node ' &
              //to_text(node)//', which is not defined', place, &
              'the deck has nodes 1 to '//to_text(build%nodes%top))
  end subroutine resolve_node

end module input_mesh
