!> CONTact: two surfaces and what acts between them.
!!
!! The records of a CONTact, one reader each. Those of its laws are in word_contact.
!!
!! The laws of a CONTact: the readers of NORMal, FRICtion and COHEsive. Which laws there are is
!! their table's to say.
module word_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, lower, fits_name, key_of
  use contact_spec, only: contact_spec_t, spec_law_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, next_line
  use input_record, only: check_record
  use base_kinds, only: wp
  use contact_pair, only: bond_t
  use input_where, only: read_where, W_FACES, W_GROUP
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t, NORMAL, FRICTION, COHESIVE
  implicit none
  private
  public :: read_contact, contact_named, read_contact_line, read_normal, read_friction, &
            read_cohesive, read_positive

  character(4), parameter :: OPTION(3) = ['pair', 'smoo', 'bord'] !! of NORMal

  character(*), parameter :: SURFACE_USAGE = 'SURFaces patch face patch face'
  character(*), parameter :: BOND_USAGE = 'BONDed [EXCEpt] HALFspace px py pz  nx ny nz [GAP d], ' &
                             //'or [EXCEpt] BOX x1 y1 z1  x2 y2 z2 [GAP d]'
  character(*), parameter :: POINT_USAGE = 'QUADrature n1 n2 [REFIne m]'
  integer, parameter :: MAX_POINT = 50 !! integration points of an element in one direction
  integer, parameter :: MAX_CELL = 10  !! cells of an element in one direction

  character(10), parameter, public :: WORD(8) = ['SURFaces  ', 'NORMal    ', 'FRICtion  ', &
                                                 'COHEsive  ', 'BONDed    ', 'DEPTh     ', &
                                                 'QUADrature', 'BALAnced  ']
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

  !> One record, whose word is known.
  subroutine read_contact_line(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error

    select case (line%key(1))
    case ('surf')
      call read_surfaces(deck, line, contact, error)
    case ('norm')
      call read_normal(deck, line, contact, error)
    case ('fric')
      call read_friction(deck, line, contact, error)
    case ('cohe')
      call read_cohesive(deck, line, contact, error)
    case ('bond')
      call read_bond(deck, line, contact, error)
    case ('dept')
      call check_count(line, 2, 2, 'DEPTh d', error)
      if (.not. allocated(error)) call read_positive(deck, line, 2, 'depth', contact%depth, error)
    case ('bala')
      call check_count(line, 1, 1, 'BALAnced', error)
      contact%balanced = .true.
    case default ! QUADrature
      call read_quadrature(deck, line, contact, error)
    end select
  end subroutine read_contact_line

  !> SURFaces patch face patch face.
  subroutine read_surfaces(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer :: i, k

    i = 2
    do k = 1, 2
      if (i > line%n) call check_count(line, 5, 5, SURFACE_USAGE, error)
      if (.not. allocated(error)) call read_where(deck, line, i, contact%at(k), error)
      if (allocated(error)) return
      if (contact%at(k)%kind /= W_FACES .and. contact%at(k)%kind /= W_GROUP) then
        call fail(error, DECK_ERROR, 'a contact acts between faces of patches', &
                  contact%at(k)%place, SURFACE_USAGE//'; SIDEs and ALL are several faces')
        return
      end if
    end do
    call check_count(line, i - 1, i - 1, SURFACE_USAGE, error)
  end subroutine read_surfaces

  !> BONDed [[EXCEpt] HALFspace or BOX] [GAP d]; several of them intersect.
  subroutine read_bond(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    type(bond_t) :: bond
    integer :: i

    if (.not. allocated(contact%bond_place%file)) contact%bond_place = line%place(1)
    i = 2
    bond%is_except = line%key(2) == 'exce'
    if (bond%is_except) i = 3
    if (bond%is_except .or. line%key(i) == 'half' .or. line%key(i) == 'box') then
      call read_region(deck, line, i, bond, error)
      if (allocated(error)) return
      contact%bond = [contact%bond, bond]
      if (line%n < i) return
    end if ! GAP alone: everywhere
    if (line%key(i) /= 'gap') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of BONDed', &
                line%place(i), BOND_USAGE)
      return
    else if (contact%bond_gap >= 0.0_wp) then
      call fail(error, DECK_ERROR, 'the GAP of the bond stands twice', line%place(i), &
                'one GAP counts for all records of BONDed')
      return
    end if
    call check_count(line, i + 1, i + 1, BOND_USAGE, error)
    if (.not. allocated(error)) call read_positive(deck, line, i + 1, 'gap', contact%bond_gap, &
                                                   error)
  end subroutine read_bond

  !> HALFspace px py pz  nx ny nz, or BOX x1 y1 z1  x2 y2 z2, from field i on; i: what follows.
  subroutine read_region(deck, line, i, bond, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    type(bond_t), intent(inout) :: bond
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6), length
    integer :: d

    bond%is_box = line%key(i) == 'box'
    if (.not. (bond%is_box .or. line%key(i) == 'half')) then
      call fail(error, DECK_ERROR, 'BONDed EXCEpt what? A region is missing', line%place(i), &
                'BONDed EXCEpt BOX x1 y1 z1  x2 y2 z2, or EXCEpt HALFspace px py pz  nx ny nz')
      return
    end if
    call check_count(line, i + 6, i + 8, BOND_USAGE, error)
    do d = 1, 6
      if (allocated(error)) return
      call get_real(deck, line, i + d, x(d), error)
    end do
    if (allocated(error)) return
    bond%a = x(:3)
    bond%b = x(4:)
    length = norm2(x(4:))
    if (bond%is_box) then
      bond%a = min(x(:3), x(4:))
      bond%b = max(x(:3), x(4:))
    else if (.not. length > 0.0_wp) then
      call fail(error, DECK_ERROR, 'the normal of the half space has no length', &
                line%place(i + 4), BOND_USAGE)
    else
      bond%b = x(4:)/length
    end if
    i = i + 7
  end subroutine read_region

  !> QUADrature n1 n2 [REFIne m].
  subroutine read_quadrature(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(line, 3, 5, POINT_USAGE, error)
    do d = 1, 2
      if (allocated(error)) return
      call get_integer(deck, line, d + 1, contact%n(d), error)
      if (allocated(error)) return
      if (contact%n(d) >= 1 .and. contact%n(d) <= MAX_POINT) cycle
      call fail(error, DECK_ERROR, to_text(contact%n(d))//' integration points', &
                line%place(d + 1), '1 to '//to_text(MAX_POINT)//' points in each direction')
    end do
    if (allocated(error) .or. line%n == 3) return
    if (line%key(4) /= 'refi') then
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(4)), line%place(4), &
                POINT_USAGE)
      return
    end if
    call check_count(line, 5, 5, POINT_USAGE, error)
    if (.not. allocated(error)) call get_integer(deck, line, 5, contact%ncell, error)
    if (allocated(error)) return
    contact%refine_place = line%place(4)
    if (contact%ncell >= 2 .and. contact%ncell <= MAX_CELL) return
    call fail(error, DECK_ERROR, to_text(contact%ncell)//' cells', line%place(5), &
              '2 to '//to_text(MAX_CELL)//' cells in each direction')
  end subroutine read_quadrature

  !> NORMal PENAlty eps, or AUTO [factor]; then PAIR, SMOOth d and BORDer w in any order.
  subroutine read_normal(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    associate (law => contact%normal)
      i = 2
      if (line%key(2) == 'auto') then ! of the first law
        call find_law(line, 0, NORMAL, law, error)
      else
        call find_law(line, 2, NORMAL, law, error)
        i = 3
      end if
      if (allocated(error)) return
      if (line%key(i) == 'auto') then
        law%auto = .true.
        if (line%n > i .and. all(line%key(i + 1) /= OPTION)) then
          i = i + 1
          call read_positive(deck, line, i, 'factor of AUTO', law%factor, error)
        end if
      else
        call check_count(line, i, i + 5, trim(law%row%usage), error)
        if (.not. allocated(error)) call read_positive(deck, line, i, 'penalty', law%prop(1), error)
      end if
    end associate
    do while (.not. allocated(error) .and. i < line%n)
      call read_option(deck, line, i, contact, error)
    end do
  end subroutine read_normal

  !> One option of NORMal behind field i, which then is its last.
  subroutine read_option(deck, line, i, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage

    usage = trim(contact%normal%row%usage)
    i = i + 1
    if (line%key(i) == 'pair' .and. .not. contact%on_pair) then
      contact%on_pair = .true.
      contact%pair_place = line%place(i)
    else if (line%key(i) == 'smoo' .and. .not. contact%normal%prop(2) > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 3, usage, error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'penetration of SMOOth', &
                                                     contact%normal%prop(2), error)
    else if (line%key(i) == 'bord' .and. .not. contact%border > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 3, usage, error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'width of BORDer', &
                                                     contact%border, error)
      if (allocated(error) .or. contact%border <= 1.0_wp) return
      call fail(error, DECK_ERROR, 'the width of BORDer is a share of an element, at most 1', &
                line%place(i), usage)
    else if (any(line%key(i) == OPTION)) then
      call fail(error, DECK_ERROR, line%text(i)//' stands twice', line%place(i), usage)
    else
      call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of NORMal', &
                line%place(i), usage)
    end if
  end subroutine read_option

  !> FRICtion COULomb mu PENAlty eps | AUTO [AFTEr time].
  subroutine read_friction(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage

    call find_law(line, 2, FRICTION, contact%friction, error)
    if (allocated(error)) return
    usage = trim(contact%friction%row%usage)
    associate (law => contact%friction)
      call check_count(line, 5, 7, usage, error)
      if (.not. allocated(error)) call get_real(deck, line, 3, law%prop(1), error)
      if (allocated(error)) return
      if (.not. law%prop(1) >= 0.0_wp) then
        call fail(error, DECK_ERROR, 'the coefficient of friction is '//to_text(law%prop(1)), &
                  line%place(3), 'it is not negative')
      else if (line%key(4) /= 'pena') then
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(4))//' of FRICtion', &
                  line%place(4), usage)
      else if (line%key(5) == 'auto') then
        law%auto = .true.
      else
        call read_positive(deck, line, 5, 'tangential penalty', law%prop(2), error)
      end if
      if (allocated(error) .or. line%n == 5) return
      if (line%key(6) /= 'afte') then
        call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(6))//' of FRICtion', &
                  line%place(6), usage)
        return
      end if
      call check_count(line, 7, 7, usage, error)
      if (.not. allocated(error)) call get_real(deck, line, 7, contact%after, error)
      contact%has_after = .true.
    end associate
  end subroutine read_friction

  !> COHEsive law and its numbers, all of them positive; then its options in any order.
  subroutine read_cohesive(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: hint
    integer :: i, n, wrong

    associate (law => contact%cohesive)
      call find_law(line, 2, COHESIVE, law, error)
      if (allocated(error)) return
      n = law%row%nprop
      call check_count(line, n + 2, n + 5, trim(law%row%usage), error)
      do i = 3, n + 2
        if (allocated(error)) return
        call read_positive(deck, line, i, 'number', law%prop(i - 2), error)
      end do
      i = n + 2
      do while (.not. allocated(error) .and. i < line%n)
        call read_cohesive_option(deck, line, i, law, error)
      end do
      if (allocated(error) .or. .not. associated(law%row%prepare)) return
      call law%row%prepare(law%prop, wrong, hint)
      if (wrong > 0) call fail(error, DECK_ERROR, line%text(wrong + 2)//' is out of range', &
                               line%place(wrong + 2), hint)
    end associate
  end subroutine read_cohesive

  !> One option behind field i, which then is its last: VISCous tau, or the word of another row of
  !! the same name.
  subroutine read_cohesive_option(deck, line, i, law, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: i
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    integer :: j

    i = i + 1
    if (line%key(i) == 'visc' .and. .not. law%tau > 0.0_wp) then
      i = i + 1
      call check_count(line, i, i + 1, trim(law%row%usage), error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'time of VISCous', law%tau, &
                                                     error)
      return
    end if
    call load_contact_laws(table)
    do j = 1, size(table)
      if (table(j)%role /= COHESIVE .or. table(j)%name /= law%row%name) cycle
      if (table(j)%option == law%row%option .or. table(j)%option == '') cycle
      if (key_of(table(j)%option) /= line%key(i)) cycle
      law%row = table(j)
      return
    end do
    call fail(error, DECK_ERROR, 'unknown option '//quoted(line%text(i))//' of COHEsive', &
              line%place(i), trim(law%row%usage))
  end subroutine read_cohesive_option

  !> The row of the law in field i; i = 0: the first of its role.
  subroutine find_law(line, i, role, law, error)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i, role
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    type(contact_law_t), allocatable :: table(:)
    character(:), allocatable :: known
    integer :: j

    call load_contact_laws(table)
    known = ''
    do j = 1, size(table)
      if (table(j)%role /= role .or. table(j)%option /= '') cycle
      known = known//' '//trim(table(j)%name)
      if (i > 0 .and. key_of(table(j)%name) /= line%key(max(i, 1))) cycle
      law%row = table(j)
      law%given = .true.
      return
    end do
    if (known == '') then
      call fail(error, DECK_ERROR, line%text(1)//' is not available yet', line%place(1), &
                'this version has no law for it')
    else if (line%is_empty(i)) then
      call fail(error, DECK_ERROR, 'the law of '//line%text(1)//' is missing', line%place(i), &
                'known laws:'//known)
    else
      call fail(error, DECK_ERROR, 'unknown law '//quoted(line%text(i))//' of '//line%text(1), &
                line%place(i), 'known laws:'//known)
    end if
  end subroutine find_law

  !> A number greater than zero.
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
    call fail(error, DECK_ERROR, 'the '//what//' is '//to_text(x), line%place(i), 'it is positive')
  end subroutine read_positive

end module word_contact
