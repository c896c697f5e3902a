!> Corrects kept factors at the nodes where the matrix has changed most, usually nodes in contact.
!!
!! The kept factors M give an approximate solution for the whole matrix A. Then the equations S of
!! all nodes whose diagonal block has changed by more than the fraction CHANGED since M was made are
!! solved with factors of the current block A_SS, in single precision:
!!
!!   z = M^-1 r,   z_S <- z_S + A_SS^-1 (r - A z)_S .
!!
!! When a contact opens, closes, slips or moves to other elements, the penalty changes a few rows of
!! A. M does not contain these changes, and iterations with M alone find the corresponding motions
!! only one by one. A_SS is usually much smaller than A, and is factorised anew for each matrix A. S
!! grows until M is renewed.
module factor_correction
  use base_agreement, only: agree
  use base_comm, only: largest
  use base_error, only: error_t, SYSTEM_ERROR
  use base_kinds, only: wp
  use csr, only: block_matrix_t, diagonal_block, multiply_free
  use csr_extract, only: entries_t, new_entries, gather
  use solver_mumps, only: solver_mumps_t, new_solver_mumps
  use tangent_factors, only: find_order
  implicit none
  private
  public :: correction_t, note_matrix, correct, add_correction, forget_correction

  !> A node belongs to S if its diagonal block has changed by more than this fraction.
  real(wp), parameter :: CHANGED = 0.1_wp
  !> The correction is not made if S contains more than this fraction of all equations.
  real(wp), parameter :: LARGEST_PART = 0.4_wp

  type :: correction_t
    logical :: acts = .false.              !! the correction is used for the current matrix
    !> (3, 3, nnode) diagonal blocks of the matrix whose factors are kept.
    real(wp), allocatable, private :: known(:, :, :)
    integer, allocatable, private :: eq(:, :)        !! (3, nnode) numbers in A_SS, 0: not in S
    integer, allocatable, private :: whole(:)        !! (ns) numbers of these equations in A
    integer, allocatable, private :: col(:)          !! pattern of the last analysis
    type(entries_t), private :: list
    type(solver_mumps_t) :: solver         !! solver of A_SS
  end type correction_t

contains

  !> Record the diagonal of the matrix that is factorised.
  subroutine note_matrix(correction, a)
    type(correction_t), intent(inout) :: correction
    type(block_matrix_t), intent(in) :: a
    integer :: n

    call forget_correction(correction)
    allocate (correction%known(3, 3, a%nnode))
    do n = 1, a%nnode
      correction%known(:, :, n) = diagonal_block(a, n)
    end do
  end subroutine note_matrix

  !> Make the correction for a matrix. It is not used if nothing or too much has changed, if it
  !! would cost too much, if there is too little memory, or if A_SS is singular.
  subroutine correct(correction, a, eq, most, error)
    type(correction_t), intent(inout) :: correction
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)        !! (3, nnode) equation numbers, 0: prescribed
    real(wp), intent(in) :: most           !! largest number of operations allowed for A_SS
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: values(:)
    logical :: analysed

    correction%acts = .false.
    if (.not. allocated(correction%known)) return
    call collect(correction, a, eq, analysed)
    if (size(correction%whole) == 0 .or. &
        size(correction%whole) > LARGEST_PART*count(eq > 0)) return
    if (.not. analysed) call analyse_part(correction, a, error)
    if (allocated(error)) then
      call leave_out(error)
      return
    end if
    if (correction%solver%info%flops > most) return
    allocate (values(size(correction%list%row)))
    call gather(correction%list, a, values)
    call correction%solver%factorise(values, 0.0_wp, error)
    correction%acts = .not. allocated(error)
    if (correction%acts) correction%acts = size(correction%solver%info%null) == 0
    call leave_out(error)

  contains

    !> If there is too little memory, go on without the correction.
    subroutine leave_out(error)
      type(error_t), allocatable, intent(inout) :: error

      if (.not. allocated(error)) return
      if (error%code == SYSTEM_ERROR) deallocate (error)
    end subroutine leave_out

  end subroutine correct

  !> Add the nodes that have changed to S.
  subroutine collect(correction, a, eq, analysed)
    type(correction_t), intent(inout) :: correction
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    logical, intent(out) :: analysed       !! .true.: neither S nor the pattern has changed
    integer :: i, n, ns
    logical :: grown

    if (.not. allocated(correction%eq)) allocate (correction%eq(3, a%nnode), source=0)
    grown = .false.
    do n = 1, a%nnode
      if (all(eq(:, n) == 0) .or. any(correction%eq(:, n) > 0)) cycle
      associate (known => correction%known(:, :, n))
        if (norm2(diagonal_block(a, n) - known) <= CHANGED*norm2(known)) cycle
      end associate
      where (eq(:, n) > 0) correction%eq(:, n) = 1
      grown = .true.
    end do
    analysed = .not. grown .and. allocated(correction%col)
    if (analysed) analysed = size(correction%col) == size(a%col)
    if (analysed) analysed = all(correction%col == a%col)
    analysed = largest(merge(0, 1, analysed)) == 0
    if (.not. grown .and. allocated(correction%whole)) return
    ns = 0
    if (allocated(correction%whole)) deallocate (correction%whole)
    allocate (correction%whole(count(correction%eq > 0)))
    do n = 1, a%nnode
      do i = 1, 3
        if (correction%eq(i, n) == 0) cycle
        ns = ns + 1
        correction%eq(i, n) = ns
        correction%whole(ns) = eq(i, n)
      end do
    end do
  end subroutine collect

  !> Analyse the pattern of A_SS.
  subroutine analyse_part(correction, a, error)
    type(correction_t), intent(inout) :: correction
    type(block_matrix_t), intent(in) :: a
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: order(:)

    if (allocated(correction%col)) deallocate (correction%col)
    call new_entries(correction%list, a, correction%eq, error)
    call agree(error)
    if (allocated(error)) return
    call find_order(a, correction%eq, order, error)
    if (allocated(error)) return
    call correction%solver%free()
    call new_solver_mumps(correction%solver, single=.true., low_rank=0.0_wp)
    associate (list => correction%list)
      call correction%solver%analyse(list%neq, a%symmetric, list%row, list%col, order, error)
    end associate
    if (.not. allocated(error)) correction%col = a%col
  end subroutine analyse_part

  !> Release all memory, and forget the diagonal of the matrix that was factorised.
  subroutine forget_correction(correction)
    type(correction_t), intent(inout) :: correction

    call correction%solver%free()
    correction%acts = .false.
    if (allocated(correction%known)) deallocate (correction%known)
    if (allocated(correction%eq)) deallocate (correction%eq, correction%whole)
    if (allocated(correction%col)) deallocate (correction%col)
    correction%list = entries_t()
  end subroutine forget_correction

  !> Add A_SS^-1 (r - A z)_S to z_S, where z is the solution with the kept factors.
  subroutine add_correction(correction, a, eq, r, z, y, xn, yn, error)
    type(correction_t), intent(inout) :: correction
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: r(:)
    real(wp), intent(inout) :: z(:)
    real(wp), intent(inout) :: y(:), xn(:, :) !! work space of the product A z
    real(wp), intent(inout), contiguous :: yn(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: part(size(correction%whole), 1)

    call multiply_free(a, eq, z, y, xn, yn)
    part(:, 1) = r(correction%whole) - y(correction%whole)
    call correction%solver%solve(part, error)
    if (.not. allocated(error)) z(correction%whole) = z(correction%whole) + part(:, 1)
  end subroutine add_correction

end module factor_correction
