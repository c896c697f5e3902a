!> TANG, UTAN, FORM, SOLV: Newton's iteration; TOL and FACTor: its tolerance and its linear solver.
module command_solve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: log_line, progress, warn
  use base_system, only: wall_seconds
  use base_text, only: to_text
  use command_step, only: open_step_here, take_outcome
  use command_type, only: run_t, command_t, command_row_t, program_t, new_row, &
                          check_fields
  use contact_pair, only: MORTAR
  use linear_system, only: FULL, REUSE, SINGLE, LOWRANK, AUTO
  use model, only: model_t
  use newton, only: set_factorisation
  use program_position, only: iterates
  use step, only: form_pass, solve_pass, STEP_GOES_ON
  implicit none
  private
  public :: solve_rows

  real(wp), parameter :: LOOSE = 1.0e-6_wp !! tolerance of TOL above which a warning is issued

contains

  function solve_rows() result(row)
    type(command_row_t) :: row(6)

    row(1) = new_row('TANG', 'TANG,[LINE],[1]', 4, run_tangent)
    row(2) = new_row('UTAN', 'UTAN,[LINE],[1]', 4, run_tangent)
    row(3) = new_row('FORM', 'FORM', 1, run_form)
    row(4) = new_row('SOLV', 'SOLV,[LINE]', 2, run_solve)
    row(5) = new_row('TOL', 'TOL,,energy', 4, run_tolerance)
    row(6) = new_row('FACTor', 'FACTor AUTO | FULL | REUSe | SINGle | LOWRank eps', 2, run_factor)
  end function solve_rows

  !> Run TANG or UTAN: form the system, and solve it if the number after the option is 1.
  subroutine run_tangent(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: symmetric

    call check_option(command, error)
    call check_fields(command, merge(2, 1, command%option == 'line'), &
                      command%record%text(1)//',,1 or '//command%record%text(1)//',LINE,1', error)
    if (allocated(error)) return
    if (all(abs(command%x(1) - [0.0_wp, 1.0_wp]) > 0.0_wp)) then
      call fail(error, DECK_ERROR, 'expected 1 or 0, found '//to_text(command%x(1)), &
                command%record%place(3), command%record%text(1)//',,1 forms the system and ' &
                //'solves it; '//command%record%text(1)//' alone leaves the solution to SOLV')
      return
    end if
    if (run%program%dry) then
      if (abs(command%x(2)) > 0.0_wp) then
        call log_line("note: the line search ends at the fixed ratio 0.8; FEAP's number is ignored")
      end if
      return
    end if
    symmetric = command%record%key(1) == 'tang' .or. .not. is_unsymmetric(run%model)
    call iterate(run, command, .true., symmetric, abs(command%x(1)) > 0.0_wp, error)
  end subroutine run_tangent

  !> Run FORM: compute the forces at the current displacements; the tangent is formed with them.
  subroutine run_form(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 0, 'FORM', error, option=.false.)
    if (allocated(error) .or. run%program%dry) return
    call iterate(run, command, .true., &
                 run%step%newton%symmetric .or. .not. is_unsymmetric(run%model), .false., error)
  end subroutine run_form

  !> Run SOLV: solve the system that the last TANG, UTAN or FORM formed. It is formed again if a
  !! FACTor has come between, which discards the linear system.
  subroutine run_solve(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    character(4), parameter :: FORMS(3) = ['tang', 'utan', 'form']
    !> Commands that begin a step, or that change its loads, its inertia or its contact.
    character(4), parameter :: CHANGES(6) = ['time', 'prop', 'tran', 'mass', 'arcl', 'augm']
    character(:), allocatable :: before
    logical :: lost !! the system has been discarded
    integer :: i

    call check_option(command, error)
    call check_fields(command, 0, 'SOLV,[LINE]', error)
    if (allocated(error)) return
    before = ', and after TIME if there is one'
    do i = run%program%counter - 1, 1, -1
      if (any(run%program%command(i)%record%key(1) == [FORMS, CHANGES])) exit
    end do
    if (i > 0) then
      if (any(run%program%command(i)%record%key(1) == CHANGES)) then
        if (run%program%command(i)%record%key(1) /= 'time') then
          before = ', and after '//trim(run%program%row(run%program%command(i)%row)%word)
        end if
        i = 0
      end if
    end if
    if (i == 0) then
      call fail(error, DECK_ERROR, 'SOLV has no system to solve', command%record%place(1), &
                'put TANG, UTAN or FORM before SOLV'//before)
    else if (.not. run%program%dry) then
      lost = .not. run%step%newton%ready
      call iterate(run, command, lost, run%step%newton%symmetric, .true., error)
    end if
  end subroutine run_solve

  !> Form the system, solve it, or do both, in the current step; a deck without TIME is one step at
  !! t = 0.
  subroutine iterate(run, command, forms, symmetric, solves, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    logical, intent(in) :: forms, symmetric, solves
    type(error_t), allocatable, intent(out) :: error
    integer :: outcome

    outcome = STEP_GOES_ON
    if (forms) then
      if (.not. run%step%open) call open_step_here(run)
      if (symmetric .and. is_unsymmetric(run%model)) then
        run%step%newton%exact = .false.
        if (.not. run%program%noted(command%row)) then
          run%program%noted(command%row) = .true.
          call log_line('note: '//command%record%text(1)//' uses the symmetric part of the ' &
                        //'tangent, UTAN all of it')
        end if
      end if
      call form_pass(run%step, run%model, run%state, symmetric, command%record%place(1), outcome, &
                     error)
      if (allocated(error)) return
    end if
    if (solves) then
      if (outcome == STEP_GOES_ON) then
        run%step%newton%alone = is_alone(run%program)
        call solve_pass(run%step, run%model, run%state, command%option == 'line', &
                        command%record%place(1), outcome, error)
      end if
      associate (pass => run%step%pass)
        associate (asm => run%step%newton%asm)
          call run%timers%add('assembly', asm%seconds - asm%contact_seconds)
          if (size(run%model%contact) > 0) call run%timers%add('contact', asm%contact_seconds)
          asm%seconds = 0.0_wp
          asm%contact_seconds = 0.0_wp
        end associate
        if (pass%solve%factorisations > 0) then
          call run%timers%add('analyse', pass%solve%seconds_analyse)
          call run%timers%add('factorise', pass%solve%seconds_factor)
        end if
        call run%timers%add('solve', pass%solve%seconds_solve)
        if (allocated(error)) return ! the report includes the times of a failed pass
        if (pass%ok) call show_iteration(run)
      end associate
    end if
    call take_outcome(run, outcome, error)
  end subroutine iterate

  !> Is the current command executed once in a step, as in decks of linear problems?
  pure logical function is_alone(program)
    type(program_t), intent(in) :: program

    is_alone = size(program%loop) == 0
    if (is_alone) return
    is_alone = .not. iterates(program, program%loop(size(program%loop))%at)
  end function is_alone

  !> Show an iteration: a line in the log, and on a terminal a line that the next one overwrites.
  subroutine show_iteration(run)
    type(run_t), intent(in) :: run
    character(160) :: line
    character(:), allocatable :: left
    real(wp) :: load, done
    integer :: i, seconds

    associate (state => run%state, iterations => run%step%newton%iterations, pass => run%step%pass)
      if (allocated(pass%solve%storage)) call log_line('note: '//pass%solve%storage)
      if (pass%solve%gave_up_single) then
        call log_line('note: factors in single precision are not accurate enough here; from now ' &
                      //'on they are in double precision')
      end if
      write (line, '(a,i6,a,es12.5,a,i3,3(a,es10.3))') 'step', state%step, '  time', &
        state%time, '  iteration', iterations, '  residual', pass%residual, &
        '  energy', pass%energy, '  ratio', pass%ratio
      if (pass%solve%iterations > 1) line = trim(line)//'  krylov '//to_text(pass%solve%iterations)
      if (pass%line < 1.0_wp) line = trim(line)//'  line '//to_text(pass%line)
      call log_line(trim(line))
      left = '' ! time that is still needed at the same pace
      done = 0.0_wp
      do i = 1, size(run%program%loop)
        associate (loop => run%program%loop(i))
          if (run%program%command(loop%at)%holds_time) done = real(loop%count - 1, wp)/loop%limit
        end associate
      end do
      if (done > 0.0_wp) then
        seconds = nint(min(wall_seconds()*(1.0_wp - done)/done, 1.0e9_wp))
        left = '  left '//to_text(seconds)//' s'
        if (seconds > 600) left = '  left '//to_text(seconds/60)//' min'
      end if
      load = state%time
      if (size(state%factor) > 0) load = sum(state%factor)
      write (line, '(es8.1)') pass%residual
      call progress('step '//to_text(state%step)//'  load '//to_text(load, 5)//'  iteration ' &
                    //to_text(iterations)//'  residual '//trim(adjustl(line))//left)
    end associate
  end subroutine show_iteration

  !> May the tangent of the model be unsymmetric? The mortar scheme has a potential unless there is
  !! friction or bonds.
  pure function is_unsymmetric(model) result(yes)
    type(model_t), intent(in) :: model
    logical :: yes
    integer :: i

    yes = .false.
    do i = 1, size(model%contact)
      yes = yes .or. model%contact(i)%scheme /= MORTAR .or. model%contact(i)%friction%given &
            .or. model%contact(i)%cohesive%given
    end do
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
              'LINE chooses a line search; otherwise leave the field empty, as in TANG,,1')
  end subroutine check_option

  subroutine run_tolerance(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 1, 'TOL,,energy', error, option=command%option == 'ener')
    if (allocated(error)) return
    if (.not. (command%x(1) > 0.0_wp .and. command%x(1) < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'expected a tolerance between 0 and 1, found ' &
                //to_text(command%x(1)), command%record%place(3), 'write TOL,,1.e-16')
      return
    end if
    if (.not. run%program%dry) run%step%newton%tolerance = command%x(1)
    if (run%program%dry .and. command%x(1) > LOOSE) then
      call warn('TOL is '//to_text(command%x(1))//', a ratio of energies: steps may be accepted ' &
                //'in which displacements are wrong by '//to_text(100*sqrt(command%x(1)), 2) &
                //' %, and contact forces by far more', command%record%place(3), &
                'write TOL,,1.e-16, which is the default')
    end if
  end subroutine run_tolerance

  subroutine run_factor(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: mode

    select case (command%option)
    case ('auto')
      mode = AUTO
    case ('full')
      mode = FULL
    case ('reus')
      mode = REUSE
    case ('sing')
      mode = SINGLE
    case ('lowr')
      mode = LOWRANK
    case default
      call fail(error, DECK_ERROR, 'unknown way of solving linear systems', &
                command%record%place(2), 'FACTor AUTO | FULL | REUSe | SINGle | LOWRank eps')
      return
    end select
    call check_fields(command, merge(1, 0, mode == LOWRANK), &
                      trim(run%program%row(command%row)%usage), error)
    if (allocated(error)) return
    if (mode == LOWRANK .and. .not. (command%x(1) > 0.0_wp .and. command%x(1) < 1.0_wp)) then
      call fail(error, DECK_ERROR, 'LOWRank needs an accuracy between 0 and 1, found ' &
                //to_text(command%x(1)), command%record%place(2), 'write FACTor LOWRank 1.e-8')
      return
    end if
    if (.not. run%program%dry) call set_factorisation(run%step%newton, mode, command%x(1))
  end subroutine run_factor

end module command_solve
