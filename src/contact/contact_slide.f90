!> Positions of a side's points, and their stored sliding points when a step is accepted.
module contact_slide
  use base_kinds, only: wp
  use contact_foot, only: shape_t
  use contact_pair, only: surface_t, contact_points_t
  use contact_type, only: STICK, SLIP
  use contact_walk, only: walk
  implicit none
  private
  public :: side_positions, accept_slides

contains

  !> Positions of the integration points of element e.
  pure subroutine side_positions(surface, e, x, xp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) current positions [L]
    real(wp), intent(out) :: xp(:, :)    !! (3, nq)
    integer :: j, q
    real(wp) :: s, w

    associate (shp => surface%kind(surface%ikind(e))%shp, first => surface%first(e))
      do q = 1, size(xp, 2)
        xp(:, q) = 0.0_wp
        w = 0.0_wp
        do j = 1, size(shp, 1)
          s = shp(j, q)
          if (allocated(surface%w)) s = s*surface%w(first + j - 1)
          xp(:, q) = xp(:, q) + s*x(:, surface%node(first + j - 1))
          w = w + s
        end do
        if (allocated(surface%w)) xp(:, q) = xp(:, q)/w
      end do
    end associate
  end subroutine side_positions

  !> Sticking points keep their sliding point; a slipping one's follows its foot at the distance of
  !! the elastic part; all others' is their foot (Sauer and De Lorenzis 2015).
  subroutine accept_slides(other, shape, points)
    type(surface_t), intent(in) :: other
    type(shape_t), intent(in) :: shape
    type(contact_points_t), intent(inout) :: points
    logical :: clamped
    integer :: i

    do i = 1, size(points%state)
      if (points%state(i) == STICK .and. points%slide(i) > 0) cycle
      points%slide(i) = points%foot(i)
      points%slide_xi(:, i) = points%foot_xi(:, i)
      if (points%state(i) == SLIP .and. points%foot(i) > 0) &
        call walk(other, shape, points%slide(i), points%slide_xi(:, i), -points%elastic(:, i), &
        clamped)
    end do
  end subroutine accept_slides

end module contact_slide
