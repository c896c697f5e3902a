!> Results of the mortar scheme when a step is accepted.
module mortar_results
  use base_kinds, only: wp
  use contact_cells, only: cells_t
  use contact_corners, only: deepest_corner, CORNER_XI
  use contact_energy, only: slip_work
  use contact_fric, only: NO_SLIP
  use contact_pair, only: contact_t, contact_points_t, contact_state_t, friction_points_t, &
                          is_integrated, surface_t
  use contact_point, only: traction_derivatives_t, vary_normal
  use contact_smooth, only: number_nodes, find_squares, weighting_functions, reverse, NSPREAD
  use contact_type, only: MU, OPEN, STICK, SLIP
  use contact_work, only: energy_share, own_share
  use mortar_control, only: pressed_energy, pressure_at
  use mortar_type, only: mortar_t, mortar_side_t
  use projection, only: project
  use projection_search, only: grid_t
  use projection_type, only: foot_t, shape_t, touches
  use self_contact, only: project_on_itself
  use surface_chart, only: collapsed_side, to_chart
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: accept_mortar, measure_corners, spread_cells

  !> Rate of slip in a step in which no time passes: large, but finite even when multiplied by a
  !! time step. The value only decides whether slip is expected in the next step.
  real(wp), parameter :: FAST = sqrt(huge(1.0_wp))

  !> Nodes of one side to which values are spread.
  type :: target_t
    integer, allocatable :: at(:)            !! (size(surface%node)) see number_nodes
    logical, allocatable :: squares(:)       !! (nelem) see find_squares
  end type target_t

