!> PATCh: a body by its name and its records.
module setup_patch
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t
  use patch_spec, only: GEO_NONE
  use setup_build, only: build_t, patch_entry_t, next_line
  use setup_patch_record, only: read_line, TYPES
  use setup_record, only: check_record
  implicit none
  private
  public :: read_patch, patch_named, check_patch_name, append_patch

  character(12), parameter :: WORD(12) = ['BOX         ', 'HEMIsphere  ', 'NPATch      ', &
                                          'FILE        ', 'ROTAte      ', 'TRANslate   ', &
                                          'ELEMents    ', 'KNOTs       ', 'TYPE        ', &
                                          'ENRIch      ', 'QUADrature  ', 'MATErial    ']
  character(4), parameter :: RESERVED(3) = ['node', 'poin', 'plan']

contains

  !> Index of a patch by its name; 0: there is none.
  pure integer function patch_named(build, name) result(p)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name

    do p = size(build%patch), 1, -1
      if (lower(build%patch(p)%spec%name) == lower(name)) return
    end do
  end function patch_named

  subroutine read_patch(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(patch_entry_t) :: patch
    type(record_t) :: line
    logical :: more, seen(size(WORD))

    call check_count(record, 2, 2, 'PATCh,name', error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    call check_patch_name(build, record, error)
    if (allocated(error)) return
    allocate (patch%spec%enrich(0), patch%spec%placement(0))
    call append_patch(build, patch) ! now: an error in its records must not make it unknown
    seen = .false.
    do
      call next_line(build, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call check_record(line, WORD, 'rota tran knot enri', 'PATCh', &
                        'patch '//quoted(patch%spec%name), seen, error)
      if (.not. allocated(error)) call read_line(deck, line, patch, error)
      if (allocated(error)) return
    end do
    call check_complete(patch, error)
    build%patch(size(build%patch)) = patch
  end subroutine read_patch

  !> A name of its own that is no word of WHERE.
  subroutine check_patch_name(build, record, error)
    type(build_t), intent(in) :: build
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    if (any(record%key(2) == RESERVED) .or. record%is_empty(2)) then
      call fail(error, DECK_ERROR, 'a patch cannot be named '//quoted(record%text(2)), &
                record%place(2), &
                'NODE, POINt and PLANe have their own meaning where a patch may stand')
    else if (patch_named(build, record%text(2)) > 0) then
      call fail(error, DECK_ERROR, 'patch '//quoted(record%text(2))//' is defined twice', &
                record%place(2), &
                'the first one stands in line ' &
                //to_text(build%patch(patch_named(build, record%text(2)))%spec%place%line))
    end if
  end subroutine check_patch_name

  subroutine append_patch(build, patch)
    type(build_t), intent(inout) :: build
    type(patch_entry_t), intent(in) :: patch
    type(patch_entry_t), allocatable :: longer(:)
    integer :: n

    n = size(build%patch)
    allocate (longer(n + 1))
    longer(:n) = build%patch
    longer(n + 1) = patch
    call move_alloc(longer, build%patch)
  end subroutine append_patch

  !> What a patch cannot do without.
  subroutine check_complete(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error

    associate (spec => patch%spec)
      if (spec%geometry == GEO_NONE) then
        call complain('geometry', 'give BOX, HEMIsphere, NPATch or FILE')
      else if (spec%type == '') then
        call complain('TYPE', TYPES)
      else if (any(spec%nelem < 1)) then
        call complain('ELEMents', 'give ELEMents n1 n2 n3, or KNOTs in each direction')
      else if (spec%type == 'RIGID') then
        call check_bare(patch, error)
      else if (.not. allocated(patch%material_place%file)) then
        call complain('MATErial', 'give MATErial m')
      end if
    end associate

  contains

    subroutine complain(what, hint)
      character(*), intent(in) :: what, hint

      call fail(error, DECK_ERROR, 'patch '//quoted(patch%spec%name)//' has no '//what, &
                patch%spec%place, hint)
    end subroutine complain
  end subroutine check_complete

  !> A rigid patch is a surface that moves, nothing else.
  subroutine check_bare(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error

    if (allocated(patch%material_place%file)) then
      call fail(error, DECK_ERROR, 'the rigid patch '//quoted(patch%spec%name)//' has a MATErial', &
                patch%material_place, 'remove it: a rigid body is moved, not deformed')
    else if (size(patch%spec%enrich) > 0) then
      call fail(error, DECK_ERROR, 'the rigid patch '//quoted(patch%spec%name)//' is enriched', &
                patch%spec%enrich(1)%place, 'remove ENRIch: its faces are the geometry itself')
    else if (patch%spec%q > 0) then
      call fail(error, DECK_ERROR, 'the rigid patch '//quoted(patch%spec%name)//' has QUADrature', &
                patch%spec%place, 'remove it: the surface is not integrated')
    end if
  end subroutine check_bare

end module setup_patch
