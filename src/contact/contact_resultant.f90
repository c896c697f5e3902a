!> Sums over the integration points of one side: resultants, area, points in contact.
!!
!! Force and moment are those of the nodal forces of the side. Where the points of the other side
!! load it too (BALAnced, or it is rigid) their forces act where they stand on it: moments of the
!! two sides differ by forces along the surface (friction, BORDer) times penetration then.
!!
!! Values of the quantities of contacts that a CURVe asks for.
!!
!! Tractions on side k act on side k: a body that is pressed down on another one is pushed up, and
!! what it lies on feels a negative z force. A rigid side has no points of its own: it shows what
!! the other side shows, with forces reversed where the points stand on it.
module contact_resultant
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use contact_history, only: side_positions
  use rigid_surface, only: split_force
  use contact_type, only: OPEN, STICK, SLIP
  use contact_work, only: own_share, position_at
  use tensor, only: cross
  use contact_smooth, only: smooth_t, smooth_side, largest_pressure, largest_tangential
  use curve_type, only: quantity_t, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
      Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
      Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED
  use model, only: model_t, state_t
  implicit none
  private
  public :: resultant_t, find_resultant, contact_value, side_resultant

  type :: resultant_t
    real(wp) :: force(3) = 0.0_wp        !! on this side [F]
    real(wp) :: moment(3) = 0.0_wp       !! of it, at current positions [F L]
    real(wp) :: force_size = 0.0_wp      !! int |t| da [F]
    real(wp) :: moment_size = 0.0_wp     !! int |(x - about) x t| da [F L]
    real(wp) :: area = 0.0_wp            !! in contact, current [L^2]
    real(wp) :: penetration = 0.0_wp     !! largest -gap of the points in contact [L]
    integer :: npoint = 0, nclosed = 0   !! points, and those in contact
    integer :: nstick = 0, nslip = 0
  end type resultant_t

contains

  !> Of side k. A rigid side has no points of its own: the sizes, areas and numbers of points are
  !! those of the other side.
  subroutine find_resultant(contact, k, points, x, about, total)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k                       !! side
    type(contact_points_t), intent(in) :: points(2) !! of both sides
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    real(wp), intent(in) :: about(3)               !! point of the moments [L]
    type(resultant_t), intent(out) :: total
    real(wp) :: force(3), moment(3), weight
    integer :: own

    own = merge(3 - k, k, contact%side(k)%rigid)
    call sum_points(contact, own, points(own), x, about, total)
    if (.not. (own /= k .or. contact%balanced)) return
    weight = own_share(contact)
    call sum_reversed(contact%side(k), points(3 - k), x, about, force, moment)
    if (own /= k) then
      total%force = -force
      total%moment = -moment
    else
      total%force = weight*(total%force - force)
      total%moment = weight*(total%moment - moment)
    end if
  end subroutine find_resultant

  !> Of the points of side k where they stand.
  subroutine sum_points(contact, k, points, x, about, total)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points   !! of side k
    real(wp), intent(in) :: x(:, :), about(3)
    type(resultant_t), intent(inout) :: total
    real(wp) :: xp(3, contact%nq), df(3), dm(3)
    integer :: e, i, q

    total%npoint = count(points%area > 0.0_wp)
    total%nclosed = count(points%state /= OPEN .and. points%area > 0.0_wp)
    total%nstick = count(points%state == STICK .and. points%area > 0.0_wp)
    total%nslip = count(points%state == SLIP .and. points%area > 0.0_wp)
    if (contact%side(k)%rigid) return
    do e = 1, contact%side(k)%nelem
      i = (e - 1)*contact%nq
      if (all(points%state(i + 1:i + contact%nq) == OPEN .and. &
              points%bond(i + 1:i + contact%nq) == 0)) cycle
      call side_positions(contact%side(k), e, x, xp)
      do q = 1, contact%nq
        i = (e - 1)*contact%nq + q
        if (points%state(i) == OPEN .and. points%bond(i) == 0) cycle
        df = points%traction(:, i)*points%area(i)
        dm = cross(xp(:, q) - about, df)
        total%force = total%force + df
        total%moment = total%moment + dm
        total%force_size = total%force_size + norm2(df)
        total%moment_size = total%moment_size + norm2(dm)
        if (points%state(i) == OPEN .or. .not. points%area(i) > 0.0_wp) cycle
        total%area = total%area + points%area(i)
        total%penetration = max(total%penetration, -points%gap(i))
      end do
    end do
  end subroutine sum_points

  !> Tractions of points, and their moment where they act on the other side.
  subroutine sum_reversed(other, points, x, about, force, moment)
    type(surface_t), intent(in) :: other           !! side that the points load
    type(contact_points_t), intent(in) :: points
    real(wp), intent(in) :: x(:, :), about(3)
    real(wp), intent(out) :: force(3), moment(3)
    real(wp) :: at_partner(3), at_foot(3)
    integer :: i

    force = 0.0_wp
    moment = 0.0_wp
    do i = 1, size(points%state)
      if (points%state(i) == OPEN .and. points%bond(i) == 0) cycle
      call split_force(points, i, at_partner, at_foot)
      force = force + points%traction(:, i)*points%area(i)
      if (points%bond(i) > 0) then
        moment = moment + cross(place(other, points%bond(i), points%bond_xi(:, i), x) - about, &
                                at_partner)
      end if
      if (points%state(i) == OPEN .or. points%foot(i) == 0) cycle
      moment = moment + cross(place(other, points%foot(i), points%foot_xi(:, i), x) - about, &
                              at_foot)
    end do
  end subroutine sum_reversed

  !> Position of a parametric point of element e.
  pure function place(surface, e, xi, x) result(at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)
    real(wp) :: at(3)
    real(wp) :: shp(surface%first(e + 1) - surface%first(e))
    real(wp) :: dshp(2, surface%first(e + 1) - surface%first(e))

    call position_at(surface, e, xi, x, shp, dshp, at)
  end function place

  !> One column.
  function contact_value(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    type(resultant_t) :: total

    if (any(quantity%id == [Q_CONTACT_PRESSURE, Q_CONTACT_TANGENTIAL])) then
      value = largest_value(model, state, quantity)
      return
    end if
    if (quantity%id == Q_CONTACT_DEBONDED) then
      value = debonded_share(model, state, quantity)
      return
    end if
    call side_resultant(model, state, quantity%contact, quantity%side, quantity%point, total)
    select case (quantity%id)
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
      if (quantity%id == Q_CONTACT_PRESSURE) then
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

end module contact_resultant
