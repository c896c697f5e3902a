!> The anchors of bodies that contact does not hold yet (see `anchors`) in Newton's iteration: their
!! forces in the residual, and their stiffness in the solution of the linear system.
module anchored_newton
  use anchors, only: anchors_t, anchor_force, set_anchors
  use assembly, only: free_part
  use base_error, only: error_t
  use base_kinds, only: wp
  use lapack, only: dgesv, dsyev
  use linear_system, only: solve_report_t
  use model, only: model_t, state_t
  use newton_type, only: newton_t
  implicit none
  private
  public :: renew_anchors, solve_anchored, loads_of, sum_of_loads

  !> Tolerance of the relative residual of a linear solve for an anchor.
  real(wp), parameter :: CLOSE = 1.0e-9_wp

contains

  !> Set the anchors of bodies that contact does not hold, and add their forces to the residual.
  !! There are no anchors while bodies "fly", that is, while they are moved towards a contact.
  subroutine renew_anchors(newton, model, state, flies)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(in) :: flies
    real(wp), allocatable :: force(:, :), du(:, :)

    associate (asm => newton%asm)
      if (.not. (allocated(asm%anchors%dv) .or. newton%hold%springs)) return
      allocate (force(3, model%mesh%nnode), source=0.0_wp)
      allocate (du, source=state%u - state%u_step)
      call anchor_force(asm%anchors, du, force)
      asm%f_int = asm%f_int - force
      if (flies) then
        asm%anchors = anchors_t()
      else
        call set_anchors(newton%hold%body, newton%hold%weak, newton%hold%released, model%eq, &
                         model%mesh%xr + state%u, asm%k, asm%anchors)
      end if
      call anchor_force(asm%anchors, du, asm%f_int)
      state%reaction = asm%f_int - asm%f_ext
      call free_part(model%eq, -state%reaction, newton%rhs)
    end associate
  end subroutine renew_anchors

  !> Correct the increment for the stiffness of the anchors, which is not part of the matrix A: each
  !! anchor adds w w^T with w = D v (formula of Sherman, Morrison and Woodbury). Then correct the
  !! signs of the pivots by det(A + W W^T) = det(A) det(S), S = 1 + W^T A^-1 W, and by Sylvester's
  !! law of inertia.
  subroutine solve_anchored(newton, model, report, error)
    type(newton_t), intent(inout) :: newton
    type(model_t), intent(in) :: model
    type(solve_report_t), intent(inout) :: report !! signs without, then with anchors
    type(error_t), allocatable, intent(out) :: error
    type(solve_report_t) :: other
    real(wp), allocatable :: w(:, :), y(:, :), s(:, :), c(:), value(:), work(:), lower(:, :)
    integer, allocatable :: pivot(:)
    integer :: i, info, m

    if (.not. allocated(newton%asm%anchors%dv)) return
    m = size(newton%asm%anchors%dv, 3)
    allocate (w(size(newton%dx), m), y(size(newton%dx), m), pivot(m))
    do i = 1, m
      call free_part(model%eq, newton%asm%anchors%dv(:, :, i), w(:, i))
      call newton%system%solve(newton%asm%k, w(:, i), y(:, i), CLOSE, other, error, &
                               same_matrix=.true.)
      if (allocated(error)) return
    end do
    s = matmul(transpose(w), y)
    do i = 1, m
      s(i, i) = s(i, i) + 1.0_wp
    end do
    c = matmul(newton%dx, w)
    if (newton%symmetric) then
      allocate (value(m), work(8*m), lower(m, m))
      lower = s
      call dsyev('N', 'L', m, lower, m, value, work, size(work), info)
      report%negative = max(0, report%negative - count(value < 0.0_wp))
    end if
    call dgesv(m, 1, s, m, pivot, c, m, info)
    if (info /= 0) return
    newton%dx = newton%dx - matmul(y, c)
    do i = 1, m ! the diagonal of U and the exchanges of rows give the sign of det(S)
      if (s(i, i) < 0.0_wp) report%determinant = -report%determinant
      if (pivot(i) /= i) report%determinant = -report%determinant
    end do
  end subroutine solve_anchored

  !> External minus internal forces, without the forces of the anchors [F].
  function loads_of(newton, state) result(force)
    type(newton_t), intent(in) :: newton
    type(state_t), intent(in) :: state
    real(wp) :: force(3, size(state%u, 2))

    force = -state%reaction
    call anchor_force(newton%asm%anchors, state%u - state%u_step, force)
  end function loads_of

  !> The sum of the magnitudes of all nodal loads or of all reactions of supports, whichever is
  !! larger [F].
  pure real(wp) function sum_of_loads(newton, model, state) result(loads)
    type(newton_t), intent(in) :: newton
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    loads = max(sum(norm2(newton%asm%f_ext, 1)), &
                sum(norm2(merge(state%reaction, 0.0_wp, model%eq == 0), 1)))
  end function sum_of_loads

end module anchored_newton
