!> PATCh: a body with a name, a geometry and an element type. MESH and SPLIne use the same placement
!! records and the same list of bodies.
module word_patch
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, lower
  use deck_record, only: record_t, check_count, resolve_path
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, patch_entry_t, next_line
  use input_fields, only: get_numbers, get_direction, get_axis
  use input_record, only: check_record, record_word_t, word_index, word_list
  use input_where, only: read_face
  use patch_spec, only: patch_spec_t, enrich_t, placement_t, GEO_NONE, GEO_BOX, GEO_HEMISPHERE, &
                        GEO_NURBS
  use spline_file, only: read_patch_file
  implicit none
  private
  public :: read_patch, patch_named, check_patch_name, append_patch, read_patch_record, &
            read_placement

  type(record_word_t), parameter, public :: PATCH_RECORDS(12) = [ &
                                            record_word_t('BOX'), record_word_t('HEMIsphere'), &
                                            record_word_t('NPATch'), record_word_t('FILE'), &
                                            record_word_t('ROTAte', .true.), &
                                            record_word_t('TRANslate', .true.), &
                                            record_word_t('ELEMents'), &
                                            record_word_t('KNOTs', .true.), record_word_t('TYPE'), &
                                            record_word_t('ENRIch', .true.), &
                                            record_word_t('QUADrature'), record_word_t('MATErial')]

  character(5), parameter :: TYPES(5) = ['Q1   ', 'Q1E9 ', 'Q2   ', 'IGA  ', 'RIGId']
  character(4), parameter :: RESERVED(3) = ['node', 'poin', 'plan'] !! other words of WHERE
  integer, parameter :: MAX_POINT = 16 !! integration points in one direction
  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp

