!> Small mesh words: PARAmeters, PRINt, NOPRint, TIE.
module word_settings
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real, read_parameters
  use input_draft, only: build_t, tie_t
  implicit none
  private
  public :: read_para, read_print, read_tie

  character(*), parameter :: TIE_USAGE = 'TIE, or TIE,,direction,coordinate, TIE,NODE,n1,n2, ' &
                             //'TIE,MATErial,m1,m2'

contains

  !> PARAmeters.
  subroutine read_para(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, 'PARAmeters stands alone; name = expression follow', error)
    if (allocated(error)) return
    call read_parameters(deck, build%closed_line, error)
    if (.not. allocated(error)) build%in_set = .false.
  end subroutine read_para

  !> PRINt and NOPRint: what was read is always in the log.
  subroutine read_print(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    associate (unused => build%in_set, none => deck%consumed); end associate
    call check_count(record, 1, 1, record%text(1)//' stands alone', error)
  end subroutine read_print

  !> TIE [,,direction,coordinate | NODE,n1,n2 | MATErial,m1,m2] [tolerance].
  subroutine read_tie(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(tie_t) :: t
    type(tie_t), allocatable :: longer(:)
    integer :: used

    call check_count(record, 1, 5, TIE_USAGE, error)
    if (.not. allocated(error)) call read_range(deck, record, t, error)
    if (allocated(error)) return
    t%place = record%place(1)
    call get_real(deck, record, 5, t%tolerance, error, 0.0_wp)
    if (allocated(error)) return
    if (t%tolerance < 0.0_wp) then
      call fail(error, DECK_ERROR, 'tolerance '//to_text(t%tolerance), record%place(5), &
                'a share of the size of the mesh; 0 is the default')
      return
    end if
    used = count(build%tie%from > 0)
    if (used == size(build%tie)) then
      allocate (longer(2*used + 8))
      longer(:used) = build%tie
      longer(used + 1:)%from = 0 ! none
      call move_alloc(longer, build%tie)
    end if
    build%tie(used + 1) = t
  end subroutine read_tie

  !> Which nodes are tied.
  subroutine read_range(deck, record, t, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(tie_t), intent(inout) :: t
    type(error_t), allocatable, intent(out) :: error

    select case (record%key(2))
    case ('')
      call get_integer(deck, record, 3, t%direction, error, 0)
      if (.not. allocated(error)) call get_real(deck, record, 4, t%coordinate, error, 0.0_wp)
      if (allocated(error)) return
      if (t%direction < 0 .or. t%direction > 3) then
        call fail(error, DECK_ERROR, 'direction '//to_text(t%direction), record%place(3), &
                  'directions are 1, 2 and 3')
      end if
    case ('node')
      call get_integer(deck, record, 3, t%from, error)
      if (.not. allocated(error)) call get_integer(deck, record, 4, t%to, error)
      if (allocated(error)) return
      if (t%from < 1 .or. t%to < t%from) then
        call fail(error, DECK_ERROR, 'nodes '//to_text(t%from)//' to '//to_text(t%to), &
                  record%place(3), 'TIE,NODE,first,last')
      end if
    case ('mate')
      call get_integer(deck, record, 3, t%material(1), error)
      if (.not. allocated(error)) call get_integer(deck, record, 4, t%material(2), error)
    case default
      call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(2))//' of TIE', &
                record%place(2), TIE_USAGE)
    end select
  end subroutine read_range

end module word_settings
