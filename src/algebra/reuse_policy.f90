!> When to factorise again.
!!
!! A kept factorisation gets worse as the matrix moves away from it. The cost of one solve, averaged
!! over the life of a factorisation, is least if it is replaced as soon as a solve costs more than
!! that average so far. Costs are iteration counts; a factorisation is worth as many iterations as
!! its operation count says. No clock is asked, so that runs repeat.
module reuse_policy
  use base_kinds, only: wp
  implicit none
  private
  public :: reuse_policy_t, note_factorisation, note_solve, iteration_limit

  integer, parameter :: EXACT_LIMIT = 10 !! iterations granted to exact factors of the same matrix
  integer, parameter :: LEAST_LIMIT = 10 !! iterations granted at least to any factors
  !> Operations of the elimination in the time in which a solve handles one entry of the factors:
  !! one thread does about 45e9 operations and 6e8 entries a second.
  real(wp), parameter :: OPERATIONS_AN_ENTRY = 72.0_wp

  !> The life of a factorisation.
  type :: reuse_policy_t
    logical :: due = .true.         !! factorise at the next solve
    real(wp) :: worth = 0.0_wp      !! cost of the factorisation [iterations]
    real(wp) :: spent = 0.0_wp      !! cost so far, factorisation included [iterations]
    integer :: solves = 0           !! so far
  end type reuse_policy_t

contains

  !> A factorisation was made.
  pure subroutine note_factorisation(policy, flops, entries)
    type(reuse_policy_t), intent(inout) :: policy
    real(wp), intent(in) :: flops   !! operations of the elimination
    real(wp), intent(in) :: entries !! entries of the factors

    policy%due = .false.
    policy%worth = flops/max(entries, 1.0_wp)/OPERATIONS_AN_ENTRY
    policy%spent = policy%worth
    policy%solves = 0
  end subroutine note_factorisation

  !> A solve took that many iterations.
  pure subroutine note_solve(policy, iterations)
    type(reuse_policy_t), intent(inout) :: policy
    integer, intent(in) :: iterations

    if (policy%solves > 0) policy%due = iterations*policy%solves > policy%spent
    policy%spent = policy%spent + iterations
    policy%solves = policy%solves + 1
  end subroutine note_solve

  !> Iterations granted to a solve before it is given up.
  pure integer function iteration_limit(policy, same_matrix, exact) result(limit)
    type(reuse_policy_t), intent(in) :: policy
    logical, intent(in) :: same_matrix !! the factors are those of this matrix
    logical, intent(in) :: exact       !! they are in double precision, not compressed

    limit = max(LEAST_LIMIT, ceiling(policy%worth))
    if (same_matrix .and. exact) limit = EXACT_LIMIT
  end function iteration_limit

end module reuse_policy
