!> Options of MUMPS, the same in both precisions. Numbers are those of the users' guide, 5.5.
module solver_mumps_control
  implicit none
  private
  public :: set_controls, set_fronts, set_panels

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

  !> Smaller fronts than by default: nodes of the elimination tree are merged with fewer pivots. On
  !! cubes of 26 and 82 thousand equations this saved 9 and 7 % of the operations and of the
  !! entries. KEEP is not in the guide; these have stood in MUMPS's dini_defaults.F since 5.0.
  !! Before the analysis.
  pure subroutine set_fronts(keep)
    integer, intent(inout) :: keep(:)

    keep(1) = 2
  end subroutine set_fronts

  !> Narrower inner panels than by default (16 and 32 columns) for symmetric matrices: inside a
  !! panel MUMPS updates column by column, which took a fifth of the time; the rest is dgemm. Saved
  !! 15 % of a factorisation of 26 thousand equations. After the analysis.
  pure subroutine set_panels(keep)
    integer, intent(inout) :: keep(:)

    keep(5:6) = 8
  end subroutine set_panels

end module solver_mumps_control
