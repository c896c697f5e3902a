!> Conditions by position, applied to all nodes and control points at the END of the mesh: on planes
!! (EBOUndary EDISplacement EFORce EPROportional), at points and on surfaces (CBOUndary
!! CDISplacement CFORce CSURface).
!!
!! Source: FEAPpv's manual
module word_position
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, condition_entry_t, next_data, end_set
  use input_fields, only: get_numbers
  use input_record, only: word_index, word_list
  implicit none
  private
  public :: read_planes, read_places

  integer, parameter, public :: R_EBOU = 1, R_EDIS = 2, R_EFOR = 3, R_EPRO = 4, R_CBOU = 5, &
                                R_CFOR = 6, R_CDIS = 7, R_CSUR = 8 !! in FEAP's order
  character(4), parameter :: WORD(8) = ['ebou', 'edis', 'efor', 'epro', 'cbou', 'cfor', 'cdis', &
                                        'csur'] !! words of these records

  !> Records of the words that select planes, of the words that select points, of CBOUndary and of
  !! CSURface.
  character(12), parameter, public :: &
    PLANE_RECORDS(1) = ['GAP         '], &
    POINT_RECORDS(3) = ['NODE        ', 'GAP         ', 'CARTesian   '], &
    CBOU_RECORDS(4) = ['NODE        ', 'SURFace     ', 'GAP         ', 'CARTesian   '], &
    CSUR_RECORDS(4) = ['SURFace     ', 'GAP         ', 'CARTesian   ', 'NORMal      ']

