!> MESH: a body from the mesh file of another program.
module word_mesh
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: quoted, lower, to_text
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t, get_integer, get_real
  use format_feap, only: read_feap
  use format_gmsh, only: read_gmsh
  use format_text, only: load_text, fail_in_file
  use input_draft, only: draft_t, patch_entry_t, next_line
  use input_record, only: check_record, record_word_t
  use mesh_body, only: mesh_spec_t, mesh_material_t
  use patch_spec, only: placement_t, GEO_MESH
  use spline_layer, only: read_constraints
  use unread_constraints, only: expect_table, note_table
  use word_patch, only: check_patch_name, append_patch, read_placement
  implicit none
  private
  public :: read_mesh

  type(record_word_t), parameter, public :: MESH_RECORDS(6) = [ &
                                            record_word_t('ROTAte', .true.), &
                                            record_word_t('TRANslate', .true.), &
                                            record_word_t('SCALe', .true.), record_word_t('TYPE'), &
                                            record_word_t('MATErial', .true.), &
                                            record_word_t('CONStraint', .true.)]

contains

  !> Read MESH,name FILE path and its records.
  subroutine read_mesh(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'MESH,name FILE path'
    type(patch_entry_t) :: patch
    type(error_t), allocatable :: broken
    type(record_t) :: line
    logical :: more, seen(size(MESH_RECORDS))

    call check_count(record, 4, 4, USAGE, error)
    if (.not. allocated(error)) call check_patch_name(draft, record, error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    patch%spec%geometry = GEO_MESH
    allocate (patch%spec%enrich(0), patch%spec%placement(0), patch%mesh%material(0))
    call append_patch(draft, patch) ! the name is known even if a record fails
    if (record%key(3) /= 'file') then
      call fail(error, DECK_ERROR, 'expected FILE, found '//quoted(record%text(3)), &
                record%place(3), USAGE)
      return
    end if
    call read_file(record, patch%mesh, broken)
    call expect_table(draft%tables, resolve_path(record, 4), record%place(4))
    seen = .false.
    do
      call next_line(draft, deck, line, more, error)
      if (allocated(error) .or. .not. more) exit
      call check_record(line, MESH_RECORDS, 'MESH', 'mesh '//quoted(patch%spec%name), seen, error)
      if (.not. allocated(error)) call read_record(draft, deck, line, patch, error)
      if (allocated(error)) exit
    end do
    patch%mesh%is_read = .not. allocated(broken)
    if (allocated(broken)) call draft%errors%add(broken)
    if (allocated(error)) return
    if (size(patch%mesh%material) == 0) then
      call fail(error, DECK_ERROR, 'mesh '//quoted(patch%spec%name)//' has no MATErial', &
                patch%spec%place, 'give MATErial m')
      return
    end if
    patch%mesh%spec = patch%spec
    draft%patch(size(draft%patch)) = patch
  end subroutine read_mesh

  !> Read the mesh file; its first word gives the format.
  subroutine read_file(record, mesh, error)
    type(record_t), intent(in) :: record
    type(mesh_spec_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer :: first

    call load_text(resolve_path(record, 4), record%place(4), mesh%text, error)
    if (allocated(error)) return
    associate (text => mesh%text)
      first = max(1, verify(text%all, ' '//achar(9)//achar(10)//achar(13)))
      ! other sections, such as $Comments, may precede $MeshFormat
      if (index(text%all(first:), '$') == 1 .and. index(text%all, '$MeshFormat') > 0) then
        call read_gmsh(text, mesh%file, error)
        return
      end if
      text%comment = '!'
      if (index(text%all(first:), '!') == 1 .or. &
          any(lower(text%all(first:min(first + 3, len(text%all)))) == ['coor', 'elem'])) then
        call read_feap(text, mesh%file, error)
      else
        call fail_in_file(text, 'unknown file format', error, 'known formats: Gmsh 2.2 and 4.1 ' &
                          //'in ASCII, and FEAP records (COORdinates, ELEMents)')
      end if
    end associate
  end subroutine read_file

  !> Read one record, whose word is known.
  subroutine read_record(draft, deck, line, patch, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error
    type(placement_t) :: p
    type(mesh_material_t) :: m

    select case (line%key(1))
    case ('rota', 'tran')
      call read_placement(deck, line, patch%spec, error)
    case ('scal')
      call check_count(line, 2, 2, 'SCALe factor', error)
      if (.not. allocated(error)) call get_real(deck, line, 2, p%scale, error)
      if (allocated(error)) return
      if (.not. p%scale > 0.0_wp) call fail(error, DECK_ERROR, 'scale factor '//to_text(p%scale) &
                                            //' is not positive', line%place(2), &
                                            'give a positive factor')
      patch%spec%placement = [patch%spec%placement, p]
    case ('type')
      call check_count(line, 2, 2, 'TYPE Q1 or Q1E9', error)
      if (allocated(error)) return
      select case (lower(line%text(2)))
      case ('q1')
        patch%spec%type = 'Q1'
      case ('q1e9')
        patch%spec%type = 'Q1E9'
      case default
        call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(2))//' of a MESH', &
                  line%place(2), 'TYPE is Q1 or Q1E9 and applies to hexahedra of 8 nodes; the ' &
                  //'file gives the type of all other elements')
      end select
    case ('mate')
      call check_count(line, 2, 3, 'MATErial m [group]', error)
      if (.not. allocated(error)) call get_integer(deck, line, 2, m%number, error)
      if (allocated(error)) return
      m%place = line%place(2)
      if (line%n > 2) then
        m%group = line%text(3)
        m%group_place = line%place(3)
      end if
      patch%mesh%material = [patch%mesh%material, m]
    case default ! CONStraint
      call check_count(line, 2, 2, 'CONStraint path', error)
      if (allocated(error)) return
      patch%mesh%constraint_place = line%place(2)
      call read_constraints(resolve_path(line, 2), patch%mesh%constraint, line%place(2), error)
      call note_table(draft%tables, resolve_path(line, 2))
    end select
  end subroutine read_record

end module word_mesh
