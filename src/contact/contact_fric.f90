!> COULomb: stick by a tangential penalty, and slip at mu times the pressure.
!!
!! prop(MU)                  coefficient of friction mu [-]
!! prop(TANGENTIAL_PENALTY)  tangential penalty parameter eps_t [F/L^3]
!! Source:  Corbett and Sauer 2015, eqs (27) to (29), predictor and corrector; sliding points as in
!!          Sauer and De Lorenzis 2015
module contact_fric
  use base_kinds, only: wp
  use contact_type, only: contact_law_t, FRICTION, STICK, SLIP, MU, TANGENTIAL_PENALTY
  implicit none
  private
  public :: describe, coulomb

  !> A slip that is smaller than this, relative to the elastic part, is a rounding error. Where
  !! nothing moves, a point that slipped before is exactly at its limit, and sticks.
  real(wp), parameter, public :: NO_SLIP = 1.0e-9_wp

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'COULomb'
    row%role = FRICTION
    row%usage = 'FRICtion COULomb mu [PENAlty eps | AUTO]'
    row%source = 'Coulomb friction; Corbett and Sauer 2015, eqs (27) to (29)'
    row%nprop = 2
    row%friction => coulomb
  end function describe

  !> Predict stick. If the traction then exceeds mu p, the corrector returns it to mu p. If `ahead`
  !! is not negative and d is not zero, the point slips at mu p, whatever the prediction is.
  !!
  !! Perpendicular to the direction of slip, the stiffness -dt/dd is mu p divided by |d|, where d is
  !! the vector from the sliding point. At the start of a step, d contains hardly more than its
  !! elastic part, so that this stiffness may be a hundred times too large. The expected slip
  !! `ahead` is therefore added to |d|.
  pure subroutine coulomb(prop, d, p, ahead, t, dtdd, dtdp, elastic, state)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: d(3), p, ahead
    real(wp), intent(out) :: t(3), dtdd(3, 3), dtdp(3), elastic(3)
    integer, intent(out) :: state
    real(wp) :: most, eps, size, across, e(3)
    integer :: i

    most = prop(MU)*p
    eps = prop(TANGENTIAL_PENALTY)
    size = norm2(d)
    dtdd = 0.0_wp
    dtdp = 0.0_wp
    if (.not. most > 0.0_wp) then ! without friction, d = 0 is slip too
      state = SLIP
      t = 0.0_wp
      elastic = 0.0_wp
      return
    end if
    if (eps*size <= (1.0_wp + NO_SLIP)*most .and. .not. (ahead >= 0.0_wp .and. size > 0.0_wp)) then
      state = STICK
      t = -eps*d
      elastic = d
      do i = 1, 3
        dtdd(i, i) = -eps
      end do
      return
    end if
    state = SLIP
    e = d/size
    t = -most*e
    elastic = (most/eps)*e
    dtdp = -prop(MU)*e
    across = most/(size + max(ahead, 0.0_wp))
    do i = 1, 3
      dtdd(:, i) = across*e*e(i)
      dtdd(i, i) = dtdd(i, i) - across
    end do
  end subroutine coulomb

end module contact_fric
