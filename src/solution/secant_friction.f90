!> Secants of friction: the last means for a step that Newton's iteration does not solve, however
!! small the step is.
!!
!! If friction alone holds a body (a block on a slope, a stack of blocks under a dead load), all its
!! points may slip in one iterate. The tangent of a slipping point has no stiffness along the slip,
!! so the next increment is far too long, and the iteration passes from one state to the next
!! forever. The problem scales with the load, so smaller steps do not help. At the points that slip,
!! an attempt with secants replaces the derivatives of the frictional traction t with respect to the
!! tangential displacement d and the pressure p:
!!
!!   dt/dd -> -|t|/|d| 1,  dt/dp -> 0.
!!
!! For a fixed friction limit this is the iteration of Kacanov, which always decreases the energy,
!! but converges slowly. It is therefore accelerated by Anderson's method (module anderson). Secants
!! and acceleration change only the course of the iteration; residual and equilibrium are those of
!! the model.
!! Source: Han, Jensen and Shimansky 1997 [bib: han1997]
module secant_friction
  use anderson, only: anderson_t, forget
  use base_kinds, only: wp
  implicit none
  private
  public :: secant_t, begin_secant, adapt_secant

  !> If the residual grows by this factor, the acceleration starts again without earlier increments.
  real(wp), parameter :: GROWN = 1.1_wp
  !> Secants are used until the residual falls below this value, relative to the largest one of the
  !! step or to the loads, whichever is smaller: an increment that goes astray makes the first one
  !! as large as it likes.
  real(wp), parameter :: SMALL = 1.0e-7_wp
  integer, parameter :: MOST = 100         !! largest number of increments with secants in a step

  type :: secant_t
    logical :: on = .false.                !! the next increment has secants
    integer :: count = 0                   !! number of increments with secants in this step
    logical :: tangent = .false.           !! the next tangent is formed with secants
    real(wp), private :: last = 0.0_wp, largest = 0.0_wp !! residuals [F]
    type(anderson_t) :: past               !! increments with secants
  end type secant_t

contains

  !> Begin a step, with secants of friction if `on`.
  pure subroutine begin_secant(secant, on)
    type(secant_t), intent(out) :: secant
    logical, intent(in) :: on

    secant%on = on
  end subroutine begin_secant

  !> Decide whether the next increment and the next tangent have secants. The first tangent has
  !! none, because friction cannot act before contact has found pressures.
  pure subroutine adapt_secant(secant, residual, loads)
    type(secant_t), intent(inout) :: secant
    real(wp), intent(in) :: residual       !! at the current displacements [F]
    real(wp), intent(in) :: loads          !! sum of all loads or reactions [F]
    real(wp) :: scale

    secant%largest = max(secant%largest, residual)
    scale = secant%largest
    if (loads > 0.0_wp) scale = min(scale, loads)
    if (secant%count > 0) then
      secant%on = residual > SMALL*scale .and. secant%count < MOST
      if (residual > GROWN*secant%last) call forget(secant%past)
    end if
    secant%tangent = secant%on
    secant%last = residual
    secant%count = secant%count + 1
  end subroutine adapt_secant

end module secant_friction
