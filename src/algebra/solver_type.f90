!> The interface of direct solvers.
module solver_type
  use base_error, only: error_t
  use base_kinds, only: wp
  implicit none
  private
  public :: solver_t

  !> Results of the analysis and the factorisation.
  type :: factor_info_t
    real(wp) :: flops = 0.0_wp        !! operations of the elimination, estimated by the analysis
    real(wp) :: entries = 0.0_wp      !! entries in the factors, estimated by the analysis
    real(wp) :: estimate_mb = 0.0_wp  !! memory estimated by the analysis [MB]
    real(wp) :: used_mb = 0.0_wp      !! memory in use [MB]
    integer :: negative = 0           !! number of negative pivots (symmetric matrices)
    integer :: determinant = 0        !! sign of the determinant (unsymmetric matrices; 0: singular)
    integer, allocatable :: null(:)   !! equations with zero pivots; empty: regular matrix
  end type factor_info_t

  !> A solver analyses a pattern, factorises matrices with this pattern, and solves any number of
  !! systems with each matrix.
  type, abstract :: solver_t
    integer :: neq = 0
    logical :: symmetric = .true.
    logical :: pins_null_pivots = .false. !! `solve` works for singular matrices too
    type(factor_info_t) :: info
  contains
    procedure(analyse_i), deferred :: analyse
    procedure(factorise_i), deferred :: factorise
    procedure(solve_i), deferred :: solve
    procedure(free_i), deferred :: free
  end type solver_t

  abstract interface
    !> Take a pattern. For a symmetric matrix, each pair (row, col) is listed once, in either order.
    subroutine analyse_i(self, neq, symmetric, row, col, order, error)
      import :: solver_t, error_t
      implicit none
      class(solver_t), intent(inout) :: self
      integer, intent(in) :: neq
      logical, intent(in) :: symmetric
      integer, intent(in) :: row(:), col(:) !! (nnz)
      integer, intent(in) :: order(:)       !! (neq) positions in the elimination; empty: any order
      type(error_t), allocatable, intent(out) :: error
    end subroutine analyse_i

    !> Take the values and factorise. A singular matrix is not an error: see info%null.
    subroutine factorise_i(self, values, available_mb, error)
      import :: solver_t, error_t, wp
      implicit none
      class(solver_t), intent(inout) :: self
      real(wp), intent(in) :: values(:)     !! (nnz)
      real(wp), intent(in) :: available_mb  !! memory in addition to that in use [MB]; 0: unknown
      type(error_t), allocatable, intent(out) :: error
    end subroutine factorise_i

    !> Solve in place: the solutions replace the right-hand sides.
    subroutine solve_i(self, x, error)
      import :: solver_t, error_t, wp
      implicit none
      class(solver_t), intent(inout) :: self
      real(wp), intent(inout) :: x(:, :)    !! (neq, nrhs)
      type(error_t), allocatable, intent(out) :: error
    end subroutine solve_i

    !> Release all memory.
    subroutine free_i(self)
      import :: solver_t
      implicit none
      class(solver_t), intent(inout) :: self
    end subroutine free_i
  end interface

end module solver_type
