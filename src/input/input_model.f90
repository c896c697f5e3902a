!> From the first record of a deck to the END of its mesh.
!!
!! At the END of the mesh: from what was read to a model that can be solved.
module input_model
  use base_error, only: error_t, fail, DECK_ERROR, error_list_t
  use base_text, only: to_text, quoted, nearest
  use deck_record, only: record_t, RECORD_WORDS
  use deck_stream, only: deck_t
  use model, only: model_t
  use input_draft, only: build_t, mesh_read_i, skip_set, row_of, known_word
  use word_control, only: read_title, read_control
  use word_table, only: load_mesh_words
  use mesh, only: mesh_t, is_rigid
  use model_basis, only: tabulate_basis
  use patch_body, only: build_body
  use patch_spec, only: GEO_SPLINE, GEO_MESH
  use unread_constraints, only: find_unread
  use input_conditions, only: apply_conditions, note_loose
  use input_check, only: check_references, check_jacobians
  use input_constraint, only: close_constraints, release_slaves
  use input_contact, only: build_contacts
  use input_lists, only: MAX_NUMBER
  use input_loads, only: integrate_loads
  use word_material, only: material_index
  use input_mesh, only: make_mesh, count_mesh, make_mesh_body, make_spline
  use input_rigid, only: hold_rigid
  use input_resolve, only: resolve_supports, resolve_loads, resolve_curves
  use input_npatch, only: npatch_geometry, append_npatch
  use input_tie, only: tie_nodes
  implicit none
  private
  public :: build_model, finish

  !> Blocks in which a comment alone does not count as blank.
  character(8), parameter :: OURS(5) = ['PATCh   ', 'SPLIne  ', 'MESH    ', 'CURVe   ', 'CONTact ']

