!> Linear systems of Newton's method: one call solves a system to a tolerance.
!!
!! FULL:    factorises every matrix.
!! REUSE:   keeps a factorisation as the preconditioner of conjugate gradients (or of GMRES if the
!!          matrix is unsymmetric, or if the factors have negative pivots or are corrected) until
!!          iterations become so expensive that a new factorisation saves work.
!! SINGLE:  does the same with factors in single precision, which need half the memory.
!! LOWRANK: does the same with compressed factors.
!! AUTO:    is the same as FULL if a factorisation costs at most as much as KEEPING iterations, and
!!          the same as SINGLE otherwise.
!!
!! If memory is too short, AUTO tries factors in single precision: first as they are, then
!! compressed, then on disk. FULL, REUSE and SINGLE write the factors to disk right away, and
!! LOWRANK ends with an error.
!!
!! The solution meets the same tolerance in every mode.
!!
!! AUTO chooses between FULL and SINGLE by the numbers of operations and entries that the analysis
!! finds. If factors in single precision turn out not to suffice, they are made in double precision
!! until the next force_refactor. If the caller needs the signs of the pivots or of the determinant,
!! FULL and AUTO find them for every matrix, the other modes only when they factorise.
!!
!! If kept factors no longer suffice, they are first corrected at the nodes where the matrix has
!! changed most, usually nodes in contact (factor_correction). They are replaced only if this does
!! not suffice either.
!!
!! A kept factorisation becomes less useful as the matrix changes. The cost of gaining one decimal
!! digit, averaged over the life of a factorisation, is least if the factorisation is replaced as
!! soon as a digit costs more than the average so far. Costs are expressed in iterations; the
!! operations of a factorisation are converted to iterations. Measured times have no influence, so
!! that runs can be repeated exactly.
module linear_system
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_error, only: error_t, fail, BUG, NO_SOLUTION
  use base_kinds, only: wp
  use base_system, only: seconds_of_both
  use base_text, only: to_text
  use csr, only: block_matrix_t
  use definiteness, only: is_still_definite
  use factor_correction, only: correction_t, note_matrix, correct, forget_correction
  use krylov, only: krylov_report_t, conjugate_gradients, gmres
  use tangent_factors, only: solve_report_t, factors_t, storage_t, new_factors, take_equations, &
                             analyse, use_precision, memory_of, describe_storage, renew, &
                             look_for_motions, be_exact, start_anew, drop
  implicit none
  private
  public :: linear_system_t, solve_report_t, new_linear_system, change_pattern
  public :: reuse_policy_t, note_factorisation, note_solve, iteration_limit, worth_keeping

  integer, parameter, public :: FULL = 1, REUSE = 2, SINGLE = 3, LOWRANK = 4, AUTO = 5

  !> Loads outside this range are scaled.
  real(wp), parameter :: SMALLEST = 1.0e-100_wp, LARGEST = 1.0e100_wp
  !> Largest number of attempts at a solve: with old factors, with corrected old factors, with new
  !! factors, and with exact factors.
  integer, parameter :: MOST_ATTEMPTS = 4
  !> A larger residual is accepted if rounding alone may leave it, if no factors are better, and if
  !! the matrix is not singular: in stiff parts that move far, the forces of rounding are large
  !! compared with the loads. Newton's iteration then refines the solution.
  real(wp), parameter :: ROUGH = 1.0e-2_wp
  !> Largest number of operations of a correction, relative to a new factorisation.
  real(wp), parameter :: WORTHWHILE = 0.3_wp
  integer, parameter :: EXACT_LIMIT = 10 !! limit on iterations with exact factors of this matrix
  !> A solve is taken to gain at least this many digits, because even the easiest one costs a whole
  !! iteration.
  real(wp), parameter :: FEWEST_DIGITS = 2.0_wp
  integer, parameter :: LEAST_LIMIT = 10 !! smallest limit on iterations with old or inexact factors
  !> The cost of a factorisation in iterations is estimated as PREPARATION, for the assembly of the
  !! entries, plus one iteration for each OPERATIONS_AN_ENTRY operations per entry of the factors.
  !! The measured costs for cubes with 3, 26 and 86 thousand equations are 14, 18 and 26 iterations.
  real(wp), parameter :: PREPARATION = 10.0_wp, OPERATIONS_AN_ENTRY = 110.0_wp
  !> AUTO keeps factors if a factorisation costs more iterations than this. With linear hexahedra,
  !! this is the case for more than about 12,000 equations. Smaller models would gain too, but their
  !! runs are short.
  real(wp), parameter :: KEEPING = 15.0_wp
  real(wp), parameter :: COMPRESSION = 1e-4_wp !! AUTO: relative error of compressed blocks
  type(storage_t), parameter :: AUTO_WAYS(4) = [ & !! in the order in which AUTO tries them
                                storage_t(), &
                                storage_t(single=.true.), &
                                storage_t(single=.true., eps=COMPRESSION), &
                                storage_t(single=.true., on_disk=.true.)]
  integer, parameter :: LIKELY = 12000 !! with more equations, AUTO usually keeps factors

  !> The costs of a factorisation and of its use so far.
  type :: reuse_policy_t
    logical :: due = .true.         !! the next solve factorises
    real(wp) :: worth = 0.0_wp      !! cost of the factorisation, in iterations
    real(wp) :: spent = 0.0_wp      !! cost of the factorisation and of all solves with it
    real(wp) :: digits = 0.0_wp     !! decimal digits that all solves so far have gained
  end type reuse_policy_t

  !> A system with its pattern, its factors and the costs of their use.
  type :: linear_system_t
    integer :: neq = 0
    integer :: mode = FULL                 !! if AUTO is given, the mode that it chose
    logical, private :: automatic = .false. !! AUTO is given
    type(factors_t), private :: factors
    logical, private :: current = .false.  !! the factors are those of the last matrix
    type(reuse_policy_t), private :: policy
    type(correction_t), private :: correction
    logical, private :: corrects = .false. !! kept factors are corrected before use
    real(wp), allocatable, private :: probe(:) !! (neq) load of is_still_definite
  contains
    procedure :: solve
    procedure :: find_signs
    procedure :: keeps_factors
    procedure :: estimate_mb
    procedure :: list_memory
    procedure :: force_refactor
    procedure :: forget
    procedure :: free
  end type linear_system_t

