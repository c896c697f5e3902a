!> The parameters of a deck: names and values.
module deck_params
  use base_kinds, only: wp
  use base_text, only: lower
  use deck_function, only: PI
  implicit none
  private
  public :: params_t, set_parameter, find_parameter, parameter_names, is_name, &
            note_spelling

  type :: name_t
    character(:), allocatable :: text !! lower case
    character(:), allocatable :: spelling !! as in the deck's last assignment
    integer :: line = 0               !! line of the deck's last assignment to it
  end type name_t

  type :: params_t
    private
    integer :: n = 0
    type(name_t), allocatable :: name(:)
    real(wp), allocatable :: value(:)
    integer, allocatable :: order(:) !! positions in alphabetical order of the names
  end type params_t

contains

  !> Set or change a parameter.
  subroutine set_parameter(params, name, value)
    type(params_t), intent(inout) :: params
    character(*), intent(in) :: name
    real(wp), intent(in) :: value
    type(name_t), allocatable :: longer(:)
    integer :: at, i
    logical :: known

    if (.not. allocated(params%name)) allocate (params%name(16), params%value(0), params%order(0))
    call locate(params, lower(trim(name)), at, known)
    if (known) then
      params%value(params%order(at)) = value
      return
    end if
    if (params%n == size(params%name)) then
      allocate (longer(2*params%n))
      do i = 1, params%n
        call move_alloc(params%name(i)%text, longer(i)%text)
        if (.not. allocated(params%name(i)%spelling)) cycle
        call move_alloc(params%name(i)%spelling, longer(i)%spelling)
        longer(i)%line = params%name(i)%line
      end do
      call move_alloc(longer, params%name)
    end if
    params%n = params%n + 1
    params%name(params%n)%text = lower(trim(name))
    params%value = [params%value, value]
    params%order = [params%order(:at - 1), params%n, params%order(at:)]
  end subroutine set_parameter

  !> Record how the deck spells the name of a parameter that it sets, and in which line. The
  !! spelling of the previous assignment and its line are returned; `earlier` is not allocated if
  !! there is none.
  subroutine note_spelling(params, spelling, line, earlier, earlier_line)
    type(params_t), intent(inout) :: params
    character(*), intent(in) :: spelling
    integer, intent(in) :: line
    character(:), allocatable, intent(out) :: earlier
    integer, intent(out) :: earlier_line
    integer :: at
    logical :: known

    earlier_line = 0
    call locate(params, lower(spelling), at, known)
    if (.not. known) return
    associate (name => params%name(params%order(at)))
      if (allocated(name%spelling)) earlier = name%spelling
      earlier_line = name%line
      name%spelling = spelling
      name%line = line
    end associate
  end subroutine note_spelling

  !> Find the value of a parameter; `pi` has its usual value unless the deck sets it.
  pure subroutine find_parameter(params, name, value, known)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: name !! lower case
    real(wp), intent(out) :: value
    logical, intent(out) :: known
    integer :: at

    value = 0.0_wp
    call locate(params, name, at, known)
    if (known) then
      value = params%value(params%order(at))
    else if (name == 'pi') then
      value = PI
      known = .true.
    end if
  end subroutine find_parameter

  !> Length of the longest name of a parameter, at least 64.
  pure integer function longest_name(params) result(length)
    type(params_t), intent(in) :: params
    integer :: i

    length = 64
    do i = 1, params%n
      length = max(length, len(params%name(i)%text))
    end do
  end function longest_name

  !> Names of all parameters, in the order in which they were set.
  pure function parameter_names(params) result(list)
    type(params_t), intent(in) :: params
    character(longest_name(params)) :: list(params%n)
    integer :: i

    do i = 1, params%n
      list(i) = params%name(i)%text
    end do
  end function parameter_names

  !> Is the text a name: a letter, followed by letters, digits or underscores?
  pure function is_name(text) result(yes)
    character(*), intent(in) :: text
    logical :: yes
    character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyz', MORE = LETTERS//'0123456789_'

    yes = .false.
    if (len(text) == 0) return
    yes = index(LETTERS, lower(text(1:1))) > 0 .and. verify(lower(text), MORE) == 0
  end function is_name

  !> Find the position of a name in `order`, or the position at which it would be inserted.
  pure subroutine locate(params, name, at, known)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: name
    integer, intent(out) :: at
    logical, intent(out) :: known
    integer :: low, high, middle

    low = 1
    high = params%n
    do while (low <= high)
      middle = (low + high)/2
      if (params%name(params%order(middle))%text < name) then
        low = middle + 1
      else
        high = middle - 1
      end if
    end do
    at = low
    known = .false.
    if (at <= params%n) known = params%name(params%order(at))%text == name
  end subroutine locate

end module deck_params
