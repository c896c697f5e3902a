!> Closing a step: the last test, the rows of the curves, fields, checkpoint.
module command_close
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use listing_contact, only: list_contacts
  use contact_notes, only: note_lost_contacts
  use command_files, only: open_files, write_rows, write_fields, write_checkpoint, set_restart_point
  use linear_system, only: FULL
  use command_loop, only: cut_back
  use command_type, only: run_t
  use energy_book, only: accept_step_end
  use newton, only: close_newton, pass_t
  use path_switch, only: look_after_step
  use step_control, only: accept_step, pass_target
  implicit none
  private
  public :: close_step

  integer, parameter :: RESTART_EVERY = 10 !! steps between restart points where factors are kept
  real(wp), parameter :: FAR = 2.0_wp !! sizes of the model: no step goes farther

contains

  !> Close the step under way, if any. closed = .false.: it failed its last test and was cut; the
  !! command counter points to its TIME again.
  subroutine close_step(run, closed, error)
    type(run_t), intent(inout) :: run
    logical, intent(out) :: closed
    type(error_t), allocatable, intent(out) :: error
    type(pass_t) :: pass

    closed = .true.
    if (.not. run%plan%open) return
    run%plan%open = .false.
    if (.not. run%plan%solved) then       ! a step never solved writes nothing and moves nothing
      run%state%step = run%plan%step
      if (run%plan%timed) call accept_step(run%control, 0)
      return
    end if
    call close_newton(run%newton, run%model, run%state, pass, error)
    if (allocated(error)) return
    if (pass%ok .and. flies_off(run)) then
      pass%ok = .false.
      pass%trouble = 'a body that nothing holds has flown off'
    end if
    closed = pass%ok .and. (run%newton%converged .or. .not. run%control%automatic)
    if (.not. closed) then
      run%plan%open = .true.
      if (pass%ok) pass%trouble = 'no convergence'
      call cut_back(run, pass%trouble, error)
      return
    end if
    if (.not. run%newton%converged) call complain(run, pass)
    if (.not. run%newton%local%on) call look_at_pivots(run)
    call note_lost_contacts(run%model, run%state)
    call accept_step_end(run%newton%asm, run%model, run%state)
    call count_step(run)
    call look_after_step(run, pass%sweep%largest)
    call run%timers%start('output')
    call write_step(run, error)
    call run%timers%stop('output')
    run%plan%cutbacks = 0
    run%plan%solved = .false.
  end subroutine close_step

  !> Automatic steps with contact: has a node gone farther than twice the size of the model and the
  !! longest way that a node was led? What contact and bonds no longer hold has equilibria anywhere;
  !! inertia finds a better one.
  pure logical function flies_off(run) result(yes)
    type(run_t), intent(in) :: run
    real(wp) :: extent, led

    yes = run%control%automatic .and. size(run%model%contact) > 0
    if (.not. yes) return
    associate (xr => run%model%mesh%xr)
      extent = maxval(maxval(xr, 2) - minval(xr, 2))
    end associate
    associate (way => run%state%u - run%state%u_step)
      led = max(0.0_wp, maxval(abs(way), mask=run%model%bc%fixed /= 0))
      yes = maxval(abs(way)) > FAR*(extent + led)
    end associate
  end function flies_off

  !> The step is behind; where it was hard the next one is smaller, and the log says so.
  subroutine count_step(run)
    type(run_t), intent(inout) :: run
    integer :: n

    if (.not. run%plan%timed) return
    n = run%newton%iterations - run%newton%before
    if (run%newton%local%on) then
      call pass_target(run%control)
      return
    end if
    call accept_step(run%control, n)
    if (.not. run%control%reduced) return
    call log_line('  step '//to_text(run%state%step)//' took '//to_text(n) &
                  //' iterations: the next one is at most '//to_text(run%control%size)//' long')
  end subroutine count_step

  !> Everything a closed step writes.
  subroutine write_step(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    logical :: fields

    call open_files(run, error)
    if (allocated(error)) return
    call write_rows(run, error)
    if (allocated(error)) return
    call list_contacts(run%model, run%state, run%newton%asm%f_ext)
    fields = run%plan%plot
    if (run%plan%every > 0) fields = fields .or. mod(run%state%step, run%plan%every) == 0
    if (fields) call write_fields(run, error)
    if (allocated(error)) return
    run%plan%plot = .false.
    if (run%plan%save) then
      run%plan%save = .false.
      call write_checkpoint(run, error)
    else if (run%newton%mode /= FULL .and. mod(run%state%step, RESTART_EVERY) == 0) then
      call set_restart_point(run)
    end if
  end subroutine write_step

  subroutine complain(run, pass)
    type(run_t), intent(inout) :: run
    type(pass_t), intent(in) :: pass

    run%failed_step = .true.
    call warn('step '//to_text(run%state%step)//' was closed before it converged: residual ' &
              //to_text(pass%residual)//', largest nodal force '//to_text(pass%sweep%largest), &
              hint='more iterations, or AUTO,,dtmin,dtmax; the run will end with code 2')
  end subroutine complain

  !> A converged state on an unstable branch is a warning; after the first it is only logged.
  subroutine look_at_pivots(run)
    type(run_t), intent(inout) :: run
    character(:), allocatable :: text
    integer :: negative

    if (.not. run%pass%solve%factorised) return
    negative = run%pass%solve%negative + run%pass%sweep%negative
    text = to_text(negative)//' negative pivots'
    if (negative == 0 .and. .not. run%newton%symmetric .and. run%pass%solve%determinant < 0) then
      negative = 1
      text = 'the determinant of the tangent is negative'
    end if
    if (negative > 0 .and. run%negative_pivots == 0) then
      text = 'step '//to_text(run%state%step)//' converged to an unstable state: '//text
      if (run%unstable) then
        call log_line(text)
      else
        call warn(text//'; the log names later ones', hint='hourglassing (ENHAnced in ' &
                  //'compression), buckling or a limit point; look at the deformed shape')
      end if
      run%unstable = .true.
    end if
    run%negative_pivots = negative
  end subroutine look_at_pivots

end module command_close
