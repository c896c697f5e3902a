!> Factors of the tangent matrix. They are stored in the first of several ways for which memory
!! suffices: in double precision, in single precision, compressed, or on disk. Exact factors replace
!! approximate ones if they turn out to be needed.
module tangent_factors
  use base_agreement, only: agree
  use base_comm, only: is_root, ranks_here, total
  use base_error, only: error_t, fail, BUG, SYSTEM_ERROR
  use base_kinds, only: wp, i8
  use base_system, only: available_memory_mb, return_memory, seconds_of_both
  use base_text, only: to_text
  use csr, only: block_matrix_t
  use csr_whole, only: gather_pattern
  use csr_extract, only: entries_t, new_entries, gather
  use null_space, only: prove_regular
  use partition_metis, only: elimination_order
  use solver_dense, only: solver_dense_t
  use solver_mumps, only: solver_mumps_t, new_solver_mumps
  use solver_type, only: solver_t
  implicit none
  private
  public :: solve_report_t, factors_t, storage_t, new_factors, take_equations, analyse, &
            use_precision, renew, look_for_motions, be_exact, start_anew, drop, describe_storage, &
            memory_of, find_order

  !> A way to store factors.
  type :: storage_t
    logical :: single = .false.   !! in single precision
    real(wp) :: eps = 0.0_wp      !! relative error of compressed blocks; 0: not compressed
    logical :: on_disk = .false.
  end type storage_t

  !> Exact factors, in memory or on disk.
  type(storage_t), parameter :: EXACT_WAYS(2) = [storage_t(), storage_t(on_disk=.true.)]

  !> Report of one solve.
  type :: solve_report_t
    logical :: factorised = .false.        !! the matrix was factorised in this call
    logical :: converged = .false.         !! the tolerance was met as far as rounding allows
    logical :: singular = .false.          !! there is no solution, and x is zero; see `null`
    integer, allocatable :: null(:)        !! one equation for each free motion; empty: regular
    integer :: iterations = 0              !! solves with the factors, including failed attempts
    integer :: factorisations = 0          !! number of factorisations in this call
    logical :: used_single = .false.       !! the last factors are in single precision
    logical :: used_gmres = .false.
    logical :: gave_up_single = .false.    !! AUTO: double precision from now on
    logical :: signed = .false.            !! `negative` and `determinant` are those of this matrix
    integer :: negative = 0                !! number of negative pivots of the factors in use
    integer :: determinant = 1             !! sign of the determinant of an unsymmetric matrix
    real(wp) :: residual = 0.0_wp          !! |b - A x| / |b|
    !> Wall and processor time [s]. The time of the analysis includes analyses before this solve.
    real(wp) :: seconds_analyse(2) = 0.0_wp, seconds_factor(2) = 0.0_wp, seconds_solve(2) = 0.0_wp
    real(wp) :: memory_mb = 0.0_wp         !! memory held by the factors [MB]
    character(:), allocatable :: storage  !! a sentence, if memory did not suffice for the first way
  end type solve_report_t

  integer, parameter :: SMALL = 24 !! largest number of equations for the dense solver

  type :: factors_t
    type(storage_t), allocatable :: ways(:) !! in the order in which they are tried
    real(wp) :: available_mb = 0.0_wp    !! available memory [MB]; 0: that of the machine
    real(wp) :: estimate_mb = 0.0_wp     !! estimated memory of a factorisation [MB]
    class(solver_t), allocatable :: solver
    integer, allocatable :: eq(:, :)     !! (3, nnode) equation numbers, 0: prescribed
    logical :: valid = .false.           !! the factors exist and are those of a regular matrix
    logical :: exact = .true.            !! the factors are in double precision and not compressed
    real(wp) :: seconds_analyse(2) = 0.0_wp !! wall and processor time not reported yet [s]
    type(entries_t), private :: entries
    integer, allocatable, private :: order(:) !! order of elimination for the current pattern
    logical, private :: analysed = .false.  !! the solver knows the current pattern
    logical, private :: proved = .false.    !! the last matrix that was factorised was regular
    logical, private :: escalated = .false. !! the chosen precision did not suffice
    integer, private :: way = 1 !! way in use: of `ways`, or of EXACT_WAYS if `escalated`
    !> A sentence that has not been reported yet: why a way other than the first is used.
    character(:), allocatable :: note
  end type factors_t

