!> Newton's iteration: forms the system, solves it, and performs the last test of a step.
module newton
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use anchored_newton, only: renew_anchors, solve_anchored, loads_of, sum_of_loads
  use anchors, only: anchors_t
  use anderson, only: accelerate, accelerate_slow, forget, restart
  use approach, only: approach_surface
  use assembly, only: assembler_t, sweep_t, new_assembler, set_aside, take_back, form, free_part, &
                      full_vector
  use base_error, only: error_t
  use base_kinds, only: wp
  use common_turn, only: turn_together
  use constrained_newton, only: solve_constrained
  use contact_assembly, only: begin_contact, set_secant, set_patience, overlap_found, &
                              overlap_accepted, has_followed, has_stale_cells
  use continuation_type, only: turns_away
  use convergence, only: check_convergence, energy_tolerance, force_tolerance, &
                         find_largest_residual, node_spacing, find_floor, needs_line_search, &
                         needs_signs, find_forcing, damping, count_flips, has_lost_balance
  use csr, only: multiply
  use failure_text, only: name_element, name_singularity
  use line_search, only: search_line, step_by, retreat
  use linear_system, only: new_linear_system, change_pattern
  use model, only: model_t, state_t
  use newton_type, only: newton_t, pass_t
  use predictor, only: predict
  use prescribed, only: to_prescribed
  use secant_friction, only: begin_secant, adapt_secant
  use solution_state, only: accept_iteration
  use stabilisation, only: begin_stabilisation, find_unheld, use_springs, find_flight, &
                           release_loaded, find_reach, add_springs, remove_springs, &
                           spring_energy, note_move, is_lost, is_restless
  use stabilisation_report, only: lost_text
  implicit none
  private
  public :: newton_t, pass_t, begin_newton, prepare_newton, set_factorisation, form_system, &
            solve_system, close_newton

  integer, parameter :: MOST_HALVINGS = 6   !! largest number of halvings of a prescribed increment
  !> A prescribed or predicted motion is too long if it makes surfaces overlap by more than this
  !! fraction of a facet, and by more than DEEPER times as much as before.
  real(wp), parameter :: DEEP = 0.1_wp, DEEPER = 2.0_wp
  !> The energy of the springs of `stabilisation` in an increment is negligible if it is smaller
  !! than this, relative to the total energy of the increment.
  real(wp), parameter :: NO_ENERGY = 1.0e-3_wp
  real(wp), parameter :: MANY_TIMES = 4.0_wp !! allowed ratio of increment and prescribed motion

