!> One time step, from its beginning to its end: begin, iterate, cut back and repeat, close.
!!
!!     begin_step -> form_pass, solve_pass (Newton's iteration, until STEP_CONVERGED) -> close_step
!!
!! If form_pass, solve_pass or the last test of the step fails, cut_step restores the state at the
!! start of the step and chooses another method of continuation or a smaller step. The outcome
!! STEP_REWOUND tells the caller to go back to the command that began the step. If there is nothing
!! left to try, cut_step fails.
module step
  use anchored_newton, only: sum_of_loads
  use base_comm, only: largest
  use base_error, only: error_t, place_t, fail, NO_SOLUTION
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_system, only: stop_requested
  use base_text, only: to_text
  use boundary, only: moved_dofs
  use contact_bond, only: moves_bonds
  use contact_missed, only: follow_gaps
  use contact_pair, only: HALFPASS, MORTAR
  use contact_type, only: SMOOTHING
  use contact_report, only: measure_contacts, find_jump
  use continuation, only: begin_increment, change_method, adapt_method
  use continuation_type, only: PATH_OFF, BY_INERTIA, path_constraint_t, end_trial
  use convergence, only: turns_back
  use edge_contact, only: find_edge_contact, edge_text, keep_edge_contact
  use energy_balance, only: accept_solution
  use energy_growth, only: begin_motion, follow_growth
  use force_rounding, only: follow_rounding
  use friction_limit, only: sliding_text
  use load_jump, only: jump_t, suspect_jump, report_jump
  use model, only: model_t, state_t
  use newton, only: begin_newton, form_system, solve_system, close_newton
  use newton_type, only: pass_t
  use solution_state, only: open_step, restore_step
  use stabilisation, only: end_stabilisation
  use stabilisation_report, only: report_stabilisation
  use step_control, only: set_dt, set_end, accept_time, pass_target, may_halve, cut_time, &
                          whole_step, on_target
  use step_type, only: step_t, STEP_IDLE, STEP_GOES_ON, STEP_CONVERGED, STEP_ACCEPTED, STEP_REWOUND
  use uneven_steps, only: find_uneven
  implicit none
  private
  public :: step_t, STEP_IDLE, STEP_GOES_ON, STEP_CONVERGED, STEP_ACCEPTED, STEP_REWOUND
  public :: change_dt, begin_step, form_pass, solve_pass, cut_step, begin_again, return_to_load, &
            abandon_step, close_step, test_again

  !> A body counts as lost if its displacement in a step is larger than this, relative to the size
  !! of the model plus the largest prescribed displacement.
  real(wp), parameter :: FAR = 2.0_wp
  !> Displacements in a step without TIME that count as none, relative to the largest displacement.
  real(wp), parameter :: AT_REST = 1.0e-6_wp
  !> Number of iterations in which the cells of the mortar scheme still change; these iterations do
  !! not influence the size of the next step.
  integer, parameter :: SETTLING = 2
  integer, parameter :: MOST_SECANT = 3 !! largest number of attempts of a step with secants

contains

  !> Set the distance between targets (DT), counted from the end of the current step. Within a
  !! step it takes effect when the step is closed on its target, because the DT may be executed
  !! again before that.
  subroutine change_dt(step, time, dt)
    type(step_t), intent(inout) :: step
    real(wp), intent(in) :: time, dt

    if (step%open .and. step%timed) then
      step%next_dt = dt
    else
      call set_dt(step%control, time, dt)
    end if
  end subroutine change_dt

  !> Set the distance between targets that a DT in the current step has given, if the step has
  !! reached its target.
  pure subroutine take_next_dt(step, time)
    type(step_t), intent(inout) :: step
    real(wp), intent(in) :: time

    if (.not. step%next_dt > 0.0_wp) return
    if (step%control%automatic .and. .not. on_target(step%control)) return
    call set_dt(step%control, time, step%next_dt)
    step%control%target = -step%control%passed ! accept_time or pass_target adds them
  end subroutine take_next_dt

  !> Begin a step; rewind_step can restore the state as it is now.
  subroutine begin_step(step, model, state, left)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in), optional :: left !! targets that remain in the loop over time, including
    !! this one; absent: a step without TIME, in which no time passes

    step%start_step = state%step
    step%start_time = state%time
    step%start_iterations = step%total%iterations
    step%start_held = step%newton%hold%active
    step%start_fell = step%newton%hold%fell
    step%open = .true.
    step%solved = .false.
    step%next_dt = 0.0_wp
    step%timed = present(left)
    if (.not. (step%retry .and. step%timed)) then
      step%cutbacks = 0
      step%secant_attempts = 0
      step%secant = .false.
      step%exhausted = .false.
    end if
    step%retry = .false.
    if (present(left)) then
      step%loop_end = step%control%origin + (step%control%target + left)*step%control%dt
      call begin_increment(step, model, state, left)
    else
      step%newton%constraint = path_constraint_t() ! that of the last step with TIME
      call open_step(state, state%time)
    end if
    call begin_newton(step%newton, model, step%timed .and. step%cutbacks == 0, step%secant)
  end subroutine begin_step

  !> Form forces and tangent at the current displacements.
  subroutine form_pass(step, model, state, symmetric, place, outcome, error)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: symmetric     !! form only the symmetric part of the tangent
    type(place_t), intent(in) :: place   !! place to name in the error if no attempt succeeds
    integer, intent(out) :: outcome      !! STEP_GOES_ON or STEP_REWOUND
    type(error_t), allocatable, intent(out) :: error

    outcome = STEP_GOES_ON
    step%pass = pass_t()
    call form_system(step%newton, model, state, symmetric, step%pass, error)
    if (allocated(error) .or. step%pass%ok) return
    call cut_step(step, model, state, step%pass%trouble, place, error)
    outcome = STEP_REWOUND
  end subroutine form_pass

  !> Solve the last formed system and move the displacements.
  subroutine solve_pass(step, model, state, searches, place, outcome, error)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: searches      !! use a line search
    type(place_t), intent(in) :: place
    integer, intent(out) :: outcome      !! STEP_GOES_ON, STEP_CONVERGED or STEP_REWOUND
    type(error_t), allocatable, intent(out) :: error

    outcome = STEP_REWOUND
    step%searches = searches
    call solve_system(step%newton, model, state, searches, step%pass, error)
    do while (.not. allocated(error) .and. step%pass%ok .and. step%newton%secant%on)
      if (largest(merge(1, 0, stop_requested())) > 0) exit
      call form_system(step%newton, model, state, step%newton%symmetric, step%pass, error)
      if (allocated(error) .or. .not. step%pass%ok) exit
      step%pass%short = step%pass%short + 1
      call solve_system(step%newton, model, state, searches, step%pass, error)
    end do
    if (allocated(error)) return
    if (.not. step%pass%ok) then
      call cut_step(step, model, state, step%pass%trouble, place, error)
      return
    end if
    step%solved = .true.
    step%total%iterations = step%total%iterations + 1 + step%pass%short
    if (step%newton%constraint%on) then  ! the end of the step is known only now
      call set_end(step%control, state%time, step%newton%constraint%at_limit)
    end if
    outcome = merge(STEP_CONVERGED, STEP_GOES_ON, step%newton%converged)
  end subroutine solve_pass

  !> The step has failed: restore the state at its start, and choose another method or a smaller
  !! step for the next attempt. If there is none, this is an error.
  subroutine cut_step(step, model, state, why, place, error)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    character(*), intent(in) :: why
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    logical :: possible

    possible = .false.
    if (step%pass%hopeless .and. .not. (step%continuation%given .and. &
                                        step%continuation%method /= PATH_OFF)) then
      call fail_step(step, model, state, why, place, error)
      return
    end if
    if (step%timed .and. step%control%automatic) possible = change_method(step, model, state, why)
    if (possible) then
      step%secant = .false.
    else
      call choose_attempt(step, model, state, why, possible)
    end if
    if (.not. possible) then
      call fail_step(step, model, state, why, place, error)
      return
    end if
    call rewind_step(step, state)
    step%retry = .true.
  end subroutine cut_step

  !> Choose the next attempt of a step under load control: a smaller step or secants of friction.
  !!
  !! Secants are tried for the first time when a step has been cut to dtmin without them. In later
  !! steps, each step size is tried first without and then with secants; a step makes at most
  !! MOST_SECANT attempts with secants.
  subroutine choose_attempt(step, model, state, why, possible)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(*), intent(in) :: why
    logical, intent(out) :: possible
    character(:), allocatable :: how
    logical :: may_try

    how = ''
    may_try = can_use_secants(step, model) .and. step%secant_attempts < MOST_SECANT
    possible = may_try .and. step%needs_secant .and. .not. step%secant
    if (possible) then
      step%secant = .true.
    else
      if (step%timed .and. .not. (step%exhausted .and. .not. may_try)) then
        possible = cut_time(step%control)
      end if
      step%secant = step%exhausted .and. may_try
      if (.not. possible .and. may_try .and. .not. step%exhausted) then
        step%needs_secant = .true.
        step%exhausted = .true.
        step%secant = .true.
        possible = .true.
        call whole_step(step%control)
      end if
    end if
    if (.not. possible) return
    if (step%secant) then
      step%secant_attempts = step%secant_attempts + 1
      how = ' and secants of friction'
    end if
    call report_cutback(step, state, why, how)
  end subroutine choose_attempt

  !> The step has converged, but to a doubtful state: repeat it in halves.
  subroutine halve_step(step, state, why)
    type(step_t), intent(inout) :: step
    type(state_t), intent(inout) :: state
    character(*), intent(in) :: why
    logical :: possible

    possible = cut_time(step%control)
    if (possible) call report_cutback(step, state, why, '')
    call rewind_step(step, state)
    step%retry = .true.
  end subroutine halve_step

  !> Count a cut-back, and log it.
  subroutine report_cutback(step, state, why, how)
    type(step_t), intent(inout) :: step
    type(state_t), intent(in) :: state
    character(*), intent(in) :: why
    character(*), intent(in) :: how      !! what else is changed in the next attempt

    step%cutbacks = step%cutbacks + 1
    step%total%cutbacks = step%total%cutbacks + 1
    call log_line('  step '//to_text(state%step)//' is cut back: '//why//'; the next attempt ' &
                  //'has dt = '//to_text(step%control%size)//how)
  end subroutine report_cutback

  !> Can secants of friction help? They need friction, and a step whose time is given.
  pure logical function can_use_secants(step, model)
    type(step_t), intent(in) :: step
    type(model_t), intent(in) :: model

    can_use_secants = step%timed .and. step%control%automatic .and. &
                      any(model%contact%friction%given) .and. .not. step%newton%constraint%on
  end function can_use_secants

  !> Restore the state at the start of the current step, and forget the step.
  subroutine rewind_step(step, state)
    type(step_t), intent(inout) :: step
    type(state_t), intent(inout) :: state

    call restore_step(state, step%start_step, step%start_time)
    step%open = .false.
    step%solved = .false.
  end subroutine rewind_step

  !> Begin the current step again if nothing was solved in it: its loads or its inertia have
  !! changed, and FORM or TANG may already have found its prescribed motion.
  subroutine begin_again(step, model, state)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: left
    real(wp) :: next

    if (.not. step%open .or. step%solved) return
    next = step%next_dt
    call rewind_step(step, state)
    step%retry = .true. ! it is the same attempt
    if (step%timed) then
      left = nint((step%loop_end - step%control%origin)/step%control%dt) - step%control%target
      call begin_step(step, model, state, left)
    else
      call begin_step(step, model, state)
    end if
    step%next_dt = next
  end subroutine begin_again

  !> Return to load control: end the control of the arc length or of the release of bonds, and the
  !! inertia of the continuation. A step that has begun, but in which nothing was solved, begins
  !! again.
  subroutine return_to_load(step, model, state)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state

    if (step%continuation%active == BY_INERTIA) state%dynamics%on = .false.
    call end_trial(step%continuation)
    if (.not. step%newton%constraint%on) return
    step%newton%constraint = path_constraint_t()
    call begin_again(step, model, state)
  end subroutine return_to_load

  !> Forget the current step when a run is stopped, and undo what the step has set: a restarted run
  !! begins the step again, and counts iterations and cut-backs as if the run had not been stopped.
  subroutine abandon_step(step, state)
    type(step_t), intent(inout) :: step
    type(state_t), intent(inout) :: state

    call rewind_step(step, state)
    step%total%iterations = step%start_iterations
    step%newton%hold%active = step%start_held
    step%newton%hold%fell = step%start_fell
    step%retry = step%cutbacks > 0
  end subroutine abandon_step

  !> Make the error of a step that cannot be cut back any further, with a hint that says what may
  !! help.
  subroutine fail_step(step, model, state, why, place, error)
    type(step_t), intent(in) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(*), intent(in) :: why
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: cuts, hint, slides
    real(wp) :: ahead

    slides = ''
    if (allocated(step%newton%asm%f_ext) .and. allocated(step%newton%hold%body) .and. &
        .not. (step%pass%hopeless .or. state%dynamics%on)) then
      ahead = state%time
      if (step%timed .and. .not. step%newton%constraint%on) ahead = step%loop_end
      slides = sliding_text(model, state, step%newton%hold%body, step%newton%asm%f_ext, ahead)
    end if
    associate (pass => step%pass, ncut => step%cutbacks)
      cuts = ''
      if (ncut > 0) cuts = ' after '//to_text(ncut)//trim(merge(' cut-back ', ' cut-backs', &
                                                                ncut == 1))
      hint = usual_hint(step, model)
      if (.not. step%newton%exact) then
        hint = 'TANG leaves out the unsymmetric part of the tangent: use UTAN,,1; '//hint
      end if
      if (turns_back(step%newton)) then
        hint = 'Newton''s iteration alternates between two states of contact whose tangents have ' &
               //'determinants of opposite sign: the load path turns back here, so that ' &
               //'smaller steps do not help, but a softer penalty may'
      end if
      if (pass%solve%singular .or. pass%hopeless) then
        hint = 'support the model: FIX or MOVE for patches; BOUN, EBOU or CBOU for nodes'
        if (.not. pass%solve%singular) then
          hint = hint//'; or check the faces of the contacts'
          if (.not. all(model%contact%friction%given)) hint = hint//', or add friction'
        end if
      end if
      if (len(slides) > 0) then
        hint = 'support the body against this motion with FIX or MOVE, or give a larger ' &
               //'coefficient of friction; smaller steps do not help near and beyond the load ' &
               //'that friction can bear'
        slides = '; '//slides
      end if
    end associate
    call fail(error, NO_SOLUTION, 'step '//to_text(state%step)//' failed'//cuts//': '//why &
              //slides, place, hint)
  end subroutine fail_step

  !> Hint for a step that does not converge: smaller steps, and what may help where points open and
  !! close in turn, unless the deck has it already.
  function usual_hint(step, model) result(hint)
    type(step_t), intent(in) :: step
    type(model_t), intent(in) :: model
    character(:), allocatable :: hint, remedies

    hint = ''
    associate (pass => step%pass)
      if (pass%worst(2) > 0) then
        hint = 'residual '//to_text(pass%residual)//', largest at node '//to_text(pass%worst(2)) &
               //', dof u'//'xyz' (pass%worst(1):pass%worst(1))//'; '
      end if
    end associate
    hint = hint//'smaller steps may help: '
    if (.not. step%timed) then
      hint = hint//'apply the loads in steps (PROP, DT and a loop with TIME)'
      if (.not. step%control%automatic) hint = hint//' with AUTO,,dtmin,dtmax'
    else
      hint = hint//'AUTO,,dtmin,dtmax'
      if (step%control%automatic) hint = hint//' with a smaller dtmin'
    end if
    if (size(model%contact) == 0 .or. step%cutbacks < 2) return
    remedies = ''
    if (any(model%contact%scheme == HALFPASS)) remedies = ', or remove SCHEme HALFpass'
    if (.not. step%searches) remedies = remedies//', or use UTAN,LINE,1'
    if (.not. all(model%contact%normal%prop(SMOOTHING) > 0.0_wp)) then
      remedies = remedies//', or use NORMal ... SMOOth d'
    end if
    if (len(remedies) == 0) remedies = ', or use a softer penalty'
    hint = hint//'; if contact points open and close in turn at an edge or where the gap is ' &
           //'zero, no step is small enough: '//remedies(len(', or ') + 1:)
  end function usual_hint

  !> Close the current step, if any: test it once more, then accept it or cut it back.
  subroutine close_step(step, model, state, place, outcome, error)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(place_t), intent(in) :: place
    integer, intent(out) :: outcome      !! STEP_IDLE, STEP_ACCEPTED or STEP_REWOUND
    type(error_t), allocatable, intent(out) :: error
    type(pass_t) :: pass
    type(jump_t) :: jump
    real(wp), allocatable :: share(:)    ! see find_edge_contact
    integer :: found, iterations

    outcome = STEP_IDLE
    if (.not. step%open) return
    step%open = .false.
    if (.not. step%solved) then          ! nothing was solved: there is no step to accept
      if (step%timed .and. step%newton%constraint%on) then
        state%time = step%control%to     ! time passes nevertheless
        call set_end(step%control, state%time, on_target=.true.)
      end if
      call restore_step(state, step%start_step, state%time)
      if (step%timed) call take_next_dt(step, state%time)
      if (step%timed) call accept_time(step%control, 0)
      if (step%timed) call warn_lost_time(model, state, place, step%total%lost_time)
      return
    end if

    call close_newton(step%newton, model, state, pass, error)
    if (allocated(error)) return
    if (pass%ok) call find_trouble(step, model, state, pass)
    if (.not. pass%ok) then
      call cut_step(step, model, state, pass%trouble, place, error)
      outcome = STEP_REWOUND
      return
    end if
    call find_edge_contact(step%newton%asm, model, state, share, found)
    if (found > 0 .and. step%timed .and. .not. step%newton%constraint%on) then
      if (may_halve(step%control)) then
        call halve_step(step, state, edge_text(model, found, share(found)))
        outcome = STEP_REWOUND
        return
      end if
    end if

    if (.not. step%newton%converged) then
      step%total%unconverged = .true.
      call warn('step '//to_text(state%step)//' was closed before it converged: residual ' &
                //to_text(pass%residual)//', largest nodal force '//to_text(pass%sweep%largest), &
                hint='use more iterations or, in a loop with TIME, AUTO,,dtmin,dtmax; the run ' &
                //'will end with code 2')
    end if
    if (.not. step%newton%constraint%on) call check_stability(step, model, state)
    associate (asm => step%newton%asm)
      call report_stabilisation(step%newton%hold, model, state, asm%f_ext, asm%anchors, &
                                sum_of_loads(step%newton, model, state))
    end associate
    call follow_rounding(step, model, state, pass)
    step%total%inertia = step%total%inertia .or. state%dynamics%on
    if (.not. (step%total%jumped .or. step%reloaded)) then
      call suspect_jump(step%newton, model, state, jump)
    end if
    call find_uneven(model, state, step%total%uneven)
    call warn_still(state, place, step%total%still)
    call warn_untimed(model, state, step%total%untimed)
    call begin_motion(step%newton%asm, model, state)
    call accept_solution(step%newton%asm, model, state)
    call follow_growth(model, state)
    if (jump%suspected) call report_jump(jump, model, state, step%total%jumped)
    call measure_contacts(model, state, step%total%load)
    call keep_edge_contact(model, state, share, found)
    call follow_gaps(model, state)
    if (step%timed) call take_next_dt(step, state%time)
    if (step%timed .and. step%newton%constraint%on) then
      call pass_target(step%control)
    else if (step%timed) then
      iterations = step%newton%iterations - step%newton%before - step%newton%secant%count
      call accept_time(step%control, iterations - merge(SETTLING, 0, &
                                                        any(model%contact%scheme == MORTAR)))
      if (step%control%reduced) then
        call log_line('  step '//to_text(state%step)//' took '//to_text(iterations) &
                      //' iterations: the next one has at most dt = '//to_text(step%control%size))
      end if
    end if
    call adapt_method(step, model, state, pass%sweep%largest)
    call end_stabilisation(step%newton%hold)
    step%solved = .false.
    outcome = STEP_ACCEPTED
  end subroutine close_step

  !> Test whether the last solve of a step has reached convergence, as closing the step would.
  subroutine test_again(step, model, state, error)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(pass_t) :: pass

    call close_newton(step%newton, model, state, pass, error)
    if (.not. pass%ok) step%newton%converged = .false.
  end subroutine test_again

  !> Warn once if a TIME without a solve passes in a model whose forces depend on the length of the
  !! step. The state does not change, so that motions and bonds go on as if no time had passed.
  subroutine warn_lost_time(model, state, place, warned)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(place_t), intent(in) :: place
    logical, intent(inout) :: warned

    if (warned .or. .not. (state%dynamics%on .or. any(model%contact%cohesive%tau > 0.0_wp))) return
    warned = .true.
    call warn('a TIME without a solve has passed: loads take the new time, but inertia and ' &
              //'VISCous know only the DT of each step that is solved, so the time before it is ' &
              //'lost', place, 'let TANG or UTAN follow each TIME, or use a larger DT')
  end subroutine warn_lost_time

  !> Warn once if a motion (TRANsient) goes on after a step without TIME that has moved bodies: this
  !! step was a static solve, and their velocities are those before it. Static steps before and
  !! after a motion may be meant.
  subroutine warn_still(state, place, warned)
    type(state_t), intent(in) :: state
    type(place_t), intent(in) :: place
    logical, intent(inout) :: warned
    real(wp) :: moved

    associate (dynamics => state%dynamics)
      if (warned .or. .not. dynamics%on .or. dynamics%density >= 0.0_wp) return
      if (state%last_dt > 0.0_wp .or. .not. state%dt > 0.0_wp) return
      if (.not. any(abs(dynamics%v) > 0.0_wp)) return
    end associate
    moved = maxval(abs(state%last_increment))
    if (moved <= AT_REST*maxval(abs(state%u_step))) return
    warned = .true.
    call warn('the motion of TRANsient goes on after step '//to_text(state%step - 1)//', which ' &
              //'was solved without TIME: that step had no inertia and moved bodies to static ' &
              //'equilibrium, but they keep the velocities that they had before it', place, &
              'let TIME begin each step of the motion; write TRANsient,OFF before a static step ' &
              //'if the bodies are to start from rest after it')
  end subroutine warn_still

  !> Warn once if bonds with VISCous move in a step in which time does not increase. Their traction
  !! is then that of the law without VISCous, because there is no rate.
  subroutine warn_untimed(model, state, warned)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(inout) :: warned
    integer :: c

    if (warned .or. state%dt > 0.0_wp) return
    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        if (.not. contact%cohesive%tau > 0.0_wp) cycle
        if (.not. moves_bonds(contact, state%contact(c))) cycle
        warned = .true.
        call warn("contact '"//contact%name//"': VISCous has no effect in step " &
                  //to_text(state%step)//', in which bonds open or close although no time passes', &
                  contact%place, 'let TIME begin each step that loads bonds: DT,,dt and a loop ' &
                  //'with TIME')
        return
      end associate
    end do
  end subroutine warn_untimed

  !> Find a reason why a step cannot be accepted although no solve of it failed.
  subroutine find_trouble(step, model, state, pass)
    type(step_t), intent(in) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(pass_t), intent(inout) :: pass

    if (step%control%automatic) then
      if (flies_off(model, state)) then
        pass%trouble = 'a body that nothing holds has moved far away'
      else if (.not. step%newton%converged) then
        pass%trouble = 'no convergence'
      end if
    end if
    if (.not. allocated(pass%trouble)) call find_jump(model, state, pass%trouble)
    pass%ok = .not. allocated(pass%trouble)
  end subroutine find_trouble

  !> In a model with contact, has a node moved in this step farther than twice the sum of the size
  !! of the model and the largest prescribed displacement? A body that is held neither by contact
  !! nor by bonds is in equilibrium anywhere, so the new positions of its nodes have no meaning.
  !! Only inertia determines the motion of such a body.
  pure logical function flies_off(model, state) result(yes)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp) :: extent, prescribed

    yes = size(model%contact) > 0
    if (.not. yes) return
    extent = maxval(maxval(model%mesh%xr, 2) - minval(model%mesh%xr, 2))
    associate (du => state%u - state%u_step)
      prescribed = max(0.0_wp, maxval(abs(du), mask=model%bc%fixed /= 0 .or. &
                                      moved_dofs(model%bc, model%mesh%nnode)))
      yes = maxval(abs(du)) > FAR*(extent + prescribed)
    end associate
  end function flies_off

  !> Report a converged state on an unstable branch: by a warning the first time, later by a line in
  !! the log.
  subroutine check_stability(step, model, state)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable :: text, causes
    integer :: negative

    associate (pass => step%pass, total => step%total)
      if (.not. pass%solve%signed) return
      negative = pass%solve%negative + pass%sweep%negative
      text = to_text(negative)//trim(merge(' negative pivot ', ' negative pivots', negative == 1))
      if (negative == 0 .and. .not. step%newton%symmetric .and. pass%solve%determinant < 0) then
        negative = 1
        text = 'the determinant of the tangent is negative'
      end if
      if (negative > 0 .and. total%negative_pivots == 0) then
        text = 'step '//to_text(state%step)//' converged to an unstable state: '//text
        if (total%unstable) then
          call log_line(text)
        else
          causes = 'buckling, a limit point'
          if (any(model%mesh%block%row%nmode > 0)) then
            causes = 'hourglassing of elements with enhanced modes in compression, '//causes
          end if
          call warn(text//'; later unstable states are reported only in the log', &
                    hint='possible causes: '//causes//'; look at the deformed shape')
        end if
        total%unstable = .true.
      end if
      total%negative_pivots = negative
    end associate
  end subroutine check_stability

end module step
