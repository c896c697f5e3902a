!> The state of the analysis: how it is created, advanced, accepted and restored.
module solution_state
  use base_kinds, only: wp
  use contact_bond, only: find_bonds
  use contact_history, only: new_contact_state, restore_contact_step, keep_contact_step
  use dynamics_type, only: set_rates, new_dynamics
  use energy_type, only: open_book
  use load_curve, only: table_factor, table_slope
  use model, only: model_t, state_t
  use solid_form, only: history_length
  implicit none
  private
  public :: new_state, open_step, accept_iteration, accept_step_state, restore_step, set_factors, &
            factor_slopes

contains

  !> Create the undeformed state at time 0.
  subroutine new_state(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(out) :: state
    integer :: b, n

    n = model%mesh%nnode
    allocate (state%u(3, n), state%u_step(3, n), state%u_base(3, n), state%last_increment(3, n), &
              state%reaction(3, n), state%reaction_step(3, n), source=0.0_wp)
    allocate (state%table(0), state%factor(0), state%history(size(model%mesh%block)))
    do b = 1, size(model%mesh%block)
      associate (block => model%mesh%block(b))
        n = history_length(block%nen, block%row%nmode)
        allocate (state%history(b)%step(3*block%row%nmode, block%nelem), source=0.0_wp)
        allocate (state%history(b)%iter(n, block%nelem), source=0.0_wp)
        allocate (state%history(b)%trial(n, block%nelem), source=0.0_wp)
      end associate
    end do
    ! Even if this run does not use the balance, one that continues from its checkpoint may do so.
    call open_book(state%energy, model%mesh%nnode)
    ! Contact may have to continue the path with inertia.
    if (size(model%contact) > 0) call new_dynamics(state%dynamics, model%mesh%nnode)
    allocate (state%contact(size(model%contact)))
    do b = 1, size(model%contact)
      call new_contact_state(model%contact(b), state%contact(b))
      call find_bonds(model%contact(b), model%mesh%xr, state%contact(b))
    end do
  end subroutine new_state

  !> Begin a step; number, time and load factors become those at its end.
  subroutine open_step(state, time)
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: time !! time at the end of the step

    state%dt = time - state%time
    state%time = time
    state%step = state%step + 1
    call set_factors(state)
    call set_rates(state%dynamics, state%dt)
  end subroutine open_step

  !> Set the factors of all load tables at the time of the state.
  subroutine set_factors(state)
    type(state_t), intent(inout) :: state
    integer :: i

    if (size(state%factor) /= size(state%table)) then
      deallocate (state%factor)
      allocate (state%factor(size(state%table)))
    end if
    do i = 1, size(state%table)
      state%factor(i) = table_factor(state%table(i), state%time)
    end do
  end subroutine set_factors

  !> Derivatives of the load factors with respect to time.
  pure function factor_slopes(state, ahead) result(slope)
    type(state_t), intent(in) :: state
    logical, intent(in) :: ahead !! take the slope after a corner of a table
    real(wp) :: slope(size(state%table))
    integer :: i

    do i = 1, size(slope)
      slope(i) = table_slope(state%table(i), state%time, ahead)
    end do
  end function factor_slopes

  !> Make the trial state of the last sweep the state of the iteration.
  subroutine accept_iteration(state)
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: swap(:, :)
    integer :: b

    do b = 1, size(state%history)
      call move_alloc(state%history(b)%iter, swap)
      call move_alloc(state%history(b)%trial, state%history(b)%iter)
      call move_alloc(swap, state%history(b)%trial)
    end do
    state%u_base = state%u
    state%scale = 0.0_wp
  end subroutine accept_iteration

  !> Accept the step: from now on, a cut-back restores the state at its end.
  subroutine accept_step_state(state)
    type(state_t), intent(inout) :: state
    integer :: b

    state%last_increment = state%u - state%u_step
    state%last_dt = state%dt
    state%u_step = state%u
    state%reaction_step = state%reaction
    state%factor_step = state%factor
    do b = 1, size(state%history)
      state%history(b)%step = state%history(b)%iter(:size(state%history(b)%step, 1), :)
    end do
    do b = 1, size(state%contact)
      call keep_contact_step(state%contact(b))
    end do
  end subroutine accept_step_state

  !> Restore the state at the start of the step, at which the number of the step was `step` and the
  !! time was `time`.
  subroutine restore_step(state, step, time)
    type(state_t), intent(inout) :: state
    integer, intent(in) :: step
    real(wp), intent(in) :: time
    integer :: b

    state%step = step
    state%time = time
    state%u = state%u_step
    state%u_base = state%u_step
    state%scale = 0.0_wp
    state%reaction = state%reaction_step
    do b = 1, size(state%history)
      state%history(b)%iter = 0.0_wp
      state%history(b)%iter(:size(state%history(b)%step, 1), :) = state%history(b)%step
    end do
    do b = 1, size(state%contact)
      call restore_contact_step(state%contact(b))
    end do
    call set_factors(state)
  end subroutine restore_step

end module solution_state
