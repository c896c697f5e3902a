!> One surface element in contact: nodal forces and their derivatives with respect to both surfaces.
module contact_element
  use base_kinds, only: wp
  use contact_bond, only: bond_traction_t, find_bond_traction
  use contact_history, only: BESIDE
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use contact_point, only: point_t, traction_derivatives_t, traction_at, outer
  use contact_type, only: MU, OPEN, SLIP, TOUCH
  use contact_work, only: work_t, own_share, clear, add_own, add_partner, add_back, add_cross, &
                          measure, sliding_position
  use edge_taper, only: taper_edge
  use projection_type, only: foot_t, touches
  use subcell_quadrature, only: acting
  implicit none
  private
  public :: form_element

  !> Fractions of DEPTh, used in contacts with bonds. With BORDer, the pressure decreases beyond the
  !! depth DEEP. With BORDer, and at points that entered over the boundary, there is no traction
  !! beyond the depth LAST.
  real(wp), parameter :: DEEP = 0.25_wp, LAST = 0.9_wp
  real(wp), parameter :: FIXED_AREA(3, 2) = 0.0_wp !! the reference area does not change

contains

  !> Find forces and derivatives of element e of side k, and store the results of its points in
  !! their history. If no point is in contact or bonded, work%npartner is 0 and the rest of `work`
  !! is undefined.
  pure subroutine form_element(contact, k, e, x, feet, slides, points, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) current positions [L]
    type(foot_t), intent(in) :: feet(:)        !! (nq) projections
    logical, intent(in) :: slides              !! friction acts
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    type(point_t) :: point
    type(traction_derivatives_t) :: dt
    type(bond_traction_t) :: bond
    real(wp) :: up(3, 2), da, load, dtdg(3, 3), dtda(3, 3, 2)
    integer :: act(2), i, j, q

    associate (own => contact%side(k), other => contact%side(3 - k))
      work%nk = own%basis(own%ibasis(e))%nsf
      work%npartner = 0
      act = acting(contact, points, e)
      do q = act(1), act(2)
        i = (e - 1)*contact%nq + q
        call measure(own, e, q, x, work, point%x, up, da)
        da = da*contact%wgt(q)
        call find_traction(contact, other, x, feet(q), slides, i, points, work, point, dt)
        bond = bond_traction_t()
        if (points%bond(i) > 0) call find_bond_traction(contact, other, x, i, point%x, points, &
                                                        work, bond)
        if (.not. bond%share > 0.0_wp) then ! the normal law and the friction law do not act here
          point%state = OPEN
          point%elastic = 0.0_wp
        end if
        call record(contact, feet(q), i, point, bond, da, points)

        if (points%bond(i) > 0) then
          call clear(work)
          load = points%area0(i)*own_share(contact)
          call add_own(bond%t, bond%dtdg, FIXED_AREA, load, work)
          call add_partner(other, points%bond(i), points%bond_xi(:, i), -bond%dtdg, bond%dtda, &
                           load, work)
          if (contact%balanced) call add_back(other, points%bond(i), bond%t, load, work)
        end if

        if (point%state == OPEN) cycle
        call clear(work)
        load = da*own_share(contact)
        if (points%bond(i) > 0 .and. bond%share < 1.0_wp) then ! the share varies with the opening
          do j = 1, 3
            dtdg(:, j) = point%t*bond%slope(j)
          end do
          do j = 1, 2
            dtda(:, :, j) = outer(point%t, bond%tilt(:, j))
          end do
          dt%x = bond%share*dt%x + dtdg
          dt%p = bond%share*dt%p
          dt%a = bond%share*dt%a
          dt%s = bond%share*dt%s
          call add_partner(other, points%bond(i), points%bond_xi(:, i), -dtdg, dtda, load, work)
        end if
        call add_own(bond%share*point%t, dt%x, up, load, work)
        call add_partner(other, feet(q)%elem, feet(q)%xi, dt%p, dt%a, load, work)
        if (contact%balanced) call add_back(other, feet(q)%elem, bond%share*point%t, load, work, &
                                            feet(q), point%x)
        if (.not. point%slides) cycle
        call add_partner(other, points%slide(i), points%slide_xi(:, i), dt%s, 0.0_wp*dt%a, load, &
                         work)
        if (contact%balanced) call add_cross(other, load, work)
      end do
    end associate
  end subroutine form_element

  !> Find the traction at integration point i from its projection.
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
    logical :: outside(4)
    integer :: e

    point%state = OPEN
    point%p = 0.0_wp
    point%t = 0.0_wp
    point%friction = 0.0_wp
    point%elastic = 0.0_wp
    point%slip = 0.0_wp
    point%energy = 0.0_wp
    point%rest = 0.0_wp
    if (.not. touches(foot, contact%depth)) return
    point%multiplier = points%multiplier(i)
    ! On bonded surfaces, some points are not pushed out through the face: points that entered over
    ! the boundary, and points that a tapered pressure did not stop. Surfaces without bonds may
    ! indent each other deeply.
    point%full = -1.0_wp
    if (contact%cohesive%given) then
      point%last = LAST*contact%depth
      if (contact%taper > 0.0_wp) point%full = DEEP*contact%depth
      if (points%beside(i)) point%full = BESIDE*contact%depth
    end if
    e = points%slide(i)
    point%slides = slides .and. e > 0
    point%ahead = -1.0_wp
    if (points%new_step .and. points%state_step(i) == SLIP) then
      point%ahead = points%slip_rate(i)*points%dt
    end if
    if (point%slides) call sliding_position(other, e, points%slide_xi(:, i), x, work, point%xs)
    call traction_at(contact, foot, work%secant, point, dt)
    if (point%state == OPEN .or. .not. contact%taper > 0.0_wp) return
    outside = other%neighbour(:, foot%elem) == 0
    if (allocated(other%point)) outside = outside .and. .not. other%point(:, foot%elem)
    call taper_edge(contact%taper, outside, foot, point, dt)
  end subroutine find_traction

  !> Record the results of the laws at a point. Tractions are recorded per current area, whichever
  !! area the laws refer to.
  pure subroutine record(contact, foot, i, point, bond, da, points)
    type(contact_t), intent(in) :: contact
    type(foot_t), intent(in) :: foot
    integer, intent(in) :: i
    type(point_t), intent(in) :: point
    type(bond_traction_t), intent(in) :: bond  !! zero at a point that is not bonded
    real(wp), intent(in) :: da                 !! current area [L^2]
    type(contact_points_t), intent(inout) :: points
    real(wp) :: ratio

    points%gap(i) = foot%gap
    points%state(i) = point%state
    points%pressure(i) = bond%share*point%p
    points%traction(:, i) = bond%share*point%t
    points%friction(:, i) = bond%share*point%friction
    points%normal(:, i) = bond%share*(point%t - point%friction)
    points%elastic(:, i) = point%elastic
    points%slip(i) = point%slip
    points%area(i) = da
    points%pressed(i) = da*bond%share*(point%energy - point%rest)
    points%limit(i) = 0.0_wp
    if (contact%friction%given) points%limit(i) = contact%friction%prop(MU)*bond%share &
                                                  *max(0.0_wp, point%p)
    if (points%bond(i) == 0) return
    points%share(i) = bond%share
    points%pressed(i) = points%pressed(i) + points%area0(i)*bond%energy
    ratio = 0.0_wp
    if (da > 0.0_wp) ratio = points%area0(i)/da
    points%traction(:, i) = points%traction(:, i) + ratio*bond%t
    points%normal(:, i) = points%normal(:, i) + ratio*bond%normal
    points%pressure(i) = points%pressure(i) + ratio*bond%p
    if (bond%share < 0.5_wp) points%gap(i) = bond%gap
    if (bond%p > 0.0_wp .and. point%state == OPEN) points%state(i) = TOUCH
  end subroutine record

end module contact_element
