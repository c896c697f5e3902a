!> Members of JSON objects with the kind that they must have.
module json_value
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use json_tree, only: json_t, member, first_of, JSON_NUMBER, JSON_OBJECT
  use patch_text, only: text_t, complain
  implicit none
  private
  public :: get, get_integer, to_integer, get_reals, compare

contains

  !> A member of a kind.
  subroutine get(text, json, i, name, kind, found, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i, kind
    character(*), intent(in) :: name
    integer, intent(out) :: found
    type(error_t), allocatable, intent(out) :: error

    found = member(text, json, i, name)
    text%at = json%at(i)
    if (found == 0) then
      call complain(text, 'there is no '//quoted(name), error, &
                    'the format asks for it')
      return
    end if
    text%at = json%at(found)
    if (json%kind(found) /= kind) call complain(text, quoted(name)//' is not what it should be', &
                                                error, 'it is '//kind_name(kind))
  end subroutine get

  pure function kind_name(kind) result(name)
    integer, intent(in) :: kind
    character(:), allocatable :: name

    name = 'a list'
    if (kind == JSON_NUMBER) name = 'a number'
    if (kind == JSON_OBJECT) name = 'an object'
  end function kind_name

  subroutine get_integer(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i
    character(*), intent(in) :: name
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error
    integer :: found

    n = 0
    call get(text, json, i, name, JSON_NUMBER, found, error)
    if (.not. allocated(error)) call to_integer(text, json, found, name, n, error)
  end subroutine get_integer

  !> A value as a whole number.
  subroutine to_integer(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i
    character(*), intent(in) :: name
    integer, intent(out) :: n
    type(error_t), allocatable, intent(out) :: error

    n = 0
    text%at = json%at(i)
    if (json%kind(i) == JSON_NUMBER .and. abs(json%number(i)) < huge(n) &
        .and. .not. abs(json%number(i) - anint(json%number(i))) > 0.0_wp) then
      n = nint(json%number(i))
    else
      call complain(text, 'a whole number should stand in '//quoted(name), error)
    end if
  end subroutine to_integer

  !> All numbers of a list.
  subroutine get_reals(text, json, list, name, x, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: list
    character(*), intent(in) :: name
    real(wp), allocatable, intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: i, j

    allocate (x(json%length(list)), source=0.0_wp)
    j = first_of(json, list)
    do i = 1, size(x)
      if (json%kind(j) /= JSON_NUMBER) then
        text%at = json%at(j)
        call complain(text, 'a number should stand in '//quoted(name), error)
        return
      end if
      x(i) = json%number(j)
      j = json%next(j)
    end do
  end subroutine get_reals

  !> A count, where the file says one.
  subroutine compare(text, json, i, name, n, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: i, n
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error
    integer :: said

    if (member(text, json, i, name) == 0) return
    call get_integer(text, json, i, name, said, error)
    if (allocated(error) .or. said == n) return
    call complain(text, quoted(name)//' is '//to_text(said)//', but there are '//to_text(n), error)
  end subroutine compare

end module json_value
