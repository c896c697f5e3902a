!> Linear systems as Newton sees them: one call that solves to a tolerance.
!!
!! FULL     factorises every matrix.
!! REUSE    keeps a factorisation as preconditioner of conjugate gradients (GMRES where the matrix
!!          is unsymmetric or has negative pivots) until iterating costs more than factorising.
!! SINGLE   the same with factors in single precision: half the memory.
!! LOWRANK  the same with compressed factors.
!!
!! The answer meets the same tolerance in every mode.
module linear_system
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_error, only: error_t, fail, BUG, NO_SOLUTION, SYSTEM_ERROR
  use base_system, only: available_memory_mb, return_memory, wall_seconds
  use csr_pattern, only: block_matrix_t
  use csr_extract, only: entries_t, gather
  use solver_type, only: solver_t
  use solver_choice, only: new_solver
  use null_space, only: prove_regular
  use solve_report, only: solve_report_t
  use reuse_policy, only: reuse_policy_t, note_factorisation, note_solve, iteration_limit
  use krylov, only: krylov_report_t, conjugate_gradients, gmres
  implicit none
  private
  public :: linear_system_t, solve_report_t, new_linear_system, change_pattern

  integer, parameter, public :: FULL = 1, REUSE = 2, SINGLE = 3, LOWRANK = 4
  integer, parameter :: MOST_ATTEMPTS = 3  !! factors at hand, fresh ones, fresh exact ones

  !> A pattern, its factorisation and what was learnt about it.
  type :: linear_system_t
    integer :: neq = 0
    integer :: mode = FULL
    real(wp) :: eps = 0.0_wp               !! LOWRANK: relative error of compressed blocks
    real(wp) :: available_mb = 0.0_wp      !! memory there is [MB]; 0: ask the machine
    real(wp) :: estimate_mb = 0.0_wp       !! memory a factorisation needs, by the analysis [MB]
    class(solver_t), allocatable :: solver
    type(entries_t), private :: entries
    integer, allocatable, private :: eq(:, :)     !! (3, nnode)
    logical, private :: analysed = .false.        !! the solver knows the present pattern
    logical, private :: has_factors = .false.
    logical, private :: current = .false.         !! and they are those of the last matrix
    logical, private :: exact = .true.            !! factors are in double precision, not compressed
    logical, private :: proved = .false.          !! a matrix of this system was regular
    logical, private :: escalated = .false.       !! approximate factors did not do for this problem
    type(reuse_policy_t), private :: policy
  contains
    procedure :: solve
    procedure :: force_refactor
    procedure :: forget
    procedure :: free
  end type linear_system_t

