!> Warns about backward Euler steps of changing length while supports accelerate.
!!
!! Velocities of this method are the means of steps, (u_1 - u_0)/dt. Their difference over dt is the
!! acceleration if the steps have equal lengths; otherwise it is (dt_0 + dt)/(2 dt) times the
!! acceleration, with the length dt_0 of the step before. Bodies that loads move are not affected,
!! because there the force is given, and not the motion. Where the motion is prescribed, the
!! inertial forces of the first step of a new length are wrong by this factor, however small the
!! steps are (Brenan, Campbell and Petzold 1996 describe this for constrained motions).
module uneven_steps
  use base_kinds, only: wp
  use base_log, only: warn
  use dynamics_type, only: BACKWARD_EULER
  use model, only: model_t, state_t
  implicit none
  private
  public :: find_uneven

  real(wp), parameter :: EVEN = 1.0e-2_wp   !! change of the length of steps that is tolerated
  real(wp), parameter :: STEADY = 1.0e-6_wp !! change of a velocity that counts as none

contains

  !> Before a step is accepted: warn once if its length differs from that of the step before while
  !! prescribed velocities change. A motion that begins from rest has no step before.
  subroutine find_uneven(model, state, warned)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(inout) :: warned
    real(wp) :: before, change, now

    associate (dynamics => state%dynamics)
      if (warned .or. .not. dynamics%on .or. dynamics%method /= BACKWARD_EULER) return
      if (dynamics%density >= 0.0_wp) return ! the inertia of ARCLength
      if (.not. (state%last_dt > 0.0_wp .and. state%dt > 0.0_wp)) return
      if (abs(state%dt - state%last_dt) <= EVEN*state%last_dt) return
      before = maxval(abs(dynamics%v), model%eq == 0)
      now = maxval(abs(state%u - state%u_step), model%eq == 0)/state%dt
      change = maxval(abs((state%u - state%u_step)/state%dt - dynamics%v), model%eq == 0)
    end associate
    if (.not. before > 0.0_wp .or. change <= STEADY*max(before, now)) return
    warned = .true.
    call warn('with TRANsient,BACK the length of steps has changed while supports accelerate: ' &
              //'forces of supports and contacts in the first step of a new length are wrong by ' &
              //'the factor (old + new)/(2 new) where they move masses', &
              hint='use steps of equal length (AUTO with dtmax = DT and no cut-backs), or ' &
              //'TRANsient,NEWMark')
  end subroutine find_uneven

end module uneven_steps
