!> FIX, MOVE and PRESsure: what holds, moves and presses a body.
module word_boundary
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, support_t, move_t, press_t
  use input_where, only: read_where, W_FACES, W_GROUP
  implicit none
  private
  public :: read_fix, read_move, read_pressure

  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp
  character(*), parameter :: MOVE_USAGE = 'MOVE,WHERE TRANslate dx dy dz [PROP k], or ROTAte px ' &
                             //'py pz  ax ay az  degrees [PROP k]'

contains

  !> FIX,WHERE c1 c2 c3.
  subroutine read_fix(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(support_t) :: s
    type(support_t), allocatable :: longer(:)
    integer :: i, d

    i = 2
    call read_where(deck, record, i, s%at, error)
    if (allocated(error)) return
    call check_count(record, i + 2, i + 2, 'FIX,WHERE code1 code2 code3', error)
    do d = 1, 3
      if (allocated(error)) return
      call get_integer(deck, record, i + d - 1, s%code(d), error, 0)
    end do
    if (allocated(error)) return
    if (build%nsupport == size(build%support)) then
      allocate (longer(2*build%nsupport + 8))
      longer(:build%nsupport) = build%support
      call move_alloc(longer, build%support)
    end if
    build%nsupport = build%nsupport + 1
    build%support(build%nsupport) = s
  end subroutine read_fix

  !> MOVE,WHERE TRANslate or ROTAte [PROP k].
  subroutine read_move(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(move_t) :: m
    type(move_t), allocatable :: longer(:)
    integer :: i

    i = 2
    call read_where(deck, record, i, m%at, error)
    if (allocated(error)) return
    m%motion%place = record%place(1)
    select case (record%key(i))
    case ('tran')
      call read_translation(deck, record, i, m, error)
    case ('rota')
      call read_rotation(deck, record, i, m, error)
    case default
      call fail(error, DECK_ERROR, merge('the motion is missing     ', &
                                         'unknown motion of the body', &
                                         record%is_empty(i)), record%place(i), MOVE_USAGE)
    end select
    if (allocated(error)) return
    call read_table(deck, record, i, m%motion%table, MOVE_USAGE, error)
    if (allocated(error)) return
    call check_count(record, i - 1, i - 1, MOVE_USAGE, error)
    if (allocated(error)) return
    if (build%nmove == size(build%move)) then
      allocate (longer(2*build%nmove + 8))
      longer(:build%nmove) = build%move
      call move_alloc(longer, build%move)
    end if
    build%nmove = build%nmove + 1
    build%move(build%nmove) = m
  end subroutine read_move

  !> TRANslate dx dy dz; * leaves a direction free. i ends behind it.
  subroutine read_translation(deck, record, i, m, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(inout) :: i
    type(move_t), intent(inout) :: m
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    do d = 1, 3
      if (record%text(i + d) == '*') then
        m%motion%acts(d) = .false.
      else
        call get_real(deck, record, i + d, m%motion%vector(d), error)
        if (allocated(error)) then
          if (record%is_empty(i + d)) error%hint = MOVE_USAGE
          return
        end if
      end if
    end do
    if (.not. any(m%motion%acts)) then
      call fail(error, DECK_ERROR, 'MOVE leaves all three directions free', record%place(i + 1), &
                'give a number in at least one direction')
    end if
    i = i + 4
  end subroutine read_translation

  !> ROTAte px py pz  ax ay az  degrees. i ends behind it.
  subroutine read_rotation(deck, record, i, m, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(inout) :: i
    type(move_t), intent(inout) :: m
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(7), length
    integer :: d

    do d = 1, 7
      call get_real(deck, record, i + d, x(d), error)
      if (allocated(error)) then
        if (record%is_empty(i + d)) error%hint = MOVE_USAGE
        return
      end if
    end do
    length = norm2(x(4:6))
    if (.not. length > 0.0_wp) then
      call fail(error, DECK_ERROR, 'the axis of rotation has no length', record%place(i + 4), &
                MOVE_USAGE)
      return
    end if
    m%motion%rotates = .true.
    m%motion%vector = x(:3)
    m%motion%axis = x(4:6)/length
    m%motion%angle = x(7)*DEGREE
    i = i + 8
  end subroutine read_rotation

  !> [PROP k] in field i; i ends behind it.
  subroutine read_table(deck, record, i, table, usage, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(inout) :: i
    integer, intent(out) :: table
    character(*), intent(in) :: usage
    type(error_t), allocatable, intent(out) :: error

    table = 0
    if (record%n < i) return
    if (record%key(i) /= 'prop') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(i)), record%place(i), &
                usage)
      return
    end if
    call get_integer(deck, record, i + 1, table, error)
    if (allocated(error)) return
    if (table < 0) call fail(error, DECK_ERROR, 'load table '//to_text(table), &
                             record%place(i + 1), &
                             'load tables are counted from 1; 0 is their sum')
    i = i + 2
  end subroutine read_table

  !> PRESsure,WHERE p [PROP k] [FOLLower].
  subroutine read_pressure(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'PRESsure,patch,face p [PROP k] [FOLLower]'
    type(press_t) :: p
    type(press_t), allocatable :: longer(:)
    integer :: i

    i = 2
    call read_where(deck, record, i, p%at, error)
    if (allocated(error)) return
    if (p%at%kind /= W_FACES .and. p%at%kind /= W_GROUP) then
      call fail(error, DECK_ERROR, 'a pressure acts on a face of a patch', p%at%place, &
                USAGE//'; on a FEAP mesh use CSURface')
      return
    end if
    p%pressure%place = record%place(1)
    call get_real(deck, record, i, p%pressure%value, error)
    if (allocated(error)) then
      if (record%is_empty(i)) error%hint = USAGE
      return
    end if
    i = i + 1
    if (record%key(i) == 'prop') call read_table(deck, record, i, p%pressure%table, USAGE, error)
    if (allocated(error)) return
    if (i <= record%n) then
      if (record%key(i) /= 'foll') then
        call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(i)), record%place(i), &
                  USAGE)
        return
      end if
      p%pressure%follower = .true.
      i = i + 1
    end if
    call check_count(record, i - 1, i - 1, USAGE, error)
    if (allocated(error)) return
    if (build%npress == size(build%press)) then
      allocate (longer(2*build%npress + 8))
      longer(:build%npress) = build%press
      call move_alloc(longer, build%press)
    end if
    build%npress = build%npress + 1
    build%press(build%npress) = p
  end subroutine read_pressure

end module word_boundary
