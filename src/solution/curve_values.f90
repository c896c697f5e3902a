!> Values of the quantities of a CURVe at the current state.
module curve_values
  use base_kinds, only: wp
  use contact_resultant, only: contact_value
  use curve_type, only: quantity_t, Q_FORCE, Q_TORQUE, Q_DISP, Q_STRESS, Q_ENERGY, Q_MAX_DISP, &
                        Q_MAX_MISES, Q_NODAL, Q_CONTACT_FORCE, Q_CONTACT_DEBONDED, Q_BOOK
  use energy_balance, only: energy_entry
  use model, only: model_t, state_t
  use point_values, only: stress_at, reactions_at, body_energy, largest_mises
  use tensor, only: cross
  implicit none
  private
  public :: quantity_value

contains

  !> Value of one column.
  function quantity_value(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    real(wp) :: sig(6)
    real(wp), allocatable :: r(:, :)
    integer :: i

    value = 0.0_wp
    select case (quantity%id)
    case (Q_FORCE)
      value = sum(state%reaction(quantity%component, quantity%node))
    case (Q_NODAL)
      allocate (r(3, size(quantity%node)))
      r = reactions_at(model, state, state%factor, quantity%node)
      value = sum(r(quantity%component, :))
    case (Q_TORQUE)
      value = torque(model, state, quantity)
    case (Q_DISP)
      value = sum(state%u(quantity%component, quantity%node))/size(quantity%node)
    case (Q_STRESS)
      sig = stress_at(model, state, quantity%block, quantity%elem, quantity%xi)
      value = sig(quantity%component)
    case (Q_ENERGY)
      value = body_energy(model, state, quantity%body)
    case (Q_MAX_DISP)
      do i = 1, size(quantity%node)
        value = max(value, norm2(state%u(:, quantity%node(i))))
      end do
    case (Q_MAX_MISES)
      value = largest_mises(model, state, quantity%body)
    case (Q_CONTACT_FORCE:Q_CONTACT_DEBONDED)
      value = contact_value(model, state, quantity)
    case (Q_BOOK)
      value = energy_entry(model, state, quantity%component)
    case default               ! there are no other quantities
    end select
  end function quantity_value

  !> Moment of the reactions about an axis, at the current positions.
  pure function torque(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    real(wp) :: m(3), x(3)
    integer :: i, n

    m = 0.0_wp
    do i = 1, size(quantity%node)
      n = quantity%node(i)
      x = model%mesh%xr(:, n) + state%u(:, n) - quantity%point
      m = m + cross(x, state%reaction(:, n))
    end do
    value = dot_product(m, quantity%axis)
  end function torque

end module curve_values
