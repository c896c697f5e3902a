!> Augmentation (Uzawa): how much the pressure multipliers of a contact rise.
!!
!! A multiplier that took the pressure of its own point would go on until no point of either side
!! penetrates. There are more points than nodes, and both sides are integrated: one of two surfaces
!! that do not fit then carries all multipliers and the other none, and the bodies feel different
!! forces. So pressures and penetrations are made smooth first, with the functions of the surfaces.
!! Then the mean of both sides' penetrations is to vanish, and the difference of their pressures:
!!
!!   rise_1 = (d_1 + d_2)/2 - (p_1 - p_2)/2,   rise_2 = (d_1 + d_2)/2 + (p_1 - p_2)/2,
!!
!! d what the penetrations press, which is the pressure p less the multiplier. Of a body on a rigid
!! tool rise = d.
module contact_augment
  use base_kinds, only: wp
  use contact_work, only: element_functions
  use contact_pair, only: contact_t, contact_points_t, contact_state_t
  use contact_smooth, only: smooth_t, smooth_side
  use contact_type, only: TOUCH
  implicit none
  private
  public :: rise_t, find_rise, take_rise

  !> Of the points of one side.
  type :: rise_t
    real(wp), allocatable :: at(:)     !! (np) [F/L^2]
  end type rise_t

contains

  !> Rises of both sides; none where a side is rigid.
  subroutine find_rise(contact, state, rise)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    type(rise_t), intent(out) :: rise(2)
    type(smooth_t) :: pressed(2), pressure(2)
    integer :: k

    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      associate (points => state%side(k))
        call smooth(contact, k, points, points%pressure - points%multiplier, pressed(k))
        call smooth(contact, k, points, points%pressure, pressure(k))
      end associate
    end do
    do k = 1, 2
      if (contact%side(k)%rigid) then
        allocate (rise(k)%at(0))
      else
        call interpolate(contact, k, state%side(k), pressed, pressure, rise(k)%at)
      end if
    end do
  end subroutine find_rise

  !> A value of all points of side k, in contact or not, smooth at its nodes: field%pressure.
  subroutine smooth(contact, k, points, value, field)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    real(wp), intent(in) :: value(:)   !! (np)
    type(smooth_t), intent(out) :: field
    type(contact_points_t) :: part

    part = points
    part%pressure = value
    part%state = TOUCH
    part%traction = 0.0_wp
    part%elastic = 0.0_wp
    call smooth_side(contact, k, part, field)
  end subroutine smooth

  !> At the points of side k, with the other side's fields at the feet. A point without a foot loses
  !! what it had.
  subroutine interpolate(contact, k, points, pressed, pressure, rise)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    type(smooth_t), intent(in) :: pressed(2), pressure(2)
    real(wp), allocatable, intent(out) :: rise(:)
    real(wp) :: d, p
    integer :: i, q

    rise = -points%multiplier
    do i = 1, size(rise)
      if (points%foot(i) == 0) cycle
      q = mod(i - 1, contact%nq) + 1
      d = value_at(contact, k, pressed(k), (i - 1)/contact%nq + 1, contact%xi(:, q))
      rise(i) = d
      if (contact%side(3 - k)%rigid) cycle
      associate (e => points%foot(i), xi => points%foot_xi(:, i))
        d = 0.5_wp*(d + value_at(contact, 3 - k, pressed(3 - k), e, xi))
        p = value_at(contact, k, pressure(k), (i - 1)/contact%nq + 1, contact%xi(:, q)) &
            - value_at(contact, 3 - k, pressure(3 - k), e, xi)
        rise(i) = d - 0.5_wp*p
      end associate
    end do
  end subroutine interpolate

  !> The field of a side in element e at xi.
  real(wp) function value_at(contact, k, field, e, xi) result(value)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    type(smooth_t), intent(in) :: field
    real(wp), intent(in) :: xi(2)
    real(wp), allocatable :: shp(:), dshp(:, :)

    associate (side => contact%side(k))
      associate (mine => field%at(side%first(e):side%first(e + 1) - 1))
        allocate (shp(size(mine)), dshp(2, size(mine)))
        call element_functions(side, e, xi, shp, dshp)
        value = dot_product(shp, field%pressure(mine))
      end associate
    end associate
  end function value_at

  !> The multipliers rise; none is negative.
  pure subroutine take_rise(rise, points)
    type(rise_t), intent(in) :: rise
    type(contact_points_t), intent(inout) :: points

    if (size(rise%at) == 0) return
    points%multiplier = max(0.0_wp, points%multiplier + rise%at)
  end subroutine take_rise

end module contact_augment
