!> Values of the quantities of contacts that a CURVe asks for.
!!
!! Tractions on side k act on side k: a body that is pressed down on another one is pushed up, and
!! what it lies on feels a negative z force. A rigid side has no points of its own: it shows what
!! the other side shows, with forces reversed where the points stand on it.
module contact_values
  use base_kinds, only: wp
  use contact_resultant, only: resultant_t, find_resultant
  use contact_smooth, only: smooth_t, smooth_side, largest_pressure, largest_tangential
  use curve_type, only: quantity_t, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                        Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
                        Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED
  use model, only: model_t, state_t
  implicit none
  private
  public :: contact_value, side_resultant

contains

  !> One column.
  function contact_value(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    type(resultant_t) :: total

    if (any(quantity%kind == [Q_CONTACT_PRESSURE, Q_CONTACT_TANGENTIAL])) then
      value = largest_value(model, state, quantity)
      return
    end if
    if (quantity%kind == Q_CONTACT_DEBONDED) then
      value = debonded_share(model, state, quantity)
      return
    end if
    call side_resultant(model, state, quantity%contact, quantity%side, quantity%point, total)
    select case (quantity%kind)
    case (Q_CONTACT_FORCE)
      value = total%force(quantity%component)
    case (Q_CONTACT_TORQUE)
      value = dot_product(total%moment, quantity%axis)
    case (Q_CONTACT_STICK)
      value = share(total%nstick, total%nclosed)
    case (Q_CONTACT_SLIP)
      value = share(total%nslip, total%nclosed)
    case (Q_CONTACT_AREA)
      value = total%area
    case (Q_CONTACT_PENETRATION)
      value = total%penetration
    case default
      value = 0.0_wp
    end select
  end function contact_value

  !> Share of the area that was bonded whose bonds count as released.
  function debonded_share(model, state, quantity) result(share)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: share, bonded, lost
    integer :: k

    associate (contact => model%contact(quantity%contact))
      k = quantity%side
      if (contact%side(k)%rigid) k = 3 - k
      associate (points => state%contact(quantity%contact)%side(k))
        bonded = sum(points%area0, mask=points%bond > 0)
        lost = sum(points%area0, &
                   mask=points%bond > 0 .and. points%opening >= contact%released)
      end associate
    end associate
    share = 0.0_wp
    if (bonded > 0.0_wp) share = lost/bonded
  end function debonded_share

  !> Sums over a side of a contact.
  subroutine side_resultant(model, state, c, k, about, total)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: c, k            !! contact and side
    real(wp), intent(in) :: about(3)       !! point of the moments [L]
    type(resultant_t), intent(out) :: total

    call find_resultant(model%contact(c), k, state%contact(c)%side, model%mesh%xr + state%u, &
                        about, total)
  end subroutine side_resultant

  !> Largest value of a smooth field.
  function largest_value(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    type(smooth_t) :: field
    integer :: k

    associate (contact => model%contact(quantity%contact), &
               points => state%contact(quantity%contact))
      k = quantity%side
      if (contact%side(k)%rigid) k = 3 - k
      call smooth_side(contact, k, points%side(k), field)
      if (quantity%kind == Q_CONTACT_PRESSURE) then
        value = largest_pressure(contact, k, field, quantity%component)
      else
        value = largest_tangential(contact, k, field, quantity%component)
      end if
    end associate
  end function largest_value

  !> 0 where nothing is in contact.
  pure real(wp) function share(n, whole)
    integer, intent(in) :: n, whole

    share = 0.0_wp
    if (whole > 0) share = real(n, wp)/real(whole, wp)
  end function share

end module contact_values
