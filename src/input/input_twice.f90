!> Warnings about records that give again what earlier records have given, and replace it or add to
!! it. Usually such a record is left over from a copy.
module input_twice
  use base_error, only: place_t
  use base_log, only: warn
  use base_text, only: to_text
  use input_draft, only: draft_t
  implicit none
  private
  public :: replaced_t, note_replaced, warn_replaced, warn_node_twice

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

end module input_twice
