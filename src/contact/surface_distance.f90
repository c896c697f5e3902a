!> The distance between the two surfaces of a contact.
module surface_distance
  use base_kinds, only: wp
  use contact_pair, only: contact_t
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces
  use projection_type, only: foot_t, shape_t
  use self_search, only: nearness_t, search_itself
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: find_distance

  real(wp), parameter :: SAME = 1.0e-6_wp !! difference between equal directions, and between equal
  !! distances relative to the size of both surfaces

contains

  !> The smallest distance between an integration point of one surface and the other surface, or
  !! zero if a point penetrates; points deeper than DEPTh are left out. If no point is left, it is
  !! the distance between the boxes around both surfaces. In self-contact, it is the smallest
  !! distance between parts that face each other, and huge if there are no such parts.
  real(wp) function find_distance(contact, xr, x, towards) result(distance)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :), x(:, :) !! (3, nnode) before the deformation, and now [L]
    !> Direction in which side 1 approaches side 2 where they are nearest; zero if it is not known
    !! or if points in different directions are equally near.
    real(wp), intent(out), optional :: towards(3)
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    type(nearness_t) :: near
    real(wp) :: xp(3), a(3, 2), b(3, 3), low(3, 2), high(3, 2), way(3), rounding
    logical :: unique
    integer :: e, k, q

    if (present(towards)) towards = 0.0_wp
    if (contact%self) then
      associate (node => contact%side(1)%node)
        call search_itself(contact, xr, x, norm2(maxval(x(:, node), 2) - minval(x(:, node), 2)), &
                           near)
      end associate
      distance = near%gap
      return
    end if
    call place_surfaces(contact, x, shape, grid)
    do k = 1, 2
      low(:, k) = minval(shape(k)%low, 2)
      high(:, k) = maxval(shape(k)%high, 2)
    end do
    distance = huge(distance)
    rounding = SAME*norm2(maxval(high, 2) - minval(low, 2))
    unique = .true.
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot)
          if (foot%elem == 0 .or. foot%gap < -contact%depth) cycle
          if (present(towards)) then
            way = merge(-1.0_wp, 1.0_wp, k == 1)*direction(foot, xp)
            if (abs(max(foot%gap, 0.0_wp) - distance) <= rounding) then
              if (norm2(way - towards) > SAME) unique = .false.
            else if (foot%gap < distance) then
              unique = .true.
            end if
            if (max(foot%gap, 0.0_wp) < distance) towards = way
          end if
          distance = min(distance, max(foot%gap, 0.0_wp))
        end do
      end do
    end do
    if (present(towards) .and. .not. unique) towards = 0.0_wp
    if (distance < huge(distance)) return
    distance = norm2(max(0.0_wp, low(:, 1) - high(:, 2), low(:, 2) - high(:, 1)))
  end function find_distance

  !> The direction from a projection to its point. It is normal to the surface, except on ridges and
  !! at vertices.
  pure function direction(foot, x) result(d)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: x(3)              !! the point [L]
    real(wp) :: d(3)

    d = foot%n
    if (.not. all(foot%free) .and. foot%gap > 0.0_wp) d = (x - foot%x)/foot%gap
  end function direction

end module surface_distance
