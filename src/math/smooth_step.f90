!> A smooth step from 0 to 1.
module smooth_step
  use base_kinds, only: wp
  implicit none
  private
  public :: smoothstep

contains

  !> 3 z^2 - 2 z^3: it rises from 0 to 1 between z = 0 and z = 1, with zero slope at both ends.
  pure elemental real(wp) function smoothstep(z)
    real(wp), intent(in) :: z !! 0 to 1

    smoothstep = z*z*(3.0_wp - 2*z)
  end function smoothstep

end module smooth_step
