!> AUGMent: one step of Uzawa's iteration for contact pressures (FEAP's AUGM).
!!
!! The multipliers take over the pressure due to the penetrations, so that the next solves leave
!! smaller penetrations. The commands are LOOP,augment,n / LOOP,newton,m / UTAN,,1 / NEXT / AUGMent
!! / NEXT. If no pressure would change by more than a tolerance (relative to the largest pressure or
!! multiplier at present), nothing is changed and LOOP,augment ends. Nothing is changed in the last
!! pass of this loop either if no solve follows in it. Before the first solve of a step, nothing is
!! changed, because the pressures are those of the previous step.
module command_augment
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use command_type, only: run_t, program_t, command_t, command_row_t, new_row, check_fields
  use contact_augment, only: rise_t, find_rise, take_rise, largest_pressure
  use program_position, only: begins_step, is_last_pass, leave_loop, spans_step
  implicit none
  private
  public :: augment_rows

  real(wp), parameter :: USUAL = 1.0e-3_wp !! default tolerance
  character(4), parameter :: SOLVES(3) = ['tang', 'utan', 'solv']

contains

  function augment_rows() result(row)
    type(command_row_t) :: row(1)

    row(1) = new_row('AUGMent', 'AUGMent,,[tolerance]', 2, run_augment)
  end function augment_rows

  subroutine run_augment(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(rise_t), allocatable :: rise(:, :) ! (2, ncontact)
    real(wp) :: change, most, tolerance
    integer :: c, k

    call check_fields(command, 1, 'AUGMent,,[tolerance]', error, option=.false.)
    if (allocated(error)) return
    tolerance = USUAL
    if (.not. command%record%is_empty(3)) tolerance = command%x(1)
    if (.not. (tolerance > 0.0_wp .and. tolerance < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'expected a tolerance between 0 and 1, found ' &
                //to_text(tolerance), command%record%place(3), 'write AUGMent,,1.e-3')
      return
    end if
    if (size(run%model%contact) == 0) then
      call fail(error, DECK_ERROR, 'AUGMent needs a CONTact, but the deck has none', &
                command%record%place(1), 'define a CONTact, whose pressures AUGMent corrects, or ' &
                //'remove AUGMent')
      return
    end if
    if (any(run%model%contact(:)%ncell > 1)) then
      call fail(error, DECK_ERROR, 'AUGMent cannot be used together with REFIne', &
                command%record%place(1), 'remove AUGMent, or replace REFIne by more integration ' &
                //'points (QUADrature n1 n2)')
      return
    end if
    if (run%program%dry) then
      if (.not. is_followed(run%program)) then
        call fail(error, DECK_ERROR, 'no TANG or UTAN follows this AUGMent within the same step', &
                  command%record%place(1), 'enclose both the Newton loop and AUGMent in ' &
                  //'LOOP,augment,n, inside the loop with TIME if there is one')
      else if (command%visit == 1 .and. .not. is_preceded(run%program)) then
        call warn('AUGMent has no effect, because no TANG or UTAN precedes it in its step', &
                  command%record%place(1), 'enclose both the Newton loop and AUGMent in ' &
                  //'LOOP,augment,n with at least two passes')
      end if
      return
    end if
    if (.not. (run%step%open .and. run%step%solved)) return

    associate (contact => run%state%contact)
      allocate (rise(2, size(contact)))
      change = 0.0_wp
      most = 0.0_wp
      do c = 1, size(contact)
        call find_rise(run%model%contact(c), contact(c), rise(:, c))
        do k = 1, 2
          if (size(rise(k, c)%at) == 0) cycle
          change = max(change, maxval(abs(rise(k, c)%at)))
          most = max(most, largest_pressure(run%model%contact(c), k, contact(c)))
        end do
      end do
      if (most > 0.0_wp) change = change/most
      if (change <= tolerance) then
        if (.not. change > 0.0_wp) then
          call log_line('  no augmentation: no pressure would change')
        else
          call log_line('  no further augmentation: pressures would change by only ' &
                        //to_text(change)//' times the largest pressure')
        end if
        call leave_loop(run%program)
      else if (is_last_pass(run%program) .and. .not. solves_again(run%program)) then
        call log_line('  no augmentation in the last pass: pressures would still change by ' &
                      //'up to '//to_text(change)//' times the largest pressure')
      else
        do c = 1, size(contact)
          do k = 1, 2
            call take_rise(run%model%contact(c), rise(k, c), k, contact(c))
          end do
        end do
        ! The equilibrium of the step has changed, so its iteration continues.
        run%step%newton%converged = .false.
        run%step%newton%before = run%step%newton%iterations
        run%step%newton%secant%count = 0 ! increments with secants are part of `before`
        call log_line('  augmented: pressures changed by up to '//to_text(change) &
                      //' times the largest pressure')
      end if
    end associate
  end subroutine run_augment

  !> Is there a solve between the command at the counter and the end of the innermost loop?
  pure logical function solves_again(program) result(yes)
    type(program_t), intent(in) :: program
    integer :: i, top

    yes = .false.
    top = size(program%loop)
    if (top == 0) return
    do i = program%counter + 1, program%command(program%loop(top)%at)%matching
      yes = yes .or. any(program%command(i)%record%key(1) == SOLVES)
    end do
  end function solves_again

  !> Is there a solve between the command at the counter and the next step, either in the commands
  !! that follow or, before a step begins, in another pass of a loop?
  pure logical function is_followed(program) result(yes)
    type(program_t), intent(in) :: program
    integer :: i, j

    yes = .false.
    do i = program%counter + 1, size(program%command)
      associate (command => program%command(i))
        if (begins_step(program, i)) return
        yes = any(command%record%key(1) == SOLVES)
        if (command%record%key(1) == 'next') then
          do j = command%matching, i
            if (begins_step(program, j)) exit
            yes = yes .or. any(program%command(j)%record%key(1) == SOLVES)
          end do
          if (j <= i) return
        end if
        if (yes) return
      end associate
    end do
  end function is_followed

  !> Is there a solve between the beginning of the step and the command at the counter, or in
  !! another pass of a loop around it in which no step begins?
  pure logical function is_preceded(program) result(yes)
    type(program_t), intent(in) :: program
    integer :: i, j

    yes = .false.
    if (begins_step(program, program%counter)) return
    do i = program%counter - 1, 1, -1
      associate (command => program%command(i))
        yes = any(command%record%key(1) == SOLVES)
        if (command%record%key(1) == 'loop' .and. command%matching > program%counter .and. &
            .not. spans_step(program, i) .and. command%passes > 1) then
          yes = yes .or. any([(any(program%command(j)%record%key(1) == SOLVES), &
                               j=program%counter, command%matching)])
        end if
        if (yes .or. begins_step(program, i)) return
      end associate
    end do
  end function is_preceded

end module command_augment
