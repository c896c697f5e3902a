!> Warnings about records that give again what earlier records have given, and replace it or add to
!! it. Usually such a record is left over from a copy.
module input_twice
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use input_draft, only: draft_t, condition_entry_t
  use word_position, only: R_EDIS, R_EFOR, R_CBOU, R_CFOR, R_CDIS, R_CSUR
  implicit none
  private
  public :: replaced_t, note_replaced, warn_replaced, warn_node_twice, warn_repeated_conditions, &
            same_place, is_repeated, warn_repeated

  !> The elements that a word replaces.
  type :: replaced_t
    integer :: n = 0       !! number of these elements
    integer :: element = 0 !! the first of them
    type(place_t) :: earlier, place !! records that gave it first, and that replace it
  end type replaced_t

contains

  !> Warn, once, if a node that is given now has been given before. The list of nodes must have room
  !! for it.
  subroutine warn_node_twice(draft, place, n, hint)
    type(draft_t), intent(inout) :: draft
    type(place_t), intent(in) :: place
    integer, intent(in) :: n
    character(*), intent(in) :: hint

    if (draft%node_twice .or. .not. draft%nodes%given(n)) return
    draft%node_twice = .true.
    call warn('node '//to_text(n)//' is given twice; further such nodes are not reported', place, &
              hint)
  end subroutine warn_node_twice

  !> Count element e if an earlier record has given it. The lists of the draft must have room for
  !! it.
  subroutine note_replaced(draft, e, place, replaced)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: e
    type(place_t), intent(in) :: place !! the record that gives it now
    type(replaced_t), intent(inout) :: replaced

    if (draft%elements%nen(e) == 0) return
    replaced%n = replaced%n + 1
    if (replaced%n > 1) return
    replaced%element = e
    replaced%earlier = draft%places%at(draft%elements%place(e))
    replaced%place = place
  end subroutine note_replaced

  !> Warn if a word has replaced elements.
  subroutine warn_replaced(word, replaced, hint)
    character(*), intent(in) :: word
    type(replaced_t), intent(in) :: replaced
    character(*), intent(in) :: hint
    character(:), allocatable :: text

    if (replaced%n == 0) return
    text = 'element '//to_text(replaced%element)//', which line '//to_text(replaced%earlier%line) &
           //' gives'
    if (replaced%n > 1) text = to_text(replaced%n)//' elements; the first is '//text
    call warn('this '//word//' replaces '//text, replaced%place, hint)
  end subroutine warn_replaced

  !> Warn about a condition by position whose value is added to that of an equal record, and about
  !! one that replaces that of an earlier record of its word at the same point.
  subroutine warn_repeated_conditions(draft)
    type(draft_t), intent(in) :: draft
    integer :: i, j

    do i = 2, draft%ncondition
      do j = 1, i - 1
        if (.not. same_place(draft%condition(i), draft%condition(j))) cycle
        if (is_repeated(draft%condition(i), draft%condition(j))) exit
      end do
      if (j < i) call warn_repeated(draft%condition(i), draft%condition(j), 'the same place')
    end do
  end subroutine warn_repeated_conditions

  !> Do two records of one word act at the same place?
  pure logical function same_place(r, s) result(same)
    type(condition_entry_t), intent(in) :: r, s

    same = r%word == s%word .and. r%direction == s%direction .and. &
           (allocated(r%surface) .eqv. allocated(s%surface))
    if (.not. same) return
    if (allocated(r%surface)) then
      same = all(abs(r%surface - s%surface) <= 0.0_wp)
    else
      same = all(abs(r%at - s%at) <= 0.0_wp)
    end if
  end function same_place

  !> Does record r, at the same place as the earlier record s, act a second time or replace it?
  !! Forces of different size may be meant to be added, but displacements hardly are.
  pure logical function is_repeated(r, s) result(repeated)
    type(condition_entry_t), intent(in) :: r, s

    associate (differ => any(abs(r%value - s%value) > 0.0_wp))
      repeated = .false.
      select case (r%word)
      case (R_EFOR, R_CFOR)
        repeated = any(abs(s%value) > 0.0_wp) .and. .not. (differ .and. r%adds)
      case (R_EDIS, R_CDIS)
        if (r%adds) then
          repeated = any(abs(r%value) > 0.0_wp .and. abs(s%value) > 0.0_wp)
        else
          repeated = any(abs(s%value) > 0.0_wp) .and. differ
        end if
      case (R_CBOU)
        repeated = .not. r%adds .and. .not. allocated(r%surface) .and. &
                   any(abs(s%value) > 0.0_wp .and. .not. abs(r%value) > 0.0_wp)
      case default ! codes and load numbers that are equal have the same effect once or twice
        if (r%word == R_CSUR .and. allocated(r%surface)) then
          repeated = any(abs(r%surface(4, :)) > 0.0_wp)
        end if
      end select
    end associate
  end function is_repeated

  !> Warn about record r, which repeats record s.
  subroutine warn_repeated(r, s, at)
    type(condition_entry_t), intent(in) :: r, s
    character(*), intent(in) :: at     !! where both act, such as: the same place
    character(*), parameter :: NAME(5) = ['EDISplacement', 'EFORce       ', 'CBOUndary    ', &
                                          'CFORce       ', 'CDISplacement']
    character(:), allocatable :: word, line

    line = ' in line '//to_text(s%place%line)
    if (r%word == R_CSUR) then
      call warn('the same CSURface is already given'//line//', so the surface bears the sum of ' &
                //'both', r%place, 'remove one of them, or give the sum in one record')
      return
    end if
    word = trim(NAME(findloc([R_EDIS, R_EFOR, R_CBOU, R_CFOR, R_CDIS], r%word, 1)))
    if (r%adds) then
      call warn('this '//word//' adds its values to those'//line//' at '//at, r%place, &
                'remove one of the records, or give the sum in one record')
    else
      call warn('this '//word//' replaces the values given'//line//' at '//at, r%place, &
                'remove one of the records, or write '//word//',ADD to keep both')
    end if
  end subroutine warn_repeated

end module input_twice
