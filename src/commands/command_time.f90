!> DT, TIME, AUTO: how time moves.
module command_time
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use command_type, only: run_t, command_t, command_row_t, new_row
  use command_close, only: close_step
  use command_loop, only: mark_step
  use newton, only: begin_newton
  use path_switch, only: begin_way
  use step_control, only: set_dt, set_auto
  implicit none
  private
  public :: describe_dt, describe_time, describe_auto

contains

  function describe_dt() result(row)
    type(command_row_t) :: row

    row = new_row('DT', 'DT,,dt', 2, run_dt)
  end function describe_dt

  function describe_time() result(row)
    type(command_row_t) :: row

    row = new_row('TIME', 'TIME', 0, run_time)
  end function describe_time

  function describe_auto() result(row)
    type(command_row_t) :: row

    row = new_row('AUTO', 'AUTO,,dtmin,dtmax', 3, run_auto)
  end function describe_auto

  subroutine run_dt(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (.not. command%x(1) > 0.0_wp) then
      call fail(error, DECK_ERROR, 'a time step is positive, not '//to_text(command%x(1)), &
                command%record%place(3), 'write DT,,dt')
      return
    end if
    call set_dt(run%control, run%state%time, command%x(1))
    ! the step under way ends at the new anchor: closing it must not count a target
    if (run%plan%open .and. run%plan%timed) run%control%target = -run%control%passed
    ! A step under way is counted when it closes, and it ends where the new targets begin.
    if (run%plan%open .and. run%plan%timed) run%control%target = -run%control%passed
  end subroutine run_dt

  !> Close the step under way and open the next one.
  subroutine run_time(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: closed
    integer :: left, top

    if (run%control%dt <= 0.0_wp) then
      call fail(error, DECK_ERROR, 'TIME without a time step', command%record%place(1), &
                'put DT,,dt before it')
      return
    end if
    if (run%dry) return
    call close_step(run, closed, error)
    if (allocated(error) .or. .not. closed) return
    left = 1
    top = size(run%loop)
    if (top > 0) then
      if (run%command(run%loop(top)%at)%holds_time) then
        left = run%loop(top)%limit - run%loop(top)%count + 1
      end if
    end if
    call mark_step(run)
    call begin_way(run, left)
    if (.not. run%plan%retry) run%plan%cutbacks = 0
    run%plan%retry = .false.
    run%plan%timed = .true.
    call begin_newton(run%newton, run%model, run%state)
  end subroutine run_time

  subroutine run_auto(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (.not. command%x(1) > 0.0_wp .or. command%x(2) < command%x(1)) then
      call fail(error, DECK_ERROR, 'AUTO needs 0 < dtmin <= dtmax, not '//to_text(command%x(1)) &
                //' and '//to_text(command%x(2)), command%record%place(3), &
                'write AUTO,,dtmin,dtmax')
      return
    end if
    call set_auto(run%control, command%x(1), command%x(2))
  end subroutine run_auto

end module command_time
