!> Options of MUMPS, the same in both precisions. Numbers are those of the users' guide, 5.5.
module solver_mumps_control
  implicit none
  private
  public :: set_controls

  integer, parameter, public :: ORDER_AMD = 0, ORDER_GIVEN = 1, ORDER_PORD = 4 !! ICNTL(7)
  integer, parameter, public :: FIRST_MARGIN = 20 !! work space beyond the estimate [%]

contains

  !> Set ICNTL before the analysis.
  pure subroutine set_controls(icntl, symmetric, compressed, ordering)
    integer, intent(inout) :: icntl(:)
    logical, intent(in) :: symmetric
    logical, intent(in) :: compressed  !! low-rank blocks
    integer, intent(in) :: ordering

    icntl(1:4) = [-1, -1, -1, 0] ! silence
    icntl(6) = 0   ! no permutation to the diagonal: it would need values in the analysis
    icntl(7) = ordering
    icntl(12) = 1  ! nor another symmetric preprocessing
    icntl(13) = 1  ! root node as all others: the inertia is then exact
    icntl(14) = FIRST_MARGIN
    icntl(24) = 1  ! detect null pivots
    icntl(28) = 1  ! sequential analysis
    if (.not. symmetric) icntl(33) = 1 ! determinant
    if (compressed) icntl(35) = 2
  end subroutine set_controls

end module solver_mumps_control
