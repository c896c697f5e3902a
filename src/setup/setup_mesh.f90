!> Nodes and blocks of a FEAP mesh, from the lists that the deck filled.
module setup_mesh
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use element_table, only: load_elements
  use element_type, only: element_t
  use mesh, only: mesh_t, block_t
  use setup_build, only: build_t
  use setup_material, only: material_index
  implicit none
  private
  public :: make_mesh, count_mesh

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
      do e = 1, size(rows)
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

end module setup_mesh
