!> EXPOnential: a cohesive traction that rises to T0 at the opening g0 and then decays. It has two
!! rows in the table: reversible, and IRREversible with linear unloading to the origin.
!!
!! prop(1)  largest traction T0 [F/L^2]
!! prop(2)  opening g0 at which the traction is T0 [L]
!! Source:  Corbett and Sauer 2015, eq. (31), after Xu and Needleman 1993. The traction is per
!!          reference area, and the energy per area is e T0 g0 in every mixture of modes. Unloading
!!          follows Camacho and Ortiz 1996: the largest opening is found from the gap g without its
!!          compressive part, so that compression causes no damage. When the bond has broken, only
!!          the penalty resists compression
module contact_cz
  use base_kinds, only: wp
  use contact_secant, only: pull_by_secants, REVERSIBLE, WHOLE
  use contact_type, only: contact_law_t, cohesion_t, COHESIVE
  implicit none
  private
  public :: describe, irreversible

  real(wp), parameter :: RELEASED_AT = 8.0_wp !! opening, divided by g0, with 0.7 % of T0 left

contains

  !> The reversible row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'EXPOnential'
    row%role = COHESIVE
    row%usage = 'COHEsive EXPOnential T0 g0'
    row%source = 'exponential mixed mode, reversible; Corbett and Sauer 2015, eq. (31)'
    row%nprop = 2
    row%heals = .true.
    row%cohesive => reversible_law
    row%released => released
  end function describe

  !> The irreversible row.
  function irreversible() result(row)
    type(contact_law_t) :: row

    row = describe()
    row%option = 'IRREversible'
    row%source = 'envelope of Corbett and Sauer 2015, eq. (31); unloading to the origin'
    row%oriented = .true.
    row%heals = .false.
    row%cohesive => irreversible_law
  end function irreversible

  !> The traction T = -T0 (g/g0) exp(1 - |g|/g0), which also acts in compression.
  pure subroutine reversible_law(prop, lag, g, n, past, now, c)
    real(wp), intent(in) :: prop(:), lag, g(3), n(3), past(:)
    real(wp), intent(out) :: now(:)
    type(cohesion_t), intent(out) :: c

    call pull_by_secants(secants, REVERSIBLE, prop, RELEASED_AT*prop(2), lag, g, 0.0_wp*n, past, &
                         now, c, potential)
  end subroutine reversible_law

  !> T = -(T0/g0) exp(1 - k/g0) g, where k is the largest opening so far.
  pure subroutine irreversible_law(prop, lag, g, n, past, now, c)
    real(wp), intent(in) :: prop(:), lag, g(3), n(3), past(:)
    real(wp), intent(out) :: now(:)
    type(cohesion_t), intent(out) :: c

    call pull_by_secants(secants, WHOLE, prop, RELEASED_AT*prop(2), lag, g, n, past, now, c)
  end subroutine irreversible_law

  !> Both secants are (T0/g0) exp(1 - k_1/g0).
  pure subroutine secants(prop, k, s, ds)
    real(wp), intent(in) :: prop(:), k(2)
    real(wp), intent(out) :: s(2), ds(2, 2)

    s = prop(1)/prop(2)*exp(1.0_wp - k(1)/prop(2))
    ds(:, 1) = -s/prop(2)
    ds(:, 2) = 0.0_wp
  end subroutine secants

  !> Potential e T0 g0 (1 - (1 + x) exp(-x)) with x = k/g0. For small x a series is used, because
  !! the difference would lose its digits.
  pure function potential(prop, k) result(energy)
    real(wp), intent(in) :: prop(:), k
    real(wp) :: energy
    real(wp) :: x

    x = k/prop(2)
    if (x < 1.0e-3_wp) then
      energy = x*x*(0.5_wp - x*(1.0_wp/3.0_wp - x/8.0_wp))
    else
      energy = 1.0_wp - (1.0_wp + x)*exp(-x)
    end if
    energy = exp(1.0_wp)*prop(1)*prop(2)*energy
  end function potential

  !> Opening at which a bond counts as released, 8 g0 in both modes.
  pure subroutine released(prop, opening)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(out) :: opening(2)

    opening = RELEASED_AT*prop(2)
  end subroutine released

end module contact_cz
