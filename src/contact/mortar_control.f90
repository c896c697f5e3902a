!> Control points of the mortar scheme: their pressures, the nodes that they couple, and their part
!! of the tangent.
module mortar_control
  use base_kinds, only: wp
  use contact_pair, only: assigned_law_t, contact_t, surface_t, control_points_t
  use contact_point, only: energy_at_rest, traction_derivatives_t, vary_normal, outer
  use contact_type, only: PENALTY, SLIP, SMOOTHING
  use contact_work, only: element_functions, energy_share, own_share
  use csr, only: block_matrix_t, clique_t, block_position
  use mortar_type, only: mortar_t, mortar_side_t, control_functions, functions_at, number_at, &
                         size_of_element
  implicit none
  private
  public :: find_pressures, pressed_energy, pressure_at, need_lists, mortar_clique, &
            add_control_tangent

  !> An overlap of a control point is ignored if it is below this fraction of the largest overlap.
  real(wp), parameter :: NO_OVERLAP = 1.0e-10_wp
  !> Surfaces just touch where the gap is below this fraction of the width of the smallest element.
  !! It may be due to rounding in the file of the mesh.
  real(wp), parameter :: NO_GAP = 1.0e-9_wp
  !> Rounding error of a gap, relative to the positions of the nodes.
  real(wp), parameter, public :: GAP_ERROR = 1.0e3_wp*epsilon(1.0_wp)
  !> After this number of iterations of a step, surfaces touch only where the gap is below its
  !! rounding error.
  integer, parameter :: TOUCHES = 10

