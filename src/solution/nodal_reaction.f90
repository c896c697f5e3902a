!> Reactions as FEAP prints them: what the elements exert on the nodes.
!!
!! Nodal forces (FORC, EFOR, CFOR, CSUR) are not taken off: a free node with a force shows that
!! force, and the sum over all nodes is zero in equilibrium without body forces.
!! Source: FEAPpv
module nodal_reaction
  use base_kinds, only: wp
  use load_curve, only: load_factor
  use model, only: model_t, state_t
  implicit none
  private
  public :: reactions_at

contains

  !> Internal force of the elements, less their body forces, at nodes.
  pure function reactions_at(model, state, node) result(r)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: node(:)
    real(wp) :: r(3, size(node))         !! [F]
    integer :: i, d

    do i = 1, size(node)
      associate (n => node(i))
        r(:, i) = state%reaction(:, n)
        if (.not. allocated(model%bc%force)) cycle
        do d = 1, 3
          r(d, i) = r(d, i) + model%bc%force(d, n)*load_factor(state%factor, model%bc%table(d, n))
        end do
      end associate
    end do
  end function reactions_at

end module nodal_reaction
