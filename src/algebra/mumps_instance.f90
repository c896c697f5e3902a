!> One instance of the library MUMPS in double or single precision, with its options and messages.
!!
!! No other file uses the data structures of MUMPS. All arguments are in double precision. The
!! numbers of options and results are those in the users' guide of version 5.5.
module mumps_instance
  use, intrinsic :: ieee_arithmetic, only: ieee_get_underflow_mode, ieee_set_underflow_mode
  use, intrinsic :: ieee_arithmetic, only: ieee_support_underflow_control
  use base_comm, only: communicator, is_root, largest, rank_count, share
  use base_error, only: error_t, fail, BUG, NO_SOLUTION, SYSTEM_ERROR
  use base_kinds, only: wp, i8
  use base_text, only: to_text
  implicit none
  private
  public :: mumps_t, start, runs, give_options, give_pattern, give_values, give_margin, &
            narrow_panels, run, solve_with, null_pivots, finish, check_memory

  include 'dmumps_struc.h'
  include 'smumps_struc.h'

  integer, parameter, public :: ORDER_AMD = 0, ORDER_GIVEN = 1, ORDER_PORD = 4 !! ICNTL(7)
  integer, parameter, public :: FIRST_MARGIN = 20 !! work space beyond the estimate [%]
  integer, parameter, public :: ANALYSE_JOB = 1, FACTORISE_JOB = 2 !! JOB
  integer, parameter :: INITIALISE = -1, FINISH_JOB = -2, SOLVE_JOB = 3
  integer, parameter :: sp = kind(1.0)        !! kind of the reals of SMUMPS
  integer, parameter :: SYMMETRIC_GENERAL = 2, UNSYMMETRIC = 0 !! SYM
  !> Low-rank blocks are formed in the order of elimination. Otherwise MUMPS 5.5 would pass an
  !! uninitialised graph to SCOTCH 7, which sometimes crashes.
  integer, parameter :: CLUSTERING = 482, PLAIN = 3 !! an index and a value of KEEP
  !> A pivot of the scaled matrix below this limit is taken as zero; it belongs to an equation
  !! without stiffness. The pivots of free bodies are larger; see null_space.
  real(wp), parameter :: NULL_PIVOT = 1e-18_wp, NULL_PIVOT_SINGLE = 1e-12_wp

  character(*), parameter :: COARSER = 'use a coarser mesh or a machine with more memory'
  character(*), parameter :: HALF = 'FACTor,SINGle needs about half as much memory; if that is ' &
                             //'still too much, '//COARSER

  !> An instance. Between start and finish, either d or s is associated.
  type :: mumps_t
    type(dmumps_struc), pointer, private :: d => null()
    type(smumps_struc), pointer, private :: s => null()
    integer, private :: neq = 0
    real(wp), private :: scale = 1.0_wp !! divides the values of a single-precision matrix
    integer :: infog(80) = 0            !! INFOG of the last call
    real(wp) :: rinfog(40) = 0.0_wp
  end type mumps_t

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

  !> Start an instance.
  subroutine start(m, single, symmetric, error)
    type(mumps_t), intent(out) :: m
    logical, intent(in) :: single, symmetric
    type(error_t), allocatable, intent(out) :: error
    integer :: matrix_type

    matrix_type = merge(SYMMETRIC_GENERAL, UNSYMMETRIC, symmetric)
    if (single) then
      allocate (m%s)
      m%s%comm = communicator()
      m%s%par = 1
      m%s%sym = matrix_type
    else
      allocate (m%d)
      m%d%comm = communicator()
      m%d%par = 1
      m%d%sym = matrix_type
    end if
    call run(m, INITIALISE, error)
  end subroutine start

  !> Has the instance been started and not yet finished?
  pure logical function runs(m)
    type(mumps_t), intent(in) :: m

    runs = associated(m%d) .or. associated(m%s)
  end function runs

  !> Set the options of the analysis and of the factorisation, before the analysis.
  subroutine give_options(m, symmetric, low_rank, ordering, on_disk)
    type(mumps_t), intent(inout) :: m
    logical, intent(in) :: symmetric
    real(wp), intent(in) :: low_rank !! relative error of compressed blocks; 0: none
    integer, intent(in) :: ordering
    logical, intent(in) :: on_disk   !! store the factors in files, in MUMPS_OOC_TMPDIR

    if (associated(m%s)) then
      call set_controls(m%s%icntl, symmetric, low_rank > 0.0_wp, ordering)
      call set_fronts(m%s%keep)
      m%s%icntl(22) = merge(1, 0, on_disk)
      m%s%cntl(3) = real(NULL_PIVOT_SINGLE, sp)
      m%s%cntl(7) = real(low_rank, sp)
      m%s%keep(CLUSTERING) = PLAIN
    else
      call set_controls(m%d%icntl, symmetric, low_rank > 0.0_wp, ordering)
      call set_fronts(m%d%keep)
      m%d%icntl(22) = merge(1, 0, on_disk)
      m%d%cntl(3) = NULL_PIVOT
      m%d%cntl(7) = low_rank
      m%d%keep(CLUSTERING) = PLAIN
    end if
  end subroutine give_options

  !> Set the options in ICNTL, before the analysis.
  subroutine set_controls(icntl, symmetric, compressed, ordering)
    integer, intent(inout) :: icntl(:)
    logical, intent(in) :: symmetric
    logical, intent(in) :: compressed  !! low-rank blocks are used
    integer, intent(in) :: ordering

    icntl(1:4) = [-1, -1, -1, 0] ! no output
    icntl(6) = 0   ! no permutation: it would need values in the analysis
    icntl(7) = ordering
    icntl(12) = 1  ! no other symmetric preprocessing
    if (rank_count() > 1) icntl(18) = 3 ! each rank gives its entries
    icntl(13) = 1  ! treat the root node like the others, for exact inertia
    icntl(14) = FIRST_MARGIN
    icntl(24) = 1  ! detect null pivots
    icntl(28) = 1  ! sequential analysis
    if (.not. symmetric) icntl(33) = 1 ! determinant
    if (compressed) icntl(35) = 2
  end subroutine set_controls

  !> Before the analysis, make the fronts smaller than by default: nodes of the elimination tree are
  !! merged only up to a smaller number of pivots. For cubes with 26 and 82 thousand equations, this
  !! saved 9 and 7 % of the operations and of the entries. KEEP is not described in the guide; the
  !! entries used here are set in dini_defaults.F of MUMPS, since version 5.0.
  pure subroutine set_fronts(keep)
    integer, intent(inout) :: keep(:)

    keep(1) = 2
  end subroutine set_fronts

  !> Copy the pattern and allocate room for its values. With several ranks, the pattern is that of
  !! the entries of this rank; only the first rank gives an order.
  subroutine give_pattern(m, neq, row, col, order, error)
    type(mumps_t), intent(inout) :: m
    integer, intent(in) :: neq
    integer, intent(in) :: row(:), col(:) !! (nnz)
    integer, intent(in) :: order(:)       !! (neq) or empty
    type(error_t), allocatable, intent(out) :: error
    integer :: stat

    m%neq = neq
    if (associated(m%s) .and. rank_count() > 1) then
      call copy(m%s%n, m%s%nnz_loc, m%s%irn_loc, m%s%jcn_loc, m%s%perm_in)
      if (stat == 0) allocate (m%s%a_loc(size(row)), stat=stat)
    else if (associated(m%s)) then
      call copy(m%s%n, m%s%nnz, m%s%irn, m%s%jcn, m%s%perm_in)
      if (stat == 0) allocate (m%s%a(size(row)), stat=stat)
    else if (rank_count() > 1) then
      call copy(m%d%n, m%d%nnz_loc, m%d%irn_loc, m%d%jcn_loc, m%d%perm_in)
      if (stat == 0) allocate (m%d%a_loc(size(row)), stat=stat)
    else
      call copy(m%d%n, m%d%nnz, m%d%irn, m%d%jcn, m%d%perm_in)
      if (stat == 0) allocate (m%d%a(size(row)), stat=stat)
    end if
    if (stat /= 0) call fail(error, SYSTEM_ERROR, 'not enough memory for the tangent matrix of ' &
                             //to_text(neq)//' equations', hint=COARSER)

  contains

    subroutine copy(n, nnz, irn, jcn, perm_in)
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
    end subroutine copy

  end subroutine give_pattern

  !> Copy the values of the entries in the pattern.
  subroutine give_values(m, values)
    type(mumps_t), intent(inout) :: m
    real(wp), intent(in) :: values(:) !! (nnz)

    if (associated(m%s)) then
      m%scale = power_of_two(largest(maxval(abs(values))))
      if (associated(m%s%a)) m%s%a = real(values/m%scale, sp)
      if (associated(m%s%a_loc)) m%s%a_loc = real(values/m%scale, sp)
    else
      if (associated(m%d%a)) m%d%a = values
      if (associated(m%d%a_loc)) m%d%a_loc = values
    end if
  end subroutine give_values

  !> Power of two by which values are divided, so that the largest one becomes about 1. It is 1 if
  !! the largest value is zero.
  pure real(wp) function power_of_two(largest)
    real(wp), intent(in) :: largest

    power_of_two = 1.0_wp
    if (largest > 0.0_wp) power_of_two = 2.0_wp**exponent(largest)
  end function power_of_two

  !> Set the work space of the factorisation in excess of the estimate [%].
  subroutine give_margin(m, margin)
    type(mumps_t), intent(inout) :: m
    integer, intent(in) :: margin

    if (associated(m%s)) m%s%icntl(14) = margin
    if (associated(m%d)) m%d%icntl(14) = margin
  end subroutine give_margin

  !> Set the width of panels, between analysis and factorisation.
  subroutine narrow_panels(m)
    type(mumps_t), intent(inout) :: m

    if (associated(m%s)) call set_panels(m%s%keep)
    if (associated(m%d)) call set_panels(m%d%keep)
  end subroutine narrow_panels

  !> After the analysis of a symmetric matrix, make the inner panels narrower than by default (16
  !! and 32 columns). Inside a panel, MUMPS updates column by column, which took a fifth of the
  !! time; everything else is done by dgemm. Narrower panels saved 15 % of the time of a
  !! factorisation with 26 thousand equations.
  pure subroutine set_panels(keep)
    integer, intent(inout) :: keep(:)

    keep(5:6) = 8
  end subroutine set_panels

  !> Call the library once.
  subroutine run(m, job, error)
    type(mumps_t), intent(inout) :: m
    integer, intent(in) :: job
    type(error_t), allocatable, intent(out) :: error
    logical :: flush, gradual

    if (associated(m%s)) then
      m%s%job = job
      ! Numbers below the normal range are flushed to zero during this call. In single precision,
      ! the factors of a matrix with a dominant diagonal decay into that range, and without
      ! flushing, a factorisation took seven times as long.
      flush = ieee_support_underflow_control(1.0_sp)
      if (flush) then
        call ieee_get_underflow_mode(gradual)
        call ieee_set_underflow_mode(.false.)
      end if
      call smumps(m%s)
      if (flush) call ieee_set_underflow_mode(gradual)
      m%infog = m%s%infog
      m%rinfog = real(m%s%rinfog, wp)
    else
      m%d%job = job
      call dmumps(m%d)
      m%infog = m%d%infog
      m%rinfog = m%d%rinfog
    end if
    if (m%infog(1) < 0) call describe_failure(m%infog(1), m%infog(2), m%neq, &
                                              associated(m%s), error)
  end subroutine run

  !> Solve in place: the solutions replace the right-hand sides. All ranks have the same right-hand
  !! sides and get the same solutions; MUMPS works with those of the first rank.
  subroutine solve_with(m, x, error)
    type(mumps_t), intent(inout) :: m
    real(wp), intent(inout) :: x(:, :) !! (neq, nrhs)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: list(:)
    real(wp) :: factor

    if (associated(m%s)) then
      factor = power_of_two(maxval(abs(x)))
      allocate (m%s%rhs(size(x)))
      m%s%rhs = real(reshape(x, [size(x)])/factor, sp)
      m%s%nrhs = size(x, 2)
      m%s%lrhs = m%neq
      call run(m, SOLVE_JOB, error)
      list = real(m%s%rhs, wp)
      call share(list, 1)
      x = reshape(list, shape(x))*(factor/m%scale)
      deallocate (m%s%rhs)
    else
      allocate (m%d%rhs(size(x)))
      m%d%rhs = reshape(x, [size(x)])
      m%d%nrhs = size(x, 2)
      m%d%lrhs = m%neq
      call run(m, SOLVE_JOB, error)
      call share(m%d%rhs, 1)
      x = reshape(m%d%rhs, shape(x))
      deallocate (m%d%rhs)
    end if
  end subroutine solve_with

  !> The equations that had zero pivots in the last factorisation.
  function null_pivots(m) result(list)
    type(mumps_t), intent(in) :: m
    integer, allocatable :: list(:)

    allocate (list(m%infog(28)), source=0)
    if (size(list) == 0) return
    if (is_root()) then ! MUMPS gives the list to the first rank only
      if (associated(m%s)) list = m%s%pivnul_list(:size(list))
      if (associated(m%d)) list = m%d%pivnul_list(:size(list))
    end if
    call share(list, 1)
  end function null_pivots

  !> Finish the instance and release its memory.
  subroutine finish(m)
    type(mumps_t), intent(inout) :: m
    type(error_t), allocatable :: ignored

    if (associated(m%d)) then
      call drop_pattern(m%d%irn, m%d%jcn, m%d%perm_in)
      call drop_pattern(m%d%irn_loc, m%d%jcn_loc, m%d%perm_in)
      if (associated(m%d%a)) deallocate (m%d%a)
      if (associated(m%d%a_loc)) deallocate (m%d%a_loc)
      call run(m, FINISH_JOB, ignored)
      deallocate (m%d)
    else if (associated(m%s)) then
      call drop_pattern(m%s%irn, m%s%jcn, m%s%perm_in)
      call drop_pattern(m%s%irn_loc, m%s%jcn_loc, m%s%perm_in)
      if (associated(m%s%a)) deallocate (m%s%a)
      if (associated(m%s%a_loc)) deallocate (m%s%a_loc)
      call run(m, FINISH_JOB, ignored)
      deallocate (m%s)
    end if

  contains

    subroutine drop_pattern(irn, jcn, perm_in)
      integer, pointer, intent(inout) :: irn(:), jcn(:), perm_in(:)

      if (associated(irn)) deallocate (irn)
      if (associated(jcn)) deallocate (jcn)
      if (associated(perm_in)) deallocate (perm_in)
    end subroutine drop_pattern

  end subroutine finish

  !> Reject a factorisation for which there is not enough memory, because otherwise the computer
  !! would start to swap.
  subroutine check_memory(need_mb, available_mb, neq, single, error)
    real(wp), intent(in) :: need_mb, available_mb
    integer, intent(in) :: neq
    logical, intent(in) :: single !! the factors are in single precision
    type(error_t), allocatable, intent(out) :: error

    if (need_mb <= available_mb) return
    call fail(error, SYSTEM_ERROR, 'the factorisation of '//to_text(neq) &
              //' equations needs about '//to_text(nint(need_mb, i8))//' MB of memory, but only ' &
              //to_text(nint(available_mb, i8))//' MB are available')
    error%hint = HALF
    if (single) error%hint = COARSER
  end subroutine check_memory

  !> Make the error message for INFOG(1) and INFOG(2).
  subroutine describe_failure(code, detail, neq, single, error)
    integer, intent(in) :: code   !! INFOG(1) < 0
    integer, intent(in) :: detail !! INFOG(2)
    integer, intent(in) :: neq    !! number of equations
    logical, intent(in) :: single !! the factors are in single precision
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: less_memory

    less_memory = HALF
    if (single) less_memory = COARSER
    select case (code)
    case (-6)
      call fail(error, NO_SOLUTION, 'the tangent is singular: the pattern of its '//to_text(neq) &
                //' equations has only rank '//to_text(detail), hint='look for nodes without ' &
                //'stiffness or support')
    case (-10)
      call fail(error, NO_SOLUTION, 'the tangent is singular', &
                hint='look for bodies that can move freely and for missing supports')
    case (-5, -7)
      call fail(error, SYSTEM_ERROR, 'not enough memory for the analysis of '//to_text(neq) &
                //' equations (no room for '//amount(detail)//' more numbers)', hint=COARSER)
    case (-13)
      call fail(error, SYSTEM_ERROR, 'not enough memory for the factorisation of '//to_text(neq) &
                //' equations (no room for '//amount(detail)//' more numbers)', hint=less_memory)
    case (-8, -9, -11, -14, -15, -19)
      call fail(error, SYSTEM_ERROR, 'pivoting needs much more work space than estimated (' &
                //'room for '//amount(detail)//' more numbers)', &
                hint='the tangent may be close to singular; '//less_memory)
    case (-17, -20)
      call fail(error, SYSTEM_ERROR, 'a message buffer of MUMPS is too small')
    case (-51, -52)
      call fail(error, SYSTEM_ERROR, to_text(neq) &
                //' equations are too many for the 32-bit integers of MUMPS', &
                hint='use a coarser mesh')
    case (-90)
      call fail(error, SYSTEM_ERROR, 'MUMPS could not write or read its factors on disk', &
                hint='the folder that the environment variable MUMPS_OOC_TMPDIR names must ' &
                //'exist and have enough space')
    case (-2, -3, -4, -16, -40:-21, -800)
      call fail(error, BUG, 'MUMPS rejected its input with code '//to_text(code)//', detail ' &
                //to_text(detail))
    case default
      call fail(error, SYSTEM_ERROR, 'MUMPS failed with code '//to_text(code)//', detail ' &
                //to_text(detail), &
                hint='the users'' guide of MUMPS explains the code under INFOG(1)')
    end select
  end subroutine describe_failure

  !> Text of a number of reals or integers, which MUMPS gives in millions with a negative sign if it
  !! is large.
  pure function amount(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text

    text = to_text(abs(n))
    if (n < 0) text = text//' million'
  end function amount

end module mumps_instance
