!> Bonds: which points are bonded to which partners, and the tractions between them.
!!
!! The partner of a point is its projection in the reference configuration, eq. (30) of Corbett and
!! Sauer 2015. The cohesive law and, with PAIR, the penalty act between the point and its partner.
!!
!! g is the vector from the partner x_p = x_l(xi_0) to the point x, and n is the outward unit normal
!! of side l at xi_0. Both surfaces move while xi_0 is constant, so that, with the tangents a_1 and
!! a_2 at the partner and the dual tangents a^1 and a^2,
!!
!!   dg = dx - dx_p,    dn = -sum_j a^j (n . da_j).
!!
!! All tractions act on the reference area.
module contact_bond
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, bond_t, is_released, &
                          release_of, surface_t
  use contact_point, only: energy_at_rest, outer
  use contact_type, only: cohesion_t, LARGEST_OPENINGS, LAST_OPENINGS, MAX_PAST
  use contact_work, only: work_t, new_work, measure, position_on, tangents_on
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces, update_grid
  use projection_type, only: foot_t, shape_t
  use smooth_step, only: smoothstep
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: find_bonds, find_unbonded, find_opened_bonds, find_strength, find_broken_bonds, &
            moves_bonds, released_force, bond_traction_t, find_bond_traction, needs_projection

  !> Default of GAP, relative to the size of an element.
  real(wp), parameter, public :: CLOSE_BY = 1.0e-3_wp
  !> Points that are not farther than this from the other side count as lying on it, relative to the
  !! width of an element: some points of curved surfaces of flat elements that touch are that far
  !! apart.
  real(wp), parameter, public :: NEXT_TO = 0.05_wp
  !> Traction that counts as almost nothing, relative to the largest one.
  real(wp), parameter :: ALMOST_NOTHING = 0.1_wp
  real(wp), parameter :: NEARLY = 1.0e-6_wp   !! relative tolerance of openings and positions
  real(wp), parameter :: VISIBLE = 0.01_wp    !! change of a release (release_of) that counts
  integer, parameter :: SAMPLES = 500         !! number of openings at which a traction is sampled

  !> Traction of a bonded point per reference area, and its derivatives.
  type :: bond_traction_t
    real(wp) :: t(3) = 0.0_wp          !! [F/L^2]
    real(wp) :: dtdg(3, 3) = 0.0_wp    !! dt/dg [F/L^3]
    real(wp) :: dtda(3, 3, 2) = 0.0_wp !! dt/da_j with the tangents a_j of l at the partner
    real(wp) :: p = 0.0_wp             !! pressure of the penalty [F/L^2]
    real(wp) :: normal(3) = 0.0_wp     !! traction of this pressure, a part of t [F/L^2]
    real(wp) :: energy = 0.0_wp        !! energy of this pressure [F/L]
    real(wp) :: gap = 0.0_wp           !! n . g [L]
    !> Weight of the normal law and of the friction law at the current projection.
    real(wp) :: share = 1.0_wp
    real(wp) :: slope(3) = 0.0_wp      !! dshare/dg [1/L]
    real(wp) :: tilt(3, 2) = 0.0_wp    !! dshare/da_j [1/L]
  end type bond_traction_t