contains

  !> Begin a step. Displacements do not change before its first forces are formed.
  subroutine begin_newton(newton, model, predicts, secant)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    logical, intent(in) :: predicts          !! the step may start from predicted displacements
    logical, intent(in) :: secant            !! the step uses secants of friction

    newton%iterations = 0
    newton%before = 0
    call restart(newton%past)
    call begin_secant(newton%secant, secant .and. .not. newton%constraint%on)
    if (allocated(newton%asm%contact)) then
      call begin_contact(newton%asm%contact)
      call set_secant(newton%asm%contact, newton%secant%tangent)
    end if
    newton%has_moved = .false.
    newton%converged = .false.
    newton%exact = .true.
    newton%may_retreat = .false.
    newton%largest_energy = 0.0_wp
    newton%least_residual = huge(1.0_wp)
    newton%stalls = 0
    newton%first_energy = 0.0_wp
    newton%before_solve = 0.0_wp
    newton%expected = 0.0_wp
    newton%sign = 0
    newton%flips = 0
    call begin_stabilisation(newton%hold, model)
    newton%asm%anchors = anchors_t()
    newton%moves = .false.
    newton%predicted = .false.
    newton%begins = .true.
    ! do not continue moves of bodies towards a contact
    newton%predicts = predicts .and. .not. (secant .or. newton%constraint%on .or. &
                                            newton%hold%active)
  end subroutine begin_newton

  !> Before the first forces of a step are formed, find its prescribed motion, and predict the
  !! displacements, or turn the bodies with their supports: state%u is that at the start of the
  !! step, state%factor and state%time are those at its end, which PROP may have changed since the
  !! step began.
  subroutine begin_move(newton, model, state)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state

    newton%begins = .false.
    if (.not. allocated(newton%move)) allocate (newton%move(3, model%mesh%nnode))
    call to_prescribed(model, state%factor, state%u, newton%move)
    newton%moves = any(abs(newton%move) > 0.0_wp)
    if (newton%predicts) then
      call predict(model, state, newton%move, newton%piece, newton%predicted)
      newton%moves = newton%moves .and. .not. newton%predicted
    end if
    if (.not. newton%moves .or. newton%constraint%on .or. state%dynamics%on) return
    call turn_together(model, state, newton%move, newton%predicted)
  end subroutine begin_move

  !> Form forces and tangent at the current displacements; the trial history becomes that of this
  !! iteration.
  subroutine form_system(newton, model, state, symmetric, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: symmetric
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error

    call prepare_newton(newton, model, state%step, symmetric, error)
    if (allocated(error)) return
    if (newton%begins) call begin_move(newton, model, state)
    call set_patience(newton%asm%contact, patient=.not. newton%hold%used)
    call form(newton%asm, model, state, pass%sweep, error)
    if (allocated(error)) return
    if (newton%predicted) call check_prediction(newton, model, state, pass%sweep, error)
    if (allocated(error)) return
    if (newton%has_moved .and. is_too_far(newton, pass%sweep)) then
      call move_less(newton, model, state, pass%sweep, error)
      if (allocated(error)) return
    end if
    newton%has_moved = .false.
    if (newton%may_retreat) then
      call retreat(newton%asm, model, state, newton%dx, newton%rhs, pass%sweep, error)
      if (allocated(error)) return
      newton%last = state%scale*newton%dx
    end if
    newton%may_retreat = .false.
    pass%ok = pass%sweep%ok
    if (.not. pass%ok) then
      pass%trouble = name_element(model, pass%sweep)
      return
    end if
    call accept_iteration(state)
    newton%overlap = overlap_found(newton%asm%contact)
    pass%floor = find_floor(newton%asm%k, newton%spacing, state%u)
    state%reaction = newton%asm%f_int - newton%asm%f_ext
    call free_part(model%eq, -state%reaction, newton%rhs)
    call find_largest_residual(model, state%reaction, pass)
    if (.not. ieee_is_finite(pass%residual)) then
      pass%ok = .false.
      pass%trouble = 'the residual is not a number'
    end if
  end subroutine form_system

  !> Has a prescribed or predicted motion inverted an element, or pushed surfaces too deep into each
  !! other? The contact forces of such a penetration are so large that the next increment often
  !! leaves the range in which Newton's iteration converges.
  pure logical function is_too_far(newton, sweep) result(yes)
    type(newton_t), intent(in) :: newton
    type(sweep_t), intent(in) :: sweep

    yes = .not. sweep%ok
    if (.not. yes) yes = overlap_found(newton%asm%contact) > max(DEEP, DEEPER*newton%overlap)
  end function is_too_far

  !> Find the energy of the step from the forces at the predicted displacements. If the prediction
  !! goes too far, return to the displacements at the start of the step.
  subroutine check_prediction(newton, model, state, sweep, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(sweep_t), intent(inout) :: sweep
    type(error_t), allocatable, intent(out) :: error

    newton%predicted = .false.
    newton%overlap = overlap_accepted(newton%asm%contact, state)
    if (.not. is_too_far(newton, sweep)) then
      newton%largest_energy = abs(sum((state%u - state%u_step) &
                                      *(newton%asm%f_int - newton%asm%f_ext - state%reaction)))
    else
      state%u = state%u_step
      state%u_base = state%u_step
      call to_prescribed(model, state%factor, state%u, newton%move)
      newton%moves = any(abs(newton%move) > 0.0_wp)
      call form(newton%asm, model, state, sweep, error)
    end if
  end subroutine check_prediction

  !> If the increment with the prescribed motion goes too far, take only a part of it, and leave the
  !! rest of the motion to the next iterations.
  subroutine move_less(newton, model, state, sweep, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(sweep_t), intent(inout) :: sweep
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: du(:, :)
    integer :: i

    allocate (du, source=(state%u - state%u_base)/state%scale)
    do i = 1, MOST_HALVINGS
      if (.not. is_too_far(newton, sweep)) exit
      call step_by(state, du, 0.5_wp*state%scale)
      call form(newton%asm, model, state, sweep, error)
      if (allocated(error)) return
    end do
    if (.not. sweep%ok) return
    newton%move = (1.0_wp - state%scale)*newton%moved
    newton%moves = .true.
    newton%last = state%scale*newton%dx
  end subroutine move_less

  !> Solve for the increment of the last formed system and add it.
  subroutine solve_system(newton, model, state, searches, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: searches    !! use a line search
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: du(:, :)
    logical :: loaded, moved

    if (newton%constraint%on) then
      call take_pattern(newton, model, error)
      if (allocated(error)) return
      call solve_constrained(newton, model, state, find_forcing(newton, pass), pass, error)
      return
    end if
    call solve_held(newton, model, state, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    moved = newton%moves
    newton%iterations = newton%iterations + 1
    call count_flips(newton, merge(0, pass%solve%determinant, &
                                   newton%symmetric .or. newton%secant%on .or. &
                                   .not. pass%solve%signed))
    newton%before_solve = merge(0.0_wp, pass%residual, moved)
    newton%expected = newton%forcing*maxval(abs(newton%rhs))
    call find_increment(newton, model, moved, du, pass)
    newton%has_moved = moved
    if (moved) newton%moved = newton%move
    newton%moves = .false.
    call check_convergence(newton, pass, moved)
    if (.not. pass%ok) return
    if (newton%secant%on) newton%converged = .false.
    if (newton%converged) then
      call newton%system%find_signs(newton%asm%k, pass%solve, error)
      if (.not. allocated(error)) call name_trouble(model, state, pass)
      if (allocated(error) .or. .not. pass%ok) return
      call release_loaded(newton%hold, model, state, newton%asm%anchors, &
                          sum_of_loads(newton, model, state), loaded)
      newton%converged = .not. loaded
    end if
    if (newton%secant%on) then
      if (.not. moved .and. newton%secant%count > 1) then
        call accelerate(newton%secant%past, newton%dx)
        call full_vector(model%eq, newton%dx, du)
      end if
      call step_by(state, du, 1.0_wp)
    else if ((searches .or. needs_line_search(newton, model)) .and. .not. moved) then
      call search_line(newton%asm, model, state, newton%dx, du, &
                       dot_product(newton%dx, newton%rhs), pass%line, error)
    else
      ! a fraction of an increment would lose the rest of its prescribed motion
      if (size(model%contact) > 0 .and. .not. moved) pass%line = damping(newton)
      if (has_followed(newton%asm%contact) .and. pass%line >= 1.0_wp .and. .not. moved) then
        call accelerate_slow(newton%past, newton%dx)
        call full_vector(model%eq, newton%dx, du)
      else
        call forget(newton%past)
      end if
      call step_by(state, du, pass%line)
    end if
    newton%last = pass%line*newton%dx
    newton%may_retreat = .not. (moved .or. newton%converged .or. newton%secant%on)
  end subroutine solve_system

  !> If the tangent has a new pattern, pass it to the linear system.
  subroutine take_pattern(newton, model, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(error_t), allocatable, intent(out) :: error

    if (.not. newton%asm%new_pattern) return
    call change_pattern(newton%system, newton%asm%k, model%eq, error)
    if (allocated(error)) return
    newton%asm%new_pattern = .false.
  end subroutine take_pattern

  !> Solve the system. As long as bodies "fly", which means that contact does not hold them yet,
  !! move them, and form and solve the system again.
  subroutine solve_held(newton, model, state, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: du(:, :)
    real(wp) :: reach, s
    logical :: loaded

    associate (hold => newton%hold)
      if (size(hold%body) > 0) allocate (du(3, model%mesh%nnode))
      do
        call take_pattern(newton, model, error)
        if (allocated(error)) return
        call find_unheld(hold, model, state, newton%asm%k, newton%secant%tangent)
        loaded = .false.
        if (hold%springs) then
          call find_flight(hold, model, state, loads_of(newton, state), force_tolerance(pass), &
                           sum_of_loads(newton, model, state), du, loaded)
        end if
        call renew_anchors(newton, model, state, loaded)
        if (loaded) then
          call approach_surface(hold%body, model, state, du, hold%fell)
          du = du/sqrt(maxval(sum(du**2, 1)))
          call free_part(model%eq, du, newton%dx)
          call find_reach(hold, model, state, du, reach)
          s = reach
        else
          call solve_tangent(newton, model, state, pass, error)
          if (allocated(error) .or. .not. pass%ok) return
          if (.not. hold%springs) return
          call find_fraction(newton, model, state, du, s)
          if (.not. s < 1.0_wp) return
          pass%short = pass%short + 1
        end if
        call fly(newton, model, state, du, s, loaded, pass, error)
        if (allocated(error) .or. .not. pass%ok) return
      end do
    end associate
  end subroutine solve_held

  !> Take the fraction s of an increment in which bodies "fly", and form the system there.
  subroutine fly(newton, model, state, du, s, rigid, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: du(:, :)     !! (3, nnode) [L]
    real(wp), intent(in) :: s
    logical, intent(in) :: rigid         !! du is a translation, not a solution of the system
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: before(:, :)

    if (is_lost(newton%hold, model) .or. is_restless(newton%hold)) then
      pass%ok = .false.
      ! a smaller step may help if an increment of Newton's iteration has led past a contact
      pass%hopeless = is_lost(newton%hold, model) .and. newton%iterations == 0 &
                      .and. .not. any(model%contact(:)%friction%given)
      pass%trouble = lost_text(newton%hold)
      return
    end if
    allocate (before, source=state%u)
    newton%has_moved = newton%moves .and. .not. rigid
    newton%may_retreat = .not. (newton%moves .or. rigid)
    if (newton%has_moved) then
      newton%moved = newton%move
      newton%move = (1.0_wp - s)*newton%moved
    end if
    call step_by(state, du, s)
    newton%last = s*newton%dx
    call form_system(newton, model, state, newton%symmetric, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    call note_move(newton%hold, state%u - before)
  end subroutine fly

  !> Find the fraction of an increment that may be taken while stabilising springs are in the
  !! tangent. The fraction is one, unless the increment is mainly a motion that only the springs
  !! resist.
  subroutine find_fraction(newton, model, state, du, s)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: du(:, :)    !! (3, nnode) the increment [L]
    real(wp), intent(out) :: s
    real(wp), allocatable :: force(:, :)
    real(wp) :: energy, longest, reach

    call full_vector(model%eq, newton%dx, du)
    if (newton%moves) du = du + newton%move
    s = 1.0_wp
    allocate (force(3, model%mesh%nnode))
    call multiply(newton%asm%k, du, force)
    energy = spring_energy(newton%hold, newton%asm%k, du)
    if (energy <= NO_ENERGY*abs(sum(du*force))) return
    longest = sqrt(maxval(sum(du**2, 1)))
    if (newton%moves .and. longest <= MANY_TIMES*maxval(abs(newton%move))) return
    call find_reach(newton%hold, model, state, du, reach)
    if (longest > reach) s = reach/longest
  end subroutine find_fraction

  !> Find the increment of all dofs, and update the largest energy of an increment in this step.
  subroutine find_increment(newton, model, moved, du, pass)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    logical, intent(in) :: moved       !! the increment contains prescribed motion
    real(wp), allocatable, intent(out) :: du(:, :) !! (3, nnode) [L]
    type(pass_t), intent(inout) :: pass
    real(wp), allocatable :: force(:, :)

    allocate (du(3, model%mesh%nnode))
    call full_vector(model%eq, newton%dx, du)
    pass%energy = abs(dot_product(newton%dx, newton%rhs)) + pass%sweep%enhanced
    if (.not. newton%largest_energy > 0.0_wp .and. .not. moved) newton%first_energy = pass%energy
    if (moved) then
      du = du + newton%move
      allocate (force(3, model%mesh%nnode))
      call multiply(newton%asm%k, du, force)
      newton%largest_energy = max(newton%largest_energy, abs(sum(du*force)))
    end if
    newton%largest_energy = max(newton%largest_energy, pass%energy)
  end subroutine find_increment

  !> Find the increment of the free dofs, on which prescribed motion acts through the tangent.
  subroutine solve_tangent(newton, model, state, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: force(:, :)

    if (newton%moves) then
      allocate (force(3, model%mesh%nnode))
      call multiply(newton%asm%k, newton%move, force)
      call free_part(model%eq, -state%reaction - force, newton%rhs)
    end if
    if (newton%secant%on) then           ! this affects the next tangent
      call adapt_secant(newton%secant, pass%residual, sum_of_loads(newton, model, state))
      call set_secant(newton%asm%contact, newton%secant%tangent)
    end if
    do
      if (newton%hold%springs) call add_springs(newton%hold, newton%asm%k)
      newton%forcing = find_forcing(newton, pass)
      call newton%system%solve(newton%asm%k, newton%rhs, newton%dx, newton%forcing, pass%solve, &
                               error, signs=needs_signs(newton, pass))
      if (.not. (allocated(error) .or. pass%solve%singular)) then
        call solve_anchored(newton, model, pass%solve, error)
      end if
      if (newton%hold%springs) call remove_springs(newton%hold, newton%asm%k)
      if (allocated(error)) return
      if (.not. pass%solve%singular) exit
      if (.not. use_springs(newton%hold, state)) exit
    end do
    call name_trouble(model, state, pass)
  end subroutine solve_tangent

  !> State the reason if the system has no solution.
  subroutine name_trouble(model, state, pass)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(pass_t), intent(inout) :: pass

    if (pass%solve%singular) then
      pass%ok = .false.
      call name_singularity(model, state, pass%solve%null, pass%trouble, pass%hopeless)
    else if (.not. pass%solve%converged) then
      pass%ok = .false.
      pass%trouble = 'the tangent is so nearly singular that the system cannot be solved'
    end if
  end subroutine name_trouble

  !> Find the reactions at the final displacements. A step that has not passed its test yet is
  !! tested once more, and so is one whose last increment has changed the forces.
  subroutine close_newton(newton, model, state, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(pass_t), intent(out) :: pass
    type(error_t), allocatable, intent(out) :: error
    logical :: loaded

    call form_system(newton, model, state, newton%symmetric, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    if (turns_away(newton%constraint, state)) then
      pass%ok = .false.
      pass%trouble = 'the step does not continue in the direction of the previous one'
      return
    end if
    if (newton%converged) newton%converged = .not. has_lost_balance(newton, pass)
    if (newton%converged .or. newton%moves) return
    newton%converged = pass%residual <= force_tolerance(pass) &
                       .and. pass%sweep%enhanced <= energy_tolerance(newton, pass) &
                       .and. .not. has_stale_cells(newton%asm%contact)
    if (.not. newton%converged) return
    call release_loaded(newton%hold, model, state, newton%asm%anchors, &
                        sum_of_loads(newton, model, state), loaded)
    newton%converged = .not. loaded
  end subroutine close_newton

  !> Find the pattern and analyse it. This is done once, and repeated here only if TANG and UTAN
  !! alternate or an option of FACTor changes; see take_pattern for changes by contact.
  !!
  !! This may happen within a step. The step keeps its contact then, because the cells that were cut
  !! in it are part of its equilibrium. The pattern that is analysed has no couplings by contact,
  !! because a restarted run, which knows none, may have to analyse it here.
  subroutine prepare_newton(newton, model, step, symmetric, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    integer, intent(in) :: step          !! number of the current step
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error
    type(assembler_t) :: kept

    if (newton%ready .and. (newton%symmetric .eqv. symmetric)) return
    if (newton%ready) call newton%system%free()
    newton%ready = .false.
    call set_aside(newton%asm, kept)
    call new_assembler(newton%asm, model, symmetric, error)
    if (allocated(error)) return
    call new_linear_system(newton%system, newton%asm%k, model%eq, newton%mode, newton%eps, error)
    if (allocated(error)) return
    newton%asm%new_pattern = .false.
    call take_back(newton%asm, model, step, kept, error)
    if (allocated(error)) return
    newton%symmetric = symmetric
    newton%ready = .true.
    if (.not. allocated(newton%spacing)) newton%spacing = node_spacing(model%mesh)
    if (.not. allocated(newton%rhs)) allocate (newton%rhs(model%neq), newton%dx(model%neq))
  end subroutine prepare_newton

  !> Set the options of FACTor; the analysis is repeated if one of them changes.
  subroutine set_factorisation(newton, mode, eps)
    type(newton_t), intent(inout) :: newton
    integer, intent(in) :: mode        !! FULL, REUSE, SINGLE, LOWRANK, AUTO
    real(wp), intent(in) :: eps        !! accuracy of LOWRANK

    if (newton%ready .and. (mode /= newton%mode .or. abs(eps - newton%eps) > 0.0_wp)) then
      call newton%system%free()
      newton%ready = .false.
    end if
    newton%mode = mode
    newton%eps = eps
  end subroutine set_factorisation

end module newton
