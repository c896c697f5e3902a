!> Nodal forces of pressure, friction and cohesion apart, and the bonds' release.
!!
!! How much of the bonds of a model has been released: the measure that local control prescribes.
module contact_forces
  use base_kinds, only: wp
  use projection_type, only: foot_t
  use surface_basis, only: make_rational
  use contact_pair, only: contact_t, contact_points_t, surface_t
  use rigid_surface, only: put_force
  use contact_work, only: measure, own_share, position_on, work_t, new_work
  use constraint, only: fold_force
  use model, only: model_t, state_t
  implicit none
  private
  public :: add_shares, add_release, bonded_area, find_release

  !> A bond counts as released at so many openings d at its strength (`contact%released`).
  real(wp), parameter :: OPENINGS = 8.0_wp

contains

  !> Shares of the internal forces of what the last sweep found on side k.
  subroutine add_shares(contact, k, feet, points, f)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(foot_t), intent(in) :: feet(:)            !! (np)
    type(contact_points_t), intent(in) :: points
    real(wp), intent(inout) :: f(:, :, :)          !! (3, nnode, 3) pressure, friction, cohesion [F]
    real(wp) :: t(3, contact%nq, 3)
    real(wp), allocatable :: shp(:)
    real(wp) :: weight
    integer :: e, i, j, n, q

    weight = own_share(contact)
    associate (own => contact%side(k), other => contact%side(3 - k))
      do e = 1, own%nelem
        i = (e - 1)*contact%nq
        do q = 1, contact%nq
          t(:, q, :) = weight*shares(points, i + q)
        end do
        if (.not. any(abs(t) > 0.0_wp)) cycle
        do q = 1, contact%nq
          shp = own_functions(own, e, q)
          do j = 1, size(shp)
            n = own%node(own%first(e) + j - 1)
            f(:, n, :) = f(:, n, :) - shp(j)*t(:, q, :)
          end do
        end do
        if (.not. (other%rigid .or. contact%balanced)) cycle
        do q = 1, contact%nq
          call share_other(other, feet(i + q), i + q, t(:, q, :), weight, points, f)
        end do
      end do
    end associate
  end subroutine add_shares

  !> What the other side bears too: of a bond at the partner, all else at the foot.
  subroutine share_other(other, foot, i, t, weight, points, f)
    type(surface_t), intent(in) :: other
    type(foot_t), intent(in) :: foot
    integer, intent(in) :: i
    real(wp), intent(in) :: t(3, 3)                !! of point i [F]
    real(wp), intent(in) :: weight                 !! of its tractions that t has
    type(contact_points_t), intent(in) :: points
    real(wp), intent(inout) :: f(:, :, :)
    real(wp) :: press(3)

    press = t(:, 1)
    if (points%bond(i) > 0) then
      press = weight*points%area0(i)*(points%pull(:, i) - points%cohesion(:, i))
      call put_force(other, points%bond(i), points%bond_xi(:, i), press, f(:, :, 1))
      call put_force(other, points%bond(i), points%bond_xi(:, i), t(:, 3), f(:, :, 3))
      press = t(:, 1) - press
    end if
    if (foot%elem == 0) return
    call put_force(other, foot%elem, foot%xi, press, f(:, :, 1))
    call put_force(other, foot%elem, foot%xi, t(:, 2), f(:, :, 2))
  end subroutine share_other

  !> Forces of point i: its tractions times the areas they act on.
  pure function shares(points, i) result(t)
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: i
    real(wp) :: t(3, 3)

    t(:, 2) = points%friction(:, i)*points%area(i)
    t(:, 3) = points%cohesion(:, i)*points%area0(i)
    t(:, 1) = points%traction(:, i)*points%area(i) - t(:, 2) - t(:, 3)
  end function shares

  !> Functions of element e at its integration point q.
  pure function own_functions(own, e, q) result(shp)
    type(surface_t), intent(in) :: own
    integer, intent(in) :: e, q
    real(wp), allocatable :: shp(:)
    real(wp), allocatable :: dshp(:, :)

    shp = own%basis(own%ibasis(e))%shp(:, q)
    if (.not. allocated(own%w)) return
    dshp = own%basis(own%ibasis(e))%dshp(:, :, q)
    call make_rational(own%w(own%first(e):own%first(e + 1) - 1), shp, dshp)
  end function own_functions

  !> Release of side k: each bonded point's area times 1 - (1 + r/d) exp(-r/d), and its derivative.
  !!
  !! It is what an exponential bond (eq. 31) has given off of its energy, a measure that grows while
  !! a crack does, for bonds of every law.
  subroutine add_release(contact, k, x, scale, points, released, slope)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    real(wp), intent(in) :: scale                  !! d, the law's opening [L]
    type(contact_points_t), intent(in) :: points
    real(wp), intent(inout) :: released            !! [L^2]
    real(wp), intent(inout) :: slope(:, :)         !! (3, nnode) its derivative [L]
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

  !> Reference area of all bonded points, of both sides [L^2]: the release of a model without bonds
  !! left.
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

  !> Release of all bonds at the displacements u, and its derivative.
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
        call add_release(model%contact(c), k, x, model%contact(c)%released/OPENINGS, &
                         state%contact(c)%side(k), released, slope)
      end do
    end do
    call fold_force(model%mesh%constraint, slope)
  end subroutine find_release

end module contact_forces
