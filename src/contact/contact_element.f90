!> One surface element in contact: nodal forces and their derivatives against both surfaces.
!!
!! BALAnced: the force of a point on the other surface, and its derivatives.
!!
!! The partner's nodes c feel M_c(xi) t da, M its functions. What varies is t, da, and at a foot xi:
!! dxi_a = h_a.(dx - dx_p) + sum_b c_ab g.da_b. A bond's xi is fixed.
module contact_element
  use base_kinds, only: wp
  use contact_bond, only: bond_traction_t, find_pull
  use subcell_quadrature, only: acting
  use edge_taper, only: fade_border
  use projection_type, only: foot_t, touches
  use contact_history, only: ASIDE
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use contact_point, only: point_t, traction_derivatives_t, traction_at, foot_way, outer
  use contact_type, only: OPEN, SLIP, TOUCH
  use contact_work, only: work_t, own_share, clear, add_own, add_partner, measure, position_on, &
      spread_rows
  implicit none
  private
  public :: form_element, add_back, add_cross

  !> Of DEPTh: with BORDer pressure falls from here on, and for points from beside too nothing is
  !! left here.
  real(wp), parameter :: DEEP = 0.25_wp, LAST = 0.9_wp
  real(wp), parameter :: FIXED_AREA(3, 2) = 0.0_wp !! the reference area does not change

