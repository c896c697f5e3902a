!> Records of a block: known ones, and most of them once.
module input_record
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, nearest, key_of
  use deck_record, only: record_t
  implicit none
  private
  public :: check_record

contains

  !> Is the record's word known, and may it stand here?
  subroutine check_record(line, words, repeated, block, name, seen, error)
    type(record_t), intent(in) :: line
    character(*), intent(in) :: words(:)
    character(*), intent(in) :: repeated !! keys of words that may stand several times
    character(*), intent(in) :: block    !! the deck's word, for messages
    character(*), intent(in) :: name     !! what the user calls it, such as: patch 'a'
    logical, intent(inout) :: seen(:)    !! (size(words))
    type(error_t), allocatable, intent(out) :: error
    integer :: w

    do w = size(words), 1, -1
      if (key_of(words(w)) == line%key(1)) exit
    end do
    if (w == 0) then
      call fail(error, DECK_ERROR, 'unknown record '//quoted(line%text(1))//' of a '//block, &
                line%place(1), 'nearest known: '//nearest(line%text(1), words))
    else if (seen(w) .and. index(repeated, key_of(words(w))) == 0) then
      call fail(error, DECK_ERROR, trim(words(w))//' stands twice in '//name, line%place(1), &
                'keep one of them')
    else
      seen(w) = .true.
    end if
  end subroutine check_record

end module input_record
