!> The energy balance (BOOK): the contributions of accepted steps, and the entries of the balance.
module energy_balance
  use assembly, only: assembler_t
  use base_kinds, only: wp
  use constraint, only: follow
  use contact_assembly, only: accept_contact
  use contact_energy, only: bond_energy, bond_energy_at_start, contact_energies
  use contact_report, only: report_contact_changes
  use curve_type, only: B_WORK, B_STORED, B_KINETIC, B_NORMAL, B_FRICTION, B_COHESIVE, B_INERTIA, &
                        B_BONDS, B_DAMAGE, B_VISCOUS, B_CREATED, B_ERROR
  use dynamics_type, only: advance
  use energy_type, only: book_work
  use inertia, only: kinetic_energy
  use model, only: model_t, state_t
  use point_values, only: body_energy
  use solution_state, only: accept_step_state
  implicit none
  private
  public :: accept_solution, energy_entry, stored_energy, energy_at_start, &
            contact_energy_of, contact_energy_at_start

contains

  !> Accept a converged step: add its work to the balance, update the rates, report what it changes
  !! in contacts, and keep the histories.
  !! state%reaction and the forces of the assembler are those of the converged displacements.
  subroutine accept_solution(asm, model, state)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: du(:, :), outer(:, :)

    allocate (du, source=state%u - state%u_step)
    allocate (outer, source=asm%f_ext)
    where (model%eq == 0) outer = outer + state%reaction
    call book_work(state%energy, du, state%last_increment, outer, asm%f_inert, asm%f_contact)
    if (allocated(state%dynamics%v)) then
      call advance(state%dynamics, du, model%eq == 0, state%dt, state%reaction - asm%f_inert)
      call follow(model%mesh%constraint, state%dynamics%v)
      call follow(model%mesh%constraint, state%dynamics%a)
    end if
    state%energy%kinetic = 0.0_wp ! also if a checkpoint of a motion is continued without inertia
    if (allocated(asm%mass)) state%energy%kinetic = kinetic_energy(model, asm%mass, state)
    call accept_contact(asm%contact, model, state)
    call report_contact_changes(model, state)
    call accept_step_state(state)
  end subroutine accept_solution

  !> Energy that bodies and contacts store or, in contacts, have dissipated [F L].
  real(wp) function stored_energy(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    energy = body_energy(model, state, 0) + contact_energy_of(model, state)
  end function stored_energy

  !> The stored energy at the start of the current step, which is not accepted yet [F L].
  real(wp) function energy_at_start(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(state_t) :: start
    integer :: b

    start%u = state%u_step
    allocate (start%history(size(state%history)))
    do b = 1, size(state%history)
      associate (own => state%history(b), first => start%history(b))
        allocate (first%iter(size(own%iter, 1), size(own%iter, 2)), source=0.0_wp)
        first%iter(:size(own%step, 1), :) = own%step
      end associate
    end do
    energy = body_energy(model, start, 0) + contact_energy_at_start(model, state)
  end function energy_at_start

  !> Energy that contacts store or have dissipated at the end of the last accepted step [F L].
  pure real(wp) function contact_energy_of(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: c

    energy = 0.0_wp
    do c = 1, size(model%contact)
      energy = energy + sum(contact_energies(model%contact(c), state%contact(c)))
    end do
  end function contact_energy_of

  !> Energy that contacts stored or had dissipated at the start of the current step, which is not
  !! accepted yet [F L]. The energies of pressure and friction are found when it is accepted.
  pure real(wp) function contact_energy_at_start(model, state) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: c

    energy = 0.0_wp
    do c = 1, size(model%contact)
      energy = energy + sum(contact_energies(model%contact(c), state%contact(c))) &
               - sum(bond_energy(model%contact(c), state%contact(c))) &
               + bond_energy_at_start(model%contact(c), state%contact(c))
    end do
  end function contact_energy_at_start

  !> One entry of the balance [F L]. IMBAlance is the excess of the work of supports and loads over
  !! the energies; it consists of the error of that work and of the energy that the forces of
  !! contact destroy (CREAted < 0).
  real(wp) function energy_entry(model, state, entry) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: entry         !! B_WORK ...
    real(wp) :: contact(3), bonds(3)
    integer :: c

    contact = 0.0_wp
    bonds = 0.0_wp
    do c = 1, size(model%contact)
      contact = contact + contact_energies(model%contact(c), state%contact(c))
      bonds = bonds + bond_energy(model%contact(c), state%contact(c))
    end do
    associate (energy => state%energy)
      select case (entry)
      case (B_WORK)
        value = energy%outer
      case (B_STORED)
        value = body_energy(model, state, 0)
      case (B_KINETIC)
        value = energy%kinetic
      case (B_NORMAL, B_FRICTION, B_COHESIVE)
        value = contact(entry - B_NORMAL + 1)
      case (B_INERTIA)
        value = energy%inertia - energy%kinetic
      case (B_BONDS, B_DAMAGE, B_VISCOUS)
        value = bonds(entry - B_BONDS + 1)
      case (B_CREATED)
        value = sum(contact) - energy%contact
      case (B_ERROR)
        value = energy%error
      case default
        value = energy%outer - body_energy(model, state, 0) - energy%inertia - sum(contact)
      end select
    end associate
  end function energy_entry

end module energy_balance
