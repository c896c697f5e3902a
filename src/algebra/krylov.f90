!> Krylov methods that use a factorisation as the preconditioner. The factors may be those of an
!! older matrix, in single precision, or compressed. With exact factors of the same matrix, the
!! methods amount to iterative refinement.
module krylov
  use base_error, only: error_t
  use base_kinds, only: wp
  use csr, only: block_matrix_t, multiply_free, row_sums
  use factor_correction, only: correction_t, add_correction
  use solver_type, only: solver_t
  implicit none
  private
  public :: krylov_report_t, conjugate_gradients, gmres

  !> Result of an iteration.
  type :: krylov_report_t
    logical :: converged = .false.
    logical :: rounds = .false.        !! the residual is not larger than rounding alone can leave
    logical :: indefinite = .false.    !! conjugate gradients met a direction of negative curvature
    logical :: slow = .false.          !! abandoned, because convergence was too slow
    integer :: iterations = 0          !! number of applications of the preconditioner
    real(wp) :: residual = 0.0_wp      !! |b - A x| / |b|, computed rather than estimated
  end type krylov_report_t

  !> Largest number of cycles of conjugate gradients; each cycle starts from the true residual.
  integer, parameter :: MOST_CYCLES = 5
  real(wp), parameter :: SLACK = 0.5_wp !! a cycle must at least halve the residual

