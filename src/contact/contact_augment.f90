!> Augmentation by Uzawa's iteration: finds the increments of the pressure multipliers of a contact.
!!
!! If each multiplier took over the pressure of its own integration point, the multipliers would
!! rise until no point of either side penetrates. There are more points than nodes, and both sides
!! are integrated, so these conditions cannot all be met if the two meshes do not match. The
!! multipliers of one surface would then grow at the expense of those of the other surface until
!! the latter are zero, and different forces would act on the two bodies. To avoid this, pressures
!! and penetrations are first smoothed with the functions of the surfaces. Augmentation then makes
!! two quantities vanish: the mean of the penetrations of both sides and the difference of their
!! pressures. The increments of the multipliers are
!!
!!   rise_1 = (d_1 + d_2)/2 - (p_1 - p_2)/2,   rise_2 = (d_1 + d_2)/2 + (p_1 - p_2)/2,
!!
!! where p is the pressure and d = p - multiplier is the part of p that is due to the penetration.
!! For a body on a rigid surface, rise = d. With PAIR, the multiplier of a bonded point is a
!! pressure on its reference area, while p is a pressure on the current area. In d, the multiplier
!! therefore has the weight area0/area, and the increment is divided by this weight. With MORTar,
!! the multipliers belong to control points,
!! and rise = d on both sides without smoothing.
module contact_augment
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_state_t, MORTAR, contact_points_t
  use contact_smooth, only: smooth_t, smooth_side
  use contact_type, only: TOUCH, PENALTY
  use contact_work, only: element_functions
  implicit none
  private
  public :: rise_t, find_rise, largest_pressure, take_rise, share_penalty, is_augmented

  !> Smallest fraction of the penalty that acts at the control points with MORTar and AUGMent. The
  !! multipliers of the control points take over the pressure.
  real(wp), parameter :: AT_CONTROL_POINTS = 0.9_wp

  !> Increments of the multipliers of one side.
  type :: rise_t
    !> (np) or, with MORTar, (control points of the side) [F/L^2]. Without MORTar, the size is 0 if
    !! the side is rigid.
    real(wp), allocatable :: at(:)
  end type rise_t

