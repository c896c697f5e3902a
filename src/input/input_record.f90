!> Records of a block: the words that it accepts, and which of them may occur more than once.
module input_record
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, nearest, key_of
  use deck_record, only: record_t
  implicit none
  private
  public :: check_record, record_word_t, word_index, word_list

  !> A word of a block. The reader of the block, the check for duplicates and the hints of the
  !! program all use the words of one array of this type.
  type :: record_word_t
    character(12) :: name              !! spelling in the manual; only its first four letters count
    logical :: repeats = .false.       !! the word may occur more than once
  end type record_word_t

  interface check_record
    module procedure check_table, check_listed
  end interface check_record

contains

  !> Fail if the word of the record is unknown, or if it is repeated but must not be.
  subroutine check_table(line, words, block, name, seen, error)
    type(record_t), intent(in) :: line
    type(record_word_t), intent(in) :: words(:)
    character(*), intent(in) :: block !! the word of the block in the deck, for messages
    character(*), intent(in) :: name  !! the user's name for the block, such as: patch 'a'
    logical, intent(inout) :: seen(:) !! (size(words))
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: repeated
    integer :: w

    repeated = ''
    do w = 1, size(words)
      if (words(w)%repeats) repeated = repeated//' '//key_of(words(w)%name)
    end do
    call check_listed(line, words%name, repeated, block, name, seen, error)
  end subroutine check_table

  !> Fail if the word of the record is unknown, or if it is repeated but must not be.
  subroutine check_listed(line, words, repeated, block, name, seen, error)
    type(record_t), intent(in) :: line
    character(*), intent(in) :: words(:)
    character(*), intent(in) :: repeated !! keys of words that may occur several times
    character(*), intent(in) :: block    !! the word of the block in the deck, for messages
    character(*), intent(in) :: name     !! the user's name for the block, such as: patch 'a'
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
      call fail(error, DECK_ERROR, 'duplicate '//trim(words(w))//' in '//name, line%place(1), &
                'keep one of them')
    else
      seen(w) = .true.
    end if
  end subroutine check_listed

  !> Position in a list of the word whose first four letters are `key`; 0: there is none.
  pure integer function word_index(words, key) result(w)
    character(*), intent(in) :: words(:)
    character(4), intent(in) :: key

    do w = size(words), 1, -1
      if (key_of(words(w)) == key) return
    end do
  end function word_index

  !> The words of a list in one line.
  pure function word_list(words, separator) result(list)
    character(*), intent(in) :: words(:)
    character(*), intent(in) :: separator
    character(:), allocatable :: list
    integer :: w

    list = trim(words(1))
    do w = 2, size(words)
      list = list//separator//trim(words(w))
    end do
  end function word_list

end module input_record
