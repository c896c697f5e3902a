!> Times the linear solver on the 27-point stencil of an elastic bar of n x n x 2n trilinear
!! elements, clamped at one end and pushed at the other: orders of elimination, precision, and what
!! reuse saves over a row of matrices.
!!
!! Usage: bench_solver [n [threads]]
program bench_solver
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_system, only: cpu_seconds, wall_seconds
  use csr, only: block_matrix_t, clique_t, new_pattern, element_map, add_element, set_zero, multiply
  use csr_extract, only: entries_t, new_entries, gather
  use partition_metis, only: elimination_order
  use solver_mumps, only: solver_mumps_t, new_solver_mumps, ORDER_AMD, ORDER_PORD
 use linear_system, only: linear_system_t, solve_report_t, new_linear_system, FULL, REUSE, SINGLE, &
                           LOWRANK
  use blas_threads, only: set_threads, blas_kernel
  implicit none

  integer, parameter :: NMATRIX = 15 !! as many as Newton iterations in section 4 of the paper
  type(error_t), allocatable :: error
  type(block_matrix_t) :: a
  type(clique_t) :: mesh(1)
  integer, allocatable :: map(:, :, :), eq(:, :)
  real(wp) :: ke(24, 24)
  integer :: n, threads, neq

  n = argument(1, 16)
  threads = argument(2, 1)
  call set_threads(threads, error)
  if (allocated(error)) error stop 'no memory for the linear algebra'
  call make_mesh(n)
  call element_stiffness(0.3_wp, ke)
  print '(a, i0, a, i0, a, i0, 2a)', 'bar of ', size(mesh(1)%conn, 2), ' elements, ', neq, &
    ' equations, ', threads, ' thread(s), BLAS kernel ', blas_kernel()
  call time_pattern()
  print '(/, a26, 7a9)', 'direct solver', 'order s', 'analyse', 'factor', 'GFLOP/s', 'solve', &
    'entries', 'MB'
  call time_direct('double, METIS', .false., 0.0_wp, .true., ORDER_AMD)
  call time_direct('double, AMD', .false., 0.0_wp, .false., ORDER_AMD)
  call time_direct('double, PORD', .false., 0.0_wp, .false., ORDER_PORD)
  call time_direct('single, METIS', .true., 0.0_wp, .true., ORDER_AMD)
  call time_direct('low rank 1e-6, METIS', .false., 1e-6_wp, .true., ORDER_AMD)
  print '(/, i0, a)', NMATRIX, ' matrices, each stiffened a little more, solved to 1e-10'
  print '(a26, a10, 2a12, a14)', 'way', 's', 'factorised', 'iterations', 'difference'
  call time_ways()

