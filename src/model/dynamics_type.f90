!> Time integration: finds accelerations from displacements, and stores the velocities and
!! accelerations at the beginning of a step.
!!
!! If the displacement is prescribed, the acceleration of Newmark's method follows from a recursion
!! that hardly forgets (not at all with beta = 1/4 and gamma = 1/2, where an error changes its sign
!! in each step and grows). Velocities and accelerations of prescribed displacements are therefore
!! backward differences of the last displacements. In steps of equal length,
!!
!!   v_1 = (3 u_1 - 4 u_0 + u_-1)/(2 dt),  a = (2 u_1 - 5 u_0 + 4 u_-1 - u_-2)/dt^2,
!!
!! which are of second order. They are computed from the stored v and a alone: a = 2 (du/dt - v)/dt,
!! and the new rates are those of Newmark's method with beta = 1 and gamma = 3/2, whose acceleration
!! (u_1 - 2 u_0 + u_-1)/dt^2 is the only one with a finite memory.
module dynamics_type
  use base_kinds, only: wp
  implicit none
  private
  public :: dynamics_t, new_dynamics, set_rates, acceleration, advance

  integer, parameter, public :: BACKWARD_EULER = 1, NEWMARK = 2, HHT = 3

  !> Velocities and accelerations refer to the deck's unit of time. They change only when a step is
  !! accepted.
  type :: dynamics_t
    logical :: on = .false.
    integer :: method = BACKWARD_EULER
    real(wp) :: beta = 0.25_wp, gamma = 0.5_wp   !! parameters of Newmark's method
    real(wp) :: alpha = 0.0_wp                   !! parameter of the HHT method, -1 < alpha <= 0
    logical :: lumped = .false.
    !> RESTart has read v and a of a motion, and no step has been accepted since.
    logical :: continues = .false.
    !> Density of all bodies, which replaces the densities of their materials [M/L^3]; if it is
    !! negative, the densities of the materials are used.
    real(wp) :: density = -1.0_wp
    !> Coefficients of the acceleration in the current step, c(1) (u - u_step) - c(2) v - c(3) a,
    !! with the stored v and a.
    real(wp) :: c(3) = 0.0_wp
    !> The same of prescribed displacements, d(1) (u - u_step) - d(2) v.
    real(wp) :: d(2) = 0.0_wp
    real(wp), allocatable :: v(:, :)             !! (3, nnode) velocity when the step began [L/T]
    real(wp), allocatable :: a(:, :)             !! (3, nnode) acceleration at that time [L/T^2]
    !> (3, nnode) Internal minus external force at that time, a fraction of which enters the HHT
    !! equations [F].
    real(wp), allocatable :: static(:, :)
  end type dynamics_t

contains

  !> Allocate the velocities and accelerations of nnode nodes, and set them to zero.
  pure subroutine new_dynamics(dynamics, nnode)
    type(dynamics_t), intent(inout) :: dynamics
    integer, intent(in) :: nnode

    if (allocated(dynamics%v)) deallocate (dynamics%v, dynamics%a, dynamics%static)
    allocate (dynamics%v(3, nnode), dynamics%a(3, nnode), dynamics%static(3, nnode), source=0.0_wp)
  end subroutine new_dynamics

  !> Set the coefficients of the acceleration for a step of length dt.
  pure subroutine set_rates(dynamics, dt)
    type(dynamics_t), intent(inout) :: dynamics
    real(wp), intent(in) :: dt

    if (.not. dynamics%on) return
    if (.not. dt > 0.0_wp) then
      dynamics%c = 0.0_wp
      dynamics%d = 0.0_wp
    else if (dynamics%method == BACKWARD_EULER) then
      dynamics%c = [1.0_wp/dt**2, 1.0_wp/dt, 0.0_wp]
      dynamics%d = dynamics%c(:2)
    else
      dynamics%d = [2.0_wp/dt**2, 2.0_wp/dt]
      associate (beta => dynamics%beta)
        dynamics%c = [1.0_wp/(beta*dt**2), 1.0_wp/(beta*dt), 0.5_wp/beta - 1.0_wp]
      end associate
    end if
  end subroutine set_rates

  !> Acceleration of nodes that have moved by du since the beginning of the step.
  pure function acceleration(dynamics, du, driven) result(a)
    type(dynamics_t), intent(in) :: dynamics
    real(wp), intent(in) :: du(:, :)             !! (3, nnode) [L]
    logical, intent(in) :: driven(:, :)          !! (3, nnode) is du prescribed?
    real(wp) :: a(3, size(du, 2))

    where (driven)
      a = dynamics%d(1)*du - dynamics%d(2)*dynamics%v
    else where
      a = dynamics%c(1)*du - dynamics%c(2)*dynamics%v - dynamics%c(3)*dynamics%a
    end where
  end function acceleration

  !> Compute the velocities and accelerations at the end of a step.
  pure subroutine advance(dynamics, du, driven, dt, static)
    type(dynamics_t), intent(inout) :: dynamics
    real(wp), intent(in) :: du(:, :)             !! (3, nnode) [L]
    logical, intent(in) :: driven(:, :)          !! (3, nnode) is du prescribed?
    real(wp), intent(in) :: dt
    real(wp), intent(in) :: static(:, :)         !! (3, nnode) internal minus external force [F]
    real(wp), allocatable :: a(:, :)

    dynamics%continues = .false.
    if (.not. dt > 0.0_wp) then ! only the static forces have changed
      if (dynamics%on) dynamics%static = static
      return
    end if
    if (.not. dynamics%on) then ! no inertia: only set the rates for a later dynamic step
      dynamics%v = du/dt
      dynamics%a = 0.0_wp
      dynamics%static = 0.0_wp
      return
    end if
    allocate (a, source=acceleration(dynamics, du, driven))
    if (dynamics%method == BACKWARD_EULER) then
      dynamics%v = du/dt
    else
      associate (gamma => dynamics%gamma)
        where (driven)
          a = 0.5_wp*(a + dynamics%a)
          dynamics%v = dynamics%v + dt*(1.5_wp*a - 0.5_wp*dynamics%a)
        else where
          dynamics%v = dynamics%v + dt*((1.0_wp - gamma)*dynamics%a + gamma*a)
        end where
      end associate
    end if
    call move_alloc(a, dynamics%a)
    dynamics%static = static
  end subroutine advance

end module dynamics_type