contains

  !> Find weighted gaps and pressures of the control points, and the pressures of the points.
  !!
  !! Where surfaces just touch, rounding decides whether a point is open or closed. Such a point is
  !! given the stiffness of a closed one, and, with friction, that of a point that sticks (see
  !! add_friction). If only a random half of the points had a stiffness, the first iteration could
  !! lead to a state in which the edges of the bodies no longer meet. This is not the derivative of
  !! the pressure, however. Thin or stiff bodies penetrate each other by less than NO_GAP, and if
  !! points that have opened by as little kept this stiffness, the iteration would converge slowly.
  subroutine find_pressures(contact, k, x, iterate, side, control)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) current positions [L]
    integer, intent(in) :: iterate            !! see mortar_t
    type(mortar_side_t), intent(inout) :: side
    type(control_points_t), intent(inout) :: control
    real(wp) :: energy, prop(size(contact%normal%prop))
    real(wp) :: psi(size_of_element(contact%side(k))), width
    integer :: a, i, j

    width = 0.0_wp
    if (allocated(contact%side(k)%width) .and. .not. contact%normal%prop(SMOOTHING) > 0.0_wp) then
      width = minval(contact%side(k)%width)
    end if
    side%no_gap = NO_GAP*width
    side%no_slip = side%no_gap
    if (iterate > 1) then
      side%no_slip = min(side%no_gap, GAP_ERROR*maxval(abs(x(:, contact%side(k)%node))))
    end if
    if (iterate > TOUCHES) side%no_gap = side%no_slip
    associate (own => contact%side(k), cells => side%cells, law => contact%normal%law)
      control%gap = huge(1.0_wp)
      control%pressure = 0.0_wp
      side%q = 0.0_wp
      side%dq = 0.0_wp
      side%a = 0.0_wp
      prop = contact%normal%prop
      if (contact%control_penalty > 0.0_wp) then
        side%volume = 0.0_wp
        do i = 1, cells%n
          if (cells%foot(i)%elem == 0) cycle
          call control_at(own, side, i, psi)
          do j = 1, number_at(own, cells%elem(i))
            a = own%control(own%control_first(cells%elem(i)) + j - 1)
            side%a(a) = side%a(a) + cells%weight(i)*psi(j)
            side%volume(a) = side%volume(a) + cells%weight(i)*psi(j)*cells%foot(i)%gap
          end do
        end do
        prop(PENALTY) = contact%control_penalty
        do a = 1, own%ncontrol
          if (.not. side%a(a) > NO_OVERLAP*maxval(side%a)) cycle
          control%gap(a) = side%volume(a)/side%a(a)
          call law%normal(prop, control%gap(a), control%multiplier(a), side%q(a), &
                          side%dq(a), energy)
          if (touching(control%gap(a) - control%multiplier(a)/prop(PENALTY), side%no_gap)) then
            side%dq(a) = -prop(PENALTY)
          end if
        end do
        control%pressure = side%q
      end if
      prop(PENALTY) = contact%point_penalty
      side%p = 0.0_wp
      side%dp = 0.0_wp
      do i = 1, cells%n
        if (cells%foot(i)%elem == 0) cycle
        call law%normal(prop, cells%foot(i)%gap, 0.0_wp, side%p(i), side%dp(i), energy)
        if (touching(cells%foot(i)%gap, side%no_gap)) side%dp(i) = -prop(PENALTY)
        if (.not. contact%control_penalty > 0.0_wp) cycle
        call control_at(own, side, i, psi)
        do j = 1, number_at(own, cells%elem(i))
          a = own%control(own%control_first(cells%elem(i)) + j - 1)
          side%p(i) = side%p(i) + psi(j)*side%q(a)
        end do
      end do
    end associate
  end subroutine find_pressures

  !> Is the gap zero up to rounding, and not negative?
  pure logical function touching(gap, no_gap)
    real(wp), intent(in) :: gap, no_gap

    touching = gap >= 0.0_wp .and. gap <= no_gap
  end function touching

  !> Energy of the pressure on side k at the gaps and multipliers of find_pressures.
  pure real(wp) function pressed_energy(contact, k, side, control) result(energy)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(mortar_side_t), intent(in) :: side
    type(control_points_t), intent(in) :: control
    type(assigned_law_t) :: normal
    real(wp) :: p, dp, w
    integer :: a, i

    energy = 0.0_wp
    normal = contact%normal
    normal%prop(PENALTY) = contact%point_penalty
    do i = 1, side%cells%n
      if (side%cells%foot(i)%elem == 0) cycle
      call normal%law%normal(normal%prop, side%cells%foot(i)%gap, 0.0_wp, p, dp, w)
      energy = energy + side%cells%weight(i)*w
    end do
    normal%prop(PENALTY) = contact%control_penalty
    do a = 1, contact%side(k)%ncontrol
      if (.not. control%gap(a) < huge(1.0_wp)) cycle
      call normal%law%normal(normal%prop, control%gap(a), control%multiplier(a), p, dp, w)
      energy = energy + side%a(a)*(w - energy_at_rest(normal, control%multiplier(a)))
    end do
    energy = energy_share(contact)*energy
  end function pressed_energy

  !> Evaluate the functions of the control points at point i of the cells.
  pure subroutine control_at(surface, side, i, psi)
    type(surface_t), intent(in) :: surface
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: i
    real(wp), intent(out) :: psi(:)

    associate (e => side%cells%elem(i))
      call control_functions(surface, side%cells%xi(:, i), &
                             side%shp(:surface%first(e + 1) - surface%first(e), i), psi)
    end associate
  end subroutine control_at

  !> Pressure, per reference area, at a point with a given gap.
  pure real(wp) function pressure_at(side, contact, k, e, xi, gap) result(p)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: xi(2), gap
    real(wp) :: psi(size_of_element(contact%side(k))), prop(size(contact%normal%prop)), dp, energy
    integer :: j

    prop = contact%normal%prop
    prop(PENALTY) = contact%point_penalty
    call contact%normal%law%normal(prop, gap, 0.0_wp, p, dp, energy)
    if (.not. contact%control_penalty > 0.0_wp) return
    associate (own => contact%side(k))
      call functions_at(own, e, xi, psi)
      do j = 1, number_at(own, e)
        p = p + psi(j)*side%q(own%control(own%control_first(e) + j - 1))
      end do
    end associate
  end function pressure_at

  !> Find the nodes that each control point couples. `grown` is set if the pattern must be rebuilt.
  subroutine need_lists(contact, k, side, nnode, new, grown)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(mortar_side_t), intent(inout) :: side
    integer, intent(in) :: nnode
    logical, intent(in) :: new               !! the step begins, so earlier couplings are forgotten
    logical, intent(inout) :: grown
    integer, allocatable :: mark(:), list(:)
    integer :: a, e, i, n, r

    allocate (mark(nnode), source=0)
    allocate (list(nnode))
    associate (own => contact%side(k), other => contact%side(3 - k), cells => side%cells)
      do a = 1, own%ncontrol
        n = 0
        if (side%dq(a) < 0.0_wp) then
          do r = side%round_first(a), side%round_first(a + 1) - 1
            e = side%round(r)
            if (cells%first(e) == cells%first(e + 1)) cycle
            call put_element(own, e)
            do i = cells%first(e), cells%first(e + 1) - 1
              if (cells%foot(i)%elem == 0) cycle
              call put_element(other, cells%foot(i)%elem)
            end do
          end do
        end if
        mark(list(:n)) = 0
        associate (known => side%known(a))
          if (new) then ! an unchanged list needs no new pattern
            if (n /= size(known%node)) then
              grown = .true.
            else if (n > 0) then
              mark(known%node) = 1
              grown = grown .or. any(mark(list(:n)) == 0)
              mark(known%node) = 0
            end if
            known%node = list(:n)
          else if (n > 0) then
            mark(known%node) = 1
            r = 0
            do i = 1, n
              if (mark(list(i)) > 0) cycle
              r = r + 1
              list(r) = list(i)
            end do
            mark(known%node) = 0
            if (r > 0) then
              grown = .true.
              known%node = [known%node, list(:r)]
            end if
          end if
        end associate
      end do
    end associate

  contains

    subroutine put_element(surface, e)
      type(surface_t), intent(in) :: surface
      integer, intent(in) :: e
      integer :: j

      do j = surface%first(e), surface%first(e + 1) - 1
        if (mark(surface%node(j)) > 0) cycle
        mark(surface%node(j)) = 1
        n = n + 1
        list(n) = surface%node(j)
      end do
    end subroutine put_element
  end subroutine need_lists

  !> List the nodes that the control points of side k couple, for the pattern.
  subroutine mortar_clique(mortar, k, clique)
    type(mortar_t), intent(in) :: mortar
    integer, intent(in) :: k
    type(clique_t), intent(out) :: clique
    integer :: a, m, n, size_of(size(mortar%side(k)%known))

    size_of = [(size(mortar%side(k)%known(a)%node), a=1, size(size_of))]
    m = 0
    if (size(size_of) > 0) m = maxval(size_of)
    allocate (clique%conn(m, count(size_of > 0)))
    n = 0
    do a = 1, size(size_of)
      if (size_of(a) == 0) cycle
      n = n + 1
      clique%conn(:, n) = mortar%side(k)%known(a)%node(1)
      clique%conn(:size_of(a), n) = mortar%side(k)%known(a)%node
    end do
  end subroutine mortar_clique

  !> Add the part of the tangent that couples all nodes around a control point, because the pressure
  !! there varies with the positions of all these nodes.
  subroutine add_control_tangent(side, contact, k, x, secant, a)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)
    logical, intent(in) :: secant            !! derivatives of friction are secants
    type(block_matrix_t), intent(inout) :: a
    real(wp), allocatable :: slope(:, :)     ! (3, nodes) derivatives of a weighted gap [L^2]
    real(wp), allocatable :: rows(:, :)      ! (3, nodes) forces due to a unit pressure [L^2]
    integer, allocatable :: at(:)            ! (nnode) position of a node in a list
    real(wp) :: stiffness
    integer :: c, i, j, most, p

    most = 0
    do c = 1, size(side%known)
      most = max(most, size(side%known(c)%node))
    end do
    allocate (at(size(x, 2)), source=0)
    allocate (slope(3, most), rows(3, most))
    do c = 1, contact%side(k)%ncontrol
      if (.not. side%dq(c) < 0.0_wp) cycle
      associate (list => side%known(c)%node)
        do j = 1, size(list)
          at(list(j)) = j
        end do
        call vary_gap(side, contact, k, c, x, secant, at, slope, rows)
        stiffness = -own_share(contact)*side%dq(c)/side%a(c)
        do j = 1, size(list)
          do i = 1, size(list)
            if (a%symmetric .and. list(i) > list(j)) cycle
            p = block_position(a, list(i), list(j))
            if (a%symmetric) then
              a%val(:, :, p) = a%val(:, :, p) + 0.5_wp*stiffness*(outer(rows(:, i), slope(:, j)) &
                                                                  + outer(slope(:, i), rows(:, j)))
            else
              a%val(:, :, p) = a%val(:, :, p) + outer(rows(:, i), stiffness*slope(:, j))
            end if
          end do
        end do
        at(list) = 0
      end associate
    end do
  end subroutine add_control_tangent

  !> Find the derivatives of the weighted gap of control point c, sum_i w_i N_c(xi_i) g_i over the
  !! points of the cells (weights w, function N_c, gaps g), with respect to the positions of the
  !! nodes that c couples. Also find the forces on these nodes due to a unit pressure at c,
  !! including the friction of points that slip.
  subroutine vary_gap(side, contact, k, c, x, secant, at, slope, rows)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, c
    real(wp), intent(in) :: x(:, :)          !! (3, nnode) [L]
    logical, intent(in) :: secant            !! omit the friction: the secant ignores the pressure
    integer, intent(in) :: at(:)             !! (nnode) column of a node in `slope` and `rows`
    real(wp), intent(out) :: slope(:, :), rows(:, :) !! (3, nodes) [L^2]
    real(wp) :: psi(size_of_element(contact%side(k)))
    real(wp) :: there(size_of_element(contact%side(3 - k))), &
                dthere(2, size_of_element(contact%side(3 - k)))
    type(traction_derivatives_t) :: dn
    real(wp) :: xp(3), n(3), t(3), w
    integer :: e, i, j, l, nk, nl, r

    slope = 0.0_wp
    rows = 0.0_wp
    associate (own => contact%side(k), other => contact%side(3 - k), cells => side%cells)
      do r = side%round_first(c), side%round_first(c + 1) - 1
        e = side%round(r)
        nk = own%first(e + 1) - own%first(e)
        do i = cells%first(e), cells%first(e + 1) - 1
          if (cells%foot(i)%elem == 0) cycle
          call control_at(own, side, i, psi)
          w = 0.0_wp
          do j = 1, number_at(own, e)
            if (own%control(own%control_first(e) + j - 1) == c) w = w + psi(j)
          end do
          w = w*cells%weight(i)
          if (.not. abs(w) > 0.0_wp) cycle
          xp = 0.0_wp
          do j = 1, nk
            xp = xp + side%shp(j, i)*x(:, own%node(own%first(e) + j - 1))
          end do
          call vary_normal(cells%foot(i), xp, n, dn)
          t = n
          if (side%state(i) == SLIP .and. .not. secant) t = n + side%friction(:, i)/side%p(i)
          do j = 1, nk
            l = at(own%node(own%first(e) + j - 1))
            slope(:, l) = slope(:, l) + w*side%shp(j, i)*n
            rows(:, l) = rows(:, l) + w*side%shp(j, i)*t
          end do
          associate (first => other%first(cells%foot(i)%elem))
            nl = other%first(cells%foot(i)%elem + 1) - first
            call element_functions(other, cells%foot(i)%elem, cells%foot(i)%xi, there(:nl), &
                                   dthere(:, :nl))
            do j = 1, nl
              l = at(other%node(first + j - 1))
              slope(:, l) = slope(:, l) - w*there(j)*n
              rows(:, l) = rows(:, l) - w*there(j)*t
            end do
          end associate
        end do
      end do
    end associate
  end subroutine vary_gap

end module mortar_control
