!> TANG, UTAN, FORM, SOLV: the Newton iteration; TOL and FACTor: how it is done.
module command_solve
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: log_line
  use command_progress, only: show_iteration
  use command_type, only: run_t, command_t, command_row_t, new_row
  use command_loop, only: leave_loop, mark_step, cut_back
  use linear_system, only: FULL, REUSE, SINGLE, LOWRANK
  use model, only: model_t
  use newton, only: newton_pass, form_system, solve_system, begin_newton, pass_t
  use path_switch, only: note_time
  use solution_state, only: open_step
  implicit none
  private
  public :: describe_tang, describe_utan, describe_form, describe_solv, describe_tol, &
            describe_factor

contains

  function describe_tang() result(row)
    type(command_row_t) :: row

    row = new_row('TANG', 'TANG,[LINE],[1]', 4, run_tangent)
  end function describe_tang

  function describe_utan() result(row)
    type(command_row_t) :: row

    row = new_row('UTAN', 'UTAN,[LINE],[1]', 4, run_tangent)
  end function describe_utan

  function describe_form() result(row)
    type(command_row_t) :: row

    row = new_row('FORM', 'FORM', 1, run_form)
  end function describe_form

  function describe_solv() result(row)
    type(command_row_t) :: row

    row = new_row('SOLV', 'SOLV,[LINE]', 2, run_solve)
  end function describe_solv

  function describe_tol() result(row)
    type(command_row_t) :: row

    row = new_row('TOL', 'TOL,,energy', 4, run_tolerance)
  end function describe_tol

  function describe_factor() result(row)
    type(command_row_t) :: row

    row = new_row('FACTor', 'FACTor REUSe | SINGle | LOWRank eps', 2, run_factor)
  end function describe_factor

  subroutine run_tangent(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: symmetric

    call check_option(command, error)
    if (allocated(error) .or. run%dry) return
    call ensure_step(run)
    symmetric = command%record%key(1) == 'tang' .or. .not. is_unsymmetric(run%model)
    if (symmetric .and. is_unsymmetric(run%model)) then
      run%newton%exact = .false.
      call note_once(run, command%row)
    end if
    if (.not. abs(command%x(1)) > 0.0_wp) then
      run%pass = pass_t()
      call form_system(run%newton, run%model, run%state, symmetric, run%pass, error)
      if (allocated(error)) return
      if (.not. run%pass%ok) call cut_back(run, run%pass%trouble, error)
      return
    end if
    call newton_pass(run%newton, run%model, run%state, symmetric, command%option == 'line', &
                     run%pass, error)
    if (allocated(error)) return
    call after_solve(run, error)
  end subroutine run_tangent

  !> TANG on a model whose tangent is not symmetric.
  subroutine note_once(run, row)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: row

    if (run%noted(row)) return
    run%noted(row) = .true.
    call log_line('note: TANG takes the symmetric part of the tangent; UTAN takes all of it')
  end subroutine note_once

  !> FORM: the residual at the displacements of now (the tangent comes with it).
  subroutine run_form(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (run%dry .or. command%row == 0) return
    call ensure_step(run)
    run%pass = pass_t()
    call form_system(run%newton, run%model, run%state, run%newton%symmetric .or. &
                     .not. is_unsymmetric(run%model), run%pass, error)
    if (allocated(error)) return
    if (.not. run%pass%ok) call cut_back(run, run%pass%trouble, error)
  end subroutine run_form

  !> SOLV: solve for what the last FORM or TANG formed.
  subroutine run_solve(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_option(command, error)
    if (allocated(error)) return
    if (.not. is_formed(run)) then
      call fail(error, DECK_ERROR, 'SOLV before anything was formed', command%record%place(1), &
                'put TANG or FORM before it, behind TIME')
      return
    end if
    if (run%dry) return
    call solve_system(run%newton, run%model, run%state, command%option == 'line', run%pass, error)
    if (allocated(error)) return
    call after_solve(run, error)
  end subroutine run_solve

  !> A TANG, UTAN or FORM stands between SOLV and the TIME before it.
  function is_formed(run) result(yes)
    type(run_t), intent(in) :: run
    logical :: yes
    integer :: i

    yes = .false.
    do i = run%pc - 1, 1, -1
      yes = any(run%command(i)%record%key(1) == ['tang', 'utan', 'form'])
      if (yes .or. run%command(i)%record%key(1) == 'time') return
    end do
  end function is_formed

  !> Book, show and act on a solve.
  subroutine after_solve(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    call run%timers%add('assembly', run%pass%sweep%seconds - run%pass%sweep%contact_seconds)
    if (size(run%model%contact) > 0) call run%timers%add('contact', run%pass%sweep%contact_seconds)
    call run%timers%add('factorise', run%pass%solve%seconds_factor)
    call run%timers%add('solve', run%pass%solve%seconds_solve)
    if (.not. run%pass%ok) then
      call cut_back(run, run%pass%trouble, error)
      return
    end if
    run%plan%solved = .true.
    call note_time(run)
    run%iterations = run%iterations + 1
    call show_iteration(run)
    if (run%newton%converged) call leave_loop(run)
  end subroutine after_solve

  !> A deck without TIME is one step at t = 0.
  subroutine ensure_step(run)
    type(run_t), intent(inout) :: run

    if (run%plan%open) return
    call mark_step(run)
    run%plan%timed = .false.
    run%plan%cutbacks = 0
    call open_step(run%state, run%state%time)
    call begin_newton(run%newton, run%model, run%state)
  end subroutine ensure_step

  !> The model has a tangent that is not symmetric.
  pure function is_unsymmetric(model) result(yes)
    type(model_t), intent(in) :: model
    logical :: yes
    integer :: i

    yes = size(model%contact) > 0
    do i = 1, size(model%bc%pressure)
      yes = yes .or. model%bc%pressure(i)%follower
    end do
    do i = 1, size(model%material)
      yes = yes .or. .not. model%material(i)%row%symmetric
    end do
  end function is_unsymmetric

  subroutine check_option(command, error)
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (command%option == '' .or. command%option == 'line') return
    call fail(error, DECK_ERROR, "unknown option '"//command%record%text(2)//"'", &
              command%record%place(2), &
              'LINE asks for a line search; otherwise leave the field empty: TANG,,1')
  end subroutine check_option

  subroutine run_tolerance(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (.not. (command%x(1) > 0.0_wp .and. command%x(1) < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'a tolerance lies between 0 and 1', command%record%place(3), &
                'write TOL,,1.e-16')
      return
    end if
    run%newton%tolerance = command%x(1)
  end subroutine run_tolerance

  subroutine run_factor(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: mode

    select case (command%option)
    case ('full')
      mode = FULL
    case ('reus')
      mode = REUSE
    case ('sing')
      mode = SINGLE
    case ('lowr')
      mode = LOWRANK
    case default
      call fail(error, DECK_ERROR, 'unknown way to solve', command%record%place(2), &
                'FACTor FULL | REUSe | SINGle | LOWRank eps')
      return
    end select
    if (mode == LOWRANK .and. .not. (command%x(1) > 0.0_wp .and. command%x(1) < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'LOWRank needs its accuracy, between 0 and 1', &
                command%record%place(2), 'FACTor LOWRank 1.e-8')
      return
    end if
    if (run%dry) return
    if (run%newton%ready &
        .and. (mode /= run%newton%mode .or. abs(command%x(1) - run%newton%eps) > 0.0_wp)) then
      call run%newton%system%free()
      run%newton%ready = .false.
    end if
    run%newton%mode = mode
    run%newton%eps = command%x(1)
  end subroutine run_factor

end module command_solve
