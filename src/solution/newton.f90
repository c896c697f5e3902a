!> Newton's iteration: form, solve, and the last test of a step.
module newton
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use assembly, only: sweep_t, new_assembler, form, free_part, full_vector
  use base_error, only: error_t
  use base_kinds, only: wp
  use constrained_newton, only: solve_constrained
  use continuation_type, only: turns_away
  use convergence, only: check_convergence, energy_tolerance, force_tolerance, &
                         find_largest_residual, node_spacing, find_floor, needs_line_search, &
                         damping, count_flips
  use csr, only: multiply
  use failure_text, only: name_element, name_singularity
  use line_search, only: search_line, step_by, retreat
  use linear_system, only: new_linear_system, change_pattern, FULL
  use model, only: model_t, state_t
  use newton_type, only: newton_t, pass_t
  use predictor, only: predict
  use prescribed, only: to_prescribed
  use solution_state, only: accept_iteration
  implicit none
  private
  public :: newton_t, pass_t, begin_newton, prepare_newton, set_factorisation, form_system, &
            solve_system, close_newton

  !> Tolerance of the relative residual of a linear solve with kept factors.
  real(wp), parameter :: FORCING = 1.0e-3_wp
  integer, parameter :: MOST_HALVINGS = 6   !! of a prescribed increment

