!> Short mesh words: PARAmeters, PRINt, NOPRint, TIE.
module word_settings
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real, read_parameters
  use input_draft, only: draft_t, tie_entry_t
  use input_fields, only: get_numbers
  implicit none
  private
  public :: read_para, read_print, read_tie

contains

  !> Read PARAmeters and the assignments that follow.
  subroutine read_para(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, &
                     "PARAmeters has no options; records 'name = expression' follow", error)
    if (allocated(error)) return
    call read_parameters(deck, draft%row%name, draft%closed_line, error)
    draft%closed_by = 'blank record' ! or a comment, which is treated like one
    if (.not. allocated(error)) draft%in_set = .false.
  end subroutine read_para

  !> Read PRINt or NOPRint, which have no effect.
  subroutine read_print(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    associate (unused => draft%in_set, none => deck%consumed); end associate
    call check_count(record, 1, 1, record%text(1)//' has no options', error)
  end subroutine read_print

  !> Read TIE [,,direction,coordinate | NODE,n1,n2 | MATErial,m1,m2] [tolerance].
  subroutine read_tie(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = "write 'TIE', 'TIE,,direction,coordinate', " &
                               //"'TIE,NODE,n1,n2' or 'TIE,MATErial,m1,m2'"
    type(tie_entry_t) :: t

    call check_count(record, 1, 5, USAGE, error)
    if (allocated(error)) return
    t%place = record%place(1)
    select case (record%key(2))
    case ('')
      call get_integer(deck, record, 3, t%direction, error, 0)
      if (.not. allocated(error)) call get_real(deck, record, 4, t%coordinate, error, 0.0_wp)
      if (allocated(error)) return
      if (t%direction < 0 .or. t%direction > 3) then
        call fail(error, DECK_ERROR, 'unknown direction '//to_text(t%direction), &
                  record%place(3), 'directions are 1, 2 and 3')
      else if (t%direction == 0 .and. abs(t%coordinate) > 0.0_wp) then
        call fail(error, DECK_ERROR, 'TIE has a coordinate, but no direction', record%place(4), &
                  'TIE,,direction,coordinate joins nodes on a plane; a tolerance is the fifth ' &
                  //'field: TIE,,,,tolerance')
      end if
    case ('node')
      call get_integer(deck, record, 3, t%from, error)
      if (.not. allocated(error)) call get_integer(deck, record, 4, t%to, error)
      if (allocated(error)) return
      if (t%from < 1 .or. t%to < t%from) then
        call fail(error, DECK_ERROR, 'nodes '//to_text(t%from)//' to '//to_text(t%to)//' do not ' &
                  //'form a range', record%place(3), 'TIE,NODE,first,last')
      end if
    case ('mate')
      call get_numbers(deck, record, 3, t%material, error)
      if (.not. allocated(error) .and. any(t%material < 1)) then
        call fail(error, DECK_ERROR, 'material '//to_text(minval(t%material))//' is not positive', &
                  record%place(merge(3, 4, t%material(1) < 1)), 'TIE,MATErial,m1,m2')
      end if
    case default
      call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(2))//' of TIE', &
                record%place(2), USAGE)
    end select
    if (.not. allocated(error)) call get_real(deck, record, 5, t%tolerance, error, 0.0_wp)
    if (allocated(error)) return
    if (t%tolerance < 0.0_wp) then
      call fail(error, DECK_ERROR, 'tolerance '//to_text(t%tolerance)//' is negative', &
                record%place(5), 'give a fraction of the size of the mesh, or 0 for the default')
      return
    end if
    draft%tie = [draft%tie, t]
  end subroutine read_tie

end module word_settings
