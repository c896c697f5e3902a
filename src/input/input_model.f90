!> Builds, from the records of a deck, a model that can be solved.
module input_model
  use base_error, only: error_t, fail, DECK_ERROR, error_list_t
  use base_text, only: to_text, quoted, nearest
  use condition_doubts, only: warn_supports_kept, warn_added, warn_unused, warn_planes_inside, &
                              warn_same_nodes, note_loose
  use deck_feap, only: mesh_hint
  use deck_record, only: record_t, check_numbers, RECORD_WORDS
  use deck_stream, only: deck_t
  use input_check, only: check_references, check_size, check_jacobians
  use input_collapsed, only: warn_collapsed
  use input_conditions, only: apply_conditions
  use input_constraint, only: close_constraints, release_slaves
  use input_contact, only: build_contacts
  use input_doubts, only: check_twice, warn_twisted, warn_locking
  use input_draft, only: draft_t, mesh_read_i, skip_set, row_of, known_word
  use input_idle, only: note_idle_materials, warn_idle_bodies, warn_idle_loads, &
                        warn_idle_transform, warn_increments
  use input_inside, only: warn_inside
  use input_loads, only: integrate_loads
  use input_mesh, only: make_mesh, count_mesh, make_bodies
  use input_mismatch, only: warn_mismatch
  use input_motion, only: count_motions_once, report_moved_supports
  use input_numbers, only: warn_numbers
  use input_overlap, only: warn_overlaps
  use input_resolve, only: follow_ties, resolve_supports, resolve_loads, resolve_curves
  use input_rigid, only: hold_rigid
  use input_tie, only: find_tied, tie_nodes
  use input_touching, only: warn_touching
  use input_twice, only: warn_repeated_conditions
  use input_untied, only: warn_hanging, warn_untied
  use mesh, only: place_origin
  use mesh_seam, only: leave_inner_faces
  use model, only: model_t
  use model_basis, only: tabulate_basis
  use unread_constraints, only: find_unread
  use word_control, only: read_title, read_control
  use word_table, only: load_mesh_words
  implicit none
  private
  public :: build_model

  !> Words whose sets FEAP does not have; comments in these sets are skipped.
  character(8), parameter :: OURS(5) = ['PATCh   ', 'SPLIne  ', 'MESH    ', 'CURVe   ', 'CONTact ']

