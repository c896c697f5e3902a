!> Sparse direct solver MUMPS, double or single precision, with or without low-rank compression.
!! The only file that sees MUMPS.
!! Source: Amestoy, Duff, L'Excellent and Koster 2001 [bib: amestoy2001]; users' guide of MUMPS 5.5
module solver_mumps
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_get_underflow_mode
  use, intrinsic :: ieee_arithmetic, only: ieee_set_underflow_mode, ieee_support_underflow_control
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, BUG, NO_SOLUTION, SYSTEM_ERROR
  use base_text, only: to_text
  use solver_type, only: solver_t
  use solver_mumps_control, only: set_controls, set_fronts, set_panels, FIRST_MARGIN, &
                                  ORDER_AMD, ORDER_GIVEN, ORDER_PORD
  use solver_mumps_text, only: check_memory, describe_failure
  implicit none
  private
  public :: solver_mumps_t, new_solver_mumps, ORDER_AMD, ORDER_PORD

  include 'dmumps_struc.h'
  include 'smumps_struc.h'

  integer, parameter :: sp = kind(1.0)        !! what SMUMPS computes in
  integer, parameter :: INITIALISE = -1, FINISH = -2 !! values of JOB
  integer, parameter :: ANALYSE_JOB = 1, FACTORISE_JOB = 2, SOLVE_JOB = 3
  integer, parameter :: SYMMETRIC_GENERAL = 2, UNSYMMETRIC = 0 !! values of SYM
  !> Low-rank blocks are cut in the order of elimination: MUMPS 5.5 hands SCOTCH 7, which would
  !! group them otherwise, a graph without initialising it, and crashes now and then.
  integer, parameter :: CLUSTERING = 482, PLAIN = 3 !! an index and a value of KEEP
  integer, parameter :: LAST_MARGIN = 1000    !! largest work space beyond the estimate [%]
  !> A pivot of the scaled matrix below this is an exact zero but for rounding (an equation without
  !! stiffness). Free bodies leave larger ones: see null_space.
  real(wp), parameter :: NULL_PIVOT = 1e-18_wp, NULL_PIVOT_SINGLE = 1e-12_wp

  !> One instance of MUMPS.
  type, extends(solver_t) :: solver_mumps_t
    private
    logical :: single = .false.
    real(wp) :: low_rank = 0.0_wp             !! relative error of compressed blocks; 0: none
    integer :: ordering = ORDER_AMD           !! used where no order is given
    integer :: margin = FIRST_MARGIN
    real(wp) :: scale = 1.0_wp                !! power of two, divides the single matrix
    type(dmumps_struc), pointer :: d => null()
    type(smumps_struc), pointer :: s => null()
    integer :: infog(80) = 0
    real(wp) :: rinfog(40) = 0.0_wp
  contains
    procedure :: analyse
    procedure :: factorise
    procedure :: solve
    procedure :: free
  end type solver_mumps_t

  interface
    subroutine dmumps(id)
      import :: dmumps_struc
      implicit none
      type(dmumps_struc), intent(inout) :: id
    end subroutine dmumps

    subroutine smumps(id)
      import :: smumps_struc
      implicit none
      type(smumps_struc), intent(inout) :: id
    end subroutine smumps
  end interface

