!> PENAlty: the pressure is proportional to the penetration. With SMOOth, a small penetration gives
!! a pressure that is proportional to its square.
!!
!! prop(PENALTY)    penalty parameter eps_n [F/L^3]
!! prop(SMOOTHING)  d of SMOOth [L]: below this penetration the pressure is quadratic; 0: no SMOOth
!! Source:  Corbett and Sauer 2015, eq. (26)
module contact_normal
  use base_kinds, only: wp
  use contact_type, only: contact_law_t, NORMAL, PENALTY, SMOOTHING
  implicit none
  private
  public :: describe, pressure

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'PENAlty'
    row%role = NORMAL
    row%usage = 'NORMal PENAlty eps | AUTO [factor]'
    row%source = 'penalty; Corbett and Sauer 2015, eq. (26)'
    row%nprop = 2
    row%normal => pressure
  end function describe

  !> Find p = <y> with y = multiplier - eps_n gap; without augmentation the multiplier is zero. If d
  !! > 0, p = y^2/(2 eps_n d) up to y = eps_n d, and p = y - eps_n d/2 beyond that. The derivative
  !! of p then has no jump, and it is zero where surfaces just touch. In y, the multiplier is
  !! replaced by the number for which p equals the multiplier at a gap of zero, so that augmentation
  !! closes the gap.
  pure subroutine pressure(prop, gap, multiplier, p, dp, energy)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: gap, multiplier
    real(wp), intent(out) :: p, dp, energy

    associate (eps => prop(PENALTY), d => prop(SMOOTHING))
      if (multiplier < 0.5_wp*eps*d) then
        p = sqrt(2*multiplier*eps*d) - eps*gap
      else
        p = multiplier + 0.5_wp*eps*d - eps*gap
      end if
      dp = -eps
      if (.not. p > 0.0_wp) then
        p = 0.0_wp
        dp = 0.0_wp
        energy = 0.0_wp
      else if (p < eps*d) then
        dp = -p/d
        energy = p**3/(6*eps**2*d)
        p = 0.5_wp*p*p/(eps*d)
      else
        p = p - 0.5_wp*eps*d
        energy = 0.5_wp*p*p/eps + eps*d**2/24
      end if
    end associate
  end subroutine pressure

end module contact_normal
