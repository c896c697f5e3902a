!> The model while its deck is read: what was said so far, and the errors found.
!!
!! What the words of the mesh part said, before their names and numbers are resolved.
module input_draft
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR, error_list_t
  use base_text, only: to_text, quoted, key_of
  use contact_spec, only: contact_spec_t
  use deck_record, only: record_t, RECORD_WORDS
  use deck_stream, only: deck_t, get_real
  use model, only: model_t
  use unread_constraints, only: unread_constraints_t
  use input_lists, only: node_list_t, element_list_t, mention_list_t, place_list_t, MAX_NUMBER
  use boundary, only: motion_t, pressure_t
  use curve_type, only: quantity_t
  use mesh_body, only: mesh_spec_t
  use patch_spec, only: patch_spec_t
  use input_where, only: where_t
  implicit none
  private
  public :: build_t, mesh_word_t, mesh_read_i, patch_entry_t, npatch_t, knot_vector_t, support_t, &
            move_t, press_t, column_t, curve_entry_t, request_t, tie_t, control_t, next_data, &
            next_line, skip_set, known_word, check_number, row_of

  !> FEAP's control record; zeros are counted.
  type :: control_t
    integer :: numnp = 0, numel = 0, nummat = 0, nen = 0
    type(place_t) :: place
  end type control_t

  !> A PATCh, MESH or SPLIne before its names and numbers are resolved.
  type :: patch_entry_t
    type(patch_spec_t) :: spec
    integer :: material = 0            !! the user's number
    integer :: npatch = 0              !! its geometry is this NPATch
    type(mesh_spec_t) :: mesh          !! MESH
    type(place_t) :: material_place, npatch_place
  end type patch_entry_t

  !> NPATch solid: a tri-variate patch by the numbers of its knot vectors and control points.
  type :: npatch_t
    integer :: material = 0
    integer :: n(3) = 0                !! control points
    integer :: knot(3) = 0             !! numbers of the knot vectors
    integer, allocatable :: node(:, :, :) !! (n1, n2, n3)
    logical :: is_geometry = .false.   !! a PATCh uses it
    type(place_t) :: place
  end type npatch_t

  !> KNOTs.
  type :: knot_vector_t
    integer :: number = 0
    real(wp), allocatable :: u(:)
    type(place_t) :: place
  end type knot_vector_t

  !> FIX.
  type :: support_t
    type(where_t) :: at
    integer :: code(3) = 0
  end type support_t

  !> MOVE.
  type :: move_t
    type(where_t) :: at
    type(motion_t) :: motion
  end type move_t

  !> PRESsure.
  type :: press_t
    type(where_t) :: at
    type(pressure_t) :: pressure
  end type press_t

  !> One record of a CURVe.
  type :: column_t
    type(where_t) :: at                !! kind 0: none is needed
    type(quantity_t) :: quantity
    character(:), allocatable :: body  !! name of a patch; not allocated: none
    type(place_t) :: body_place
    character(:), allocatable :: contact !! name of a contact; not allocated: none
    type(place_t) :: contact_place
  end type column_t

  type :: curve_entry_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(column_t), allocatable :: column(:)
  end type curve_entry_t

  !> A record of EBOU EDIS EFOR EPRO CBOU CDIS CFOR CSUR, applied at the END of the mesh.
  type :: request_t
    integer :: kind = 0
    logical :: adds = .false.
    integer :: direction = 0           !! of a plane; 0: a point or a surface
    real(wp) :: at(3) = 0.0_wp         !! point; at(1) is a plane's coordinate [L]
    real(wp) :: gap = -1.0_wp          !! GAP; negative: FEAP's default
    real(wp) :: value(3) = 0.0_wp
    real(wp), allocatable :: surface(:, :) !! (4, 9) points of a surface [L] and pressures [F/L^2]
    type(place_t) :: place
  end type request_t

  !> TIE.
  type :: tie_t
    integer :: from = 1, to = huge(1)  !! nodes
    integer :: material(2) = 0         !! the user's numbers; 0: all
    integer :: direction = 0           !! of a plane; 0: everywhere
    real(wp) :: coordinate = 0.0_wp    !! [L]
    real(wp) :: tolerance = 0.0_wp     !! share of the mesh's extent; 0: FEAP's default
    type(place_t) :: place
  end type tie_t

  !> A mesh word: how it is spelled and who reads it.
  type :: mesh_word_t
    character(16) :: name = ''         !! its first four letters count, or all where there are fewer
    character(96) :: records = ''      !! words that stand in its block
    logical :: has_set = .false.       !! records up to a blank one follow
    logical :: has_numbers = .false.   !! and they begin with a number
    procedure(mesh_read_i), pointer, nopass :: read => null()
  end type mesh_word_t

  !> Everything the readers fill.
  type :: build_t
    type(model_t) :: model
    type(error_list_t) :: errors
    type(mesh_word_t), allocatable :: row(:)
    type(control_t) :: control
    type(node_list_t) :: nodes
    type(element_list_t) :: elements
    type(mention_list_t) :: mention
    type(place_list_t) :: places
    type(unread_constraints_t) :: aside             !! tables beside the files of the mesh
    real(wp) :: turn(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1]*1.0_wp, [3, 3]) !! TRAN
    real(wp) :: shift(3) = 0.0_wp
    integer :: last_node = 0, last_element = 0, last_material = 0 !! of the last BLOC
    type(patch_entry_t), allocatable :: patch(:)
    type(npatch_t), allocatable :: npatch(:)
    type(knot_vector_t), allocatable :: knots(:)
    type(support_t), allocatable :: support(:)
    integer :: nsupport = 0
    type(move_t), allocatable :: move(:)
    integer :: nmove = 0
    type(press_t), allocatable :: press(:)
    integer :: npress = 0
    type(contact_spec_t), allocatable :: contact(:)
    type(curve_entry_t), allocatable :: curve(:)
    integer :: ncurve = 0
    integer :: nrequest = 0
    type(request_t), allocatable :: request(:) !! (>= nrequest)
    type(tie_t), allocatable :: tie(:)
    logical :: ended = .false.         !! the deck ended inside a set
    logical :: incomplete = .false.    !! an unknown word was skipped: names may be missing
    logical :: in_set = .false.        !! reading stands between a word and its blank record
    logical :: keeps_comments = .false. !! in this set a comment does not count as blank
    integer :: closed = 0              !! row whose set was closed last
    type(place_t) :: closed_place      !! where that set began
    integer :: closed_line = 0         !! and where it ended
    logical :: has_pending = .false.
    type(record_t) :: pending          !! a word that ended a set that had no blank record
  end type build_t

  abstract interface
    !> Read a mesh word: `record` is its first one, further ones come from the deck.
    subroutine mesh_read_i(build, deck, record, error)
      import :: build_t, deck_t, record_t, error_t
      implicit none
      type(build_t), intent(inout) :: build
      type(deck_t), intent(inout) :: deck
      type(record_t), intent(in) :: record
      type(error_t), allocatable, intent(out) :: error
    end subroutine mesh_read_i
  end interface

