!> CONTact: reads its records and their options into the draft of the model.
!!
!! Checks and hints of its records use CONTACT_RECORDS; those of the options use one list for each
!! record.
module word_contact
  use base_error, only: error_t, fail, DECK_ERROR, BUG
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, lower, fits_name
  use contact_pair, only: bond_t, HALFPASS, BALANCED, MORTAR, MAX_POINT
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, contact_entry_t, next_line
  use input_option, only: next_option, read_positive, with_options
  use input_record, only: check_record, record_word_t
  use input_where, only: read_where, W_FACES, W_GROUP
  use word_contact_law, only: read_normal, read_friction, read_cohesive, set_usual_normal
  implicit none
  private
  public :: read_contact, contact_named

  character(*), parameter :: POINT_OPTION(1) = ['REFIne m']
  character(*), parameter :: BOND_OPTION(1) = ['GAP d']
  character(*), parameter :: SCHEME_USAGE = 'SCHEme HALFpass | BALAnced | MORTar'
  character(*), parameter :: SURFACE_USAGE = 'SURFaces patch face patch face'
  integer, parameter :: MAX_CELL = 10  !! cells of an element in one direction
  integer, parameter :: LONGEST = 32   !! longest name; it becomes part of column names

  type(record_word_t), parameter, public :: CONTACT_RECORDS(9) = [ &
                                            record_word_t('SURFaces'), record_word_t('NORMal'), &
                                            record_word_t('FRICtion'), record_word_t('COHEsive'), &
                                            record_word_t('BONDed', .true.), &
                                            record_word_t('DEPTh'), record_word_t('QUADrature'), &
                                            record_word_t('BALAnced'), &
                                            record_word_t('SCHEme')]

