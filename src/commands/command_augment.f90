!> AUGMent: one step of Uzawa's iteration for contact pressures (FEAP's AUGM).
!!
!! The multipliers take the pressures of now, so that the next solves press the surfaces together
!! with less penetration: LOOP,augment,n / LOOP,newton,m / UTAN,,1 / NEXT / AUGMent / NEXT.
!! Where no pressure would change by more than a tolerance, nothing is changed and the loop ends.
module command_augment
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: log_line
  use base_text, only: to_text
  use command_loop, only: leave_loop
  use command_type, only: run_t, command_t, command_row_t, new_row
  implicit none
  private
  public :: describe_augment

  real(wp), parameter :: USUAL = 1.0e-3_wp !! change of a pressure relative to the largest

contains

  function describe_augment() result(row)
    type(command_row_t) :: row

    row = new_row('AUGMent', 'AUGMent,,[tolerance]', 2, run_augment)
  end function describe_augment

  subroutine run_augment(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: change, most, tolerance
    integer :: c, k

    tolerance = USUAL
    if (.not. command%record%is_empty(3)) tolerance = command%x(1)
    if (.not. (tolerance > 0.0_wp .and. tolerance < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'the tolerance of AUGMent lies between 0 and 1', &
                command%record%place(3), 'write AUGMent,,1.e-3')
      return
    end if
    if (size(run%model%contact) == 0) then
      call fail(error, DECK_ERROR, 'AUGMent in a deck without CONTact', command%record%place(1), &
                'it augments the pressures of contacts')
      return
    end if
    if (run%dry .or. .not. run%plan%open) return
    change = 0.0_wp
    most = 0.0_wp
    do c = 1, size(run%state%contact)
      do k = 1, 2
        associate (points => run%state%contact(c)%side(k))
          if (size(points%pressure) == 0) cycle
          most = max(most, maxval(points%pressure))
          change = max(change, maxval(abs(points%pressure - points%multiplier)))
        end associate
      end do
    end do
    if (change <= tolerance*most) then
      call leave_loop(run)
      return
    end if
    do c = 1, size(run%state%contact)
      do k = 1, 2
        run%state%contact(c)%side(k)%multiplier = run%state%contact(c)%side(k)%pressure
      end do
    end do
    run%newton%converged = .false.
    call log_line('  augmented: a pressure changed by '//to_text(change/most)//' of the largest')
  end subroutine run_augment

end module command_augment
