!> Named values, which the commands store in a checkpoint in addition to the state.
module named_values
  use base_kinds, only: wp
  implicit none
  private
  public :: named_values_t, put, get

  integer, parameter, public :: REAL_VALUE = 1, INTEGER_VALUE = 2, TEXT_VALUE = 3

  !> A value and its name. The type tells which component is in use.
  type :: value_t
    character(:), allocatable :: name
    integer :: type = 0 !! REAL_VALUE, INTEGER_VALUE, TEXT_VALUE
    real(wp), allocatable :: reals(:)
    integer, allocatable :: integers(:)
    character(:), allocatable :: text
  end type value_t

  type :: named_values_t
    integer :: n = 0
    type(value_t), allocatable :: value(:)
  end type named_values_t

  !> put(values, name, value) stores a number, a list of numbers, a logical or text under a name. It
  !! replaces an earlier value with that name.
  interface put
    module procedure put_real, put_reals, put_integer, put_integers, put_logical, put_text
  end interface put

  !> get(values, name, value, found): if there is no value of that name and type, `value` is
  !! unchanged.
  interface get
    module procedure get_real, get_reals, get_integer, get_integers, get_logical, get_text
  end interface get

contains

  subroutine put_reals(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    real(wp), intent(in) :: value(:)
    integer :: k

    call claim(values, name, REAL_VALUE, k)
    values%value(k)%reals = value
  end subroutine put_reals

  subroutine put_real(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    real(wp), intent(in) :: value

    call put_reals(values, name, [value])
  end subroutine put_real

  subroutine put_integers(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    integer, intent(in) :: value(:)
    integer :: k

    call claim(values, name, INTEGER_VALUE, k)
    values%value(k)%integers = value
  end subroutine put_integers

  subroutine put_integer(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    integer, intent(in) :: value

    call put_integers(values, name, [value])
  end subroutine put_integer

  subroutine put_logical(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    logical, intent(in) :: value

    call put_integers(values, name, [merge(1, 0, value)])
  end subroutine put_logical

  subroutine put_text(values, name, value)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name, value
    integer :: k

    call claim(values, name, TEXT_VALUE, k)
    values%value(k)%text = value
  end subroutine put_text

  subroutine get_reals(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    real(wp), allocatable, intent(inout) :: value(:)
    logical, intent(out) :: found
    integer :: k

    k = position(values, name, REAL_VALUE)
    found = k > 0
    if (found) value = values%value(k)%reals
  end subroutine get_reals

  subroutine get_real(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    real(wp), intent(inout) :: value
    logical, intent(out) :: found
    real(wp), allocatable :: list(:)

    call get_reals(values, name, list, found)
    if (found) found = size(list) == 1
    if (found) value = list(1)
  end subroutine get_real

  subroutine get_integers(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    integer, allocatable, intent(inout) :: value(:)
    logical, intent(out) :: found
    integer :: k

    k = position(values, name, INTEGER_VALUE)
    found = k > 0
    if (found) value = values%value(k)%integers
  end subroutine get_integers

  subroutine get_integer(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    integer, intent(inout) :: value
    logical, intent(out) :: found
    integer, allocatable :: list(:)

    call get_integers(values, name, list, found)
    if (found) found = size(list) == 1
    if (found) value = list(1)
  end subroutine get_integer

  subroutine get_logical(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    logical, intent(inout) :: value
    logical, intent(out) :: found
    integer :: number

    call get_integer(values, name, number, found)
    if (found) value = number /= 0
  end subroutine get_logical

  subroutine get_text(values, name, value, found)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: value
    logical, intent(out) :: found
    integer :: k

    k = position(values, name, TEXT_VALUE)
    found = k > 0
    if (found) value = values%value(k)%text
  end subroutine get_text

  !> Position of the value with that name and type; 0: there is none.
  pure integer function position(values, name, type) result(k)
    type(named_values_t), intent(in) :: values
    character(*), intent(in) :: name
    integer, intent(in) :: type

    do k = values%n, 1, -1
      if (values%value(k)%name == name .and. values%value(k)%type == type) return
    end do
  end function position

  !> Find the position of the value with that name, which is added if it does not exist yet.
  subroutine claim(values, name, type, k)
    type(named_values_t), intent(inout) :: values
    character(*), intent(in) :: name
    integer, intent(in) :: type
    integer, intent(out) :: k
    type(value_t), allocatable :: longer(:)

    if (.not. allocated(values%value)) allocate (values%value(16))
    do k = 1, values%n
      if (values%value(k)%name == name) exit
    end do
    if (k > size(values%value)) then
      allocate (longer(2*size(values%value)))
      longer(:values%n) = values%value
      call move_alloc(longer, values%value)
    end if
    values%n = max(values%n, k)
    values%value(k)%name = name
    values%value(k)%type = type
  end subroutine claim

end module named_values