contains

  !> Read the mesh part of a deck. Independent errors are collected in `errors`; `error` is one
  !! after which reading could not go on.
  subroutine build_model(deck, model, errors, error)
    type(deck_t), intent(inout) :: deck
    type(model_t), intent(inout) :: model
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    type(build_t) :: build

    call start(build)
    call read_title(build, deck, error)
    if (allocated(error)) return
    call read_control(build, deck, error)
    if (allocated(error)) then
      if (error%code /= DECK_ERROR) return
      call build%errors%add(error)
      deallocate (error)
    end if
    call read_words(build, deck, error)
    if (.not. (allocated(error) .or. build%ended)) call read_ties(build, deck, error)
    if (.not. allocated(error)) call finish(build)
    errors = build%errors
    call hand_over(build%model, model)
  end subroutine build_model

  !> The model without a second copy of its arrays.
  subroutine hand_over(from, to)
    type(model_t), intent(inout) :: from, to

    if (allocated(from%title)) call move_alloc(from%title, to%title)
    if (allocated(from%material)) call move_alloc(from%material, to%material)
    if (allocated(from%contact)) call move_alloc(from%contact, to%contact)
    if (allocated(from%curve)) call move_alloc(from%curve, to%curve)
    if (allocated(from%unread)) call move_alloc(from%unread, to%unread)
    to%mesh%nnode = from%mesh%nnode
    if (allocated(from%mesh%xr)) call move_alloc(from%mesh%xr, to%mesh%xr)
    if (allocated(from%mesh%is_control)) call move_alloc(from%mesh%is_control, to%mesh%is_control)
    if (allocated(from%mesh%used)) call move_alloc(from%mesh%used, to%mesh%used)
    if (allocated(from%mesh%block)) call move_alloc(from%mesh%block, to%mesh%block)
    if (allocated(from%mesh%body)) call move_alloc(from%mesh%body, to%mesh%body)
    to%mesh%constraint = from%mesh%constraint
    to%bc = from%bc
  end subroutine hand_over

  !> An empty model.
  subroutine start(build)
    type(build_t), intent(inout) :: build

    call load_mesh_words(build%row)
    allocate (build%model%material(0), build%model%contact(0), build%patch(0), build%npatch(0))
    allocate (build%knots(0), build%support(0), build%contact(0))
    allocate (build%move(0), build%press(0), build%curve(0), build%tie(0))
  end subroutine start

  !> Word after word up to END.
  subroutine read_words(build, deck, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: r

    do
      if (build%has_pending) then
        record = build%pending
        build%has_pending = .false.
      else
        call deck%next(record, error)
        if (allocated(error)) return
      end if
      if (record%is_blank()) cycle
      if (record%is_end() .or. record%key(1) == 'batc' .or. record%key(1) == 'inte' &
          .or. record%key(1) == 'stop') then
        call fail(error, DECK_ERROR, 'the mesh has no END', record%place(1), &
                  'END closes the mesh, before BATCh')
        return
      end if
      if (record%key(1) == 'end') exit
      r = row_of(build, record%text(1))
      if (r == 0) then
        call pass_unknown(build, deck, record, error)
      else
        call read_word(build, deck, record, r, error)
      end if
      if (allocated(error) .or. build%ended) return
    end do
  end subroutine read_words

  !> FEAP has TIE, and PARAmeters, also between the END of the mesh and BATCh.
  subroutine read_ties(build, deck, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record

    do
      call deck%next(record, error)
      if (allocated(error)) return
      if (record%is_blank()) cycle
      if (record%key(1) /= 'tie' .and. record%key(1) /= 'para') exit
      call read_word(build, deck, record, row_of(build, record%text(1)), error)
      if (allocated(error)) return
    end do
    call deck%put_back(record)
  end subroutine read_ties

  !> FEAP's manual writes `BOUNdary conditions`: words of explanation behind a word that has lists.
  pure function without_remark(record) result(plain)
    type(record_t), intent(in) :: record
    type(record_t) :: plain
    integer :: i

    plain = record
    if (all(record%key(1) /= ['coor', 'boun', 'forc', 'disp', 'fpro', 'bloc'])) return
    do i = 2, record%n
      if (all(record%key(i) /= ['cond', 'rest', 'code', 'data', 'node', 'all '])) return
    end do
    plain%n = 1
  end function without_remark

  !> One known word; after an error reading goes on behind its set.
  subroutine read_word(build, deck, record, r, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: r
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: found
    procedure(mesh_read_i), pointer :: read
    character(:), allocatable :: belongs

    belongs = closed_hint(build, record)
    build%in_set = build%row(r)%has_set
    build%keeps_comments = any(build%row(r)%name == OURS)
    if (build%in_set) then
      build%closed = r
      build%closed_place = record%place(1)
      build%closed_line = 0
    end if
    read => build%row(r)%read
    call read (build, deck, without_remark(record), found)
    if (.not. allocated(found)) return
    if (len(belongs) > 0 .and. found%place%line == record%line) found%hint = belongs
    if (build%row(r)%name == 'PARAmeters' .or. record%assigns() .or. found%code /= DECK_ERROR) then
      call move_alloc(found, error) ! what follows would fail without the parameters
      return
    end if
    call build%errors%add(found)
    call deck%stop_loops()
    call skip_set(build, deck, error)
  end subroutine read_word

  !> Where a record would belong to the set closed last: how to put it there. Else empty.
  function closed_hint(build, record) result(hint)
    type(build_t), intent(in) :: build
    type(record_t), intent(in) :: record
    character(:), allocatable :: hint
    logical :: belongs
    character(4) :: key

    hint = ''
    key = record%key(1)
    if (build%closed == 0 .or. build%in_set .or. build%closed_line == 0) return
    associate (row => build%row(build%closed))
      belongs = index(' '//trim(row%records)//' ', ' '//trim(upper(record%key(1)))//' ') > 0
      if (row%has_numbers) belongs = belongs .or. scan(key, '0123456789') == 1
      if (row%name == 'PARAmeters') belongs = record%assigns()
      if (belongs) hint = quoted(record%text(1))//' may belong to '//trim(row%name) &
                          //', which the blank record in line ' &
                          //to_text(build%closed_line)//' closed'
    end associate
  end function closed_hint

  pure function upper(key) result(text)
    character(4), intent(in) :: key
    character(4) :: text
    integer :: i

    text = key
    do i = 1, 4
      if (key(i:i) >= 'a' .and. key(i:i) <= 'z') text(i:i) = achar(iachar(key(i:i)) - 32)
    end do
  end function upper

  !> An unknown word and the nearest known one; its records are passed over.
  subroutine pass_unknown(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: found
    type(record_t) :: next
    character(:), allocatable :: hint, word
    integer :: r
    logical :: to_blank

    word = nearest(record%text(1), build%row%name)
    r = row_of(build, word)
    to_blank = build%row(r)%has_set .and. .not. build%row(r)%has_numbers
    hint = closed_hint(build, record)
    if (len(hint) == 0) then
      hint = 'nearest known: '//word
    else
      to_blank = .true.
    end if
    call fail(found, DECK_ERROR, 'unknown word '//quoted(record%text(1)), record%place(1), hint)
    if (record%assigns()) then
      call move_alloc(found, error) ! what follows would fail without the parameter
      return
    end if
    call build%errors%add(found)
    call deck%stop_loops()
    build%incomplete = .true.
    do
      if (any(word == OURS)) then
        call deck%next_in_block(next, error)
      else
        call deck%next_of_set(next, error)
      end if
      if (allocated(error) .or. next%is_blank()) return
      if (to_blank .and. .not. (next%is_end() .or. next%key(1) == 'end' &
                                .or. next%key(1) == 'batc')) cycle
      if (next%kind == RECORD_WORDS .and. .not. known_word(build, next%text(1))) cycle
      build%has_pending = .true.
      build%pending = next
      return
    end do
  end subroutine pass_unknown

  !> Each stage needs the one before: errors of a stage are collected, then it ends.
  subroutine finish(build)
    type(build_t), intent(inout) :: build

    call check_references(build)
    if (.not. build%incomplete) call count_mesh(build)
    if (build%errors%count() > 0) return
    associate (model => build%model)
      call make_mesh(build, model%mesh)
      if (build%errors%count() == 0) call make_bodies(build, model%mesh)
      if (build%errors%count() > 0) return
      call mark_used(model%mesh)
      call check_size(build, model%mesh)
      if (build%errors%count() > 0) return
      call tabulate_basis(model%mesh) ! surface loads ask for its rules
      call apply_conditions(build, model%mesh, model%bc)
      call tie_nodes(build, model%mesh, model%bc)
      call close_constraints(build, model%mesh)
      if (build%errors%count() > 0) return
      call resolve_supports(build, model)
      call hold_rigid(build, model)
      call release_slaves(build, model%mesh, model%bc)
      call resolve_loads(build, model)
      call note_loose(build, model%mesh, model%bc)
      call find_unread(build%aside, model%unread)
      call resolve_curves(build, model)
      if (build%errors%count() > 0) return
      call check_jacobians(build, model%mesh)
      if (build%errors%count() > 0) return
      call build_contacts(build, model)
      if (build%errors%count() > 0) return
      call integrate_loads(model)
    end associate
  end subroutine finish

  !> NPATch bodies on the given control points, then the patches in deck order.
  subroutine make_bodies(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable :: error
    integer :: i

    do i = 1, size(build%npatch)
      if (build%npatch(i)%is_geometry) cycle
      call append_npatch(build, i, mesh, error)
      if (allocated(error)) call build%errors%add(error)
    end do
    do i = 1, size(build%patch)
      associate (p => build%patch(i))
        p%spec%material = material_index(build, p%material)
        if (p%spec%geometry == GEO_SPLINE) then
          call make_spline(build, p%spec, mesh, error)
        else if (p%spec%geometry == GEO_MESH) then
          call make_mesh_body(build, i, mesh, error)
        else
          if (p%npatch > 0) call npatch_geometry(build, p%npatch, p%spec%nurbs, error)
          if (.not. allocated(error)) call build_body(p%spec, mesh, error)
        end if
      end associate
      if (allocated(error)) call build%errors%add(error)
    end do
  end subroutine make_bodies

  !> Nodes that elements use.
  subroutine mark_used(mesh)
    type(mesh_t), intent(inout) :: mesh
    integer :: b, e

    mesh%used = .false.
    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        mesh%used(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
  end subroutine mark_used

  !> Neither nothing nor too much.
  subroutine check_size(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error

    if (any(mesh%used) .and. all(is_rigid(mesh%block))) then
      call fail(error, DECK_ERROR, 'all bodies are rigid', build%control%place, &
                'give a body that can be deformed')
    else if (.not. any(mesh%used)) then
      call fail(error, DECK_ERROR, 'the mesh has no elements', build%control%place, &
                'give ELEMents, BLOCk, NPATch, PATCh or MESH')
    else if (mesh%nnode > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'the mesh has '//to_text(mesh%nnode)//' nodes', &
                build%control%place, &
                'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
    end if
    if (allocated(error)) call build%errors%add(error)
  end subroutine check_size

end module input_model