contains

  !> Solve by preconditioned conjugate gradients for a symmetric matrix; x starts at zero.
  !!
  !! Each search direction is explicitly made conjugate to the previous one (the flexible form), so
  !! that the preconditioner may be slightly unsymmetric because of rounding.
  !! Source: Golub and Ye 1999 [bib: golub1999]
  subroutine conjugate_gradients(a, eq, solver, b, x, limit, tolerance, report, error, hurries)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)               !! (3, nnode) equation numbers, 0: prescribed
    class(solver_t), intent(inout) :: solver      !! preconditioner, factorised
    real(wp), intent(in) :: b(:)                  !! (neq), not zero
    real(wp), intent(out) :: x(:)                 !! (neq)
    integer, intent(in) :: limit                  !! largest number of iterations
    real(wp), intent(in) :: tolerance             !! tolerance of |b - A x| / |b|
    type(krylov_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: hurries !! give up early if the limit will not suffice
    real(wp), allocatable :: r(:), z(:, :), p(:), q(:), xn(:, :), yn(:, :)
    real(wp) :: rz, pq, alpha, goal, before
    integer :: cycle_number
    logical :: exhausted

    allocate (r(size(b)), z(size(b), 1), p(size(b)), q(size(b)), xn(3, a%nnode), yn(3, a%nnode))
    x = 0.0_wp
    r = b
    goal = tolerance*norm2(b)
    do cycle_number = 1, MOST_CYCLES
      before = norm2(r)
      p = 0.0_wp
      q = 0.0_wp
      pq = 1.0_wp
      do while (norm2(r) > goal .and. report%iterations < limit)
        z(:, 1) = r
        call solver%solve(z, error)
        if (allocated(error)) return
        report%iterations = report%iterations + 1
        rz = dot_product(r, z(:, 1))
        p = z(:, 1) - (dot_product(z(:, 1), q)/pq)*p
        call multiply_free(a, eq, p, q, xn, yn)
        pq = dot_product(p, q)
        report%indefinite = .not. (pq > 0.0_wp .and. rz > 0.0_wp) ! true also for a NaN
        if (report%indefinite) exit
        alpha = dot_product(p, r)/pq
        x = x + alpha*p
        r = r - alpha*q
        report%slow = is_slow(norm2(r)/norm2(b), tolerance, report%iterations, limit, hurries)
        if (report%slow) exit
      end do
      call true_residual(a, eq, b, x, r, xn, yn)
      exhausted = report%iterations >= limit .or. report%indefinite .or. report%slow
      if (stops(a, eq, b, x, r, goal, before, exhausted, report)) return
    end do
  end subroutine conjugate_gradients

  !> Solve by restarted GMRES with the preconditioner on the right; x starts at zero. The
  !! preconditioned vectors are stored (the flexible form), which saves one solve in each cycle.
  !! Source: Saad 1993 [bib: saad1993]
  subroutine gmres(a, eq, solver, correction, b, x, limit, tolerance, report, error, hurries)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    class(solver_t), intent(inout) :: solver
    type(correction_t), intent(inout) :: correction !! correction of the factors, used if it acts
    real(wp), intent(in) :: b(:)
    real(wp), intent(out) :: x(:)
    integer, intent(in) :: limit
    real(wp), intent(in) :: tolerance
    type(krylov_report_t), intent(out) :: report
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: hurries
    integer, parameter :: RESTART = 30
    real(wp), allocatable :: v(:, :), z(:, :), r(:), xn(:, :), yn(:, :)
    real(wp) :: h(RESTART + 1, RESTART), rotation(2, RESTART), g(RESTART + 1), y(RESTART)
    real(wp) :: goal, before
    integer :: i, j, m
    logical :: exhausted

    m = min(RESTART, limit, size(b))
    allocate (v(size(b), m + 1), z(size(b), m), r(size(b)), xn(3, a%nnode), yn(3, a%nnode))
    x = 0.0_wp
    r = b
    goal = tolerance*norm2(b)
    do
      before = norm2(r)
      v(:, 1) = r/before
      g = 0.0_wp
      g(1) = before
      do j = 1, m
        z(:, j) = v(:, j)
        call solver%solve(z(:, j:j), error)
        if (allocated(error)) return
        report%iterations = report%iterations + 1
        if (correction%acts) then
          call add_correction(correction, a, eq, v(:, j), z(:, j), v(:, j + 1), xn, yn, error)
          if (allocated(error)) return
        end if
        call multiply_free(a, eq, z(:, j), v(:, j + 1), xn, yn)
        h(:, j) = 0.0_wp
        do i = 1, j ! modified Gram-Schmidt
          h(i, j) = dot_product(v(:, i), v(:, j + 1))
          v(:, j + 1) = v(:, j + 1) - h(i, j)*v(:, i)
        end do
        h(j + 1, j) = norm2(v(:, j + 1))
        if (h(j + 1, j) > 0.0_wp) v(:, j + 1) = v(:, j + 1)/h(j + 1, j)
        call rotate(h(:, j), rotation, g, j)
        if (report%iterations >= limit .or. .not. abs(g(j + 1)) > goal) exit
        report%slow = is_slow(abs(g(j + 1))/norm2(b), tolerance, report%iterations, limit, hurries)
        if (report%slow) exit
      end do
      j = min(j, m)
      y = 0.0_wp
      do i = j, 1, -1
        if (h(i, i) > 0.0_wp) y(i) = (g(i) - dot_product(h(i, i + 1:j), y(i + 1:j)))/h(i, i)
      end do
      x = x + matmul(z(:, 1:j), y(1:j))
      call true_residual(a, eq, b, x, r, xn, yn)
      exhausted = report%iterations >= limit .or. report%slow
      if (stops(a, eq, b, x, r, goal, before, exhausted, report)) return
    end do
  end subroutine gmres

  !> May the solver give up early, and would it need more than ALLOWANCE times `limit` iterations,
  !! judging by the digits gained so far?
  pure logical function is_slow(reached, tolerance, iterations, limit, hurries)
    real(wp), intent(in) :: reached    !! relative residual
    real(wp), intent(in) :: tolerance
    integer, intent(in) :: iterations, limit
    logical, intent(in), optional :: hurries
    integer, parameter :: TRIAL = 6            !! number of iterations that are always made
    real(wp), parameter :: ALLOWANCE = 1.5_wp  !! factor of `limit`; convergence may become faster

    is_slow = .false.
    if (present(hurries)) is_slow = hurries
    is_slow = is_slow .and. iterations >= TRIAL .and. reached > tolerance
    if (is_slow) is_slow = iterations*log(tolerance) < ALLOWANCE*limit*log(reached)
  end function is_slow

  !> Make column j of the Hessenberg matrix triangular by Givens rotations, and apply them to the
  !! right-hand side g.
  pure subroutine rotate(h, rotation, g, j)
    real(wp), intent(inout) :: h(:), rotation(:, :), g(:)
    integer, intent(in) :: j
    real(wp) :: length
    integer :: i

    do i = 1, j - 1
      h(i:i + 1) = [rotation(1, i)*h(i) + rotation(2, i)*h(i + 1), &
                    rotation(1, i)*h(i + 1) - rotation(2, i)*h(i)]
    end do
    length = hypot(h(j), h(j + 1))
    rotation(:, j) = [1.0_wp, 0.0_wp]
    if (length > 0.0_wp) rotation(:, j) = h(j:j + 1)/length
    h(j:j + 1) = [length, 0.0_wp]
    g(j:j + 1) = [rotation(1, j)*g(j), -rotation(2, j)*g(j)]
  end subroutine rotate

  !> Compute r = b - A x.
  subroutine true_residual(a, eq, b, x, r, xn, yn)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: b(:), x(:)
    real(wp), intent(inout) :: r(:), xn(:, :), yn(:, :)

    call multiply_free(a, eq, x, r, xn, yn)
    r = b - r
  end subroutine true_residual

  !> Does the iteration stop after this cycle? It stops if it has reached its goal, if it was
  !! exhausted (limit, slow convergence or negative curvature), or if it has stagnated.
  !!
  !! Rounding alone leaves a residual of about eps |A| |x|, which may be above the goal if |x| is
  !! large (slender bodies). If the iteration stops with a residual of this size, it is accepted as
  !! converged.
  logical function stops(a, eq, b, x, r, goal, before, exhausted, report)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: b(:), x(:), r(:)
    real(wp), intent(in) :: goal, before
    logical, intent(in) :: exhausted
    type(krylov_report_t), intent(inout) :: report
    real(wp), parameter :: ROUNDING = 10*epsilon(1.0_wp)
    !> With a larger relative residual, the matrix may be practically singular.
    real(wp), parameter :: WORST = 1e-6_wp
    real(wp) :: total(size(b))

    report%residual = norm2(r)/norm2(b)
    report%converged = norm2(r) <= goal
    stops = report%converged .or. exhausted .or. .not. norm2(r) <= SLACK*before
    if (report%converged .or. .not. stops) return
    call row_sums(a, eq, total)
    report%rounds = maxval(abs(r)) <= ROUNDING*(maxval(total)*maxval(abs(x)) + maxval(abs(b)))
    report%converged = report%rounds .and. report%residual <= WORST
  end function stops

end module krylov
