!> A bag of named values: what the commands want to find again after a restart.
module named_values
  use base_kinds, only: wp
  implicit none
  private
  public :: named_values_t, put, get, item_t

  integer, parameter, public :: ITEM_REAL = 1, ITEM_INTEGER = 2, ITEM_TEXT = 3

  type :: item_t
    character(:), allocatable :: name
    integer :: kind = 0
    real(wp), allocatable :: reals(:)
    integer, allocatable :: integers(:)
    character(:), allocatable :: text
  end type item_t

  type :: named_values_t
    integer :: n = 0
    type(item_t), allocatable :: item(:)
  end type named_values_t

  !> put(bag, name, value): a number, a list of numbers or text; an old value goes.
  interface put
    module procedure put_real, put_reals, put_integer, put_integers, put_logical, put_text
  end interface put

  !> get(bag, name, value, found): the value stays as it is where there is none of that kind.
  interface get
    module procedure get_real, get_reals, get_integer, get_integers, get_logical, get_text
  end interface get

contains

  !> Number of the item of that name and kind; 0: none.
  pure function find(bag, name, kind) result(k)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    integer, intent(in) :: kind
    integer :: k

    do k = bag%n, 1, -1
      if (bag%item(k)%name == name .and. bag%item(k)%kind == kind) return
    end do
  end function find

  !> Item of that name, made where it is new.
  subroutine claim(bag, name, kind, k)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    integer, intent(in) :: kind
    integer, intent(out) :: k
    type(item_t), allocatable :: longer(:)

    if (.not. allocated(bag%item)) allocate (bag%item(16))
    do k = 1, bag%n
      if (bag%item(k)%name == name) exit
    end do
    if (k > size(bag%item)) then
      allocate (longer(2*size(bag%item)))
      longer(:bag%n) = bag%item
      call move_alloc(longer, bag%item)
    end if
    bag%n = max(bag%n, k)
    bag%item(k)%name = name
    bag%item(k)%kind = kind
  end subroutine claim

  subroutine put_reals(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    real(wp), intent(in) :: value(:)
    integer :: k

    call claim(bag, name, ITEM_REAL, k)
    bag%item(k)%reals = value
  end subroutine put_reals

  subroutine put_real(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    real(wp), intent(in) :: value

    call put_reals(bag, name, [value])
  end subroutine put_real

  subroutine put_integers(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    integer, intent(in) :: value(:)
    integer :: k

    call claim(bag, name, ITEM_INTEGER, k)
    bag%item(k)%integers = value
  end subroutine put_integers

  subroutine put_integer(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    integer, intent(in) :: value

    call put_integers(bag, name, [value])
  end subroutine put_integer

  subroutine put_logical(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name
    logical, intent(in) :: value

    call put_integers(bag, name, [merge(1, 0, value)])
  end subroutine put_logical

  subroutine put_text(bag, name, value)
    type(named_values_t), intent(inout) :: bag
    character(*), intent(in) :: name, value
    integer :: k

    call claim(bag, name, ITEM_TEXT, k)
    bag%item(k)%text = value
  end subroutine put_text

  subroutine get_reals(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    real(wp), allocatable, intent(inout) :: value(:)
    logical, intent(out) :: found
    integer :: k

    k = find(bag, name, ITEM_REAL)
    found = k > 0
    if (found) value = bag%item(k)%reals
  end subroutine get_reals

  subroutine get_real(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    real(wp), intent(inout) :: value
    logical, intent(out) :: found
    integer :: k

    k = find(bag, name, ITEM_REAL)
    found = k > 0
    if (found) found = size(bag%item(k)%reals) == 1
    if (found) value = bag%item(k)%reals(1)
  end subroutine get_real

  subroutine get_integers(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    integer, allocatable, intent(inout) :: value(:)
    logical, intent(out) :: found
    integer :: k

    k = find(bag, name, ITEM_INTEGER)
    found = k > 0
    if (found) value = bag%item(k)%integers
  end subroutine get_integers

  subroutine get_integer(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    integer, intent(inout) :: value
    logical, intent(out) :: found
    integer :: k

    k = find(bag, name, ITEM_INTEGER)
    found = k > 0
    if (found) found = size(bag%item(k)%integers) == 1
    if (found) value = bag%item(k)%integers(1)
  end subroutine get_integer

  subroutine get_logical(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    logical, intent(inout) :: value
    logical, intent(out) :: found
    integer :: number

    call get_integer(bag, name, number, found)
    if (found) value = number /= 0
  end subroutine get_logical

  subroutine get_text(bag, name, value, found)
    type(named_values_t), intent(in) :: bag
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: value
    logical, intent(out) :: found
    integer :: k

    k = find(bag, name, ITEM_TEXT)
    found = k > 0
    if (found) value = bag%item(k)%text
  end subroutine get_text

end module named_values