contains

  !> Choose precision and compression.
  subroutine new_solver_mumps(solver, single, low_rank, ordering)
    type(solver_mumps_t), intent(out) :: solver
    logical, intent(in) :: single              !! factors in single precision
    real(wp), intent(in) :: low_rank           !! relative error of compressed blocks; 0: none
    integer, intent(in), optional :: ordering  !! where `analyse` gets no order

    solver%single = single
    solver%low_rank = low_rank
    if (present(ordering)) solver%ordering = ordering
  end subroutine new_solver_mumps

  subroutine analyse(self, neq, symmetric, row, col, order, error)
    class(solver_mumps_t), intent(inout) :: self
    integer, intent(in) :: neq
    logical, intent(in) :: symmetric
    integer, intent(in) :: row(:), col(:)
    integer, intent(in) :: order(:)
    type(error_t), allocatable, intent(out) :: error

    integer :: ordering, stat

    call self%free()
    ordering = merge(ORDER_GIVEN, self%ordering, size(order) > 0)
    self%neq = neq
    self%symmetric = symmetric
    self%pins_null_pivots = .true.
    self%info%null = [integer ::]
    if (neq == 0) return
    call start(self, error)
    if (allocated(error)) return
    if (self%single) then
      call set_controls(self%s%icntl, symmetric, self%low_rank > 0.0_wp, ordering)
      call set_fronts(self%s%keep)
      self%s%cntl(3) = real(NULL_PIVOT_SINGLE, sp)
      self%s%cntl(7) = real(self%low_rank, sp)
      self%s%keep(CLUSTERING) = PLAIN
      call give_pattern(self%s%n, self%s%nnz, self%s%irn, self%s%jcn, self%s%perm_in)
      if (stat == 0) allocate (self%s%a(size(row)), stat=stat)
    else
      call set_controls(self%d%icntl, symmetric, self%low_rank > 0.0_wp, ordering)
      call set_fronts(self%d%keep)
      self%d%cntl(3) = NULL_PIVOT
      self%d%cntl(7) = self%low_rank
      self%d%keep(CLUSTERING) = PLAIN
      call give_pattern(self%d%n, self%d%nnz, self%d%irn, self%d%jcn, self%d%perm_in)
      if (stat == 0) allocate (self%d%a(size(row)), stat=stat)
    end if
    if (stat /= 0) then
      call fail(error, SYSTEM_ERROR, 'no memory for the tangent of '//to_text(neq)//' equations', &
                hint='use a coarser mesh or a machine with more memory')
      return
    end if
    call run(self, ANALYSE_JOB, error)
    if (allocated(error)) return
    if (symmetric .and. .not. self%low_rank > 0.0_wp) then
      if (self%single) call set_panels(self%s%keep)
      if (.not. self%single) call set_panels(self%d%keep)
    end if
    self%info%flops = self%rinfog(1)
    self%info%entries = count_of(self%infog(20))
    ! MUMPS rounds down to whole megabytes.
    self%info%estimate_mb = 1 + merge(self%infog(37), self%infog(17), self%low_rank > 0.0_wp)

  contains

    subroutine give_pattern(n, nnz, irn, jcn, perm_in)
      integer, intent(out) :: n
      integer(i8), intent(out) :: nnz
      integer, pointer, intent(inout) :: irn(:), jcn(:), perm_in(:)

      n = neq
      nnz = size(row, kind=i8)
      allocate (irn(nnz), stat=stat)
      if (stat == 0) allocate (jcn(nnz), stat=stat)
      if (stat == 0) allocate (perm_in(size(order)), stat=stat)
      if (stat /= 0) return
      irn = row
      jcn = col
      perm_in = order
    end subroutine give_pattern

  end subroutine analyse

  !> MUMPS returns large counts as negative millions.
  pure real(wp) function count_of(n)
    integer, intent(in) :: n

    count_of = merge(real(n, wp), -1e6_wp*real(n, wp), n >= 0)
  end function count_of

  !> A new instance.
  subroutine start(self, error)
    type(solver_mumps_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    integer :: kind_of_matrix

    kind_of_matrix = merge(SYMMETRIC_GENERAL, UNSYMMETRIC, self%symmetric)
    if (self%single) then
      allocate (self%s)
      self%s%comm = 0 ! libmpiseq does not look at it
      self%s%par = 1
      self%s%sym = kind_of_matrix
    else
      allocate (self%d)
      self%d%comm = 0
      self%d%par = 1
      self%d%sym = kind_of_matrix
    end if
    call run(self, INITIALISE, error)
  end subroutine start

  subroutine factorise(self, values, available_mb, error)
    class(solver_mumps_t), intent(inout) :: self
    real(wp), intent(in) :: values(:)
    real(wp), intent(in) :: available_mb
    type(error_t), allocatable, intent(out) :: error

    real(wp) :: largest

    self%info%null = [integer ::]
    self%info%negative = 0
    self%info%determinant = 1
    if (self%neq == 0) return
    if (.not. (associated(self%d) .or. associated(self%s))) then
      call fail(error, BUG, 'factorise was called before analyse')
      return
    end if
    if (.not. all(ieee_is_finite(values))) then
      call fail(error, NO_SOLUTION, 'the tangent holds a number that is not finite')
      return
    end if
    if (available_mb > 0.0_wp) then
      call check_memory(self%info%estimate_mb, available_mb + self%info%used_mb, self%neq, &
                        self%single, error)
      if (allocated(error)) return
    end if
    self%scale = 1.0_wp
    if (self%single) then
      largest = maxval(abs(values))
      if (largest > 0.0_wp) self%scale = 2.0_wp**exponent(largest)
      self%s%a = real(values/self%scale, sp)
    else
      self%d%a = values
    end if
    call factorise_with_margin(self, error)
    if (allocated(error)) return
    call read_info(self)
  end subroutine factorise

  !> Pivoting may need more room than the analysis foresaw: try again with more, within bounds.
  subroutine factorise_with_margin(self, error)
    type(solver_mumps_t), intent(inout) :: self
    type(error_t), allocatable, intent(out) :: error

    do
      if (self%single) then
        self%s%icntl(14) = self%margin
      else
        self%d%icntl(14) = self%margin
      end if
      call run(self, FACTORISE_JOB, error)
      if (.not. allocated(error)) return
      if (all(self%infog(1) /= [-8, -9, -14, -15]) .or. 2*self%margin > LAST_MARGIN) return
      self%margin = 2*self%margin
    end do
  end subroutine factorise_with_margin

  !> Pivots and memory.
  subroutine read_info(self)
    type(solver_mumps_t), intent(inout) :: self

    self%info%used_mb = real(self%infog(19), wp)
    if (self%symmetric) then
      self%info%negative = self%infog(12)
    else
      self%info%determinant = 0
      if (abs(self%rinfog(12)) > 0.0_wp) self%info%determinant = nint(sign(1.0_wp, self%rinfog(12)))
    end if
    if (self%infog(28) == 0) return
    if (self%single) then
      self%info%null = self%s%pivnul_list(1:self%infog(28))
    else
      self%info%null = self%d%pivnul_list(1:self%infog(28))
    end if
    self%info%determinant = 0
  end subroutine read_info

  subroutine solve(self, x, error)
    class(solver_mumps_t), intent(inout) :: self
    real(wp), intent(inout) :: x(:, :)
    type(error_t), allocatable, intent(out) :: error

    real(wp) :: factor
    integer :: n

    n = size(x)
    if (n == 0) return
    if (self%single) then
      factor = 1.0_wp
      if (maxval(abs(x)) > 0.0_wp) factor = 2.0_wp**exponent(maxval(abs(x)))
      allocate (self%s%rhs(n))
      self%s%rhs = real(reshape(x, [n])/factor, sp)
      self%s%nrhs = size(x, 2)
      self%s%lrhs = self%neq
      call run(self, SOLVE_JOB, error)
      x = reshape(real(self%s%rhs, wp), shape(x))*(factor/self%scale)
      deallocate (self%s%rhs)
    else
      allocate (self%d%rhs(n))
      self%d%rhs = reshape(x, [n])
      self%d%nrhs = size(x, 2)
      self%d%lrhs = self%neq
      call run(self, SOLVE_JOB, error)
      x = reshape(self%d%rhs, shape(x))
      deallocate (self%d%rhs)
    end if
  end subroutine solve

  !> One call of the library.
  subroutine run(self, job, error)
    type(solver_mumps_t), intent(inout) :: self
    integer, intent(in) :: job
    type(error_t), allocatable, intent(out) :: error

    if (self%single) then
      self%s%job = job
      call smumps_flushed(self%s)
      self%infog = self%s%infog
      self%rinfog = real(self%s%rinfog, wp)
    else
      self%d%job = job
      call dmumps(self%d)
      self%infog = self%d%infog
      self%rinfog = self%d%rinfog
    end if
    if (self%infog(1) < 0) call describe_failure(self%infog(1), self%infog(2), self%neq, error)
  end subroutine run

  !> Numbers below the normal range count as zero meanwhile: factors of a matrix with a strong
  !! diagonal decay into that range in single precision, where a factorisation took seven times as
  !! long.
  subroutine smumps_flushed(id)
    type(smumps_struc), intent(inout) :: id

    logical :: gradual

    if (ieee_support_underflow_control(1.0_sp)) then
      call ieee_get_underflow_mode(gradual)
      call ieee_set_underflow_mode(.false.)
      call smumps(id)
      call ieee_set_underflow_mode(gradual)
    else
      call smumps(id)
    end if
  end subroutine smumps_flushed

  subroutine free(self)
    class(solver_mumps_t), intent(inout) :: self

    type(error_t), allocatable :: ignored

    if (associated(self%d)) then
      if (associated(self%d%irn)) deallocate (self%d%irn)
      if (associated(self%d%jcn)) deallocate (self%d%jcn)
      if (associated(self%d%perm_in)) deallocate (self%d%perm_in)
      if (associated(self%d%a)) deallocate (self%d%a)
      call run(self, FINISH, ignored)
      deallocate (self%d)
    end if
    if (associated(self%s)) then
      if (associated(self%s%irn)) deallocate (self%s%irn)
      if (associated(self%s%jcn)) deallocate (self%s%jcn)
      if (associated(self%s%perm_in)) deallocate (self%s%perm_in)
      if (associated(self%s%a)) deallocate (self%s%a)
      call run(self, FINISH, ignored)
      deallocate (self%s)
    end if
    self%info%used_mb = 0.0_wp
    self%margin = FIRST_MARGIN
  end subroutine free

end module solver_mumps
