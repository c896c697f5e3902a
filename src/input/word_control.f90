!> The first records of a deck: FEAP ** title, then the control record or `ndm = 3`.
module word_control
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count, RECORD_WORDS, RECORD_END
  use deck_stream, only: deck_t, get_integer
  use input_draft, only: draft_t, known_word
  use input_fields, only: get_numbers
  implicit none
  private
  public :: read_title, read_control

  !> Order of the control record; three further numbers give the sizes of FEAP's arrays and are not
  !! used.
  integer, parameter :: NUMNP = 1, NUMEL = 2, NUMMAT = 3, NDM = 4, NDF = 5, NEN = 6
  character(*), parameter :: USAGE = "write 'ndm = 3' and a blank record, or six numbers, " &
                             //"'numnp numel nummat ndm ndf nen'"
  character(*), parameter :: ZERO_HINT = 'give a positive number, or 0 to let the program count; ' &
                             //'ndm and ndf must be 3'

contains

  !> Read FEAP ** title.
  subroutine read_title(draft, deck, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(place_t) :: at
    integer :: first, last

    call next_words(deck, record, error)
    if (allocated(error)) return
    if (record%kind == RECORD_END) then
      call fail(error, DECK_ERROR, 'the deck has no records', record%place(1), &
                "the first record of a deck is 'FEAP ** title'")
    else if (record%key(1) /= 'feap') then
      call fail(error, DECK_ERROR, 'expected FEAP, found '//quoted(record%text(1)), &
                record%place(1), "the first record of a deck is 'FEAP ** title'")
    else
      at = record%place(1)
      first = at%column + 4
      last = len_trim(at%text)
      if (at%text(last:last) == achar(13)) last = len_trim(at%text(:last - 1))
      do while (first <= last)
        if (verify(at%text(first:first), ' *'//achar(9)) /= 0) exit
        first = first + 1
      end do
      draft%model%title = at%text(first:last)
    end if
  end subroutine read_title

  !> Read six to nine numbers, or records such as `ndm = 3` up to a blank record or another word.
  subroutine read_control(draft, deck, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: n(9), i

    call next_words(deck, record, error)
    if (allocated(error)) return
    if (record%kind == RECORD_END) then
      call fail(error, DECK_ERROR, 'the deck ends after its title', record%place(1), USAGE)
      return
    end if
    draft%control%place = record%place(1)
    n = 0
    n(NDF) = 3
    if (size_index(record) > 0) then
      do while (record%kind == RECORD_WORDS)
        i = size_index(record)
        if (i == 0) then
          draft%has_pending = .true.
          draft%pending = record
          exit
        end if
        call check_count(record, 2, 2, USAGE, error)
        if (.not. allocated(error)) call get_integer(deck, record, 2, n(i), error)
        if (allocated(error)) return
        if (n(i) < 0) call fail(error, DECK_ERROR, record%text(1)//' must not be negative, found ' &
                                //to_text(n(i)), record%place(2), &
                                ZERO_HINT)
        if (i == NDM) draft%control%place = record%place(2)
        if (.not. allocated(error)) call deck%next_of_set(record, error)
        if (allocated(error)) return
      end do
    else if (known_word(draft, record%text(1))) then
      draft%has_pending = .true.
      draft%pending = record
      call fail(error, DECK_ERROR, 'the control record is missing', record%place(1), USAGE)
    else
      call check_count(record, 6, 9, USAGE, error)
      if (.not. allocated(error)) call get_numbers(deck, record, 1, n(:record%n), error, 0)
      if (allocated(error)) return
      i = findloc(n < 0, .true., 1)
      if (i > 0) call fail(error, DECK_ERROR, 'number '//to_text(i)//' of the control record ' &
                           //'must not be negative, found '//to_text(n(i)), record%place(i), &
                           ZERO_HINT)
    end if
    if (allocated(error)) return
    associate (c => draft%control)
      c%numnp = n(NUMNP)
      c%numel = n(NUMEL)
      c%nummat = n(NUMMAT)
      c%nen = n(NEN)
      if (n(NDM) /= 3) then
        call fail(error, DECK_ERROR, 'expected ndm = 3, found '//to_text(n(NDM)), c%place, &
                  'ndm is the number of dimensions; all models are three-dimensional')
      else if (n(NDF) /= 3) then
        call fail(error, DECK_ERROR, 'expected ndf = 3, found '//to_text(n(NDF)), c%place, &
                  'ndf is the number of dofs of a node, its three displacements')
      else if (n(NEN) > 27) then
        call fail(error, DECK_ERROR, 'expected nen of at most 27, found '//to_text(n(NEN)), &
                  c%place, 'nen is the largest number of nodes of an element of ELEMents')
      end if
    end associate
  end subroutine read_control

  !> Which number of the control record does a record such as `ndm = 3` give? The result is its
  !! position, or 0 if the record gives none of them. Two of FEAP's names are also mesh words, but a
  !! mesh word is not followed by an equals sign.
  pure integer function size_index(record) result(i)
    type(record_t), intent(in) :: record

    select case (record%key(1))
    case ('node', 'numn')
      i = NUMNP
    case ('nume')
      i = NUMEL
    case ('elem')
      i = merge(NUMEL, 0, record%assigns())
    case ('numm')
      i = NUMMAT
    case ('mate')
      i = merge(NUMMAT, 0, record%assigns())
    case ('ndm', 'dime')
      i = NDM
    case ('ndf', 'dofs')
      i = NDF
    case ('nen', 'elno')
      i = NEN
    case default
      i = 0
    end select
  end function size_index

  !> Read the next record that is not blank.
  subroutine next_words(deck, record, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    do
      call deck%next(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_WORDS .or. record%kind == RECORD_END) return
    end do
  end subroutine next_words

end module word_control
