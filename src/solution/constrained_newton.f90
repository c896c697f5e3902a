!> Newton's iteration of a constrained step, with one factorisation for two right-hand sides.
!!
!! The displacements u and the time t are unknown. The equations are R(u, t) = 0 and G(u) = goal,
!! where G is the release of the bonds or the arc length of the step. With K = dR/du,
!!
!!     K a = -R,   K b = -dR/dt,   dt = (goal - G - G'.a)/(G'.b),   du = a + dt b.
!!
!! As a crack advances, G grows whether loads rise or fall, so dt can be found even where load
!! control fails. No step passes its time limit. A step that reaches the limit but not its goal ends
!! there, with its load prescribed.
module constrained_newton
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use assembly, only: free_part, full_vector
  use base_error, only: error_t
  use base_kinds, only: wp
  use continuation_type, only: path_constraint_t, find_measure
  use convergence, only: check_convergence
  use csr, only: multiply
  use external_load, only: load_rates
  use linear_system, only: solve_report_t
  use model, only: model_t, state_t
  use newton_type, only: newton_t, pass_t
  use prescribed, only: prescribed_rates, to_prescribed
  use solution_state, only: set_factors, factor_slopes
  implicit none
  private
  public :: solve_constrained

  real(wp), parameter :: NEAR = 1.0e-6_wp !! smaller differences of the measure G count as zero,
  !! relative to its increment in the step

contains

  !> Find the increments of displacements and time from the system formed last, and add them.
  subroutine solve_constrained(newton, model, state, forcing, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: forcing !! relative residual of the linear solves
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: a(:, :), b(:, :), slope(:, :)
    real(wp) :: alone, measure, dt
    logical :: arrived

    allocate (a(3, model%mesh%nnode), b(3, model%mesh%nnode), slope(3, model%mesh%nnode))
    call find_measure(newton%constraint, model, state, measure, slope)
    call solve_both(newton, model, state, forcing, a, b, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    newton%iterations = newton%iterations + 1
    newton%forcing = forcing
    call find_time(newton%constraint, state%time, measure, sum(slope*a), sum(slope*b), dt, &
                   arrived, pass%ok)
    if (.not. pass%ok) then
      pass%trouble = 'at no time after 0 do the loads open the bonds as far as this step requires'
      if (allocated(newton%constraint%direction)) pass%trouble = 'the path leads to times before 0'
      return
    end if
    call free_part(model%eq, a, newton%dx)
    alone = abs(dot_product(newton%dx, newton%rhs)) ! energy without the change of time
    a = a + dt*b
    call free_part(model%eq, a, newton%dx)
    pass%energy = max(alone, abs(dot_product(newton%dx, newton%rhs))) + pass%sweep%enhanced
    if (newton%iterations == newton%before + 1) then ! the predictor
      call multiply(newton%asm%k, a, b)
      newton%largest_energy = max(newton%largest_energy, abs(sum(a*b)))
    end if
    newton%largest_energy = max(newton%largest_energy, pass%energy)
    call check_convergence(newton, pass, moved=.not. arrived)
    if (.not. pass%ok) return

    state%time = state%time + dt
    if (newton%constraint%at_limit) state%time = newton%constraint%limit
    state%dt = state%time - newton%constraint%start
    call set_factors(state)
    state%u = state%u_base + a
    state%scale = 1.0_wp
    call to_prescribed(model, state%factor, state%u, b)
    state%u = state%u + b
  end subroutine solve_constrained

  !> Find the increment of time. The time does not pass the limit. A step that stops at the limit
  !! has arrived if it also stopped there in the previous iteration.
  pure subroutine find_time(constraint, time, measure, by_a, by_b, dt, arrived, ok)
    type(path_constraint_t), intent(inout) :: constraint
    real(wp), intent(in) :: time
    real(wp), intent(in) :: measure    !! [L^2], or [L]
    real(wp), intent(in) :: by_a, by_b !! G'.a, and G'.b per unit time
    real(wp), intent(out) :: dt
    logical, intent(out) :: arrived    !! the step's goal was reached before this iteration
    logical, intent(out) :: ok
    logical :: again

    dt = constraint%limit - time       ! up to the limit while no bond is open
    if (allocated(constraint%direction) .or. measure > NEAR*constraint%increment) then
      dt = (constraint%goal - measure - by_a)/by_b
    end if
    ok = ieee_is_finite(dt)
    if (ok) ok = time + dt >= 0.0_wp
    again = constraint%at_limit
    arrived = abs(constraint%goal - measure) <= NEAR*constraint%increment
    constraint%at_limit = time + dt >= constraint%limit
    if (.not. constraint%at_limit) return
    dt = constraint%limit - time
    arrived = again
  end subroutine find_time

  !> Solve for a = -K^-1 R and b = -K^-1 dR/dt, including prescribed motion.
  subroutine solve_both(newton, model, state, forcing, a, b, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: forcing
    real(wp), intent(out) :: a(:, :), b(:, :) !! (3, nnode)
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    type(solve_report_t) :: second
    real(wp), allocatable :: rate(:, :), force(:, :), rhs(:), slope(:)

    allocate (rate(3, model%mesh%nnode), force(3, model%mesh%nnode), rhs(size(newton%rhs)))
    call newton%system%solve(newton%asm%k, newton%rhs, newton%dx, forcing, pass%solve, error, &
                             signs=.true.)
    if (allocated(error)) return
    call full_vector(model%eq, newton%dx, a)
    slope = factor_slopes(state, ahead=state%time <= newton%constraint%start)
    call prescribed_rates(model, state%factor, slope, rate)
    call load_rates(model, state, slope, force)
    call multiply(newton%asm%k, rate, b)
    call free_part(model%eq, force - b, rhs)
    call newton%system%solve(newton%asm%k, rhs, newton%dx, forcing, second, error, &
                             same_matrix=.true.)
    if (allocated(error)) return
    call full_vector(model%eq, newton%dx, b)
    b = b + rate
    pass%solve%seconds_solve = pass%solve%seconds_solve + second%seconds_solve
    pass%ok = pass%solve%converged .and. second%converged .and. .not. pass%solve%singular
    if (.not. pass%ok) pass%trouble = 'the tangent is singular'
  end subroutine solve_both

end module constrained_newton
