!> CURVe: tables of quantities, one column a record.
module setup_curve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower, key_of, fits_name
  use curve_type, only: Q_FORCE, Q_TORQUE, Q_DISP, Q_STRESS, Q_ENERGY, Q_MAX_DISP, Q_MAX_MISES
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_real
  use setup_build, only: build_t, curve_entry_t, column_t, next_line
  use setup_curve_book, only: read_book
  use setup_curve_contact, only: read_contact_column
  use setup_curve_field, only: read_direction, read_axis
  use setup_where, only: read_where
  implicit none
  private
  public :: read_curve

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
      column%quantity%kind = Q_FORCE
    case ('disp')
      call read_component(deck, line, 'DISP WHERE direction', 'disp_', column, error)
      column%quantity%kind = Q_DISP
    case ('torq')
      call read_torque(deck, line, column, error)
    case ('stre')
      call read_stress(deck, line, column, error)
    case ('ener')
      call check_count(line, 1, 2, 'ENERgy [patch]', error)
      if (allocated(error)) return
      column%quantity%kind = Q_ENERGY
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
    column%quantity%kind = Q_TORQUE
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
    column%quantity%kind = Q_STRESS
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
      column%quantity%kind = Q_MAX_DISP
      column%quantity%column = 'max_displacement'
    case ('mise')
      column%quantity%kind = Q_MAX_MISES
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

end module setup_curve
