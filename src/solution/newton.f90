!> The one Newton iteration: one pass of TANG,,1, and what closes a step.
module newton
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_error, only: error_t
  use model, only: model_t, state_t
  use csr, only: multiply
  use linear_system, only: new_linear_system, change_pattern, FULL
  use assembly, only: new_assembler, form
  use line_search, only: search_line, step_by, retreat
  use local_control, only: solve_local
  use local_type, only: turns_away
  use newton_judge, only: judge, energy_tolerance, force_tolerance, is_slow, damping, find_worst, &
                          name_element, count_flips
  use newton_type, only: newton_t, pass_t
  use nodal_vector, only: free_part, full_vector
  use prescribed, only: to_prescribed
  use rounding_floor, only: node_spacing, find_floor
  use solution_state, only: accept_iteration
  use singularity, only: name_singularity
  implicit none
  private
  public :: newton_t, pass_t, begin_newton, prepare_newton, form_system, solve_system, &
            newton_pass, close_newton

  real(wp), parameter :: FORCING = 1.0e-3_wp !! relative residual of a linear solve where factors
  !! are kept

contains

  !> Start a step: state%factor and state%time are those of its end, state%u of its start.
  subroutine begin_newton(newton, model, state)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    newton%iterations = 0
    newton%before = 0
    newton%converged = .false.
    newton%exact = .true.
    newton%may_retreat = .false.
    newton%largest_energy = 0.0_wp
    newton%sign = 0
    newton%flips = 0
    if (.not. allocated(newton%move)) allocate (newton%move(3, model%mesh%nnode))
    call to_prescribed(model, state%factor, state%u, newton%move)
    newton%moves = any(abs(newton%move) > 0.0_wp)
  end subroutine begin_newton

  !> Forces and tangent at the displacements of now; the trial history becomes the iteration's.
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
    call find_worst(model, state%reaction, pass)
    if (.not. ieee_is_finite(pass%residual)) then
      pass%ok = .false.
      pass%trouble = 'the residual is not a number'
    end if
  end subroutine form_system

  !> Solve for the increment of the last formed system and add it.
  subroutine solve_system(newton, model, state, searches, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: searches !! look along the increment
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
    if (newton%local%on) then
      call solve_local(newton, model, state, FORCING, pass, error)
      return
    end if
    call solve_tangent(newton, model, state, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    newton%iterations = newton%iterations + 1
    call count_flips(newton, merge(0, pass%solve%determinant, newton%symmetric))
    newton%exact = newton%exact .and. newton%mode == FULL
    call find_increment(newton, model, moved, du, pass)
    newton%moves = .false.
    call judge(newton, pass, moved)
    if (.not. pass%ok) return
    if ((searches .or. is_slow(newton, model)) .and. .not. moved) then
      call search_line(newton%asm, model, state, newton%dx, du, &
                       dot_product(newton%dx, newton%rhs), pass%line, error)
    else
      if (size(model%contact) > 0) pass%line = damping(newton)
      call step_by(state, du, pass%line)
    end if
    newton%last = pass%line*newton%dx
    newton%may_retreat = .not. moved .and. .not. newton%converged
  end subroutine solve_system

  !> The increment of all dofs, and the largest energy that one had.
  subroutine find_increment(newton, model, moved, du, pass)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    logical, intent(in) :: moved       !! it contains the prescribed motion
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

  !> The increment of the free dofs, after the tangent's own guess of what prescribed motion does.
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
      pass%trouble = name_singularity(model, pass%solve%null)
    else if (.not. pass%solve%converged) then
      pass%ok = .false.
      pass%trouble = 'the tangent is so nearly singular that its system cannot be solved'
    end if
  end subroutine solve_tangent

  !> One pass of TANG,,1 or UTAN,,1.
  subroutine newton_pass(newton, model, state, symmetric, searches, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: symmetric, searches
    type(pass_t), intent(out) :: pass
    type(error_t), allocatable, intent(out) :: error

    call form_system(newton, model, state, symmetric, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    call solve_system(newton, model, state, searches, pass, error)
  end subroutine newton_pass

  !> Reactions at the final displacements; a step whose test has not passed yet is tested once more.
  subroutine close_newton(newton, model, state, pass, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(pass_t), intent(out) :: pass
    type(error_t), allocatable, intent(out) :: error

    call form_system(newton, model, state, newton%symmetric, pass, error)
    if (allocated(error) .or. .not. pass%ok) return
    if (turns_away(newton%local, state)) then
      pass%ok = .false.
      pass%trouble = 'the step turns away from the one before'
      return
    end if
    if (newton%converged) return
    if (newton%moves) return
    newton%converged = pass%residual <= force_tolerance(pass) &
                       .and. pass%sweep%enhanced <= energy_tolerance(newton, pass)
  end subroutine close_newton

  !> Pattern and analysis, once, and again only where TANG and UTAN alternate.
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

end module newton
