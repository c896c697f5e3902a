!> History of the integration points of contacts: made, accepted, brought back.
module contact_history
  use base_kinds, only: wp
  use contact_foot, only: foot_t
  use contact_pair, only: contact_t, contact_state_t, contact_points_t
  use contact_type, only: OPEN, MAX_PAST
  implicit none
  private
  public :: new_contact_state, restore_contact_step, keep_contact_step, had_touched, &
            look_aside

  real(wp), parameter, public :: ASIDE = 0.1_wp !! of DEPTh: at a surface, not far off it

contains

  !> No point has a foot yet; a rigid side has no points.
  subroutine new_contact_state(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(out) :: state
    integer :: k, np

    do k = 1, 2
      np = contact%side(k)%nelem*contact%nq
      if (contact%side(k)%rigid) np = 0
      call new_points(np, np/max(1, contact%nq), state%side(k))
    end do
  end subroutine new_contact_state

  subroutine new_points(np, nelem, points)
    integer, intent(in) :: np, nelem
    type(contact_points_t), intent(out) :: points

    allocate (points%foot(np), points%foot_step(np), points%slide(np), source=0)
    allocate (points%foot_xi(2, np), points%foot_xi_step(2, np), points%slide_xi(2, np), &
              source=0.0_wp)
    allocate (points%multiplier(np), points%multiplier_step(np), source=0.0_wp)
    allocate (points%pressure(np), points%area(np), source=0.0_wp)
    allocate (points%gap(np), source=huge(1.0_wp))
    allocate (points%traction(3, np), points%elastic(3, np), source=0.0_wp)
    allocate (points%friction(3, np), points%cohesion(3, np), source=0.0_wp)
    allocate (points%state(np), points%state_step(np), source=OPEN)
    allocate (points%slip(np), points%slip_rate(np), source=0.0_wp)
    allocate (points%aside(np), points%cut(nelem), source=.false.)
    allocate (points%bond(np), source=0)
    allocate (points%bond_xi(2, np), points%area0(np), points%opening(np), source=0.0_wp)
    allocate (points%past(MAX_PAST, np), points%past_step(MAX_PAST, np), source=0.0_wp)
    allocate (points%opening_step(np), source=0.0_wp)
    allocate (points%energy(3, np), points%pull(3, np), source=0.0_wp)
  end subroutine new_points

  !> A cut: projections start where they stood at the start of the step.
  subroutine restore_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    do k = 1, 2
      state%side(k)%foot = state%side(k)%foot_step
      state%side(k)%foot_xi = state%side(k)%foot_xi_step
      state%side(k)%multiplier = state%side(k)%multiplier_step
      state%side(k)%past = state%side(k)%past_step
      state%side(k)%opening = state%side(k)%opening_step
      state%side(k)%state = state%side(k)%state_step
      state%side(k)%fresh = .true.
    end do
  end subroutine restore_contact_step

  !> The step is done: what is now is what a cut brings back.
  subroutine keep_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    do k = 1, 2
      state%side(k)%foot_step = state%side(k)%foot
      state%side(k)%foot_xi_step = state%side(k)%foot_xi
      state%side(k)%multiplier_step = state%side(k)%multiplier
      state%side(k)%past_step = state%side(k)%past
      state%side(k)%opening_step = state%side(k)%opening
      state%side(k)%state_step = state%side(k)%state
      state%side(k)%slip_rate = 0.0_wp
      if (state%side(k)%dt > 0.0_wp) then
        state%side(k)%slip_rate = state%side(k)%slip/state%side(k)%dt
      end if
      state%side(k)%fresh = .true.
    end do
  end subroutine keep_contact_step

  !> Feet of an accepted step: which points stand beside the other surface, no higher than `depth`
  !! above its tangent plane, or have stood there and are deeper now.
  pure subroutine look_aside(feet, depth, points)
    type(foot_t), intent(in) :: feet(:)    !! (np)
    real(wp), intent(in) :: depth          !! [L]
    type(contact_points_t), intent(inout) :: points
    integer :: i

    do i = 1, size(feet)
      if (feet(i)%elem > 0) then
        points%aside(i) = points%aside(i) .and. feet(i)%gap < -depth
      else if (feet(i)%border > 0) then
        points%aside(i) = feet(i)%border_gap < depth
      end if
    end do
  end subroutine look_aside

  !> A point was in contact when the last step ended.
  pure logical function had_touched(state)
    type(contact_state_t), intent(in) :: state

    had_touched = any(state%side(1)%state_step /= OPEN) &
                  .or. any(state%side(2)%state_step /= OPEN)
  end function had_touched

end module contact_history
