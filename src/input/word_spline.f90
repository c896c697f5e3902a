!> SPLIne: a spline surface from a file, as the outside of a layer or as a rigid tool.
module word_spline
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, lower
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t
  use patch_spec, only: GEO_SPLINE
  use unread_constraints, only: expect_table, note_table
  use input_draft, only: build_t, patch_entry_t, next_line
  use word_patch, only: check_patch_name, append_patch, read_line
  use input_record, only: check_record
  use spline_file, only: read_spline_file
  use spline_layer, only: read_layer, read_constraints
  implicit none
  private
  public :: read_spline

  character(12), parameter :: WORD(8) = ['LAYEr       ', 'CONStraint  ', 'QUADrature  ', &
                                         'TYPE        ', 'REVErse     ', 'ROTAte      ', &
                                         'TRANslate   ', 'MATErial    ']
  character(*), parameter :: TYPES = 'known types: Q1, Q1E9 [TAPEred] and RIGId'

contains

  subroutine read_spline(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(patch_entry_t) :: patch

    call check_count(record, 4, 5, 'SPLIne,name FILE path [surface]', error)
    if (.not. allocated(error)) call check_patch_name(build, record, error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    patch%spec%geometry = GEO_SPLINE
    patch%spec%type = 'LAYER'
    allocate (patch%spec%enrich(0), patch%spec%placement(0))
    call append_patch(build, patch) ! now: an error in its records must not make it unknown
    if (record%key(3) /= 'file') then
      call fail(error, DECK_ERROR, quoted(record%text(3))//' where FILE should stand', &
                record%place(3), 'SPLIne,name FILE path [surface]')
    else
      call read_spline_file(resolve_path(record, 4), record%text(5), patch%spec%spline%surface, &
                            record%place(4), error)
    end if
    if (.not. allocated(error)) call read_records(build, deck, patch, error)
    if (allocated(error)) return
    if (patch%spec%type == 'RIGID') then
      call check_tool(patch, error)
    else
      call check_layered(patch, error)
    end if
    build%patch(size(build%patch)) = patch
  end subroutine read_spline

  !> Up to the blank record.
  subroutine read_records(build, deck, patch, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    logical :: more, seen(size(WORD))

    seen = .false.
    do
      call next_line(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      call check_record(line, WORD, 'rota tran', 'SPLIne', 'spline '//quoted(patch%spec%name), &
                        seen, error)
      if (.not. allocated(error)) call read_record(build, deck, line, patch, error)
      if (allocated(error)) return
    end do
  end subroutine read_records

  subroutine read_record(build, deck, line, patch, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
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
        call expect_table(build%aside, resolve_path(line, 2), line%place(2))
      case ('cons')
        call check_count(line, 2, 2, 'CONStraint path', error)
        if (allocated(error)) return
        s%constraint_place = line%place(1)
        call read_constraints(resolve_path(line, 2), s%constraint, line%place(2), error)
        call note_table(build%aside, resolve_path(line, 2))
      case ('type')
        call read_type(line, patch, error)
      case ('reve')
        call check_count(line, 1, 1, 'REVErse', error)
        s%reverse = .true.
        s%reverse_place = line%place(1)
      case default
        call read_line(deck, line, patch, error)
      end select
    end associate
  end subroutine read_record

  !> TYPE Q1 | Q1E9 [TAPEred] | RIGId.
  subroutine read_type(line, patch, error)
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 3, 'TYPE Q1, Q1E9 [TAPEred] or RIGId', error)
    if (allocated(error)) return
    associate (s => patch%spec%spline)
      if (line%key(2) == 'rigi') then
        patch%spec%type = 'RIGID'
      else if (lower(line%text(2)) == 'q1e9') then
        s%eas = .true.
      else if (lower(line%text(2)) /= 'q1') then
        call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(2))//' of a layer', &
                  line%place(2), TYPES)
        return
      end if
      if (line%n == 2) return
      s%tapered = s%eas .and. line%key(3) == 'tape'
      if (.not. s%tapered) call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(3)) &
                                     //' of TYPE', line%place(3), TYPES)
    end associate
  end subroutine read_type

  !> A layer has inner nodes and a material; it lies where its mesh lies.
  subroutine check_layered(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error

    associate (spec => patch%spec)
      if (.not. spec%spline%has_layer) then
        call fail(error, DECK_ERROR, 'spline '//quoted(spec%name)//' has no LAYEr', spec%place, &
                  'give LAYEr path, or TYPE RIGId for a tool')
      else if (.not. allocated(patch%material_place%file)) then
        call fail(error, DECK_ERROR, 'spline '//quoted(spec%name)//' has no MATErial', spec%place, &
                  'give MATErial m')
      else if (spec%spline%reverse) then
        call fail(error, DECK_ERROR, 'the layer of spline '//quoted(spec%name)//' has REVErse', &
                  spec%spline%reverse_place, &
                  'remove it: the inner nodes tell which side is inside')
      else if (size(spec%placement) > 0) then
        call fail(error, DECK_ERROR, 'the layer of spline '//quoted(spec%name) &
                  //' has ROTAte or TRANslate', spec%place, &
                  'remove them: it lies where its inner nodes lie')
      end if
    end associate
  end subroutine check_layered

  !> A rigid surface moves, nothing else.
  subroutine check_tool(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: what

    what = ''
    if (patch%spec%spline%has_layer) what = 'LAYEr'
    if (allocated(patch%spec%spline%constraint_place%file)) what = 'CONStraint'
    if (patch%spec%q > 0) what = 'QUADrature'
    if (allocated(patch%material_place%file)) what = 'MATErial'
    if (len(what) == 0) return
    call fail(error, DECK_ERROR, 'the rigid spline '//quoted(patch%spec%name)//' has '//what, &
              patch%spec%place, 'remove it: a rigid surface is moved, not deformed')
  end subroutine check_tool

end module word_spline
