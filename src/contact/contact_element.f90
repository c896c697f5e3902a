!> One surface element in contact: nodal forces and their derivatives against both surfaces.
module contact_element
  use base_kinds, only: wp
  use contact_foot, only: foot_t
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use contact_point, only: point_t, slope_t, traction_at
  use contact_kind, only: surface_functions_at, make_rational
  use contact_type, only: OPEN, SLIP
  implicit none
  private
  public :: work_t, new_work, form_element, touches, element_functions, measure

  !> Room for one element and the elements of the other side that its points see.
  type :: work_t
    integer :: nk = 0                          !! nodes of the element
    integer :: npartner = 0
    integer, allocatable :: partner(:)         !! elements of the other side
    real(wp), allocatable :: r(:, :)           !! (3, nk) force on the nodes, reversed [F]
    real(wp), allocatable :: kk(:, :)          !! (3*nk, 3*nk) dr/du of the own nodes [F/L]
    real(wp), allocatable :: kl(:, :, :)       !! (3*nk, 3*nl, npartner) and of the partners' nodes
    real(wp), allocatable :: own(:), down(:, :) !! own functions at a point
    real(wp), allocatable :: shp(:), dshp(:, :) !! the partner's
    real(wp), allocatable :: q(:, :, :)        !! (3, 3, n) columns of a point
  end type work_t

