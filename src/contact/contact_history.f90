!> History of the integration points of a contact: how it is allocated, accepted with a step, and
!! restored by a cut-back.
!!
!! Its arrays are those of contact_points_t (contact_pair); arrays whose names end in `_step` hold
!! the state at the start of the step. Friction needs a sliding point on the other surface, which
!! moves only when a step is accepted (accept_slides). See also contact_assembly (fills the arrays
!! in an iteration), contact_smooth and contact_resultant (compute fields and sums from them) and
!! contact_augment (changes the multipliers).
module contact_history
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, is_integrated, surface_t, &
                          HALFPASS, MORTAR
  use contact_smooth, only: count_nodes, NSPREAD
  use contact_type, only: OPEN, MAX_PAST, STICK, SLIP
  use projection, only: project
  use projection_search, only: grid_t
  use projection_type, only: foot_t, shape_t
  use surface_geometry, only: surface_point
  use surface_traversal, only: walk
  implicit none
  private
  public :: new_contact_state, restore_contact_step, keep_contact_step, had_touched, mark_beside, &
            side_positions, enter_slide, accept_slides, direction, trail_behind, slide_beyond

  !> Fraction of DEPTh: a point beside the other surface is marked if it is less than this above the
  !! tangent plane of the border (mark_beside). The pressure of a marked point that has entered the
  !! body decreases beyond this depth.
  real(wp), parameter, public :: BESIDE = 0.1_wp

  integer, parameter :: MOST_STEPS = 20
  !> A gap that is smaller than this, relative to the tangents, has no meaningful direction.
  real(wp), parameter :: NO_DIRECTION = 1.0e-12_wp

