!> PATCh: a body by its name and its records.
!!
!! The records of a PATCh, one reader each.
!!
!! The records of a PATCh that say what it is and where: BOX, HEMIsphere, NPATch, FILE, ROTAte,
!! TRANslate.
module word_patch
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t, get_integer, get_real
  use patch_spec, only: GEO_NONE, patch_spec_t, enrich_t, placement_t, GEO_BOX, GEO_HEMISPHERE, &
      GEO_NURBS
  use input_draft, only: build_t, patch_entry_t, next_line
  use input_record, only: check_record
  use input_where, only: read_face
  use base_kinds, only: wp
  use spline_file, only: read_patch_file
  implicit none
  private
  public :: read_patch, patch_named, check_patch_name, append_patch, read_line, read_geometry, &
            read_placement, read_reals

  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp

  character(*), parameter, public :: TYPES = 'known types: Q1 Q1E9 Q2 IGA RIGId'
  integer, parameter :: MAX_POINT = 16

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

  !> BOX, HEMIsphere, NPATch or FILE.
  subroutine read_geometry(deck, line, patch, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error

    select case (line%key(1))
    case ('box')
      call read_box(deck, line, patch%spec, error)
    case ('hemi')
      call read_hemisphere(deck, line, patch%spec, error)
    case ('npat')
      call check_count(line, 2, 2, 'NPATch k, the k-th solid of the NPATch records', error)
      if (allocated(error)) return
      call get_integer(deck, line, 2, patch%npatch, error)
      if (allocated(error)) return
      patch%npatch_place = line%place(2)
      if (patch%npatch < 1) call fail(error, DECK_ERROR, 'NPATch '//to_text(patch%npatch), &
                                      line%place(2), 'NPATch solids are counted from 1')
      patch%spec%geometry = GEO_NURBS
    case default ! FILE
      call check_count(line, 2, 3, 'FILE path [name]', error)
      if (allocated(error)) return
      call read_patch_file(resolve_path(line, 2), line%text(3), patch%spec%nurbs, line%place(2), &
                           error)
      patch%spec%geometry = GEO_NURBS
    end select
  end subroutine read_geometry

  !> BOX x0 y0 z0  lx ly lz.
  subroutine read_box(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6)
    integer :: i

    call check_count(line, 7, 7, 'BOX x0 y0 z0  lx ly lz', error)
    if (.not. allocated(error)) call read_reals(deck, line, 2, x, error)
    if (allocated(error)) return
    do i = 4, 6
      if (x(i) > 0.0_wp) cycle
      call fail(error, DECK_ERROR, 'a box of length '//to_text(x(i))//' in direction ' &
                //to_text(i - 3), line%place(i + 1), 'lengths are positive')
      return
    end do
    spec%geometry = GEO_BOX
    spec%origin = x(:3)
    spec%length = x(4:)
  end subroutine read_box

  !> HEMIsphere radius thickness [x0 y0 z0].
  subroutine read_hemisphere(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(5)

    x = 0.0_wp
    call check_count(line, 3, 6, 'HEMIsphere radius thickness [x0 y0 z0]', error)
    if (.not. allocated(error)) call read_reals(deck, line, 2, x(:line%n - 1), error)
    if (allocated(error)) return
    if (.not. x(1) > 0.0_wp) then
      call fail(error, DECK_ERROR, 'a hemisphere of radius '//to_text(x(1)), line%place(2), &
                'the radius is positive')
      return
    else if (.not. (x(2) > 0.0_wp .and. x(2) < x(1))) then
      call fail(error, DECK_ERROR, 'a hemisphere of radius '//to_text(x(1))//' and thickness ' &
                //to_text(x(2)), line%place(3), 'the thickness lies between 0 and the radius')
      return
    end if
    spec%geometry = GEO_HEMISPHERE
    spec%radius = x(1)
    spec%thickness = x(2)
    spec%origin = x(3:5)
  end subroutine read_hemisphere

  subroutine read_reals(deck, line, first, x, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: first
    real(wp), intent(inout) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(x)
      call get_real(deck, line, first + i - 1, x(i), error)
      if (allocated(error)) return
    end do
  end subroutine read_reals

  !> ROTAte px py pz  ax ay az  deg, or TRANslate dx dy dz.
  subroutine read_placement(deck, line, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    type(placement_t) :: p
    real(wp) :: x(7), length

    p%rotates = line%key(1) == 'rota'
    if (p%rotates) then
      call check_count(line, 8, 8, 'ROTAte px py pz  ax ay az  degrees', error)
      if (.not. allocated(error)) call read_reals(deck, line, 2, x, error)
      if (allocated(error)) return
      length = norm2(x(4:6))
      if (.not. length > 0.0_wp) then
        call fail(error, DECK_ERROR, 'the axis of rotation has no length', line%place(5), &
                  'ROTAte px py pz  ax ay az  degrees')
        return
      end if
      p%point = x(:3)
      p%axis = x(4:6)/length
      p%angle = x(7)*DEGREE
    else
      call check_count(line, 4, 4, 'TRANslate dx dy dz', error)
      if (.not. allocated(error)) call read_reals(deck, line, 2, p%point, error)
      if (allocated(error)) return
    end if
    spec%placement = [spec%placement, p]
  end subroutine read_placement

end module word_patch
