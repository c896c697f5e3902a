!> Linear systems of Newton's method: one call solves a system to a tolerance.
!!
!! FULL     factorises every matrix.
!! REUSE    keeps a factorisation as preconditioner of conjugate gradients (or of GMRES if the
!!          matrix is unsymmetric or has negative pivots) until iterations cost more than a
!!          factorisation.
!! SINGLE   does the same with factors in single precision, which need half the memory.
!! LOWRANK  does the same with compressed factors.
!!
!! The solution meets the same tolerance in every mode.
!!
!! A kept factorisation becomes less useful as the matrix changes. The cost per solve, averaged over
!! the life of a factorisation, is least if the factorisation is replaced as soon as a solve costs
!! more than the average so far. Costs are counted in iterations; the operation count of a
!! factorisation is converted to iterations. Times are not measured, so that runs can be repeated
!! exactly.
module linear_system
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_error, only: error_t, fail, BUG, NO_SOLUTION
  use base_kinds, only: wp
  use base_system, only: seconds_of_both
  use base_text, only: to_text
  use csr, only: block_matrix_t
  use krylov, only: krylov_report_t, conjugate_gradients, gmres
  use tangent_factors, only: solve_report_t, factors_t, new_factors, take_equations, analyse, &
                             renew, look_for_motions, be_exact, start_anew, drop
  implicit none
  private
  public :: linear_system_t, solve_report_t, new_linear_system, change_pattern
  public :: reuse_policy_t, note_factorisation, note_solve, iteration_limit

  integer, parameter, public :: FULL = 1, REUSE = 2, SINGLE = 3, LOWRANK = 4

  integer, parameter :: MOST_ATTEMPTS = 3 !! one with old, one with new, one with exact factors
  integer, parameter :: EXACT_LIMIT = 10 !! iterations with exact factors of the same matrix
  integer, parameter :: LEAST_LIMIT = 10 !! smallest limit on the iterations with other factors
  !> Number of operations of an elimination that take as long as a solve needs for one entry of the
  !! factors. In one second, a thread does about 45e9 operations of an elimination, or handles 6e8
  !! entries in a solve.
  real(wp), parameter :: OPERATIONS_AN_ENTRY = 72.0_wp

  !> The costs of a factorisation and of its use so far.
  type :: reuse_policy_t
    logical :: due = .true.         !! the next solve factorises
    real(wp) :: worth = 0.0_wp      !! cost of the factorisation, in iterations
    real(wp) :: spent = 0.0_wp      !! total cost so far with the factorisation, in iterations
    integer :: solves = 0           !! number of solves so far
  end type reuse_policy_t

  !> A system with its pattern, its factors and the costs of their use.
  type :: linear_system_t
    integer :: neq = 0
    integer :: mode = FULL
    type(factors_t), private :: factors
    logical, private :: current = .false.  !! the factors are those of the last matrix
    type(reuse_policy_t), private :: policy
  contains
    procedure :: solve
    procedure :: estimate_mb
    procedure :: force_refactor
    procedure :: forget
    procedure :: free
  end type linear_system_t

