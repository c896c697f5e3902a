!> Finds out whether a factorised matrix is singular, and which motions are then free.
!!
!! Pivots alone do not show whether a matrix is singular: rounding leaves pivots of 1e-9 in a free
!! slender body, and supported slender bodies have pivots of 1e-10. Two steps of inverse iteration
!! find the smallest eigenvalue itself, which is of the order of the rounding unit if the matrix is
!! singular, and far larger otherwise. Rows and columns are divided by the square roots of the sums
!! of the absolute values in the rows, so that units and stiff parts of the model have no influence.
module null_space
  use base_error, only: error_t
  use base_kinds, only: wp
  use csr, only: block_matrix_t, multiply_free, row_sums
  use solver_type, only: solver_t
  implicit none
  private
  public :: prove_regular, pick_dofs

  !> Eigenvalues below this limit are taken as zero. Free bodies of all shapes had eigenvalues of
  !! 6e-17 to 9e-17, and a clamped bar of 3000 cubes in a row had one of 2e-15.
  real(wp), parameter :: ZERO_EIGENVALUE = 2*epsilon(1.0_wp)
  real(wp), parameter :: DOUBT = 2*epsilon(1.0) !! limit for approximate factors
  integer, parameter :: MOST = 14  !! motions found at once: six of each of two bodies, and two more
  integer, parameter :: STEPS = 2  !! number of steps of inverse iteration

contains

  !> Find out whether the matrix that was just factorised is regular; if so, `null` is not
  !! changed. Otherwise `null` gets one equation for each free motion, such that supports at these
  !! equations would prevent the motions.
  !!
  !! If approximate factors do not give a clear answer, the matrix is reported as singular (with
  !! equation 1 in place of the free motions), and exact factors must decide.
  subroutine prove_regular(a, eq, solver, exact, null, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)              !! (3, nnode) equation numbers, 0: prescribed
    class(solver_t), intent(inout) :: solver     !! with the factors of the matrix
    logical, intent(in) :: exact                 !! factors in double precision, not compressed
    !> Equations of free motions: on entry those that the solver found, on exit all of them if the
    !! factors are exact.
    integer, allocatable, intent(inout) :: null(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: q(:, :), s(:), lambdas(:)
    integer, allocatable :: more(:)
    integer :: k, n

    if (size(null) > 0 .and. .not. (exact .and. solver%pins_null_pivots)) return
    call iterate(a, eq, solver, 1, q, s, lambdas, error)
    if (allocated(error)) return
    if (lambdas(1) > merge(ZERO_EIGENVALUE, DOUBT, exact)) return
    more = [1]
    if (exact) then
      call iterate(a, eq, solver, min(MOST, solver%neq), q, s, lambdas, error)
      if (allocated(error)) return
      n = 0
      do k = 1, size(lambdas)
        if (lambdas(k) > ZERO_EIGENVALUE) cycle
        n = n + 1
        q(:, n) = q(:, k)/s
      end do
      call pick_dofs(q(:, :n), more)
    end if
    null = [null, more]
  end subroutine prove_regular

  !> Do the inverse iteration with m vectors.
  subroutine iterate(a, eq, solver, m, q, s, lambdas, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :), m
    class(solver_t), intent(inout) :: solver
    real(wp), allocatable, intent(out) :: q(:, :)    !! (neq, m) orthonormal in the scaled system
    real(wp), allocatable, intent(out) :: s(:)       !! (neq) scale factors: displacements are q/s
    real(wp), allocatable, intent(out) :: lambdas(:) !! (m) |A q| of the scaled system
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: y(:), xn(:, :), yn(:, :)
    integer :: i, k

    allocate (q(solver%neq, m), s(solver%neq), lambdas(m), y(solver%neq))
    allocate (xn(3, a%nnode), yn(3, a%nnode))
    call row_sums(a, eq, s)
    where (s > 0.0_wp)
      s = sqrt(s)
    else where
      s = 1.0_wp
    end where
    do k = 1, m
      q(:, k) = [(sin(real(i, wp)*real(i + 7*k, wp)), i=1, solver%neq)] ! irregular but repeatable
    end do
    do i = 1, STEPS
      q = spread(s, 2, m)*q
      call solver%solve(q, error)
      if (allocated(error)) return
      q = spread(s, 2, m)*q
      call orthonormalise(q)
    end do
    do k = 1, m
      call multiply_free(a, eq, q(:, k)/s, y, xn, yn)
      lambdas(k) = norm2(y/s)
    end do
  end subroutine iterate

  !> Orthonormalise by the Gram-Schmidt method, always continuing with the longest remaining column.
  !! Each column is orthogonalised twice, because the columns are almost parallel.
  pure subroutine orthonormalise(q)
    real(wp), intent(inout) :: q(:, :)
    real(wp) :: length(size(q, 2)), column(size(q, 1))
    integer :: j, k, longest, pass

    do k = 1, size(q, 2)
      length = [(norm2(q(:, j)), j=1, size(q, 2))]
      longest = k - 1 + maxloc(length(k:), dim=1)
      column = q(:, longest)
      q(:, longest) = q(:, k)
      do pass = 1, 2
        do j = 1, k - 1
          column = column - dot_product(q(:, j), column)*q(:, j)
        end do
        if (norm2(column) > 0.0_wp) column = column/norm2(column)
      end do
      q(:, k) = column
      do j = k + 1, size(q, 2)
        q(:, j) = q(:, j) - dot_product(column, q(:, j))*column
      end do
    end do
  end subroutine orthonormalise

  !> Choose as many dofs as there are motions, such that every combination of the motions moves at
  !! least one of these dofs.
  pure subroutine pick_dofs(motion, dof)
    real(wp), intent(in) :: motion(:, :)        !! (neq, m)
    integer, allocatable, intent(out) :: dof(:) !! (m)
    real(wp), allocatable :: w(:, :)
    integer :: at(2), j, k

    allocate (w(size(motion, 1), size(motion, 2)), dof(size(motion, 2)))
    w(:, :) = motion
    do k = 1, size(w, 2)
      at = maxloc(abs(w(:, k:)))
      dof(k) = at(1)
      at(2) = at(2) + k - 1
      w(:, [k, at(2)]) = w(:, [at(2), k])
      if (.not. abs(w(dof(k), k)) > 0.0_wp) cycle
      do j = k + 1, size(w, 2)
        w(:, j) = w(:, j) - w(:, k)*(w(dof(k), j)/w(dof(k), k))
      end do
    end do
  end subroutine pick_dofs

end module null_space
