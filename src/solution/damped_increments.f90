!> Damped increments: the last means for a step that Newton's iteration does not solve, however
!! small the step is.
!!
!! Where contacts open, close, stick and slip in turn, the iteration may pass from one state to the
!! next for ever, and smaller steps do not help if the state is decided at zero gaps (a stack of
!! blocks under a dead load). With the stiffness lambda D added to the tangent, an increment is an
!! implicit step along D du/ds = r(u), a motion that friction and elasticity damp, towards
!! equilibrium:
!!
!!   (K + lambda D) du = r,  D = |K_nn| at each node n.
!!
!! The residual r is not changed, so the equilibrium is that of the model. lambda falls as long as
!! the residual does, and grows if the residual grows. When the residual is small, the undamped
!! iteration goes on.
!! Source: Kelley and Keyes 1998 [bib: kelley1998]
module damped_increments
  use anchors, only: node_stiffness
  use base_comm, only: is_root
  use base_kinds, only: wp
  use csr, only: block_matrix_t, block_position
  implicit none
  private
  public :: damped_t, begin_damping, adapt_damping, add_damping, remove_damping

  real(wp), parameter :: FIRST = 0.1_wp    !! lambda at the start of a step
  real(wp), parameter :: LARGEST = 1.0_wp
  real(wp), parameter :: GROWN = 1.1_wp    !! a residual that exceeds the last one by this has grown
  real(wp), parameter :: UP = 4.0_wp, DOWN = 0.5_wp !! factors of lambda
  !> The damping ends at this residual, relative to the largest one of the step.
  real(wp), parameter :: SMALL = 1.0e-3_wp
  integer, parameter :: MOST = 100         !! damped increments of a step

  type :: damped_t
    logical :: on = .false.                !! the next increment is damped
    integer :: count = 0                   !! damped increments of this step
    real(wp), private :: lambda = 0.0_wp
    real(wp), private :: last = 0.0_wp, largest = 0.0_wp !! residuals [F]
    real(wp), allocatable, private :: kept(:, :) !! (3, nnode) diagonal without damping [F/L]
  end type damped_t

contains

  !> Begin a step, with damped increments if `on`.
  subroutine begin_damping(damped, on)
    type(damped_t), intent(out) :: damped
    logical, intent(in) :: on

    damped%on = on
    damped%lambda = FIRST
  end subroutine begin_damping

  !> Choose lambda for the next increment, or end the damping.
  pure subroutine adapt_damping(damped, residual)
    type(damped_t), intent(inout) :: damped
    real(wp), intent(in) :: residual       !! at the current displacements [F]

    damped%largest = max(damped%largest, residual)
    if (damped%count > 0) then
      damped%lambda = merge(min(LARGEST, UP*damped%lambda), DOWN*damped%lambda, &
                            residual > GROWN*damped%last)
      damped%on = residual > SMALL*damped%largest .and. damped%count < MOST
    end if
    damped%last = residual
    damped%count = damped%count + 1
  end subroutine adapt_damping

  !> Add lambda D to the tangent.
  subroutine add_damping(damped, k)
    type(damped_t), intent(inout) :: damped
    type(block_matrix_t), intent(inout) :: k
    real(wp) :: stiffness
    integer :: i, n, p

    if (.not. allocated(damped%kept)) allocate (damped%kept(3, k%nnode))
    do n = 1, k%nnode
      p = block_position(k, n, n)
      if (p == 0) cycle
      stiffness = node_stiffness(k, n)
      do i = 1, 3
        damped%kept(i, n) = k%val(i, i, p)
        if (is_root()) k%val(i, i, p) = k%val(i, i, p) + damped%lambda*stiffness ! ranks add theirs
      end do
    end do
  end subroutine add_damping

  !> Restore the tangent without damping, bit for bit.
  subroutine remove_damping(damped, k)
    type(damped_t), intent(in) :: damped
    type(block_matrix_t), intent(inout) :: k
    integer :: i, n, p

    do n = 1, k%nnode
      p = block_position(k, n, n)
      if (p == 0) cycle
      do i = 1, 3
        k%val(i, i, p) = damped%kept(i, n)
      end do
    end do
  end subroutine remove_damping

end module damped_increments
