!> DT, TIME, AUTO: time steps.
module command_time
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_step, only: finish_step, open_step_here
  use command_type, only: run_t, command_t, command_row_t, new_row, check_fields
  use program_position, only: targets_left
  use step, only: change_dt
  use step_control, only: set_auto
  implicit none
  private
  public :: time_rows

contains

  function time_rows() result(row)
    type(command_row_t) :: row(3)

    row(1) = new_row('DT', 'DT,,dt', 2, run_dt)
    row(2) = new_row('TIME', 'TIME', 0, run_time)
    row(3) = new_row('AUTO', 'AUTO,,dtmin,dtmax', 3, run_auto)
  end function time_rows

  subroutine run_dt(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 1, 'DT,,dt', error, option=.false.)
    if (allocated(error)) return
    if (command%x(1) > 0) then
      call change_dt(run%step, run%state%time, command%x(1))
    else
      call fail(error, DECK_ERROR, 'expected a time step greater than 0, found ' &
                //to_text(command%x(1)), command%record%place(3), 'write DT,,dt')
    end if
  end subroutine run_dt

  !> Close the current step and begin the next one.
  subroutine run_time(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: rewound

    if (run%step%control%dt <= 0) then
      call fail(error, DECK_ERROR, 'TIME has no time step', command%record%place(1), &
                'put DT,,dt before it')
      return
    end if
    if (run%program%dry) then
      call warn_large_dt(run)
      return
    end if
    call finish_step(run, rewound, error)
    if (.not. (allocated(error) .or. rewound)) call open_step_here(run, targets_left(run%program))
  end subroutine run_time

  !> Warn if targets are farther apart than dtmax of AUTO, which does not shorten steps.
  subroutine warn_large_dt(run)
    type(run_t), intent(inout) :: run
    real(wp), parameter :: ROUNDING = 1.0e-9_wp
    integer :: i

    associate (control => run%step%control, program => run%program)
      if (.not. control%automatic .or. control%dt <= (1 + ROUNDING)*control%dtmax) return
      do i = program%counter, 1, -1
        if (program%command(i)%record%key(1) == 'auto') exit
      end do
      if (program%noted(program%command(i)%row)) return
      program%noted(program%command(i)%row) = .true.
      call warn('AUTO has dtmax = '//to_text(control%dtmax)//', which does not shorten steps of ' &
                //'DT = '//to_text(control%dt), program%command(i)%record%place(4), 'dtmax only ' &
                //'limits how far steps grow beyond DT; for shorter steps give a smaller DT and ' &
                //'more passes of the loop')
    end associate
  end subroutine warn_large_dt

  subroutine run_auto(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 2, 'AUTO,,dtmin,dtmax', error, option=.false.)
    if (allocated(error)) return
    if (command%x(1) > 0 .and. command%x(2) >= command%x(1)) then
      call set_auto(run%step%control, command%x(1), command%x(2))
    else
      call fail(error, DECK_ERROR, 'AUTO needs 0 < dtmin <= dtmax, found '//to_text(command%x(1)) &
                //' and '//to_text(command%x(2)), command%record%place(3), &
                'write AUTO,,dtmin,dtmax')
    end if
  end subroutine run_auto

end module command_time
