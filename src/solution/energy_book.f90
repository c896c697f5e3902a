!> A converged step is accepted: works are booked, rates move on, contacts keep their history.
module energy_book
  use base_kinds, only: wp
  use assembly, only: assembler_t
  use contact_assembly, only: accept_contact, share_contact
  use dynamics_type, only: advance
  use energy_type, only: energy_t, book_work
  use inertia, only: kinetic_energy
  use model, only: model_t, state_t
  use solution_state, only: accept_step_state
  implicit none
  private
  public :: accept_step_end

contains

  !> state%reaction and the forces of the assembler are those of the converged displacements.
  subroutine accept_step_end(asm, model, state)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: du(:, :), outer(:, :), contact(:, :, :)

    allocate (du, source=state%u - state%u_step)
    if (state%energy%on) then
      allocate (contact(3, model%mesh%nnode, 3))
      call share_contact(asm%contact, model, state, contact)
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
  end subroutine accept_step_end

end module energy_book