contains

  !> Index of a contact by its name; 0: there is none.
  pure integer function contact_named(draft, name) result(c)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name

    do c = size(draft%contact), 1, -1
      if (lower(draft%contact(c)%contact%name) == lower(name)) return
    end do
  end function contact_named

  !> Read CONTact,name and its records.
  subroutine read_contact(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(contact_entry_t) :: entry
    type(record_t) :: line
    logical :: more, seen(size(CONTACT_RECORDS))
    integer :: i

    call check_count(record, 2, 2, 'CONTact,name', error)
    if (allocated(error)) return
    i = contact_named(draft, record%text(2))
    if (.not. fits_name(record%text(2), LONGEST)) then
      call fail(error, DECK_ERROR, 'a contact cannot be named '//quoted(record%text(2)), &
                record%place(2), 'columns are named after the contact: use up to ' &
                //to_text(LONGEST)//' letters, digits, _ and -')
    else if (i > 0) then
      call fail(error, DECK_ERROR, 'duplicate contact '//quoted(record%text(2)), record%place(2), &
                'the first one is in line '//to_text(draft%contact(i)%contact%place%line))
    end if
    if (allocated(error)) return
    entry%contact%name = record%text(2)
    entry%contact%place = record%place(2)
    allocate (entry%contact%bond(0))
    draft%contact = [draft%contact, entry] ! the name is known even if a record fails
    seen = .false.
    do
      call next_line(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call check_option(line, error)
      if (allocated(error)) return
      call check_record(line, CONTACT_RECORDS, 'CONTact', &
                        'contact '//quoted(entry%contact%name), seen, error)
      if (allocated(error)) return
      select case (line%key(1))
      case ('surf')
        call read_surfaces(deck, line, entry, error)
      case ('norm')
        call read_normal(deck, line, entry, error)
      case ('fric')
        call read_friction(deck, line, entry, error)
      case ('cohe')
        call read_cohesive(deck, line, entry, error)
      case ('bond')
        call read_bond(deck, line, entry, error)
      case ('quad')
        call read_quadrature(deck, line, entry, error)
      case ('bala')
        call check_count(line, 1, 1, 'BALAnced', error)
        if (.not. allocated(error) .and. entry%contact%scheme /= 0) then
          call fail(error, DECK_ERROR, 'both SCHEme and BALAnced are given', line%place(1), &
                    "BALAnced alone means 'SCHEme BALAnced': give only one of the two records")
        end if
        entry%contact%scheme = BALANCED
        entry%scheme_place = line%place(1)
      case ('sche')
        if (entry%contact%scheme /= 0) then
          call fail(error, DECK_ERROR, 'both SCHEme and BALAnced are given', line%place(1), &
                    "BALAnced alone means 'SCHEme BALAnced': give only one of the two records")
        else
          call read_scheme(line, entry, error)
        end if
        entry%scheme_place = line%place(1)
      case ('dept')
        call check_count(line, 2, 2, 'DEPTh d', error)
        if (.not. allocated(error)) call read_positive(deck, line, 2, 'depth', &
                                                       entry%contact%depth, error)
      case default
        call fail(error, BUG, 'the record '//line%text(1)//' of CONTact has no reader', &
                  line%place(1))
      end select
      if (allocated(error)) return
    end do
    if (.not. entry%contact%normal%given) call set_usual_normal(entry%contact%normal)
    call check_complete(entry, error)
    draft%contact(size(draft%contact)) = entry
  end subroutine read_contact

  !> An option of a record is not a record of its own: name the record to which it belongs.
  subroutine check_option(line, error)
    type(record_t), intent(in) :: line
    type(error_t), allocatable, intent(out) :: error
    character(4), parameter :: OPTIONS(8) = ['refi', 'pair', 'smoo', 'bord', 'afte', 'irre', &
                                             'visc', 'gap ']
    character(10), parameter :: OWNER(8) = &
                                [character(10) :: 'QUADrature', 'NORMal', 'NORMal', 'NORMal', &
                                                   'FRICtion', 'COHEsive', 'COHEsive', 'BONDed']
    integer :: i

    i = findloc(OPTIONS, line%key(1), 1)
    if (i == 0) return
    call fail(error, DECK_ERROR, quoted(line%text(1))//' is not a record of a CONTact', &
              line%place(1), 'it is an option: write it at the end of the record '//trim(OWNER(i)))
  end subroutine check_option

  !> Read SCHEme HALFpass, BALAnced or MORTar.
  subroutine read_scheme(line, entry, error)
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 2, SCHEME_USAGE, error)
    if (allocated(error)) return
    select case (line%key(2))
    case ('half')
      entry%contact%scheme = HALFPASS
    case ('bala')
      entry%contact%scheme = BALANCED
    case ('mort')
      entry%contact%scheme = MORTAR
    case default
      call fail(error, DECK_ERROR, 'unknown scheme '//quoted(line%text(2)), line%place(2), &
                SCHEME_USAGE)
    end select
  end subroutine read_scheme

  !> Check for missing records, and for records that need or exclude each other.
  subroutine check_complete(entry, error)
    type(contact_entry_t), intent(in) :: entry
    type(error_t), allocatable, intent(out) :: error

    associate (contact => entry%contact)
      if (entry%at(1)%type == 0) then
        call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//' has no SURFaces', &
                  contact%place, "give '"//SURFACE_USAGE//"'")
      else if (allocated(entry%bond_place%file) .and. .not. contact%cohesive%given) then
        call fail(error, DECK_ERROR, 'BONDed needs COHEsive, but this contact has none', &
                  entry%bond_place, "give the law of the bonds, for instance 'COHEsive " &
                  //"EXPOnential T0 g0', or remove BONDed")
      else if (contact%on_pair .and. .not. contact%cohesive%given) then
        call fail(error, DECK_ERROR, 'PAIR needs COHEsive, but this contact has none', &
                  entry%pair_place, 'only bonded points have a partner: give COHEsive, or remove ' &
                  //'PAIR')
      else if (contact%scheme == MORTAR .and. (contact%cohesive%given .or. &
                                               contact%taper > 0.0_wp .or. contact%ncell > 1)) then
        call fail(error, DECK_ERROR, 'SCHEme MORTar cannot be used together with COHEsive, ' &
                  //'BORDer or REFIne', entry%scheme_place, &
                  'these need integration points that keep their positions on the surface: give ' &
                  //'SCHEme BALAnced, or no SCHEme')
      else if (contact%ncell > 1 .and. contact%cohesive%given) then
        call fail(error, DECK_ERROR, 'REFIne cannot be used together with COHEsive', &
                  entry%refine_place, 'remove REFIne, and use more integration points for the ' &
                  //"bonds with 'QUADrature n1 n2'")
      end if
    end associate
  end subroutine check_complete

  !> Read SURFaces patch face patch face.
  subroutine read_surfaces(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    integer :: i, k

    i = 2
    do k = 1, 2
      if (i > line%n) call check_count(line, 5, 5, SURFACE_USAGE, error)
      if (.not. allocated(error)) call read_where(deck, line, i, entry%at(k), error)
      if (allocated(error)) return
      if (entry%at(k)%type /= W_FACES .and. entry%at(k)%type /= W_GROUP) then
        call fail(error, DECK_ERROR, 'a side of a contact is not a face of a patch', &
                  entry%at(k)%place, SURFACE_USAGE &
                  //'; a side may also be SIDEs, ALL or a named group')
        return
      end if
    end do
    call check_count(line, i - 1, i - 1, SURFACE_USAGE, error)
  end subroutine read_surfaces

  !> Read BONDed [[EXCEpt] HALFspace or BOX] [GAP d]. With several records, a point is bonded if it
  !! lies in every region without EXCEpt and in no region with EXCEpt.
  subroutine read_bond(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    type(bond_t) :: bond
    real(wp) :: x(6)
    logical :: seen(size(BOND_OPTION))
    character(:), allocatable :: usage
    character(4) :: key
    integer :: d, i

    usage = with_options('BONDed [EXCEpt] HALFspace px py pz  nx ny nz | BOX x1 y1 z1  x2 y2 z2', &
                         BOND_OPTION)
    if (.not. allocated(entry%bond_place%file)) entry%bond_place = line%place(1)
    bond%is_except = line%key(2) == 'exce'
    i = merge(3, 2, bond%is_except)
    bond%is_box = line%key(i) == 'box'
    if (bond%is_box .or. line%key(i) == 'half') then
      call check_count(line, i + 6, huge(i), usage, error)
      do d = 1, 6
        if (.not. allocated(error)) call get_real(deck, line, i + d, x(d), error)
      end do
      if (allocated(error)) return
      bond%a = x(:3)
      bond%b = x(4:)
      if (bond%is_box) then
        bond%a = min(x(:3), x(4:))
        bond%b = max(x(:3), x(4:))
      else if (.not. norm2(x(4:)) > 0.0_wp) then
        call fail(error, DECK_ERROR, 'the normal of the half space is zero', line%place(i + 4), &
                  usage)
        return
      else
        bond%b = x(4:)/norm2(x(4:))
      end if
      entry%contact%bond = [entry%contact%bond, bond]
      i = i + 6
    else if (bond%is_except) then
      call fail(error, DECK_ERROR, 'the region after EXCEpt is missing', line%place(i), usage)
      return
    else
      i = 1 ! GAP alone: all points are bonded
      call check_count(line, 2, huge(i), usage, error)
    end if
    seen = entry%contact%bond_gap >= 0.0_wp ! one GAP applies to all records
    do
      if (.not. allocated(error)) call next_option(line, i, BOND_OPTION, usage, seen, key, error)
      if (allocated(error)) return
      select case (key)
      case ('gap')
        i = i + 1
        call read_positive(deck, line, i, 'gap', entry%contact%bond_gap, error)
      case default
        return
      end select
    end do
  end subroutine read_bond

  !> Read QUADrature n1 n2 [REFIne m].
  subroutine read_quadrature(deck, line, entry, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_entry_t), intent(inout) :: entry
    type(error_t), allocatable, intent(out) :: error
    logical :: seen(size(POINT_OPTION))
    character(:), allocatable :: usage
    character(4) :: key
    integer :: i

    usage = with_options('QUADrature n1 n2', POINT_OPTION)
    associate (contact => entry%contact)
      call check_count(line, 3, huge(i), usage, error)
      contact%given_points = .true.
      do i = 2, 3
        if (.not. allocated(error)) call read_number(i, 1, MAX_POINT, ' integration points', &
                                                     contact%ngauss(i - 1))
      end do
      i = 3
      seen = .false.
      do
        if (.not. allocated(error)) call next_option(line, i, POINT_OPTION, usage, seen, key, &
                                                     error)
        if (allocated(error)) return
        select case (key)
        case ('refi')
          entry%refine_place = line%place(i)
          i = i + 1
          call read_number(i, 2, MAX_CELL, ' cells', contact%ncell)
        case default
          return
        end select
      end do
    end associate

  contains

    !> Read field i: a number of points or cells in each direction of an element.
    subroutine read_number(i, least, most, what, n)
      integer, intent(in) :: i, least, most
      character(*), intent(in) :: what
      integer, intent(inout) :: n

      call get_integer(deck, line, i, n, error)
      if (allocated(error)) return
      if (n >= least .and. n <= most) return
      call fail(error, DECK_ERROR, 'expected '//to_text(least)//' to '//to_text(most)//what &
                //' in each direction, found '//to_text(n), line%place(i), usage)
    end subroutine read_number
  end subroutine read_quadrature

end module word_contact