contains

  !> Make a history in which no point is in contact; a side that is not integrated has no points.
  subroutine new_contact_state(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(out) :: state
    integer :: k, np

    do k = 1, 2
      np = contact%side(k)%nelem*contact%nq
      if (.not. is_integrated(contact, k)) np = 0
      associate (p => state%side(k))
        allocate (p%closest(np), p%closest_step(np), p%slide(np), p%bond(np), source=0)
        allocate (p%closest_xi(2, np), p%closest_xi_step(2, np), p%slide_xi(2, np), &
                  p%bond_xi(2, np), source=0.0_wp)
        allocate (p%multiplier(np), p%multiplier_step(np), p%pressure(np), source=0.0_wp)
        allocate (p%limit(np), p%limit_step(np), p%pressed(np), source=0.0_wp)
        allocate (p%area(np), p%area0(np), p%slip(np), p%slip_rate(np), source=0.0_wp)
        allocate (p%opening(np), p%opening_step(np), source=0.0_wp)
        allocate (p%traction(3, np), p%friction(3, np), p%normal(3, np), p%elastic(3, np), &
                  p%bond_traction(3, np), p%energy(3, np), source=0.0_wp)
        allocate (p%past(MAX_PAST, np), p%past_step(MAX_PAST, np), source=0.0_wp)
        allocate (p%gap(np), source=huge(1.0_wp))
        allocate (p%share(np), source=1.0_wp)
        allocate (p%state(np), p%state_step(np), source=OPEN)
        allocate (p%beside(np), p%refined(np/max(1, contact%nq)), source=.false.)
        if (contact%scheme == MORTAR) then
          if (np > 0) np = count_nodes(contact%side(k)%node)
          allocate (p%spread(NSPREAD, np), source=0.0_wp)
        end if
      end associate
      associate (rubbed => state%rubbed(k))
        allocate (rubbed%elem(0), rubbed%xi(2, 0), rubbed%elastic(3, 0), rubbed%slip_rate(0), &
                  rubbed%limit(0))
      end associate
      np = 0 ! control points of MORTar
      if (contact%scheme == MORTAR .and. is_integrated(contact, k)) np = contact%side(k)%ncontrol
      associate (p => state%control(k))
        allocate (p%multiplier(np), p%multiplier_step(np), p%pressure(np), source=0.0_wp)
        allocate (p%gap(np), source=huge(1.0_wp))
      end associate
    end do
  end subroutine new_contact_state

  !> Restore the state at the start of the step, when the step is cut back.
  subroutine restore_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    state%force = state%force_step
    state%moment = state%moment_step
    do k = 1, 2
      associate (points => state%side(k))
        points%closest = points%closest_step
        points%closest_xi = points%closest_xi_step
        points%multiplier = points%multiplier_step
        points%past = points%past_step
        points%opening = points%opening_step
        points%state = points%state_step
        points%new_step = .true.
      end associate
      associate (control => state%control(k))
        control%multiplier = control%multiplier_step
      end associate
    end do
  end subroutine restore_contact_step

  !> Accept the step: save the state that a cut-back of the next step restores.
  subroutine keep_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    state%force_step = state%force
    state%moment_step = state%moment
    do k = 1, 2
      associate (points => state%side(k))
        points%closest_step = points%closest
        points%closest_xi_step = points%closest_xi
        points%multiplier_step = points%multiplier
        points%past_step = points%past
        points%opening_step = points%opening
        points%state_step = points%state
        points%limit_step = points%limit
        points%slip_rate = 0.0_wp
        if (points%dt > 0.0_wp) points%slip_rate = points%slip/points%dt
        points%new_step = .true.
      end associate
      associate (control => state%control(k))
        control%multiplier_step = control%multiplier
      end associate
    end do
  end subroutine keep_contact_step

  !> Mark the points of an accepted step that lie beside the other surface and less than `depth`
  !! above the tangent plane of its border. A marked point stays marked as long as it is deeper than
  !! `depth` below its projection.
  pure subroutine mark_beside(feet, depth, points)
    type(foot_t), intent(in) :: feet(:)    !! (np)
    real(wp), intent(in) :: depth          !! [L]
    type(contact_points_t), intent(inout) :: points
    integer :: i

    do i = 1, size(feet)
      if (feet(i)%elem > 0) then
        points%beside(i) = points%beside(i) .and. feet(i)%gap < -depth
      else if (feet(i)%outer > 0) then
        points%beside(i) = feet(i)%outer_gap < depth
      end if
    end do
  end subroutine mark_beside

  !> Was any point in contact at the end of the previous step?
  pure logical function had_touched(state)
    type(contact_state_t), intent(in) :: state

    had_touched = any(state%side(1)%state_step /= OPEN) &
                  .or. any(state%side(2)%state_step /= OPEN)
  end function had_touched

  !> Find positions of integration points of element e: skip the first `from` points, and take as
  !! many of the next ones as xp has room for.
  pure subroutine side_positions(surface, e, x, xp, from)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) current positions [L]
    real(wp), intent(out) :: xp(:, :)    !! (3, n)
    integer, intent(in), optional :: from
    integer :: j, q, q0
    real(wp) :: s, w

    q0 = 0
    if (present(from)) q0 = from
    associate (shp => surface%basis(surface%ibasis(e))%shp, first => surface%first(e))
      do q = 1, size(xp, 2)
        xp(:, q) = 0.0_wp
        w = 0.0_wp
        do j = 1, size(shp, 1)
          s = shp(j, q0 + q)
          if (allocated(surface%w)) s = s*surface%w(first + j - 1)
          xp(:, q) = xp(:, q) + s*x(:, surface%node(first + j - 1))
          w = w + s
        end do
        if (allocated(surface%w)) xp(:, q) = xp(:, q)/w
      end do
    end associate
  end subroutine side_positions

  !> Set the sliding point of point i, which comes into contact in this step, to its projection at
  !! the start of the step. Friction then resists the whole tangential motion of the step, as it
  !! does at points whose sliding points were set when the previous step was accepted. A point whose
  !! projection failed, as on a badly distorted surface, has no sliding point.
  subroutine enter_slide(contact, k, shape, grid, x_start, i, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, i
    type(shape_t), intent(in) :: shape           !! other side at the start of the step
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x_start(:, :)        !! (3, nnode) x at the start of the step [L]
    type(contact_points_t), intent(inout) :: points
    type(foot_t) :: foot
    real(wp) :: xp(3, 1)

    call side_positions(contact%side(k), (i - 1)/contact%nq + 1, x_start, xp, &
                        from=mod(i - 1, contact%nq))
    call project(contact%side(3 - k), shape, grid, xp(:, 1), foot)
    if (foot%elem > 0) then
      points%slide(i) = foot%elem
      points%slide_xi(:, i) = foot%xi
    else
      points%slide(i) = foot%outer
      points%slide_xi(:, i) = foot%outer_xi
      if (contact%scheme /= HALFPASS .and. foot%outer > 0) then
        points%slide_xi(:, i) = slide_beyond(contact%side(3 - k), shape, foot, xp(:, 1))
      end if
    end if
  end subroutine enter_slide

  !> Set the sliding points of an accepted step. A sticking point keeps its sliding point. The
  !! sliding point of a slipping point follows the projection at a distance equal to the elastic
  !! part (Sauer and De Lorenzis 2015). The sliding point of any other point is its projection. If
  !! the point lies beyond the outer boundary, its sliding point lies there, too (slide_beyond), so
  !! that friction acts in the step in which the point crosses the boundary. With HALFpass, it is
  !! the closest point of the boundary.
  pure subroutine accept_slides(scheme, own, other, shape, x, feet, points)
    integer, intent(in) :: scheme                !! scheme of the contact: HALFPASS or BALANCED
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape           !! shape of the other side
    real(wp), intent(in) :: x(:, :)              !! (3, nnode) current positions [L]
    type(foot_t), intent(in) :: feet(:)          !! (np)
    type(contact_points_t), intent(inout) :: points
    real(wp) :: xp(3, size(feet)/max(1, own%nelem))
    integer :: e, i, q

    do e = 1, own%nelem
      call side_positions(own, e, x, xp)
      do q = 1, size(xp, 2)
        i = (e - 1)*size(xp, 2) + q
        if (points%state(i) == STICK .and. points%slide(i) > 0) cycle
        points%slide(i) = points%closest(i)
        points%slide_xi(:, i) = points%closest_xi(:, i)
        if (points%closest(i) == 0) then
          points%slide(i) = feet(i)%outer
          points%slide_xi(:, i) = feet(i)%outer_xi
          if (scheme /= HALFPASS .and. feet(i)%outer > 0) then
            points%slide_xi(:, i) = slide_beyond(other, shape, feet(i), xp(:, q))
          end if
        else if (points%state(i) == SLIP) then
          call trail_behind(other, shape, xp(:, q), feet(i), points%elastic(:, i), &
                            points%slide(i), points%slide_xi(:, i))
        end if
      end do
    end do
  end subroutine accept_slides

  !> Coordinates of the sliding point of a point x beyond the outer boundary, in the element of the
  !! closest point of the boundary. They lie outside of the square [-1, 1]^2, and refer to the
  !! tangents at the closest point (sliding_functions). If the surface then moves under x, friction
  !! acts against this motion. A sliding point on the boundary would turn the slip towards the
  !! normal of the boundary, and shorten it.
  pure function slide_beyond(other, shape, foot, x) result(xi)
    type(surface_t), intent(in) :: other
    type(shape_t), intent(in) :: shape           !! shape of the other side
    type(foot_t), intent(in) :: foot             !! with a point on the outer boundary
    real(wp), intent(in) :: x(3)                 !! [L]
    real(wp) :: xi(2)
    real(wp), parameter :: FLAT = 1.0e-6_wp      !! least sine of the angle between the tangents
    real(wp) :: at(3), a(3, 2), b(3, 3), g(2, 2), d(2), det

    call surface_point(other, shape, foot%outer, foot%outer_xi, at, a, b)
    g = matmul(transpose(a), a)
    d = matmul(x - at, a)
    det = g(1, 1)*g(2, 2) - g(1, 2)**2
    xi = foot%outer_xi
    if (.not. det > FLAT**2*g(1, 1)*g(2, 2)) return
    xi = xi + [g(2, 2)*d(1) - g(1, 2)*d(2), g(1, 1)*d(2) - g(1, 2)*d(1)]/det
  end function slide_beyond

  !> Unit vector from a surface towards a point outside it: the normal or, on a ridge or at a
  !! vertex, the direction of the distance.
  pure function direction(foot, x) result(n)
    type(foot_t), intent(in) :: foot         !! projection of the point
    real(wp), intent(in) :: x(3)             !! the point [L]
    real(wp) :: n(3)

    n = foot%n
    if (all(foot%free)) return
    if (abs(foot%gap) > NO_DIRECTION*maxval(abs(foot%a))) n = (x - foot%x)/foot%gap
  end function direction

  !> Move the sliding point from the projection so that the tangential vector from it to the point
  !! is `elastic`. The traction then stays the same if the load stays the same. On a curved surface,
  !! a single step along the tangents would not be exact.
  pure subroutine trail_behind(other, shape, x, foot, elastic, elem, xi)
    type(surface_t), intent(in) :: other
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)                 !! the point [L]
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: elastic(3)           !! [L]
    integer, intent(inout) :: elem               !! on entry, the element of the projection
    real(wp), intent(inout) :: xi(2)
    real(wp) :: rest(3), xs(3), a(3, 2), b(3, 3), n(3), last
    real(wp) :: next_xi(2)
    integer :: next, step
    logical :: clamped

    n = direction(foot, x)
    rest = -elastic
    last = huge(1.0_wp)
    do step = 1, MOST_STEPS
      next = elem
      next_xi = xi
      call walk(other, shape, next, next_xi, rest, clamped)
      call surface_point(other, shape, next, next_xi, xs, a, b)
      rest = x - xs
      rest = rest - dot_product(rest, n)*n - elastic
      if (.not. norm2(rest) < last) return ! rounding, or a fold
      last = 0.5_wp*norm2(rest)
      elem = next
      xi = next_xi
      if (clamped) return
    end do
  end subroutine trail_behind

end module contact_history
