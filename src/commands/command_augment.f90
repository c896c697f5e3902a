!> AUGMent: one step of Uzawa's iteration for contact pressures (FEAP's AUGM).
!!
!! The multipliers rise by what penetrations press, so that the next solves leave less of them:
!! LOOP,augment,n / LOOP,newton,m / UTAN,,1 / NEXT / AUGMent / NEXT. Where no pressure would change
!! by more than a tolerance, nothing is changed and the loop ends; so too in its last pass.
module command_augment
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: log_line
  use base_text, only: to_text
  use contact_augment, only: rise_t, find_rise, take_rise
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
    type(rise_t), allocatable :: rise(:, :)
    real(wp) :: change, tolerance

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
    if (any(run%model%contact(:)%ncell > 1)) then
      call fail(error, DECK_ERROR, 'AUGMent in a deck with REFIne', command%record%place(1), &
                'one of both: QUADrature n1 n2 with more points, or no AUGMent')
      return
    end if
    if (run%dry .or. .not. run%plan%open) return
    call find_rises(run, rise, change)
    if (change <= tolerance) then
      call leave_loop(run)
    else if (is_last(run)) then
      call log_line('  last augmentation: a pressure would still change by '//to_text(change) &
                    //' of the largest')
    else
      call take_rises(run, rise)
      call log_line('  augmented: a pressure changed by '//to_text(change)//' of the largest')
    end if
  end subroutine run_augment

  !> Rises of all contacts, and the largest relative to the largest pressure.
  subroutine find_rises(run, rise, change)
    type(run_t), intent(in) :: run
    type(rise_t), allocatable, intent(out) :: rise(:, :) !! (2, ncontact)
    real(wp), intent(out) :: change
    real(wp) :: most
    integer :: c, k

    allocate (rise(2, size(run%state%contact)))
    change = 0.0_wp
    most = 0.0_wp
    do c = 1, size(run%state%contact)
      call find_rise(run%model%contact(c), run%state%contact(c), rise(:, c))
      do k = 1, 2
        if (size(rise(k, c)%at) == 0) cycle
        change = max(change, maxval(abs(rise(k, c)%at)))
        most = max(most, maxval(run%state%contact(c)%side(k)%pressure))
      end do
    end do
    if (most > 0.0_wp) change = change/most
  end subroutine find_rises

  !> Nothing follows the last pass of a loop that would bring the bodies into balance with new
  !! multipliers: there they stay as they are.
  pure logical function is_last(run)
    type(run_t), intent(in) :: run
    integer :: top

    top = size(run%loop)
    is_last = top > 0
    if (is_last) is_last = run%loop(top)%count == run%loop(top)%limit &
                           .and. .not. run%command(run%loop(top)%at)%holds_time
  end function is_last

  !> The multipliers change, and with them the balance of the step.
  subroutine take_rises(run, rise)
    type(run_t), intent(inout) :: run
    type(rise_t), intent(in) :: rise(:, :)
    integer :: c, k

    do c = 1, size(run%state%contact)
      do k = 1, 2
        call take_rise(rise(k, c), run%state%contact(c)%side(k))
      end do
    end do
    run%newton%converged = .false.
    run%newton%before = run%newton%iterations
  end subroutine take_rises

end module command_augment
