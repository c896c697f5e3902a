!> The largest penetration of the corners of surface elements.
!!
!! Integration points lie inside the elements. Where a body stands on an edge or on a corner, or
!! where two edges cross, the corners of the elements penetrate much deeper than any point at which
!! contact acts. Results and warnings about the penetration therefore include the corners.
module contact_corners
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, contact_state_t, is_released, surface_t
  use projection, only: project, project_from
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
  !! rounding. Corners of rigid sides and of elements with bonds are left out.
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

  !> Largest penetration of the corners of side k into the other side [L]. The penetration of a
  !! corner is its distance from the closest point of those surfaces that one of its elements faces.
  !! Corners of elements with bonds that are not released are left out: where such bonds join curved
  !! surfaces, the corners of one mesh lie inside the other from the start.
  pure real(wp) function deepest_corner(contact, k, shape, grid, points) result(deepest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid           !! grid of the other side
    type(contact_points_t), intent(in) :: points
    type(foot_t) :: foot
    real(wp) :: x(3), a(3, 2), b(3, 3)
    real(wp), allocatable :: normals(:, :)     !! normals of the elements of a corner
    integer :: j, q, v

    deepest = 0.0_wp
    associate (own => contact%side(k), other => contact%side(3 - k))
      do v = 1, size(own%ring_first) - 1
        j = own%ring_first(v)
        if (own%ring_first(v + 1) == j) cycle
        call surface_point(own, shape(k), own%ring_elem(j), CORNER_XI(:, own%ring_corner(j)), x, &
                           a, b)
        foot%elem = 0
        call project(other, shape(3 - k), grid, x, foot, contact%depth)
        if (.not. touches(foot, contact%depth)) cycle
        if (.not. -foot%gap > deepest) cycle
        normals = normals_at(own, shape(k), v)
        call find_closest(other, shape(3 - k), x, normals, foot)
        if (foot%elem == 0 .or. .not. -foot%gap > deepest) cycle
        if (any([((is_held((own%ring_elem(j) - 1)*contact%nq + q), q=1, contact%nq), &
                  j=own%ring_first(v), own%ring_first(v + 1) - 1)])) cycle
        deepest = -foot%gap
      end do
    end associate

  contains

    !> Does a bond hold point i?
    pure logical function is_held(i)
      integer, intent(in) :: i

      is_held = points%bond(i) > 0
      if (is_held) is_held = .not. is_released(contact, points, i)
    end function is_held

  end function deepest_corner

  !> Normals of the elements around vertex v at this vertex; their lengths are arbitrary.
  pure function normals_at(surface, shape, v) result(normals)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: v
    real(wp), allocatable :: normals(:, :)     !! (3, number of elements)
    real(wp) :: x(3), a(3, 2), b(3, 3)
    integer :: first, j

    first = surface%ring_first(v)
    allocate (normals(3, surface%ring_first(v + 1) - first))
    do j = first, surface%ring_first(v + 1) - 1
      call surface_point(surface, shape, surface%ring_elem(j), &
                         CORNER_XI(:, surface%ring_corner(j)), x, a, b)
      normals(:, j - first + 1) = cross(a(:, 1), a(:, 2))
    end do
  end function normals_at

  !> Among the projection of x and closer ones on other elements, find the closest one at which the
  !! surface faces one of the given normals; foot%elem = 0 if there is none. A projection is the
  !! closest point near its start only: where elements are large, the start for a point that lies
  !! beneath the bottom of a tool may be on a side of the tool.
  pure subroutine find_closest(surface, shape, x, normals, foot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3)               !! [L]
    real(wp), intent(in) :: normals(:, :)
    type(foot_t), intent(inout) :: foot
    type(foot_t) :: other
    real(wp) :: least
    integer :: e

    least = abs(foot%gap)
    if (.not. faces(foot)) foot%elem = 0
    do e = 1, surface%nelem
      if (norm2(max(0.0_wp, shape%low(:, e) - x, x - shape%high(:, e))) >= least) cycle
      other%elem = e
      other%xi = 0.0_wp
      call project_from(surface, shape, x, other)
      if (other%elem == 0 .or. .not. abs(other%gap) < least) cycle
      if (.not. faces(other)) cycle
      foot = other
      least = abs(foot%gap)
    end do

  contains

    pure logical function faces(foot)
      type(foot_t), intent(in) :: foot

      faces = any(matmul(foot%n, normals) < 0.0_wp)
    end function faces

  end subroutine find_closest

end module contact_corners
