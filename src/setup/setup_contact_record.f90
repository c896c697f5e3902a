!> The records of a CONTact, one reader each. Which laws there are is their table's to say.
module setup_contact_record
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, key_of
  use contact_pair, only: bond_t
  use contact_spec, only: contact_spec_t, spec_law_t
  use contact_table, only: load_contact_laws
  use contact_type, only: contact_law_t, NORMAL, FRICTION, COHESIVE
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use setup_where, only: read_where, W_FACES
  implicit none
  private
  public :: read_contact_line

  character(*), parameter :: SURFACE_USAGE = 'SURFaces patch face patch face'
  character(*), parameter :: BOND_USAGE = 'BONDed HALFspace px py pz  nx ny nz [GAP d], or ' &
                             //'BOX x1 y1 z1  x2 y2 z2 [GAP d]'
  integer, parameter :: MAX_POINT = 50 !! integration points of an element in one direction

contains

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
      call read_normal(deck, line, contact%normal, error)
    case ('fric')
      call read_friction(deck, line, contact, error)
    case ('cohe')
      call read_cohesive(deck, line, contact%cohesive, error)
    case ('bond')
      call read_bond(deck, line, contact, error)
    case ('dept')
      call check_count(line, 2, 2, 'DEPTh d', error)
      if (.not. allocated(error)) call read_positive(deck, line, 2, 'depth', contact%depth, error)
    case default ! QUADrature
      call read_quadrature(deck, line, contact%n, error)
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
      if (contact%at(k)%kind /= W_FACES) then
        call fail(error, DECK_ERROR, 'a contact acts between faces of patches', &
                  contact%at(k)%place, SURFACE_USAGE//'; SIDEs and ALL are several faces')
        return
      end if
    end do
    call check_count(line, i - 1, i - 1, SURFACE_USAGE, error)
  end subroutine read_surfaces

  !> NORMal PENAlty eps, or AUTO [factor].
  subroutine read_normal(deck, line, law, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    integer :: i

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
      call check_count(line, i, i + 1, trim(law%row%usage), error)
      if (allocated(error) .or. line%n == i) return
      call read_positive(deck, line, i + 1, 'factor of AUTO', law%factor, error)
    else
      call check_count(line, i, i, trim(law%row%usage), error)
      if (.not. allocated(error)) call read_positive(deck, line, i, 'penalty', law%prop(1), error)
    end if
  end subroutine read_normal

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

  !> COHEsive law and its numbers, all of them positive.
  subroutine read_cohesive(deck, line, law, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(spec_law_t), intent(inout) :: law
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n

    call find_law(line, 2, COHESIVE, law, error)
    if (allocated(error)) return
    n = law%row%nprop
    call check_count(line, n + 2, n + 2, trim(law%row%usage), error)
    do i = 1, n
      if (allocated(error)) return
      call read_positive(deck, line, i + 2, 'number', law%prop(i), error)
    end do
  end subroutine read_cohesive

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
      if (table(j)%role /= role) cycle
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

  !> BONDed [HALFspace or BOX] [GAP d]; several of them intersect.
  subroutine read_bond(deck, line, contact, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(contact_spec_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    type(bond_t) :: bond
    integer :: i

    if (.not. allocated(contact%bond_place%file)) contact%bond_place = line%place(1)
    i = 2
    select case (line%key(2))
    case ('half', 'box')
      call read_region(deck, line, bond, error)
      if (allocated(error)) return
      contact%bond = [contact%bond, bond]
      i = 9
      if (line%n < i) return
    case default
      continue ! GAP alone: everywhere
    end select
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

  !> HALFspace px py pz  nx ny nz, or BOX x1 y1 z1  x2 y2 z2.
  subroutine read_region(deck, line, bond, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(bond_t), intent(out) :: bond
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6), length
    integer :: d

    call check_count(line, 8, 10, BOND_USAGE, error)
    do d = 1, 6
      if (allocated(error)) return
      call get_real(deck, line, d + 2, x(d), error)
    end do
    if (allocated(error)) return
    bond%is_box = line%key(2) == 'box'
    bond%a = x(:3)
    bond%b = x(4:)
    length = norm2(x(4:))
    if (bond%is_box) then
      bond%a = min(x(:3), x(4:))
      bond%b = max(x(:3), x(4:))
    else if (.not. length > 0.0_wp) then
      call fail(error, DECK_ERROR, 'the normal of the half space has no length', line%place(6), &
                BOND_USAGE)
    else
      bond%b = x(4:)/length
    end if
  end subroutine read_region

  !> QUADrature n1 n2.
  subroutine read_quadrature(deck, line, n, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    integer, intent(inout) :: n(2)
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(line, 3, 3, 'QUADrature n1 n2', error)
    do d = 1, 2
      if (allocated(error)) return
      call get_integer(deck, line, d + 1, n(d), error)
      if (allocated(error)) return
      if (n(d) >= 1 .and. n(d) <= MAX_POINT) cycle
      call fail(error, DECK_ERROR, to_text(n(d))//' integration points', line%place(d + 1), &
                '1 to '//to_text(MAX_POINT)//' points in each direction')
    end do
  end subroutine read_quadrature

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

end module setup_contact_record
