!> The sparse direct solver MUMPS in double or single precision, with or without low-rank
!! compression, with factors in memory or on disk. Factors on disk are written into the folder that
!! the environment variable MUMPS_OOC_TMPDIR names.
!! Source: Amestoy, Duff, L'Excellent and Koster 2001 [bib: amestoy2001]; users' guide of MUMPS 5.5
module solver_mumps
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_agreement, only: agree
  use base_comm, only: largest
  use base_error, only: error_t, fail, BUG, NO_SOLUTION
  use base_kinds, only: wp
  use mumps_instance, only: mumps_t, start, runs, give_options, give_pattern, give_values, &
                            give_margin, narrow_panels, run, solve_with, null_pivots, finish, &
                            check_memory, ANALYSE_JOB, FACTORISE_JOB, ORDER_AMD, ORDER_GIVEN, &
                            ORDER_PORD, FIRST_MARGIN
  use solver_type, only: solver_t
  implicit none
  private
  public :: solver_mumps_t, new_solver_mumps, ORDER_AMD, ORDER_PORD

  integer, parameter :: LAST_MARGIN = 1000    !! largest work space in excess of the estimate [%]
  !> Values of INFOG(1) that report too little work space.
  integer, parameter :: TOO_NARROW(4) = [-8, -9, -14, -15]

  type, extends(solver_t) :: solver_mumps_t
    private
    logical :: single = .false.
    real(wp) :: low_rank = 0.0_wp             !! relative error of compressed blocks; 0: none
    logical :: on_disk = .false.              !! the factors are kept on disk
    integer :: ordering = ORDER_AMD           !! used if `analyse` gets no order
    integer :: margin = FIRST_MARGIN
    type(mumps_t) :: mumps
  contains
    procedure :: analyse
    procedure :: factorise
    procedure :: solve
    procedure :: free
  end type solver_mumps_t

contains

  !> Choose the precision, the compression and the storage of the factors.
  subroutine new_solver_mumps(solver, single, low_rank, ordering, on_disk)
    type(solver_mumps_t), intent(out) :: solver
    logical, intent(in) :: single              !! the factors are in single precision
    real(wp), intent(in) :: low_rank           !! relative error of compressed blocks; 0: none
    integer, intent(in), optional :: ordering  !! used if `analyse` gets no order
    logical, intent(in), optional :: on_disk

    solver%single = single
    solver%low_rank = low_rank
    if (present(ordering)) solver%ordering = ordering
    if (present(on_disk)) solver%on_disk = on_disk
  end subroutine new_solver_mumps

  subroutine analyse(self, neq, symmetric, row, col, order, error)
    class(solver_mumps_t), intent(inout) :: self
    integer, intent(in) :: neq
    logical, intent(in) :: symmetric
    integer, intent(in) :: row(:), col(:)
    integer, intent(in) :: order(:)
    type(error_t), allocatable, intent(out) :: error

    call self%free()
    self%neq = neq
    self%symmetric = symmetric
    self%pins_null_pivots = .true.
    self%info%null = [integer ::]
    if (neq == 0) return
    call start(self%mumps, self%single, symmetric, error)
    if (allocated(error)) return
    call give_options(self%mumps, symmetric, self%low_rank, &
                      merge(ORDER_GIVEN, self%ordering, size(order) > 0), self%on_disk)
    call give_pattern(self%mumps, neq, row, col, order, error)
    call agree(error)
    if (allocated(error)) return
    call run(self%mumps, ANALYSE_JOB, error)
    if (allocated(error)) return
    if (symmetric .and. .not. self%low_rank > 0.0_wp) call narrow_panels(self%mumps)
    associate (infog => self%mumps%infog)
      self%info%flops = self%mumps%rinfog(1)
      self%info%entries = count_of(infog(20))
      ! MUMPS rounds down to whole megabytes.
      if (self%low_rank > 0.0_wp) then
        self%info%estimate_mb = 1 + merge(infog(39), infog(37), self%on_disk)
      else
        self%info%estimate_mb = 1 + merge(infog(27), infog(17), self%on_disk)
      end if
    end associate
  end subroutine analyse

  !> A number of entries, which MUMPS gives in millions with a negative sign if it is large.
  pure real(wp) function count_of(n)
    integer, intent(in) :: n

    count_of = merge(real(n, wp), -1e6_wp*real(n, wp), n >= 0)
  end function count_of

  subroutine factorise(self, values, available_mb, error)
    class(solver_mumps_t), intent(inout) :: self
    real(wp), intent(in) :: values(:)
    real(wp), intent(in) :: available_mb
    type(error_t), allocatable, intent(out) :: error

    self%info%null = [integer ::]
    self%info%negative = 0
    self%info%determinant = 1
    if (self%neq == 0) return
    if (.not. runs(self%mumps)) then
      call fail(error, BUG, 'factorise was called before analyse')
      return
    end if
    if (largest(merge(0, 1, all(ieee_is_finite(values)))) > 0) then
      call fail(error, NO_SOLUTION, 'the tangent contains a number that is not finite')
      return
    end if
    if (available_mb > 0.0_wp) then
      call check_memory(self%info%estimate_mb, available_mb + self%info%used_mb, self%neq, &
                        self%single, error)
      if (allocated(error)) return
    end if
    call give_values(self%mumps, values)
    do ! pivoting may need more room than was estimated: repeat with more, within bounds
      call give_margin(self%mumps, self%margin)
      call run(self%mumps, FACTORISE_JOB, error)
      if (.not. allocated(error)) exit
      if (all(self%mumps%infog(1) /= TOO_NARROW) .or. 2*self%margin > LAST_MARGIN) return
      self%margin = 2*self%margin
    end do
    associate (infog => self%mumps%infog, mantissa => self%mumps%rinfog(12))
      self%info%used_mb = real(infog(19), wp)
      if (self%symmetric) then
        self%info%negative = infog(12)
      else
        self%info%determinant = 0
        if (abs(mantissa) > 0.0_wp) self%info%determinant = nint(sign(1.0_wp, mantissa))
      end if
    end associate
    self%info%null = null_pivots(self%mumps)
    if (size(self%info%null) > 0) self%info%determinant = 0
  end subroutine factorise

  subroutine solve(self, x, error)
    class(solver_mumps_t), intent(inout) :: self
    real(wp), intent(inout) :: x(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (size(x) > 0) call solve_with(self%mumps, x, error)
  end subroutine solve

  subroutine free(self)
    class(solver_mumps_t), intent(inout) :: self

    call finish(self%mumps)
    self%info%used_mb = 0.0_wp
    self%margin = FIRST_MARGIN
  end subroutine free

end module solver_mumps
