!> Fields of contact surfaces at nodes and control points, smoothed; zero away from the surfaces.
module contact_fields
  use base_kinds, only: wp
  use contact_smooth, only: smooth_t, smooth_side
  use model, only: model_t, state_t
  implicit none
  private
  public :: nodal_contact_t, gather_contact

  !> Coefficients. Where a node belongs to several sides the tractions add up, the smallest gap and
  !! the largest state count.
  type :: nodal_contact_t
    real(wp), allocatable :: traction(:, :) !! (3, nnode) on the surface [F/L^2]
    real(wp), allocatable :: friction(:, :) !! (3, nnode) part of it that friction holds [F/L^2]
    real(wp), allocatable :: pressure(:, :) !! (1, nnode) [F/L^2]
    real(wp), allocatable :: gap(:, :)      !! (1, nnode) [L]
    real(wp), allocatable :: slip(:, :)     !! (3, nnode) [L]
    real(wp), allocatable :: state(:, :)    !! (1, nnode) 0 open, 1 stick, 2 slip
  end type nodal_contact_t

contains

  !> All sides of all contacts; a rigid side has no points and stays zero.
  subroutine gather_contact(model, state, nodal)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(nodal_contact_t), intent(out) :: nodal
    type(smooth_t) :: field
    logical, allocatable :: met(:)
    integer :: c, k, n

    n = model%mesh%nnode
    allocate (nodal%traction(3, n), nodal%friction(3, n), nodal%slip(3, n), source=0.0_wp)
    allocate (nodal%pressure(1, n), nodal%gap(1, n), nodal%state(1, n), source=0.0_wp)
    allocate (met(n), source=.false.)
    do c = 1, size(model%contact)
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        call smooth_side(model%contact(c), k, state%contact(c)%side(k), field)
        call add_side(field, met, nodal)
      end do
    end do
  end subroutine gather_contact

  pure subroutine add_side(field, met, nodal)
    type(smooth_t), intent(in) :: field
    logical, intent(inout) :: met(:)        !! (nnode) the node was on a side before
    type(nodal_contact_t), intent(inout) :: nodal
    integer :: a, n

    do a = 1, size(field%node)
      n = field%node(a)
      nodal%traction(:, n) = nodal%traction(:, n) + field%traction(:, a)
      nodal%friction(:, n) = nodal%friction(:, n) + field%friction(:, a)
      nodal%pressure(1, n) = nodal%pressure(1, n) + field%pressure(a)
      nodal%slip(:, n) = nodal%slip(:, n) + field%slip(:, a)
      nodal%state(1, n) = max(nodal%state(1, n), field%state(a))
      nodal%gap(1, n) = merge(min(nodal%gap(1, n), field%gap(a)), field%gap(a), met(n))
      met(n) = .true.
    end do
  end subroutine add_side

end module contact_fields
