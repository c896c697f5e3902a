!> The first records of a deck: FEAP ** title, then the control record or `ndm = 3`.
module word_control
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count, RECORD_WORDS, RECORD_END
  use deck_stream, only: deck_t, get_integer
  use input_draft, only: build_t, known_word
  implicit none
  private
  public :: read_title, read_control

  character(*), parameter :: USAGE = 'write ndm = 3 and a blank record, or six numbers: numnp ' &
                             //'numel nummat ndm ndf nen'

contains

  !> FEAP ** title.
  subroutine read_title(build, deck, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(place_t) :: at

    call next_words(deck, record, error)
    if (allocated(error)) return
    if (record%kind == RECORD_END) then
      call fail(error, DECK_ERROR, 'the deck holds no record', record%place(1), &
                'it begins with FEAP ** title')
    else if (record%key(1) /= 'feap') then
      call fail(error, DECK_ERROR, 'the deck begins with '//quoted(record%text(1)), &
                record%place(1), 'its first record is FEAP ** title')
    else
      at = record%place(1)
      build%model%title = title_of(at%text, at%column)
    end if
  end subroutine read_title

  !> What stands behind FEAP and its stars.
  pure function title_of(line, column) result(title)
    character(*), intent(in) :: line
    integer, intent(in) :: column
    character(:), allocatable :: title
    integer :: i, n

    i = column + 4
    do while (i <= len(line))
      if (verify(line(i:i), ' *'//achar(9)) /= 0) exit
      i = i + 1
    end do
    n = len_trim(line)
    if (n > 0) then
      if (line(n:n) == achar(13)) n = len_trim(line(:n - 1))
    end if
    title = line(i:n)
  end function title_of

  !> Six numbers, or `ndm = 3` and its like up to a blank record.
  subroutine read_control(build, deck, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: ndm, ndf

    call next_words(deck, record, error)
    if (allocated(error)) return
    ndm = 0
    ndf = 3
    if (record%kind == RECORD_END) then
      call fail(error, DECK_ERROR, 'the deck ends behind its title', record%place(1), USAGE)
      return
    end if
    build%control%place = record%place(1)
    if (is_size(record)) then
      call read_sizes(build, deck, record, ndm, ndf, error)
    else
      call read_numbers(build, deck, record, ndm, ndf, error)
    end if
    if (allocated(error)) return
    if (ndm /= 3) then
      call fail(error, DECK_ERROR, 'ndm is '//to_text(ndm), build%control%place, &
                'this program is for three dimensions: ndm = 3')
    else if (ndf /= 3) then
      call fail(error, DECK_ERROR, 'ndf is '//to_text(ndf), build%control%place, &
                'a node has three displacements: ndf = 3')
    else if (build%control%nen > 27) then
      call fail(error, DECK_ERROR, 'nen is '//to_text(build%control%nen), build%control%place, &
                'elements of a FEAP mesh have up to 27 nodes')
    end if
  end subroutine read_control

  !> `ndm = 3` and its like, up to a blank record or another word.
  subroutine read_sizes(build, deck, record, ndm, ndf, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(inout) :: record
    integer, intent(inout) :: ndm, ndf
    type(error_t), allocatable, intent(out) :: error

    do while (record%kind == RECORD_WORDS)
      if (.not. is_size(record)) then
        build%has_pending = .true.
        build%pending = record
        exit
      end if
      call read_size(build, deck, record, ndm, ndf, error)
      if (allocated(error)) return
      call deck%next_of_set(record, error)
      if (allocated(error)) return
    end do
  end subroutine read_sizes

  !> FEAP's six numbers; three more size its arrays and mean nothing here.
  subroutine read_numbers(build, deck, record, ndm, ndf, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(out) :: ndm, ndf
    type(error_t), allocatable, intent(out) :: error
    integer :: n(9), i

    n = 0
    ndm = 0
    ndf = 3
    if (known_word(build, record%text(1))) then
      build%has_pending = .true.
      build%pending = record
      call fail(error, DECK_ERROR, 'the control record is missing', record%place(1), USAGE)
      return
    end if
    call check_count(record, 6, 9, USAGE, error)
    if (allocated(error)) return
    do i = 1, record%n
      call get_integer(deck, record, i, n(i), error, 0)
      if (allocated(error)) return
      if (n(i) < 0) call fail(error, DECK_ERROR, 'the control record holds '//to_text(n(i)), &
                              record%place(i), 'counts are not negative; zeros are counted')
      if (allocated(error)) return
    end do
    associate (c => build%control)
      c%numnp = n(1)
      c%numel = n(2)
      c%nummat = n(3)
      c%nen = n(6)
    end associate
    ndm = n(4)
    ndf = n(5)
  end subroutine read_numbers

  !> FEAP's names of the numbers of the control record; two of them are mesh words without their =.
  pure logical function is_size(record)
    type(record_t), intent(in) :: record

    select case (record%key(1))
    case ('ndm', 'dime', 'ndf', 'dofs', 'nen', 'elno', 'node', 'numn', 'nume', 'numm')
      is_size = .true.
    case ('elem', 'mate')
      is_size = index(record%raw, '=') > 0
    case default
      is_size = .false.
    end select
  end function is_size

  subroutine read_size(build, deck, record, ndm, ndf, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(inout) :: ndm, ndf
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    call check_count(record, 2, 2, USAGE, error)
    if (allocated(error)) return
    call get_integer(deck, record, 2, n, error)
    if (allocated(error)) return
    if (n < 0) then
      call fail(error, DECK_ERROR, record%text(1)//' is '//to_text(n), record%place(2), &
                'counts are not negative; zeros are counted')
      return
    end if
    select case (record%key(1))
    case ('ndm', 'dime')
      ndm = n
      build%control%place = record%place(2)
    case ('ndf', 'dofs')
      ndf = n
    case ('nen', 'elno')
      build%control%nen = n
    case ('node', 'numn')
      build%control%numnp = n
    case ('elem', 'nume')
      build%control%numel = n
    case default
      build%control%nummat = n
    end select
  end subroutine read_size

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
