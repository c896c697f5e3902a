!> Positions of a side's points, and their stored sliding points when a step is accepted.
module contact_slide
  use base_kinds, only: wp
  use contact_foot, only: foot_t, shape_t
  use contact_pair, only: surface_t, contact_points_t
  use contact_shape, only: surface_point
  use contact_type, only: STICK, SLIP
  use contact_walk, only: walk
  implicit none
  private
  public :: side_positions, accept_slides

  integer, parameter :: MOST_STEPS = 20
  !> A gap this small, relative to the tangents, has no direction.
  real(wp), parameter :: NO_DIRECTION = 1.0e-12_wp

contains

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

    associate (shp => surface%kind(surface%ikind(e))%shp, first => surface%first(e))
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
          points%slide(i) = feet(i)%border
          points%slide_xi(:, i) = feet(i)%border_xi
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

end module contact_slide
