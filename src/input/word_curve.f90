!> CURVe: a table of quantities with one column for each record.
module word_curve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower, key_of, fits_name
  use curve_type, only: Q_FORCE, Q_TORQUE, Q_DISP, Q_STRESS, Q_ENERGY, Q_MAX_DISP, Q_MAX_MISES, &
                        Q_BOOK, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                        Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
                        Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED, B_WORK, B_STORED, B_KINETIC, &
                        B_NORMAL, B_FRICTION, B_COHESIVE, B_INERTIA, B_IMBALANCE, B_BONDS, &
                        B_DAMAGE, B_VISCOUS, B_CREATED, B_ERROR
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use input_draft, only: draft_t, curve_entry_t, column_entry_t, next_line
  use input_fields, only: get_numbers, get_direction, get_axis
  use input_record, only: record_word_t, word_index, word_list
  use input_where, only: read_where
  implicit none
  private
  public :: read_curve

  type(record_word_t), parameter, public :: CURVE_RECORDS(8) = [ &
                                            record_word_t('FORCe', .true.), &
                                            record_word_t('TORQue', .true.), &
                                            record_word_t('DISP', .true.), &
                                            record_word_t('CONTact', .true.), &
                                            record_word_t('STREss', .true.), &
                                            record_word_t('ENERgy', .true.), &
                                            record_word_t('MAXImum', .true.), &
                                            record_word_t('BOOK', .true.)]

  !> A quantity of BOOK or CONTact. The name of its column contains its word in lower case.
  type :: quantity_word_t
    character(12) :: word
    integer :: id          !! B_... of BOOK, Q_CONTACT_... of CONTact
  end type quantity_word_t

  !> Terms of the energy balance.
  type(quantity_word_t), parameter :: ENERGIES(13) = [ &
                                      quantity_word_t('WORK', B_WORK), &
                                      quantity_word_t('STORed', B_STORED), &
                                      quantity_word_t('KINEtic', B_KINETIC), &
                                      quantity_word_t('NORMal', B_NORMAL), &
                                      quantity_word_t('FRICtion', B_FRICTION), &
                                      quantity_word_t('COHEsive', B_COHESIVE), &
                                      quantity_word_t('INERtia', B_INERTIA), &
                                      quantity_word_t('IMBAlance', B_IMBALANCE), &
                                      quantity_word_t('BONDs', B_BONDS), &
                                      quantity_word_t('DAMAge', B_DAMAGE), &
                                      quantity_word_t('VISCous', B_VISCOUS), &
                                      quantity_word_t('CREAted', B_CREATED), &
                                      quantity_word_t('ERROr', B_ERROR)]

  type(quantity_word_t), parameter :: OF_CONTACT(9) = [ &
                                      quantity_word_t('FORCe', Q_CONTACT_FORCE), &
                                      quantity_word_t('TORQue', Q_CONTACT_TORQUE), &
                                      quantity_word_t('PRESsure', Q_CONTACT_PRESSURE), &
                                      quantity_word_t('TANGential', Q_CONTACT_TANGENTIAL), &
                                      quantity_word_t('STICk', Q_CONTACT_STICK), &
                                      quantity_word_t('SLIP', Q_CONTACT_SLIP), &
                                      quantity_word_t('AREA', Q_CONTACT_AREA), &
                                      quantity_word_t('PENEtration', Q_CONTACT_PENETRATION), &
                                      quantity_word_t('DEBOnded', Q_CONTACT_DEBONDED)]

  !> Components of a stress as they are written in the deck, and their positions in Voigt notation.
  character(2), parameter :: COMPONENT(9) = ['11', '22', '33', '12', '23', '31', '21', '32', '13']
  integer, parameter :: VOIGT(9) = [1, 2, 3, 4, 5, 6, 4, 5, 6]
  integer, parameter :: LONGEST = 60 !! longest name; it becomes part of a file name

