!> From element to element of a surface: where the distance to a point falls further.
module contact_border
  use base_kinds, only: wp
  use contact_foot, only: shape_t
  use contact_pair, only: surface_t
  use contact_spot, only: spot_t, look_at, is_rounding
  use contact_walk, only: step_across
  implicit none
  private
  public :: change_element, leave_point, corner_at, corner_xi

  !> So close to an edge that is a point other elements round it are asked.
  real(wp), parameter :: BESIDE = 1.0e-3_wp

contains

  !> To an element behind the edges, or round the vertex, where the distance falls.
  pure subroutine change_element(surface, shape, x, edge, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: edge(2)
    type(spot_t), intent(inout) :: spot
    logical, intent(out) :: moved
    type(spot_t) :: other
    integer :: i, elem, behind
    real(wp) :: xi(2)

    do i = 1, 2
      if (edge(i) == 0) cycle
      elem = spot%elem
      xi = spot%xi
      if (surface%neighbour(edge(i), elem) == 0) cycle
      call step_across(surface, edge(i), elem, xi, behind)
      call look_at(surface, shape, elem, xi, x, other)
      moved = falls_inwards(other, (behind + 1)/2)
      if (moved) then
        spot = other
        return
      end if
    end do
    moved = .false.
    if (all(edge > 0)) call look_round(surface, shape, x, corner_at(spot%xi), spot, moved)
  end subroutine change_element

  !> Beside an edge that is a point: to an element round it where the distance falls.
  pure subroutine leave_point(surface, shape, x, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(spot_t), intent(inout) :: spot
    logical, intent(out) :: moved
    integer :: i

    moved = .false.
    if (.not. allocated(surface%point)) return
    do i = 1, 2
      if (1.0_wp - abs(spot%xi(i)) > BESIDE) cycle
      if (.not. surface%point(merge(2*i - 1, 2*i, spot%xi(i) < 0.0_wp), spot%elem)) cycle
      call look_round(surface, shape, x, corner_at(spot%xi), spot, moved)
      return
    end do
  end subroutine leave_point

  !> To an element round a corner of the spot's element where the distance falls.
  pure subroutine look_round(surface, shape, x, c, spot, moved)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: c
    type(spot_t), intent(inout) :: spot
    logical, intent(out) :: moved
    type(spot_t) :: other
    integer :: vertex, r, elem

    moved = .false.
    vertex = surface%vertex(c, spot%elem)
    do r = surface%ring_first(vertex), surface%ring_first(vertex + 1) - 1
      elem = surface%ring_elem(r)
      if (elem == spot%elem) cycle
      call look_at(surface, shape, elem, corner_xi(surface%ring_corner(r)), x, other)
      moved = falls_inwards(other, 1) .or. falls_inwards(other, 2)
      if (moved) then
        spot = other
        return
      end if
    end do
  end subroutine look_round

  !> Does the distance fall from a border inwards, in direction i?
  pure logical function falls_inwards(spot, i)
    type(spot_t), intent(in) :: spot
    integer, intent(in) :: i

    falls_inwards = spot%regular .and. spot%g(i)*spot%xi(i) < 0.0_wp
    if (falls_inwards) falls_inwards = .not. is_rounding(spot, i, spot%g(i)/spot%m(i))
  end function falls_inwards

  pure integer function corner_at(xi)
    real(wp), intent(in) :: xi(2)

    corner_at = merge(2, 1, xi(1) > 0.0_wp) + merge(2, 0, xi(2) > 0.0_wp)
  end function corner_at

  pure function corner_xi(c) result(xi)
    integer, intent(in) :: c
    real(wp) :: xi(2)

    xi = [merge(1.0_wp, -1.0_wp, mod(c, 2) == 0), merge(1.0_wp, -1.0_wp, c > 2)]
  end function corner_xi

end module contact_border