contains

  !> Choose the ways in which the factors may be stored.
  subroutine new_factors(factors, ways, available_mb)
    type(factors_t), intent(out) :: factors
    type(storage_t), intent(in) :: ways(:) !! at least one, in the order in which they are tried
    real(wp), intent(in), optional :: available_mb

    factors%ways = ways
    if (present(available_mb)) factors%available_mb = available_mb
  end subroutine new_factors

  !> Replace the matrix by one with another pattern. Existing factors are kept if the equations are
  !! the same; the new pattern is analysed at the next factorisation.
  subroutine take_equations(factors, a, eq, error)
    type(factors_t), intent(inout) :: factors
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (size(eq, 1) /= 3 .or. size(eq, 2) /= a%nnode) then
      call fail(error, BUG, 'expected equation numbers of 3 dofs at '//to_text(a%nnode) &
                //' nodes, found '//to_text(size(eq, 1))//' at '//to_text(size(eq, 2)))
      return
    end if
    if (factors%valid) then
      factors%valid = size(factors%eq) == size(eq)
      if (factors%valid) factors%valid = all(factors%eq == eq)
    end if
    factors%eq = eq
    factors%analysed = .false.
    if (allocated(factors%order)) deallocate (factors%order)
  end subroutine take_equations

  !> Analyse the pattern of the free dofs for one way of storing the factors after another, until
  !! there is enough memory.
  subroutine analyse(factors, a, error)
    type(factors_t), intent(inout) :: factors
    type(block_matrix_t), intent(in) :: a
    type(error_t), allocatable, intent(out) :: error

    do
      call analyse_way(factors, a, error)
      if (allocated(error)) return
      if (factors%estimate_mb <= memory_mb(factors) .or. is_last(factors)) exit
      call take_next_way(factors)
    end do
  end subroutine analyse

  !> Is there no further way to store the factors?
  pure logical function is_last(factors)
    type(factors_t), intent(in) :: factors

    is_last = factors%way == merge(size(EXACT_WAYS), size(factors%ways), factors%escalated)
  end function is_last

  !> Store the factors in the next way, and note why.
  subroutine take_next_way(factors)
    type(factors_t), intent(inout) :: factors
    real(wp) :: available

    available = memory_mb(factors)
    factors%note = 'a factorisation '//describe_storage(the_way(factors))
    if (factors%estimate_mb > available) then
      factors%note = factors%note//' needs about '//to_text(nint(factors%estimate_mb, i8)) &
                     //' MB, but only '//to_text(nint(available, i8))//' MB are available'
    else
      factors%note = factors%note//' failed, although the ' &
                     //to_text(nint(factors%estimate_mb, i8)) &
                     //' MB that it was estimated to need are available'
    end if
    factors%note = factors%note//'; factors are computed '
    factors%way = factors%way + 1
    factors%note = factors%note//describe_storage(the_way(factors))
    factors%analysed = .false.
  end subroutine take_next_way

  !> The way in which factors are stored now.
  pure type(storage_t) function the_way(factors)
    type(factors_t), intent(in) :: factors

    if (factors%escalated) then
      the_way = EXACT_WAYS(factors%way)
    else
      the_way = factors%ways(factors%way)
    end if
  end function the_way

  !> Description of a way of storage, to follow `factors are computed`.
  pure function describe_storage(way) result(text)
    type(storage_t), intent(in) :: way
    character(:), allocatable :: text

    text = 'in '//trim(merge('single', 'double', way%single))//' precision'
    if (way%eps > 0.0_wp) text = text//' with low-rank blocks'
    if (way%on_disk) text = text//' on disk'
  end function describe_storage

  !> Analyse the pattern of the free dofs for the current way of storing the factors: for a dense
  !! solver if there are only a few equations, otherwise for a sparse solver with the ordering of
  !! METIS.
  subroutine analyse_way(factors, a, error)
    type(factors_t), intent(inout) :: factors
    type(block_matrix_t), intent(in) :: a
    type(error_t), allocatable, intent(out) :: error
    type(solver_mumps_t), allocatable :: mumps
    type(storage_t) :: way
    real(wp) :: start(2)
    logical :: dense

    start = seconds_of_both()
    call drop(factors)
    call new_entries(factors%entries, a, factors%eq, error)
    if (allocated(error)) return
    way = the_way(factors)
    associate (entries => factors%entries)
      dense = entries%neq <= SMALL .and. .not. a%shared
      factors%exact = dense .or. .not. (way%single .or. way%eps > 0.0_wp)
      if (dense) then
        allocate (solver_dense_t :: factors%solver)
        factors%order = [integer ::]
      else
        allocate (mumps)
        call new_solver_mumps(mumps, way%single, way%eps, on_disk=way%on_disk)
        call move_alloc(mumps, factors%solver)
        if (.not. allocated(factors%order)) then
          call find_order(a, factors%eq, factors%order, error)
          if (allocated(error)) return
        end if
      end if
      call factors%solver%analyse(entries%neq, a%symmetric, entries%row, entries%col, &
                                  factors%order, error)
    end associate
    factors%seconds_analyse = factors%seconds_analyse + seconds_of_both() - start
    if (allocated(error)) return
    factors%estimate_mb = factors%solver%info%estimate_mb
    factors%analysed = .true.
  end subroutine analyse_way

  !> Find the order of elimination, which only the first rank needs; it is empty on the other ranks.
  subroutine find_order(a, eq, order, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    integer, allocatable, intent(out) :: order(:)
    type(error_t), allocatable, intent(out) :: error
    type(block_matrix_t) :: whole

    if (.not. a%shared) then
      call elimination_order(a, eq, order, error)
      return
    end if
    call gather_pattern(a, whole, error)
    if (allocated(error)) return
    if (is_root()) call elimination_order(whole, eq, order, error)
    if (.not. allocated(order)) order = [integer ::]
    call agree(error)
  end subroutine find_order

  !> After the analysis, choose the precision of the first way of storing factors; the analysis
  !! is repeated if it was made for the other precision. If memory is too short for the first way,
  !! nothing changes.
  subroutine use_precision(factors, single, a, error)
    type(factors_t), intent(inout) :: factors
    logical, intent(in) :: single
    type(block_matrix_t), intent(in) :: a
    type(error_t), allocatable, intent(out) :: error

    if (factors%way > 1 .or. (factors%ways(1)%single .eqv. single)) return
    factors%ways(1)%single = single
    call analyse(factors, a, error)
  end subroutine use_precision

  !> Factorise the matrix. If the matrix seems to be singular according to approximate factors,
  !! exact factors decide.
  subroutine renew(factors, a, report, error)
    type(factors_t), intent(inout) :: factors
    type(block_matrix_t), intent(in) :: a
    type(solve_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: values(:)
    integer :: stat

    factors%valid = .false.
    do
      if (.not. factors%analysed) call analyse(factors, a, error)
      if (allocated(error)) return
      allocate (values(size(factors%entries%row)), stat=stat)
      if (stat /= 0) then
        call fail(error, SYSTEM_ERROR, 'not enough memory for the values of the tangent matrix')
      end if
      call agree(error)
      if (allocated(error)) return
      call gather(factors%entries, a, values)
      call factors%solver%factorise(values, memory_mb(factors), error)
      deallocate (values)
      if (allocated(error)) then
        if (error%code /= SYSTEM_ERROR .or. is_last(factors)) return
        call take_next_way(factors) ! the estimate was too low, or other programs took the memory
        deallocate (error)
        cycle
      end if
      report%factorised = .true.
      report%factorisations = report%factorisations + 1
      report%null = factors%solver%info%null
      if (.not. factors%proved .or. size(report%null) > 0) then
        call look_for_motions(factors, a, report%null, error)
        if (allocated(error)) return
      end if
      if (size(report%null) == 0 .or. factors%exact) exit
      call be_exact(factors)
    end do
    factors%valid = size(report%null) == 0
    factors%proved = factors%valid
  end subroutine renew

  !> Memory of a factorisation whose factors are stored in a given way, as estimated by an analysis
  !! [MB].
  subroutine memory_of(factors, a, way, mb, error)
    type(factors_t), intent(in) :: factors !! with an analysed pattern
    type(block_matrix_t), intent(in) :: a
    type(storage_t), intent(in) :: way
    real(wp), intent(out) :: mb
    type(error_t), allocatable, intent(out) :: error
    type(factors_t) :: trial

    mb = 0.0_wp
    call new_factors(trial, [way])
    trial%eq = factors%eq
    trial%order = factors%order
    call analyse_way(trial, a, error)
    mb = trial%estimate_mb
    call drop(trial)
  end subroutine memory_of

  !> Available memory of all machines [MB].
  real(wp) function memory_mb(factors)
    type(factors_t), intent(in) :: factors

    memory_mb = factors%available_mb
    if (memory_mb > 0.0_wp) return
    memory_mb = memory_of_all()
    if (memory_mb + factors%solver%info%used_mb >= factors%estimate_mb) return
    call return_memory() ! memory that earlier solvers have freed
    memory_mb = memory_of_all()
  end function memory_mb

  !> Memory that is available now on all machines [MB]; each rank adds its share of the memory of
  !! its machine.
  real(wp) function memory_of_all()
    real(wp), parameter :: MEBIBYTE = 1.048576_wp

    memory_of_all = min(available_memory_mb(), 1e12_wp)*MEBIBYTE/ranks_here()
    call total(memory_of_all)
  end function memory_of_all

  !> Look for free motions of the matrix that was just factorised.
  subroutine look_for_motions(factors, a, null, error)
    type(factors_t), intent(inout) :: factors
    type(block_matrix_t), intent(in) :: a
    !> Equations of free motions: on entry those that the solver found, on exit all of them if the
    !! factors are exact.
    integer, allocatable, intent(inout) :: null(:)
    type(error_t), allocatable, intent(out) :: error

    call prove_regular(a, factors%eq, factors%solver, factors%exact, null, error)
  end subroutine look_for_motions

  !> Use factors in double precision, without compression, from the next factorisation on.
  subroutine be_exact(factors)
    type(factors_t), intent(inout) :: factors

    factors%escalated = .true.
    factors%way = 1
    factors%analysed = .false.
  end subroutine be_exact

  !> Forget what is known about earlier matrices.
  subroutine start_anew(factors)
    type(factors_t), intent(inout) :: factors

    factors%proved = .false.
    if (factors%escalated) factors%analysed = .false.
    if (factors%escalated) factors%way = 1
    factors%escalated = .false.
  end subroutine start_anew

  !> Release the memory of the factors.
  subroutine drop(factors)
    type(factors_t), intent(inout) :: factors

    factors%valid = .false.
    factors%analysed = .false.
    factors%entries = entries_t()
    if (.not. allocated(factors%solver)) return
    call factors%solver%free()
    deallocate (factors%solver)
  end subroutine drop

end module tangent_factors
