!> Several independent errors of one deck.
module base_error_list
  use base_error, only: error_t, render
  use base_text, only: to_text
  implicit none
  private
  public :: error_list_t

  integer, parameter :: MOST = 10 !! shown and kept; the others are counted

  type :: error_list_t
    private
    type(error_t) :: kept(MOST)
    integer :: n = 0
  contains
    procedure :: add => add_error
    procedure :: count => count_errors
    procedure :: code => exit_code
    procedure :: render => render_list
  end type error_list_t

contains

  !> Keep one more.
  subroutine add_error(list, error)
    class(error_list_t), intent(inout) :: list
    type(error_t), intent(in) :: error

    list%n = list%n + 1
    if (list%n <= MOST) list%kept(list%n) = error
  end subroutine add_error

  pure function count_errors(list) result(n)
    class(error_list_t), intent(in) :: list
    integer :: n

    n = list%n
  end function count_errors

  !> Exit code: that of the first error, 0 where there is none.
  pure function exit_code(list) result(code)
    class(error_list_t), intent(in) :: list
    integer :: code

    code = 0
    if (list%n > 0) code = list%kept(1)%code
  end function exit_code

  !> As the user sees them, up to ten, and how many more there are.
  pure function render_list(list) result(text)
    class(error_list_t), intent(in) :: list
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, min(list%n, MOST)
      if (i > 1) text = text//new_line('a')
      text = text//render(list%kept(i))
    end do
    if (list%n > MOST) text = text//new_line('a')//'and '//to_text(list%n - MOST)//' more'
  end function render_list

end module base_error_list