contains

  !> Read the mesh part of a deck and make the model; `model` is allocated in any case.
  subroutine build_model(deck, model, errors, error)
    type(deck_t), intent(inout) :: deck
    type(model_t), allocatable, intent(out) :: model
    type(error_list_t), intent(inout) :: errors      !! independent errors of the deck
    type(error_t), allocatable, intent(out) :: error !! an error after which reading cannot continue
    type(draft_t) :: draft
    integer, allocatable :: tied(:) ! (nnode) the node that replaces each node after TIE
    logical, allocatable :: told(:, :) ! (nbody, nbody) pairs of bodies that were warned about
    logical, allocatable :: restrained(:, :) ! (3, nnode) by BOUN, EBOU and CBOU

    call load_mesh_words(draft%row)
    allocate (draft%model)
    allocate (draft%model%material(0), draft%model%contact(0), draft%patch(0), draft%npatch(0))
    allocate (draft%knots(0), draft%support(0), draft%contact(0))
    allocate (draft%motion(0), draft%pressure(0), draft%curve(0), draft%tie(0))
    allocate (draft%last_of_set(0))
    call read_mesh_part(draft, deck, error)
    stages: block ! each stage needs the previous one; errors end the sequence
      if (allocated(error)) exit stages
      call check_references(draft)
      if (.not. draft%incomplete) call count_mesh(draft)
      if (draft%errors%count() > 0) exit stages
      associate (mesh => draft%model%mesh, bc => draft%model%bc)
        call make_mesh(draft, mesh)
        if (draft%errors%count() == 0) call make_bodies(draft, mesh)
        if (draft%errors%count() == 0) call check_size(draft, mesh)
        if (draft%errors%count() > 0) exit stages
        call tabulate_basis(mesh) ! surface loads need the quadrature rules
        call warn_numbers(draft, mesh)
        call warn_increments(draft)
        call warn_idle_transform(draft)
        call find_tied(draft, mesh, tied)
        call warn_repeated_conditions(draft)
        call warn_same_nodes(draft, mesh, tied)
        call check_jacobians(draft, mesh) ! before surfaces are sought on misnumbered elements
        call apply_conditions(draft, mesh, tied, bc)
        call tie_nodes(tied, mesh)
        call leave_inner_faces(mesh)
        call follow_ties(draft, tied)
        call close_constraints(draft, mesh)
        if (draft%errors%count() > 0) exit stages
        restrained = bc%fixed /= 0 ! without FIX
        call resolve_supports(draft, draft%model)
        call warn_supports_kept(draft, mesh)
        call hold_rigid(draft, draft%model)
        call count_motions_once(draft, mesh%nnode, bc)
        call report_moved_supports(draft, mesh%xr, restrained, bc)
        call warn_planes_inside(draft, mesh, tied, bc)
        call release_slaves(draft, draft%model)
        call resolve_loads(draft, draft%model)
        call warn_added(draft, mesh, tied, bc)
        call warn_unused(draft, mesh, tied)
        call note_loose(draft, mesh, bc)
        call find_unread(draft%tables, draft%model%unread)
        call resolve_curves(draft, draft%model)
        if (draft%errors%count() > 0) exit stages
        call check_jacobians(draft, mesh) ! TIE may have joined nodes of an element
        if (draft%errors%count() == 0) call check_twice(draft, mesh)
        if (draft%errors%count() > 0) exit stages
        call warn_twisted(draft, mesh)
        call warn_collapsed(draft, mesh, bc)
        call warn_locking(draft, mesh)
        call note_idle_materials(draft, mesh)
        call warn_idle_loads(draft, mesh, tied, bc)
        call place_origin(mesh)
        call build_contacts(draft, draft%model)
        if (draft%errors%count() > 0) exit stages
        call warn_untied(draft, mesh, told)
        call warn_hanging(mesh, draft%model%contact, tied)
        call warn_touching(draft, mesh, draft%model%contact, told)
        call warn_mismatch(draft, mesh, told)
        call warn_overlaps(mesh, draft%model%contact, told)
        call warn_inside(draft, mesh, draft%model%contact)
        call warn_idle_bodies(mesh, draft%model%contact)
        call integrate_loads(draft%model)
      end associate
    end block stages
    errors = draft%errors
    call move_alloc(draft%model, model)
  end subroutine build_model

  !> Read the title, the control record, one word after another up to END, and the TIE and
  !! PARAmeters after it.
  subroutine read_mesh_part(draft, deck, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: r

    call read_title(draft, deck, error)
    if (allocated(error)) return
    call read_control(draft, deck, error)
    if (allocated(error)) then
      if (error%code /= DECK_ERROR) return
      call draft%errors%add(error)
      deallocate (error)
    end if
    do
      if (draft%has_pending) then
        record = draft%pending
        draft%has_pending = .false.
      else
        call deck%next(record, error)
        if (allocated(error)) return
      end if
      if (record%is_blank()) cycle
      if (record%is_end() .or. any(record%key(1) == ['batc', 'inte', 'stop'])) then
        call fail(error, DECK_ERROR, 'the mesh has no END', record%place(1), &
                  'close the mesh with END, before BATCh')
        return
      end if
      if (record%key(1) == 'end') then
        call check_numbers(record, 2, 'END takes no numbers', error)
        if (allocated(error)) return
        exit
      end if
      r = row_of(draft, record%text(1))
      if (r == 0) then
        call skip_unknown(draft, deck, record, error)
      else
        call read_word(draft, deck, record, r, error)
      end if
      if (allocated(error) .or. draft%ended) return
    end do
    do ! FEAP also allows TIE and PARAmeters between END and BATCh
      call deck%next(record, error)
      if (allocated(error)) return
      if (record%is_blank()) cycle
      if (record%key(1) /= 'tie' .and. record%key(1) /= 'para') exit
      call read_word(draft, deck, record, row_of(draft, record%text(1)), error)
      if (allocated(error)) return
    end do
    call deck%put_back(record)
  end subroutine read_mesh_part

  !> Read a known word and its set; after an error, skip the rest of the set.
  subroutine read_word(draft, deck, record, r, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: r !! row of the word
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: found
    type(record_t) :: plain
    procedure(mesh_read_i), pointer :: read
    character(:), allocatable :: belongs
    logical :: explained
    integer :: i

    belongs = closed_hint(draft, record)
    draft%in_set = draft%row(r)%has_set
    draft%skips_comments = any(draft%row(r)%name == OURS)
    if (draft%in_set) then
      draft%closed = r
      draft%closed_place = record%place(1)
      draft%closed_line = 0
    end if
    explained = any(record%key(1) == ['coor', 'boun', 'forc', 'disp', 'fpro', 'bloc'])
    do i = 2, record%n
      explained = explained .and. any(record%key(i) == ['cond', 'rest', 'code', 'data', 'node', &
                                                        'all '])
    end do
    plain = record
    if (explained) plain%n = 1 ! words of explanation, as in FEAP's `BOUNdary conditions`
    read => draft%row(r)%read
    call read (draft, deck, plain, found)
    if (.not. allocated(found)) return
    if (len(belongs) > 0 .and. found%place%line == record%line) found%hint = belongs
    if (draft%row(r)%name == 'PARAmeters' .or. record%assigns() .or. found%code /= DECK_ERROR) then
      call move_alloc(found, error) ! the records that follow would fail without the parameters
      return
    end if
    call draft%errors%add(found)
    call deck%stop_loops()
    call skip_set(draft, deck, error)
  end subroutine read_word

  !> Hint for a record that may belong to the set that was closed last; empty if it cannot.
  function closed_hint(draft, record) result(hint)
    type(draft_t), intent(in) :: draft
    type(record_t), intent(in) :: record
    character(:), allocatable :: hint
    logical :: belongs
    character(4) :: key

    hint = ''
    key = record%key(1)
    if (draft%closed == 0 .or. draft%in_set .or. draft%closed_line == 0) return
    associate (row => draft%row(draft%closed))
      belongs = any(row%records == key .and. row%records /= '')
      if (row%has_numbers) belongs = belongs .or. scan(key, '0123456789') == 1
      if (row%name == 'PARAmeters') belongs = record%assigns()
      if (belongs) hint = quoted(record%text(1))//' may belong to '//trim(row%name) &
                          //', which the '//draft%closed_by//' in line ' &
                          //to_text(draft%closed_line)//' closed'
    end associate
  end function closed_hint

  !> Report an unknown word with a hint, and skip the records that seem to belong to it. The hint
  !! names the set that the record may belong to, what to use instead of a word of FEAP, or else
  !! the most similar known word.
  subroutine skip_unknown(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: found
    type(record_t) :: next
    character(:), allocatable :: hint, word
    integer :: r
    logical :: to_blank

    word = nearest(record%text(1), draft%row%name)
    r = row_of(draft, word)
    to_blank = draft%row(r)%has_set .and. .not. draft%row(r)%has_numbers
    hint = closed_hint(draft, record)
    if (len(hint) > 0) then
      to_blank = .true.
    else
      hint = mesh_hint(record%text(1))
      if (len(hint) == 0) hint = 'nearest known: '//word
    end if
    call fail(found, DECK_ERROR, 'unknown word '//quoted(record%text(1)), record%place(1), hint)
    if (record%assigns()) then
      call move_alloc(found, error) ! the records that follow would fail without the parameter
      return
    end if
    call draft%errors%add(found)
    call deck%stop_loops()
    draft%incomplete = .true.
    do
      if (any(word == OURS)) then
        call deck%next_in_block(next, error)
      else
        call deck%next_of_set(next, error)
      end if
      if (allocated(error) .or. next%is_blank()) return
      if (to_blank .and. .not. (next%is_end() .or. next%key(1) == 'end' &
                                .or. next%key(1) == 'batc')) cycle
      if (next%kind == RECORD_WORDS .and. .not. known_word(draft, next%text(1))) cycle
      draft%has_pending = .true.
      draft%pending = next
      return
    end do
  end subroutine skip_unknown

end module input_model