contains

  !> Make a system of the free dofs of a matrix, and analyse its pattern.
  subroutine new_linear_system(ls, a, eq, mode, eps, error, available_mb, keeping)
    type(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)   !! (3, nnode) equation numbers, 0: prescribed
    integer, intent(in) :: mode       !! FULL, REUSE, SINGLE, LOWRANK, AUTO
    real(wp), intent(in) :: eps       !! LOWRANK: relative error of compressed blocks, in (0, 1)
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: available_mb !! memory [MB]; absent: that of the machine
    real(wp), intent(in), optional :: keeping !! replaces KEEPING
    logical :: halved !! the factors are in single precision

    call ls%free()
    ls%automatic = mode == AUTO
    ls%mode = merge(FULL, mode, ls%automatic)
    if (mode < FULL .or. mode > AUTO) then
      call fail(error, BUG, 'the linear system has the unknown mode '//to_text(mode))
    else if (mode == LOWRANK .and. .not. (eps > 0.0_wp .and. eps < 1.0_wp)) then
      call fail(error, BUG, 'expected an accuracy of low-rank factors between 0 and 1, found ' &
                //to_text(eps))
    end if
    if (allocated(error)) return
    halved = mode == SINGLE
    if (ls%automatic .and. size(eq) > 0) halved = maxval(eq) > LIKELY
    call new_factors(ls%factors, ways_of(mode, halved, eps), available_mb)
    call change_pattern(ls, a, eq, error)
    if (allocated(error)) return
    call analyse(ls%factors, a, error)
    if (allocated(error) .or. .not. ls%automatic) return
    associate (info => ls%factors%solver%info)
      halved = worth_keeping(info%flops, info%entries, keeping)
    end associate
    if (halved) ls%mode = SINGLE
    call use_precision(ls%factors, halved, a, error)
    if (.not. ls%factors%exact) ls%mode = SINGLE ! memory may require it
  end subroutine new_linear_system

  !> The ways to store factors in a mode, in the order in which they are tried.
  pure function ways_of(mode, single, eps) result(ways)
    integer, intent(in) :: mode
    logical, intent(in) :: single !! the first way is in single precision
    real(wp), intent(in) :: eps   !! LOWRANK: relative error of compressed blocks
    type(storage_t), allocatable :: ways(:)

    select case (mode)
    case (LOWRANK)
      allocate (ways, source=[storage_t(eps=eps)])
    case (AUTO)
      allocate (ways, source=AUTO_WAYS(merge(2, 1, single):))
    case default
      allocate (ways, source=[storage_t(single=single), storage_t(single=single, on_disk=.true.)])
    end select
  end function ways_of

  !> Replace the matrix by one with another pattern, as when contact changes. Existing factors
  !! remain the preconditioner if the equations are the same.
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

  !> May solves use factors of earlier matrices, or factors that are not exact?
  pure logical function keeps_factors(self)
    class(linear_system_t), intent(in) :: self

    keeps_factors = self%mode /= FULL
  end function keeps_factors

  !> Memory of a factorisation, as estimated by the analysis [MB].
  pure real(wp) function estimate_mb(self)
    class(linear_system_t), intent(in) :: self

    estimate_mb = self%factors%estimate_mb
  end function estimate_mb

  !> List AUTO's ways of storing factors, from the one that needs most memory to the one that needs
  !! least, with the memory that a factorisation needs in each of them.
  subroutine list_memory(self, a, way, mb, error)
    class(linear_system_t), intent(in) :: self
    type(block_matrix_t), intent(in) :: a
    character(64), allocatable, intent(out) :: way(:) !! in words
    real(wp), allocatable, intent(out) :: mb(:)       !! [MB]
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    allocate (way(size(AUTO_WAYS)), mb(size(AUTO_WAYS)))
    do i = 1, size(AUTO_WAYS)
      way(i) = describe_storage(AUTO_WAYS(i))
      call memory_of(self%factors, a, AUTO_WAYS(i), mb(i), error)
      if (allocated(error)) return
    end do
  end subroutine list_memory

  !> Solve A x = rhs.
  subroutine solve(ls, a, rhs, x, tolerance, report, error, same_matrix, signs)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:)           !! (neq)
    real(wp), intent(out) :: x(:)            !! (neq)
    real(wp), intent(in) :: tolerance        !! tolerance of |rhs - A x| / |rhs|
    type(solve_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: same_matrix !! .true.: a has not changed since the last solve
    logical, intent(in), optional :: signs !! .true.: AUTO finds the signs of the pivots
    type(krylov_report_t) :: run
    integer :: attempt
    logical :: inexact, wanted, same

    x = 0.0_wp
    report%null = [integer ::]
    report%converged = .true.
    if (ls%neq == 0) return
    if (.not. all(ieee_is_finite(rhs))) then
      call fail(error, NO_SOLUTION, 'the residual or the load contains a number that is not finite')
      return
    end if
    same = .false.
    if (present(same_matrix)) same = same_matrix
    if (.not. same) ls%current = .false.
    if (ls%mode == FULL .and. .not. ls%current) ls%policy%due = .true.
    wanted = .false.
    if (present(signs)) wanted = signs .and. ls%automatic .and. .not. ls%current
    if (wanted) call prove_definite(ls, a, report, error)
    if (allocated(error)) return
    inexact = .not. ls%factors%exact
    do attempt = 1, MOST_ATTEMPTS
      if (ls%corrects .and. .not. (ls%current .or. ls%policy%due)) then
        if (.not. (same .and. ls%correction%acts)) then
          call correct(ls%correction, a, ls%factors%eq, &
                       WORTHWHILE*ls%factors%solver%info%flops, error)
          if (allocated(error)) return
        end if
        ls%policy%due = attempt > 1 .and. .not. ls%correction%acts
      end if
      if (ls%policy%due .or. .not. ls%factors%valid) then
        call factorise(ls, a, report, error)
        if (allocated(error) .or. report%singular) return
        if (wanted .and. are_doubtful(ls)) then ! the signs are found with exact factors
          call be_exact(ls%factors)
          ls%policy%due = .true.
          cycle
        end if
      end if
      call iterate(ls, a, rhs, x, tolerance, run, report, error)
      if (allocated(error) .or. run%converged) exit
      if (.not. (ls%current .or. ls%corrects)) then
        ls%corrects = .true.
        cycle
      end if
      if (ls%current .and. ls%factors%exact) then ! there are no better factors
        call look_for_motions(ls%factors, a, report%null, error)
        report%singular = size(report%null) > 0
        ls%factors%valid = .not. report%singular
        if (report%singular) x = 0.0_wp
        run%converged = run%rounds .and. run%residual <= ROUGH .and. .not. report%singular
        exit
      end if
      if (ls%current) call be_exact(ls%factors)
      ls%policy%due = .true.
    end do
    if (allocated(error)) return
    report%gave_up_single = ls%automatic .and. inexact .and. ls%factors%exact
    report%converged = run%converged
    report%residual = run%residual
    call note_solve(ls%policy, run%iterations, max(FEWEST_DIGITS, -log10(tolerance)), &
                    cost_of_correction(ls, run%iterations))
    if (ls%policy%due .and. .not. ls%corrects .and. ls%mode /= FULL) then
      ls%corrects = .true. ! the next solve tries a correction first
      ls%policy%due = .false.
    end if
  end subroutine solve

  !> Cost of a correction and of its use, in iterations.
  pure real(wp) function cost_of_correction(ls, iterations) result(cost)
    class(linear_system_t), intent(in) :: ls
    integer, intent(in) :: iterations

    cost = 0.0_wp
    if (.not. ls%correction%acts) return
    associate (part => ls%correction%solver%info, whole => ls%factors%solver%info)
      cost = (iterations + cost_of(part%flops, part%entries))*part%entries &
             /max(1.0_wp, whole%entries)
    end associate
  end function cost_of_correction

  !> AUTO: after a solve that did not need the signs of the pivots, find those of the last matrix.
  subroutine find_signs(ls, a, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    type(solve_report_t), intent(inout) :: report !! report of the solve
    type(error_t), allocatable, intent(out) :: error
    logical :: inexact

    if (report%signed .or. .not. ls%automatic .or. ls%neq == 0) return
    inexact = .not. ls%factors%exact
    call prove_definite(ls, a, report, error)
    if (allocated(error) .or. report%signed) return
    do
      call factorise(ls, a, report, error)
      if (allocated(error) .or. report%singular) return
      if (.not. are_doubtful(ls)) exit
      call be_exact(ls%factors)
    end do
    report%gave_up_single = report%gave_up_single .or. (inexact .and. ls%factors%exact)
  end subroutine find_signs

  !> Factorise the matrix, and report the time that this takes, and that of the analyses since the
  !! last report.
  subroutine factorise(ls, a, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: start(2), before(2)

    start = seconds_of_both()
    before = ls%factors%seconds_analyse
    call renew(ls%factors, a, report, error)
    associate (analysis => ls%factors%seconds_analyse)
      report%seconds_analyse = report%seconds_analyse + analysis
      report%seconds_factor = report%seconds_factor + seconds_of_both() - start &
                              - (analysis - before)
      analysis = 0.0_wp
    end associate
    if (allocated(error)) return
    call note_factorisation(ls%policy, ls%factors%solver%info%flops, &
                            ls%factors%solver%info%entries)
    if (allocated(ls%probe)) deallocate (ls%probe) ! it depends on the factors
    if (ls%mode /= FULL) call note_matrix(ls%correction, a)
    ls%current = ls%factors%valid
    report%singular = .not. ls%factors%valid
    report%converged = ls%factors%valid
    report%signed = ls%factors%valid
    call describe(ls, report)
  end subroutine factorise

  !> Try to find the signs of all pivots without a new factorisation. They are known if kept factors
  !! show that the matrix is positive definite; otherwise the next solve factorises the matrix.
  subroutine prove_definite(ls, a, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: start(2)

    if (ls%policy%due .or. .not. ls%factors%valid) return
    start = seconds_of_both()
    if (is_definite(ls, a)) call is_still_definite(a, ls%factors%eq, ls%factors%solver, ls%probe, &
                                                   report%signed, report%iterations, error)
    ls%policy%due = .not. report%signed
    report%seconds_solve = report%seconds_solve + seconds_of_both() - start
  end subroutine prove_definite

  !> Are matrix and factors positive definite as far as is known?
  pure logical function is_definite(ls, a)
    class(linear_system_t), intent(in) :: ls
    type(block_matrix_t), intent(in) :: a

    is_definite = a%symmetric .and. ls%factors%solver%symmetric &
                  .and. ls%factors%solver%info%negative == 0
  end function is_definite

  !> Are the factors approximate, and do they have negative pivots or a determinant that is not
  !! positive? Such signs may be due to rounding.
  pure logical function are_doubtful(ls)
    class(linear_system_t), intent(in) :: ls

    associate (info => ls%factors%solver%info)
      are_doubtful = .not. ls%factors%exact .and. (info%negative > 0 .or. info%determinant < 1)
    end associate
  end function are_doubtful

  !> Iterate with the existing factors: by conjugate gradients if matrix and factors are positive
  !! definite as far as is known and the factors are not corrected, otherwise by GMRES. If conjugate
  !! gradients meet a direction of negative curvature with current factors, GMRES follows.
  subroutine iterate(ls, a, rhs, x, tolerance, run, report, error)
    class(linear_system_t), intent(inout) :: ls
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: rhs(:), tolerance
    real(wp), intent(out) :: x(:)
    type(krylov_report_t), intent(out) :: run
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: start(2), most
    real(wp), allocatable :: b(:)
    integer :: limit, power
    logical :: definite

    x = 0.0_wp
    run%converged = .true.
    most = maxval(abs(rhs))
    if (.not. most > 0.0_wp) return
    ! Very small and very large loads are scaled, because the squares in their norms are not
    ! representable. Scaling by a power of two changes no digit.
    power = 0
    if (most < SMALLEST .or. most > LARGEST) power = exponent(most)
    b = rhs
    if (power /= 0) b = scale(rhs, -power)
    start = seconds_of_both()
    limit = iteration_limit(ls%policy, ls%current, ls%factors%exact)
    definite = is_definite(ls, a) .and. .not. ls%correction%acts
    if (definite) then
      call conjugate_gradients(a, ls%factors%eq, ls%factors%solver, b, x, limit, tolerance, &
                               run, error, hurries=.not. ls%current)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
    end if
    ! If old factors led to a direction of negative curvature, new factors are made first, because
    ! their pivots show whether the matrix is indefinite.
    if (.not. definite .or. (run%indefinite .and. ls%current .and. .not. run%converged)) then
      call gmres(a, ls%factors%eq, ls%factors%solver, ls%correction, b, x, limit, tolerance, &
                 run, error, hurries=.not. ls%current)
      if (allocated(error)) return
      report%iterations = report%iterations + run%iterations
      report%used_gmres = .true.
    end if
    if (power /= 0) x = scale(x, power)
    call describe(ls, report)
    report%seconds_solve = report%seconds_solve + seconds_of_both() - start
  end subroutine iterate

  !> Copy the information of the solver into the report.
  subroutine describe(ls, report)
    class(linear_system_t), intent(inout) :: ls
    type(solve_report_t), intent(inout) :: report

    associate (info => ls%factors%solver%info)
      report%negative = info%negative
      report%determinant = info%determinant
      report%memory_mb = info%used_mb
    end associate
    report%used_single = .not. ls%factors%exact .and. ls%mode == SINGLE
    if (allocated(ls%factors%note)) call move_alloc(ls%factors%note, report%storage)
  end subroutine describe

  !> Factorise at the next solve, and forget what is known about earlier matrices. From then on,
  !! results depend only on later matrices, as a restart point requires.
  subroutine force_refactor(self)
    class(linear_system_t), intent(inout) :: self

    self%policy = reuse_policy_t()
    self%corrects = .false.
    call forget_correction(self%correction)
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

  !> Does a factorisation cost so much that AUTO keeps it?
  pure logical function worth_keeping(flops, entries, least) result(worth)
    real(wp), intent(in) :: flops   !! operations of the elimination
    real(wp), intent(in) :: entries !! entries of the factors
    real(wp), intent(in), optional :: least !! replaces KEEPING

    worth = cost_of(flops, entries) > KEEPING
    if (present(least)) worth = cost_of(flops, entries) > least
  end function worth_keeping

  !> Cost of a factorisation, in iterations.
  pure real(wp) function cost_of(flops, entries)
    real(wp), intent(in) :: flops, entries

    cost_of = PREPARATION + flops/max(entries, 1.0_wp)/OPERATIONS_AN_ENTRY
  end function cost_of

  !> Record the cost of a factorisation.
  pure subroutine note_factorisation(policy, flops, entries)
    type(reuse_policy_t), intent(inout) :: policy
    real(wp), intent(in) :: flops   !! operations of the elimination
    real(wp), intent(in) :: entries !! entries of the factors

    policy%due = .false.
    policy%worth = cost_of(flops, entries)
    policy%spent = policy%worth
    policy%digits = 0.0_wp
  end subroutine note_factorisation

  !> Record the cost of a solve, and find out whether the factorisation should be replaced.
  pure subroutine note_solve(policy, iterations, digits, more)
    type(reuse_policy_t), intent(inout) :: policy
    integer, intent(in) :: iterations
    real(wp), intent(in) :: digits  !! decimal digits by which the residual had to fall
    real(wp), intent(in), optional :: more !! further cost of the solve, in iterations
    real(wp) :: cost

    cost = iterations
    if (present(more)) cost = cost + more
    if (policy%digits > 0.0_wp) policy%due = cost*policy%digits > policy%spent*digits
    policy%spent = policy%spent + cost
    policy%digits = policy%digits + digits
  end subroutine note_solve

  !> Number of iterations after which a solve is abandoned.
  pure integer function iteration_limit(policy, same_matrix, exact) result(limit)
    type(reuse_policy_t), intent(in) :: policy
    logical, intent(in) :: same_matrix !! the factors are those of this matrix
    logical, intent(in) :: exact       !! the factors are in double precision and not compressed

    limit = max(LEAST_LIMIT, ceiling(policy%worth))
    if (same_matrix .and. exact) limit = EXACT_LIMIT
  end function iteration_limit

end module linear_system
