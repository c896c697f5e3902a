!> History of the integration points of contacts: made, accepted, brought back.
!!
!! Positions of a side's points, and their stored sliding points when a step is accepted.
module contact_history
  use base_kinds, only: wp
  use projection_type, only: foot_t, shape_t
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, surface_t
  use contact_type, only: OPEN, MAX_PAST, STICK, SLIP
  use surface_geometry, only: surface_point
  use surface_traversal, only: walk
  implicit none
  private
  public :: new_contact_state, restore_contact_step, keep_contact_step, had_touched, look_aside, &
            side_positions, accept_slides

  real(wp), parameter, public :: ASIDE = 0.1_wp !! of DEPTh: at a surface, not far off it

  integer, parameter :: MOST_STEPS = 20
  !> A gap this small, relative to the tangents, has no direction.
  real(wp), parameter :: NO_DIRECTION = 1.0e-12_wp

contains

  !> No point has a foot yet; a rigid side has no points.
  subroutine new_contact_state(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(out) :: state
    integer :: k, np

    do k = 1, 2
      np = contact%side(k)%nelem*contact%nq
      if (contact%side(k)%rigid) np = 0
      call new_points(np, np/max(1, contact%nq), state%side(k))
    end do
  end subroutine new_contact_state

  subroutine new_points(np, nelem, points)
    integer, intent(in) :: np, nelem
    type(contact_points_t), intent(out) :: points

    allocate (points%foot(np), points%foot_step(np), points%slide(np), source=0)
    allocate (points%foot_xi(2, np), points%foot_xi_step(2, np), points%slide_xi(2, np), &
              source=0.0_wp)
    allocate (points%multiplier(np), points%multiplier_step(np), source=0.0_wp)
    allocate (points%pressure(np), points%area(np), source=0.0_wp)
    allocate (points%gap(np), source=huge(1.0_wp))
    allocate (points%traction(3, np), points%elastic(3, np), source=0.0_wp)
    allocate (points%friction(3, np), points%cohesion(3, np), source=0.0_wp)
    allocate (points%state(np), points%state_step(np), source=OPEN)
    allocate (points%slip(np), points%slip_rate(np), source=0.0_wp)
    allocate (points%aside(np), points%cut(nelem), source=.false.)
    allocate (points%bond(np), source=0)
    allocate (points%bond_xi(2, np), points%area0(np), points%opening(np), source=0.0_wp)
    allocate (points%past(MAX_PAST, np), points%past_step(MAX_PAST, np), source=0.0_wp)
    allocate (points%opening_step(np), source=0.0_wp)
    allocate (points%energy(3, np), points%pull(3, np), source=0.0_wp)
  end subroutine new_points

  !> A cut: projections start where they stood at the start of the step.
  subroutine restore_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    do k = 1, 2
      state%side(k)%foot = state%side(k)%foot_step
      state%side(k)%foot_xi = state%side(k)%foot_xi_step
      state%side(k)%multiplier = state%side(k)%multiplier_step
      state%side(k)%past = state%side(k)%past_step
      state%side(k)%opening = state%side(k)%opening_step
      state%side(k)%state = state%side(k)%state_step
      state%side(k)%fresh = .true.
    end do
  end subroutine restore_contact_step

  !> The step is done: what is now is what a cut brings back.
  subroutine keep_contact_step(state)
    type(contact_state_t), intent(inout) :: state
    integer :: k

    do k = 1, 2
      state%side(k)%foot_step = state%side(k)%foot
      state%side(k)%foot_xi_step = state%side(k)%foot_xi
      state%side(k)%multiplier_step = state%side(k)%multiplier
      state%side(k)%past_step = state%side(k)%past
      state%side(k)%opening_step = state%side(k)%opening
      state%side(k)%state_step = state%side(k)%state
      state%side(k)%slip_rate = 0.0_wp
      if (state%side(k)%dt > 0.0_wp) then
        state%side(k)%slip_rate = state%side(k)%slip/state%side(k)%dt
      end if
      state%side(k)%fresh = .true.
    end do
  end subroutine keep_contact_step

  !> Feet of an accepted step: which points stand beside the other surface, no higher than `depth`
  !! above its tangent plane, or have stood there and are deeper now.
  pure subroutine look_aside(feet, depth, points)
    type(foot_t), intent(in) :: feet(:)    !! (np)
    real(wp), intent(in) :: depth          !! [L]
    type(contact_points_t), intent(inout) :: points
    integer :: i

    do i = 1, size(feet)
      if (feet(i)%elem > 0) then
        points%aside(i) = points%aside(i) .and. feet(i)%gap < -depth
      else if (feet(i)%outer > 0) then
        points%aside(i) = feet(i)%outer_gap < depth
      end if
    end do
  end subroutine look_aside

  !> A point was in contact when the last step ended.
  pure logical function had_touched(state)
    type(contact_state_t), intent(in) :: state

    had_touched = any(state%side(1)%state_step /= OPEN) &
                  .or. any(state%side(2)%state_step /= OPEN)
  end function had_touched

  !> Positions of integration points of element e: those behind `from`, as many as xp has room for.
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

  !> Sticking points keep their sliding point; a slipping one's follows its foot at the distance of
  !! the elastic part; all others' is their foot (Sauer and De Lorenzis 2015), or the border where
  !! they lie beyond it: friction acts in the step that brings them in.
  subroutine accept_slides(own, other, shape, x, feet, points)
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape           !! of the other side
    real(wp), intent(in) :: x(:, :)              !! (3, nnode) current positions [L]
    type(foot_t), intent(in) :: feet(:)          !! (np)
    type(contact_points_t), intent(inout) :: points
    real(wp), allocatable :: xp(:, :)
    integer :: e, i, q

    allocate (xp(3, size(feet)/max(1, own%nelem)))
    do e = 1, own%nelem
      call side_positions(own, e, x, xp)
      do q = 1, size(xp, 2)
        i = (e - 1)*size(xp, 2) + q
        if (points%state(i) == STICK .and. points%slide(i) > 0) cycle
        points%slide(i) = points%foot(i)
        points%slide_xi(:, i) = points%foot_xi(:, i)
        if (points%foot(i) == 0) then ! it will come in over the border
          points%slide(i) = feet(i)%outer
          points%slide_xi(:, i) = feet(i)%outer_xi
        end if
        if (points%state(i) == SLIP .and. points%foot(i) > 0) then
          call follow(other, shape, xp(:, q), feet(i), points%elastic(:, i), points%slide(i), &
                      points%slide_xi(:, i))
        end if
      end do
    end do
  end subroutine accept_slides

  !> Walk from the foot to where the tangential way to the point is `elastic`: then a load that is
  !! held finds the same traction again. On a curved surface one step along the tangents ends
  !! beside it.
  pure subroutine follow(other, shape, x, foot, elastic, elem, xi)
    type(surface_t), intent(in) :: other
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)                 !! the point [L]
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: elastic(3)           !! [L]
    integer, intent(inout) :: elem               !! in: the foot's
    real(wp), intent(inout) :: xi(2)
    real(wp) :: way(3), xs(3), a(3, 2), b(3, 3), n(3), last
    real(wp) :: next_xi(2)
    integer :: next, step
    logical :: clamped

    n = foot%n
    if (.not. all(foot%free) .and. abs(foot%gap) > NO_DIRECTION*maxval(abs(foot%a))) then
      n = (x - foot%x)/foot%gap
    end if
    way = -elastic
    last = huge(1.0_wp)
    do step = 1, MOST_STEPS
      next = elem
      next_xi = xi
      call walk(other, shape, next, next_xi, way, clamped)
      call surface_point(other, shape, next, next_xi, xs, a, b)
      way = x - xs
      way = way - dot_product(way, n)*n - elastic
      if (.not. norm2(way) < last) return ! rounding, or a fold
      last = 0.5_wp*norm2(way)
      elem = next
      xi = next_xi
      if (clamped) return
    end do
  end subroutine follow

end module contact_history
