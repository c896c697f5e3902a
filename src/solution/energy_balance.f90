!> The energy balance (BOOK): the contributions of accepted steps, and its entries.
module energy_balance
  use assembly, only: assembler_t
  use base_kinds, only: wp
  use contact_assembly, only: accept_contact, split_contact_forces
  use contact_pair, only: contact_points_t
  use curve_type, only: B_WORK, B_STORED, B_KINETIC, B_NORMAL, B_FRICTION, B_COHESIVE, B_INERTIA, &
                        B_BONDS, B_DAMAGE, B_VISCOUS
  use dynamics_type, only: advance
  use energy_type, only: book_work
  use inertia, only: kinetic_energy
  use model, only: model_t, state_t
  use point_values, only: body_energy
  use solution_state, only: accept_step_state
  implicit none
  private
  public :: accept_solution, energy_entry

contains

  !> Accept a converged step: add its works, update the rates, and keep the histories.
  !! state%reaction and the forces of the assembler are those of the converged displacements.
  subroutine accept_solution(asm, model, state)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: du(:, :), outer(:, :), contact(:, :, :)

    allocate (du, source=state%u - state%u_step)
    if (state%energy%on) then
      allocate (contact(3, model%mesh%nnode, 3))
      call split_contact_forces(asm%contact, model, state, contact)
      allocate (outer, source=asm%f_ext)
      where (model%eq == 0) outer = outer + state%reaction
      call book_work(state%energy, du, outer, asm%f_inert, contact)
    end if
    if (allocated(state%dynamics%v)) then
      call advance(state%dynamics, du, state%dt, state%reaction - asm%f_inert)
    end if
    if (allocated(asm%mass)) then
      state%energy%kinetic = kinetic_energy(model, asm%mass, state)
    end if
    call accept_contact(asm%contact, model, state)
    call accept_step_state(state)
  end subroutine accept_solution

  !> One entry of the balance [F L]. The work of supports and loads equals the sum of the other
  !! entries except for IMBAlance, the error of the trapezoidal rule over the steps.
  real(wp) function energy_entry(model, state, entry) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: entry         !! B_WORK ...
    integer :: c

    associate (energy => state%energy)
      select case (entry)
      case (B_WORK)
        value = energy%outer
      case (B_STORED)
        value = body_energy(model, state, 0)
      case (B_KINETIC)
        value = energy%kinetic
      case (B_NORMAL, B_FRICTION, B_COHESIVE)
        value = energy%contact(entry - B_NORMAL + 1)
        if (entry == B_FRICTION) value = value + sum(state%contact(:)%dissipated)
      case (B_INERTIA)
        value = energy%inertia - energy%kinetic
      case (B_BONDS, B_DAMAGE, B_VISCOUS)
        value = bond_energy(model, state, entry - B_BONDS + 1)
      case default
        value = energy%outer - body_energy(model, state, 0) - energy%inertia - sum(energy%contact) &
                - sum(state%contact(:)%dissipated)
        do c = 1, size(state%contact)
          value = value - sum(state%contact(c)%sheared)
        end do
      end select
    end associate
  end function energy_entry

  !> Energy of all bonds according to their laws: 1 stored, 2 dissipated by damage, 3 dissipated by
  !! viscosity. Each of the two sides covers the whole interface, so the mean of both sides is
  !! taken; a rigid side has no points.
  pure real(wp) function bond_energy(model, state, part) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part
    integer :: c

    energy = 0.0_wp
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%cohesive%given) cycle
      associate (side => state%contact(c)%side, rigid => model%contact(c)%side%rigid)
        energy = energy + (of_side(side(1)) + of_side(side(2)))/count(.not. rigid)
      end associate
    end do

  contains

    pure real(wp) function of_side(points)
      type(contact_points_t), intent(in) :: points

      of_side = sum(points%area0*points%energy(part, :), mask=points%bond > 0)
    end function of_side

  end function bond_energy

end module energy_balance
