!> Contact when a step is accepted: what its forces were made of, and what the next one starts with.
module contact_accept
  use base_kinds, only: wp
  use contact_assembly, only: contact_work_t, friction_acts
  use contact_feet, only: follow_silent
  use contact_history, only: look_aside, ASIDE
  use contact_shares, only: add_shares
  use contact_slide, only: accept_slides
  use model, only: model_t, state_t
  implicit none
  private
  public :: share_contact, accept_contact

contains

  !> Shares of the internal forces: pressure, friction and cohesion of all contacts.
  subroutine share_contact(work, model, state, f)
    type(contact_work_t), intent(in) :: work(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: f(:, :, :)            !! (3, nnode, 3) [F]
    integer :: c, k

    f = 0.0_wp
    do c = 1, size(work)
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        call add_shares(model%contact(c), k, work(c)%feet(k)%at, state%contact(c)%side(k), f)
      end do
    end do
  end subroutine share_contact

  !> The step is done: stored sliding points move.
  subroutine accept_contact(work, model, state)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: x(:, :)
    integer :: c, k

    if (size(work) == 0) return
    x = model%mesh%xr + state%u
    do c = 1, size(work)
      associate (contact => model%contact(c), point => state%contact(c)%side)
        do k = 1, 2
          if (contact%side(k)%rigid) cycle
          call follow_silent(contact, k, work(c)%shape(3 - k), work(c)%grid(3 - k), x, &
                             friction_acts(contact, state), work(c)%feet(k)%at, point(k), &
                             work(c)%element(k))
          call look_aside(work(c)%feet(k)%at, ASIDE*contact%depth, point(k))
          call accept_slides(contact%side(k), contact%side(3 - k), work(c)%shape(3 - k), x, &
                             work(c)%feet(k)%at, point(k))
        end do
      end associate
    end do
  end subroutine accept_contact

end module contact_accept