contains

  !> Index of a patch by its name; 0: there is none.
  pure integer function patch_named(draft, name) result(p)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name

    do p = size(draft%patch), 1, -1
      if (lower(draft%patch(p)%spec%name) == lower(name)) return
    end do
  end function patch_named

  !> Read PATCh,name and its records.
  subroutine read_patch(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(patch_entry_t) :: patch
    type(record_t) :: line
    logical :: more, seen(size(PATCH_RECORDS))

    call check_count(record, 2, 2, 'PATCh,name', error)
    if (.not. allocated(error)) call check_patch_name(draft, record, error)
    if (allocated(error)) return
    patch%spec%name = record%text(2)
    patch%spec%place = record%place(2)
    allocate (patch%spec%enrich(0), patch%spec%placement(0))
    call append_patch(draft, patch) ! the name is known even if a record fails
    seen = .false.
    do
      call next_line(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call check_record(line, PATCH_RECORDS, 'PATCh', 'patch '//quoted(patch%spec%name), seen, &
                        error)
      if (.not. allocated(error)) call read_patch_record(deck, line, patch, error)
      if (allocated(error)) return
    end do
    call check_complete(patch, error)
    draft%patch(size(draft%patch)) = patch
  end subroutine read_patch

  !> Check that the name in field 2 is new and not a word of WHERE.
  subroutine check_patch_name(draft, record, error)
    type(draft_t), intent(in) :: draft
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    integer :: first

    first = patch_named(draft, record%text(2))
    if (any(record%key(2) == RESERVED) .or. record%is_empty(2)) then
      call fail(error, DECK_ERROR, 'a patch cannot be named '//quoted(record%text(2)), &
                record%place(2), &
                'choose another name: NODE, POINt and PLANe are reserved words')
    else if (is_npatch_name(lower(record%text(2)))) then
      call fail(error, DECK_ERROR, 'a patch cannot be named '//quoted(record%text(2)), &
                record%place(2), 'choose another name: npatch1, npatch2, ... are reserved for ' &
                //'NPATch')
    else if (first > 0) then
      call fail(error, DECK_ERROR, 'duplicate patch '//quoted(record%text(2)), record%place(2), &
                'the first one is in line '//to_text(draft%patch(first)%spec%place%line))
    end if
  end subroutine check_patch_name

  !> Is this the name of an NPATch, such as npatch1?
  pure logical function is_npatch_name(name)
    character(*), intent(in) :: name !! in lower case

    is_npatch_name = index(name, 'npatch') == 1 .and. len(name) > 6
    if (is_npatch_name) is_npatch_name = verify(name(7:), '0123456789') == 0
  end function is_npatch_name

  subroutine append_patch(draft, patch)
    type(draft_t), intent(inout) :: draft
    type(patch_entry_t), intent(in) :: patch
    type(patch_entry_t), allocatable :: longer(:)
    integer :: n

    n = size(draft%patch)
    allocate (longer(n + 1))
    longer(:n) = draft%patch
    longer(n + 1) = patch
    call move_alloc(longer, draft%patch)
  end subroutine append_patch

  !> Check for missing records. A deformable patch needs more records than a rigid one, which is
  !! only a surface.
  subroutine check_complete(patch, error)
    type(patch_entry_t), intent(in) :: patch
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name

    name = 'patch '//quoted(patch%spec%name)
    associate (spec => patch%spec, has_material => allocated(patch%material_place%file))
      if (spec%geometry == GEO_NONE) then
        call fail(error, DECK_ERROR, name//' has no geometry', spec%place, &
                  'give BOX, HEMIsphere, NPATch or FILE')
      else if (spec%type == '') then
        call fail(error, DECK_ERROR, name//' has no TYPE', spec%place, &
                  'known types: '//word_list(TYPES, ' '))
      else if (any(spec%nelem < 1)) then
        call fail(error, DECK_ERROR, name//' has no ELEMents', spec%place, &
                  "give 'ELEMents n1 n2 n3', or KNOTs in each direction")
      else if (spec%type /= 'RIGID') then
        if (.not. has_material) call fail(error, DECK_ERROR, name//' has no MATErial', &
                                          spec%place, 'give MATErial m')
      else if (has_material) then
        call fail(error, DECK_ERROR, 'rigid '//name//' has a MATErial', patch%material_place, &
                  'remove it: a rigid body does not deform')
      else if (size(spec%enrich) > 0) then
        call fail(error, DECK_ERROR, 'rigid '//name//' has ENRIch', spec%enrich(1)%place, &
                  'remove it: contact uses the exact geometry of a rigid patch')
      else if (spec%q > 0) then
        call fail(error, DECK_ERROR, 'rigid '//name//' has QUADrature', spec%place, &
                  'remove it: a rigid surface has no integration points')
      end if
    end associate
  end subroutine check_complete

  !> Read one record, whose word is known.
  subroutine read_patch_record(deck, line, patch, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error
    integer :: d, n(3)

    associate (spec => patch%spec)
      select case (line%key(1))
      case ('rota', 'tran')
        call read_placement(deck, line, spec, error)
      case ('elem')
        call check_count(line, 4, 4, 'ELEMents n1 n2 n3', error)
        if (.not. allocated(error)) call get_numbers(deck, line, 2, n, error)
        do d = 1, 3
          if (allocated(error)) return
          if (n(d) < 1) call fail(error, DECK_ERROR, 'expected at least 1 element in direction ' &
                                  //to_text(d)//', found '//to_text(n(d)), line%place(d + 1), &
                                  'ELEMents n1 n2 n3')
          if (.not. allocated(error)) call set_number(line, d + 1, n(d), d, spec, error)
        end do
      case ('knot')
        call read_knots(deck, line, spec, error)
      case ('type')
        call read_type(deck, line, spec, error)
      case ('enri')
        call read_enrich(deck, line, spec, error)
      case ('quad')
        call check_count(line, 2, 3, 'QUADrature q [qz]', error)
        if (.not. allocated(error)) call get_numbers(deck, line, 2, n(:line%n - 1), error)
        if (allocated(error)) return
        d = findloc(n(:line%n - 1) < 1 .or. n(:line%n - 1) > MAX_POINT, .true., 1)
        if (d > 0) call fail(error, DECK_ERROR, 'QUADrature has '//to_text(n(d)) &
                             //' integration points', &
                             line%place(d + 1), 'give 1 to '//to_text(MAX_POINT) &
                             //' integration points in each direction')
        spec%q = n(1)
        if (line%n == 3) spec%qz = n(2)
      case ('mate')
        call check_count(line, 2, 2, 'MATErial m', error)
        if (.not. allocated(error)) call get_integer(deck, line, 2, patch%material, error)
        patch%material_place = line%place(2)
      case default
        call read_geometry(deck, line, patch, error)
      end select
    end associate
  end subroutine read_patch_record

  !> Set the number of elements. Fail if ELEMents and KNOTs give different numbers.
  subroutine set_number(line, i, n, d, spec, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i !! field to which an error refers
    integer, intent(in) :: n, d !! elements in direction d
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error

    if (spec%nelem(d) > 0 .and. spec%nelem(d) /= n) then
      call fail(error, DECK_ERROR, 'ELEMents and KNOTs give different numbers of elements in ' &
                //'direction '//to_text(d), line%place(i), 'the list of KNOTs makes ' &
                //to_text(size(spec%knots(d)%u) + 1)//' elements')
    end if
    spec%nelem(d) = n
  end subroutine set_number

  !> Read KNOTs,direction and its interior knots.
  subroutine read_knots(deck, line, spec, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i

    call check_count(line, 3, huge(1), 'KNOTs,direction and its interior knots', error)
    if (.not. allocated(error)) call get_direction(deck, line, 2, d, error)
    if (allocated(error)) return
    if (allocated(spec%knots(d)%u)) then
      call fail(error, DECK_ERROR, 'duplicate KNOTs of direction '//to_text(d), line%place(2), &
                'keep one of them')
      return
    end if
    allocate (spec%knots(d)%u(line%n - 2))
    associate (u => spec%knots(d)%u)
      call get_numbers(deck, line, 3, u, error)
      if (allocated(error)) return
      do i = 2, size(u)
        if (u(i) > u(i - 1)) cycle
        call fail(error, DECK_ERROR, 'knot '//line%text(i + 2)//' is not larger than the one ' &
                  //'before it', line%place(i + 2), 'list each knot once, in increasing order')
        return
      end do
    end associate
    call set_number(line, 2, line%n - 1, d, spec, error)
  end subroutine read_knots

  !> Read TYPE Q1 | Q1E9 | Q2 | IGA p | RIGId.
  subroutine read_type(deck, line, spec, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: t

    call check_count(line, 2, 3, 'TYPE Q1, Q1E9, Q2, IGA p or RIGId', error)
    if (allocated(error)) return
    t = word_index(TYPES, line%key(2))
    if (t > 0) spec%type = TYPES(t)
    if (spec%type == 'RIGId') then
      spec%type = 'RIGID'
    else if (t == 0 .or. len(line%text(2)) > 4) then ! names of elements are written in full
      call fail(error, DECK_ERROR, 'unknown element type '//quoted(line%text(2)), line%place(2), &
                'known types: '//word_list(TYPES, ' '))
      return
    end if
    if (spec%type == 'IGA') then
      call check_count(line, 3, 3, 'TYPE IGA p', error)
      if (.not. allocated(error)) call get_integer(deck, line, 3, spec%degree, error)
    else
      call check_count(line, 2, 2, 'TYPE '//line%text(2), error)
    end if
  end subroutine read_type

  !> Read ENRIch face p [RAISe t] [EAS [TAPEred]].
  subroutine read_enrich(deck, line, spec, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'ENRIch face p [RAISe t] [EAS [TAPEred]]'
    type(enrich_t) :: e
    type(enrich_t), allocatable :: longer(:)
    integer :: i, n

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
        if (e%raise < 0) call fail(error, DECK_ERROR, 'RAISe '//to_text(e%raise)//' is negative', &
                                   line%place(i), 'RAISe t raises the order by t, which must be ' &
                                   //'0 or more')
      case ('eas')
        e%eas = .true.
      case ('tape')
        e%tapered = .true.
        if (.not. e%eas) call fail(error, DECK_ERROR, 'TAPEred needs EAS', line%place(i), USAGE)
      case default
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of ENRIch', &
                  line%place(i), USAGE)
      end select
      if (allocated(error)) return
      i = i + 1
    end do
    n = size(spec%enrich)
    allocate (longer(n + 1))
    longer(:n) = spec%enrich
    longer(n + 1) = e
    call move_alloc(longer, spec%enrich)
  end subroutine read_enrich

  !> Read BOX, HEMIsphere, NPATch or FILE, of which a patch has exactly one.
  subroutine read_geometry(deck, line, patch, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_entry_t), intent(inout) :: patch
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6)
    integer :: i

    associate (spec => patch%spec)
      if (spec%geometry /= GEO_NONE) then
        call fail(error, DECK_ERROR, 'patch '//quoted(spec%name)//' has two geometries', &
                  line%place(1), 'give only one: BOX, HEMIsphere, NPATch or FILE')
        return
      end if
      select case (line%key(1))
      case ('box')
        call check_count(line, 7, 7, 'BOX x0 y0 z0  lx ly lz', error)
        if (.not. allocated(error)) call get_numbers(deck, line, 2, x, error)
        if (allocated(error)) return
        i = findloc(x(4:) > 0.0_wp, .false., 1)
        if (i > 0) call fail(error, DECK_ERROR, 'the box has length '//to_text(x(i + 3)) &
                             //' in direction '//to_text(i), line%place(i + 4), &
                             'give positive lengths')
        spec%geometry = GEO_BOX
        spec%origin = x(:3)
        spec%length = x(4:)
      case ('hemi')
        x = 0.0_wp
        call check_count(line, 3, 6, 'HEMIsphere radius thickness [x0 y0 z0]', error)
        if (.not. allocated(error)) call get_numbers(deck, line, 2, x(:line%n - 1), error)
        if (allocated(error)) return
        if (.not. x(1) > 0.0_wp) then
          call fail(error, DECK_ERROR, 'the hemisphere has radius '//to_text(x(1)), &
                    line%place(2), 'give a positive radius')
        else if (.not. (x(2) > 0.0_wp .and. x(2) < x(1))) then
          call fail(error, DECK_ERROR, 'the hemisphere has radius '//to_text(x(1)) &
                    //' and thickness '//to_text(x(2)), line%place(3), &
                    'give a thickness between 0 and the radius')
        end if
        spec%geometry = GEO_HEMISPHERE
        spec%radius = x(1)
        spec%thickness = x(2)
        spec%origin = x(3:5)
      case ('npat')
        call check_count(line, 2, 2, 'NPATch k, the k-th solid of the NPATch records', error)
        if (.not. allocated(error)) call get_integer(deck, line, 2, patch%npatch, error)
        if (allocated(error)) return
        patch%npatch_place = line%place(2)
        if (patch%npatch < 1) call fail(error, DECK_ERROR, 'unknown NPATch ' &
                                        //to_text(patch%npatch), line%place(2), &
                                        'the solids of NPATch are numbered from 1')
        spec%geometry = GEO_NURBS
      case default ! FILE
        call check_count(line, 2, 3, 'FILE path [name]', error)
        if (.not. allocated(error)) call read_patch_file(resolve_path(line, 2), line%text(3), &
                                                         spec%nurbs, line%place(2), error)
        spec%geometry = GEO_NURBS
      end select
    end associate
  end subroutine read_geometry

  !> Read ROTAte px py pz  ax ay az  degrees, or TRANslate dx dy dz.
  subroutine read_placement(deck, line, spec, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(patch_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: ROTATE = 'ROTAte px py pz  ax ay az  degrees'
    type(placement_t) :: p

    p%rotates = line%key(1) == 'rota'
    if (p%rotates) then
      call check_count(line, 8, 8, ROTATE, error)
      if (.not. allocated(error)) call get_axis(deck, line, 2, ROTATE, p%point, p%axis, error)
      if (.not. allocated(error)) call get_real(deck, line, 8, p%angle, error)
      p%angle = p%angle*DEGREE
    else
      call check_count(line, 4, 4, 'TRANslate dx dy dz', error)
      if (.not. allocated(error)) call get_numbers(deck, line, 2, p%point, error)
    end if
    if (.not. allocated(error)) spec%placement = [spec%placement, p]
  end subroutine read_placement

end module word_patch