contains

  !> Room for side k of a contact.
  subroutine new_work(contact, k, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(work_t), intent(out) :: work
    integer :: mk, ml, m

    mk = maxval(contact%side(k)%kind%nsf)
    ml = maxval(contact%side(3 - k)%kind%nsf)
    m = max(mk, ml)
    allocate (work%partner(3*contact%nq), work%r(3, mk), work%kk(3*mk, 3*mk))
    allocate (work%kl(3*mk, 3*ml, 3*contact%nq), work%shp(m), work%dshp(2, m), work%own(m))
    allocate (work%down(2, m), work%q(3, 3, m))
  end subroutine new_work

  !> There is a foot, not deeper than allowed.
  pure logical function touches(contact, foot)
    type(contact_t), intent(in) :: contact
    type(foot_t), intent(in) :: foot

    touches = foot%elem > 0
    if (touches) touches = foot%gap >= -contact%depth
  end function touches

  !> Functions of element e of a surface at a point, weights included.
  pure subroutine element_functions(surface, e, xi, shp, dshp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: shp(:), dshp(:, :) !! (nsf), (2, nsf)

    call surface_functions_at(surface%kind(surface%ikind(e)), xi, shp, dshp)
    if (allocated(surface%w)) call make_rational(surface%w(surface%first(e): &
                                                           surface%first(e + 1) - 1), shp, dshp)
  end subroutine element_functions

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
    type(slope_t) :: dt
    real(wp) :: up(3, 2), da
    integer :: i, q

    associate (own => contact%side(k), other => contact%side(3 - k))
      work%nk = own%kind(own%ikind(e))%nsf
      work%npartner = 0
      do q = 1, contact%nq
        i = (e - 1)*contact%nq + q
        call measure(own, e, q, x, work, point%x, up, da)
        da = da*contact%wgt(q)
        call find_traction(contact, other, x, feet(q), slides, i, points, work, point, dt)
        points%gap(i) = feet(q)%gap
        points%state(i) = point%state
        points%pressure(i) = point%p
        points%traction(:, i) = point%t
        points%elastic(:, i) = point%elastic
        points%area(i) = da
        if (points%bond(i) > 0) call add_cohesion(contact, other, x, i, points, point%x, da, work)
        if (point%state == OPEN) cycle
        call clear(work)
        call add_own(point%t, dt%x, up, da, work)
        call add_partner(other, feet(q)%elem, feet(q)%xi, dt%p, dt%a, da, work)
        if (point%slides) call add_partner(other, points%slide(i), points%slide_xi(:, i), dt%s, &
                                           0.0_wp*dt%a, da, work)
      end do
    end associate
  end subroutine form_element

  !> Before the first point of an element that acts.
  pure subroutine clear(work)
    type(work_t), intent(inout) :: work

    if (work%npartner > 0) return
    work%r = 0.0_wp
    work%kk(:, :3*work%nk) = 0.0_wp
  end subroutine clear

  !> The cohesive law of a bonded point, on the reference area.
  pure subroutine add_cohesion(contact, other, x, i, points, at, da, work)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: x(:, :)
    integer, intent(in) :: i
    type(contact_points_t), intent(inout) :: points
    real(wp), intent(in) :: at(3), da          !! position [L] and current area [L^2] of the point
    type(work_t), intent(inout) :: work
    real(wp) :: g(3), t(3), dtdg(3, 3), nothing(3, 3, 2), partner(3)

    call clear(work)
    call position_on(other, points%bond(i), points%bond_xi(:, i), x, work, partner)
    g = at - partner
    points%opening(i) = norm2(g)
    points%worst(i) = points%worst_step(i)
    call contact%cohesive%cohesive(contact%cohesive_prop, g, points%worst(i), t, dtdg)
    if (da > 0.0_wp) points%traction(:, i) = points%traction(:, i) + t*(points%area0(i)/da)
    nothing = 0.0_wp
    call add_own(t, dtdg, nothing(:, 1, :), points%area0(i), work)
    call add_partner(other, points%bond(i), points%bond_xi(:, i), -dtdg, nothing, &
                     points%area0(i), work)
  end subroutine add_cohesion

  !> Position of a parametric point of a surface.
  pure subroutine position_on(surface, e, xi, x, work, at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: at(3)
    integer :: j, n

    n = surface%kind(surface%ikind(e))%nsf
    call element_functions(surface, e, xi, work%shp(:n), work%dshp(:, :n))
    at = 0.0_wp
    do j = 1, n
      at = at + work%shp(j)*x(:, surface%node(surface%first(e) + j - 1))
    end do
  end subroutine position_on

  !> Position of integration point q, contravariant tangents and area.
  pure subroutine measure(own, e, q, x, work, xq, up, area)
    type(surface_t), intent(in) :: own
    integer, intent(in) :: e, q
    real(wp), intent(in) :: x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: xq(3), up(3, 2), area
    real(wp) :: a(3, 2), n(3), m(2, 2)
    integer :: j

    associate (kind => own%kind(own%ikind(e)), node => own%node(own%first(e):own%first(e + 1) - 1))
      work%own(:kind%nsf) = kind%shp(:, q)
      work%down(:, :kind%nsf) = kind%dshp(:, :, q)
      if (allocated(own%w)) call make_rational(own%w(own%first(e):own%first(e + 1) - 1), &
                                               work%own(:kind%nsf), work%down(:, :kind%nsf))
      xq = 0.0_wp
      a = 0.0_wp
      do j = 1, kind%nsf
        xq = xq + work%own(j)*x(:, node(j))
        a(:, 1) = a(:, 1) + work%down(1, j)*x(:, node(j))
        a(:, 2) = a(:, 2) + work%down(2, j)*x(:, node(j))
      end do
    end associate
    n = [a(2, 1)*a(3, 2) - a(3, 1)*a(2, 2), a(3, 1)*a(1, 2) - a(1, 1)*a(3, 2), &
         a(1, 1)*a(2, 2) - a(2, 1)*a(1, 2)]
    area = norm2(n)
    m = matmul(transpose(a), a)
    up = 0.0_wp
    if (.not. area > 0.0_wp) return
    up(:, 1) = (m(2, 2)*a(:, 1) - m(1, 2)*a(:, 2))/area**2
    up(:, 2) = (m(1, 1)*a(:, 2) - m(1, 2)*a(:, 1))/area**2
  end subroutine measure

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
    type(slope_t), intent(out) :: dt
    integer :: e

    point%state = OPEN
    point%p = 0.0_wp
    point%t = 0.0_wp
    point%elastic = 0.0_wp
    if (.not. touches(contact, foot)) return
    point%multiplier = points%multiplier(i)
    e = points%slide(i)
    point%slides = slides .and. e > 0
    point%slipping = points%fresh .and. points%state_step(i) == SLIP
    if (point%slides) call position_on(other, e, points%slide_xi(:, i), x, work, point%xs)
    call traction_at(contact, foot, point, dt)
  end subroutine find_traction

  !> Force on the own nodes, its change with the point, and with the area the point stands for.
  pure subroutine add_own(t, dtdx, up, da, work)
    real(wp), intent(in) :: t(3), dtdx(3, 3), up(3, 2), da
    type(work_t), intent(inout) :: work
    real(wp) :: v(3)
    integer :: b, j, n

    n = work%nk
    do b = 1, n
      work%r(:, b) = work%r(:, b) - work%own(b)*da*t
      v = up(:, 1)*work%down(1, b) + up(:, 2)*work%down(2, b)
      do j = 1, 3
        work%q(:, j, b) = dtdx(:, j)*work%own(b) + t*v(j)
      end do
    end do
    call spread_rows(n, n, work%own, work%q, da, size(work%kk, 1), work%kk)
  end subroutine add_own

  !> Change with the nodes of an element of the other side, at a point of it.
  pure subroutine add_partner(other, e, xi, dtdx, dtda, da, work)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(in) :: dtdx(3, 3), dtda(3, 3, 2), da
    type(work_t), intent(inout) :: work
    integer :: b, n, slot

    do slot = 1, work%npartner
      if (work%partner(slot) == e) exit
    end do
    if (slot > work%npartner) then
      work%npartner = slot
      work%partner(slot) = e
      work%kl(:, :, slot) = 0.0_wp
    end if
    n = other%kind(other%ikind(e))%nsf
    call element_functions(other, e, xi, work%shp(:n), work%dshp(:, :n))
    do b = 1, n
      work%q(:, :, b) = dtdx*work%shp(b) + dtda(:, :, 1)*work%dshp(1, b) &
                        + dtda(:, :, 2)*work%dshp(2, b)
    end do
    call spread_rows(work%nk, n, work%own, work%q, da, size(work%kl, 1), work%kl(:, :, slot))
  end subroutine add_partner

  !> k(i a, j b) = k(i a, j b) - N_a q(i, j, b) da.
  pure subroutine spread_rows(na, nb, shp, q, da, ld, k)
    integer, intent(in) :: na, nb, ld
    real(wp), intent(in) :: shp(na), q(3, 3*nb), da
    real(wp), intent(inout) :: k(ld, 3*nb)
    real(wp) :: s(3*na)
    integer :: a, c, i

    do a = 1, na
      s(3*a - 2:3*a) = shp(a)*da
    end do
    do c = 1, 3*nb
      do a = 1, na
        do i = 1, 3
          k(3*(a - 1) + i, c) = k(3*(a - 1) + i, c) - s(3*(a - 1) + i)*q(i, c)
        end do
      end do
    end do
  end subroutine spread_rows

end module contact_element
