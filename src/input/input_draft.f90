!> The model while its deck is read: records whose names and numbers are not yet resolved, and the
!! errors found so far. Also reads the records of a set.
module input_draft
  use base_error, only: error_t, place_t, fail, DECK_ERROR, error_list_t
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, key_of
  use boundary, only: motion_t, pressure_t
  use contact_pair, only: contact_t
  use curve_type, only: quantity_t
  use deck_record, only: record_t, RECORD_COMMENT, RECORD_WORDS
  use deck_stream, only: deck_t, get_real
  use input_lists, only: node_list_t, element_list_t, named_nodes_t, place_list_t, MAX_NUMBER
  use input_where, only: where_t
  use mesh_body, only: mesh_spec_t
  use model, only: model_t
  use patch_spec, only: patch_spec_t
  use unread_constraints, only: unread_constraints_t
  implicit none
  private
  public :: draft_t, mesh_word_t, mesh_read_i, patch_entry_t, npatch_entry_t, knot_vector_t, &
            support_entry_t, motion_entry_t, pressure_entry_t, contact_entry_t, column_entry_t, &
            curve_entry_t, condition_entry_t, tie_entry_t, last_element_t, next_data, next_line, &
            end_set, skip_set, known_word, check_number, check_increment, row_of

  integer, parameter :: MOST_RECORDS = 24 !! limit on the number of different words in a set

  !> FEAP's control record; the program counts the quantities that are 0 here.
  type :: control_t
    integer :: numnp = 0, numel = 0, nummat = 0, nen = 0
    type(place_t) :: place
  end type control_t

  !> A PATCh, MESH or SPLIne before its names and numbers are resolved.
  type :: patch_entry_t
    type(patch_spec_t) :: spec
    integer :: material = 0            !! the user's number
    integer :: npatch = 0  !! number of the NPATch that gives its geometry; 0: none
    type(mesh_spec_t) :: mesh          !! spec of a MESH
    type(place_t) :: material_place, npatch_place
  end type patch_entry_t

  !> NPATch: a trivariate patch, given by the numbers of its knot vectors and control points.
  type :: npatch_entry_t
    integer :: material = 0            !! the user's number
    integer :: n(3) = 0                !! control points
    integer :: knot(3) = 0             !! numbers of the knot vectors
    integer, allocatable :: node(:, :, :) !! (n1, n2, n3)
    logical :: is_geometry = .false.   !! .true.: geometry of a PATCh, not a body of its own
    type(place_t) :: place
  end type npatch_entry_t

  !> A knot vector of KNOTs.
  type :: knot_vector_t
    integer :: number = 0
    real(wp), allocatable :: u(:)
    type(place_t) :: place
  end type knot_vector_t

  !> A FIX record.
  type :: support_entry_t
    type(where_t) :: at
    integer :: code(3) = 0
    integer, allocatable :: node(:)    !! after TIE
  end type support_entry_t

  !> A MOVE record.
  type :: motion_entry_t
    type(where_t) :: at
    type(motion_t) :: motion
  end type motion_entry_t

  !> A PRESsure record.
  type :: pressure_entry_t
    type(where_t) :: at
    type(pressure_t) :: pressure
  end type pressure_entry_t

  !> One record of a CURVe.
  type :: column_entry_t
    type(where_t) :: at                !! type 0: the quantity needs no WHERE
    type(quantity_t) :: quantity
    character(:), allocatable :: body  !! name of a patch; not allocated: the whole model
    type(place_t) :: body_place
    character(:), allocatable :: contact !! name of a contact; not allocated: none
    type(place_t) :: contact_place
  end type column_entry_t

  !> CONTact: the values that its records give, and the places of records that only the input needs.
  type :: contact_entry_t
    type(contact_t) :: contact
    type(where_t) :: at(2)             !! SURFaces
    type(place_t) :: scheme_place
    type(place_t) :: bond_place, pair_place, refine_place !! places of BONDed, PAIR and REFIne
    !! in the deck; their `file` is not allocated if there is no such record
  end type contact_entry_t

  !> A CURVe.
  type :: curve_entry_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(column_entry_t), allocatable :: column(:)
  end type curve_entry_t

  integer, parameter, public :: C_FIXED = 1, C_VALUE = 2, C_FORCE = 3, C_TABLE = 4 !! conditions of
  !! nodes: restraints, prescribed displacements, forces, load numbers

  !> A record of EBOU, EDIS, EFOR, EPRO, CBOU, CDIS, CFOR or CSUR. Such a condition is given by
  !! position and is applied at the END of the mesh.
  type :: condition_entry_t
    integer :: word = 0                !! number of the word: R_EBOU to R_CSUR
    logical :: adds = .false.          !! add the values to those of other records
    logical :: sets = .false.          !! the deck says SET
    integer :: direction = 0           !! normal of a plane; 0: a point or a surface
    real(wp) :: at(3) = 0.0_wp         !! point, or coordinate of a plane in at(1) [L]
    real(wp) :: gap = -1.0_wp          !! GAP [L]; negative: FEAP's default
    real(wp) :: value(3) = 0.0_wp      !! codes, displacements [L], forces [F] or load numbers
    real(wp), allocatable :: surface(:, :) !! (4, 9) points [L] and pressures [F/L^2]
    type(place_t) :: place
  end type condition_entry_t

  !> A TIE record.
  type :: tie_entry_t
    integer :: from = 1, to = huge(1)  !! range of nodes
    integer :: material(2) = 0         !! the user's numbers; 0: all materials
    integer :: direction = 0           !! normal of a plane; 0: the whole mesh
    real(wp) :: coordinate = 0.0_wp    !! [L]
    real(wp) :: tolerance = 0.0_wp     !! fraction of the mesh's extent; 0: FEAP's default
    type(place_t) :: place
  end type tie_entry_t

  !> The last element of an ELEMents, if its record gives an increment.
  type :: last_element_t
    integer :: number = 0, increment = 0
    integer :: place = 0               !! index into the list of places
  end type last_element_t

  !> A mesh word: its spelling, the data that follow it, and its reader.
  type :: mesh_word_t
    character(16) :: name = ''         !! only the first four letters count
    character(4) :: records(MOST_RECORDS) = '' !! keys of the words that begin records of its set
    logical :: has_set = .false.       !! a set follows: records up to a blank one
    logical :: has_numbers = .false.   !! the records of its set begin with a number
    procedure(mesh_read_i), pointer, nopass :: read => null()
  end type mesh_word_t

  !> All data that the readers of the mesh part read.
  type :: draft_t
    type(model_t), allocatable :: model
    type(error_list_t) :: errors
    type(mesh_word_t), allocatable :: row(:)
    type(control_t) :: control
    type(node_list_t) :: nodes
    type(element_list_t) :: elements
    type(named_nodes_t) :: named_nodes
    type(place_list_t) :: places
    logical :: node_twice = .false.      !! the warning about nodes given twice was issued
    logical :: twice(4) = .false. !! a warning about nodes that BOUN, DISP, FORC or FPRO gives twice
    !! was issued (C_FIXED, C_VALUE, C_FORCE, C_TABLE)
    type(unread_constraints_t) :: tables !! constraint tables next to mesh files, and those read
    !> TRANsform: a position x becomes turn x + shift [L].
    real(wp) :: turn(3, 3) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1]*1.0_wp, [3, 3])
    real(wp) :: shift(3) = 0.0_wp
    type(place_t), allocatable :: idle_transform !! a TRANsform that nothing has followed so far
    integer :: last_node = 0, last_element = 0, last_material = 0 !! last numbers of the last BLOCk
    type(patch_entry_t), allocatable :: patch(:)
    type(npatch_entry_t), allocatable :: npatch(:)
    type(knot_vector_t), allocatable :: knots(:)
    type(support_entry_t), allocatable :: support(:)
    integer :: nsupport = 0
    type(motion_entry_t), allocatable :: motion(:)
    integer :: nmotion = 0
    type(pressure_entry_t), allocatable :: pressure(:)
    integer :: npressure = 0
    type(contact_entry_t), allocatable :: contact(:)
    type(curve_entry_t), allocatable :: curve(:)
    integer :: ncurve = 0
    integer :: ncondition = 0
    type(condition_entry_t), allocatable :: condition(:) !! (>= ncondition)
    type(tie_entry_t), allocatable :: tie(:)
    type(last_element_t), allocatable :: last_of_set(:)
    logical :: ended = .false.         !! the deck ended inside a set
    logical :: incomplete = .false.    !! definitions may be missing, because an unknown word was
    !! skipped or the deck ended inside a set
    logical :: in_set = .false.        !! between a word and the blank record of its set
    logical :: skips_comments = .false. !! skip comments in the set instead of closing it
    integer :: closed = 0 !! row of the word of this set or, between sets, of the last one
    type(place_t) :: closed_place      !! place where that set begins
    integer :: closed_line = 0         !! line of the record that closed that set; 0: none
    character(:), allocatable :: closed_by !! 'blank record' or 'comment line'
    logical :: has_pending = .false.
    type(record_t) :: pending          !! a word that closed a set without a blank record
  end type draft_t

  abstract interface
    !> Read a mesh word, beginning with its first record; the records of its set are read from the
    !! deck.
    subroutine mesh_read_i(draft, deck, record, error)
      import :: draft_t, deck_t, record_t, error_t
      implicit none
      type(draft_t), intent(inout) :: draft
      type(deck_t), intent(inout) :: deck
      type(record_t), intent(in) :: record
      type(error_t), allocatable, intent(out) :: error
    end subroutine mesh_read_i
  end interface

