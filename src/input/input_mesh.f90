!> The mesh: nodes and blocks from the lists of the deck, then the bodies of NPATch, PATCh, MESH and
!! SPLIne. The material numbers and the node numbers of tables are resolved.
module input_mesh
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_sort, only: find
  use base_text, only: to_text, quoted
  use constraint, only: constraint_t, add_constraint
  use element_table, only: load_elements
  use element_type, only: element_t
  use input_draft, only: draft_t
  use input_npatch, only: npatch_geometry, append_npatch
  use input_where, only: body_index
  use mesh, only: mesh_t, block_t
  use mesh_body, only: build_mesh
  use patch_body, only: build_body
  use patch_spec, only: patch_spec_t, GEO_SPLINE, GEO_MESH
  use spline_body, only: build_spline
  use word_material, only: material_index
  use word_patch, only: patch_named
  implicit none
  private
  public :: make_mesh, count_mesh, make_bodies

contains

  !> Compare the largest numbers of nodes, elements and materials, and the largest number of nodes
  !! per element, with the control record. It is an error if they exceed it, as in FEAP's manual.
  subroutine count_mesh(draft)
    type(draft_t), intent(inout) :: draft

    associate (c => draft%control)
      call compare(draft, c%numnp, draft%nodes%top, 'numnp', 'node number')
      call compare(draft, c%numel, draft%elements%top, 'numel', 'element number')
      if (size(draft%model%material) > 0) then
        call compare(draft, c%nummat, maxval(draft%model%material%number), 'nummat', &
                     'material number')
      end if
      if (draft%elements%top > 0) then
        call compare(draft, c%nen, maxval(draft%elements%nen), 'nen', &
                     'number of nodes per element')
      end if
    end associate
  end subroutine count_mesh

  subroutine compare(draft, announced, found, name, what)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: announced, found
    character(*), intent(in) :: name !! name in the control record
    character(*), intent(in) :: what !! what is compared, for the message
    type(error_t), allocatable :: error

    if (announced == 0 .or. found <= announced) return
    call fail(error, DECK_ERROR, 'the largest '//what//' in the deck is '//to_text(found) &
              //', but '//name//' in its control record is '//to_text(announced), &
              draft%control%place, &
              'correct '//name//', or write '//name//' = 0 and let the program count')
    call draft%errors%add(error)
  end subroutine compare

  !> Make the nodes, then a block for each material and number of nodes, in order of appearance;
  !! errors go to `draft%errors`.
  subroutine make_mesh(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable :: error
    integer, allocatable :: group(:)  ! (nelem) group of each element; 0: no element has this number
    integer, allocatable :: material(:) ! (ngroup) index into the model's materials
    integer, allocatable :: nen(:)      ! (ngroup)
    type(element_t), allocatable :: rows(:)
    integer :: n, e, a, g, m

    associate (list => draft%elements, nodes => draft%nodes)
      n = nodes%top
      mesh%nnode = n
      allocate (mesh%xr(3, n), mesh%is_control(n), mesh%body(0))
      allocate (mesh%used(n), source=.false.)
      if (n > 0) then
        mesh%xr = nodes%x(:, :n)
        mesh%is_control = nodes%weight(:n) > 0.0_wp
      end if
      do e = 1, list%top
        do a = 1, list%nen(e)
          if (list%node(a, e) <= nodes%top) then
            if (nodes%given(list%node(a, e))) cycle
          end if
          call fail(error, DECK_ERROR, 'element '//to_text(e)//' refers to node ' &
                    //to_text(list%node(a, e))//', which is not defined', &
                    draft%places%at(list%place(e)), 'define it with COORdinates or BLOCk; the ' &
                    //'largest node number is '//to_text(nodes%top))
          call draft%errors%add(error)
          exit
        end do
      end do
      allocate (group(list%top), source=0)
      allocate (material(0), nen(0))
      do e = 1, list%top
        if (list%nen(e) == 0) cycle
        m = material_index(draft, list%material(e))
        do g = size(nen), 1, -1
          if (material(g) == m .and. nen(g) == list%nen(e)) exit
        end do
        if (g == 0) then
          material = [material, m]
          nen = [nen, list%nen(e)]
          g = size(nen)
        end if
        group(e) = g
      end do
    end associate
    allocate (mesh%block(size(nen)))
    if (draft%errors%count() > 0) return
    call load_elements(rows)
    do g = 1, size(nen)
      call make_block(draft, pack([(e, e=1, size(group))], group == g), material(g), nen(g), rows, &
                      mesh%block(g))
      if (draft%errors%count() > 0) return
    end do
  end subroutine make_mesh

  !> Make a block. The number of nodes determines the shape, and DISPlacement or ENHAnced of the
  !! material determines the formulation.
  subroutine make_block(draft, list, material, nen, rows, block)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: list(:)      !! (nelem) numbers of the elements
    integer, intent(in) :: material     !! index into the model's materials
    integer, intent(in) :: nen
    type(element_t), intent(in) :: rows(:)
    type(block_t), intent(inout) :: block
    type(error_t), allocatable :: error
    integer :: e, found

    associate (set => draft%model%material(material))
      found = 0
      do e = size(rows), 1, -1 ! the first match in the table is taken
        if (rows(e)%deck_nodes == nen .and. (rows(e)%nmode > 0 .eqv. set%enhanced)) found = e
      end do
      if (found == 0) then
        call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                  //' is ENHAnced, but its elements have '//to_text(nen)//' nodes', &
                  set%place, 'remove ENHAnced: only 8-node elements have enhanced modes')
      else if (any(set%nurbs_points > 0)) then
        call fail(error, DECK_ERROR, 'material '//to_text(set%number) &
                  //' has NURB interp, but is used by elements of ELEMents or BLOCk', &
                  set%place, 'remove NURB: it applies only to an NPATch')
      end if
      if (allocated(error)) call draft%errors%add(error)
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
        block%conn(block%row%deck_order(:nen), e) = draft%elements%node(:nen, list(e))
      else
        block%conn(:, e) = draft%elements%node(:nen, list(e))
      end if
    end do
  end subroutine make_block

  !> Append the NPATch bodies on the given control points, then the patches in deck order; errors go
  !! to `draft%errors`. Then mark the nodes that elements use.
  subroutine make_bodies(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable :: error
    integer :: i, j, b, e

    do i = 1, size(draft%npatch)
      if (draft%npatch(i)%is_geometry) cycle
      call append_npatch(draft, i, mesh, error)
      if (allocated(error)) call draft%errors%add(error)
    end do
    do i = 1, size(draft%patch)
      associate (p => draft%patch(i))
        p%spec%material = material_index(draft, p%material)
        select case (p%spec%geometry)
        case (GEO_SPLINE)
          call make_spline(draft, p%spec, mesh, error)
        case (GEO_MESH)
          do j = 1, size(p%mesh%material)
            p%mesh%material(j)%index = material_index(draft, p%mesh%material(j)%number)
          end do
          call build_mesh(p%mesh, mesh, error)
          if (.not. allocated(error)) then
            call add_constraints(draft, p%mesh%spec, p%mesh%constraint, p%mesh%constraint_place, &
                                 mesh, error)
          end if
        case default
          if (p%npatch > 0) call npatch_geometry(draft, p%npatch, p%spec%nurbs, error)
          if (.not. allocated(error)) call build_body(p%spec, mesh, error)
        end select
      end associate
      if (allocated(error)) call draft%errors%add(error)
      if (allocated(error)) deallocate (error) ! the next body is independent of it
    end do
    if (draft%errors%count() > 0) return
    mesh%used = .false.
    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        mesh%used(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
  end subroutine make_bodies

  !> Append the body of a SPLIne and its hanging nodes.
  subroutine make_spline(draft, spec, mesh, error)
    type(draft_t), intent(in) :: draft
    type(patch_spec_t), intent(inout) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: inner(:, :)
    integer :: c, e, p

    allocate (inner(4, 0))
    if (spec%spline%has_layer) then
      p = 0
      if (allocated(spec%spline%mesh)) p = patch_named(draft, spec%spline%mesh)
      if (p > 0) spec%placement = draft%patch(p)%spec%placement ! the skin moves with the nodes
      inner = spec%spline%inner
      do e = 1, size(inner, 2)
        do c = 1, 4
          call resolve_node(draft, mesh, spec, spec%spline%layer_place, inner(c, e), error)
          if (allocated(error)) return
        end do
      end do
    end if
    call build_spline(spec, inner, mesh, error)
    if (allocated(error)) return
    call add_constraints(draft, spec, spec%spline%constraint, spec%spline%constraint_place, mesh, &
                         error)
  end subroutine make_spline

  !> Append the constraints of the last body. In the table of a SPLIne the master -k stands for
  !! control point k of its surface.
  subroutine add_constraints(draft, spec, list, place, mesh, error)
    type(draft_t), intent(in) :: draft
    type(patch_spec_t), intent(in) :: spec   !! patch of the body
    type(constraint_t), intent(in) :: list   !! constraints with the node numbers of the table
    type(place_t), intent(in) :: place       !! place of the table in the deck
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:)
    logical, allocatable :: has(:)
    integer :: i, j

    do i = 1, list%n
      node = [list%slave(i), list%master(list%first(i):list%first(i + 1) - 1)]
      do j = 1, size(node)
        if (node(j) >= 0 .or. spec%geometry == GEO_MESH) then
          call resolve_node(draft, mesh, spec, place, node(j), error)
          if (allocated(error)) return
          cycle
        end if
        associate (s => spec%spline%surface, k => -node(j))
          allocate (has(max(s%nnode, k)), source=.false.)
          has(s%node(:s%first(s%nelem + 1) - 1)) = .true.
          if (.not. has(k)) then
            if (k > s%nnode) then
              call fail(error, DECK_ERROR, 'spline '//quoted(spec%name)//' has no control point ' &
                        //to_text(k), place, 'a master -k is control point k of the surface; ' &
                        //'its control points are 1 to '//to_text(s%nnode))
            else
              call fail(error, DECK_ERROR, 'no element of spline '//quoted(spec%name) &
                        //' uses control point '//to_text(k), place, 'a master -k must be a ' &
                        //'control point of an element of the surface')
            end if
            return
          end if
          node(j) = mesh%body(size(mesh%body))%node(count(has(:k)))
        end associate
        deallocate (has)
      end do
      call add_constraint(mesh%constraint, node(1), node(2:), &
                          list%c(list%first(i):list%first(i + 1) - 1), list%place(i))
    end do
  end subroutine add_constraints

  !> Find the node to which a number in a table refers; the number is that of the mesh file or of
  !! the deck.
  subroutine resolve_node(draft, mesh, spec, place, node, error)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(patch_spec_t), intent(in) :: spec   !! patch of the body to which the table belongs
    type(place_t), intent(in) :: place       !! place of the table in the deck
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name
    integer :: b, n

    if (spec%geometry == GEO_MESH) then
      name = spec%name
    else if (allocated(spec%spline%mesh)) then
      name = spec%spline%mesh
    else
      if (node <= draft%nodes%top) then
        if (draft%nodes%given(node)) return
      end if
      call fail(error, DECK_ERROR, 'a table of spline '//quoted(spec%name)//' refers to node ' &
                //to_text(node)//', which is not defined', place, &
                'the largest node number of the deck is '//to_text(draft%nodes%top))
      return
    end if
    b = body_index(mesh, name)
    if (b == 0) then
      call fail(error, DECK_ERROR, 'mesh '//quoted(name)//' is not defined', &
                spec%spline%mesh_place, 'define the MESH before this SPLIne, or omit its name ' &
                //'if the nodes are those of the deck')
      return
    end if
    n = 0
    if (allocated(mesh%body(b)%label)) n = find(mesh%body(b)%label, node)
    if (n == 0) then
      call fail(error, DECK_ERROR, 'node '//to_text(node)//' is not in mesh '//quoted(name), &
                place, 'tables refer to nodes by their numbers in the mesh file')
    else
      node = mesh%body(b)%node(n)
    end if
  end subroutine resolve_node

end module input_mesh
