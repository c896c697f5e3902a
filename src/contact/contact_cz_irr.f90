!> EXPOnential ... IRREversible: the envelope of eq. (31), and unloading straight to the origin.
!!
!! prop(1)  largest traction T0 [F/L^2]
!! prop(2)  opening g0 at which it acts [L]
!! Source:  Corbett and Sauer 2015, eq. (31); unloading after Camacho and Ortiz 1996. The worst
!!          opening is that of the vector g without its part that presses: compression does not
!!          damage, and is left to the penalty as the bond tears
module contact_cz_irr
  use base_kinds, only: wp
  use contact_cz, only: secants, released
  use contact_secant, only: pull_by_secants, WHOLE
  use contact_type, only: contact_law_t, cohesion_t, COHESIVE
  implicit none
  private
  public :: describe, irreversible

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'EXPOnential'
    row%option = 'IRREversible'
    row%role = COHESIVE
    row%usage = 'COHEsive EXPOnential T0 g0 [IRREversible] [VISCous tau]'
    row%source = 'exponential, unloading to the origin; envelope Corbett and Sauer 2015, eq. (31)'
    row%nprop = 2
    row%oriented = .true.
    row%cohesive => irreversible
    row%released => released
  end function describe

  !> T = -(T0/g0) exp(1 - k/g0) g, k the worst opening.
  pure subroutine irreversible(prop, lag, g, n, past, now, c)
    real(wp), intent(in) :: prop(:), lag, g(3), n(3), past(:)
    real(wp), intent(out) :: now(:)
    type(cohesion_t), intent(out) :: c

    call pull_by_secants(secants, WHOLE, prop, released(prop), lag, g, n, past, now, c)
  end subroutine irreversible

end module contact_cz_irr
