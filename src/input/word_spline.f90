!> SPLIne: a spline surface from a file, used as the outer face of a layer of elements or as a rigid
!! surface.
module word_spline
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, lower
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t
  use input_draft, only: draft_t, patch_entry_t, next_line
  use input_record, only: check_record, record_word_t
  use patch_spec, only: GEO_SPLINE
  use spline_file, only: read_spline_file
  use spline_layer, only: read_layer, read_constraints
  use unread_constraints, only: expect_table, note_table
  use word_patch, only: check_patch_name, append_patch, read_patch_record
  implicit none
  private
  public :: read_spline

  type(record_word_t), parameter, public :: SPLINE_RECORDS(8) = [ &
                                            record_word_t('LAYEr'), record_word_t('CONStraint'), &
                                            record_word_t('QUADrature'), record_word_t('TYPE'), &
                                            record_word_t('REVErse'), &
                                            record_word_t('ROTAte', .true.), &
                                            record_word_t('TRANslate', .true.), &
                                            record_word_t('MATErial')]
  character(*), parameter :: TYPES = 'known types: Q1, Q1E9 [TAPEred] and RIGId'

contains

  !> Read SPLIne,name FILE path [surface] and its records.
  subroutine read_spline(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'SPLIne,name FILE path [surface]'
    type(patch_entry_t) :: patch
    type(record_t) :: line
    logical :: more, seen(size(SPLINE_RECORDS))

    call check_count(record, 4, 5, USAGE, error)
    if (.not. allocated(error)) call check_patch_name(draft, record, error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    patch%spec%geometry = GEO_SPLINE
    patch%spec%type = 'LAYER'
    allocate (patch%spec%enrich(0), patch%spec%placement(0))
    call append_patch(draft, patch) ! the name is known even if a record fails
    if (record%key(3) /= 'file') then
      call fail(error, DECK_ERROR, 'expected FILE, found '//quoted(record%text(3)), &
                record%place(3), USAGE)
    else
      call read_spline_file(resolve_path(record, 4), record%text(5), patch%spec%spline%surface, &
                            record%place(4), error)
    end if
    if (allocated(error)) return
    seen = .false.
    do
      call next_line(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call check_record(line, SPLINE_RECORDS, 'SPLIne', 'spline '//quoted(patch%spec%name), &
                        seen, error)
      if (.not. allocated(error)) call read_record(draft, deck, line, patch, error)
      if (allocated(error)) return
    end do
    call check_complete(patch, error)
    draft%patch(size(draft%patch)) = patch
  end subroutine read_spline

  !> Read one record, whose word is known.
  subroutine read_record(draft, deck, line, patch, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error

    associate (s => patch%spec%spline)
      select case (line%key(1))
      case ('laye')
        call check_count(line, 2, 3, 'LAYEr path [name of a MESH]', error)
        if (allocated(error)) return
        s%has_layer = .true.
        s%layer_place = line%place(1)
        if (line%n > 2) s%mesh = line%text(3)
        s%mesh_place = line%place(3)
        call read_layer(resolve_path(line, 2), s%surface%nelem, s%inner, line%place(2), error)
        call expect_table(draft%tables, resolve_path(line, 2), line%place(2))
      case ('cons')
        call check_count(line, 2, 2, 'CONStraint path', error)
        if (allocated(error)) return
        s%constraint_place = line%place(1)
        call read_constraints(resolve_path(line, 2), s%constraint, line%place(2), error)
        call note_table(draft%tables, resolve_path(line, 2))
      case ('type')
        call check_count(line, 2, 3, 'TYPE Q1, Q1E9 [TAPEred] or RIGId', error)
        if (allocated(error)) return
        if (line%key(2) == 'rigi') then
          patch%spec%type = 'RIGID'
        else if (lower(line%text(2)) == 'q1e9') then
          s%eas = .true.
        else if (lower(line%text(2)) /= 'q1') then
          call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(2)) &
                    //' of a layer', line%place(2), TYPES)
          return
        end if
        if (line%n == 2) return
        s%tapered = s%eas .and. line%key(3) == 'tape'
        if (.not. s%tapered) call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(3)) &
                                       //' of TYPE', line%place(3), TYPES)
      case ('reve')
        call check_count(line, 1, 1, 'REVErse', error)
        s%reverse = .true.
        s%reverse_place = line%place(1)
      case default
        call read_patch_record(deck, line, patch, error)
      end select
    end associate
  end subroutine read_record

  !> Check for missing records. A layer needs a material and its inner nodes, which also define on
  !! which side it lies; a rigid surface can only be moved.
  subroutine check_complete(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name, extra

    name = 'spline '//quoted(patch%spec%name)
    associate (spec => patch%spec)
      if (spec%type == 'RIGID') then
        extra = ''
        if (spec%spline%has_layer) extra = 'LAYEr'
        if (allocated(spec%spline%constraint_place%file)) extra = 'CONStraint'
        if (spec%q > 0) extra = 'QUADrature'
        if (allocated(patch%material_place%file)) extra = 'MATErial'
        if (extra /= '') call fail(error, DECK_ERROR, 'rigid '//name//' has '//extra, &
                                   spec%place, 'remove it: a rigid surface does not deform')
      else if (.not. spec%spline%has_layer) then
        call fail(error, DECK_ERROR, name//' has no LAYEr', spec%place, &
                  "give 'LAYEr path', or 'TYPE RIGId' for a rigid surface")
      else if (.not. allocated(patch%material_place%file)) then
        call fail(error, DECK_ERROR, name//' has no MATErial', spec%place, 'give MATErial m')
      else if (spec%spline%reverse) then
        call fail(error, DECK_ERROR, name//' has REVErse and LAYEr', spec%spline%reverse_place, &
                  'remove REVErse: the inner nodes of the layer determine which side is inside')
      else if (size(spec%placement) > 0) then
        call fail(error, DECK_ERROR, name//' has LAYEr and ROTAte or TRANslate', spec%place, &
                  'remove them: the inner nodes determine where the layer lies, and it follows ' &
                  //'ROTAte, TRANslate and SCALe of its MESH')
      end if
    end associate
  end subroutine check_complete

end module word_spline
