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
!! but converges slowly. It is therefore accelerated by Anderson's method: with the increment dx_k
!! that the system gives after k increments, and the increments s_j that were taken, the next one is
!!
!!   s_k = dx_k - sum_j c_j (dx_(j+1) - dx_j + s_j),
!!
!! where c minimises |dx_k - sum_j c_j (dx_(j+1) - dx_j)| over the last DEPTH increments. Secants
!! and acceleration change only the course of the iteration; residual and equilibrium are those of
!! the model.
!! Source: Han, Jensen and Shimansky 1997 [bib: han1997]; Walker and Ni 2011 [bib: walker2011]
module secant_friction
  use base_kinds, only: wp
  use lapack, only: dgesv
  implicit none
  private
  public :: secant_t, begin_secant, adapt_secant, accelerate

  !> If the residual grows by this factor, the acceleration starts again without earlier increments.
  real(wp), parameter :: GROWN = 1.1_wp
  !> Secants are used until the residual falls below this value, relative to the largest one of the
  !! step.
  real(wp), parameter :: SMALL = 1.0e-7_wp
  integer, parameter :: MOST = 100         !! largest number of increments with secants in a step
  integer, parameter :: DEPTH = 6
  real(wp), parameter :: REGULAR = 1.0e-12_wp !! relative addition to the diagonal of the normal
  !! equations for c

  type :: secant_t
    logical :: on = .false.                !! the next increment has secants
    integer :: count = 0                   !! number of increments with secants in this step
    logical :: tangent = .false.           !! the next tangent is formed with secants
    real(wp), private :: last = 0.0_wp, largest = 0.0_wp !! residuals [F]
    integer, private :: known = 0          !! number of columns of `change` and `taken` in use
    !> (neq, DEPTH) dx_(j+1) - dx_j, the latest first [L].
    real(wp), allocatable, private :: change(:, :)
    real(wp), allocatable, private :: taken(:, :) !! (neq, DEPTH) s_j [L]
    real(wp), allocatable, private :: last_dx(:) !! (neq) dx_(k-1), if there is one [L]
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
  pure subroutine adapt_secant(secant, residual)
    type(secant_t), intent(inout) :: secant
    real(wp), intent(in) :: residual       !! at the current displacements [F]

    secant%largest = max(secant%largest, residual)
    if (secant%count > 0) then
      secant%on = residual > SMALL*secant%largest .and. secant%count < MOST
      if (residual > GROWN*secant%last .and. allocated(secant%last_dx)) then
        deallocate (secant%last_dx)
        secant%known = 0
      end if
    end if
    secant%tangent = secant%on
    secant%last = residual
    secant%count = secant%count + 1
  end subroutine adapt_secant

  !> Replace the increment of the linear system by the accelerated one.
  subroutine accelerate(secant, dx)
    type(secant_t), intent(inout) :: secant
    real(wp), intent(inout) :: dx(:)       !! (neq) [L]
    real(wp), allocatable :: new(:)
    real(wp) :: a(DEPTH, DEPTH), c(DEPTH)
    integer :: i, info, n, pivot(DEPTH)

    if (.not. allocated(secant%change)) then
      allocate (secant%change(size(dx), DEPTH), secant%taken(size(dx), DEPTH))
    end if
    new = dx
    if (allocated(secant%last_dx)) then
      n = min(DEPTH, secant%known + 1)
      secant%known = n
      secant%change(:, 2:n) = secant%change(:, :n - 1)
      secant%change(:, 1) = dx - secant%last_dx
      a(:n, :n) = matmul(transpose(secant%change(:, :n)), secant%change(:, :n))
      do i = 1, n
        a(i, i) = (1.0_wp + REGULAR)*a(i, i)
      end do
      c(:n) = matmul(dx, secant%change(:, :n))
      call dgesv(n, 1, a, DEPTH, pivot, c, DEPTH, info)
      if (info == 0) new = dx - matmul(secant%change(:, :n) + secant%taken(:, :n), c(:n))
    end if
    secant%last_dx = dx
    dx = new
    secant%taken(:, 2:) = secant%taken(:, :DEPTH - 1)
    secant%taken(:, 1) = dx
  end subroutine accelerate

end module secant_friction
