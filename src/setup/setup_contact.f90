!> CONTact: two surfaces and what acts between them.
module setup_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower, fits_name
  use contact_spec, only: contact_spec_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t
  use setup_build, only: build_t, next_line
  use setup_contact_record, only: read_contact_line
  use setup_record, only: check_record
  implicit none
  private
  public :: read_contact, contact_named

  character(10), parameter :: WORD(8) = ['SURFaces  ', 'NORMal    ', 'FRICtion  ', 'COHEsive  ', &
                                         'BONDed    ', 'DEPTh     ', 'QUADrature', &
                                         'BALAnced  ']
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
      call check_record(line, WORD, 'bond', 'CONTact', 'contact '//quoted(contact%name), seen, &
                        error)
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
    else if (contact%ncell > 1 .and. contact%cohesive%given) then
      call fail(error, DECK_ERROR, 'REFIne with COHEsive', contact%refine_place, &
                'bonds have points of their own: give more of them, QUADrature n1 n2')
    end if
  end subroutine check_complete

end module setup_contact
