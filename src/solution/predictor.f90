!> Predictor of a step with contact: continues the displacements as in the previous step.
!!
!! Where bodies slide, each step resembles the previous one. If Newton's method starts from the
!! continued displacements, it may need only half as many iterations. Each body continues with the
!! rigid motion that fits its last increment best; the remainder of the increment, which is its
!! deformation, is continued linearly and turns with the body. If rotations were continued linearly,
!! bodies would grow. Prescribed displacements take their values at the end of the step.
!!
!! There is a predictor only if all contacts of the model use the mortar scheme. The iterations of
!! HALFpass thus remain those of the published scheme.
module predictor
  use base_kinds, only: wp
  use contact_pair, only: MORTAR
  use load_curve, only: table_factor
  use model, only: model_t, state_t
  use rigid_modes, only: find_pieces
  use screw_motion, only: screw_t, fit_screw, continue_screw, rotate
  implicit none
  private
  public :: predict

  !> Largest change of the rate of a load table, relative to the larger rate.
  real(wp), parameter :: SAME_RATE = 0.5_wp
  !> Longest step for which displacements are predicted, relative to the previous step.
  real(wp), parameter :: LONGEST = 4.0_wp

contains

  !> Replace the displacements by predicted ones if the previous step allows a prediction.
  subroutine predict(model, state, move, piece, predicted)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: move(:, :)       !! (3, nnode) prescribed increments [L]
    integer, allocatable, intent(inout) :: piece(:) !! (nnode) body of a node; found here if unknown
    logical, intent(out) :: predicted
    real(wp) :: goes_on(3, size(move, 2))    ! continued increments [L]
    real(wp) :: ratio

    predicted = .false.
    if (size(model%contact) == 0) return
    if (.not. all(model%contact%scheme == MORTAR)) return
    if (state%dynamics%on .or. .not. (state%last_dt > 0.0_wp .and. state%dt > 0.0_wp)) return
    ratio = state%dt/state%last_dt
    if (ratio > LONGEST .or. .not. loads_go_on(state)) return
    if (.not. any(abs(state%last_increment) > 0.0_wp)) return
    if (.not. allocated(piece)) call find_pieces(model%mesh, piece)
    call continue_increment(model%mesh%xr + state%u_step, state%last_increment, ratio, piece, &
                            goes_on)
    state%u = state%u + merge(goes_on, move, model%eq /= 0)
    ! Enhanced parameters are not predicted, because their derivatives are not known after a
    ! restart.
    state%u_base = state%u
    predicted = .true.
  end subroutine predict

  !> The increment from the positions x that continues the last increment in a step that is `ratio`
  !! times as long.
  subroutine continue_increment(x, last, ratio, piece, increment)
    real(wp), intent(in) :: x(:, :)          !! (3, nnode) [L]
    real(wp), intent(in) :: last(:, :)       !! (3, nnode) the last increment, which led to x [L]
    real(wp), intent(in) :: ratio
    integer, intent(in) :: piece(:)          !! (nnode) body of a node; 0: none
    real(wp), intent(out) :: increment(:, :) !! (3, nnode) [L]
    type(screw_t) :: screw
    integer, allocatable :: node(:)
    real(wp) :: rest(3)
    integer :: b, i, k

    increment = ratio*last
    do b = 1, maxval(piece)
      node = pack([(i, i=1, size(piece))], piece == b)
      call fit_screw(x(:, node) - last(:, node), x(:, node), screw)
      do k = 1, size(node)
        i = node(k)
        rest = x(:, i) - continue_screw(screw, 1.0_wp, x(:, i) - last(:, i))
        increment(:, i) = continue_screw(screw, ratio, x(:, i)) - x(:, i) &
                          + ratio*rotate(ratio*screw%w, rest)
      end do
    end do
  end subroutine continue_increment

  !> Do all load tables continue at about the same rate as in the previous step?
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