contains

  !> Make a system of the free dofs of a matrix, and analyse its pattern.
  subroutine new_linear_system(ls, a, eq, mode, eps, error, available_mb)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)   !! (3, nnode) equation numbers, 0: prescribed
    integer, intent(in) :: mode       !! FULL, REUSE, SINGLE, LOWRANK
    real(wp), intent(in) :: eps       !! LOWRANK: relative error of compressed blocks, in (0, 1)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: available_mb !! memory [MB]; absent: that of the machine

    call ls%free()
    ls%mode = mode
    if (mode < FULL .or. mode > LOWRANK) then
      call fail(error, BUG, 'unknown mode '//to_text(mode)//' of a linear system')
    else if (mode == LOWRANK .and. .not. (eps > 0.0_wp .and. eps < 1.0_wp)) then
      call fail(error, BUG, 'expected an error of low-rank factors between 0 and 1, found ' &
                //to_text(eps))
    end if
    if (allocated(error)) return
    call new_factors(ls%factors, mode == SINGLE, merge(eps, 0.0_wp, mode == LOWRANK), available_mb)
    call change_pattern(ls, a, eq, error)
    if (allocated(error)) return
    call analyse(ls%factors, a, error)
  end subroutine new_linear_system

  !> Take a matrix with another pattern, as contact causes it. Existing factors remain the
  !! preconditioner if the equations are the same.
  subroutine change_pattern(ls, a, eq, error)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    type(error_t), allocatable, intent(out) :: error

    call take_equations(ls%factors, a, eq, error)
    if (allocated(error)) return
    ls%neq = 0
    if (size(eq) > 0) ls%neq = maxval(eq)
  end subroutine change_pattern

  !> Memory of a factorisation, as estimated by the analysis [MB].
  pure real(wp) function estimate_mb(self)
    class(linear_system_t), intent(in) :: self

    estimate_mb = self%factors%estimate_mb
  end function estimate_mb

  !> Solve A x = rhs.
  subroutine solve(ls, a, rhs, x, tolerance, report, error, same_matrix)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:)           !! (neq)
    real(wp), intent(out) :: x(:)            !! (neq)
    real(wp), intent(in) :: tolerance        !! tolerance of |rhs - A x| / |rhs|
    type(solve_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: same_matrix !! .true.: a has not changed since the last solve
    type(krylov_report_t) :: run
    real(wp) :: start(2)
    integer :: attempt

    x = 0.0_wp
    report%null = [integer ::]
    report%converged = .true.
    if (ls%neq == 0) return
    if (.not. all(ieee_is_finite(rhs))) then
      call fail(error, NO_SOLUTION, 'the residual contains a number that is not finite')
      return
    end if
    if (.not. present(same_matrix)) then
      ls%current = .false.
    else if (.not. same_matrix) then
      ls%current = .false.
    end if
    if (ls%mode == FULL .and. .not. ls%current) ls%policy%due = .true.
    do attempt = 1, MOST_ATTEMPTS
      if (ls%policy%due .or. .not. ls%factors%valid) then
        start = seconds_of_both()
        call renew(ls%factors, a, report, error)
        if (allocated(error)) return
        call note_factorisation(ls%policy, ls%factors%solver%info%flops, &
                                ls%factors%solver%info%entries)
        ls%current = ls%factors%valid
        report%singular = .not. ls%factors%valid
        report%converged = ls%factors%valid
        call describe(ls, report)
        report%seconds_factor = report%seconds_factor + seconds_of_both() - start
        if (report%singular) return
      end if
      call iterate(ls, a, rhs, x, tolerance, run, report, error)
      if (allocated(error) .or. run%converged) exit
      if (ls%current .and. ls%factors%exact) then ! there are no better factors
        call look_for_motions(ls%factors, a, report%null, error)
        report%singular = size(report%null) > 0
        ls%factors%valid = .not. report%singular
        if (report%singular) x = 0.0_wp
        exit
      end if
      if (ls%current) call be_exact(ls%factors)
      ls%policy%due = .true.
    end do
    if (allocated(error)) return
    report%converged = run%converged
    report%residual = run%residual
    call note_solve(ls%policy, run%iterations)
  end subroutine solve

  !> Iterate with the existing factors, by conjugate gradients if matrix and factors are positive
  !! definite as far as is known.
  subroutine iterate(ls, a, rhs, x, tolerance, run, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:), tolerance
    real(wp), intent(out) :: x(:)
    type(krylov_report_t), intent(out) :: run
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: start(2)
    integer :: limit
    logical :: definite

    x = 0.0_wp
    run%converged = .true.
    if (.not. norm2(rhs) > 0.0_wp) return
    start = seconds_of_both()
    limit = iteration_limit(ls%policy, ls%current, ls%factors%exact)
    definite = a%symmetric .and. ls%factors%solver%symmetric &
               .and. ls%factors%solver%info%negative == 0
    if (definite) then
      call conjugate_gradients(a, ls%factors%eq, ls%factors%solver, rhs, x, limit, tolerance, &
                               run, error)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
    end if
    ! If old factors led to a direction of negative curvature, new factors are made first, because
    ! their pivots show whether the matrix is indefinite.
    if (.not. definite .or. (run%indefinite .and. ls%current .and. .not. run%converged)) then
      call gmres(a, ls%factors%eq, ls%factors%solver, rhs, x, limit, tolerance, run, error)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
      report%used_gmres = .true.
    end if
    call describe(ls, report)
    report%seconds_solve = report%seconds_solve + seconds_of_both() - start
  end subroutine iterate

  !> Copy the information of the solver into the report.
  subroutine describe(ls, report)
    class(linear_system_t), intent(in) :: ls
    type(solve_report_t), intent(inout) :: report

    associate (info => ls%factors%solver%info)
      report%negative = info%negative
      report%determinant = info%determinant
      report%memory_mb = info%used_mb
    end associate
    report%used_single = .not. ls%factors%exact .and. ls%mode == SINGLE
  end subroutine describe

  !> Factorise at the next solve, and forget what is known about earlier matrices. From then on,
  !! results depend only on later matrices, as a restart point requires.
  subroutine force_refactor(self)
    class(linear_system_t), intent(inout) :: self

    self%policy = reuse_policy_t()
    call start_anew(self%factors)
  end subroutine force_refactor

  !> Do the same as force_refactor, and release the memory of the factors.
  subroutine forget(self)
    class(linear_system_t), intent(inout) :: self

    call self%force_refactor()
    call drop(self%factors)
  end subroutine forget

  !> Release all memory.
  subroutine free(self)
    class(linear_system_t), intent(inout) :: self

    call self%forget()
    self%neq = 0
    if (allocated(self%factors%eq)) deallocate (self%factors%eq)
  end subroutine free

  !> Record the cost of a factorisation.
  pure subroutine note_factorisation(policy, flops, entries)
    type(reuse_policy_t), intent(inout) :: policy
    real(wp), intent(in) :: flops   !! operations of the elimination
    real(wp), intent(in) :: entries !! entries of the factors

    policy%due = .false.
    policy%worth = flops/max(entries, 1.0_wp)/OPERATIONS_AN_ENTRY
    policy%spent = policy%worth
    policy%solves = 0
  end subroutine note_factorisation

  !> Record the iterations of a solve.
  pure subroutine note_solve(policy, iterations)
    type(reuse_policy_t), intent(inout) :: policy
    integer, intent(in) :: iterations

    if (policy%solves > 0) policy%due = iterations*policy%solves > policy%spent
    policy%spent = policy%spent + iterations
    policy%solves = policy%solves + 1
  end subroutine note_solve

  !> Number of iterations after which a solve is given up.
  pure integer function iteration_limit(policy, same_matrix, exact) result(limit)
    type(reuse_policy_t), intent(in) :: policy
    logical, intent(in) :: same_matrix !! the factors are those of this matrix
    logical, intent(in) :: exact       !! the factors are in double precision and not compressed

    limit = max(LEAST_LIMIT, ceiling(policy%worth))
    if (same_matrix .and. exact) limit = EXACT_LIMIT
  end function iteration_limit

end module linear_system
