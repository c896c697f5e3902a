!> The step under way, as Newton's iteration sees it, and what one pass of it did.
module newton_type
  use base_kinds, only: wp
  use local_type, only: local_t
  use linear_system, only: linear_system_t, solve_report_t, FULL
  use assembly, only: assembler_t, sweep_t
  use rounding_floor, only: floor_t
  implicit none
  private
  public :: newton_t, pass_t

  !> The iteration of the step under way.
  type :: newton_t
    type(assembler_t) :: asm
    type(linear_system_t) :: system
    type(local_t) :: local             !! local control, where it is on
    logical :: ready = .false.         !! pattern and analysis exist
    logical :: symmetric = .true.      !! as they stand
    integer :: mode = FULL             !! FACTor
    real(wp) :: eps = 0.0_wp           !! of LOWRank
    real(wp) :: tolerance = 1.0e-16_wp !! TOL
    integer :: iterations = 0          !! solves in this step
    integer :: before = 0              !! of them before the last augmentation
    logical :: converged = .false.
    logical :: exact = .true. !! every solve of the step was full Newton: no kept factors, no
    !! symmetric part
    real(wp) :: largest_energy = 0.0_wp
    integer :: sign = 0                !! of the last tangent's determinant; 0: not known
    integer :: flips = 0               !! iterations in a row that changed it
    real(wp), allocatable :: rhs(:)    !! (neq)
    real(wp), allocatable :: dx(:)     !! (neq)
    real(wp), allocatable :: last(:)   !! (neq) what was made of it in the last iteration
    real(wp), allocatable :: move(:, :) !! (3, nnode) prescribed increments still to be made
    real(wp), allocatable :: spacing(:) !! (nnode) to the nearest neighbour [L]
    logical :: moves = .false.
    logical :: may_retreat = .false.   !! the last increment moved no prescribed dof, and was needed
  end type newton_t

  !> What one pass did.
  type :: pass_t
    logical :: ok = .true.             !! .false.: the step must be cut
    character(:), allocatable :: trouble !! why
    type(sweep_t) :: sweep
    type(floor_t) :: floor             !! what rounding leaves
    type(solve_report_t) :: solve
    real(wp) :: energy = 0.0_wp        !! |du.r| [F L]
    real(wp) :: ratio = 0.0_wp         !! to the largest of the step
    real(wp) :: residual = 0.0_wp      !! largest free component [F]
    integer :: worst(2) = 0            !! its direction and node
    real(wp) :: line = 1.0_wp          !! share of the step a line search took
  end type pass_t

end module newton_type
