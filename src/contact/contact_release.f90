!> The release of bonds: the quantity that ARCLength LOCAl controls.
module contact_release
  use base_kinds, only: wp
  use constraint, only: fold_force
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use contact_work, only: measure, position_on, work_t, new_work
  use model, only: model_t, state_t
  implicit none
  private
  public :: add_release, bonded_area, find_release

  !> Opening at which a bond counts as released (the larger of `contact%released`), divided by the
  !! opening d that scales the release. With the exponential law, d is the opening g_char of the
  !! law.
  real(wp), parameter :: OPENINGS = 8.0_wp

contains

  !> Add the release of side k and its derivative. The release is the sum, over bonded points, of
  !! their area times 1 - (1 + r/d) exp(-r/d), where r is the current opening.
  !!
  !! The factor 1 - (1 + r/d) exp(-r/d) is the released fraction of the energy of an exponential
  !! bond (eq. 31 of Corbett and Sauer 2015). For bonds of every law, the measure increases as a
  !! crack advances.
  subroutine add_release(contact, k, x, scale, points, released, slope)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    real(wp), intent(in) :: scale                  !! opening d, see OPENINGS [L]
    type(contact_points_t), intent(in) :: points
    real(wp), intent(inout) :: released            !! [L^2]
    real(wp), intent(inout) :: slope(:, :)         !! (3, nnode) derivative of the release [L]
    type(work_t) :: work
    real(wp) :: g(3), up(3, 2), xp(3), c, r, area
    integer :: e, i, m, n, q

    call new_work(contact, k, work)
    associate (own => contact%side(k), other => contact%side(3 - k))
      do e = 1, own%nelem
        do q = 1, contact%nq
          i = (e - 1)*contact%nq + q
          if (points%bond(i) == 0) cycle
          m = own%basis(own%ibasis(e))%nsf
          n = other%basis(other%ibasis(points%bond(i)))%nsf
          call measure(own, e, q, x, work, xp, up, area)
          call position_on(other, points%bond(i), points%bond_xi(:, i), x, work, g)
          g = xp - g
          r = norm2(g)/scale
          released = released + points%area0(i)*(1.0_wp - (1.0_wp + r)*exp(-r))
          c = points%area0(i)*exp(-r)/scale**2
          call spread_slope(own, e, work%own(:m), c*g, slope)
          call spread_slope(other, points%bond(i), work%shp(:n), -c*g, slope)
        end do
      end do
    end associate
  end subroutine add_release

  !> Add a vector to the nodes of an element, weighted with their functions.
  pure subroutine spread_slope(surface, e, shp, v, slope)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: shp(:), v(3)
    real(wp), intent(inout) :: slope(:, :)
    integer :: j, n

    do j = 1, size(shp)
      n = surface%node(surface%first(e) + j - 1)
      slope(:, n) = slope(:, n) + shp(j)*v
    end do
  end subroutine spread_slope

  !> Reference area of all bonded points of both sides [L^2], which equals the release when all
  !! bonds are open.
  pure real(wp) function bonded_area(model, state) result(area)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: c, k

    area = 0.0_wp
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%cohesive%given) cycle
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        associate (points => state%contact(c)%side(k))
          area = area + sum(points%area0, mask=points%bond > 0)
        end associate
      end do
    end do
  end function bonded_area

  !> Find the release of all bonds at the displacements u, and its derivative.
  subroutine find_release(model, state, u, released, slope)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: u(:, :)                !! (3, nnode) [L]
    real(wp), intent(out) :: released              !! [L^2]
    real(wp), intent(out) :: slope(:, :)           !! (3, nnode) [L]
    real(wp), allocatable :: x(:, :)
    integer :: c, k

    released = 0.0_wp
    slope = 0.0_wp
    allocate (x, source=model%mesh%xr + u)
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%cohesive%given) cycle
      do k = 1, 2
        if (model%contact(c)%side(k)%rigid) cycle
        call add_release(model%contact(c), k, x, maxval(model%contact(c)%released)/OPENINGS, &
                         state%contact(c)%side(k), released, slope)
      end do
    end do
    call fold_force(model%mesh%constraint, slope)
  end subroutine find_release

end module contact_release