contains

  !> Read CURVe,name and its records.
  subroutine read_curve(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(curve_entry_t) :: curve
    type(column_entry_t) :: column
    type(record_t) :: line
    logical :: more
    integer :: i

    call check_count(record, 2, 2, 'CURVe,name', error)
    if (allocated(error)) return
    curve%name = record%text(2)
    curve%place = record%place(2)
    if (.not. fits_name(curve%name, LONGEST)) then
      call fail(error, DECK_ERROR, 'a curve cannot be named '//quoted(curve%name), curve%place, &
                'the file of a curve has its name: use up to '//to_text(LONGEST) &
                //' letters, digits, _ and -')
      return
    else if (lower(curve%name) == 'tplot') then
      call fail(error, DECK_ERROR, 'a curve cannot be named '//quoted(curve%name), curve%place, &
                'choose another name: TPLOt writes a file of this name')
      return
    end if
    do i = 1, draft%ncurve
      if (lower(draft%curve(i)%name) /= lower(curve%name)) cycle
      call fail(error, DECK_ERROR, 'duplicate curve '//quoted(curve%name), curve%place, &
                'the first one is in line '//to_text(draft%curve(i)%place%line) &
                //'; one CURVe may have many records')
      return
    end do
    allocate (curve%column(0))
    do
      call next_line(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call read_column(deck, line, column, error)
      if (allocated(error)) return
      curve%column = [curve%column, column]
    end do
    if (size(curve%column) == 0) then
      call fail(error, DECK_ERROR, 'curve '//quoted(curve%name)//' has no records', curve%place, &
                'records are '//word_list(CURVE_RECORDS%name, ' '))
      return
    end if
    draft%curve = [draft%curve, curve]
    draft%ncurve = size(draft%curve)
  end subroutine read_curve

  !> Read one record.
  subroutine read_column(deck, line, column, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: line
    type(column_entry_t), intent(out) :: column
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: TORQUE = 'TORQue WHERE px py pz  ax ay az', &
                               MAXIMUM = 'MAXImum displacement|mises [patch]'
    character(:), allocatable :: usage
    integer :: i

    associate (q => column%quantity)
      q%place = line%place(1)
      i = 2
      select case (line%key(1))
      case ('forc')
        call read_component('force_', Q_FORCE)
      case ('disp')
        call read_component('disp_', Q_DISP)
      case ('torq')
        q%id = Q_TORQUE
        q%column = 'torque'
        call read_where(deck, line, i, column%at, error)
        if (.not. allocated(error)) call check_count(line, i + 5, i + 5, TORQUE, error)
        if (.not. allocated(error)) call get_axis(deck, line, i, TORQUE, q%point, q%axis, error)
      case ('stre')
        call read_stress(deck, line, column, error)
      case ('ener')
        q%id = Q_ENERGY
        q%column = 'energy'
        call check_count(line, 1, 2, 'ENERgy [patch]', error)
        if (.not. allocated(error)) call read_body(line, 2, column)
      case ('maxi')
        call check_count(line, 2, 3, MAXIMUM, error)
        if (allocated(error)) return
        select case (line%key(2))
        case ('disp')
          q%id = Q_MAX_DISP
          q%column = 'max_displacement'
        case ('mise')
          q%id = Q_MAX_MISES
          q%column = 'max_mises'
        case default
          call fail(error, DECK_ERROR, 'unknown maximum '//quoted(line%text(2)), line%place(2), &
                    MAXIMUM)
          return
        end select
        call read_body(line, 3, column)
      case ('cont')
        call read_contact_quantity(deck, line, column, error)
      case ('book')
        usage = 'BOOK '//word_list(ENERGIES%word, '|')
        call check_count(line, 2, 2, usage, error)
        if (allocated(error)) return
        i = word_index(ENERGIES%word, line%key(2))
        if (i == 0) then
          call fail(error, DECK_ERROR, 'unknown energy '//quoted(line%text(2)), line%place(2), &
                    'nearest known: '//nearest(line%text(2), ENERGIES%word)//'; usage: '//usage)
          return
        end if
        q%id = Q_BOOK
        q%component = ENERGIES(i)%id
        q%column = 'book_'//lower(trim(ENERGIES(i)%word))
      case default
        call fail(error, DECK_ERROR, 'unknown quantity '//quoted(line%text(1))//' of a CURVe', &
                  line%place(1), 'nearest known: '//nearest(line%text(1), CURVE_RECORDS%name))
      end select
    end associate

  contains

    !> Read FORCe or DISP: WHERE and a direction.
    subroutine read_component(name, id)
      character(*), intent(in) :: name
      integer, intent(in) :: id

      column%quantity%id = id
      call read_where(deck, line, i, column%at, error)
      if (.not. allocated(error)) call check_count(line, i, i, line%text(1)//' WHERE direction', &
                                                   error)
      if (.not. allocated(error)) call get_direction(deck, line, i, column%quantity%component, &
                                                     error)
      if (.not. allocated(error)) column%quantity%column = name//to_text(column%quantity%component)
    end subroutine read_component
  end subroutine read_column

  !> Read STREss patch x y z component. The patch ALL means all elements that deform, including
  !! those of ELEMents and BLOCk.
  subroutine read_stress(deck, line, column, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(column_entry_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    call check_count(line, 6, 6, 'STREss patch x y z component, such as 33', error)
    if (.not. allocated(error)) call get_numbers(deck, line, 3, column%quantity%point, error)
    if (allocated(error)) return
    d = findloc(COMPONENT == line%text(6), .true., 1)
    if (d == 0) then
      call fail(error, DECK_ERROR, 'unknown stress component '//quoted(line%text(6)), &
                line%place(6), 'components are '//word_list(COMPONENT(:6), ' '))
      return
    end if
    column%quantity%id = Q_STRESS
    column%quantity%component = VOIGT(d)
    column%quantity%column = 'stress_'//COMPONENT(d)
    if (key_of(line%text(2)) /= 'all') call read_body(line, 2, column)
  end subroutine read_stress

  !> Read the name of a patch from field i if there is one.
  subroutine read_body(line, i, column)
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    type(column_entry_t), intent(inout) :: column

    if (line%is_empty(i)) return
    column%body = line%text(i)
    column%body_place = line%place(i)
  end subroutine read_body

  !> Read CONTact name side and a quantity; its column is, for instance,
  !! contact_<name>_<side>_force_3.
  subroutine read_contact_quantity(deck, line, column, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(column_entry_t), intent(inout) :: column
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage
    integer :: w

    usage = 'CONTact name side '
    call check_count(line, 4, 10, "write, for instance, '"//usage//"FORCe direction'", error)
    if (.not. allocated(error)) call get_integer(deck, line, 3, column%quantity%side, error)
    if (allocated(error)) return
    column%contact = line%text(2)
    column%contact_place = line%place(2)
    associate (q => column%quantity)
      if (q%side < 1 .or. q%side > 2) then
        call fail(error, DECK_ERROR, 'unknown side '//to_text(q%side)//' of a contact', &
                  line%place(3), 'sides are 1 and 2, in the order of SURFaces')
        return
      end if
      w = word_index(OF_CONTACT%word, line%key(4))
      if (w == 0) then
        call fail(error, DECK_ERROR, 'unknown quantity '//quoted(line%text(4))//' of a contact', &
                  line%place(4), 'nearest known: '//nearest(line%text(4), OF_CONTACT%word))
        return
      end if
      q%id = OF_CONTACT(w)%id
      q%column = 'contact_'//lower(column%contact)//'_'//to_text(q%side)//'_' &
                 //lower(trim(OF_CONTACT(w)%word))
      usage = usage//trim(OF_CONTACT(w)%word)
      select case (q%id)
      case (Q_CONTACT_FORCE, Q_CONTACT_PRESSURE, Q_CONTACT_TANGENTIAL)
        if (line%n == 4 .and. q%id /= Q_CONTACT_FORCE) return ! the magnitude
        if (q%id == Q_CONTACT_FORCE) usage = usage//' direction'
        if (q%id /= Q_CONTACT_FORCE) usage = usage//' [direction]'
        call check_count(line, 5, 5, usage, error)
        if (.not. allocated(error)) call get_direction(deck, line, 5, q%component, error)
        if (.not. allocated(error)) q%column = q%column//'_'//to_text(q%component)
      case (Q_CONTACT_TORQUE)
        usage = usage//' px py pz  ax ay az'
        call check_count(line, 10, 10, usage, error)
        if (.not. allocated(error)) call get_axis(deck, line, 5, usage, q%point, q%axis, error)
      case default
        call check_count(line, 4, 4, usage, error)
      end select
    end associate
  end subroutine read_contact_quantity

end module word_curve
