!> Checks the model: before the bodies are meshed, the names and numbers to which records refer;
!! after that, the size of the mesh and the shape of its elements.
module input_check
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_sort, only: unique
  use base_text, only: to_text, quoted, nearest, lower
  use element_type, only: cell_t, topology_t
  use input_contact, only: check_contacts
  use input_draft, only: draft_t, patch_entry_t
  use input_lists, only: MAX_NUMBER
  use input_npatch, only: npatch_name, npatch_named
  use input_rigid, only: check_rigid
  use input_tie, only: tie_tolerance
  use input_where, only: where_t, unknown_face, W_FACES, W_EDGE, W_GROUP
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use mesh_body, only: check_case, group_named, group_hint
  use patch_spec, only: GEO_MESH, GEO_SPLINE
  use spline_set, only: check_set
  use tensor, only: det3
  use word_material, only: material_index
  use word_patch, only: patch_named
  implicit none
  private
  public :: check_references, check_size, check_jacobians

  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! a Jacobian is zero up to this fraction of the
  !! largest in its element; parent coordinates are equal up to this difference

contains

  !> Check that the names and numbers to which records refer exist, that the words of materials
  !! apply to the bodies that use them, and that no patch is too large; errors go to `draft%errors`.
  subroutine check_references(draft)
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable :: error
    real(wp) :: n
    integer :: i, j

    if (draft%incomplete) return ! a skipped word may have defined what is missing
    do i = 1, size(draft%patch)
      associate (p => draft%patch(i))
        if (p%spec%type /= 'RIGID') then
          if (p%spec%geometry == GEO_MESH) then
            do j = 1, size(p%mesh%material)
              call check_material(draft, p%mesh%material(j)%number, p%mesh%material(j)%place)
              call check_words(draft, p%mesh%material(j)%number, 'MESH')
            end do
            cycle ! check_size counts the nodes of a MESH
          end if
          if (.not. allocated(p%material_place%file)) cycle ! the record has an error already
          call check_material(draft, p%material, p%material_place)
          call check_words(draft, p%material, trim(merge('SPLIne', 'PATCh ', &
                                                         p%spec%geometry == GEO_SPLINE)))
        end if
        n = product(real(p%spec%nelem, wp)*merge(2.0_wp, 1.0_wp, p%spec%type == 'Q2') + 1.0_wp)
        if (n > MAX_NUMBER) then ! a patch that is too large is not meshed
          call fail(error, DECK_ERROR, 'patch '//quoted(p%spec%name)//' has '//to_text(n) &
                    //' nodes', p%spec%place, 'a mesh may have at most '//to_text(MAX_NUMBER) &
                    //' nodes')
          call draft%errors%add(error)
        end if
        if (p%npatch == 0) cycle
        if (p%npatch > size(draft%npatch)) then
          call fail(error, DECK_ERROR, 'NPATch '//to_text(p%npatch)//' is not defined', &
                    p%npatch_place, 'number of solids that NPATch defines in the deck: ' &
                    //to_text(size(draft%npatch)))
          call draft%errors%add(error)
        else
          draft%npatch(p%npatch)%is_geometry = .true.
        end if
      end associate
    end do
    do i = 1, size(draft%npatch)
      call check_material(draft, draft%npatch(i)%material, draft%npatch(i)%place)
      call check_words(draft, draft%npatch(i)%material, 'NPATch')
    end do
    call check_element_materials(draft)
    do i = 1, draft%nsupport
      call check_where(draft, draft%support(i)%at)
    end do
    do i = 1, draft%nmotion
      call settle_sides(draft%patch, draft%motion(i)%at)
      call check_where(draft, draft%motion(i)%at)
    end do
    do i = 1, draft%npressure
      call check_where(draft, draft%pressure(i)%at)
    end do
    do i = 1, draft%ncurve
      do j = 1, size(draft%curve(i)%column)
        associate (c => draft%curve(i)%column(j))
          if (c%at%type /= 0) call check_where(draft, c%at)
          if (allocated(c%body)) call check_name(draft, c%body, c%body_place)
        end associate
      end do
    end do
    do i = 1, size(draft%contact)
      do j = 1, 2
        call settle_sides(draft%patch, draft%contact(i)%at(j))
        call check_where(draft, draft%contact(i)%at(j))
      end do
    end do
    do i = 1, size(draft%tie)
      do j = 1, 2
        if (draft%tie(i)%material(j) > 0) call check_material(draft, draft%tie(i)%material(j), &
                                                              draft%tie(i)%place)
      end do
    end do
    call check_contacts(draft)
    call check_rigid(draft)
  end subroutine check_references

  !> Check the materials of ELEMents and BLOCk; each missing material is reported once.
  subroutine check_element_materials(draft)
    type(draft_t), intent(inout) :: draft
    integer, allocatable :: missing(:)
    integer, allocatable :: last ! material of the previous element
    integer :: e

    allocate (missing(0))
    do e = 1, draft%elements%top
      if (draft%elements%nen(e) == 0) cycle
      associate (m => draft%elements%material(e))
        if (allocated(last)) then
          if (m == last) cycle
        end if
        last = m
        if (material_index(draft, m) > 0 .or. any(missing == m)) cycle
        missing = [missing, m]
        call check_material(draft, m, draft%places%at(draft%elements%place(e)))
      end associate
    end do
  end subroutine check_element_materials

  subroutine check_material(draft, number, place)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: number
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(:), allocatable :: hint
    integer :: i

    if (material_index(draft, number) > 0) return
    hint = 'the deck has no MATErial'
    if (size(draft%model%material) > 0) hint = 'defined materials:'
    do i = 1, min(size(draft%model%material), 20)
      hint = hint//' '//to_text(draft%model%material(i)%number)
    end do
    call fail(error, DECK_ERROR, 'material '//to_text(number)//' is not defined', place, hint)
    call draft%errors%add(error)
  end subroutine check_material

  !> Fail if a material has words that do not apply to its body; report each material once.
  subroutine check_words(draft, number, word)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: number
    character(*), intent(in) :: word !! word of the body: PATCh, MESH, SPLIne or NPATch
    type(error_t), allocatable :: error
    character(:), allocatable :: hint
    logical :: is_npatch
    integer :: m

    is_npatch = word == 'NPATch'
    m = material_index(draft, number)
    if (m == 0) return
    associate (set => draft%model%material(m))
      if (set%given_formulation .and. .not. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has DISPlacement or ENHAnced, but is used by a '//word, &
                  set%place, 'remove this word: TYPE of the '//word//' gives the formulation')
      else if (set%enhanced .and. is_npatch) then
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' is ENHAnced, but is used by an NPATch', &
                  set%place, 'remove ENHAnced: only 8-node elements have enhanced modes')
      else if (any(set%nurbs_points > 0) .and. .not. is_npatch) then
        hint = 'remove NURB: QUADrature of the '//word//' sets the integration points'
        if (word == 'MESH') hint = 'remove NURB: it applies only to an NPATch'
        call fail(error, DECK_ERROR, 'material '//to_text(number) &
                  //' has NURB interp, but is used by a '//word, set%place, hint)
      end if
    end associate
    if (.not. allocated(error)) return
    call draft%errors%add(error)
    draft%model%material(m)%given_formulation = .false. ! report it once
    draft%model%material(m)%enhanced = .false.
    draft%model%material(m)%nurbs_points = 0
  end subroutine check_words

  !> A mesh or a spline has no SIDEs: there the word is the name of a group.
  pure subroutine settle_sides(patch, at)
    type(patch_entry_t), intent(in) :: patch(:)
    type(where_t), intent(inout) :: at
    integer :: p

    if (at%type /= W_FACES) return ! at%face is not allocated if the record has an error
    if (all(lower(at%face) /= ['side ', 'sides'])) return
    do p = 1, size(patch)
      if (all(patch(p)%spec%geometry /= [GEO_MESH, GEO_SPLINE])) cycle
      if (lower(patch(p)%spec%name) /= lower(at%body)) cycle
      at%type = W_GROUP
      at%mask = 0
    end do
  end subroutine settle_sides

  !> Check that the body that a WHERE names exists, and that it has the named face or group.
  subroutine check_where(draft, at)
    type(draft_t), intent(inout) :: draft
    type(where_t), intent(in) :: at
    type(error_t), allocatable :: error
    logical, allocatable :: chosen(:)
    integer :: p

    if (all(at%type /= [W_FACES, W_EDGE, W_GROUP])) return
    if (.not. is_known(draft, at%body)) then
      call check_name(draft, at%body, at%place)
      return
    end if
    p = patch_named(draft, at%body)
    if (p > 0 .and. at%type == W_EDGE) then
      if (any(draft%patch(p)%spec%geometry == [GEO_MESH, GEO_SPLINE])) then
        call fail(error, DECK_ERROR, 'a MESH or a SPLIne has no edges between two faces', &
                  at%face_place, 'name one group; in a MESH, a group of lines selects the nodes ' &
                  //'of an edge')
        call draft%errors%add(error)
        return
      end if
    end if
    if (p > 0) then
      if (draft%patch(p)%spec%geometry == GEO_SPLINE .and. at%type == W_GROUP) then
        call check_set(draft%patch(p)%spec%spline%surface, at%body, at%face, at%face_place, error)
        if (allocated(error)) call draft%errors%add(error)
        return
      end if
      if (draft%patch(p)%spec%geometry /= GEO_MESH) p = 0
    end if
    if (p == 0) then
      if (at%type == W_GROUP) call unknown_face(at%face, at%face_place, error)
    else if (lower(at%face) /= 'all') then
      associate (mesh => draft%patch(p)%mesh)
        if (.not. mesh%is_read) return ! its groups are not known
        chosen = group_named(mesh%file, at%face, dim=2)
        if (.not. any(chosen)) then
          call fail(error, DECK_ERROR, 'mesh '//quoted(at%body)//' has no group ' &
                    //quoted(at%face), at%face_place, group_hint(mesh%file, at%face))
        else if (count(chosen) > 1 .and. .not. any(chosen .and. mesh%file%group%named)) then
          call fail(error, DECK_ERROR, 'mesh '//quoted(at%body)//' has several groups ' &
                    //quoted(at%face)//' of different dimensions, none of them a surface', &
                    at%face_place, 'name the groups in the program that made the mesh')
        else
          call check_case(mesh%file, at%body, at%face, chosen, at%face_place, error)
        end if
      end associate
    end if
    if (allocated(error)) call draft%errors%add(error)
  end subroutine check_where

  !> Is there a PATCh, MESH, SPLIne or NPATch of that name?
  logical function is_known(draft, name) result(known)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name
    integer :: k

    known = patch_named(draft, name) > 0
    k = npatch_named(draft, name)
    if (k > 0) known = known .or. .not. draft%npatch(k)%is_geometry
  end function is_known

  !> Fail with the nearest name if no PATCh, MESH, SPLIne or NPATch has that name.
  subroutine check_name(draft, name, place)
    type(draft_t), intent(inout) :: draft
    character(*), intent(in) :: name
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error
    character(len(name) + 64), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: i

    if (is_known(draft, name)) return
    allocate (names(size(draft%patch) + size(draft%npatch)))
    do i = 1, size(draft%patch)
      names(i) = draft%patch(i)%spec%name
    end do
    do i = 1, size(draft%npatch)
      names(size(draft%patch) + i) = npatch_name(i)
    end do
    if (size(names) == 0) then
      hint = 'the deck has no PATCh, MESH, SPLIne or NPATch; nodes of ELEMents and BLOCk are ' &
             //'selected with NODE n, POINt x y z or PLANe direction coordinate'
    else
      hint = 'nearest known: '//nearest(name, names)
    end if
    call fail(error, DECK_ERROR, 'patch '//quoted(name)//' is not defined', place, hint)
    call draft%errors%add(error)
  end subroutine check_name

  !> Check that the mesh has elements that can deform, and that it does not have too many nodes.
  subroutine check_size(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error

    if (.not. any(mesh%used)) then
      call fail(error, DECK_ERROR, 'the mesh has no elements', draft%control%place, &
                'add ELEMents, BLOCk, NPATch, PATCh, MESH or SPLIne')
    else if (all(is_rigid(mesh%block))) then
      call fail(error, DECK_ERROR, 'all bodies are rigid', draft%control%place, &
                'add a body that can deform')
    else if (mesh%nnode > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'the mesh has '//to_text(mesh%nnode)//' nodes', &
                draft%control%place, 'a mesh may have at most '//to_text(MAX_NUMBER)//' nodes')
    end if
    if (allocated(error)) call draft%errors%add(error)
  end subroutine check_size

  !> Check that the Jacobian of every element is positive at all integration points, and in
  !! hexahedra also at the centre, because it vanishes there if the upper face is turned by half a
  !! turn against the lower one. Report the inverted elements of a block in one message.
  subroutine check_jacobians(draft, mesh)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    type(place_t) :: place
    character(:), allocatable :: text, hint
    real(wp), allocatable :: x(:, :), centre(:, :)
    real(wp) :: det, least, largest, worst
    integer :: b, e, q, first, bad
    logical :: turned

    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      associate (block => mesh%block(b))
        bad = 0
        first = 0
        worst = 0.0_wp
        turned = .false.
        call derivatives_at_centre(block, centre)
        do e = 1, block%nelem
          x = mesh%xr(:, block%conn(:, e))
          least = huge(least)
          largest = 0.0_wp
          associate (basis => block%basis(block%ibasis(e)))
            do q = 1, basis%nq
              det = det3(matmul(x, transpose(basis%dshp(:, :, q))))
              least = min(least, det)
              largest = max(largest, det)
            end do
          end associate
          if (.not. least < huge(least)) least = 0.0_wp ! the Jacobian is not a number
          if (least > 0.0_wp) then
            if (.not. allocated(centre)) cycle
            least = det3(matmul(x, transpose(centre)))
            if (least > ROUNDING*largest) cycle
            if (first == 0) turned = .true.
            if (abs(least) <= ROUNDING*largest) least = 0.0_wp
          end if
          bad = bad + 1
          if (first > 0) cycle
          first = e
          worst = least
        end do
        if (bad == 0) cycle
        text = 'element '//to_text(block%number(first))//' is inverted: its Jacobian is ' &
               //to_text(worst)
        if (turned) text = text//' at its centre'
        if (bad > 1) text = text//' (the first of '//to_text(bad)//' inverted elements)'
        if (block%body > 0) then
          place = mesh%body(block%body)%place
        else
          place = draft%places%at(draft%elements%place(block%number(first)))
        end if
        if (size(draft%tie) > 0 .and. size(unique(block%conn(:, first))) < block%nen) then
          hint = 'TIE has joined nodes of this element, because their distance is less than ' &
                 //to_text(tolerance(draft, mesh), 3)//' of the extent of the mesh: give TIE a ' &
                 //'smaller tolerance'
        else if (turned .and. block%body == 0) then
          hint = 'list the nodes of both faces in the same order: the fifth node must lie ' &
                 //'opposite the first, the sixth opposite the second'
        else if (block%body > 0) then
          hint = 'check the shape of the body; the elements of a PATCh follow a curved face ' &
                 //'more closely if there are more of them or if the face is enriched'
        else
          hint = order_hint(block, first, mesh%xr)
        end if
      end associate
      call fail(error, DECK_ERROR, text, place, hint)
      call draft%errors%add(error)
    end do
  end subroutine check_jacobians

  !> Hint: how to number the nodes of an inverted element of ELEMents or BLOCk. If a node that is no
  !! corner lies nearer to the position that another node should have than to its own position, the
  !! hint names the first such node, because the deck gives the nodes in a wrong order.
  function order_hint(block, e, xr) result(hint)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    real(wp), intent(in) :: xr(:, :)          !! (3, nnode) [L]
    character(:), allocatable :: hint
    type(cell_t) :: cell
    type(topology_t) :: topology
    integer :: deck(block%nen)                ! local node of each node of the deck
    real(wp), allocatable :: middle(:, :)     ! (3, nen) positions where the nodes should be [L]
    integer :: a, at(2), i

    call block_cell(block, e, cell)
    call block%row%topology(cell, topology)
    select case (topology%shape)
    case ('tetrahedron')
      hint = 'number its first three nodes counter-clockwise as seen from the fourth'
    case ('wedge')
      hint = 'number its first three nodes counter-clockwise as seen from the other three'
    case ('pyramid')
      hint = 'number its first four nodes counter-clockwise as seen from the fifth'
    case default
      hint = 'number its first four nodes counter-clockwise as seen from the other four'
    end select
    deck = [(i, i=1, block%nen)]
    if (block%row%deck_order(1) > 0) deck = block%row%deck_order(:block%nen)
    if (block%nen == size(topology%corner)) return
    allocate (middle(3, block%nen), source=0.0_wp)
    do a = 1, block%nen
      call find_ends(topology, a, at)
      middle(:, a) = 0.5_wp*(xr(:, block%conn(at(1), e)) + xr(:, block%conn(at(2), e)))
    end do
    do i = size(topology%corner) + 1, block%nen
      a = deck(i)
      associate (distance => norm2(middle - spread(xr(:, block%conn(a, e)), 2, block%nen), 1))
        if (distance(a) <= minval(distance)) cycle
      end associate
      call find_ends(topology, a, at)
      hint = 'node '//to_text(block%conn(a, e))//', number '//to_text(i)//' in the list of the ' &
             //'element, is not near the middle between nodes ' &
             //to_text(block%conn(at(1), e))//' and ' &
             //to_text(block%conn(at(2), e))//': see the order of nodes under ELEMents in the ' &
             //'manual'
      if (i == 9 .and. topology%shape == 'tetrahedron') then
        hint = hint//' (Gmsh exchanges the last two)'
      end if
      return
    end do
  end function order_hint

  !> Find the two corners that have a node in the middle between them in the reference element. For
  !! a corner, both are this corner.
  pure subroutine find_ends(topology, node, at)
    type(topology_t), intent(in) :: topology
    integer, intent(in) :: node
    integer, intent(out) :: at(2)
    integer :: i, j

    do j = 1, size(topology%corner)
      do i = 1, j
        at = topology%corner([i, j])
        if (all(abs(topology%xr(:, at(1)) + topology%xr(:, at(2)) - 2*topology%xr(:, node)) &
                < ROUNDING)) return
      end do
    end do
  end subroutine find_ends

  !> Get the derivatives of the functions with respect to the parent coordinates at the centre of
  !! hexahedra; not allocated for splines and for elements of other shapes.
  subroutine derivatives_at_centre(block, dshp)
    type(block_t), intent(in) :: block
    real(wp), allocatable, intent(out) :: dshp(:, :) !! (3, nen)
    type(cell_t) :: cell
    type(topology_t) :: topology
    real(wp) :: shp(block%nen)

    if (block%row%spline .or. block%nelem == 0) return
    call block_cell(block, 1, cell)
    call block%row%topology(cell, topology)
    if (topology%shape /= 'hexahedron') return
    allocate (dshp(3, block%nen))
    call block%row%functions(cell, [0.0_wp, 0.0_wp, 0.0_wp], shp, dshp)
  end subroutine derivatives_at_centre

  !> The largest tolerance of the TIE records, as a fraction of the extent of the mesh.
  pure real(wp) function tolerance(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer :: i

    tolerance = maxval([(tie_tolerance(draft%tie(i), mesh%nnode), i=1, size(draft%tie))])
  end function tolerance

end module input_check
