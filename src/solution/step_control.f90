!> Time steps: fixed ones, and automatic ones that are cut back and grow again.
!!
!! The targets are the times origin + k dt, which are never computed by summation. A cut-back
!! divides the interval to the next target into equal steps. A step that has grown beyond dt (dtmax
!! > dt) passes several targets and ends on one of them.
module step_control
  use base_kinds, only: wp
  implicit none
  private
  public :: step_control_t, set_dt, set_auto, next_time, next_target, set_end, accept_time, &
            pass_target, may_halve, cut_time, whole_step, on_target

  type :: step_control_t
    real(wp) :: dt = 0.0_wp          !! time between targets
    real(wp) :: origin = 0.0_wp      !! time of target 0
    integer :: target = 0            !! number of targets reached since the origin
    real(wp) :: size = 0.0_wp        !! length of the next step; at most dt unless dtmax allows more
    logical :: automatic = .false.
    real(wp) :: dtmin = 0.0_wp, dtmax = 0.0_wp
    real(wp) :: from = 0.0_wp, to = 0.0_wp !! times at which the current step begins and ends
    integer :: passed = 0  !! number of targets that the step reaches; 0: it ends before the next
    integer :: accepted = 0          !! steps since the last cut-back
    logical :: reduced = .false.     !! the next step is smaller, after many iterations
    real(wp) :: failed = 0.0_wp      !! length of the last step that was cut back; 0: there is none
  end type step_control_t

  !> A corner of a load table that is nearer to a target than this, relative to dt, counts as equal
  !! to it. A DT such as 0.3333333 misses corners by more than rounding, and a step of the remaining
  !! length would divide rounding errors of displacements by its square (inertia).
  real(wp), parameter, public :: NEARLY = 1.0e-6_wp
  integer, parameter :: FEW = 6      !! the next step may grow after at most so many iterations
  integer, parameter :: FAIR = 10    !! largest such number for a step smaller than dt
  integer, parameter :: MANY = 15    !! the next step is smaller after more iterations than this
  integer, parameter :: FINE = 16    !! see may_halve
  integer, parameter :: PATIENCE = 8 !! number of steps of limited length after a failed one
  real(wp), parameter :: SHORTER = 0.75_wp !! largest length of these steps, relative to the failed
  !! one, if this is longer than dt

