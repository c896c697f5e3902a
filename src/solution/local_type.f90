!> A step under local control: a measure of it is given, its time is found. The measure is the
!! release of the bonds, or the way along the step before (arc length in the tangent plane).
module local_type
  use base_kinds, only: wp
  use contact_forces, only: bonded_area, find_release
  use model, only: model_t, state_t
  implicit none
  private
  public :: local_t, begin_local, begin_arc, find_measure, turns_away, is_all_released

  !> Share of the bonds that is nothing.
  real(wp), parameter :: LAST = 1.0e-3_wp
  !> Least cosine between a step and the one before.
  real(wp), parameter :: LEAST_COSINE = 0.5_wp

  type :: local_t
    logical :: on = .false.
    real(wp) :: piece = 0.0_wp         !! what the step adds to the measure: [L^2], or [L]
    real(wp) :: goal = 0.0_wp          !! the measure at its end
    real(wp), allocatable :: way(:, :) !! (3, nnode) the last step's, of length one; else: release
    real(wp) :: from = 0.0_wp          !! time when it began
    real(wp) :: limit = 0.0_wp         !! time it may not pass
    !> It ends at the limit, with less of the measure than it may have.
    logical :: at_limit = .false.
  end type local_t

contains

  !> A step begins: `state` is that of its start.
  subroutine begin_local(local, model, state, piece, limit)
    type(local_t), intent(out) :: local
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: piece      !! [L^2]
    real(wp), intent(in) :: limit      !! time
    real(wp), allocatable :: slope(:, :)
    real(wp) :: left, part, released

    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u, released, slope)
    left = bonded_area(model, state) - released
    part = min(piece, 0.5_wp*left)
    local = local_t(on=.true., piece=part, goal=released + part, from=state%time, limit=limit)
  end subroutine begin_local

  !> A step begins that goes on along the one before; its length is that of the vector of all
  !! displacements.
  subroutine begin_arc(local, state, length, limit)
    type(local_t), intent(out) :: local
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: length     !! [L]
    real(wp), intent(in) :: limit      !! time

    local = local_t(on=.true., piece=length, goal=length, from=state%time, limit=limit)
    local%way = state%last_increment/norm2(state%last_increment)
  end subroutine begin_arc

  !> The measure at the displacements of now, and its derivative.
  subroutine find_measure(local, model, state, measure, slope)
    type(local_t), intent(in) :: local
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: measure               !! [L^2], or [L]
    real(wp), intent(out) :: slope(:, :)           !! (3, nnode)

    if (allocated(local%way)) then
      slope = local%way
      measure = sum(slope*(state%u - state%u_step))
    else
      call find_release(model, state, state%u, measure, slope)
    end if
  end subroutine find_measure

  !> A step along the one before has gone elsewhere: to a part of the path beyond, or another one.
  pure logical function turns_away(local, state) result(yes)
    type(local_t), intent(in) :: local
    type(state_t), intent(in) :: state

    yes = allocated(local%way)
    if (yes) yes = sum(local%way*(state%u - state%u_step)) &
                   < LEAST_COSINE*norm2(state%u - state%u_step)
  end function turns_away

  !> There were bonds, and nothing was left of them when the last step ended.
  function is_all_released(model, state) result(yes)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical :: yes
    real(wp), allocatable :: slope(:, :)
    real(wp) :: area, released

    yes = .false.
    area = bonded_area(model, state)
    if (.not. area > 0.0_wp) return
    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u_step, released, slope)
    yes = released >= (1.0_wp - LAST)*area
  end function is_all_released

end module local_type
