!> Dense solver by LAPACK for tests and very small models.
!!
!! Symmetric systems are solved with the eigenvalues of the matrix, which give the inertia and the
!! null space reliably. Other systems are solved with LU factors.
module solver_dense
  use base_error, only: error_t, fail, BUG, SYSTEM_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text
  use lapack, only: dgetrf, dgetrs, dsyev
  use null_space, only: pick_dofs
  use solver_type, only: solver_t
  implicit none
  private
  public :: solver_dense_t

  integer, parameter :: MOST_EQUATIONS = 3000

  !> Pattern and factors.
  type, extends(solver_t) :: solver_dense_t
    private
    integer, allocatable :: row(:), col(:)
    real(wp), allocatable :: factor(:, :)   !! (neq, neq) eigenvectors, or L and U
    real(wp), allocatable :: eigenvalue(:)  !! (neq)
    integer, allocatable :: pivot(:)        !! (neq)
  contains
    procedure :: analyse
    procedure :: factorise
    procedure :: solve
    procedure :: free
  end type solver_dense_t

contains

  subroutine analyse(self, neq, symmetric, row, col, order, error)
    class(solver_dense_t), intent(inout) :: self
    integer, intent(in) :: neq
    logical, intent(in) :: symmetric
    integer, intent(in) :: row(:), col(:)
    integer, intent(in) :: order(:)
    type(error_t), allocatable, intent(out) :: error

    if (neq > MOST_EQUATIONS .or. (size(order) /= 0 .and. size(order) /= neq)) then
      call fail(error, BUG, 'expected at most '//to_text(MOST_EQUATIONS)//' equations for the ' &
                //'dense solver, with positions for all or none, found '//to_text(neq) &
                //' equations and '//to_text(size(order))//' positions')
      return
    end if
    self%neq = neq
    self%symmetric = symmetric
    self%row = row
    self%col = col
    self%info%flops = 2.0_wp/3.0_wp*real(neq, wp)**3
    self%info%entries = real(neq, wp)**2
    self%info%estimate_mb = 8e-6_wp*real(neq, wp)**2
  end subroutine analyse

  subroutine factorise(self, values, available_mb, error)
    class(solver_dense_t), intent(inout) :: self
    real(wp), intent(in) :: values(:)
    real(wp), intent(in) :: available_mb !! not used, because the matrix is small
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: work(:)
    logical, allocatable :: is_null(:)
    real(wp) :: largest
    integer :: status, k

    if (available_mb < 0.0_wp .or. size(values) /= size(self%row)) then
      call fail(error, BUG, 'expected '//to_text(size(self%row))//' values of the matrix, found ' &
                //to_text(size(values)))
      return
    end if
    if (allocated(self%factor)) deallocate (self%factor)
    allocate (self%factor(self%neq, self%neq), source=0.0_wp)
    do k = 1, size(values)
      self%factor(self%row(k), self%col(k)) = self%factor(self%row(k), self%col(k)) + values(k)
      if (self%symmetric .and. self%row(k) /= self%col(k)) then
        self%factor(self%col(k), self%row(k)) = self%factor(self%col(k), self%row(k)) + values(k)
      end if
    end do
    self%info%used_mb = self%info%estimate_mb
    self%info%negative = 0
    self%info%determinant = 0
    self%info%null = [integer ::]
    if (self%neq == 0) return
    if (self%symmetric) then ! eigenvalues and eigenvectors
      if (allocated(self%eigenvalue)) deallocate (self%eigenvalue)
      allocate (self%eigenvalue(self%neq), work(3*self%neq))
      call dsyev('V', 'U', self%neq, self%factor, self%neq, self%eigenvalue, work, size(work), &
                 status)
      if (status /= 0) then
        call fail(error, SYSTEM_ERROR, 'LAPACK did not find the eigenvalues of the tangent')
        return
      end if
      is_null = [(.false., k=1, self%neq)]
      do k = 1, self%neq
        if (abs(self%eigenvalue(k)) <= relative_rounding(self)*maxval(abs(self%eigenvalue))) then
          is_null(k) = .true.
        else if (self%eigenvalue(k) < 0.0_wp) then
          self%info%negative = self%info%negative + 1
        end if
      end do
      call pick_dofs(self%factor(:, pack([(k, k=1, self%neq)], is_null)), self%info%null)
    else ! LU with row exchanges: a zero pivot is in the column of an unknown without stiffness
      largest = maxval(abs(self%factor))
      if (allocated(self%pivot)) deallocate (self%pivot)
      allocate (self%pivot(self%neq))
      call dgetrf(self%neq, self%neq, self%factor, self%neq, self%pivot, status)
      self%info%determinant = 1
      do k = 1, self%neq
        associate (pivot => self%factor(k, k), det => self%info%determinant)
          if (abs(pivot) <= relative_rounding(self)*largest) self%info%null = [self%info%null, k]
          if (pivot < 0.0_wp .neqv. self%pivot(k) /= k) det = -det
        end associate
      end do
      if (size(self%info%null) > 0) self%info%determinant = 0
    end if
  end subroutine factorise

  !> Numbers below this fraction of the largest one are taken as zero.
  pure real(wp) function relative_rounding(self)
    type(solver_dense_t), intent(in) :: self

    relative_rounding = 10*self%neq*epsilon(1.0_wp)
  end function relative_rounding

  subroutine solve(self, x, error)
    class(solver_dense_t), intent(inout) :: self
    real(wp), intent(inout) :: x(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: y(:, :)
    integer :: i, status

    if (self%neq == 0) return
    if (size(self%info%null) > 0) then
      call fail(error, BUG, 'the dense solver cannot solve with a singular matrix')
      return
    end if
    if (self%symmetric) then
      y = matmul(transpose(self%factor), x)
      do i = 1, self%neq
        y(i, :) = y(i, :)/self%eigenvalue(i)
      end do
      x = matmul(self%factor, y)
    else
      y = x
      call dgetrs('N', self%neq, size(y, 2), self%factor, self%neq, self%pivot, y, self%neq, status)
      x = y
    end if
  end subroutine solve

  subroutine free(self)
    class(solver_dense_t), intent(inout) :: self

    if (allocated(self%factor)) deallocate (self%factor)
    if (allocated(self%eigenvalue)) deallocate (self%eigenvalue)
    if (allocated(self%pivot)) deallocate (self%pivot)
    self%info%used_mb = 0.0_wp
  end subroutine free

end module solver_dense
