!> CURVe: tables of quantities, one column a record.
!!
!! BOOK in a CURVe: a column of the book of energies.
!!
!! CONTact records of a CURVe: quantities of one side of a contact.
!!
!! Fields that several records of a CURVe have: a direction, an axis.
module word_curve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower, key_of, fits_name
  use curve_type, only: Q_FORCE, Q_TORQUE, Q_DISP, Q_STRESS, Q_ENERGY, Q_MAX_DISP, Q_MAX_MISES, &
      quantity_t, Q_BOOK, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
      Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
      Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_real, get_integer
  use input_draft, only: build_t, curve_entry_t, column_t, next_line
  use input_where, only: read_where
  use base_kinds, only: wp
  implicit none
  private
  public :: read_curve, read_book, read_contact_column, read_direction, read_axis

  !> In the order of curve_type's B_WORK ...
  character(10), parameter :: word_book(11) = ['WORK      ', 'STORed    ', 'KINEtic   ', 'NORMal    ', &
                                          'FRICtion  ', 'COHEsive  ', 'INERtia   ', 'IMBAlance ', &
                                          'BONDs     ', 'DAMAge    ', 'VISCous   ']

  character(*), parameter :: USAGE = 'CONTact name side '
  character(11), parameter :: word_contact(9) = ['FORCe      ', 'TORQue     ', 'PRESsure   ', &
                                         'TANGential ', 'STICk      ', 'SLIP       ', &
                                         'AREA       ', 'PENEtration', 'DEBOnded   ']
  integer, parameter :: KIND(9) = [Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                                   Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, &
                                   Q_CONTACT_AREA, Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED]

  character(8), parameter :: WORD(8) = ['FORCe   ', 'TORQue  ', 'DISP    ', 'CONTact ', &
                                        'STREss  ', 'ENERgy  ', 'MAXImum ', 'BOOK    ']
  !> Components of a stress as the deck names them, and where they stand in Voigt's order.
  character(2), parameter :: COMPONENT(9) = ['11', '22', '33', '12', '23', '31', '21', '32', '13']
  integer, parameter :: VOIGT(9) = [1, 2, 3, 4, 5, 6, 4, 5, 6]
  integer, parameter :: LONGEST = 60 !! of a name, which becomes part of a file's

