!> Uses the factors of an earlier matrix to find out whether the current one is still positive
!! definite.
!!
!! The earlier matrix was positive definite. Its factors precondition conjugate gradients for an
!! irregular load, which therefore contains all modes; one of the two terms of this load contains
!! each mode in proportion to its flexibility. If an eigenvalue has become zero or negative, the
!! residual in its mode does not fall until a direction of negative curvature is found. If the
!! residual falls fast, there is no such eigenvalue. The test costs about as much as solving one
!! system.
module definiteness
  use base_error, only: error_t
  use base_kinds, only: wp
  use csr, only: block_matrix_t, row_sums
  use krylov, only: krylov_report_t, conjugate_gradients
  use solver_type, only: solver_t
  implicit none
  private
  public :: is_still_definite

  integer, parameter :: MOST = 8          !! largest number of iterations
  !> Allowed residual, relative to |load|/sqrt(neq), the mean share of a mode in the load.
  real(wp), parameter :: SHARE = 0.1_wp

contains

  subroutine is_still_definite(a, eq, solver, load, definite, iterations, error)
    type(block_matrix_t), intent(in) :: a      !! symmetric
    integer, intent(in) :: eq(:, :)            !! (3, nnode) equation numbers, 0: prescribed
    class(solver_t), intent(inout) :: solver   !! with factors that have no negative pivot
    real(wp), allocatable, intent(inout) :: load(:) !! (neq) if not allocated, it is made here
    logical, intent(out) :: definite           !! .false.: not known; new factors must decide
    integer, intent(inout) :: iterations       !! number of solves with the factors so far
    type(error_t), allocatable, intent(out) :: error
    type(krylov_report_t) :: run
    real(wp), allocatable :: x(:)

    definite = .false.
    if (.not. allocated(load)) then
      call make_load(a, eq, solver, load, error)
      if (allocated(error)) return
      iterations = iterations + 1
    end if
    if (.not. norm2(load) > 0.0_wp) return
    allocate (x(solver%neq))
    call conjugate_gradients(a, eq, solver, load, x, MOST, SHARE/sqrt(real(solver%neq, wp)), run, &
                             error)
    iterations = iterations + run%iterations
    definite = run%converged .and. .not. run%indefinite
  end subroutine is_still_definite

  !> Make a load that contains all modes; it is irregular but repeatable. It is zero if an equation
  !! has no stiffness.
  subroutine make_load(a, eq, solver, load, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    class(solver_t), intent(inout) :: solver
    real(wp), allocatable, intent(out) :: load(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: white(:), soft(:, :)
    integer :: i

    allocate (load(solver%neq), white(solver%neq), soft(solver%neq, 1))
    call row_sums(a, eq, load)
    if (.not. all(load > 0.0_wp)) then
      load = 0.0_wp
      return
    end if
    white = sqrt(load)*[(sin(real(i, wp)*real(i + 7, wp)), i=1, solver%neq)]
    soft(:, 1) = white
    call solver%solve(soft, error)
    soft(:, 1) = load*soft(:, 1)
    load = white/norm2(white) + soft(:, 1)/norm2(soft(:, 1))
  end subroutine make_load

end module definiteness
