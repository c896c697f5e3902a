!> CONTact: two surfaces and what acts between them.
module setup_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower, key_of, fits_name
  use contact_spec, only: contact_spec_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t
  use setup_build, only: build_t, next_line
  use setup_contact_record, only: read_contact_line
  implicit none
  private
  public :: read_contact, contact_named

  character(10), parameter :: WORD(7) = ['SURFaces  ', 'NORMal    ', 'FRICtion  ', 'COHEsive  ', &
                                         'BONDed    ', 'DEPTh     ', 'QUADrature']
  integer, parameter :: LONGEST = 32 !! of a name, which becomes part of a column's

contains

  !> Index of a contact by its name; 0: there is none.
  pure integer function contact_named(build, name) result(c)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name

    do c = size(build%contact), 1, -1
      if (lower(build%contact(c)%name) == lower(name)) return
    end do
  end function contact_named

  !> CONTact,name and its records.
  subroutine read_contact(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(contact_spec_t) :: contact
    type(record_t) :: line
    logical :: more, seen(size(WORD))

    call check_count(record, 2, 2, 'CONTact,name', error)
    if (.not. allocated(error)) call check_name(build, record, error)
    if (allocated(error)) return
    contact%name = record%text(2)
    contact%place = record%place(2)
    allocate (contact%bond(0))
    call append(build, contact) ! now: an error in its records must not make it unknown
    seen = .false.
    do
      call next_line(build, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call check_word(contact, line, seen, error)
      if (.not. allocated(error)) call read_contact_line(deck, line, contact, error)
      if (allocated(error)) return
    end do
    call check_complete(contact, error)
    build%contact(size(build%contact)) = contact
  end subroutine read_contact

  !> A name of its own, fit for the name of a column.
  subroutine check_name(build, record, error)
    type(build_t), intent(in) :: build
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    integer :: first

    first = contact_named(build, record%text(2))
    if (.not. fits_name(record%text(2), LONGEST)) then
      call fail(error, DECK_ERROR, 'a contact cannot be named '//quoted(record%text(2)), &
                record%place(2), 'its columns are named after it: use up to '//to_text(LONGEST) &
                //' letters, digits, _ and -')
    else if (first > 0) then
      call fail(error, DECK_ERROR, 'contact '//quoted(record%text(2))//' is defined twice', &
                record%place(2), 'the first one stands in line ' &
                //to_text(build%contact(first)%place%line))
    end if
  end subroutine check_name

  subroutine append(build, contact)
    type(build_t), intent(inout) :: build
    type(contact_spec_t), intent(in) :: contact
    type(contact_spec_t), allocatable :: longer(:)
    integer :: n

    n = size(build%contact)
    allocate (longer(n + 1))
    longer(:n) = build%contact
    longer(n + 1) = contact
    call move_alloc(longer, build%contact)
  end subroutine append

  !> A known record; only BONDed may stand several times.
  subroutine check_word(contact, line, seen, error)
    type(contact_spec_t), intent(in) :: contact
    type(record_t), intent(in) :: line
    logical, intent(inout) :: seen(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: w

    do w = size(WORD), 1, -1
      if (key_of(WORD(w)) == line%key(1)) exit
    end do
    if (w == 0) then
      call fail(error, DECK_ERROR, 'unknown record '//quoted(line%text(1))//' of a CONTact', &
                line%place(1), 'nearest known: '//nearest(line%text(1), WORD))
      return
    end if
    if (seen(w) .and. WORD(w) /= 'BONDed') then
      call fail(error, DECK_ERROR, trim(WORD(w))//' stands twice in contact ' &
                //quoted(contact%name), line%place(1), 'keep one of them')
    end if
    seen(w) = .true.
  end subroutine check_word

  !> What a contact cannot do without.
  subroutine check_complete(contact, error)
    type(contact_spec_t), intent(in) :: contact
    type(error_t), allocatable, intent(out) :: error

    if (contact%at(1)%kind == 0) then
      call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//' has no SURFaces', &
                contact%place, 'give SURFaces patch face patch face')
    else if (.not. contact%normal%given) then
      call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//' has no NORMal', &
                contact%place, 'give NORMal PENAlty eps, or NORMal PENAlty AUTO')
    else if (allocated(contact%bond_place%file) .and. .not. contact%cohesive%given) then
      call fail(error, DECK_ERROR, 'BONDed without COHEsive', contact%bond_place, &
                'COHEsive EXPOnential T0 g0 says what holds the bond; without it remove BONDed')
    else if (contact%on_pair .and. .not. contact%cohesive%given) then
      call fail(error, DECK_ERROR, 'PAIR without COHEsive', contact%pair_place, &
                'only bonded points have a partner: give COHEsive, or remove PAIR')
    end if
  end subroutine check_complete

end module setup_contact
