!> Which solver a system gets, with its pattern analysed.
module solver_choice
  use base_kinds, only: wp
  use base_error, only: error_t
  use csr_pattern, only: block_matrix_t
  use csr_extract, only: entries_t, new_entries
  use partition_metis, only: elimination_order
  use solver_type, only: solver_t
  use solver_dense, only: solver_dense_t
  use solver_mumps, only: solver_mumps_t, new_solver_mumps
  implicit none
  private
  public :: new_solver

  integer, parameter :: SMALL = 24 !! equations up to which the dense solver does it

contains

  !> A solver for the free dofs of a matrix: dense for a few equations, sparse with METIS's order
  !! for more.
  subroutine new_solver(solver, entries, a, eq, single, low_rank, exact, error)
    class(solver_t), allocatable, intent(out) :: solver
    type(entries_t), intent(out) :: entries
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)      !! (3, nnode) equation numbers, 0: prescribed
    logical, intent(in) :: single        !! factors in single precision
    real(wp), intent(in) :: low_rank     !! relative error of compressed blocks; 0: none
    logical, intent(out) :: exact        !! factors will be in double precision, not compressed
    type(error_t), allocatable, intent(out) :: error

    type(solver_mumps_t), allocatable :: mumps
    integer, allocatable :: order(:)

    call new_entries(entries, a, eq, error)
    if (allocated(error)) return
    exact = entries%neq <= SMALL .or. .not. (single .or. low_rank > 0.0_wp)
    if (entries%neq <= SMALL) then
      allocate (solver_dense_t :: solver)
      order = [integer ::]
    else
      allocate (mumps)
      call new_solver_mumps(mumps, single, low_rank)
      call move_alloc(mumps, solver)
      call elimination_order(a, eq, order, error)
      if (allocated(error)) return
    end if
    call solver%analyse(entries%neq, a%symmetric, entries%row, entries%col, order, error)
  end subroutine new_solver

end module solver_choice
