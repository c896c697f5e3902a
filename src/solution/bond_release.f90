!> How much of the bonds of a model has been released: the measure that local control prescribes.
module bond_release
  use base_kinds, only: wp
  use constraint, only: fold_force
  use contact_shares, only: add_release
  use model, only: model_t, state_t
  implicit none
  private
  public :: bonded_area, find_release

  !> A bond counts as released at so many openings d at its strength (`contact%released`).
  real(wp), parameter :: OPENINGS = 8.0_wp

contains

  !> Reference area of all bonded points, of both sides [L^2]: the release of a model without bonds
  !! left.
  pure real(wp) function bonded_area(model, state) result(area)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: c, k

    area = 0.0_wp
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%has_cohesive) cycle
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        associate (points => state%contact(c)%side(k))
          area = area + sum(points%area0, mask=points%bond > 0)
        end associate
      end do
    end do
  end function bonded_area

  !> Release of all bonds at the displacements u, and its derivative.
  subroutine find_release(model, state, u, released, slope)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: u(:, :)                !! (3, nnode) [L]
    real(wp), intent(out) :: released              !! [L^2]
    real(wp), intent(out) :: slope(:, :)           !! (3, nnode) [L]
    real(wp), allocatable :: x(:, :)
    integer :: c, k

    released = 0.0_wp
    slope = 0.0_wp
    allocate (x, source=model%mesh%xr + u)
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%has_cohesive) cycle
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        call add_release(model%contact(c), k, x, model%contact(c)%released/OPENINGS, &
                         state%contact(c)%side(k), released, slope)
      end do
    end do
    call fold_force(model%mesh%constraint, slope)
  end subroutine find_release

end module bond_release