contains

  !> Find the increments of both sides. A point that has neither a projection nor a partner of PAIR
  !! loses its multiplier.
  subroutine find_rise(contact, state, rise)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    type(rise_t), intent(out) :: rise(2)
    type(smooth_t) :: pressed(2), pressure(2)
    real(wp), allocatable :: w(:) ! (np)
    real(wp) :: d, p, xi(2)
    integer :: e, i, k, other, q

    if (contact%scheme == MORTAR) then ! the multipliers are pressures of control points
      do k = 1, 2
        rise(k)%at = state%control(k)%pressure - state%control(k)%multiplier
      end do
      return
    end if
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      associate (points => state%side(k))
        call smooth(contact, k, points, points%pressure &
                    - weight(contact, points)*points%multiplier, pressed(k))
        call smooth(contact, k, points, points%pressure, pressure(k))
      end associate
    end do
    do k = 1, 2
      if (contact%side(k)%rigid) then
        allocate (rise(k)%at(0))
        cycle
      end if
      associate (points => state%side(k))
        rise(k)%at = -points%multiplier
        w = weight(contact, points)
        do i = 1, size(rise(k)%at)
          call facing(contact, points, i, other, xi)
          if (other == 0) cycle
          e = (i - 1)/contact%nq + 1
          q = mod(i - 1, contact%nq) + 1
          d = value_at(contact, k, pressed(k), e, contact%xi(:, q))
          rise(k)%at(i) = d/w(i)
          if (contact%side(3 - k)%rigid) cycle
          d = 0.5_wp*(d + value_at(contact, 3 - k, pressed(3 - k), other, xi))
          p = value_at(contact, k, pressure(k), e, contact%xi(:, q)) &
              - value_at(contact, 3 - k, pressure(3 - k), other, xi)
          rise(k)%at(i) = (d - 0.5_wp*p)/w(i)
        end do
      end associate
    end do
  end subroutine find_rise

  !> Pressure on the current area of each point that its multiplier alone causes, relative to the
  !! multiplier. With PAIR, the pressure between a point and its partner acts on the reference area.
  pure function weight(contact, points) result(w)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    real(wp) :: w(size(points%multiplier))

    w = 1.0_wp
    if (.not. contact%on_pair) return
    where (points%bond > 0 .and. points%area > 0.0_wp) &
      w = points%share + (1.0_wp - points%share)*points%area0/points%area
  end function weight

  !> The place on the other side at which the normal law of point i mainly acts: its projection or,
  !! with PAIR, its partner.
  pure subroutine facing(contact, points, i, e, xi)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    integer, intent(out) :: e                !! element; 0: there is none
    real(wp), intent(out) :: xi(2)

    e = points%closest(i)
    xi = points%closest_xi(:, i)
    if (.not. contact%on_pair .or. points%bond(i) == 0) return
    if (points%share(i) > 0.5_wp) return
    e = points%bond(i)
    xi = points%bond_xi(:, i)
  end subroutine facing

  !> The largest pressure or multiplier of side k in the last iteration, with which increments are
  !! compared [F/L^2]. Multipliers are included because those of the previous step remain where a
  !! surface has opened and all pressures are zero. With MORTar, only control points count: the
  !! pressures of integration points are those of the last accepted step.
  pure real(wp) function largest_pressure(contact, k, state) result(most)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_state_t), intent(in) :: state

    if (contact%scheme == MORTAR) then
      associate (control => state%control(k))
        most = maxval([0.0_wp, control%pressure, control%multiplier])
      end associate
    else
      associate (points => state%side(k))
        most = maxval([0.0_wp, points%pressure, points%multiplier])
      end associate
    end if
  end function largest_pressure

  !> Smooth a value of all points of side k, whether in contact or not; the result is
  !! field%pressure.
  subroutine smooth(contact, k, points, value, field)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    real(wp), intent(in) :: value(:)   !! (np)
    type(smooth_t), intent(out) :: field
    type(contact_points_t) :: part

    part = points
    if (allocated(part%spread)) deallocate (part%spread)
    part%pressure = value
    part%state = TOUCH
    part%traction = 0.0_wp
    part%elastic = 0.0_wp
    call smooth_side(contact, k, part, field)
  end subroutine smooth

  !> Value at xi in element e of the smooth field of a side.
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

  !> Has AUGMent raised a multiplier of the contact?
  pure logical function is_augmented(state) result(yes)
    type(contact_state_t), intent(in) :: state
    integer :: k

    yes = any([(any(state%side(k)%multiplier > 0.0_wp), k=1, 2), &
               (any(state%control(k)%multiplier > 0.0_wp), k=1, 2)])
  end function is_augmented

  !> With AUGMent, let a penalty act at the control points too. The penalty at the integration
  !! points is not reduced: a control point whose support is larger than the contact area has a
  !! positive mean gap and therefore bears no load.
  pure subroutine share_penalty(contact)
    type(contact_t), intent(inout) :: contact

    if (contact%scheme /= MORTAR) return
    contact%control_penalty = max(contact%control_penalty, &
                                  AT_CONTROL_POINTS*contact%normal%prop(PENALTY))
  end subroutine share_penalty

  !> Add the increments, without letting any multiplier become negative.
  pure subroutine take_rise(contact, rise, k, state)
    type(contact_t), intent(in) :: contact
    type(rise_t), intent(in) :: rise
    integer, intent(in) :: k                 !! the side
    type(contact_state_t), intent(inout) :: state

    if (size(rise%at) == 0) return
    if (contact%scheme == MORTAR) then
      state%control(k)%multiplier = max(0.0_wp, state%control(k)%multiplier + rise%at)
    else
      state%side(k)%multiplier = max(0.0_wp, state%side(k)%multiplier + rise%at)
    end if
  end subroutine take_rise

end module contact_augment
