!> The records of a PATCh, one reader each.
module setup_patch_record
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use patch_spec, only: patch_spec_t, enrich_t, GEO_NONE
  use setup_build, only: patch_entry_t
  use setup_patch_shape, only: read_geometry, read_placement, read_reals
  use setup_where, only: read_face
  implicit none
  private
  public :: read_line

  character(*), parameter, public :: TYPES = 'known types: Q1 Q1E9 Q2 IGA RIGId'
  integer, parameter :: MAX_POINT = 16

contains

  !> One record.
  subroutine read_line(deck, line, patch, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error

    select case (line%key(1))
    case ('box', 'hemi', 'npat', 'file')
      if (patch%spec%geometry /= GEO_NONE) then
        call fail(error, DECK_ERROR, 'patch '//quoted(patch%spec%name)//' has two geometries', &
                  line%place(1), &
                  'give one of BOX, HEMIsphere, NPATch and FILE')
        return
      end if
      call read_geometry(deck, line, patch, error)
    case ('rota', 'tran')
      call read_placement(deck, line, patch%spec, error)
    case ('elem')
      call read_elements(deck, line, patch%spec, error)
    case ('knot')
      call read_knots(deck, line, patch%spec, error)
    case ('type')
      call read_type(deck, line, patch%spec, error)
    case ('enri')
      call read_enrich(deck, line, patch%spec, error)
    case ('quad')
      call read_quadrature(deck, line, patch%spec, error)
    case default ! MATErial
      call check_count(line, 2, 2, 'MATErial m', error)
      if (allocated(error)) return
      call get_integer(deck, line, 2, patch%material, error)
      patch%material_place = line%place(2)
    end select
  end subroutine read_line

  !> ELEMents n1 n2 n3.
  subroutine read_elements(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: d, n

    call check_count(line, 4, 4, 'ELEMents n1 n2 n3', error)
    do d = 1, 3
      if (allocated(error)) return
      call get_integer(deck, line, d + 1, n, error)
      if (allocated(error)) return
      if (n < 1) then
        call fail(error, DECK_ERROR, to_text(n)//' elements in direction '//to_text(d), &
                  line%place(d + 1), &
                  'numbers of elements are positive')
      else if (spec%nelem(d) > 0 .and. spec%nelem(d) /= n) then
        call fail(error, DECK_ERROR, 'ELEMents and KNOTs disagree in direction '//to_text(d), &
                  line%place(d + 1), &
                  'the KNOTs make '//to_text(spec%nelem(d))//' elements')
      end if
      spec%nelem(d) = n
    end do
  end subroutine read_elements

  !> KNOTs,dir list: interior knots.
  subroutine read_knots(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i

    call check_count(line, 3, huge(1), 'KNOTs,direction and its interior knots', error)
    if (.not. allocated(error)) call get_integer(deck, line, 2, d, error)
    if (allocated(error)) return
    if (d < 1 .or. d > 3) then
      call fail(error, DECK_ERROR, 'direction '//to_text(d), line%place(2), &
                'directions are 1, 2 and 3')
    else if (allocated(spec%knots(d)%u)) then
      call fail(error, DECK_ERROR, 'KNOTs of direction '//to_text(d)//' stand twice', &
                line%place(2), &
                'keep one of them')
    end if
    if (allocated(error)) return
    allocate (spec%knots(d)%u(line%n - 2))
    call read_reals(deck, line, 3, spec%knots(d)%u, error)
    if (allocated(error)) return
    do i = 2, line%n - 2
      if (spec%knots(d)%u(i) > spec%knots(d)%u(i - 1)) cycle
      call fail(error, DECK_ERROR, 'the knots do not rise', line%place(i + 2), &
                'list them in rising order')
      return
    end do
    if (spec%nelem(d) > 0 .and. spec%nelem(d) /= line%n - 1) then
      call fail(error, DECK_ERROR, 'ELEMents and KNOTs disagree in direction '//to_text(d), &
                line%place(2), 'the KNOTs make '//to_text(line%n - 1)//' elements')
    end if
    spec%nelem(d) = line%n - 1
  end subroutine read_knots

  !> TYPE Q1 | Q1E9 | Q2 | IGA p | RIGId.
  subroutine read_type(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 3, 'TYPE Q1, Q1E9, Q2, IGA p or RIGId', error)
    if (allocated(error)) return
    select case (lower(line%text(2)))
    case ('q1')
      spec%type = 'Q1'
    case ('q1e9')
      spec%type = 'Q1E9'
    case ('q2')
      spec%type = 'Q2'
    case ('iga')
      spec%type = 'IGA'
      call check_count(line, 3, 3, 'TYPE IGA p', error)
      if (.not. allocated(error)) call get_integer(deck, line, 3, spec%degree, error)
      return
    case default
      if (line%key(2) /= 'rigi') then
        call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(2)), &
                  line%place(2), TYPES)
        return
      end if
      spec%type = 'RIGID'
    end select
    call check_count(line, 2, 2, 'TYPE '//line%text(2), error)
  end subroutine read_type

  !> ENRIch face p [RAISe t] [EAS [TAPEred]].
  subroutine read_enrich(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'ENRIch face p [RAISe t] [EAS [TAPEred]]'
    type(enrich_t) :: e
    type(enrich_t), allocatable :: longer(:)
    integer :: i

    call check_count(line, 3, 7, USAGE, error)
    if (allocated(error)) return
    e%place = line%place(2)
    call read_face(line, 2, e%face, error)
    if (.not. allocated(error)) call get_integer(deck, line, 3, e%degree, error)
    if (allocated(error)) return
    i = 4
    do while (i <= line%n)
      select case (line%key(i))
      case ('rais')
        i = i + 1
        call get_integer(deck, line, i, e%raise, error)
        if (allocated(error)) return
        if (e%raise < 0) call fail(error, DECK_ERROR, 'RAISe '//to_text(e%raise), line%place(i), &
                                   'orders are raised by 0 or more')
      case ('eas')
        e%eas = .true.
      case ('tape')
        e%tapered = .true.
        if (.not. e%eas) call fail(error, DECK_ERROR, 'TAPEred without EAS', line%place(i), USAGE)
      case default
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of ENRIch', &
                  line%place(i), USAGE)
      end select
      if (allocated(error)) return
      i = i + 1
    end do
    allocate (longer(size(spec%enrich) + 1))
    longer(:size(spec%enrich)) = spec%enrich
    longer(size(longer)) = e
    call move_alloc(longer, spec%enrich)
  end subroutine read_enrich

  !> QUADrature q [qz].
  subroutine read_quadrature(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n

    call check_count(line, 2, 3, 'QUADrature q [qz]', error)
    do i = 2, line%n
      if (allocated(error)) return
      call get_integer(deck, line, i, n, error)
      if (allocated(error)) return
      if (n < 1 .or. n > MAX_POINT) then
        call fail(error, DECK_ERROR, to_text(n)//' integration points', line%place(i), &
                  '1 to '//to_text(MAX_POINT)//' points in each direction')
      end if
      if (i == 2) spec%q = n
      if (i == 3) spec%qz = n
    end do
  end subroutine read_quadrature

end module setup_patch_record
