!> Steps under load control that jump over a limit point to a distant part of the path.
!!
!! In equilibrium, the work of forces that increase from f_0 to f_1 along an increment du lies
!! between w_0 = f_0.du and w_1 = f_1.du, and bodies and contacts store or dissipate all of it. It
!! is the mean of both if the model is linear, less if it stiffens in the step, and more if it
!! softens. At a limit point the model jumps under constant load, and the energy that is released
!! there becomes motion in reality: bodies and contacts have less energy than the forces have
!! supplied.
!!
!! A step counts as a jump if it has two properties that can occur together only if the model is
!! stiff, then soft and then stiff again within the step: the increment is much longer than the
!! tangent at its start and the previous step suggest (or one of them, if the other is not known),
!! and the energies increase by less than w_0 + LEAST (w_1 - w_0). If the increment is much longer
!! than the previous step suggests, but not much longer than the tangent suggests, as near a limit
!! point, the step counts as a jump only if the energies increase by less than w_0, which is
!! impossible in equilibrium. The magnitude of the work of the supports, whose forces are not part
!! of f_0 and f_1, is subtracted from both limits.
module load_jump
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use energy_balance, only: stored_energy, energy_at_start
  use external_load, only: load_rates
  use model, only: model_t, state_t
  use newton_type, only: newton_t
  implicit none
  private
  public :: jump_t, suspect_jump, report_jump

  real(wp), parameter :: MUCH_LONGER = 2.0_wp !! increment, relative to the one that is expected
  real(wp), parameter :: LEAST = 0.3_wp       !! fraction of w_1 - w_0 (see above)
  !> Missing energy that counts, relative to the energy that is stored or has been dissipated.
  real(wp), parameter :: VISIBLE = 0.01_wp

  !> What is known about a step before it is accepted.
  type :: jump_t
    logical :: suspected = .false.
    real(wp) :: work(2) = 0.0_wp         !! w_0 and w_1 [F L]
    real(wp) :: least = 0.0_wp           !! least change of the energies without a jump [F L]
    real(wp) :: energy = 0.0_wp          !! energy of bodies and contacts when the step began [F L]
  end type jump_t

contains

  !> Before a converged step is accepted, find out whether it may be a jump. Only then are energies
  !! computed, so that other steps cost nothing.
  subroutine suspect_jump(newton, model, state, jump)
    type(newton_t), intent(in) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(jump_t), intent(out) :: jump
    type(state_t) :: start
    real(wp), allocatable :: f(:, :)
    real(wp) :: before, supports
    logical :: longer

    if (state%dynamics%on .or. newton%constraint%on .or. newton%secant%count > 0) return
    if (newton%hold%active .or. .not. newton%converged) return
    before = 0.0_wp
    associate (du => state%u - state%u_step, w => jump%work)
      w(2) = sum(newton%asm%f_ext*du)
      if (.not. w(2) > 0.0_wp) return
      if (state%last_dt > 0.0_wp) then
        before = sum(newton%asm%f_ext*state%last_increment)*state%dt/state%last_dt
      end if
      if (w(2) < MUCH_LONGER*before) return
      start%u = state%u_step
      if (allocated(state%factor_step)) then
        allocate (f(3, model%mesh%nnode))
        call load_rates(model, start, state%factor_step, f)
        w(1) = sum(f*du)
      end if
      supports = max(abs(sum(state%reaction*du, mask=model%eq == 0)), &
                     abs(sum(state%reaction_step*du, mask=model%eq == 0)))
    end associate
    if (jump%work(1) < 0.0_wp .or. jump%work(2) < jump%work(1)) return
    jump%least = jump%work(1) - supports
    longer = before > 0.0_wp
    if (newton%first_energy > 0.0_wp) then ! the work of the increment that the tangent predicts
      longer = jump%work(2) - jump%work(1) >= MUCH_LONGER*newton%first_energy
    else if (.not. longer) then
      return
    end if
    if (longer) jump%least = jump%least + LEAST*(jump%work(2) - jump%work(1))
    if (.not. jump%least > 0.0_wp) return
    jump%suspected = .true.
    jump%energy = energy_at_start(model, state)
  end subroutine suspect_jump

  !> After the step has been accepted, warn if it was a jump.
  subroutine report_jump(jump, model, state, found)
    type(jump_t), intent(in) :: jump
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(out) :: found
    real(wp) :: energy, gain, mean

    energy = stored_energy(model, state)
    gain = energy - jump%energy
    found = jump%least - gain > VISIBLE*(energy + jump%energy)
    if (.not. found) return
    mean = 0.5_wp*sum(jump%work)
    call warn('step '//to_text(state%step)//' jumps to a distant state at time ' &
              //to_text(state%time)//': its loads do work of about '//to_text(mean, 3) &
              //', but bodies and contacts absorb only '//to_text(gain, 3), hint='the rest ' &
              //'would set the model in motion: load control has skipped a limit point; follow ' &
              //'the path with ARCLength,LENGth together with AUTO and smaller steps, or compute ' &
              //'the motion with TRANsient')
  end subroutine report_jump

end module load_jump