contains

  !> A system of the free dofs of a: the analysis is done here, once.
  subroutine new_linear_system(ls, a, eq, mode, eps, error, available_mb)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)   !! (3, nnode) equation numbers, 0: prescribed
    integer, intent(in) :: mode       !! FULL, REUSE, SINGLE, LOWRANK
    real(wp), intent(in) :: eps       !! LOWRANK: relative error of compressed blocks, in (0, 1)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: available_mb !! memory there is [MB]; absent: ask the machine

    call ls%free()
    ls%mode = mode
    ls%eps = eps
    ls%available_mb = 0.0_wp
    if (present(available_mb)) ls%available_mb = available_mb
    call ls%force_refactor()
    if (mode < FULL .or. mode > LOWRANK) then
      call fail(error, BUG, 'unknown way to solve linear systems')
    else if (mode == LOWRANK .and. .not. (eps > 0.0_wp .and. eps < 1.0_wp)) then
      call fail(error, BUG, 'the error of low-rank factors must lie between 0 and 1')
    end if
    if (allocated(error)) return
    call change_pattern(ls, a, eq, error)
    if (allocated(error)) return
    call prepare(ls, a, error)
  end subroutine new_linear_system

  !> The matrix has another pattern from now on (contact). Factors at hand go on as preconditioner
  !! where the equations are the same ones; the new pattern is analysed with the next factorisation.
  subroutine change_pattern(ls, a, eq, error)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (size(eq, 1) /= 3 .or. size(eq, 2) /= a%nnode) then
      call fail(error, BUG, 'equation numbers and matrix do not belong together')
      return
    end if
    if (ls%has_factors) then
      ls%has_factors = size(ls%eq) == size(eq)
      if (ls%has_factors) ls%has_factors = all(ls%eq == eq)
    end if
    ls%eq = eq
    ls%neq = 0
    if (size(eq) > 0) ls%neq = maxval(eq)
    ls%analysed = .false.
  end subroutine change_pattern

  !> Analyse the pattern with a solver of the precision wanted now.
  subroutine prepare(ls, a, error)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    type(error_t), allocatable, intent(out) :: error

    real(wp) :: low_rank

    call drop_solver(ls)
    low_rank = 0.0_wp
    if (ls%mode == LOWRANK .and. .not. ls%escalated) low_rank = ls%eps
    call new_solver(ls%solver, ls%entries, a, ls%eq, ls%mode == SINGLE .and. .not. ls%escalated, &
                    low_rank, ls%exact, error)
    if (allocated(error)) return
    ls%estimate_mb = ls%solver%info%estimate_mb
    ls%analysed = .true.
  end subroutine prepare

  !> Solve A x = rhs.
  subroutine solve(ls, a, rhs, x, tolerance, report, error, same_matrix)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:)           !! (neq)
    real(wp), intent(out) :: x(:)            !! (neq)
    real(wp), intent(in) :: tolerance        !! of |rhs - A x| / |rhs|
    type(solve_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: same_matrix !! .true.: a has not changed since the last solve

    type(krylov_report_t) :: run
    integer :: attempt

    x = 0.0_wp
    report%null = [integer ::]
    report%converged = .true.
    if (ls%neq == 0) return
    if (.not. all(ieee_is_finite(rhs))) then
      call fail(error, NO_SOLUTION, 'the residual holds a number that is not finite')
      return
    end if
    if (.not. present(same_matrix)) then
      ls%current = .false.
    else if (.not. same_matrix) then
      ls%current = .false.
    end if
    if (ls%mode == FULL .and. .not. ls%current) ls%policy%due = .true.
    do attempt = 1, MOST_ATTEMPTS
      if (ls%policy%due .or. .not. ls%has_factors) then
        call factorise(ls, a, report, error)
        if (allocated(error) .or. report%singular) return
      end if
      call iterate(ls, a, rhs, x, tolerance, run, report, error)
      if (allocated(error) .or. run%converged) exit
      if (ls%current .and. ls%exact) then ! there is nothing better
        call prove_regular(a, ls%eq, ls%solver, .true., report%null, error)
        report%singular = size(report%null) > 0
        ls%has_factors = .not. report%singular
        if (report%singular) x = 0.0_wp
        exit
      end if
      if (ls%current) call escalate(ls)
      ls%policy%due = .true.
    end do
    if (allocated(error)) return
    report%converged = run%converged
    report%residual = run%residual
    call note_solve(ls%policy, run%iterations)
  end subroutine solve

  !> Factorise the matrix; where approximate factors look singular, exact ones decide.
  subroutine factorise(ls, a, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error

    real(wp), allocatable :: values(:)
    real(wp) :: start
    integer :: stat

    start = wall_seconds()
    ls%has_factors = .false.
    do
      if (.not. ls%analysed) call prepare(ls, a, error)
      if (allocated(error)) return
      allocate (values(size(ls%entries%row)), stat=stat)
      if (stat /= 0) call fail(error, SYSTEM_ERROR, 'no memory for the values of the tangent')
      if (allocated(error)) return
      call gather(ls%entries, a, values)
      call ls%solver%factorise(values, memory_mb(ls), error)
      if (allocated(error)) return
      deallocate (values)
      report%factorised = .true.
      report%factorisations = report%factorisations + 1
      report%null = ls%solver%info%null
      if (.not. ls%proved .or. size(report%null) > 0) then
        call prove_regular(a, ls%eq, ls%solver, ls%exact, report%null, error)
        if (allocated(error)) return
      end if
      if (size(report%null) == 0 .or. ls%exact) exit
      call escalate(ls)
    end do
    call note_factorisation(ls%policy, ls%solver%info%flops, ls%solver%info%entries)
    ls%has_factors = size(report%null) == 0
    ls%proved = ls%has_factors
    ls%current = ls%has_factors
    report%singular = .not. ls%has_factors
    report%converged = ls%has_factors
    call describe(ls, report)
    report%seconds_factor = report%seconds_factor + wall_seconds() - start
  end subroutine factorise

  !> Memory there is [MB].
  real(wp) function memory_mb(ls)
    class(linear_system_t), intent(in) :: ls

    real(wp), parameter :: MEBIBYTE = 1.048576_wp

    memory_mb = ls%available_mb
    if (memory_mb > 0.0_wp) return
    memory_mb = min(available_memory_mb(), 1e12_wp)*MEBIBYTE
    if (memory_mb + ls%solver%info%used_mb >= ls%estimate_mb) return
    call return_memory() ! what earlier solvers left
    memory_mb = min(available_memory_mb(), 1e12_wp)*MEBIBYTE
  end function memory_mb

  !> Iterate with the factors at hand: by conjugate gradients where all is positive definite as far
  !! as known.
  subroutine iterate(ls, a, rhs, x, tolerance, run, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:), tolerance
    real(wp), intent(out) :: x(:)
    type(krylov_report_t), intent(out) :: run
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error

    real(wp) :: start
    integer :: limit
    logical :: definite

    x = 0.0_wp
    run%converged = .true.
    if (.not. norm2(rhs) > 0.0_wp) return
    start = wall_seconds()
    limit = iteration_limit(ls%policy, ls%current, ls%exact)
    definite = a%symmetric .and. ls%solver%symmetric .and. ls%solver%info%negative == 0
    if (definite) then
      call conjugate_gradients(a, ls%eq, ls%solver, rhs, x, limit, tolerance, run, error)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
    end if
    ! Stale factors that met a negative direction are replaced first: fresh ones count it.
    if (.not. definite .or. (run%indefinite .and. ls%current .and. .not. run%converged)) then
      call gmres(a, ls%eq, ls%solver, rhs, x, limit, tolerance, run, error)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
      report%used_gmres = .true.
    end if
    call describe(ls, report)
    report%seconds_solve = report%seconds_solve + wall_seconds() - start
  end subroutine iterate

  !> From now on in double precision, not compressed.
  subroutine escalate(ls)
    class(linear_system_t), intent(inout) :: ls

    ls%escalated = .true.
    ls%analysed = .false.
  end subroutine escalate

  !> Copy what the solver knows.
  subroutine describe(ls, report)
    class(linear_system_t), intent(in) :: ls
    type(solve_report_t), intent(inout) :: report

    report%negative = ls%solver%info%negative
    report%determinant = ls%solver%info%determinant
    report%memory_mb = ls%solver%info%used_mb
    report%used_single = .not. ls%exact .and. ls%mode == SINGLE
  end subroutine describe

  !> Factorise at the next solve and forget what was learnt: what follows then depends on the
  !! matrices to come only (points of restart).
  subroutine force_refactor(self)
    class(linear_system_t), intent(inout) :: self

    self%policy = reuse_policy_t()
    self%proved = .false.
    if (self%escalated) self%analysed = .false.
    self%escalated = .false.
  end subroutine force_refactor

  !> The same, and give the memory of the factors back.
  subroutine forget(self)
    class(linear_system_t), intent(inout) :: self

    call self%force_refactor()
    call drop_solver(self)
  end subroutine forget

  !> Give all memory back.
  subroutine free(self)
    class(linear_system_t), intent(inout) :: self

    call self%forget()
    self%neq = 0
    self%entries = entries_t()
    if (allocated(self%eq)) deallocate (self%eq)
  end subroutine free

  subroutine drop_solver(ls)
    class(linear_system_t), intent(inout) :: ls

    ls%has_factors = .false.
    ls%analysed = .false.
    if (.not. allocated(ls%solver)) return
    call ls%solver%free()
    deallocate (ls%solver)
  end subroutine drop_solver

end module linear_system
