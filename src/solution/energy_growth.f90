!> Energy that a motion gains although nothing supplies it.
!!
!! Bodies, contacts and motion together cannot contain more energy than loads and supports have
!! supplied. Schemes that conserve the energy of a linear model do not conserve it in an impact: if
!! a body penetrates deeply within one long step, contact pushes it back with more energy than the
!! body has lost on its way in.
!!
!! The strain energy of the bodies is expensive to compute. After a step it is therefore computed
!! only if the energies of contact and motion, which are known anyway, have grown by more than the
!! work done on contacts and masses, and the difference exceeds both GROWTH times the largest energy
!! and the largest gain so far.
module energy_growth
  use assembly, only: assembler_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use dynamics_type, only: BACKWARD_EULER
  use energy_balance, only: contact_energy_at_start, contact_energy_of, energy_at_start, &
                            stored_energy
  use inertia, only: energy_of_rate
  use model, only: model_t, state_t
  implicit none
  private
  public :: begin_motion, follow_growth, warn_growth

  !> Gain that causes a warning, relative to the largest energy of the run; velocities are wrong by
  !! about half as much. The start of a motion under a sudden load may contribute some per cent.
  real(wp), parameter :: GROWTH = 0.1_wp

contains

  !> Before a step is accepted: if it is the first one with inertia, find the excess of the
  !! energies over the work so far, because earlier steps need not have been accurate.
  subroutine begin_motion(asm, model, state)
    type(assembler_t), intent(in) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical :: moves

    moves = moves_by_deck(state) .and. allocated(asm%mass)
    associate (energy => state%energy)
      if (moves .and. .not. energy%moving) then
        ! a motion begins from rest or with the velocities of a checkpoint
        energy%kinetic = energy_of_rate(model, asm%mass, state%dynamics%v)
        energy%excess_before = energy_at_start(model, state) + energy%kinetic - energy%outer
        energy%excess_without = excess_without_bodies(state, contact_energy_at_start(model, state))
      end if
      energy%moving = moves
    end associate
  end subroutine begin_motion

  !> After a step has been accepted, keep the largest energy and the largest growth of the excess.
  subroutine follow_growth(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp) :: total, growth_now

    associate (energy => state%energy)
      if (.not. energy%moving) return
      energy%largest = max(energy%largest, energy%kinetic + contact_energy_of(model, state))
      growth_now = excess_without_bodies(state, contact_energy_of(model, state)) &
                   - energy%excess_without
      if (growth_now <= max(GROWTH*energy%largest, energy%growth)) return
      total = stored_energy(model, state) + energy%kinetic
      energy%largest = max(energy%largest, total)
      growth_now = total - energy%outer - energy%excess_before - energy%error
      if (growth_now <= (1.0_wp + GROWTH)*energy%growth) return ! only a little more than before
      energy%growth = growth_now
      energy%growth_time = state%time
    end associate
  end subroutine follow_growth

  !> At the end of a run, warn if the motion has gained energy.
  subroutine warn_growth(state)
    type(state_t), intent(in) :: state
    character(:), allocatable :: hint

    associate (energy => state%energy)
      if (.not. energy%growth > GROWTH*energy%largest) return
      hint = 'an impact needs steps in which the bodies penetrate only a little: use DT with a ' &
             //'smaller dt'
      if (state%dynamics%method /= BACKWARD_EULER) then
        hint = hint//', or TRANsient,BACK, which dissipates energy'
      end if
      call warn('the motion has gained energy: at time '//to_text(energy%growth_time) &
                //' bodies, contacts and motion together contain '//to_text(energy%growth, 3) &
                //' more energy than loads and supports have supplied, ' &
                //to_text(100*energy%growth/energy%largest, 3) &
                //' % of the largest energy of the run', hint=hint)
    end associate
  end subroutine warn_growth

  !> Has TRANsient switched on inertia? The inertia that follows a path (ARCLength) has a density of
  !! its own, and its steps need not conserve energy.
  pure logical function moves_by_deck(state) result(yes)
    type(state_t), intent(in) :: state

    yes = state%dynamics%on .and. state%dynamics%density < 0.0_wp
  end function moves_by_deck

  !> Excess of the energies of contact and motion over the work done on them [F L].
  pure real(wp) function excess_without_bodies(state, contact) result(excess)
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: contact      !! energy of contacts [F L]

    associate (energy => state%energy)
      excess = contact - energy%contact + energy%kinetic - energy%inertia
    end associate
  end function excess_without_bodies

end module energy_growth
