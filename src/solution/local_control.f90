!> Newton's iteration under local control: one factorisation, two right-hand sides.
!!
!! Displacements u and time t are unknown, R(u, t) = 0 and G(u) = goal are the equations, G the
!! release of the bonds or the way along the last step. With K = dR/du,
!!
!!     K a = -R,   K b = -dR/dt,   dt = (goal - G - G'.a)/(G'.b),   du = a + dt b.
!!
!! G grows along a crack that advances while loads rise or fall, so K dt is found where load control
!! fails. A step ends at its limit in time where that comes first: its load is then prescribed.
module local_control
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_error, only: error_t
  use csr, only: multiply
  use external_load, only: load_rates
  use linear_system, only: solve_report_t, FULL
  use model, only: model_t, state_t
  use local_type, only: local_t, find_measure
  use newton_judge, only: judge
  use newton_type, only: newton_t, pass_t
  use nodal_vector, only: free_part, full_vector
  use prescribed, only: prescribed_rates, to_prescribed
  use solution_state, only: set_factors, factor_slopes
  implicit none
  private
  public :: solve_local

  real(wp), parameter :: NEAR = 1.0e-6_wp !! of the goal, relative to the step's piece

contains

  !> Solve for the increments of displacements and time that belong to the last formed system, and
  !! add them.
  subroutine solve_local(newton, model, state, forcing, pass, error)
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
    call find_measure(newton%local, model, state, measure, slope)
    call solve_both(newton, model, state, forcing, a, b, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    newton%iterations = newton%iterations + 1
    newton%exact = newton%exact .and. newton%mode == FULL
    call find_time(newton%local, state%time, measure, sum(slope*a), sum(slope*b), dt, arrived, &
                   pass%ok)
    if (.not. pass%ok) then
      pass%trouble = 'no load since time 0 opens the bonds so far'
      if (allocated(newton%local%way)) pass%trouble = 'the path leads to times before 0'
      return
    end if
    call free_part(model%eq, a, newton%dx)
    alone = abs(dot_product(newton%dx, newton%rhs)) ! also what other times would balance
    a = a + dt*b
    call free_part(model%eq, a, newton%dx)
    pass%energy = max(alone, abs(dot_product(newton%dx, newton%rhs))) + pass%sweep%enhanced
    if (newton%iterations == newton%before + 1) then ! the predictor
      call multiply(newton%asm%k, a, b)
      newton%largest_energy = max(newton%largest_energy, abs(sum(a*b)))
    end if
    newton%largest_energy = max(newton%largest_energy, pass%energy)
    call judge(newton, pass, moved=.not. arrived)
    if (pass%ok) call move_on(newton, model, state, a, dt)
  end subroutine solve_local

  !> The way to go in time. It does not pass the limit; a step that stops there has arrived when it
  !! stopped there before.
  pure subroutine find_time(local, time, measure, by_a, by_b, dt, arrived, ok)
    type(local_t), intent(inout) :: local
    real(wp), intent(in) :: time
    real(wp), intent(in) :: measure         !! [L^2], or [L]
    real(wp), intent(in) :: by_a, by_b       !! G'.a, and G'.b a unit of time
    real(wp), intent(out) :: dt
    logical, intent(out) :: arrived          !! the step's goal was reached before this iteration
    logical, intent(out) :: ok
    logical :: again

    dt = local%limit - time                  ! where nothing is open yet
    if (allocated(local%way) .or. measure > NEAR*local%piece) then
      dt = (local%goal - measure - by_a)/by_b
    end if
    ok = ieee_is_finite(dt)
    if (ok) ok = time + dt >= 0.0_wp
    again = local%at_limit
    arrived = abs(local%goal - measure) <= NEAR*local%piece
    local%at_limit = time + dt >= local%limit
    if (.not. local%at_limit) return
    dt = local%limit - time
    arrived = again
  end subroutine find_time

  !> a = -K^-1 R, b = -K^-1 dR/dt, prescribed motion included.
  subroutine solve_both(newton, model, state, forcing, a, b, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: forcing
    real(wp), intent(out) :: a(:, :), b(:, :)      !! (3, nnode)
    type(pass_t), intent(inout) :: pass
    type(error_t), allocatable, intent(out) :: error
    type(solve_report_t) :: second
    real(wp), allocatable :: way(:, :), force(:, :), rhs(:), slope(:)

    allocate (way(3, model%mesh%nnode), force(3, model%mesh%nnode), rhs(size(newton%rhs)))
    call newton%system%solve(newton%asm%k, newton%rhs, newton%dx, forcing, pass%solve, error)
    if (allocated(error)) return
    call full_vector(model%eq, newton%dx, a)
    slope = factor_slopes(state, ahead=state%time <= newton%local%from)
    call prescribed_rates(model, state%factor, slope, way)
    call load_rates(model, state, slope, force)
    call multiply(newton%asm%k, way, b)
    call free_part(model%eq, force - b, rhs)
    call newton%system%solve(newton%asm%k, rhs, newton%dx, forcing, second, error, &
                             same_matrix=.true.)
    if (allocated(error)) return
    call full_vector(model%eq, newton%dx, b)
    b = b + way
    pass%solve%seconds_solve = pass%solve%seconds_solve + second%seconds_solve
    pass%ok = pass%solve%converged .and. second%converged .and. .not. pass%solve%singular
    if (.not. pass%ok) pass%trouble = 'the tangent is singular'
  end subroutine solve_both

  !> Displacements and time move; prescribed ones to where they are at the new time.
  subroutine move_on(newton, model, state, du, dt)
    type(newton_t), intent(in) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: du(:, :)               !! (3, nnode)
    real(wp), intent(in) :: dt
    real(wp), allocatable :: way(:, :)

    state%time = state%time + dt
    if (newton%local%at_limit) state%time = newton%local%limit
    state%dt = state%time - newton%local%from
    call set_factors(state)
    state%u = state%u_base + du
    state%scale = 1.0_wp
    allocate (way(3, model%mesh%nnode))
    call to_prescribed(model, state%factor, state%u, way)
    state%u = state%u + way
  end subroutine move_on

end module local_control
