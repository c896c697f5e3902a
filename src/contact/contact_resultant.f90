!> Resultants of one side of a contact (force, moment, area and points in contact), and the values
!! of the contact quantities of a CURVe.
!!
!! The tractions of side k are those that act on side k: a body that is pressed down onto another
!! one is pushed up, and a negative z force acts on the other body. Force and moment are the
!! resultants of the nodal forces of the side. If the points of the other side load it too (with
!! BALAnced, or if it is rigid), their forces act at their projections and partners. The moments of
!! the two sides then differ by the forces along the surface (friction, BORDer) times the
!! penetration. A rigid side, or side 2 of self-contact, has no points of its own: its areas and
!! numbers of points are those of the other side.
module contact_resultant
  use base_kinds, only: wp
  use contact_history, only: side_positions
  use contact_pair, only: contact_t, contact_points_t, is_integrated, is_released, surface_t, MORTAR
  use contact_smooth, only: smooth_t, smooth_side, largest_pressure, largest_tangential
  use contact_type, only: OPEN, STICK, SLIP
  use contact_work, only: own_share, position_at
  use curve_type, only: quantity_t, Q_CONTACT_FORCE, Q_CONTACT_TORQUE, Q_CONTACT_PRESSURE, &
                        Q_CONTACT_TANGENTIAL, Q_CONTACT_STICK, Q_CONTACT_SLIP, Q_CONTACT_AREA, &
                        Q_CONTACT_PENETRATION, Q_CONTACT_DEBONDED
  use model, only: model_t, state_t
  use rigid_surface, only: split_force
  use tensor, only: cross
  implicit none
  private
  public :: resultant_t, find_resultant, contact_value, side_resultant

  type :: resultant_t
    real(wp) :: force(3) = 0.0_wp        !! force on this side [F]
    real(wp) :: moment(3) = 0.0_wp       !! moment about a given point, in the current state [F L]
    real(wp) :: force_size = 0.0_wp      !! int |t| da [F]
    real(wp) :: moment_size = 0.0_wp     !! int |(x - about) x t| da [F L]
    real(wp) :: area = 0.0_wp            !! current area in contact [L^2]
    real(wp) :: penetration = 0.0_wp     !! largest penetration of points and corners [L]
    integer :: npoint = 0, nclosed = 0   !! number of points, and of those in contact
    integer :: nstick = 0, nslip = 0
    !> The total of which `stick` and `slip` are parts: the number of points in contact or, with
    !! MORTar, the area in contact.
    real(wp) :: closed = 0.0_wp, stick = 0.0_wp, slip = 0.0_wp
  end type resultant_t

