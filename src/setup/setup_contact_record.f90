!> The records of a CONTact, one reader each. Those of its laws are in setup_contact_law.
module setup_contact_record
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use contact_pair, only: bond_t
  use contact_spec, only: contact_spec_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use setup_contact_law, only: read_normal, read_friction, read_cohesive, read_positive
  use setup_where, only: read_where, W_FACES, W_GROUP
  implicit none
  private
  public :: read_contact_line

  character(*), parameter :: SURFACE_USAGE = 'SURFaces patch face patch face'
  character(*), parameter :: BOND_USAGE = 'BONDed [EXCEpt] HALFspace px py pz  nx ny nz [GAP d], ' &
                             //'or [EXCEpt] BOX x1 y1 z1  x2 y2 z2 [GAP d]'
  character(*), parameter :: POINT_USAGE = 'QUADrature n1 n2 [REFIne m]'
  integer, parameter :: MAX_POINT = 50 !! integration points of an element in one direction
  integer, parameter :: MAX_CELL = 10  !! cells of an element in one direction

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

end module setup_contact_record