contains

  !> Begin a step: state%factor and state%time hold for its end, state%u for its start.
  subroutine begin_newton(newton, model, state, predicts)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: predicts          !! the step may start from predicted displacements

    newton%iterations = 0
    newton%before = 0
    if (allocated(newton%asm%contact)) newton%asm%contact%mortar%step = -1 ! also after a cut-back
    newton%has_moved = .false.
    newton%converged = .false.
    newton%exact = .true.
    newton%may_retreat = .false.
    newton%largest_energy = 0.0_wp
    newton%sign = 0
    newton%flips = 0
    if (.not. allocated(newton%move)) allocate (newton%move(3, model%mesh%nnode))
    call to_prescribed(model, state%factor, state%u, newton%move)
    newton%moves = any(abs(newton%move) > 0.0_wp)
    newton%predicted = .false.
    if (.not. predicts .or. newton%constraint%on) return
    call predict(model, state, newton%move, newton%predicted)
    newton%moves = newton%moves .and. .not. newton%predicted
  end subroutine begin_newton

  !> Forces and tangent at the current displacements; the trial history becomes the iteration's.
  subroutine form_system(newton, model, state, symmetric, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: symmetric
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error

    call prepare_newton(newton, model, symmetric, error)
    if (allocated(error)) return
    call form(newton%asm, model, state, pass%sweep, error)
    if (allocated(error)) return
    if (newton%predicted) call check_prediction(newton, model, state, pass%sweep, error)
    if (allocated(error)) return
    if (newton%has_moved .and. .not. pass%sweep%ok) then
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
    pass%floor = find_floor(newton%asm%k, newton%spacing, state%u)
    state%reaction = newton%asm%f_int - newton%asm%f_ext
    call free_part(model%eq, -state%reaction, newton%rhs)
    call find_largest_residual(model, state%reaction, pass)
    if (.not. ieee_is_finite(pass%residual)) then
      pass%ok = .false.
      pass%trouble = 'the residual is not a number'
    end if
  end subroutine form_system

  !> The forces at the predicted displacements are known: find the energy of the step. If an element
  !! is inverted there, return to the displacements at the start of the step.
  subroutine check_prediction(newton, model, state, sweep, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(sweep_t), intent(inout) :: sweep
    type(error_t), allocatable, intent(out) :: error

    newton%predicted = .false.
    if (sweep%ok) then
      newton%largest_energy = abs(sum((state%u - state%u_step) &
                                      *(newton%asm%f_int - newton%asm%f_ext - state%reaction)))
    else
      state%u = state%u_step
      state%u_base = state%u_step
      newton%moves = any(abs(newton%move) > 0.0_wp)
      call form(newton%asm, model, state, sweep, error)
    end if
  end subroutine check_prediction

  !> The increment with the prescribed motion inverts an element: a part of it is taken, and the
  !! rest of the motion is left to the next iterations.
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
      if (sweep%ok) exit
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
    logical, intent(in) :: searches    !! with a line search
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: du(:, :)
    logical :: moved

    moved = newton%moves
    if (newton%asm%new_pattern) then
      call change_pattern(newton%system, newton%asm%k, model%eq, error)
      if (allocated(error)) return
      newton%asm%new_pattern = .false.
    end if
    if (newton%constraint%on) then
      call solve_constrained(newton, model, state, FORCING, pass, error)
      return
    end if
    call solve_tangent(newton, model, state, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    newton%iterations = newton%iterations + 1
    call count_flips(newton, merge(0, pass%solve%determinant, newton%symmetric))
    newton%exact = newton%exact .and. newton%mode == FULL
    call find_increment(newton, model, moved, du, pass)
    newton%has_moved = moved
    if (moved) newton%moved = newton%move
    newton%moves = .false.
    call check_convergence(newton, pass, moved)
    if (.not. pass%ok) return
    if ((searches .or. needs_line_search(newton, model)) .and. .not. moved) then
      call search_line(newton%asm, model, state, newton%dx, du, &
                       dot_product(newton%dx, newton%rhs), pass%line, error)
    else
      if (size(model%contact) > 0) pass%line = damping(newton)
      call step_by(state, du, pass%line)
    end if
    newton%last = pass%line*newton%dx
    newton%may_retreat = .not. moved .and. .not. newton%converged
  end subroutine solve_system

  !> The increment of all dofs, and the largest energy of an increment so far.
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
    if (moved) then
      du = du + newton%move
      allocate (force(3, model%mesh%nnode))
      call multiply(newton%asm%k, du, force)
      newton%largest_energy = max(newton%largest_energy, abs(sum(du*force)))
    end if
    newton%largest_energy = max(newton%largest_energy, pass%energy)
  end subroutine find_increment

  !> The increment of the free dofs; prescribed motion acts on them through the tangent.
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
    call newton%system%solve(newton%asm%k, newton%rhs, newton%dx, FORCING, pass%solve, error)
    if (allocated(error)) return
    if (pass%solve%singular) then
      pass%ok = .false.
      call name_singularity(model, state, pass%solve%null, pass%trouble, pass%hopeless)
    else if (.not. pass%solve%converged) then
      pass%ok = .false.
      pass%trouble = 'the tangent is so nearly singular that its system cannot be solved'
    end if
  end subroutine solve_tangent

  !> Reactions at the final displacements; a step whose test has not passed yet is tested once more.
  subroutine close_newton(newton, model, state, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(pass_t), intent(out) :: pass
    type(error_t), allocatable, intent(out) :: error

    call form_system(newton, model, state, newton%symmetric, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    if (turns_away(newton%constraint, state)) then
      pass%ok = .false.
      pass%trouble = 'the step does not continue in the direction of the previous one'
      return
    end if
    if (newton%converged .or. newton%moves) return
    newton%converged = pass%residual <= force_tolerance(pass) &
                       .and. pass%sweep%enhanced <= energy_tolerance(newton, pass)
  end subroutine close_newton

  !> Pattern and analysis: once, and again only when TANG and UTAN alternate.
  subroutine prepare_newton(newton, model, symmetric, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error

    if (newton%ready .and. (newton%symmetric .eqv. symmetric)) return
    if (newton%ready) call newton%system%free()
    newton%ready = .false.
    call new_assembler(newton%asm, model, symmetric, error)
    if (allocated(error)) return
    call new_linear_system(newton%system, newton%asm%k, model%eq, newton%mode, newton%eps, error)
    if (allocated(error)) return
    newton%asm%new_pattern = .false.
    newton%symmetric = symmetric
    newton%ready = .true.
    if (.not. allocated(newton%spacing)) newton%spacing = node_spacing(model%mesh)
    if (.not. allocated(newton%rhs)) allocate (newton%rhs(model%neq), newton%dx(model%neq))
  end subroutine prepare_newton

  !> FACTor: the analysis is repeated if an option changes.
  subroutine set_factorisation(newton, mode, eps)
    type(newton_t), intent(inout) :: newton
    integer, intent(in) :: mode        !! FULL, REUSE, SINGLE, LOWRANK
    real(wp), intent(in) :: eps        !! accuracy of LOWRANK

    if (newton%ready .and. (mode /= newton%mode .or. abs(eps - newton%eps) > 0.0_wp)) then
      call newton%system%free()
      newton%ready = .false.
    end if
    newton%mode = mode
    newton%eps = eps
  end subroutine set_factorisation

end module newton