contains

  !> Find the resultant of side k of contact c of a model.
  subroutine side_resultant(model, state, c, k, about, total)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: c, k
    real(wp), intent(in) :: about(3)               !! point about which moments are taken [L]
    type(resultant_t), intent(out) :: total
    integer :: own

    call find_resultant(model%contact(c), k, state%contact(c)%side, model%mesh%xr + state%u, &
                        about, total)
    own = merge(k, 3 - k, is_integrated(model%contact(c), k))
    total%penetration = max(total%penetration, state%contact(c)%penetration(own))
    if (model%contact(c)%scheme /= MORTAR) return
    associate (contact => state%contact(c))
      total%force = contact%force(:, k)
      total%moment = contact%moment(:, k) - cross(about, contact%force(:, k))
      total%area = contact%area(own)
      total%penetration = contact%penetration(own)
      total%stick = contact%sticks(own)
      total%slip = contact%slips(own)
      total%closed = contact%area(own)
    end associate
  end subroutine side_resultant

  !> Find the resultant of side k.
  subroutine find_resultant(contact, k, points, x, about, total)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points(2) !! points of both sides
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    real(wp), intent(in) :: about(3)               !! point about which moments are taken [L]
    type(resultant_t), intent(out) :: total
    real(wp) :: force(3), moment(3), at_partner(3), at_projection(3), weight
    integer :: i, own

    own = merge(k, 3 - k, is_integrated(contact, k))
    call sum_points(contact, own, points(own), x, about, total)
    if (contact%scheme == MORTAR) return ! side_resultant sets the forces
    if (.not. (own /= k .or. contact%balanced)) return
    force = 0.0_wp ! forces of the points of the other side, at projections and partners
    moment = 0.0_wp
    associate (other => points(3 - k), side => contact%side(k))
      do i = 1, size(other%state)
        if (other%state(i) == OPEN .and. other%bond(i) == 0) cycle
        call split_force(other, i, at_partner, at_projection)
        force = force + other%traction(:, i)*other%area(i)
        if (other%bond(i) > 0) then
          moment = moment + cross(position_of(side, other%bond(i), other%bond_xi(:, i), x) &
                                  - about, at_partner)
        end if
        if (other%state(i) == OPEN .or. other%closest(i) == 0) cycle
        moment = moment + cross(position_of(side, other%closest(i), other%closest_xi(:, i), x) &
                                - about, at_projection)
      end do
    end associate
    if (own /= k) then
      total%force = -force
      total%moment = -moment
    else
      weight = own_share(contact)
      total%force = weight*(total%force - force)
      total%moment = weight*(total%moment - moment)
    end if
  end subroutine find_resultant

  !> Sum over the points of side k, whose tractions act at their own positions.
  subroutine sum_points(contact, k, points, x, about, total)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points   !! points of side k
    real(wp), intent(in) :: x(:, :), about(3)
    type(resultant_t), intent(inout) :: total
    real(wp) :: xp(3, contact%nq), df(3), dm(3)
    integer :: e, i, q

    total%npoint = count(points%area > 0.0_wp)
    total%nclosed = count(points%state /= OPEN .and. points%area > 0.0_wp)
    total%nstick = count(points%state == STICK .and. points%area > 0.0_wp)
    total%nslip = count(points%state == SLIP .and. points%area > 0.0_wp)
    total%closed = total%nclosed
    total%stick = total%nstick
    total%slip = total%nslip
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

  !> Position of the point xi of element e.
  pure function position_of(surface, e, xi, x) result(at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)
    real(wp) :: at(3)
    real(wp) :: shp(surface%first(e + 1) - surface%first(e))
    real(wp) :: dshp(2, surface%first(e + 1) - surface%first(e))

    call position_at(surface, e, xi, x, shp, dshp, at)
  end function position_of

  !> Value of a contact quantity of a CURVe.
  function contact_value(model, state, quantity) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(quantity_t), intent(in) :: quantity
    real(wp) :: value
    type(resultant_t) :: total
    type(smooth_t) :: field
    integer :: k

    associate (contact => model%contact(quantity%contact))
      k = quantity%side
      if (.not. is_integrated(contact, k)) k = 3 - k ! points and fields are those of the other side
      associate (points => state%contact(quantity%contact)%side(k), &
                 others => state%contact(quantity%contact)%side(3 - k))
        select case (quantity%id)
        case (Q_CONTACT_PRESSURE)
          call smooth_side(contact, k, points, field, others)
          value = largest_pressure(contact, k, field, quantity%component)
          return
        case (Q_CONTACT_TANGENTIAL)
          call smooth_side(contact, k, points, field, others)
          value = largest_tangential(contact, k, field, quantity%component)
          return
        case (Q_CONTACT_DEBONDED)
          value = released_fraction(contact, points)
          return
        case default             ! all other quantities need the sums over the points
        end select
      end associate
    end associate
    call side_resultant(model, state, quantity%contact, quantity%side, quantity%point, total)
    select case (quantity%id)
    case (Q_CONTACT_FORCE)
      value = total%force(quantity%component)
    case (Q_CONTACT_TORQUE)
      value = dot_product(total%moment, quantity%axis)
    case (Q_CONTACT_STICK)
      value = ratio(total%stick, total%closed)
    case (Q_CONTACT_SLIP)
      value = ratio(total%slip, total%closed)
    case (Q_CONTACT_AREA)
      value = total%area
    case (Q_CONTACT_PENETRATION)
      value = total%penetration
    case default
      value = 0.0_wp
    end select
  end function contact_value

  !> Fraction of the bonded area that is released.
  pure real(wp) function released_fraction(contact, points) result(value)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    real(wp) :: part
    integer :: i

    part = 0.0_wp
    do i = 1, size(points%bond)
      if (points%bond(i) == 0) cycle
      if (is_released(contact, points, i)) part = part + points%area0(i)
    end do
    value = ratio(part, sum(points%area0, mask=points%bond > 0))
  end function released_fraction

  !> Ratio part/whole; 0 if nothing is in contact or bonded.
  pure real(wp) function ratio(part, whole)
    real(wp), intent(in) :: part, whole

    ratio = 0.0_wp
    if (whole > 0.0_wp) ratio = part/whole
  end function ratio

end module contact_resultant
