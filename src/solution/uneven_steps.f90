!> Warns where forces of accelerated supports are wrong because the length of steps or the scheme of
!! time integration has changed. Bodies that loads move are not affected, because there the force is
!! given, and not the motion.
!!
!! Velocities of the backward Euler scheme are the means of steps, (u_1 - u_0)/dt. Their difference
!! over dt is the acceleration if the steps have equal lengths; otherwise it is (dt_0 + dt)/(2 dt)
!! times the acceleration, with the length dt_0 of the step before. Where the motion is prescribed,
!! the inertial forces of the first step of a new length are wrong by this factor, however small the
!! steps are (Brenan, Campbell and Petzold 1996 describe this for constrained motions).
!!
!! The velocities of Newmark's scheme and of HHT (see dynamics_type) are wrong by -dt_0^2 u'''/3. In
!! a step of another length the acceleration is therefore wrong by 2/3 (dt_0^2/dt - dt) u'''. It
!! differs from the stored acceleration, which is that of the middle of the last two steps, by
!! (dt + dt_0)(dt + 2 dt_0) u'''/(3 dt), and 2 (dt_0 - dt)/(2 dt_0 + dt) of this difference is the
!! error. Later steps inherit a part of it.
!!
!! A velocity that is the mean of a step is that of its middle. To the other schemes, which take it
!! for the one at the end of the step, it makes the first acceleration twice as large; in the other
!! direction, it becomes half as large.
module uneven_steps
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use dynamics_type, only: BACKWARD_EULER
  use inertia, only: driven_marks
  use model, only: model_t, state_t
  implicit none
  private
  public :: find_uneven, warn_scheme

  real(wp), parameter :: EVEN = 1.0e-2_wp   !! change of the length of steps that is tolerated
  real(wp), parameter :: STEADY = 1.0e-6_wp !! change of a velocity that counts as none
  real(wp), parameter :: EXACT = 1.0e-2_wp  !! error of an acceleration that is tolerated

contains

  !> Before a step is accepted: warn once if its length differs from that of the step before while
  !! prescribed velocities change or, with Newmark's scheme and HHT, prescribed accelerations. A
  !! motion that begins from rest has no step before.
  subroutine find_uneven(model, state, warned)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical, intent(inout) :: warned
    character(*), parameter :: HINT = 'use steps of equal length: a DT that divides the times of ' &
                               //'the corners of all load tables and, with AUTO, dtmax = DT and ' &
                               //'no cut-backs'
    logical :: driven(3, size(state%u, 2))
    real(wp) :: before, change, now

    associate (dynamics => state%dynamics)
      if (warned .or. .not. dynamics%on) return
      if (dynamics%density >= 0.0_wp) return ! the inertia of ARCLength
      if (.not. (state%last_dt > 0.0_wp .and. state%dt > 0.0_wp)) return
      if (abs(state%dt - state%last_dt) <= EVEN*state%last_dt) return
      driven = driven_marks(model)
      if (.not. any(driven)) return
      before = maxval(abs(dynamics%v), driven)
      now = maxval(abs(state%u - state%u_step), driven)/state%dt
      change = maxval(abs((state%u - state%u_step)/state%dt - dynamics%v), driven)
      if (.not. before > 0.0_wp .or. change <= STEADY*max(before, now)) return
      if (dynamics%method /= BACKWARD_EULER) then
        if (.not. share_of_error(state, driven) > EXACT) return
      end if
    end associate
    warned = .true.
    if (state%dynamics%method == BACKWARD_EULER) then
      call warn('with TRANsient,BACK the length of steps has changed while supports accelerate: ' &
                //'forces of supports and contacts in the first step of a new length are wrong ' &
                //'by the factor (old + new)/(2 new) where they move masses', hint=HINT)
    else
      call warn('with TRANsient,NEWMark or HHT the length of steps has changed while the ' &
                //'acceleration of supports changes: in step '//to_text(state%step)//' and the ' &
                //'next ones, forces of supports and contacts are wrong where they move masses, ' &
                //'at first by about 2/3 (old^2/new - new) times the rate of change of the ' &
                //'acceleration', hint=HINT)
    end if
  end subroutine find_uneven

  !> Estimate of the largest error of a prescribed acceleration with Newmark's scheme or HHT,
  !! relative to the largest prescribed acceleration.
  pure real(wp) function share_of_error(state, driven) result(share)
    type(state_t), intent(in) :: state
    logical, intent(in) :: driven(:, :)  !! (3, nnode) is the displacement prescribed?
    real(wp), allocatable :: a(:, :)
    real(wp) :: largest

    associate (dynamics => state%dynamics, dt => state%dt, dt_0 => state%last_dt)
      allocate (a, source=2.0_wp*((state%u - state%u_step)/dt - dynamics%v)/dt)
      largest = max(maxval(abs(a), driven), maxval(abs(dynamics%a), driven))
      share = maxval(abs(a - dynamics%a), driven)/largest &
              *2.0_wp*abs(dt_0 - dt)/(2.0_wp*dt_0 + dt)
    end associate
  end function share_of_error

  !> Warn if a TRANsient changes between the backward Euler scheme and the others while supports
  !! accelerate.
  subroutine warn_scheme(model, state, method, place)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state   !! with the method of the motion so far
    integer, intent(in) :: method        !! of the following steps
    type(place_t), intent(in) :: place
    character(:), allocatable :: factor
    logical :: driven(3, size(state%u, 2))
    real(wp) :: change

    associate (dynamics => state%dynamics)
      if ((dynamics%method == BACKWARD_EULER) .eqv. (method == BACKWARD_EULER)) return
      driven = driven_marks(model)
      if (.not. any(driven)) return
      change = state%last_dt*maxval(abs(dynamics%a), driven)
      if (.not. change > STEADY*maxval(abs(dynamics%v), driven)) return
    end associate
    factor = 'twice'
    if (method == BACKWARD_EULER) factor = 'half'
    call warn('TRANsient changes the scheme while supports accelerate: in the next step their ' &
              //'accelerations are taken to be '//factor//' as large as they are, however small ' &
              //'the step is, so that forces of supports and contacts are wrong where they move ' &
              //'masses', place, 'use one ' &
              //'scheme for the whole motion, or change it while supports rest or move uniformly')
  end subroutine warn_scheme

end module uneven_steps