contains

  !> If the contact has a cohesive law, find the bonded points of the sides that are not rigid,
  !! their partners, their histories at the start, and the reference areas of all points of these
  !! sides.
  subroutine find_bonds(contact, xr, state)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)       !! (3, nnode) reference positions [L]
    type(contact_state_t), intent(inout) :: state
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(work_t) :: work
    type(foot_t) :: foot
    real(wp) :: x(3, contact%nq), up(3, 2), near, width
    integer :: e, i, k, q

    if (.not. contact%cohesive%given) return
    do k = 1, 2
      call update_shape(contact%side(k), xr, shape(k))
      call update_grid(contact%side(k), shape(k), grid(k))
    end do
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      call new_work(contact, k, work)
      associate (points => state%side(k))
        do e = 1, contact%side(k)%nelem
          i = (e - 1)*contact%nq
          do q = 1, contact%nq
            call measure(contact%side(k), e, q, xr, work, x(:, q), up, points%area0(i + q))
            points%area0(i + q) = points%area0(i + q)*contact%wgt(q)
          end do
          width = sqrt(sum(points%area0(i + 1:i + contact%nq)))
          near = contact%bond_gap
          if (near < 0.0_wp) near = CLOSE_BY*width
          near = near + NEARLY*width ! rounding must not decide where GAP is the distance itself
          do q = 1, contact%nq
            if (.not. is_inside(contact%bond, x(:, q), NEARLY*width)) cycle
            foot%elem = 0
            call project(contact%side(3 - k), shape(3 - k), grid(3 - k), x(:, q), foot, near)
            if (foot%elem == 0 .or. abs(foot%gap) > near) cycle
            points%bond(i + q) = foot%elem
            points%bond_xi(:, i + q) = foot%xi
            call start_bond(contact, contact%side(3 - k), xr, i + q, x(:, q), points, work)
          end do
        end do
      end associate
    end do
  end subroutine find_bonds

  !> Find the points in the regions of BONDed that have no bond although they lie opposite the other
  !! side, and hardly farther apart than bonded points.
  subroutine find_unbonded(contact, xr, state, part, widest)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)           !! (3, nnode) [L]
    type(contact_state_t), intent(in) :: state !! after find_bonds
    real(wp), intent(out) :: part    !! their area, as a fraction of this and the bonded area [-]
    real(wp), intent(out) :: widest            !! largest distance [L]; 0 if there are none
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp) :: a(3, 2), b(3, 3), x(3), bonded, unbonded, width
    integer :: e, i, k, q

    call place_surfaces(contact, xr, shape, grid)
    bonded = 0.0_wp
    unbonded = 0.0_wp
    widest = 0.0_wp
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      associate (points => state%side(k))
        bonded = bonded + sum(points%area0, mask=points%bond > 0)
        do e = 1, contact%side(k)%nelem
          i = (e - 1)*contact%nq
          width = sqrt(sum(points%area0(i + 1:i + contact%nq)))
          do q = 1, contact%nq
            if (points%bond(i + q) > 0) cycle
            call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), x, a, b)
            if (.not. is_inside(contact%bond, x, NEARLY*width)) cycle
            foot%elem = 0
            call project(contact%side(3 - k), shape(3 - k), grid(3 - k), x, foot, NEXT_TO*width)
            if (foot%elem == 0 .or. abs(foot%gap) > NEXT_TO*width) cycle
            if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp) cycle
            unbonded = unbonded + points%area0(i + q)
            widest = max(widest, abs(foot%gap))
          end do
        end do
      end associate
    end do
    part = 0.0_wp
    if (unbonded > 0.0_wp) part = unbonded/(bonded + unbonded)
  end subroutine find_unbonded

  !> Set the history of bonded point i to that of a bond that was opened up to the initial gap. The
  !! damage of this opening did not arise in the first step, so VISCous does not resist it.
  pure subroutine start_bond(contact, other, xr, i, at, points, work)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: xr(:, :)       !! (3, nnode) reference positions [L]
    integer, intent(in) :: i
    real(wp), intent(in) :: at(3)          !! reference position of the point [L]
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    type(cohesion_t) :: c
    real(wp) :: g(3), n(3), up(3, 2)

    call pull_bond(contact, other, xr, i, at, 0.0_wp, points, work, g, n, up, c)
    points%past_step(:, i) = points%past(:, i)
    points%opening_step(i) = points%opening(i)
  end subroutine start_bond

  !> Find the bonded points whose initial gap is open (positive) and so large that the traction of
  !! the bond no longer increases with the opening. Such bonds soften, or are broken, before
  !! anything has moved.
  subroutine find_opened_bonds(contact, xr, state, n, widest, strongest)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)          !! (3, nnode) [L]
    type(contact_state_t), intent(in) :: state !! after find_bonds
    integer, intent(out) :: n                 !! number of these points
    real(wp), intent(out) :: widest           !! largest initial gap of these points [L]
    real(wp), intent(out) :: strongest        !! opening with the largest traction [L]; 0 if n = 0
    type(work_t) :: work
    real(wp) :: x(3), up(3, 2), area, partner(3), normal(3), low
    integer :: e, i, k, q

    n = 0
    widest = 0.0_wp
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      call new_work(contact, k, work)
      associate (points => state%side(k), other => contact%side(3 - k))
        do e = 1, contact%side(k)%nelem
          do q = 1, contact%nq
            i = (e - 1)*contact%nq + q
            if (points%bond(i) == 0) cycle
            call measure(contact%side(k), e, q, xr, work, x, up, area)
            call position_on(other, points%bond(i), points%bond_xi(:, i), xr, work, partner)
            call tangents_on(other, points%bond(i), xr, work, normal, up)
            if (.not. dot_product(x - partner, normal) > 0.0_wp) cycle
            if (stiffens(contact, norm2(x - partner))) cycle
            n = n + 1
            widest = max(widest, norm2(x - partner))
          end do
        end do
      end associate
    end do
    low = 0.0_wp
    strongest = widest
    do while (strongest - low > NEARLY*strongest)
      if (stiffens(contact, 0.5_wp*(low + strongest))) then
        low = 0.5_wp*(low + strongest)
      else
        strongest = 0.5_wp*(low + strongest)
      end if
    end do
  end subroutine find_opened_bonds

  !> Find the strength of a bond: the magnitude of the largest tractions of both modes.
  subroutine find_strength(contact)
    type(contact_t), intent(inout) :: contact
    real(wp), parameter :: MODE(2, 2) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
    real(wp) :: largest(2)
    integer :: i, j

    do j = 1, 2
      largest(j) = maxval([(traction_at_opening(contact, MODE(:, j)*contact%released*i/SAMPLES), &
                            i=1, SAMPLES)])
    end do
    contact%strength = norm2(largest)
  end subroutine find_strength

  !> Traction of a bond, without VISCous, at the largest openings of its history.
  pure real(wp) function traction_at_opening(contact, opening) result(t)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: opening(2)     !! normal and shear, or the whole opening and 0 [L]
    real(wp), parameter :: N(3) = [0.0_wp, 0.0_wp, 1.0_wp]
    real(wp) :: past(MAX_PAST), now(MAX_PAST)
    type(cohesion_t) :: c

    past = 0.0_wp
    past(LAST_OPENINGS) = opening          ! there is no work to integrate
    call contact%cohesive%law%cohesive(contact%cohesive%prop, 0.0_wp, &
                                       [opening(2), 0.0_wp, opening(1)], N, past, now, c)
    t = norm2(c%t)
  end function traction_at_opening

  !> Find the fraction of the bonded area whose bonds have broken in the current step although their
  !! traction was still increasing before it. The step must not have been accepted yet.
  pure real(wp) function find_broken_bonds(contact, state) result(part)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp) :: area
    integer :: i, k

    area = 0.0_wp
    part = 0.0_wp
    do k = 1, 2
      associate (points => state%side(k))
        do i = 1, size(points%bond)
          if (points%bond(i) == 0) cycle
          area = area + points%area0(i)
          if (breaks(contact, points%past_step(LARGEST_OPENINGS, i), &
                     points%past(LARGEST_OPENINGS, i))) part = part + points%area0(i)
        end do
      end associate
    end do
    if (area > 0.0_wp) part = part/area
  end function find_broken_bonds

  !> Does the traction of a bond first increase and then fall to almost nothing while its largest
  !! openings grow along a straight line? The traction is sampled as far as the bond is released.
  pure logical function breaks(contact, before, after)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: before(2), after(2) !! largest openings [L]
    real(wp) :: left, peak, way, start, further(2)
    integer :: i

    breaks = .false.
    way = release_of(contact, after - before)
    if (.not. way > 0.0_wp) return
    left = traction_at_opening(contact, after)
    if (left > ALMOST_NOTHING*contact%strength) return
    further = after + (after - before)/SAMPLES
    if (traction_at_opening(contact, further) > left) return ! the bond has not reached its peak
    way = min(1.0_wp, 2/way) ! openings cannot decrease, so the bond is released at 2 at the latest
    start = traction_at_opening(contact, before)
    peak = traction_at_opening(contact, before + way/SAMPLES*(after - before))
    if (.not. peak > start) return ! the bond was beyond its peak, like most bonds in most steps
    do i = 2, SAMPLES
      peak = max(peak, traction_at_opening(contact, before + way*i/SAMPLES*(after - before)))
    end do
    breaks = left <= ALMOST_NOTHING*peak
  end function breaks

  !> Does the current step, which is not accepted yet, open or close bonds so far that VISCous would
  !! resist?
  pure logical function moves_bonds(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    integer :: i, k

    moves_bonds = .false.
    do k = 1, 2
      associate (points => state%side(k))
        do i = 1, size(points%bond)
          if (points%bond(i) == 0) cycle
          moves_bonds = abs(release_of(contact, points%past(LARGEST_OPENINGS, i)) &
                            - release_of(contact, points%past_step(LARGEST_OPENINGS, i))) > VISIBLE
          if (moves_bonds) return
        end do
      end associate
    end do
  end function moves_bonds

  !> The largest force that a bonded point could bear before its bond was released [F]; 0: no bond
  !! is released.
  pure real(wp) function released_force(contact, state) result(force)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    integer :: i, k

    force = 0.0_wp
    if (.not. contact%cohesive%given) return
    do k = 1, 2
      associate (points => state%side(k))
        do i = 1, size(points%bond)
          if (points%bond(i) == 0) cycle
          if (is_released(contact, points, i)) force = max(force, contact%strength*points%area0(i))
        end do
      end associate
    end do
  end function released_force

  !> Does the traction of a bond still increase at the given normal opening?
  logical function stiffens(contact, opening)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: opening           !! [L]
    real(wp), parameter :: N(3) = [0.0_wp, 0.0_wp, 1.0_wp]
    real(wp) :: past(MAX_PAST), now(MAX_PAST)
    type(cohesion_t) :: c

    past = 0.0_wp
    call contact%cohesive%law%cohesive(contact%cohesive%prop, 0.0_wp, opening*N, N, past, now, c)
    stiffens = c%dtdg(3, 3) < 0.0_wp
  end function stiffens

  !> Does a reference point lie in all regions of BONDed, and in none of the excepted ones? The
  !! points of a face that lies in the boundary of a region are inside it.
  pure logical function is_inside(bond, x, rounding)
    type(bond_t), intent(in) :: bond(:)
    real(wp), intent(in) :: x(3)
    real(wp), intent(in) :: rounding       !! distance from a region that is due to rounding [L]
    integer :: i
    logical :: in

    is_inside = .true.
    do i = 1, size(bond)
      if (bond(i)%is_box) then
        in = all(x >= bond(i)%a - rounding .and. x <= bond(i)%b + rounding)
      else
        in = dot_product(x - bond(i)%a, bond(i)%b) >= -rounding
      end if
      is_inside = is_inside .and. (in .neqv. bond(i)%is_except)
    end do
  end function is_inside

  !> Find the traction that the cohesive law and the penalty exert on bonded point i at the position
  !! `at`.
  pure subroutine find_bond_traction(contact, other, x, i, at, points, work, bond)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) current positions [L]
    integer, intent(in) :: i
    real(wp), intent(in) :: at(3)              !! [L]
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    type(bond_traction_t), intent(out) :: bond
    type(cohesion_t) :: c
    real(wp) :: g(3), n(3), up(3, 2), lag, p, dp, energy, hold, r, rate, z, past
    real(wp) :: depth, normal, shear(3), now
    integer :: j

    lag = 0.0_wp
    if (points%dt > 0.0_wp) lag = contact%cohesive%tau/points%dt
    call pull_bond(contact, other, x, i, at, lag, points, work, g, n, up, c)
    bond%t = c%t
    bond%dtdg = c%dtdg
    if (contact%cohesive%law%oriented) then
      do j = 1, 2
        bond%dtda(:, :, j) = -outer(matmul(c%dtdn, up(:, j)), n)
      end do
    end if
    points%energy(:, i) = [c%stored, c%spent, c%viscous]
    points%bond_traction(:, i) = bond%t
    if (.not. contact%on_pair) return

    ! The penalty acts along the partner's normal until the bond has opened by half of the opening
    ! at which it is released. From there to the full opening, the penalty at the current projection
    ! gradually replaces it. If points load both surfaces, the opening at the start of the step is
    ! used, because the elements of the partner and of the projection are not coupled. A damaged
    ! bond that closes keeps the share of its largest opening, because it does not heal. Its
    ! penetration is not an opening, as in the laws with damage. r is the opening as a fraction of
    ! the opening at which the bond is released (release_of).
    bond%gap = dot_product(n, g)
    depth = 0.0_wp
    if (.not. contact%cohesive%law%heals) depth = min(0.0_wp, bond%gap)
    normal = bond%gap - depth
    shear = g - bond%gap*n
    now = release_of(contact, [normal, norm2(shear)])
    past = release_before(contact, points, i)
    r = past
    if (.not. contact%balanced) r = max(now, past)
    z = min(1.0_wp, max(0.0_wp, 2*r - 1.0_wp))
    bond%share = smoothstep(z)
    if (z > 0.0_wp .and. now > past .and. .not. contact%balanced) then
      rate = 12*z*(1.0_wp - z)/r
      associate (s => contact%released)
        bond%slope = rate*(normal/s(1)**2*n + shear/s(2)**2)
        do j = 1, 2
          bond%tilt(:, j) = rate*(bond%gap/s(2)**2 - normal/s(1)**2)*dot_product(g, up(:, j))*n
        end do
      end associate
    end if
    hold = 1.0_wp - bond%share
    call contact%normal%law%normal(contact%normal%prop, bond%gap, points%multiplier(i), p, dp, &
                                   energy)
    bond%energy = hold*(energy - energy_at_rest(contact%normal, points%multiplier(i)))
    if (.not. hold*p > 0.0_wp) return
    bond%p = hold*p
    bond%normal = bond%p*n
    bond%t = bond%t + bond%normal
    bond%dtdg = bond%dtdg + outer(n, hold*dp*n - p*bond%slope)
    do j = 1, 2
      bond%dtda(:, :, j) = bond%dtda(:, :, j) &
                           - hold*outer(p*up(:, j) + dp*dot_product(g, up(:, j))*n, n) &
                           - outer(p*n, bond%tilt(:, j))
    end do
    points%bond_traction(:, i) = bond%t
  end subroutine find_bond_traction

  !> Find the traction of the cohesive law at bonded point i, and update its history and opening.
  pure subroutine pull_bond(contact, other, x, i, at, lag, points, work, g, n, up, c)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) positions [L]
    integer, intent(in) :: i
    real(wp), intent(in) :: at(3)              !! [L]
    real(wp), intent(in) :: lag                !! tau/dt of VISCous [-]
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: g(3)              !! vector from the partner to the point [L]
    !> Unit normal and dual tangents at the partner [-], [1/L]; zero if neither the law nor the
    !! penalty needs them.
    real(wp), intent(out) :: n(3), up(3, 2)
    type(cohesion_t), intent(out) :: c
    real(wp) :: partner(3)

    call position_on(other, points%bond(i), points%bond_xi(:, i), x, work, partner)
    g = at - partner
    n = 0.0_wp
    up = 0.0_wp
    associate (cohesive => contact%cohesive)
      if (cohesive%law%oriented .or. contact%on_pair) call tangents_on(other, points%bond(i), x, &
                                                                       work, n, up)
      call cohesive%law%cohesive(cohesive%prop, lag, g, n, points%past_step(:, i), &
                                 points%past(:, i), c)
    end associate
    points%opening(i) = norm2(g)
  end subroutine pull_bond

  !> Does the contact law act at the projection of bonded point i if the point is at the position
  !! `at`?
  pure subroutine needs_projection(contact, other, x, i, at, points, work, needed)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) current positions [L]
    integer, intent(in) :: i
    real(wp), intent(in) :: at(3)              !! [L]
    type(contact_points_t), intent(in) :: points
    type(work_t), intent(inout) :: work
    logical, intent(out) :: needed
    real(wp) :: partner(3)

    needed = .true.
    if (.not. contact%on_pair) return
    call position_on(other, points%bond(i), points%bond_xi(:, i), x, work, partner)
    if (contact%balanced) then
      needed = 2*release_before(contact, points, i) > 1.0_wp
    else ! an upper bound of the release, since the normal at the partner is not known
      needed = 2*max(norm2(at - partner)/minval(contact%released), &
                     release_before(contact, points, i)) > 1.0_wp - NEARLY
    end if
  end subroutine needs_projection

  !> Release (release_of) of bonded point i before the current step that decides how much of the
  !! penalty still acts between the point and its partner: the largest one if the law has damage.
  !! With a reversible law it is the last one if points load both surfaces; otherwise it does not
  !! matter.
  pure real(wp) function release_before(contact, points, i) result(release)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i

    release = 0.0_wp
    if (.not. contact%cohesive%law%heals) then
      release = release_of(contact, points%past_step(LARGEST_OPENINGS, i))
    else if (contact%balanced) then
      release = release_of(contact, [points%opening_step(i), 0.0_wp])
    end if
  end function release_before

end module contact_bond
