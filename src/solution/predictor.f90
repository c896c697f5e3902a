!> Predictor of a step with contact: displacements go on as in the last step.
!!
!! Where bodies slide, each step resembles the one before, and Newton's iteration that starts from
!! the continued displacements saves up to half of its iterations. Prescribed displacements take
!! their values at the end of the step. HALFpass has no predictor, so that its iterations stay those
!! of the published scheme; where the schemes are mixed in a model, neither do the others.
module predictor
  use base_kinds, only: wp
  use contact_pair, only: MORTAR
  use load_curve, only: table_factor
  use model, only: model_t, state_t
  implicit none
  private
  public :: predict

  !> Largest change of the rate of a load table, relative to the larger rate.
  real(wp), parameter :: SAME_RATE = 0.5_wp
  !> Longest step, relative to the last one.
  real(wp), parameter :: LONGEST = 4.0_wp

contains

  !> Move the displacements to the predicted ones, if the last step allows to predict them.
  subroutine predict(model, state, move, predicted)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: move(:, :)       !! (3, nnode) prescribed increments [L]
    logical, intent(out) :: predicted
    integer :: i, n
    real(wp) :: ratio

    predicted = .false.
    if (size(model%contact) == 0) return
    if (.not. all(model%contact%scheme == MORTAR)) return
    if (state%dynamics%on .or. .not. (state%last_dt > 0.0_wp .and. state%dt > 0.0_wp)) return
    ratio = state%dt/state%last_dt
    if (ratio > LONGEST .or. .not. loads_go_on(state)) return
    if (.not. any(abs(state%last_increment) > 0.0_wp)) return
    do n = 1, size(model%eq, 2)
      do i = 1, 3
        if (model%eq(i, n) /= 0) then
          state%u(i, n) = state%u(i, n) + ratio*state%last_increment(i, n)
        else
          state%u(i, n) = state%u(i, n) + move(i, n)
        end if
      end do
    end do
    ! Enhanced parameters stay: after a restart, their derivatives are not known.
    state%u_base = state%u
    predicted = .true.
  end subroutine predict

  !> Do all load tables go on at about the rate of the last step?
  pure logical function loads_go_on(state) result(yes)
    type(state_t), intent(in) :: state
    real(wp) :: last, now, start
    integer :: i

    yes = .true.
    do i = 1, size(state%table)
      start = table_factor(state%table(i), state%time - state%dt)
      now = (state%factor(i) - start)/state%dt
      last = (start - table_factor(state%table(i), state%time - state%dt - state%last_dt)) &
             /state%last_dt
      yes = yes .and. abs(now - last) <= SAME_RATE*max(abs(now), abs(last))
    end do
  end function loads_go_on

end module predictor
