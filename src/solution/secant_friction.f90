!> Secants of friction: the last resort for a step that Newton's iteration does not solve, however
!! small the step is.
!!
!! If friction alone holds a body (a stack of blocks under a dead load), all its points may slip in
!! one iterate. The tangent of a slipping point has no stiffness along the slip, so the next
!! increment is far too long, and the iteration passes from one state to the next for ever. The
!! problem scales with the load, so smaller steps do not help. At the points that slip, an attempt
!! with secants replaces the derivatives of the frictional traction t with respect to the tangential
!! displacement d and the pressure p by
!!
!!   (1 - w) dt/dd - w |t|/|d| 1   and   (1 - w) dt/dp,
!!
!! where 1 is the unit matrix. With w = 1 and a fixed friction limit, this is Kacanov's iteration,
!! which always decreases the energy but converges slowly; with w = 0 it is Newton's iteration. The
!! first increment has w = 0, because friction cannot act before contact has found pressures. The
!! next one has w = 1. From then on, w is halved as long as the residual decreases, and becomes
!! larger if the residual increases. Neither the residual nor the equilibrium changes.
!!
!! Source: Han, Jensen and Shimansky 1997 [bib: han1997]
module secant_friction
  use base_kinds, only: wp
  implicit none
  private
  public :: secant_t, begin_secant, adapt_secant

  real(wp), parameter :: GROWN = 1.1_wp    !! ratio of residuals above which the residual has grown
  real(wp), parameter :: UP = 4.0_wp, DOWN = 0.5_wp !! factors of w
  !> The secants end at this residual, relative to the largest one of the step.
  real(wp), parameter :: SMALL = 1.0e-3_wp
  integer, parameter :: MOST = 100         !! largest number of increments with secants in a step

  type :: secant_t
    logical :: on = .false.                !! the next increment has secants
    integer :: count = 0                   !! increments of this step with secants
    real(wp) :: weight = 0.0_wp            !! w, the share of the secants in the next tangent
    real(wp), private :: last = 0.0_wp, largest = 0.0_wp !! residuals [F]
  end type secant_t

contains

  !> Begin a step, with secants of friction if `on`.
  pure subroutine begin_secant(secant, on)
    type(secant_t), intent(out) :: secant
    logical, intent(in) :: on

    secant%on = on
  end subroutine begin_secant

  !> Choose w for the next tangent, or end the secants.
  pure subroutine adapt_secant(secant, residual)
    type(secant_t), intent(inout) :: secant
    real(wp), intent(in) :: residual       !! residual at the current displacements [F]

    secant%largest = max(secant%largest, residual)
    if (secant%count == 0) then
      secant%weight = 1.0_wp
    else
      secant%weight = merge(min(1.0_wp, UP*secant%weight), DOWN*secant%weight, &
                            residual > GROWN*secant%last)
      secant%on = residual > SMALL*secant%largest .and. secant%count < MOST
      if (.not. secant%on) secant%weight = 0.0_wp
    end if
    secant%last = residual
    secant%count = secant%count + 1
  end subroutine adapt_secant

end module secant_friction
