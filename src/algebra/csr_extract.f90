!> The entries of a block matrix at the free dofs, as a list (row, column, value) for direct
!! solvers.
module csr_extract
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use csr, only: block_matrix_t
  implicit none
  private
  public :: entries_t, new_entries, gather

  !> Positions of the entries at the free dofs; for a symmetric matrix, only those of the upper
  !! triangle.
  type :: entries_t
    integer :: neq = 0
    logical :: symmetric = .true.
    integer, allocatable :: row(:)      !! (nnz) equation numbers
    integer, allocatable :: col(:)      !! (nnz)
    integer, allocatable :: place(:)    !! (nnz) position in a%val, taken as one vector
  end type entries_t

contains

  !> List the entries of a pattern at the free dofs.
  subroutine new_entries(entries, a, eq, error)
    type(entries_t), intent(out) :: entries
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)   !! (3, nnode) equation numbers, 0: prescribed
    type(error_t), allocatable, intent(out) :: error
    integer(i8) :: nnz
    integer :: stat

    entries%neq = 0
    if (size(eq) > 0) entries%neq = maxval(eq)
    entries%symmetric = a%symmetric
    nnz = 0
    call walk(entries, a, eq, nnz, counting=.true.)
    allocate (entries%row(nnz), stat=stat)
    if (stat == 0) allocate (entries%col(nnz), stat=stat)
    if (stat == 0) allocate (entries%place(nnz), stat=stat)
    if (stat /= 0) then
      call fail(error, SYSTEM_ERROR, 'not enough memory for the entries of the tangent matrix')
      return
    end if
    call walk(entries, a, eq, nnz, counting=.false.)
  end subroutine new_entries

  !> Visit the entries, either to count them or to store them.
  subroutine walk(entries, a, eq, nnz, counting)
    type(entries_t), intent(inout) :: entries
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    integer(i8), intent(out) :: nnz
    logical, intent(in) :: counting
    integer :: n, p, i, j, last

    nnz = 0
    do n = 1, a%nnode
      do p = a%row(n), a%row(n + 1) - 1
        do j = 1, 3
          if (eq(j, a%col(p)) == 0) cycle
          last = 3
          if (a%symmetric .and. a%col(p) == n) last = j ! upper triangle of a diagonal block
          do i = 1, last
            if (eq(i, n) == 0) cycle
            nnz = nnz + 1
            if (counting) cycle
            entries%row(nnz) = eq(i, n)
            entries%col(nnz) = eq(j, a%col(p))
            entries%place(nnz) = 9*(p - 1) + 3*(j - 1) + i
          end do
        end do
      end do
    end do
  end subroutine walk

  !> Get the values of the entries.
  pure subroutine gather(entries, a, values)
    type(entries_t), intent(in) :: entries
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(out) :: values(:) !! (nnz)

    call pick(size(a%val), a%val, entries%place, values)
  end subroutine gather

  !> Set values = val(place), with val taken as one vector.
  pure subroutine pick(n, val, place, values)
    integer, intent(in) :: n
    real(wp), intent(in) :: val(n)
    integer, intent(in) :: place(:)
    real(wp), intent(out) :: values(:)
    integer :: k

    do k = 1, size(place)
      values(k) = val(place(k))
    end do
  end subroutine pick

end module csr_extract
