!> FIX, MOVE and PRESsure: supports, prescribed motions and pressures of a body.
module word_boundary
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, support_entry_t, motion_entry_t, pressure_entry_t
  use input_fields, only: get_numbers, get_axis
  use input_where, only: read_where, W_FACES, W_GROUP
  implicit none
  private
  public :: read_fix, read_move, read_pressure

  real(wp), parameter :: DEGREE = acos(-1.0_wp)/180.0_wp

contains

  !> Read FIX,WHERE c1 c2 c3.
  subroutine read_fix(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(support_entry_t) :: s
    type(support_entry_t), allocatable :: longer(:)
    integer :: i

    i = 2
    call read_where(deck, record, i, s%at, error)
    if (.not. allocated(error)) call check_count(record, i + 2, i + 2, &
                                                 'FIX,WHERE code1 code2 code3', error)
    if (.not. allocated(error)) call get_numbers(deck, record, i, s%code, error, 0)
    if (allocated(error)) return
    if (all(s%code == 0)) call warn('this FIX restrains no direction and has no effect', &
                                    record%place(1), 'a code that is not 0 restrains its ' &
                                    //'direction; FIX does not remove restraints of other records')
    if (draft%nsupport == size(draft%support)) then
      allocate (longer(2*draft%nsupport + 8))
      longer(:draft%nsupport) = draft%support
      call move_alloc(longer, draft%support)
    end if
    draft%nsupport = draft%nsupport + 1
    draft%support(draft%nsupport) = s
  end subroutine read_fix

  !> Read MOVE,WHERE TRANslate dx dy dz, or ROTAte px py pz  ax ay az  degrees, then [PROP k].
  subroutine read_move(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'MOVE,WHERE TRANslate dx dy dz [PROP k], or ROTAte px ' &
                               //'py pz  ax ay az  degrees [PROP k]'
    type(motion_entry_t) :: m
    type(motion_entry_t), allocatable :: longer(:)
    integer :: i, d, first

    i = 2
    call read_where(deck, record, i, m%at, error)
    if (allocated(error)) return
    associate (motion => m%motion)
      motion%place = record%place(1)
      first = i + 1
      select case (record%key(i))
      case ('tran')
        do d = 1, 3
          motion%acts(d) = record%text(i + d) /= '*'
          if (motion%acts(d)) call get_real(deck, record, i + d, motion%vector(d), error)
          if (allocated(error)) exit
        end do
        if (.not. (allocated(error) .or. any(motion%acts))) then
          call fail(error, DECK_ERROR, 'MOVE prescribes none of the three directions', &
                    record%place(first), 'give a number in at least one direction')
        end if
        i = i + 4
      case ('rota')
        motion%rotates = .true.
        call get_axis(deck, record, first, USAGE, motion%vector, motion%axis, error)
        if (.not. allocated(error)) call get_real(deck, record, i + 7, motion%angle, error)
        motion%angle = motion%angle*DEGREE
        i = i + 8
      case default
        if (record%is_empty(i)) then
          call fail(error, DECK_ERROR, 'the motion is missing', record%place(i), USAGE)
        else
          call fail(error, DECK_ERROR, 'unknown motion '//quoted(record%text(i)), &
                    record%place(i), USAGE)
        end if
      end select
      if (allocated(error)) then
        if (any([(record%is_empty(d), d=first, i - 1)])) error%hint = USAGE
        return
      end if
      call read_table(deck, record, i, motion%table, USAGE, error)
    end associate
    if (.not. allocated(error)) call check_count(record, i - 1, i - 1, USAGE, error)
    if (allocated(error)) return
    if (draft%nmotion == size(draft%motion)) then
      allocate (longer(2*draft%nmotion + 8))
      longer(:draft%nmotion) = draft%motion
      call move_alloc(longer, draft%motion)
    end if
    draft%nmotion = draft%nmotion + 1
    draft%motion(draft%nmotion) = m
  end subroutine read_move

  !> Read [PROP k] at field i, and set i to the field after it.
  subroutine read_table(deck, record, i, table, usage, error)
    type(deck_t), intent(in) :: deck
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
    if (table < 0) call fail(error, DECK_ERROR, 'load table number '//to_text(table) &
                             //' is negative', record%place(i + 1), &
                             'give the number of a PROP table, or 0 for the sum of all tables')
    i = i + 2
  end subroutine read_table

  !> Read PRESsure,WHERE p [PROP k] [FOLLower].
  subroutine read_pressure(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'PRESsure,patch,face p [PROP k] [FOLLower]'
    type(pressure_entry_t) :: p
    type(pressure_entry_t), allocatable :: longer(:)
    logical :: zero
    logical :: numbered ! PROP was given
    integer :: i

    i = 2
    call read_where(deck, record, i, p%at, error)
    if (allocated(error)) return
    if (p%at%type /= W_FACES .and. p%at%type /= W_GROUP) then
      call fail(error, DECK_ERROR, 'PRESsure needs a face of a patch or a group of a mesh', &
                p%at%place, USAGE//'; for elements of ELEMents and BLOCk use CSURface')
      return
    end if
    p%pressure%place = record%place(1)
    call get_real(deck, record, i, p%pressure%value, error)
    if (allocated(error)) then
      if (record%is_empty(i)) error%hint = USAGE
      return
    end if
    zero = .not. abs(p%pressure%value) > 0.0_wp .and. record%has_digits_only(i, i)
    i = i + 1
    numbered = .false.
    do while (i <= record%n) ! the options in either order, each at most once
      if (record%key(i) == 'foll' .and. .not. p%pressure%follower) then
        p%pressure%follower = .true.
        i = i + 1
      else if (.not. numbered) then
        call read_table(deck, record, i, p%pressure%table, USAGE, error)
        if (allocated(error)) return
        numbered = .true.
      else
        exit
      end if
    end do
    call check_count(record, i - 1, i - 1, USAGE, error)
    if (allocated(error)) return
    if (draft%npressure == size(draft%pressure)) then
      allocate (longer(2*draft%npressure + 8))
      longer(:draft%npressure) = draft%pressure
      call move_alloc(longer, draft%pressure)
    end if
    draft%npressure = draft%npressure + 1
    draft%pressure(draft%npressure) = p
    if (zero) call warn('the pressure of this PRESsure is 0, so it has no effect', &
                        p%pressure%place, 'give a pressure, or remove the record')
  end subroutine read_pressure

end module word_boundary
