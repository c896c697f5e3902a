!> The largest penetration of the corners of surface elements.
!!
!! Integration points lie inside the elements. Where a body stands on an edge or on a corner, or
!! where two edges cross, the corners of the elements penetrate much deeper than any point at which
!! contact acts. Results and warnings about the penetration therefore include the corners.
module contact_corners
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, contact_state_t
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces
  use projection_type, only: foot_t, shape_t, touches
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: deepest_corner, corner_overlap, CORNER_XI

  !> Parameters of corners 1 to 4 of an element.
  real(wp), parameter :: CORNER_XI(2, 4) = reshape([-1, -1, 1, -1, -1, 1, 1, 1]*1.0_wp, [2, 4])

  !> A penetration that is smaller than this fraction of the size of the smallest element is due to
  !! rounding.
  real(wp), parameter :: ROUNDING = 1.0e-6_wp

contains

  !> Largest penetration of the corners of both sides at the positions x [L]; 0 if it is due to
  !! rounding. Corners of rigid sides and of bonded elements are left out.
  function corner_overlap(contact, x, state) result(overlap)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)            !! (3, nnode) [L]
    type(contact_state_t), intent(in) :: state
    real(wp) :: overlap
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    integer :: k

    call place_surfaces(contact, x, shape, grid)
    overlap = 0.0_wp
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      overlap = max(overlap, deepest_corner(contact, k, shape, grid(3 - k), state%side(k)))
      if (.not. allocated(contact%side(k)%width)) cycle
      if (overlap <= ROUNDING*minval(contact%side(k)%width)) overlap = 0.0_wp
    end do
  end function corner_overlap

  !> Largest penetration of the corners of side k into the other side [L]. A corner is included if
  !! one of its elements faces the surface onto which the corner is projected. Corners of bonded
  !! elements are left out, as bonded points are.
  pure real(wp) function deepest_corner(contact, k, shape, grid, points) result(deepest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid           !! grid of the other side
    type(contact_points_t), intent(in) :: points
    type(foot_t) :: foot
    real(wp) :: x(3), a(3, 2), b(3, 3)
    integer :: i, j, q, v
    logical :: faces

    deepest = 0.0_wp
    associate (own => contact%side(k))
      do v = 1, size(own%ring_first) - 1
        faces = .false.
        do j = own%ring_first(v), own%ring_first(v + 1) - 1
          i = (own%ring_elem(j) - 1)*contact%nq
          if (any([(points%bond(i + q) > 0, q=1, contact%nq)])) exit
          call surface_point(own, shape(k), own%ring_elem(j), CORNER_XI(:, own%ring_corner(j)), x, &
                             a, b)
          if (j == own%ring_first(v)) then
            foot%elem = 0
            call project(contact%side(3 - k), shape(3 - k), grid, x, foot, contact%depth)
            if (.not. touches(foot, contact%depth)) exit
            if (.not. -foot%gap > deepest) exit
          end if
          faces = faces .or. dot_product(cross(a(:, 1), a(:, 2)), foot%n) < 0.0_wp
        end do
        if (j == own%ring_first(v + 1) .and. faces) deepest = -foot%gap
      end do
    end associate
  end function deepest_corner

end module contact_corners
