!> Conditions by position, applied to all nodes and control points at the END of the mesh:
!! EBOUndary EDISplacement EFORce EPROportional name planes; word_position reads points and surfaces.
!!
!! Source: FEAPpv's manual
!!
!! Conditions at points and on surfaces: CBOUndary CDISplacement CFORce CSURface, applied at the
!! END of the mesh.
!!
!! Source: FEAPpv's manual
module word_position
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, request_t, next_data
  implicit none
  private
  public :: read_planes, begin_requests, read_gap, get_value, value_names, append_request, &
            read_places

  integer, parameter, public :: R_EBOU = 1, R_EDIS = 2, R_EFOR = 3, R_EPRO = 4, R_CBOU = 5, &
                                R_CFOR = 6, R_CDIS = 7, R_CSUR = 8 !! in FEAP's order of applying
  character(4), parameter :: WORD(8) = ['ebou', 'edis', 'efor', 'epro', 'cbou', 'cfor', 'cdis', &
                                        'csur'] !! of these kinds

contains

  !> What the word and ADD or SET behind it say of all its requests; without either, words of planes
  !! but EPROportional add.
  subroutine begin_requests(record, r, error)
    type(record_t), intent(in) :: record
    type(request_t), intent(out) :: r
    type(error_t), allocatable, intent(out) :: error

    r%kind = findloc(WORD, record%key(1), 1)
    r%adds = any(r%kind == [R_EBOU, R_EDIS, R_EFOR])
    call check_count(record, 1, 2, record%text(1)//' [ADD or SET]; its data follow', error)
    if (allocated(error) .or. record%is_empty(2)) return
    select case (record%key(2))
    case ('add')
      r%adds = .true.
    case ('set')
      r%adds = .false.
    case default
      call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(2))//' of ' &
                //record%text(1), &
                record%place(2), 'options are ADD and SET')
    end select
  end subroutine begin_requests

  !> A word of planes and its records: `direction coordinate` and three values, and GAP.
  subroutine read_planes(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(request_t) :: r
    logical :: more
    integer :: d

    call begin_requests(record, r, error)
    if (allocated(error)) return
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      if (line%key(1) == 'gap') then
        call read_gap(deck, line, r%gap, error)
        if (allocated(error)) return
        cycle
      end if
      call get_integer(deck, line, 1, r%direction, error)
      if (allocated(error)) return
      if (r%direction == 0) exit ! as a blank record (FEAP)
      call check_count(line, 2, 5, 'direction coordinate '//value_names(r%kind), error)
      if (allocated(error)) return
      if (r%direction < 1 .or. r%direction > 3) then
        call fail(error, DECK_ERROR, 'direction '//to_text(r%direction), line%place(1), &
                  'directions are 1, 2 and 3')
        return
      end if
      call get_real(deck, line, 2, r%at(1), error)
      do d = 1, 3
        if (allocated(error)) return
        call get_value(deck, line, d + 2, r%kind, r%value(d), error)
      end do
      if (allocated(error)) return
      r%place = line%place(1)
      call append_request(build, r)
    end do
    build%in_set = .false.
  end subroutine read_planes

  !> What the three values of a record are called.
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

  !> Restraint codes and load numbers are whole, the other values are not.
  subroutine get_value(deck, record, i, kind, x, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: i, kind
    real(wp), intent(out) :: x
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    if (kind == R_EBOU .or. kind == R_EPRO .or. kind == R_CBOU) then
      call get_integer(deck, record, i, n, error, 0)
      x = real(n, wp)
    else
      call get_real(deck, record, i, x, error, 0.0_wp)
    end if
  end subroutine get_value

  subroutine read_gap(deck, record, gap, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    real(wp), intent(out) :: gap
    type(error_t), allocatable, intent(out) :: error

    gap = 0.0_wp
    call check_count(record, 2, 2, 'GAP distance', error)
    if (.not. allocated(error)) call get_real(deck, record, 2, gap, error)
    if (allocated(error)) return
    if (.not. gap > 0.0_wp) call fail(error, DECK_ERROR, 'GAP '//to_text(gap), record%place(2), &
                                      'the distance within which nodes are found is positive')
  end subroutine read_gap

  subroutine append_request(build, r)
    type(build_t), intent(inout) :: build
    type(request_t), intent(in) :: r
    type(request_t), allocatable :: longer(:)
    integer :: n

    n = build%nrequest
    if (.not. allocated(build%request)) allocate (build%request(8))
    if (n == size(build%request)) then
      allocate (longer(2*n))
      longer(:n) = build%request
      call move_alloc(longer, build%request)
    end if
    build%request(n + 1) = r
    build%nrequest = n + 1
  end subroutine append_request

  !> One of the words above and its records NODE, SURFace, GAP, CARTesian and NORMal.
  subroutine read_places(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(request_t) :: r
    logical :: more, again

    call begin_requests(record, r, error)
    if (allocated(error)) return
    again = .false.
    do
      if (.not. again) then
        call next_data(build, deck, line, more, error)
        if (allocated(error) .or. .not. more) return
      end if
      again = .false.
      r%place = line%place(1)
      select case (line%key(1))
      case ('gap')
        call read_gap(deck, line, r%gap, error)
      case ('cart')
        call check_count(line, 1, 1, 'CARTesian stands alone', error)
      case ('node')
        call read_node(deck, line, r, error)
        if (.not. allocated(error)) call append_request(build, r)
      case default
        if (line%key(1) == 'norm' .and. r%kind == R_CSUR) then
          call check_count(line, 1, 1, 'NORMal stands alone', error)
        else if (line%key(1) == 'surf' .and. any(r%kind == [R_CSUR, R_CBOU])) then
          call read_surface(build, deck, r, line, again, error)
        else
          call complain(line, r%kind, error)
        end if
      end select
      if (allocated(error)) return
      if (.not. build%in_set) return
    end do
  end subroutine read_places

  subroutine complain(line, kind, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: kind
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: words

    words = 'NODE and GAP'
    if (kind == R_CBOU) words = 'NODE, SURFace and GAP'
    if (kind == R_CSUR) words = 'SURFace, NORMal, NODE and GAP'
    call fail(error, DECK_ERROR, 'unknown record '//quoted(line%text(1)), line%place(1), &
              'records are '//words)
  end subroutine complain

  !> NODE x y z and three values.
  subroutine read_node(deck, record, r, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(request_t), intent(inout) :: r
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(record, 5, 7, 'NODE x y z '//value_names(r%kind), error)
    do d = 1, 3
      if (allocated(error)) return
      call get_real(deck, record, d + 1, r%at(d), error, 0.0_wp)
      if (allocated(error)) return
      call get_value(deck, record, d + 4, r%kind, r%value(d), error)
    end do
    r%direction = 0
  end subroutine read_node

  !> SURFace [codes], then its points `i x y z [p]`; `next` is the record behind them if `again`.
  subroutine read_surface(build, deck, r, next, again, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(request_t), intent(in) :: r
    type(record_t), intent(inout) :: next
    logical, intent(out) :: again
    type(error_t), allocatable, intent(out) :: error
    type(request_t) :: s
    logical :: given(9)
    integer :: d

    again = .false.
    s = r
    if (r%kind == R_CBOU) then
      do d = 1, 3
        call get_value(deck, next, d + 1, r%kind, s%value(d), error)
        if (allocated(error)) return
      end do
    else
      call check_count(next, 1, 1, 'SURFace stands alone; its points follow: i x y z p', error)
      if (allocated(error)) return
    end if
    allocate (s%surface(4, 9), source=0.0_wp)
    call read_points(build, deck, r%kind, s%surface, given, next, again, error)
    if (allocated(error)) return
    if (.not. all(given(:4))) then
      call fail(error, DECK_ERROR, 'the surface lacks its corner ' &
                //to_text(findloc(given(:4), .false., 1)), s%place, &
                'points 1 to 4 are the corners')
      return
    end if
    call fill_surface(s%surface, given)
    call append_request(build, s)
  end subroutine read_surface

  !> The points of a surface, up to the end of the data or a word, which is then `next`.
  subroutine read_points(build, deck, kind, surface, given, next, again, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    integer, intent(in) :: kind
    real(wp), intent(inout) :: surface(:, :) !! (4, 9) x y z [L] and pressure [F/L^2]
    logical, intent(out) :: given(9)
    type(record_t), intent(inout) :: next
    logical, intent(out) :: again
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    logical :: more
    integer :: i

    given = .false.
    again = .false.
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      again = is_place_word(line%key(1))
      if (again) exit
      call read_point(deck, line, kind, surface, i, error)
      if (allocated(error)) return
      if (i == 0) then
        build%in_set = .false.
        return
      end if
      given(i) = .true.
    end do
    next = line
  end subroutine read_points

  !> `i x y z [p]`; i = 0 ends the points.
  subroutine read_point(deck, line, kind, surface, i, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: kind
    real(wp), intent(inout) :: surface(:, :)
    integer, intent(out) :: i
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call get_integer(deck, line, 1, i, error)
    if (allocated(error) .or. i == 0) return
    call check_count(line, 4, merge(5, 4, kind == R_CSUR), 'a point of the surface is: i x y z' &
                     //trim(merge(' p', '  ', kind == R_CSUR)), error)
    if (allocated(error)) return
    if (i < 1 .or. i > 9) then
      call fail(error, DECK_ERROR, 'point '//to_text(i)//' of a surface', line%place(1), &
                'points 1 to 4 are the corners, 5 to 8 the middles of the edges, 9 the centre')
      return
    end if
    do d = 1, 4
      call get_real(deck, line, d + 1, surface(d, i), error, 0.0_wp)
      if (allocated(error)) return
    end do
  end subroutine read_point

  pure logical function is_place_word(key)
    character(4), intent(in) :: key

    is_place_word = any(key == ['node', 'surf', 'gap ', 'cart', 'norm'])
  end function is_place_word

  !> Missing middles: of edges half the sum of the corners, of the centre as on a serendipity face.
  pure subroutine fill_surface(x, given)
    real(wp), intent(inout) :: x(:, :) !! (4, 9)
    logical, intent(in) :: given(9)
    integer :: i

    do i = 1, 4
      if (.not. given(i + 4)) x(:, i + 4) = 0.5_wp*(x(:, i) + x(:, mod(i, 4) + 1))
    end do
    if (.not. given(9)) x(:, 9) = 0.5_wp*sum(x(:, 5:8), 2) - 0.25_wp*sum(x(:, 1:4), 2)
  end subroutine fill_surface

end module word_position