contains

  !> Row of the word in field i; 0: unknown.
  pure integer function row_of(build, text) result(r)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: text

    do r = size(build%row), 1, -1
      if (key_of(build%row(r)%name) == key_of(text)) return
    end do
  end function row_of

  pure logical function known_word(build, text) result(known)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: text

    known = row_of(build, text) > 0 .or. key_of(text) == 'end' .or. key_of(text) == 'batc'
  end function known_word

  !> Next record of a FEAP data set; `more` is false at its blank record.
  subroutine next_data(build, deck, record, more, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(out) :: error

    build%keeps_comments = .false.
    call deck%next_of_set(record, error)
    call judge(build, deck, record, more, error)
  end subroutine next_data

  !> Next record of one of our own blocks, in which comments do not count.
  subroutine next_line(build, deck, record, more, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(out) :: error

    build%keeps_comments = .true.
    call deck%next_in_block(record, error)
    call judge(build, deck, record, more, error)
  end subroutine next_line

  !> What a record means inside a set.
  subroutine judge(build, deck, record, more, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(inout) :: error
    type(error_t), allocatable :: not_a_number
    real(wp) :: x

    more = .false.
    if (allocated(error)) return
    if (record%is_blank()) then
      build%in_set = .false.
      build%closed_line = record%line
    else if (record%is_end()) then
      build%in_set = .false.
      build%ended = .true.
      build%incomplete = .true.
      call fail(error, DECK_ERROR, 'the deck ends inside '//trim(build%row(build%closed)%name), &
                build%closed_place, 'close it with a blank record, and the mesh with END')
    else
      more = .true.
      if (.not. ends_set(build, record)) return
      call get_real(deck, record, 1, x, not_a_number)
      if (.not. allocated(not_a_number)) return
      more = .false.
      build%in_set = .false.
      build%has_pending = .true.
      build%pending = record
      call fail(error, DECK_ERROR, quoted(record%text(1))//' stands inside ' &
                //trim(build%row(build%closed)%name)//' of line ' &
                //to_text(build%closed_place%line), record%place(1), &
                'close '//trim(build%row(build%closed)%name)//' with a blank record')
    end if
  end subroutine judge

  !> A word that cannot belong to the set: the blank record was forgotten.
  pure logical function ends_set(build, record) result(ends)
    type(build_t), intent(in) :: build
    type(record_t), intent(in) :: record

    ends = .false.
    if (record%n < 1 .or. build%closed == 0) return
    associate (row => build%row(build%closed))
      if (row%has_numbers) then
        ends = known_word(build, record%text(1))
      else
        ends = any(record%key(1) == [character(4) :: 'end', 'batc', 'patc', 'spli', 'mesh', &
                                     'curv', 'fix', 'move'])
        if (record%key(1) == 'cont') ends = index(row%records, 'CONT') == 0
      end if
    end associate
  end function ends_set

  !> After an error: on to the blank record of the set.
  subroutine skip_set(build, deck, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record

    do while (build%in_set)
      if (build%keeps_comments) then
        call deck%next_in_block(record, error)
      else
        call deck%next_of_set(record, error)
      end if
      if (allocated(error)) return
      if (record%kind == RECORD_WORDS) then
        if (.not. ends_set(build, record)) cycle
        build%has_pending = .true.
        build%pending = record
      end if
      build%in_set = .false.
    end do
  end subroutine skip_set

  !> A node or element number that a list can hold.
  subroutine check_number(what, n, place, error)
    character(*), intent(in) :: what
    integer, intent(in) :: n
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    if (n < 1) then
      call fail(error, DECK_ERROR, what//' number '//to_text(n), place, &
                'numbers are positive; a blank record ends the data')
    else if (n > MAX_NUMBER) then
      call fail(error, DECK_ERROR, what//' number '//to_text(n)//' is larger than ' &
                //to_text(MAX_NUMBER), &
                place, 'a mesh has at most '//to_text(MAX_NUMBER)//' nodes and elements')
    end if
  end subroutine check_number

end module input_draft
