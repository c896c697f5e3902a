!> MESH: a body from the mesh file of another program.
module word_mesh
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, nearest, lower, key_of, to_text
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t, get_integer, get_real
  use format_feap, only: read_feap
  use format_gmsh, only: read_gmsh
  use mesh_body, only: mesh_spec_t, mesh_material_t
  use patch_spec, only: patch_spec_t, placement_t, GEO_MESH
  use format_text, only: load_text, fail_in_file
  use unread_constraints, only: expect_table, note_table
  use input_draft, only: build_t, patch_entry_t, next_line
  use word_patch, only: check_patch_name, append_patch, read_placement
  use spline_layer, only: read_constraints
  implicit none
  private
  public :: read_mesh

  character(12), parameter :: WORD(7) = ['ROTAte      ', 'TRANslate   ', 'SCALe       ', &
                                         'TYPE        ', 'MATErial    ', 'CONStraint  ', &
                                         '            ']

contains

  !> MESH,name FILE path and its records.
  subroutine read_mesh(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(patch_entry_t) :: patch
    type(error_t), allocatable :: broken
    type(record_t) :: line
    logical :: more, typed

    call check_count(record, 4, 4, 'MESH,name FILE path', error)
    if (.not. allocated(error)) call check_patch_name(build, record, error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    patch%spec%geometry = GEO_MESH
    allocate (patch%spec%enrich(0), patch%spec%placement(0), patch%mesh%material(0))
    call append_patch(build, patch) ! now: an error in its records must not make it unknown
    if (record%key(3) /= 'file') then
      call fail(error, DECK_ERROR, quoted(record%text(3))//' where FILE should stand', &
                record%place(3), 'MESH,name FILE path')
      return
    end if
    call read_file(record, patch%mesh, broken)
    call expect_table(build%aside, resolve_path(record, 4), record%place(4))
    typed = .false.
    do
      call next_line(build, deck, line, more, error)
      if (allocated(error)) exit
      if (.not. more) exit
      call read_line(build, deck, line, patch, typed, error)
      if (allocated(error)) exit
    end do
    if (allocated(broken)) call build%errors%add(broken)
    if (allocated(error)) return
    if (size(patch%mesh%material) == 0) then
      call fail(error, DECK_ERROR, 'mesh '//quoted(patch%spec%name)//' has no MATErial', &
                patch%spec%place, 'give MATErial m')
      return
    end if
    patch%mesh%spec = patch%spec
    build%patch(size(build%patch)) = patch
  end subroutine read_mesh

  !> The format is told by the first word.
  subroutine read_file(record, mesh, error)
    type(record_t), intent(in) :: record
    type(mesh_spec_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer :: first

    call load_text(resolve_path(record, 4), record%place(4), mesh%text, error)
    if (allocated(error)) return
    associate (text => mesh%text)
      first = max(1, verify(text%all, ' '//achar(9)//achar(10)//achar(13)))
      if (index(text%all(first:), '$MeshFormat') == 1) then
        call read_gmsh(text, mesh%file, error)
        return
      end if
      text%comment = '!'
      select case (lower(text%all(first:min(first + 3, len(text%all)))))
      case ('coor', 'elem', '!   ')
        call read_feap(text, mesh%file, error)
      case default
        if (text%all(first:min(first, len(text%all))) == '!') then
          call read_feap(text, mesh%file, error)
        else
          call fail_in_file(text, 'unknown format of a mesh file', error, &
                        'known formats: Gmsh 2.2 and 4.1 in ASCII, and FEAP records ' &
                        //'(COORdinates, ELEMents)')
        end if
      end select
    end associate
  end subroutine read_file

  subroutine read_line(build, deck, line, patch, typed, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    logical, intent(inout) :: typed
    type(error_t), allocatable, intent(out) :: error
    type(placement_t) :: p

    select case (line%key(1))
    case ('rota', 'tran')
      call read_placement(deck, line, patch%spec, error)
    case ('scal')
      call check_count(line, 2, 2, 'SCALe factor', error)
      if (.not. allocated(error)) call get_real(deck, line, 2, p%scale, error)
      if (allocated(error)) return
      if (.not. p%scale > 0.0_wp) call fail(error, DECK_ERROR, 'a mesh scaled by ' &
                                            //to_text(p%scale), line%place(2), &
                                            'the factor is positive')
      patch%spec%placement = [patch%spec%placement, p]
    case ('type')
      if (typed) call fail(error, DECK_ERROR, 'TYPE stands twice in mesh ' &
                           //quoted(patch%spec%name), line%place(1), 'keep one of them')
      typed = .true.
      if (.not. allocated(error)) call read_type(line, patch%spec, error)
    case ('mate')
      call read_material(deck, line, patch%mesh, error)
    case ('cons')
      call check_count(line, 2, 2, 'CONStraint path', error)
      if (allocated(error)) return
      patch%mesh%constraint_place = line%place(2)
      call read_constraints(resolve_path(line, 2), patch%mesh%constraint, line%place(2), error)
      call note_table(build%aside, resolve_path(line, 2))
    case default
      call fail(error, DECK_ERROR, 'unknown record '//quoted(line%text(1))//' of a MESH', &
                line%place(1), 'nearest known: '//nearest(line%text(1), WORD))
    end select
  end subroutine read_line

  !> TYPE Q1 | Q1E9: of hexahedra of eight nodes.
  subroutine read_type(line, spec, error)
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 2, 'TYPE Q1 or Q1E9', error)
    if (allocated(error)) return
    select case (lower(line%text(2)))
    case ('q1')
      spec%type = 'Q1'
    case ('q1e9')
      spec%type = 'Q1E9'
    case default
      call fail(error, DECK_ERROR, 'unknown type '//quoted(line%text(2))//' of a MESH', &
                line%place(2), 'Q1 and Q1E9 are types of its hexahedra of 8 nodes; other ' &
                //'elements are what the file says')
    end select
  end subroutine read_type

  !> MATErial m [group].
  subroutine read_material(deck, line, mesh, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(mesh_spec_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(mesh_material_t), allocatable :: longer(:)
    integer :: n

    call check_count(line, 2, 3, 'MATErial m [group]', error)
    if (allocated(error)) return
    n = size(mesh%material)
    allocate (longer(n + 1))
    longer(:n) = mesh%material
    call get_integer(deck, line, 2, longer(n + 1)%number, error)
    if (allocated(error)) return
    longer(n + 1)%place = line%place(2)
    if (line%n > 2) then
      longer(n + 1)%group = line%text(3)
      longer(n + 1)%group_place = line%place(3)
    end if
    call move_alloc(longer, mesh%material)
  end subroutine read_material

end module word_mesh