contains

  !> Accept a step: store the data that friction needs in the next step, find the energies, and set
  !! the results at the integration points for fields, curves and reports. Tractions refer to the
  !! current area.
  subroutine accept_mortar(mortar, contact, k, shape, grid, state)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(contact_state_t), intent(inout) :: state
    type(foot_t) :: foot
    type(traction_derivatives_t) :: dn
    real(wp) :: at(3), a(3, 2), b(3, 3), n(3), p, reference, stretch
    integer :: e, i, j, q

    if (mortar%slides .and. contact%friction%prop(MU) > 0.0_wp) then
      state%last_cut = [mortar%x_cut(:, contact%side(1)%node), &
                        mortar%x_cut(:, contact%side(2)%node)]
    end if
    call find_sticking(mortar%side(k))
    call keep_friction(mortar%side(k), contact, state%side(k)%dt, state%rubbed(k), &
                       state%limit_force(k), state%dissipated)
    call measure_cells(mortar, contact, k, shape(k), state)
    state%pressed(k) = pressed_energy(contact, k, mortar%side(k), state%control(k))
    associate (own => contact%side(k), side => mortar%side(k), points => state%side(k))
      points%traction = 0.0_wp
      points%friction = 0.0_wp
      points%normal = 0.0_wp
      points%elastic = 0.0_wp
      points%slip = 0.0_wp
      points%pressure = 0.0_wp
      points%state = OPEN
      do e = 1, own%nelem
        do q = 1, contact%nq
          i = (e - 1)*contact%nq + q
          call surface_point(own, mortar%reference(k), e, contact%xi(:, q), at, a, b)
          reference = norm2(cross(a(:, 1), a(:, 2)))
          call surface_point(own, shape(k), e, contact%xi(:, q), at, a, b)
          stretch = norm2(cross(a(:, 1), a(:, 2)))
          points%area(i) = contact%wgt(q)*stretch
          if (contact%self) then
            call find_faced(side%cells, e, contact%xi(:, q), foot)
            call project_on_itself(contact, shape(k), mortar%reference(k), e, contact%xi(:, q), &
                                   foot)
          else
            foot%elem = points%closest(i)
            foot%xi = points%closest_xi(:, i)
            call project(contact%side(3 - k), shape(3 - k), grid(3 - k), at, foot, contact%depth)
          end if
          points%closest(i) = foot%elem
          points%closest_xi(:, i) = foot%xi
          points%gap(i) = foot%gap
          if (.not. touches(foot, contact%depth)) cycle
          p = pressure_at(side, contact, k, e, contact%xi(:, q), foot%gap)
          if (.not. (p > 0.0_wp .and. stretch > 0.0_wp)) cycle
          j = nearest_closed(own, side, e, contact%xi(:, q))
          if (j == 0) cycle                  ! the point is beyond the border or faces away
          call vary_normal(foot, at, n, dn)
          p = p*reference/stretch
          points%pressure(i) = p
          points%state(i) = side%state(j)
          points%friction(:, i) = p/side%p(j)*(side%friction(:, j) &
                                               - dot_product(side%friction(:, j), n)*n)
          points%normal(:, i) = p*n
          points%traction(:, i) = points%normal(:, i) + points%friction(:, i)
          points%elastic(:, i) = side%elastic(:, j)
          points%slip(i) = side%slip(j)
        end do
      end do
    end associate
  end subroutine accept_mortar

  !> Include the corners of elements in the penetration of a step. Where a corner of one side is
  !! deep, so is the other side, so both sides get the largest depth. accept_mortar must have been
  !! called for both sides.
  subroutine measure_corners(mortar, contact, shape, grid, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(contact_state_t), intent(inout) :: state
    real(wp) :: deepest
    integer :: k

    deepest = 0.0_wp
    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      if (contact%self) then
        deepest = max(deepest, deepest_own_corner(mortar, contact, shape(k)))
      else
        deepest = max(deepest, deepest_corner(contact, k, shape, grid(3 - k), state%side(k)))
      end if
    end do
    do k = 1, 2
      if (is_integrated(contact, k)) state%penetration(k) = max(state%penetration(k), deepest)
    end do
  end subroutine measure_corners

  !> Points that were expected to slip, since they slipped in the previous step, but did not move,
  !! stick.
  pure subroutine find_sticking(side)
    type(mortar_side_t), intent(inout) :: side
    real(wp) :: elastic
    integer :: i

    do i = 1, side%cells%n
      elastic = norm2(side%elastic(:, i))
      if (side%state(i) == SLIP .and. elastic > 0.0_wp .and. side%slip(i) <= NO_SLIP*elastic) then
        side%state(i) = STICK
      end if
    end do
  end subroutine find_sticking

  !> Spread tractions, elastic slip and state of the points of all cells to the nodes of both
  !! elements that a point loads: its own one and, with the opposite traction, the one that it
  !! faces. accept_mortar must have been called for both sides.
  subroutine spread_cells(mortar, contact, shape, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape(2)
    type(contact_state_t), intent(inout) :: state
    type(target_t) :: nodes(2)
    integer, allocatable :: node(:)
    integer :: k

    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      call number_nodes(contact%side(k)%node, node, nodes(k)%at)
      nodes(k)%squares = find_squares(contact, k, state%side(k))
      state%side(k)%spread = 0.0_wp
    end do
    do k = 1, 2
      if (is_integrated(contact, k)) call spread_points(mortar, contact, k, shape(k), nodes, state)
    end do
  end subroutine spread_cells

  !> Spread the values of the points of side k to the nodes of both sides.
  subroutine spread_points(mortar, contact, k, shape, nodes, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape       !! shape of side k
    type(target_t), intent(in) :: nodes(2)
    type(contact_state_t), intent(inout) :: state
    real(wp) :: value(NSPREAD), share
    integer :: i, l

    share = own_share(contact)
    l = merge(1, 3 - k, contact%self)        ! the side that the points face
    associate (cells => mortar%side(k)%cells)
      do i = 1, cells%n
        if (.not. mortar%side(k)%p(i) > 0.0_wp) cycle
        call find_values(contact%side(k), mortar%side(k), mortar%reference(k), shape, i, value)
        call spread_value(contact%side(k), nodes(k), cells%elem(i), cells%xi(:, i), share*value, &
                          state%side(k)%spread)
        if (.not. is_integrated(contact, l)) cycle
        call spread_value(contact%side(l), nodes(l), cells%foot(i)%elem, cells%foot(i)%xi, &
                          (1.0_wp - share)*reverse(value), state%side(l)%spread)
      end do
    end associate
  end subroutine spread_points

  !> Values of point i of the cells of a side, multiplied by its area; zero if the element has no
  !! area there.
  pure subroutine find_values(own, side, reference, shape, i, value)
    type(surface_t), intent(in) :: own
    type(mortar_side_t), intent(in) :: side
    type(shape_t), intent(in) :: reference, shape !! reference and current shape of the side
    integer, intent(in) :: i
    real(wp), intent(out) :: value(NSPREAD)
    type(traction_derivatives_t) :: dn
    real(wp) :: x(3), a(3, 2), b(3, 3), n(3), area, whole, friction(3)

    value = 0.0_wp
    associate (cells => side%cells)
      call surface_point(own, reference, cells%elem(i), cells%xi(:, i), x, a, b)
      whole = norm2(cross(a(:, 1), a(:, 2)))
      if (.not. whole > 0.0_wp) return
      call surface_point(own, shape, cells%elem(i), cells%xi(:, i), x, a, b)
      area = cells%weight(i)*norm2(cross(a(:, 1), a(:, 2)))/whole
      call vary_normal(cells%foot(i), x, n, dn)
      friction = side%friction(:, i) - dot_product(side%friction(:, i), n)*n
      value(12:14) = cells%weight(i)*side%p(i)*n
      value(1:3) = value(12:14) + cells%weight(i)*friction
      value(4) = cells%weight(i)*side%p(i)
      value(5:7) = area*side%elastic(:, i)
      value(8) = area*merge(2.0_wp, 1.0_wp, side%state(i) == SLIP)
      value(9:11) = cells%weight(i)*friction
    end associate
  end subroutine find_values

  !> Add a value, multiplied by the functions at a point of element e, to the sums of its nodes.
  pure subroutine spread_value(surface, nodes, e, xi, value, sums)
    type(surface_t), intent(in) :: surface
    type(target_t), intent(in) :: nodes
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), value(NSPREAD)
    real(wp), intent(inout) :: sums(:, :)    !! (NSPREAD, n)
    real(wp) :: shp(surface%first(e + 1) - surface%first(e))
    integer :: j

    call weighting_functions(surface, e, xi, nodes%squares, shp)
    do j = 1, size(shp)
      associate (to => sums(:, nodes%at(surface%first(e) + j - 1)))
        to = to + shp(j)*value
      end associate
    end do
  end subroutine spread_value

  !> Store the values from which those of the points of the next step are interpolated. Add the work
  !! of slip in this step.
  subroutine keep_friction(side, contact, dt, rubbed, limit_force, dissipated)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: dt               !! time step [T]
    type(friction_points_t), intent(inout) :: rubbed
    real(wp), intent(inout) :: limit_force   !! integral of the friction limit [F]
    real(wp), intent(inout) :: dissipated    !! [F L]
    real(wp) :: limit(side%cells%n), rate(side%cells%n)
    logical :: rubs(side%cells%n)
    integer :: e, i, n

    associate (cells => side%cells)
      limit = 0.0_wp
      if (contact%friction%given) limit = contact%friction%prop(MU)*side%p
      rubs = .false. ! whole elements are stored, including their open points
      do e = 1, size(cells%first) - 1
        i = cells%first(e)
        n = cells%first(e + 1) - 1
        rubs(i:n) = any(limit(i:n) > 0.0_wp .or. side%state(i:n) == STICK &
                        .or. side%state(i:n) == SLIP)
      end do
      n = cells%n
      rubbed%elem = pack(cells%elem(:n), rubs)
      rubbed%xi = reshape(pack(cells%xi(:, :n), spread(rubs, 1, 2)), [2, count(rubs)])
      rubbed%elastic = reshape(pack(side%elastic, spread(rubs, 1, 3)), [3, count(rubs)])
      rate = merge(side%slip, 0.0_wp, side%state == SLIP)
      rate = rate/max(dt, rate/FAST, tiny(dt))
      rubbed%slip_rate = pack(rate, rubs)
      rubbed%limit = pack(limit, rubs)
      if (.not. contact%friction%given) return
      dissipated = dissipated + energy_share(contact)*slip_work(cells%weight(:n), side%slip(:n), &
                                                                side%limit(:n), limit(:n), &
                                                                limit_force)
      limit_force = sum(cells%weight(:n)*limit(:n))
    end associate
  end subroutine keep_friction

  !> The point nearest to xi among the points of an element's cells that carry a pressure; 0: xi
  !! lies in no cell with such a point.
  pure integer function nearest_closed(own, side, e, xi) result(j)
    type(surface_t), intent(in) :: own
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp) :: area, d, least, u(2)
    integer :: flat, i
    logical :: inside

    j = 0
    least = huge(least)
    inside = .false.
    flat = collapsed_side(own, e)
    u = to_chart(flat, xi)
    ! area of element e in its chart, divided by its reference area
    area = merge(2.0_wp, 4.0_wp, flat > 0)/own%width(e)**2
    do i = side%cells%first(e), side%cells%first(e + 1) - 1
      if (.not. side%p(i) > 0.0_wp) cycle
      d = sum((to_chart(flat, side%cells%xi(:, i)) - u)**2)
      ! d is squared: the limit is about twice the distance between two points of this cell
      inside = inside .or. d <= 4.0_wp*area*abs(side%cells%weight(i))
      if (d >= least) cycle
      least = d
      j = i
    end do
    if (.not. inside) j = 0
  end function nearest_closed

  !> Find the projection of that point of the cells of element e that is nearest to xi, or else the
  !! facet that this point faces. The result foot%elem = 0 means that element e faces nothing.
  pure subroutine find_faced(cells, e, xi, foot)
    type(cells_t), intent(in) :: cells
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    type(foot_t), intent(inout) :: foot
    integer :: i

    foot%elem = 0
    if (cells%first(e) == cells%first(e + 1)) return
    i = cells%first(e) - 1 + minloc([(sum((cells%xi(:, i) - xi)**2), &
                                      i=cells%first(e), cells%first(e + 1) - 1)], 1)
    foot%elem = cells%foot(i)%elem
    foot%xi = cells%foot(i)%xi
    if (foot%elem > 0) return
    foot%elem = cells%faced(i)
    foot%xi = cells%faced_xi(:, i)
  end subroutine find_faced

  !> Largest penetration of corners of elements in self-contact [L].
  pure real(wp) function deepest_own_corner(mortar, contact, shape) result(deepest)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape
    type(foot_t) :: foot
    integer :: e, i

    deepest = 0.0_wp
    do e = 1, contact%side(1)%nelem
      do i = 1, 4
        call find_faced(mortar%side(1)%cells, e, CORNER_XI(:, i), foot)
        if (foot%elem == 0) exit
        call project_on_itself(contact, shape, mortar%reference(1), e, CORNER_XI(:, i), foot)
        if (touches(foot, contact%depth)) deepest = max(deepest, -foot%gap)
      end do
    end do
  end function deepest_own_corner

  !> Find the largest penetration of side k and the elastic energy of its friction, and add up its
  !! area in contact and the parts of this area that stick and slip. Pressures of control points
  !! extend over whole elements. The area of a point is therefore included only if its pressure
  !! exceeds the penalty of the control points times its own gap.
  subroutine measure_cells(mortar, contact, k, shape, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape       !! shape of side k
    type(contact_state_t), intent(inout) :: state
    real(wp) :: x(3), a(3, 2), b(3, 3), area, reference
    integer :: i

    state%area(k) = 0.0_wp
    state%sticks(k) = 0.0_wp
    state%slips(k) = 0.0_wp
    state%penetration(k) = 0.0_wp
    state%sheared(k) = 0.0_wp
    associate (side => mortar%side(k), cells => mortar%side(k)%cells)
      do i = 1, cells%n
        if (.not. side%p(i) > 0.0_wp) cycle
        call surface_point(contact%side(k), mortar%reference(k), cells%elem(i), cells%xi(:, i), x, &
                           a, b)
        reference = norm2(cross(a(:, 1), a(:, 2)))
        if (.not. reference > 0.0_wp) cycle
        call surface_point(contact%side(k), shape, cells%elem(i), cells%xi(:, i), x, a, b)
        area = cells%weight(i)*norm2(cross(a(:, 1), a(:, 2)))/reference
        if (side%p(i) > contact%control_penalty*cells%foot(i)%gap) then
          state%area(k) = state%area(k) + area
          if (side%state(i) == STICK) state%sticks(k) = state%sticks(k) + area
          if (side%state(i) == SLIP) state%slips(k) = state%slips(k) + area
        end if
        state%penetration(k) = max(state%penetration(k), -cells%foot(i)%gap)
        state%sheared(k) = state%sheared(k) + 0.5_wp*energy_share(contact)*cells%weight(i) &
                           *norm2(side%friction(:, i))*norm2(side%elastic(:, i))
      end do
    end associate
  end subroutine measure_cells

end module mortar_results