contains

  !> Forces and derivatives of element e of side k; what its points found goes into their history.
  !! Where no point touches work%npartner is 0, and the rest of work means nothing.
  pure subroutine form_element(contact, k, e, x, feet, slides, points, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) current positions [L]
    type(foot_t), intent(in) :: feet(:)        !! (nq)
    logical, intent(in) :: slides              !! friction acts
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    type(point_t) :: point
    type(traction_derivatives_t) :: dt
    type(bond_traction_t) :: pull
    real(wp) :: up(3, 2), da, load
    integer :: act(2), i, q

    associate (own => contact%side(k), other => contact%side(3 - k))
      work%nk = own%basis(own%ibasis(e))%nsf
      work%npartner = 0
      act = acting(contact, points, e)
      do q = act(1), act(2)
        i = (e - 1)*contact%nq + q
        call measure(own, e, q, x, work, point%x, up, da)
        da = da*contact%wgt(q)
        call find_traction(contact, other, x, feet(q), slides, i, points, work, point, dt)
        pull = bond_traction_t()
        if (points%bond(i) > 0) call find_pull(contact, other, x, i, point%x, points, work, pull)
        if (.not. pull%share > 0.0_wp) point%state = OPEN
        call record(feet(q), i, point, pull, da, points)
        if (points%bond(i) > 0) call add_pull(contact, other, i, points, pull, work)
        if (point%state == OPEN) cycle
        call clear(work)
        load = da*own_share(contact)
        if (points%bond(i) > 0) call fade_foot(other, i, points, pull, point%t, load, dt, work)
        call add_own(pull%share*point%t, dt%x, up, load, work)
        call add_partner(other, feet(q)%elem, feet(q)%xi, dt%p, dt%a, load, work)
        if (contact%balanced) call add_back(other, feet(q)%elem, pull%share*point%t, load, work, &
                                            feet(q), point%x)
        if (.not. point%slides) cycle
        call add_partner(other, points%slide(i), points%slide_xi(:, i), dt%s, 0.0_wp*dt%a, load, &
                         work)
        if (contact%balanced) call add_cross(other, load, work)
      end do
    end associate
  end subroutine form_element

  !> Force of a bonded point and its change with both surfaces.
  pure subroutine add_pull(contact, other, i, points, pull, work)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    integer, intent(in) :: i
    type(contact_points_t), intent(in) :: points
    type(bond_traction_t), intent(in) :: pull
    type(work_t), intent(inout) :: work
    real(wp) :: load

    call clear(work)
    load = points%area0(i)*own_share(contact)
    call add_own(pull%t, pull%dtdg, FIXED_AREA, load, work)
    call add_partner(other, points%bond(i), points%bond_xi(:, i), -pull%dtdg, pull%dtda, load, &
                     work)
    if (contact%balanced) call add_back(other, points%bond(i), pull%t, load, work)
  end subroutine add_pull

  !> The traction t on the foot acts with a share that varies with the opening of the bond.
  pure subroutine fade_foot(other, i, points, pull, t, da, dt, work)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: i
    type(contact_points_t), intent(in) :: points
    type(bond_traction_t), intent(in) :: pull
    real(wp), intent(in) :: t(3), da           !! [F/L^2], [L^2]
    type(traction_derivatives_t), intent(inout) :: dt
    type(work_t), intent(inout) :: work
    real(wp) :: dtdg(3, 3)
    integer :: j

    if (.not. pull%share < 1.0_wp) return
    do j = 1, 3
      dtdg(:, j) = t*pull%slope(j)
    end do
    dt%x = pull%share*dt%x + dtdg
    dt%p = pull%share*dt%p
    dt%a = pull%share*dt%a
    dt%s = pull%share*dt%s
    call add_partner(other, points%bond(i), points%bond_xi(:, i), -dtdg, 0.0_wp*dt%a, da, work)
  end subroutine fade_foot

  !> What the laws found at a point: on the current area, whatever area they act on.
  pure subroutine record(foot, i, point, pull, da, points)
    type(foot_t), intent(in) :: foot
    integer, intent(in) :: i
    type(point_t), intent(in) :: point
    type(bond_traction_t), intent(in) :: pull           !! of a point that is not bonded: zero
    real(wp), intent(in) :: da                 !! current area [L^2]
    type(contact_points_t), intent(inout) :: points
    real(wp) :: ratio

    points%gap(i) = foot%gap
    points%state(i) = point%state
    points%pressure(i) = pull%share*point%p
    points%traction(:, i) = pull%share*point%t
    points%friction(:, i) = pull%share*point%friction
    points%cohesion(:, i) = pull%bond
    points%elastic(:, i) = point%elastic
    points%slip(i) = point%slip
    points%area(i) = da
    if (points%bond(i) == 0) return
    ratio = 0.0_wp
    if (da > 0.0_wp) ratio = points%area0(i)/da
    points%traction(:, i) = points%traction(:, i) + ratio*pull%t
    points%pressure(i) = points%pressure(i) + ratio*pull%p
    if (pull%share < 0.5_wp) points%gap(i) = pull%gap
    if (pull%p > 0.0_wp .and. point%state == OPEN) points%state(i) = TOUCH
  end subroutine record

  !> Traction at integration point i.
  pure subroutine find_traction(contact, other, x, foot, slides, i, points, work, point, dt)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: x(:, :)
    type(foot_t), intent(in) :: foot
    logical, intent(in) :: slides
    integer, intent(in) :: i
    type(contact_points_t), intent(in) :: points
    type(work_t), intent(inout) :: work
    type(point_t), intent(inout) :: point
    type(traction_derivatives_t), intent(out) :: dt
    integer :: e

    point%state = OPEN
    point%p = 0.0_wp
    point%t = 0.0_wp
    point%friction = 0.0_wp
    point%elastic = 0.0_wp
    point%slip = 0.0_wp
    if (.not. touches(foot, contact%depth)) return
    point%multiplier = points%multiplier(i)
    call limit_depth(contact, points%aside(i), point)
    e = points%slide(i)
    point%slides = slides .and. e > 0
    point%ahead = -1.0_wp
    if (points%fresh .and. points%state_step(i) == SLIP) then
      point%ahead = points%slip_rate(i)*points%dt
    end if
    if (point%slides) call position_on(other, e, points%slide_xi(:, i), x, work, point%xs)
    call traction_at(contact, foot, point, dt)
    if (point%state == OPEN .or. .not. contact%taper > 0.0_wp) return
    call fade_border(contact%taper, is_outer(other, foot%elem), foot, point, dt)
  end subroutine find_traction

  !> Of bonded surfaces: points from beside, and with BORDer those that a faded pressure did not
  !! stop, are not pressed out through the face. What is pressed only may plough.
  pure subroutine limit_depth(contact, beside, point)
    type(contact_t), intent(in) :: contact
    logical, intent(in) :: beside              !! it stood beside the surface
    type(point_t), intent(inout) :: point

    point%full = -1.0_wp
    if (.not. contact%cohesive%given) return
    point%last = LAST*contact%depth
    if (contact%taper > 0.0_wp) point%full = DEEP*contact%depth
    if (beside) point%full = ASIDE*contact%depth
  end subroutine limit_depth

  !> Edges of element e behind which the surface ends.
  pure function is_outer(surface, e) result(outside)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    logical :: outside(4)

    outside = surface%neighbour(:, e) == 0
    if (allocated(surface%point)) outside = outside .and. .not. surface%point(:, e)
  end function is_outer

  !> After add_own and add_partner were asked for the same traction at element e of the other side:
  !! their columns are used.
  pure subroutine add_back(other, e, t, da, work, foot, x)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: t(3)                 !! traction on the own side [F/L^2]
    real(wp), intent(in) :: da                   !! as of add_own
    type(work_t), intent(inout) :: work
    type(foot_t), intent(in), optional :: foot   !! where the force acts, if it moves on the surface
    real(wp), intent(in), optional :: x(3)       !! the point [L]
    integer :: b, n

    n = other%basis(other%ibasis(e))%nsf
    associate (slot => work%slot)
      do b = 1, n
        work%back(:, b, slot) = work%back(:, b, slot) + work%shp(b)*da*t
      end do
      call spread_rows(n, work%nk, work%shp, work%own_q, -da, size(work%lk, 1), &
                       work%lk(:, :, slot))
      call spread_rows(n, n, work%shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
      work%foot = slot
      work%foot_shp(:n) = work%shp(:n)
    end associate
    if (present(foot)) call move_foot(n, t, da, foot, x, work)
  end subroutine add_back

  !> The force that add_back put on the foot's element varies with the sliding point, for which
  !! add_partner was asked since.
  pure subroutine add_cross(other, da, work)
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: da
    type(work_t), intent(inout) :: work
    integer :: i

    associate (slot => work%foot, n => other%basis(other%ibasis(work%partner(work%foot)))%nsf, &
               m => other%basis(other%ibasis(work%partner(work%slot)))%nsf)
      if (work%slot == slot) then
        call spread_rows(n, m, work%foot_shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
        return
      end if
      do i = 1, work%ncross
        if (all(work%pair(:, i) == [slot, work%slot])) exit
      end do
      if (i > work%ncross) then
        work%ncross = i
        work%pair(:, i) = [slot, work%slot]
        work%cross(:, :, i) = 0.0_wp
      end if
      call spread_rows(n, m, work%foot_shp, work%q, -da, size(work%cross, 1), work%cross(:, :, i))
    end associate
  end subroutine add_cross

  !> The force moves with the foot: sum_a M_c,a t dxi_a da.
  pure subroutine move_foot(n, t, da, foot, x, work)
    integer, intent(in) :: n
    real(wp), intent(in) :: t(3), da, x(3)
    type(foot_t), intent(in) :: foot
    type(work_t), intent(inout) :: work
    real(wp) :: h(3, 2), c(2, 2), g(3), q(3, 3, size(work%shp)), slope(n)
    integer :: a, b

    call foot_way(foot, x, h, c, g)
    do a = 1, 2
      slope = work%dshp(a, :n)
      do b = 1, work%nk
        q(:, :, b) = outer(t, work%own(b)*h(:, a))
      end do
      call spread_rows(n, work%nk, slope, q, -da, size(work%lk, 1), work%lk(:, :, work%slot))
      do b = 1, n
        q(:, :, b) = outer(t, (c(a, 1)*work%dshp(1, b) + c(a, 2)*work%dshp(2, b))*g &
                           - work%shp(b)*h(:, a))
      end do
      call spread_rows(n, n, slope, q, -da, size(work%ll, 1), work%ll(:, :, work%slot))
    end do
  end subroutine move_foot

end module contact_element
