!> CONTact records of a CURVe: quantities of one side of a contact.
module setup_curve_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted, nearest, lower, key_of
  use curve_type, only: quantity_t, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                        Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
                        Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use setup_build, only: column_t
  use setup_curve_field, only: read_direction, read_axis
  implicit none
  private
  public :: read_contact_column

  character(*), parameter :: USAGE = 'CONTact name side '
  character(11), parameter :: WORD(9) = ['FORCe      ', 'TORQue     ', 'PRESsure   ', &
                                         'TANGential ', 'STICk      ', 'SLIP       ', &
                                         'AREA       ', 'PENEtration', 'DEBOnded   ']
  integer, parameter :: KIND(9) = [Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                                   Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, &
                                   Q_CONTACT_AREA, Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED]

contains

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
      do w = size(WORD), 1, -1
        if (key_of(WORD(w)) == line%key(4)) exit
      end do
      if (w == 0) then
        call fail(error, DECK_ERROR, 'unknown quantity '//quoted(line%text(4))//' of a contact', &
                  line%place(4), 'nearest known: '//nearest(line%text(4), WORD))
        return
      end if
      q%kind = KIND(w)
      q%column = 'contact_'//lower(column%contact)//'_'//to_text(q%side)//'_'//lower(trim(WORD(w)))
      call read_rest(deck, line, q, trim(WORD(w)), error)
      if (q%component > 0) q%column = q%column//'_'//to_text(q%component)
    end associate
  end subroutine read_contact_column

  !> What follows the quantity's word.
  subroutine read_rest(deck, line, quantity, name, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    type(quantity_t), intent(inout) :: quantity
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error

    select case (quantity%kind)
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

end module setup_curve_contact