contains

  !> Set what all conditions of a word have in common: their kind, and whether their values are
  !! added to other values or replace them. Without ADD or SET, the values of words that select
  !! planes are added to other values, except those of EPROportional.
  subroutine begin_requests(record, r, error)
    type(record_t), intent(in) :: record
    type(condition_entry_t), intent(out) :: r
    type(error_t), allocatable, intent(out) :: error

    r%word = findloc(WORD, record%key(1), 1)
    r%adds = any(r%word == [R_EBOU, R_EDIS, R_EFOR])
    call check_count(record, 1, 2, record%text(1)//' [ADD or SET]; its data follow', error)
    if (allocated(error) .or. record%is_empty(2)) return
    if (r%word == R_CSUR .and. record%key(2) == 'set') then
      call fail(error, DECK_ERROR, 'CSURface has no option SET', record%place(2), &
                'the pressures of all surfaces add up: remove the records that are not to act')
      return
    else if (r%word == R_EPRO .and. record%key(2) == 'add') then
      call fail(error, DECK_ERROR, 'EPROportional has no option ADD', record%place(2), &
                'load numbers are not added: a later record replaces an earlier one')
      return
    end if
    select case (record%key(2))
    case ('add')
      r%adds = .true.
    case ('set')
      r%adds = .false.
      r%sets = .true.
    case default
      call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(2))//' of ' &
                //record%text(1), record%place(2), 'options are ADD and SET')
    end select
  end subroutine begin_requests

  !> Read a word that selects planes, and its records: GAP, or `direction coordinate` and three
  !! values.
  subroutine read_planes(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(condition_entry_t) :: r
    type(place_t) :: gap
    logical :: more, idle, zero

    idle = .false.
    zero = .true. ! all values are 0 and not those of parameters
    call begin_requests(record, r, error)
    if (allocated(error)) return
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      if (line%key(1) == 'gap') then
        call read_gap(deck, line, r%gap, error)
        if (allocated(error)) return
        gap = line%place(1)
        idle = .true.
        cycle
      end if
      call get_integer(deck, line, 1, r%direction, error)
      if (allocated(error)) return
      if (r%direction == 0) then
        call end_set(draft, deck, line, 'directions are 1, 2 and 3', error)
        if (allocated(error)) return
        exit
      end if
      call check_count(line, 2, 5, 'direction coordinate '//value_names(r%word), error)
      if (allocated(error)) return
      if (r%direction < 1 .or. r%direction > 3) then
        call fail(error, DECK_ERROR, 'unknown direction '//to_text(r%direction), line%place(1), &
                  'directions are 1, 2 and 3')
        return
      end if
      call get_real(deck, line, 2, r%at(1), error)
      if (.not. allocated(error)) call get_values(deck, line, 3, r, error)
      if (allocated(error)) return
      zero = zero .and. .not. any(abs(r%value) > 0.0_wp) .and. line%has_digits_only(3)
      r%place = line%place(1)
      if (r%adds) call warn_no_restraint(r, line, 3)
      call append_request(draft, r)
      idle = .false.
    end do
    if (idle) call warn_idle_gap(gap)
    if (zero .and. r%word == R_EFOR .and. r%adds .and. allocated(r%place%file)) then
      call warn_zero_forces(record, r%place, 'direction coordinate')
    end if
  end subroutine read_planes

  !> Warn about a set of forces whose values are all 0.
  subroutine warn_zero_forces(record, place, fields)
    type(record_t), intent(in) :: record !! EFORce or CFORce
    type(place_t), intent(in) :: place
    character(*), intent(in) :: fields   !! what precedes the values

    call warn('all values of this '//record%text(1)//' are zero, so it has no effect', place, &
              'write a force as '//quoted(fields//' f1 f2 f3'))
  end subroutine warn_zero_forces

  !> Warn about restraints that are added to others, and of which all codes are 0.
  subroutine warn_no_restraint(r, line, first)
    type(condition_entry_t), intent(in) :: r
    type(record_t), intent(in) :: line
    integer, intent(in) :: first         !! field of the first code

    if (all(r%word /= [R_EBOU, R_CBOU]) .or. any(nint(r%value) /= 0)) return
    if (.not. line%has_digits_only(first)) return ! the value of a parameter
    call warn('this record of '//merge('EBOUndary', 'CBOUndary', r%word == R_EBOU) &
              //' restrains no direction and has no effect', line%place(1), &
              'a code that is not 0 restrains its direction')
  end subroutine warn_no_restraint

  !> Names of the three values of a record.
  pure function value_names(kind) result(names)
    integer, intent(in) :: kind
    character(:), allocatable :: names

    select case (kind)
    case (R_EBOU, R_CBOU)
      names = 'code1 code2 code3'
    case (R_EDIS, R_CDIS)
      names = 'u1 u2 u3'
    case (R_EPRO)
      names = 'k1 k2 k3'
    case default
      names = 'f1 f2 f3'
    end select
  end function value_names

  !> Read three values, beginning at a given field. Restraint codes and load numbers are whole
  !! numbers.
  subroutine get_values(deck, record, first, r, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    type(condition_entry_t), intent(inout) :: r
    type(error_t), allocatable, intent(out) :: error
    integer :: n(3)

    if (any(r%word == [R_EBOU, R_EPRO, R_CBOU])) then
      call get_numbers(deck, record, first, n, error, 0)
      if (.not. allocated(error)) r%value = real(n, wp)
    else
      call get_numbers(deck, record, first, r%value, error, 0.0_wp)
    end if
  end subroutine get_values

  subroutine read_gap(deck, record, gap, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    real(wp), intent(out) :: gap
    type(error_t), allocatable, intent(out) :: error

    gap = 0.0_wp
    call check_count(record, 2, 2, 'GAP distance', error)
    if (.not. allocated(error)) call get_real(deck, record, 2, gap, error)
    if (allocated(error)) return
    if (.not. gap > 0.0_wp) call fail(error, DECK_ERROR, 'GAP '//to_text(gap) &
                                      //' is not positive', record%place(2), &
                                      'give the distance within which nodes are found')
  end subroutine read_gap

  !> Warn about a GAP that no record follows to which it could apply.
  subroutine warn_idle_gap(place)
    type(place_t), intent(in) :: place

    call warn('GAP has no effect: it applies to the records that follow, and none follows', place, &
              'write GAP before the records to which it shall apply')
  end subroutine warn_idle_gap

  subroutine append_request(draft, r)
    type(draft_t), intent(inout) :: draft
    type(condition_entry_t), intent(in) :: r
    type(condition_entry_t), allocatable :: longer(:)
    integer :: n

    n = draft%ncondition
    if (.not. allocated(draft%condition)) allocate (draft%condition(8))
    if (n == size(draft%condition)) then
      allocate (longer(2*n))
      longer(:n) = draft%condition
      call move_alloc(longer, draft%condition)
    end if
    draft%condition(n + 1) = r
    draft%ncondition = n + 1
  end subroutine append_request

  !> Read a word that selects points and surfaces, and its records.
  subroutine read_places(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(12), allocatable :: words(:)
    type(record_t) :: line
    type(condition_entry_t) :: r
    type(place_t) :: gap
    logical :: more, has_line, idle, zero, any_node

    call begin_requests(record, r, error)
    if (allocated(error)) return
    words = POINT_RECORDS
    if (r%word == R_CBOU) words = CBOU_RECORDS
    if (r%word == R_CSUR) words = CSUR_RECORDS
    has_line = .false.
    idle = .false.
    zero = .true. ! all values are 0 and not those of parameters
    any_node = .false.
    do
      if (.not. has_line) then
        call next_data(draft, deck, line, more, error)
        if (allocated(error)) return
        if (.not. more) exit
      end if
      has_line = .false.
      r%place = line%place(1)
      if (word_index(words, line%key(1)) == 0) then
        call fail(error, DECK_ERROR, 'unknown record '//quoted(line%text(1))//' of ' &
                  //record%text(1), line%place(1), 'records are '//word_list(words, ' '))
        return
      end if
      select case (line%key(1))
      case ('gap')
        call read_gap(deck, line, r%gap, error)
        gap = line%place(1)
        idle = r%word /= R_CFOR
        if (.not. (idle .or. allocated(error))) then
          call warn('GAP has no effect in CFORce, whose force acts on the one node nearest to ' &
                    //'its point', gap, 'give each node a record NODE, or use EFORce or CSURface')
        end if
      case ('node')
        idle = .false.
        call check_count(line, 5, 7, 'NODE x y z '//value_names(r%word), error)
        if (.not. allocated(error)) call get_numbers(deck, line, 2, r%at, error, 0.0_wp)
        if (.not. allocated(error)) call get_values(deck, line, 5, r, error)
        r%direction = 0
        if (r%adds .and. .not. allocated(error)) call warn_no_restraint(r, line, 5)
        if (.not. allocated(error)) call append_request(draft, r)
        zero = zero .and. .not. any(abs(r%value) > 0.0_wp) .and. line%has_digits_only(5)
        any_node = .true.
      case ('surf')
        idle = .false.
        call read_surface(draft, deck, r, line, has_line, error)
      case default ! CARTesian, NORMal: the only choice
        call check_count(line, 1, 1, line%text(1)//' has no options', error)
      end select
      if (allocated(error)) return
      if (.not. draft%in_set) exit
    end do
    if (idle) call warn_idle_gap(gap)
    if (zero .and. any_node .and. r%word == R_CFOR .and. r%adds) then ! others replace forces
      call warn_zero_forces(record, r%place, 'NODE x y z')
    end if
  end subroutine read_places

  !> Read SURFace [codes], then its points `i x y z [p]`. `line` is the record after them if
  !! `has_line`.
  subroutine read_surface(draft, deck, request, line, has_line, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(condition_entry_t), intent(in) :: request
    type(record_t), intent(inout) :: line
    logical, intent(out) :: has_line
    type(error_t), allocatable, intent(out) :: error
    type(condition_entry_t) :: r
    character(:), allocatable :: fields
    logical :: given(9), loaded(9), more
    integer :: i

    has_line = .false.
    r = request
    fields = "'i x y z p'"
    if (r%word == R_CBOU) then
      fields = "'i x y z'"
      call check_count(line, 1, 4, 'SURFace code1 code2 code3', error)
      if (.not. allocated(error)) call get_values(deck, line, 2, r, error)
      if (.not. allocated(error)) call warn_no_restraint(r, line, 2)
    else
      call check_count(line, 1, 1, 'SURFace has no options; records '//fields//' follow', error)
    end if
    if (allocated(error)) return
    allocate (r%surface(4, 9), source=0.0_wp)
    given = .false.
    loaded = .false.
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      has_line = word_index([CBOU_RECORDS, CSUR_RECORDS], line%key(1)) > 0
      if (has_line) exit
      call get_integer(deck, line, 1, i, error)
      if (allocated(error)) return
      if (i == 0) then
        call end_set(draft, deck, line, 'the points of a surface are numbered from 1', error)
        if (allocated(error)) return
        exit
      end if
      call check_count(line, 4, merge(5, 4, r%word == R_CSUR), 'write a point as '//fields, error)
      if (allocated(error)) return
      if (i < 1 .or. i > 9) then
        call fail(error, DECK_ERROR, 'unknown point '//to_text(i)//' of a surface', &
                  line%place(1), 'points 1 to 4 are the corners, 5 to 8 the middles of the ' &
                  //'edges, and 9 is the centre')
        return
      end if
      if (given(i)) then
        call fail(error, DECK_ERROR, 'point '//to_text(i)//' of the surface is given twice', &
                  line%place(1), 'begin each surface with a record SURFace')
        return
      end if
      call get_numbers(deck, line, 2, r%surface(:, i), error, 0.0_wp)
      if (allocated(error)) return
      given(i) = .true.
      loaded(i) = .not. line%is_empty(5)
    end do
    if (.not. all(given(:4))) then
      call fail(error, DECK_ERROR, 'the surface has no corner ' &
                //to_text(findloc(given(:4), .false., 1)), r%place, 'give points 1 to 4')
      return
    end if
    if (r%word == R_CSUR .and. .not. any(loaded)) then
      call fail(error, DECK_ERROR, 'the surface has no pressure', r%place, 'give each point its ' &
                //'pressure: '//fields)
      return
    else if (r%word == R_CSUR .and. any(given .and. .not. loaded)) then
      i = findloc(given .and. .not. loaded, .true., 1)
      call warn('point '//to_text(i)//' of the surface has no pressure, which means 0 there, but ' &
                //'other points have one', r%place, 'give each point its pressure: '//fields)
    end if
    associate (x => r%surface)
      do i = 1, 4
        if (.not. given(i + 4)) x(:, i + 4) = 0.5_wp*(x(:, i) + x(:, mod(i, 4) + 1))
      end do
      if (.not. given(9)) x(:, 9) = 0.5_wp*sum(x(:, 5:8), 2) - 0.25_wp*sum(x(:, 1:4), 2)
    end associate
    call append_request(draft, r)
  end subroutine read_surface

end module word_position
