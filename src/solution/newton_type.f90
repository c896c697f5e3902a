!> Newton's iteration of the current step, and the outcome of one iteration.
module newton_type
  use anderson, only: anderson_t
  use assembly, only: assembler_t, sweep_t
  use base_kinds, only: wp
  use continuation_type, only: path_constraint_t
  use linear_system, only: linear_system_t, solve_report_t, AUTO
  use secant_friction, only: secant_t
  use stabilisation, only: stabilisation_t
  implicit none
  private
  public :: newton_t, pass_t, floor_t

  type :: newton_t
    type(assembler_t) :: asm
    type(linear_system_t) :: system
    type(path_constraint_t) :: constraint !! measure prescribed in a step whose time is unknown
    type(stabilisation_t) :: hold      !! stabilises bodies that contact does not hold yet
    type(secant_t) :: secant           !! secants of friction in this step
    type(anderson_t) :: past           !! increments between which cells of contact changed
    logical :: ready = .false.         !! matrix pattern and symbolic factorisation exist
    logical :: symmetric = .true.      !! pattern and factorisation are for a symmetric matrix
    integer :: mode = AUTO             !! FACTor
    real(wp) :: eps = 0.0_wp           !! accuracy of LOWRank
    real(wp) :: tolerance = 1.0e-16_wp !! TOL
    integer :: iterations = 0          !! number of solves in this step
    integer :: before = 0              !! number of solves before the last augmentation
    logical :: alone = .false.         !! the deck does not repeat this solve in a loop
    logical :: converged = .false.
    logical :: exact = .true.          !! every solve of the step used the whole tangent
    real(wp) :: largest_energy = 0.0_wp !! largest energy of an increment of this step [F L]
    real(wp) :: least_residual = huge(1.0_wp) !! smallest residual of this step so far [F]
    integer :: stalls = 0              !! iterations of this step at the floor without improvement
    logical :: at_floor = .false.      !! the last energy passed only because of the rounding floor
    real(wp) :: first_energy = 0.0_wp  !! energy of the first increment of this step [F L]; 0: the
    !! step began with prescribed motion or a prediction, or follows a constraint
    real(wp) :: forcing = 0.0_wp       !! relative residual of the last solve
    real(wp) :: before_solve = 0.0_wp !! residual before that solve; 0: prescribed motion [F]
    real(wp) :: expected = 0.0_wp      !! residual expected after that solve [F]
    integer :: sign = 0                !! sign of the last tangent's determinant; 0: not known
    integer :: flips = 0               !! consecutive iterations that changed the sign
    real(wp), allocatable :: rhs(:)    !! (neq) [F]
    real(wp), allocatable :: dx(:)     !! (neq) increment [L]
    real(wp), allocatable :: last(:)   !! (neq) the part taken of the last increment [L]
    real(wp), allocatable :: move(:, :) !! (3, nnode) prescribed increments still to be made [L]
    real(wp), allocatable :: spacing(:) !! (nnode) distance to the nearest neighbour [L]
    logical :: moves = .false.         !! the next increment contains `move`
    logical :: begins = .false.        !! no forces have been formed in this step
    logical :: predicts = .false.      !! the step may start from predicted displacements
    real(wp), allocatable :: moved(:, :) !! (3, nnode) prescribed part of the last increment [L]
    logical :: has_moved = .false.     !! the last increment contained `moved`
    real(wp) :: overlap = 0.0_wp       !! penetration before the last increment, see overlap_found
    integer, allocatable :: piece(:)   !! (nnode) body of a node, for the predictor
    logical :: predicted = .false. !! displacements are predicted or turned; forces not formed yet
    logical :: may_retreat = .false.   !! the last increment may be shortened
  end type newton_t

  !> The residual and the energy that remain because of rounding alone (see convergence).
  type :: floor_t
    real(wp) :: force = 0.0_wp         !! rounding error of a nodal force [F]
    real(wp) :: energy = 0.0_wp        !! rounding error of |du.r| [F L]
  end type floor_t

  !> Outcome of one Newton iteration: the system is formed and solved once.
  type :: pass_t
    logical :: ok = .true.             !! .false.: the step must be cut
    character(:), allocatable :: trouble !! reason why the step must be cut
    logical :: hopeless = .false.      !! neither a smaller step nor another method can help
    type(sweep_t) :: sweep
    type(floor_t) :: floor
    type(solve_report_t) :: solve
    real(wp) :: energy = 0.0_wp        !! |du.r| [F L]
    real(wp) :: ratio = 0.0_wp         !! |du.r|, relative to the largest one of the step
    real(wp) :: residual = 0.0_wp      !! largest component at a free dof [F]
    integer :: worst(2) = 0            !! direction and node of this residual
    real(wp) :: line = 1.0_wp          !! fraction of the increment that was taken
    integer :: short = 0               !! solves whose increments were shortened by `hold`
  end type pass_t

end module newton_type