contains

  integer function argument(i, default)
    integer, intent(in) :: i, default

    character(12) :: text
    integer :: status

    argument = default
    if (command_argument_count() < i) return
    call get_command_argument(i, text)
    read (text, *, iostat=status) argument
    if (status /= 0 .or. argument < 1) error stop 'usage: bench_solver [n [threads]]'
  end function argument

  !> Nodes numbered as a mesh generator would, bottom layer clamped.
  subroutine make_mesh(n)
    integer, intent(in) :: n

    integer :: i, j, k, e, layer

    layer = (n + 1)**2
    allocate (mesh(1)%conn(8, 2*n**3), eq(3, layer*(2*n + 1)), map(8, 8, 2*n**3))
    e = 0
    do k = 0, 2*n - 1
      do j = 0, n - 1
        do i = 1, n
          e = e + 1
          mesh(1)%conn(:4, e) = k*layer + j*(n + 1) + i + [0, 1, n + 2, n + 1]
          mesh(1)%conn(5:, e) = mesh(1)%conn(:4, e) + layer
        end do
      end do
    end do
    neq = 0
    do i = 1, size(eq, 2)
      eq(:, i) = 0
      if (i <= layer) cycle
      eq(:, i) = neq + [1, 2, 3]
      neq = neq + 3
    end do
  end subroutine make_mesh

  !> Stiffness of a unit cube, E = 1, 2x2x2 points.
  subroutine element_stiffness(nu, ke)
    real(wp), intent(in) :: nu
    real(wp), intent(out) :: ke(24, 24)

    real(wp), parameter :: corner(3, 8) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
                                             -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1], [3, 8])*1.0_wp
    real(wp) :: g(3, 8), lame, mu
    integer :: q, a, b, i, j

    lame = nu/((1 + nu)*(1 - 2*nu))
    mu = 0.5_wp/(1 + nu)
    ke = 0.0_wp
    do q = 1, 8
      do a = 1, 8
        associate (s => 1 + corner(:, a)*corner(:, q)/sqrt(3.0_wp))
          g(:, a) = 0.25_wp*corner(:, a)*[s(2)*s(3), s(1)*s(3), s(1)*s(2)]
        end associate
      end do
      do b = 1, 8
        do a = 1, 8
          do j = 1, 3
            do i = 1, 3
              ke(3*a - 3 + i, 3*b - 3 + j) = ke(3*a - 3 + i, 3*b - 3 + j) &
                                             + (lame*g(i, a)*g(j, b) + mu*g(j, a)*g(i, b))/8
              if (i == j) ke(3*a - 3 + i, 3*b - 3 + j) = ke(3*a - 3 + i, 3*b - 3 + j) &
                                                         + mu*dot_product(g(:, a), g(:, b))/8
            end do
          end do
        end do
      end do
    end do
  end subroutine element_stiffness

  !> The matrix number `step`: a smooth field of moduli that moves away from one.
  subroutine assemble(step)
    integer, intent(in) :: step

    integer :: e

    call set_zero(a)
    do e = 1, size(map, 3)
      call add_element(a, map(:, :, e), ke*(1 + 0.02_wp*step*sin(1e-3_wp*e)**2))
    end do
  end subroutine assemble

  subroutine time_pattern()
    type(error_t), allocatable :: error
    real(wp), allocatable :: x(:, :), y(:, :)
    real(wp) :: t0, t1, t2, t3, t4

    t0 = seconds()
    call new_pattern(a, size(eq, 2), mesh, .true., error)
    t1 = seconds()
    call element_map(a, mesh(1)%conn, map)
    t2 = seconds()
    call assemble(0)
    t3 = seconds()
    allocate (x(3, a%nnode), y(3, a%nnode))
    x = 1.0_wp
    call multiply(a, x, y)
    t4 = seconds()
    print '(4(a, f0.4), a)', 'pattern ', t1 - t0, ' s, maps ', t2 - t1, ' s, scatter ', &
      (t3 - t2)*1e6_wp/size(map, 3), ' us an element, product ', t4 - t3, ' s'
  end subroutine time_pattern

  !> One factorisation and one solution.
  subroutine time_direct(name, single_precision, eps, metis, ordering)
    character(*), intent(in) :: name
    logical, intent(in) :: single_precision, metis
    real(wp), intent(in) :: eps
    integer, intent(in) :: ordering

    type(solver_mumps_t) :: solver
    type(entries_t) :: entries
    type(error_t), allocatable :: error
    integer, allocatable :: order(:)
    real(wp), allocatable :: values(:), x(:, :)
    real(wp) :: t(5)

    call new_entries(entries, a, eq, error)
    allocate (values(size(entries%row)), x(neq, 1))
    call gather(entries, a, values)
    x = 1.0_wp
    t(1) = seconds()
    order = [integer ::]
    if (metis) call elimination_order(a, eq, order, error)
    t(2) = seconds()
    call new_solver_mumps(solver, single_precision, eps, ordering)
    call solver%analyse(neq, .true., entries%row, entries%col, order, error)
    t(3) = seconds()
    if (.not. allocated(error)) call solver%factorise(values, 0.0_wp, error)
    t(4) = seconds()
    if (.not. allocated(error)) call solver%solve(x, error)
    t(5) = seconds()
    if (allocated(error)) then
      print '(4a)', name, ': ', error%message
    else
      associate (info => solver%info, seconds_factor => t(4) - t(3))
        print '(a26, 5f9.3, es9.1, f9.1)', name, t(2:3) - t(1:2), seconds_factor, &
          info%flops/seconds_factor*1e-9_wp, t(5) - t(4), info%entries, info%used_mb
      end associate
    end if
    call solver%free()
  end subroutine time_direct

  !> The same row of systems in every mode.
  subroutine time_ways()
    real(wp), allocatable :: answer(:, :)

    allocate (answer(neq, NMATRIX))
    call time_way('full', FULL, 0.0_wp, answer)
    call time_way('reuse', REUSE, 0.0_wp, answer)
    call time_way('single', SINGLE, 0.0_wp, answer)
    call time_way('low rank 1e-4', LOWRANK, 1e-4_wp, answer)
  end subroutine time_ways

  subroutine time_way(name, mode, eps, answer)
    character(*), intent(in) :: name
    integer, intent(in) :: mode
    real(wp), intent(in) :: eps
    real(wp), intent(inout) :: answer(:, :)

    type(linear_system_t) :: ls
    type(solve_report_t) :: report
    type(error_t), allocatable :: error
    real(wp), allocatable :: x(:), rhs(:)
    real(wp) :: total, difference, t0
    integer :: step, factorisations, iterations

    allocate (x(neq), rhs(neq))
    rhs = 0.0_wp
    rhs(neq:neq - 3*(n + 1)**2 + 1:-3) = -1.0_wp
    difference = 0.0_wp; factorisations = 0; iterations = 0
    t0 = seconds()
    call new_linear_system(ls, a, eq, mode, eps, error)
    total = seconds() - t0
    do step = 1, NMATRIX
      call assemble(step)
      t0 = seconds()
      call ls%solve(a, rhs, x, 1e-10_wp, report, error)
      total = total + seconds() - t0
      if (allocated(error)) exit
      factorisations = factorisations + report%factorisations
      iterations = iterations + report%iterations
      if (mode == FULL) answer(:, step) = x
      difference = max(difference, norm2(x - answer(:, step))/norm2(x))
    end do
    call ls%free()
    if (allocated(error)) then
      print '(4a)', name, ': ', error%message
    else
      print '(a26, f10.2, 2i12, es14.1)', name, total, factorisations, iterations, difference
    end if
  end subroutine time_way

  !> Processor time where one thread works, so that other work on the machine does little; wall
  !! time where more do.
  real(wp) function seconds()
    seconds = wall_seconds()
    if (threads == 1) seconds = cpu_seconds()
  end function seconds

end program bench_solver