contains

  !> Row of a word; 0: it is unknown.
  pure integer function row_of(draft, text) result(r)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: text

    do r = size(draft%row), 1, -1
      if (key_of(draft%row(r)%name) == key_of(text)) return
    end do
  end function row_of

  pure logical function known_word(draft, text) result(known)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: text

    known = row_of(draft, text) > 0 .or. key_of(text) == 'end' .or. key_of(text) == 'batc'
  end function known_word

  !> Read the next record of a FEAP data set; `more` is false if it is the blank record at the end.
  subroutine next_data(draft, deck, record, more, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(out) :: error

    draft%skips_comments = .false.
    call next_in_set(draft, deck, record, more, error)
  end subroutine next_data

  !> Read the next record of a set that FEAP does not have; comments in it are skipped.
  subroutine next_line(draft, deck, record, more, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(out) :: error

    draft%skips_comments = .true.
    call next_in_set(draft, deck, record, more, error)
  end subroutine next_line

  !> Read a record and decide whether it belongs to the set, closes it, or shows that its blank
  !! record is missing.
  subroutine next_in_set(draft, deck, record, more, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    logical, intent(out) :: more
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: not_a_number
    character(:), allocatable :: name
    real(wp) :: x

    more = .false.
    call read_record(draft, deck, record, error)
    if (allocated(error)) return
    if (record%is_blank()) then
      draft%in_set = .false.
      draft%closed_line = record%line
      draft%closed_by = merge('comment line', 'blank record', record%kind == RECORD_COMMENT)
    else if (record%is_end()) then
      draft%in_set = .false.
      draft%ended = .true.
      draft%incomplete = .true.
      call fail(error, DECK_ERROR, 'the deck ends inside '//trim(draft%row(draft%closed)%name), &
                draft%closed_place, 'close it with a blank record, and the mesh with END')
    else
      more = .true.
      if (.not. ends_set(draft, record)) return
      call get_real(deck, record, 1, x, not_a_number) ! a parameter may have the name of a word
      if (.not. allocated(not_a_number)) return
      more = .false.
      draft%in_set = .false.
      draft%has_pending = .true.
      draft%pending = record
      name = trim(draft%row(draft%closed)%name)
      call fail(error, DECK_ERROR, 'expected a record of '//name//' (begun in line ' &
                //to_text(draft%closed_place%line)//'), found '//quoted(record%text(1)), &
                record%place(1), 'close '//name//' with a blank record')
    end if
  end subroutine next_in_set

  subroutine read_record(draft, deck, record, error)
    type(draft_t), intent(in) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    if (draft%skips_comments) then
      call deck%next_in_block(record, error)
    else
      call deck%next_of_set(record, error)
    end if
  end subroutine read_record

  !> Does the record begin with a mesh word that cannot belong to the set? If so, the blank record
  !! is missing.
  pure logical function ends_set(draft, record) result(ends)
    type(draft_t), intent(in) :: draft
    type(record_t), intent(in) :: record

    ends = .false.
    if (record%n < 1 .or. draft%closed == 0) return
    associate (row => draft%row(draft%closed))
      if (row%has_numbers) then
        ends = known_word(draft, record%text(1))
      else
        ends = any(record%key(1) == [character(4) :: 'end', 'batc', 'patc', 'spli', 'mesh', &
                                     'curv', 'fix', 'move'])
        if (record%key(1) == 'cont') ends = all(row%records /= 'cont')
      end if
    end associate
  end function ends_set

  !> Skip the rest of the set after an error.
  subroutine skip_set(draft, deck, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record

    do while (draft%in_set)
      call read_record(draft, deck, record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_WORDS) then
        if (.not. ends_set(draft, record)) cycle
        draft%has_pending = .true.
        draft%pending = record
      end if
      draft%in_set = .false.
    end do
  end subroutine skip_set

  !> End a data set of FEAP at a record whose first field is 0 or empty. Fail if another of its
  !! fields is neither empty nor 0, since the record then has data that would be lost.
  subroutine end_set(draft, deck, record, numbers, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    character(*), intent(in) :: numbers !! what a first field may be, for the hint
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: not_a_number
    character(:), allocatable :: field
    real(wp) :: x
    integer :: i

    do i = 2, record%n
      call get_real(deck, record, i, x, not_a_number, 0.0_wp)
      if (.not. (allocated(not_a_number) .or. abs(x) > 0.0_wp)) cycle
      field = 'a 0 in the first field'
      if (record%is_empty(1)) field = 'an empty first field'
      call fail(error, DECK_ERROR, field//' ends the data of ' &
                //trim(draft%row(draft%closed)%name)//', but this record has other values', &
                record%place(1), 'to end the set, leave a blank record; '//numbers)
      return
    end do
    draft%in_set = .false.
  end subroutine end_set

  !> Fail if the number of a node, an element, a control point or a knot vector is not positive or
  !! is too large for a list.
  subroutine check_number(what, n, place, error)
    character(*), intent(in) :: what
    integer, intent(in) :: n
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    if (n < 1) then
      call fail(error, DECK_ERROR, what//' number '//to_text(n)//' is not positive', place, &
                'numbers begin at 1; to end the set, leave a blank record')
    else if (n > MAX_NUMBER) then
      call fail(error, DECK_ERROR, what//' number '//to_text(n)//' is larger than ' &
                //to_text(MAX_NUMBER), &
                place, 'numbers may be from 1 to '//to_text(MAX_NUMBER))
    end if
  end subroutine check_number

  !> Check the increment of generated numbers: an increment beyond the limit would cause an
  !! overflow.
  subroutine check_increment(step, place, error)
    integer, intent(in) :: step
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    if (abs(step) > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'the increment '//to_text(step)//' is not between -' &
                //to_text(MAX_NUMBER)//' and '//to_text(MAX_NUMBER), place, &
                'numbers of nodes and elements are at most '//to_text(MAX_NUMBER))
    end if
  end subroutine check_increment

end module input_draft
