!> What the solution of a linear system reports.
module solve_report
  use base_kinds, only: wp
  implicit none
  private
  public :: solve_report_t

  !> What a solve did.
  type :: solve_report_t
    logical :: factorised = .false.        !! in this call
    logical :: converged = .false.         !! the tolerance, or all that rounding allows, is met
    logical :: singular = .false.          !! no solution: x is zero, see null
    integer, allocatable :: null(:)        !! equations whose pivot vanished
    integer :: iterations = 0              !! applications of the factors, failed attempts included
    integer :: factorisations = 0          !! in this call
    logical :: used_single = .false.       !! the last factors are in single precision
    logical :: used_gmres = .false.
    integer :: negative = 0                !! negative pivots of the factors in use
    integer :: determinant = 1             !! unsymmetric: sign of the determinant of the same
    real(wp) :: residual = 0.0_wp          !! |b - A x| / |b|
    real(wp) :: seconds_factor = 0.0_wp    !! wall time of analysis and factorisation
    real(wp) :: seconds_solve = 0.0_wp     !! wall time of the rest
    real(wp) :: memory_mb = 0.0_wp         !! held by the factors
  end type solve_report_t

end module solve_report
