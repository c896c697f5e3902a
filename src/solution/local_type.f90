!> A step under local control: the release of the bonds at its end is given, its time is found.
module local_type
  use base_kinds, only: wp
  use bond_release, only: bonded_area, find_release
  use model, only: model_t, state_t
  implicit none
  private
  public :: local_t, begin_local, is_all_released

  !> Share of the bonds that is nothing.
  real(wp), parameter :: LAST = 1.0e-3_wp

  type :: local_t
    logical :: on = .false.
    real(wp) :: piece = 0.0_wp         !! release that the step adds [L^2]
    real(wp) :: goal = 0.0_wp          !! release at its end [L^2]
    real(wp) :: from = 0.0_wp          !! time when it began
    real(wp) :: limit = 0.0_wp         !! time it may not pass
    !> It ends at the limit, with less release than it may have.
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

  !> Nothing was left to control when the last step ended.
  function is_all_released(model, state) result(yes)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    logical :: yes
    real(wp), allocatable :: slope(:, :)
    real(wp) :: released

    allocate (slope(3, model%mesh%nnode))
    call find_release(model, state, state%u_step, released, slope)
    yes = released >= (1.0_wp - LAST)*bonded_area(model, state)
  end function is_all_released

end module local_type