contains

  !> Set a new interval between targets (DT), which are counted from `time`.
  pure subroutine set_dt(control, time, dt)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: time, dt

    control%dt = dt
    control%origin = time
    control%target = 0
    control%size = dt
  end subroutine set_dt

  !> Set the limits of AUTO,,dtmin,dtmax. They hold from the next step on, which an earlier AUTO may
  !! have let grow further.
  subroutine set_auto(control, dtmin, dtmax)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: dtmin, dtmax

    control%automatic = .true.
    control%dtmin = dtmin
    control%dtmax = dtmax
    control%size = min(control%size, max(control%dt, dtmax))
  end subroutine set_auto

  !> Time at the end of the next step; `left` is the number of targets that remain in the loop,
  !! including the next one. An automatic step ends at the next corner of a load table, or at the
  !! last target before this corner. A step that passes several targets ends at the last one before
  !! the next extremum of a table.
  function next_time(control, time, left, corner, extremum) result(to)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: time
    integer, intent(in) :: left
    real(wp), intent(in), optional :: corner !! corner of a load table; absent: there is none
    real(wp), intent(in), optional :: extremum !! of a sine of a load table; absent: there is none
    real(wp) :: to, gap
    real(wp) :: nstep ! in very short steps, more than the largest integer

    control%from = time
    control%passed = 1
    if (control%automatic .and. control%size >= 2*control%dt) then
      control%passed = max(1, min(left, int(control%size/control%dt*(1 + epsilon(1.0_wp)*8))))
    end if
    to = control%origin + (control%target + control%passed)*control%dt
    if (present(extremum) .and. control%passed > 1) then
      if (extremum < to) then
        control%passed = max(1, int((extremum - control%origin)/control%dt + NEARLY) &
                             - control%target)
        to = control%origin + (control%target + control%passed)*control%dt
      end if
    end if
    if (present(corner)) call end_at_corner(control, corner, to)
    gap = to - time
    if (control%automatic) then
      nstep = (gap*(1 - epsilon(1.0_wp)*64) - 4*spacing(to))/control%size ! with rounding
      if (nstep > 1.0_wp) then
        if (aint(nstep) < nstep) nstep = aint(nstep) + 1.0_wp
        to = time + gap/nstep
        control%passed = 0
      end if
    end if
    control%to = to
  end function next_time

  !> End an automatic step at a corner, or at the last target before it.
  pure subroutine end_at_corner(control, corner, to)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: corner
    real(wp), intent(inout) :: to
    integer :: before

    if (.not. control%automatic .or. corner >= to - NEARLY*control%dt) return
    before = int((corner - control%origin)/control%dt + NEARLY) - control%target
    control%passed = max(0, min(control%passed - 1, before))
    to = corner
    if (control%passed > 0) to = control%origin + (control%target + control%passed)*control%dt
  end subroutine end_at_corner

  !> Begin a constrained step, which finds its own end. The result is the time of the next target,
  !! which the step may not pass.
  function next_target(control, time) result(target)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: time
    real(wp) :: target

    control%from = time
    control%passed = 0
    target = control%origin + (control%target + 1)*control%dt
    control%to = target
  end function next_target

  !> Set the end of a constrained step, which may be on its target or before it.
  subroutine set_end(control, time, on_target)
    type(step_control_t), intent(inout) :: control
    real(wp), intent(in) :: time
    logical, intent(in) :: on_target

    control%to = time
    control%passed = merge(1, 0, on_target)
  end subroutine set_end

  !> Accept the time of a converged step: count its targets, and set the size of the next step.
  subroutine accept_time(control, iterations)
    type(step_control_t), intent(inout) :: control
    integer, intent(in) :: iterations
    real(wp) :: taken

    call pass_target(control)
    if (.not. control%automatic) return
    if (control%origin >= control%to) return ! DT has been set again at the end of this step
    taken = control%to - control%from
    control%accepted = control%accepted + 1
    if (iterations > MANY) then
      control%size = max(0.75_wp*taken, control%dtmin)
      control%reduced = control%size < taken
    else if (control%accepted > 1 .and. &
             (iterations <= FEW .or. (iterations <= FAIR .and. control%size < control%dt))) then
      control%size = min(1.5_wp*max(taken, control%size), max(control%dt, control%dtmax))
      ! a step as long as one that failed would fail again
      if (control%failed > 0.0_wp .and. control%accepted < PATIENCE) then
        control%size = min(control%size, max(control%dt, SHORTER*control%failed))
      end if
    end if
  end subroutine accept_time

  !> Count the targets that the complete step passed.
  subroutine pass_target(control)
    type(step_control_t), intent(inout) :: control

    control%target = control%target + control%passed
    control%reduced = .false.
  end subroutine pass_target

  !> May a step that has converged be halved to look for another state? Its halves have at least the
  !! length dtmin and at least 1/FINE of the time between targets.
  pure function may_halve(control) result(yes)
    type(step_control_t), intent(in) :: control
    logical :: yes
    real(wp) :: half

    half = 0.5_wp*(control%to - control%from)
    yes = control%automatic .and. half >= control%dtmin .and. &
          half >= (1.0_wp - NEARLY)*control%dt/FINE
  end function may_halve

  !> Halve a failed step. The result is false if half of the step is smaller than dtmin.
  function cut_time(control) result(possible)
    type(step_control_t), intent(inout) :: control
    logical :: possible

    possible = .false.
    if (.not. control%automatic) return
    control%failed = control%to - control%from
    control%size = 0.5_wp*control%failed
    control%accepted = 0
    possible = control%size >= control%dtmin .and. control%from + control%size > control%from
  end function cut_time

  !> Try the whole step to the next target again, with another method.
  subroutine whole_step(control)
    type(step_control_t), intent(inout) :: control

    control%size = control%dt
    control%failed = 0.0_wp
  end subroutine whole_step

  !> Did the previous step end on a target?
  pure function on_target(control) result(yes)
    type(step_control_t), intent(in) :: control
    logical :: yes

    yes = control%passed > 0
  end function on_target

end module step_control
