!> EXPOnential: cohesive traction that rises to T0 at the opening g0 and then decays.
!!
!! prop(1)  largest traction T0 [F/L^2]
!! prop(2)  opening g0 at which it acts [L]
!! Source:  Corbett and Sauer 2015, eq. (31), after Xu and Needleman 1993; on the reference area,
!!          mixed mode, reversible: energy e T0 g0 an area
module contact_cz
  use base_kinds, only: wp
  use contact_type, only: contact_law_t, COHESIVE
  implicit none
  private
  public :: describe, exponential, released

  real(wp), parameter :: RELEASED_AT = 8.0_wp !! openings g0: 0.7 % of T0 is left

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'EXPOnential'
    row%role = COHESIVE
    row%usage = 'COHEsive EXPOnential T0 g0'
    row%source = 'exponential mixed mode, reversible; Corbett and Sauer 2015, eq. (31)'
    row%nprop = 2
    row%cohesive => exponential
    row%released => released
  end function describe

  !> T = -T0 (g/g0) exp(1 - |g|/g0), also where g presses.
  pure subroutine exponential(prop, g, worst, t, dtdg)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: g(3)
    real(wp), intent(inout) :: worst
    real(wp), intent(out) :: t(3), dtdg(3, 3)
    real(wp) :: r, stiff
    integer :: i

    r = norm2(g)
    worst = max(worst, r)
    stiff = prop(1)/prop(2)*exp(1.0_wp - r/prop(2))
    t = -stiff*g
    dtdg = 0.0_wp
    do i = 1, 3
      if (r > 0.0_wp) dtdg(:, i) = (stiff/(prop(2)*r))*g*g(i)
      dtdg(i, i) = dtdg(i, i) - stiff
    end do
  end subroutine exponential

  !> 8 g0.
  pure function released(prop) result(opening)
    real(wp), intent(in) :: prop(:)
    real(wp) :: opening

    opening = RELEASED_AT*prop(2)
  end function released

end module contact_cz
