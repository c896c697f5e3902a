!> What can only be checked when the whole deck is known: loads and motions against their tables.
module command_check
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text
  use boundary, only: boundary_t, place_of_number
  implicit none
  private
  public :: check_tables

contains

  !> Every load number has a PROP; 0, the sum of all tables, needs none. Without any PROP all
  !! factors are 1.
  subroutine check_tables(bc, ntable, error)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: ntable   !! highest table that a PROP defines
    type(error_t), allocatable, intent(out) :: error
    type(place_t) :: place
    integer :: i

    if (ntable == 0) return
    do i = 1, size(bc%motion)
      call check(bc%motion(i)%table, bc%motion(i)%place)
    end do
    do i = 1, size(bc%pressure)
      call check(bc%pressure(i)%table, bc%pressure(i)%place)
    end do
    do i = 1, size(bc%dead)
      call check(bc%dead(i)%table, bc%dead(i)%place)
    end do
    do i = 1, size(bc%table, 2)
      if (maxval(bc%table(:, i)) <= ntable) cycle
      call place_of_number(bc, maxval(bc%table(:, i)), place)
      call check(maxval(bc%table(:, i)), place)
      return
    end do

  contains

    subroutine check(table, place)
      integer, intent(in) :: table
      type(place_t), intent(in) :: place

      if (allocated(error) .or. table <= ntable) return
      call fail(error, DECK_ERROR, 'load table '//to_text(table)//' is not defined', place, &
                'put PROP,,'//to_text(table)//' among the commands and its data behind END')
    end subroutine check

  end subroutine check_tables

end module command_check
