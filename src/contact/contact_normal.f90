!> PENAlty: pressure proportional to the penetration.
!!
!! prop(1)  penalty parameter eps_n [F/L^3]
!! Source:  Corbett and Sauer 2015, eq. (26)
module contact_normal
  use base_kinds, only: wp
  use contact_type, only: contact_law_t, NORMAL
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
    row%nprop = 1
    row%normal => pressure
  end function describe

  !> p = <multiplier - eps_n gap>; without augmentation the multiplier is zero.
  pure subroutine pressure(prop, gap, multiplier, p, dp)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: gap, multiplier
    real(wp), intent(out) :: p, dp

    p = multiplier - prop(1)*gap
    dp = -prop(1)
    if (p > 0.0_wp) return
    p = 0.0_wp
    dp = 0.0_wp
  end subroutine pressure

end module contact_normal
