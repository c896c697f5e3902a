!> PPR: the potential of Park, Paulino and Roesler.
!!
!! prop(1:2)   energies phi_n, phi_t [F/L]
!! prop(3:4)   strengths sigma_max, tau_max [F/L^2]
!! prop(5:6)   shapes alpha, beta [-]: 2 makes the softening nearly linear, a smaller number gives a
!!             plateau, and a larger number gives a tail
!! prop(7:8)   lambda_n, lambda_t [-]: opening at the strength, divided by the final opening
!! prop(9:16)  derived from these: m, n [-]; final openings delta_n, delta_t [L]; constants Gamma_n,
!!             Gamma_t [F/L] or [-]; differences <phi_n - phi_t>, <phi_t - phi_n> [F/L]
!! Source:  Park, Paulino and Roesler 2009, J. Mech. Phys. Solids 57, 891-908; the tractions as in
!!          Park and Paulino 2012, Eng. Fract. Mech. 93, 239-262. Unloading is linear to the origin
!!          from the largest openings of both modes, on which both secants depend, so that damage
!!          never heals
module contact_ppr
  use base_kinds, only: wp
  use contact_secant, only: pull_by_secants, MODES
  use contact_type, only: contact_law_t, cohesion_t, COHESIVE
  implicit none
  private
  public :: describe

contains

  !> Row of the table of contact laws.
  function describe() result(row)
    type(contact_law_t) :: row

    row%name = 'PPR'
    row%role = COHESIVE
    row%usage = 'COHEsive PPR phi_n phi_t sig tau alpha beta lam_n lam_t'
    row%source = 'potential of Park, Paulino and Roesler 2009, unloading to the origin'
    row%nprop = 8
    row%oriented = .true.
    row%cohesive => ppr_law
    row%released => released
    row%prepare => prepare
  end function describe

  pure subroutine ppr_law(prop, lag, g, n, past, now, c)
    real(wp), intent(in) :: prop(:), lag, g(3), n(3), past(:)
    real(wp), intent(out) :: now(:)
    type(cohesion_t), intent(out) :: c

    call pull_by_secants(secants, MODES, prop, minval(prop(11:12)), lag, g, n, past, now, c)
  end subroutine ppr_law

  !> Compute prop(9:16) from the numbers of the deck. `wrong` is the position of a number for which
  !! this is impossible; 0: there is none.
  pure subroutine prepare(prop, wrong, hint)
    real(wp), intent(inout) :: prop(:)
    integer, intent(out) :: wrong
    character(:), allocatable, intent(out) :: hint
    real(wp) :: a, lam, m, largest
    integer :: i

    wrong = 0
    do i = 1, 2
      a = prop(4 + i)
      lam = prop(6 + i)
      if (.not. a > 1.0_wp) then
        wrong = 4 + i
        hint = 'alpha and beta must be greater than 1; with 2 the softening is nearly linear'
      else if (.not. a*lam**2 < 1.0_wp) then
        wrong = 6 + i
        hint = 'lam_n must be less than 1/sqrt(alpha), and lam_t less than 1/sqrt(beta); 0.01 to ' &
               //'0.2 are usual values'
      end if
      if (wrong > 0) return
      m = a*(a - 1.0_wp)*lam**2/(1.0_wp - a*lam**2)
      largest = a*lam*(1.0_wp - lam)**(a - 1.0_wp)*(a/m + 1.0_wp)*(lam*a/m + 1.0_wp)**(m - 1.0_wp)
      prop(8 + i) = m
      prop(10 + i) = prop(i)/prop(2 + i)*largest
      prop(12 + i) = (a/m)**m
      prop(14 + i) = max(0.0_wp, prop(i) - prop(3 - i))
    end do
    i = merge(2, 1, prop(2) > prop(1)) ! index of the constant that contains the larger energy
    prop(12 + i) = -prop(i)*prop(12 + i)
  end subroutine prepare

  !> Secants s of both modes at their largest openings k. With x = k_1/delta_n and y = k_2/delta_t,
  !!
  !!   s_n = -Gamma_n (m + alpha)/delta_n^2 P_n(x) Q_t(y),
  !!   s_t = -Gamma_t (n + beta)/delta_t^2 P_t(y) Q_n(x),
  !!   P_n(x) = (1 - x)^(alpha-1) (m/alpha + x)^(m-1),
  !!   Q_n(x) = Gamma_n (1 - x)^alpha (m/alpha + x)^m + <phi_n - phi_t>.
  !!
  !! P_t and Q_t have the same form with beta, n, Gamma_t and <phi_t - phi_n>. P is zero beyond the
  !! final opening, and Q is zero beyond the opening at which it changes its sign.
  pure subroutine secants(prop, k, s, ds)
    real(wp), intent(in) :: prop(:), k(2)
    real(wp), intent(out) :: s(2), ds(2, 2)
    real(wp) :: p(2), dp(2), q(2), dq(2), x, z, c
    integer :: i

    p = 0.0_wp
    dp = 0.0_wp
    q = prop(15:16)
    dq = 0.0_wp
    do i = 1, 2
      associate (a => prop(4 + i), m => prop(8 + i), gamma => prop(12 + i))
        x = k(i)/prop(10 + i)
        if (x < 1.0_wp) then
          z = m/a + x
          p(i) = (1.0_wp - x)**(a - 1.0_wp)*z**(m - 1.0_wp)
          dp(i) = p(i)*((m - 1.0_wp)/z - (a - 1.0_wp)/(1.0_wp - x))
          q(i) = gamma*p(i)*(1.0_wp - x)*z + q(i)
          dq(i) = -gamma*(m + a)*x*p(i)
        end if
        if (q(i)*gamma > 0.0_wp) cycle
        q(i) = 0.0_wp
        dq(i) = 0.0_wp
      end associate
    end do
    do i = 1, 2
      c = -prop(12 + i)*(prop(8 + i) + prop(4 + i))/prop(10 + i)**2
      s(i) = c*p(i)*q(3 - i)
      ds(i, i) = c*dp(i)*q(3 - i)/prop(10 + i)
      ds(i, 3 - i) = c*p(i)*dq(3 - i)/prop(13 - i)
    end do
  end subroutine secants

  !> The final openings: beyond either of them, both tractions are zero.
  pure subroutine released(prop, opening)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(out) :: opening(2)

    opening = prop(11:12)
  end subroutine released

end module contact_ppr
