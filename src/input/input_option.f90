!> Options after the required fields of a record: words in any order, each at most once.
!!
!! The options of a record are given in one list such as ['PAIR', 'SMOOth d'], each entry of which
!! is a word and the value that follows it, if any. Reading, checks and hints use that list.
module input_option
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, key_of
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_real
  implicit none
  private
  public :: next_option, option_row, read_positive, with_options

contains

  !> Read the next option after field i, and set i to the number of the field that holds its word.
  !! Fail if the option is unknown or repeated, or if its value is missing.
  subroutine next_option(line, i, option, usage, seen, key, error)
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    character(*), intent(in) :: option(:) !! words that the record accepts, with their values
    character(*), intent(in) :: usage     !! form of the record with all options
    logical, intent(inout) :: seen(:)     !! (size(option))
    character(4), intent(out) :: key      !! key of the option; blank: there are no more options
    type(error_t), allocatable, intent(out) :: error
    integer :: o

    key = ''
    if (i >= line%n) return
    i = i + 1
    o = option_row(option, line%key(i))
    if (o == 0) then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of '//line%text(1), &
                line%place(i), usage)
    else if (seen(o)) then
      call fail(error, DECK_ERROR, 'duplicate option '//line%text(i)//' of '//line%text(1), &
                line%place(i), usage)
    else
      seen(o) = .true.
      key = line%key(i)
      if (index(trim(option(o)), ' ') > 0) call check_count(line, i + 1, huge(i), usage, error)
    end if
  end subroutine next_option

  !> Position of a word in a list of options; 0: it is not in the list.
  pure integer function option_row(option, key) result(o)
    character(*), intent(in) :: option(:)
    character(4), intent(in) :: key

    do o = size(option), 1, -1
      if (key_of(option(o) (:index(option(o)//' ', ' ') - 1)) == key) return
    end do
  end function option_row

  !> The form of a record with its options in brackets.
  pure function with_options(usage, option) result(text)
    character(*), intent(in) :: usage, option(:)
    character(:), allocatable :: text
    integer :: i

    text = trim(usage)
    do i = 1, size(option)
      text = text//' ['//trim(option(i))//']'
    end do
  end function with_options

  !> Read a number greater than zero.
  subroutine read_positive(deck, line, i, what, x, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: what
    real(wp), intent(inout) :: x
    type(error_t), allocatable, intent(out) :: error

    call get_real(deck, line, i, x, error)
    if (allocated(error)) return
    if (x > 0.0_wp) return
    call fail(error, DECK_ERROR, 'the '//what//' must be positive, found '//to_text(x), &
              line%place(i), 'give a number greater than 0')
  end subroutine read_positive

end module input_option