contains

  !> CURVe,name and its records.
  subroutine read_curve(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(curve_entry_t) :: curve
    type(curve_entry_t), allocatable :: longer(:)
    type(column_t), allocatable :: columns(:)
    type(column_t) :: column
    type(record_t) :: line
    logical :: more
    integer :: n

    call check_count(record, 2, 2, 'CURVe,name', error)
    if (.not. allocated(error)) call check_name(build, record, error)
    if (allocated(error)) return
    curve%name = record%text(2)
    curve%place = record%place(2)
    allocate (curve%column(0))
    n = 0
    do
      call next_line(build, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call read_column(deck, line, column, error)
      if (allocated(error)) return
      if (n == size(curve%column)) then
        allocate (columns(2*n + 8))
        columns(:n) = curve%column
        call move_alloc(columns, curve%column)
      end if
      n = n + 1
      curve%column(n) = column
    end do
    curve%column = curve%column(:n)
    if (n == 0) then
      call fail(error, DECK_ERROR, 'curve '//quoted(curve%name)//' has no records', curve%place, &
                'records are '//word_list())
      return
    end if
    if (build%ncurve == size(build%curve)) then
      allocate (longer(2*build%ncurve + 8))
      longer(:build%ncurve) = build%curve
      call move_alloc(longer, build%curve)
    end if
    build%ncurve = build%ncurve + 1
    build%curve(build%ncurve) = curve
  end subroutine read_curve

  !> A name makes a file's name: letters, digits, - and _.
  subroutine check_name(build, record, error)
    type(build_t), intent(in) :: build
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name
    integer :: i

    name = lower(record%text(2))
    if (.not. fits_name(name, LONGEST)) then
      call fail(error, DECK_ERROR, 'a curve cannot be named '//quoted(record%text(2)), &
                record%place(2), 'its file is named after it: use up to '//to_text(LONGEST) &
                //' letters, digits, _ and -')
      return
    else if (name == 'tplot') then
      call fail(error, DECK_ERROR, 'a curve cannot be named '//quoted(record%text(2)), &
                record%place(2), &
                'TPLOt writes the file of that name')
      return
    end if
    do i = 1, build%ncurve
      if (lower(build%curve(i)%name) == name) then
        call fail(error, DECK_ERROR, 'curve '//quoted(record%text(2))//' is defined twice', &
                  record%place(2), &
                  'the first one stands in line '//to_text(build%curve(i)%place%line) &
                  //'; one CURVe holds many records')
        return
      end if
    end do
  end subroutine check_name

  function word_list() result(list)
    character(:), allocatable :: list
    integer :: i

    list = ''
    do i = 1, size(WORD)
      list = list//' '//trim(WORD(i))
    end do
    list = list(2:)
  end function word_list

  !> One record.
  subroutine read_column(deck, line, column, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(column_t), intent(out) :: column
    type(error_t), allocatable, intent(out) :: error

    column%quantity%place = line%place(1)
    select case (line%key(1))
    case ('forc')
      call read_component(deck, line, 'FORCe WHERE direction', 'force_', column, error)
      column%quantity%id = Q_FORCE
    case ('disp')
      call read_component(deck, line, 'DISP WHERE direction', 'disp_', column, error)
      column%quantity%id = Q_DISP
    case ('torq')
      call read_torque(deck, line, column, error)
    case ('stre')
      call read_stress(deck, line, column, error)
    case ('ener')
      call check_count(line, 1, 2, 'ENERgy [patch]', error)
      if (allocated(error)) return
      column%quantity%id = Q_ENERGY
      column%quantity%column = 'energy'
      call read_body(line, 2, column)
    case ('maxi')
      call read_maximum(line, column, error)
    case ('cont')
      call read_contact_column(deck, line, column, error)
    case ('book')
      call read_book(line, column%quantity, error)
    case default
      call fail(error, DECK_ERROR, 'unknown quantity '//quoted(line%text(1))//' of a CURVe', &
                line%place(1), &
                'nearest known: '//nearest(line%text(1), WORD))
    end select
  end subroutine read_column

  !> FORCe or DISP: WHERE and a direction.
  subroutine read_component(deck, line, usage, name, column, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    character(*), intent(in) :: usage, name
    type(column_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    i = 2
    call read_where(deck, line, i, column%at, error)
    if (.not. allocated(error)) call read_direction(deck, line, i, usage, column%quantity, error)
    if (allocated(error)) return
    column%quantity%column = name//to_text(column%quantity%component)
  end subroutine read_component

  !> TORQue WHERE px py pz  ax ay az.
  subroutine read_torque(deck, line, column, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(column_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    i = 2
    call read_where(deck, line, i, column%at, error)
    if (.not. allocated(error)) call read_axis(deck, line, i, 'TORQue WHERE px py pz  ax ay az', &
                                               column%quantity, error)
    if (allocated(error)) return
    column%quantity%id = Q_TORQUE
    column%quantity%column = 'torque'
  end subroutine read_torque

  !> STREss patch x y z component; the patch ALL is any, and FEAP's elements.
  subroutine read_stress(deck, line, column, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(column_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(line, 6, 6, 'STREss patch x y z component, such as 33', error)
    do d = 1, 3
      if (allocated(error)) return
      call get_real(deck, line, d + 2, column%quantity%point(d), error)
    end do
    if (allocated(error)) return
    do d = size(COMPONENT), 1, -1
      if (line%text(6) == COMPONENT(d)) exit
    end do
    if (d == 0) then
      call fail(error, DECK_ERROR, 'unknown component '//quoted(line%text(6))//' of the stress', &
                line%place(6), &
                'components are 11 22 33 12 23 31')
      return
    end if
    column%quantity%id = Q_STRESS
    column%quantity%component = VOIGT(d)
    column%quantity%column = 'stress_'//COMPONENT(d)
    if (key_of(line%text(2)) /= 'all') call read_body(line, 2, column)
  end subroutine read_stress

  !> MAXImum displacement|mises [patch].
  subroutine read_maximum(line, column, error)
    type(record_t), intent(in) :: line
    type(column_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, 2, 3, 'MAXImum displacement|mises [patch]', error)
    if (allocated(error)) return
    select case (line%key(2))
    case ('disp')
      column%quantity%id = Q_MAX_DISP
      column%quantity%column = 'max_displacement'
    case ('mise')
      column%quantity%id = Q_MAX_MISES
      column%quantity%column = 'max_mises'
    case default
      call fail(error, DECK_ERROR, 'unknown maximum '//quoted(line%text(2)), line%place(2), &
                'MAXImum displacement|mises [patch]')
      return
    end select
    call read_body(line, 3, column)
  end subroutine read_maximum

  !> The name of a patch in field i, if there is one.
  subroutine read_body(line, i, column)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    type(column_t), intent(inout) :: column

    if (line%is_empty(i)) return
    column%body = line%text(i)
    column%body_place = line%place(i)
  end subroutine read_body

  !> BOOK quantity.
  subroutine read_book(line, quantity, error)
    type(record_t), intent(in) :: line
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = &
                               'BOOK WORK|STORed|KINEtic|NORMal|FRICtion|COHEsive|INERtia|' &
                               //'IMBAlance|BONDs|DAMAge|VISCous'
    integer :: i

    call check_count(line, 2, 2, USAGE, error)
    if (allocated(error)) return
    do i = 1, size(word_book)
      if (key_of(word_book(i)) == line%key(2)) exit
    end do
    if (i > size(word_book)) then
      call fail(error, DECK_ERROR, 'unknown energy '//quoted(line%text(2)), line%place(2), &
                'nearest known: '//nearest(line%text(2), word_book)//'; '//USAGE)
      return
    end if
    quantity%id = Q_BOOK
    quantity%component = i
    quantity%column = 'book_'//trim(lower(word_book(i)))
  end subroutine read_book

  !> CONTact name side and a quantity; column contact_<name>_<side>_force_3.
  subroutine read_contact_column(deck, line, column, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(column_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: w

    call check_count(line, 4, 10, USAGE//'FORCe direction, for instance', error)
    if (.not. allocated(error)) call get_integer(deck, line, 3, column%quantity%side, error)
    if (allocated(error)) return
    column%contact = line%text(2)
    column%contact_place = line%place(2)
    associate (q => column%quantity)
      if (q%side < 1 .or. q%side > 2) then
        call fail(error, DECK_ERROR, 'side '//to_text(q%side)//' of a contact', line%place(3), &
                  'sides are 1 and 2, in the order of its SURFaces')
        return
      end if
      do w = size(word_contact), 1, -1
        if (key_of(word_contact(w)) == line%key(4)) exit
      end do
      if (w == 0) then
        call fail(error, DECK_ERROR, 'unknown quantity '//quoted(line%text(4))//' of a contact', &
                  line%place(4), 'nearest known: '//nearest(line%text(4), word_contact))
        return
      end if
      q%id = KIND(w)
      q%column = 'contact_'//lower(column%contact)//'_'//to_text(q%side)//'_'//lower(trim(word_contact(w)))
      call read_rest(deck, line, q, trim(word_contact(w)), error)
      if (q%component > 0) q%column = q%column//'_'//to_text(q%component)
    end associate
  end subroutine read_contact_column

  !> What follows the quantity's word_contact.
  subroutine read_rest(deck, line, quantity, name, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(quantity_t), intent(inout) :: quantity
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error

    select case (quantity%id)
    case (Q_CONTACT_FORCE)
      call read_direction(deck, line, 5, USAGE//name//' direction', quantity, error)
    case (Q_CONTACT_TORQUE)
      call read_axis(deck, line, 5, USAGE//name//' px py pz  ax ay az', quantity, error)
    case (Q_CONTACT_PRESSURE, Q_CONTACT_TANGENTIAL)
      if (line%n > 4) call read_direction(deck, line, 5, USAGE//name//' [direction]', quantity, &
                                          error)
    case default
      call check_count(line, 4, 4, USAGE//name, error)
    end select
  end subroutine read_rest

  !> A direction in the last field, i.
  subroutine read_direction(deck, line, i, usage, quantity, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: usage
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, i, i, usage, error)
    if (.not. allocated(error)) call get_integer(deck, line, i, quantity%component, error)
    if (allocated(error)) return
    if (quantity%component >= 1 .and. quantity%component <= 3) return
    call fail(error, DECK_ERROR, 'direction '//to_text(quantity%component), line%place(i), &
              'directions are 1, 2 and 3')
  end subroutine read_direction

  !> px py pz  ax ay az in the last fields, from i on.
  subroutine read_axis(deck, line, i, usage, quantity, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: usage
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6), length
    integer :: d

    call check_count(line, i + 5, i + 5, usage, error)
    do d = 1, 6
      if (allocated(error)) return
      call get_real(deck, line, i + d - 1, x(d), error)
    end do
    if (allocated(error)) return
    length = norm2(x(4:))
    if (.not. length > 0.0_wp) then
      call fail(error, DECK_ERROR, 'the axis of the torque has no length', line%place(i + 3), usage)
      return
    end if
    quantity%point = x(:3)
    quantity%axis = x(4:)/length
  end subroutine read_axis

end module word_curve
