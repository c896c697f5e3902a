!> Start of a step in which the supports of all bodies turn together: the bodies turn with them as
!! if they were rigid, before the first forces of the step are formed.
!!
!! The first increment of Newton's iteration is linear in the prescribed motion. In a rotation by
!! tens of degrees it distorts bodies so much that contacts and elements may leave the range in
!! which the iteration converges, although nothing but the orientation changes. After the rigid
!! motion, forces and tangent are those of the turned bodies, and only the part of the prescribed
!! motion remains that differs from the rigid one. The solution of the step does not change, since
!! the measures of strain, slip and opening refer to the end of the previous step.
module common_turn
  use base_kinds, only: wp
  use model, only: model_t, state_t
  use prescribed, only: to_prescribed
  use rigid_modes, only: find_bodies
  use screw_motion, only: screw_t, fit_screw, continue_screw
  implicit none
  private
  public :: turn_together

  !> The smallest angle [rad] worth a rigid start: linear increments of smaller rotations hardly
  !! strain the bodies.
  real(wp), parameter :: LEAST_ANGLE = 0.01_wp
  !> Largest displacement of the supports of a body that may remain after the rigid motion, relative
  !! to their largest displacement in it. It is 1 for a body that stands still.
  real(wp), parameter :: LEAST_COMMON = 0.25_wp
  !> Supports lie on a line, and leave the rotation about it open, if the second invariant of their
  !! moments is smaller than this, relative to the square of the first.
  real(wp), parameter :: ON_LINE = 1.0e-4_wp

contains

  !> Turn all nodes by the rigid motion that fits the prescribed increments `move` best, and replace
  !! `move` with what remains of it. Nothing changes if there is no such motion.
  subroutine turn_together(model, state, move, turned)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(inout) :: move(:, :)    !! (3, nnode) prescribed increments [L]
    logical, intent(out) :: turned
    real(wp) :: x(3, size(move, 2)), u(3, size(move, 2)), rest(3, size(move, 2))
    type(screw_t) :: screw
    integer, allocatable :: held(:), body(:)
    real(wp), allocatable :: rigid(:), left(:) ! (nbody) largest squares of displacements [L^2]
    integer :: b, n

    turned = .false.
    call find_supports(model, held)
    x = model%mesh%xr + state%u
    if (.not. span_a_plane(x(:, held))) return
    call fit_screw(x(:, held), x(:, held) + move(:, held), screw)
    if (.not. norm2(screw%w) > LEAST_ANGLE) return
    u = state%u
    do n = 1, size(x, 2)
      if (model%mesh%used(n)) u(:, n) = u(:, n) + continue_screw(screw, 1.0_wp, x(:, n)) - x(:, n)
    end do
    call to_prescribed(model, state%factor, u, rest)
    call find_bodies(model%mesh, body)
    allocate (rigid(maxval(body)), left(maxval(body)), source=0.0_wp)
    do n = 1, size(x, 2)
      b = body(n)
      if (b == 0 .or. all(model%eq(:, n) /= 0)) cycle
      rigid(b) = max(rigid(b), sum((u(:, n) - state%u(:, n))**2))
      left(b) = max(left(b), sum(rest(:, n)**2))
    end do
    if (any(left > LEAST_COMMON**2*rigid)) return
    state%u = u
    state%u_base = u
    move = rest
    turned = .true.
  end subroutine turn_together

  !> The nodes whose three displacements are prescribed. Slaves of constraints are not supports.
  pure subroutine find_supports(model, held)
    type(model_t), intent(in) :: model
    integer, allocatable, intent(out) :: held(:)
    logical :: is_held(size(model%eq, 2))
    integer :: n

    is_held = model%mesh%used .and. all(model%eq == 0, 1)
    associate (list => model%mesh%constraint)
      if (list%n > 0) is_held(list%slave(:list%n)) = .false.
    end associate
    held = pack([(n, n=1, size(is_held))], is_held)
  end subroutine find_supports

  !> Do points determine a rotation, because they do not lie on a line?
  pure logical function span_a_plane(x) result(yes)
    real(wp), intent(in) :: x(:, :)          !! (3, n) [L]
    real(wp) :: d(3, size(x, 2)), m(3, 3)

    yes = size(x, 2) > 2
    if (.not. yes) return
    d = x - spread(sum(x, 2)/size(x, 2), 2, size(x, 2))
    m = matmul(d, transpose(d))
    associate (trace => m(1, 1) + m(2, 2) + m(3, 3))
      yes = trace**2 - sum(m**2) > 2*ON_LINE*trace**2
    end associate
  end function span_a_plane

end module common_turn
