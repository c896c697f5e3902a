!> Conditions by position, applied to all nodes and control points at the END of the mesh:
!! EBOUndary EDISplacement EFORce EPROportional name planes; setup_places reads points and surfaces.
!!
!! Source: FEAPpv's manual
module setup_requests
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use setup_build, only: build_t, request_t, next_data
  implicit none
  private
  public :: read_planes, begin_requests, read_gap, get_value, value_names, append_request

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

end module setup_requests
