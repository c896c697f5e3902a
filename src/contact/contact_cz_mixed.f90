!> MIXEd: two exponential laws, one for the normal opening and one for shear, coupled by damage.
!!
!! prop(1)  largest normal traction Tn [F/L^2]
!! prop(2)  opening gn at which the normal traction is Tn [L]
!! prop(3)  largest shear traction Tt [F/L^2]
!! prop(4)  opening gt at which the shear traction is Tt [L]
!! Source:  van den Bosch, Schreurs and Geers 2006: a law of Xu and Needleman's type that stays
!!          physical if the two energies differ. Here it has damage instead of being reversible,
!!          cf. Kolluri et al. 2014. The energies per area are e Tn gn and sqrt(e) Tt gt
module contact_cz_mixed
  use base_kinds, only: wp
  use contact_secant, only: pull_by_secants, MODES
  use contact_type, only: contact_law_t, cohesion_t, COHESIVE
  implicit none
  private
  public :: describe

  !> Openings at which a bond is released: 8 gn, where 0.7 % of Tn and 0.3 % of Tt are left, and
  !! 4 gt, where 0.2 % of Tt and 0.03 % of Tn are left.
  real(wp), parameter :: RELEASED_AT(2) = [8.0_wp, 4.0_wp]

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'MIXEd'
    row%role = COHESIVE
    row%usage = 'COHEsive MIXEd Tn gn Tt gt'
    row%source = 'exponential with two energies and damage; after van den Bosch et al. 2006'
    row%nprop = 4
    row%oriented = .true.
    row%cohesive => mixed_law
    row%released => released
  end function describe

  pure subroutine mixed_law(prop, lag, g, n, past, now, c)
    real(wp), intent(in) :: prop(:), lag, g(3), n(3), past(:)
    real(wp), intent(out) :: now(:)
    type(cohesion_t), intent(out) :: c

    call pull_by_secants(secants, MODES, prop, minval(RELEASED_AT*prop(2:4:2)), lag, g, n, past, &
                         now, c)
  end subroutine mixed_law

  !> Secants: with x = k_1/gn and y = k_2/gt, s_n = (Tn/gn) e exp(-x) exp(-y^2/2),
  !! s_t = (Tt/gt) sqrt(e) exp(-y^2/2) (1 + x) exp(-x).
  pure subroutine secants(prop, k, s, ds)
    real(wp), intent(in) :: prop(:), k(2)
    real(wp), intent(out) :: s(2), ds(2, 2)
    real(wp) :: x, y, left

    x = k(1)/prop(2)
    y = k(2)/prop(4)
    left = exp(-x - 0.5_wp*y*y)
    s(1) = prop(1)/prop(2)*exp(1.0_wp)*left
    s(2) = prop(3)/prop(4)*exp(0.5_wp)*left
    ds(1, 1) = -s(1)/prop(2)
    ds(2, 1) = -s(2)*x/prop(2)
    s(2) = s(2)*(1.0_wp + x)
    ds(:, 2) = -s*y/prop(4)
  end subroutine secants

  pure subroutine released(prop, opening)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(out) :: opening(2)

    opening = RELEASED_AT*prop(2:4:2)
  end subroutine released

end module contact_cz_mixed
