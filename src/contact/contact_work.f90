!> Contribution of an integration point to the forces of its element and to their derivatives.
!!
!! The force on node b of the element is N_b t da. With BALAnced, the force on node c of the partner
!! is -M_c(xi) t da, where M are the functions of the partner, and da includes the factor own_share.
!! The traction t and the area da vary, and at a projection xi varies too (vary_projection):
!!
!!   dxi_a = h_a.(dx - dx_p) + sum_b c_ab g.da_b,
!!
!! where x is the point, x_p its projection, and a_b are the tangents there.
!!
!! The parameters xi of the partner of a bond and of a sliding point are fixed.
module contact_work
  use base_kinds, only: wp
  use contact_pair, only: contact_t, surface_t, MORTAR
  use contact_point, only: vary_projection, outer
  use projection_type, only: foot_t
  use surface_basis, only: surface_functions_at, make_rational
  use tensor, only: cross
  implicit none
  private
  public :: work_t, new_work, reserve_partners, reserve_crosses, clear, add_own, add_partner, &
            add_back, add_cross, measure, position_on, position_at, sliding_position, tangents_on, &
            element_functions, sliding_functions, own_share, energy_share, loads_both

  !> Work arrays of one element and of its partners. These are the elements of the other side on
  !! which the projections, the sliding points and the bonded partners of its points lie. A slot is
  !! the position of an element in the list of partners.
  type :: work_t
    integer :: nk = 0                          !! nodes of the element
    logical :: secant = .false.                !! derivatives of friction are secants
    integer :: npartner = 0
    integer, allocatable :: partner(:)         !! elements of the other side
    real(wp), allocatable :: r(:, :)           !! (3, nk) force on the nodes, reversed [F]
    real(wp), allocatable :: kk(:, :)          !! (3*nk, 3*nk) dr/dx for the own nodes [F/L]
    real(wp), allocatable :: kl(:, :, :) !! (3*nk, 3*nl, npartner) dr/dx for nodes of partners [F/L]
    !> BALAnced, MORTar: force on the partners' nodes, reversed, and its derivatives with respect to
    !! the nodes of the element and to those of the partner.
    real(wp), allocatable :: back(:, :, :)     !! (3, nl, npartner) [F]
    real(wp), allocatable :: lk(:, :, :)       !! (3*nl, 3*nk, npartner) [F/L]
    real(wp), allocatable :: ll(:, :, :)       !! (3*nl, 3*nl, npartner)
    !> BALAnced, MORTar: derivatives of `back` of one partner, slot pair(1), with respect to the
    !! nodes of another one, slot pair(2).
    integer :: ncross = 0
    integer, allocatable :: pair(:, :)         !! (2, ncross)
    real(wp), allocatable :: cross(:, :, :)    !! (3*nl, 3*nl, ncross)
    integer :: slot = 0                        !! slot of the last add_partner
    integer :: back_slot = 0                   !! slot of the last add_back
    real(wp), allocatable :: back_shp(:)       !! functions of the partner of the last add_back
    real(wp), allocatable :: own(:), down(:, :) !! functions of the element at a point and
    !! their derivatives
    real(wp), allocatable :: shp(:), dshp(:, :) !! functions of the partner
    !> (3, 3, n) derivatives of a point's traction with respect to the nodes of its element, and to
    !! those of the partner.
    real(wp), allocatable :: own_q(:, :, :), q(:, :, :)
  end type work_t

contains

  !> Work arrays for the elements of side k of a contact.
  subroutine new_work(contact, k, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(work_t), intent(out) :: work
    integer :: mk, ml, m, n

    mk = maxval(contact%side(k)%basis%nsf)
    ml = maxval(contact%side(3 - k)%basis%nsf)
    m = max(mk, ml)
    n = 3*contact%nq ! each point has at most a bond, a projection and a sliding point
    if (contact%scheme == MORTAR) n = 8 ! see reserve_partners
    allocate (work%partner(n), work%r(3, mk), work%kk(3*mk, 3*mk))
    allocate (work%kl(3*mk, 3*ml, n), work%shp(m), work%dshp(2, m), work%own(m))
    allocate (work%down(2, m), work%own_q(3, 3, mk), work%q(3, 3, ml))
    if (.not. loads_both(contact)) return
    allocate (work%back(3, ml, n), work%lk(3*ml, 3*mk, n))
    allocate (work%ll(3*ml, 3*ml, n))
    allocate (work%back_shp(ml))
    if (.not. contact%friction%given) return
    allocate (work%pair(2, contact%nq), work%cross(3*ml, 3*ml, contact%nq))
  end subroutine new_work

  !> Make room for n partners of an element. The list of partners is kept; the contents of the other
  !! arrays are lost.
  pure subroutine reserve_partners(n, work)
    integer, intent(in) :: n
    type(work_t), intent(inout) :: work
    integer, allocatable :: partner(:)
    integer :: nk, nl, m

    if (n <= size(work%partner)) return
    m = 2*n
    nk = size(work%lk, 2)
    nl = size(work%lk, 1)
    allocate (partner(m), source=0)
    partner(:size(work%partner)) = work%partner
    call move_alloc(partner, work%partner)
    deallocate (work%kl, work%back, work%lk, work%ll)
    allocate (work%kl(nk, nl, m), work%back(3, nl/3, m), work%lk(nl, nk, m), work%ll(nl, nl, m))
  end subroutine reserve_partners

  !> Make room for n pairs of partners; the existing ones remain.
  pure subroutine reserve_crosses(n, work)
    integer, intent(in) :: n
    type(work_t), intent(inout) :: work
    integer, allocatable :: pair(:, :)
    real(wp), allocatable :: cross(:, :, :)
    integer :: m

    m = size(work%pair, 2)
    if (n <= m) return
    allocate (pair(2, 2*n), cross(size(work%cross, 1), size(work%cross, 2), 2*n))
    pair(:, :m) = work%pair
    cross(:, :, :m) = work%cross
    call move_alloc(pair, work%pair)
    call move_alloc(cross, work%cross)
  end subroutine reserve_crosses

  !> Fraction of its traction by which a point loads its own side: one half if the points
  !! of both bodies, or of both parts of a surface in self-contact, load each other.
  pure real(wp) function own_share(contact)
    type(contact_t), intent(in) :: contact

    own_share = merge(0.5_wp, 1.0_wp, loads_both(contact) .and. .not. any(contact%side%rigid))
  end function own_share

  !> Fraction of the energy of a side that belongs to the energy of the contact. If both sides are
  !! integrated, each of them finds the energy of the whole contact, whichever sides its points
  !! load; in self-contact, the points of side 1 find it twice.
  pure real(wp) function energy_share(contact)
    type(contact_t), intent(in) :: contact

    energy_share = merge(1.0_wp, 0.5_wp, any(contact%side%rigid))
  end function energy_share

  !> Do the points of a side load the other side too?
  pure logical function loads_both(contact)
    type(contact_t), intent(in) :: contact

    loads_both = contact%balanced .or. contact%scheme == MORTAR
  end function loads_both

  !> Functions of element e of a surface at a point, including the weights.
  pure subroutine element_functions(surface, e, xi, shp, dshp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: shp(:), dshp(:, :) !! (nsf), (2, nsf)

    call surface_functions_at(surface%basis(surface%ibasis(e)), xi, shp, dshp)
    if (allocated(surface%w)) call make_rational(surface%w(surface%first(e): &
                                                           surface%first(e + 1) - 1), shp, dshp)
  end subroutine element_functions

  !> Functions of element e at a sliding point. If the point lies beyond the element, which then is
  !! at the outer boundary, they are continued linearly from the closest point of the square
  !! [-1, 1]^2. They still sum to one.
  pure subroutine sliding_functions(surface, e, xi, shp, dshp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: shp(:), dshp(:, :) !! (nsf), (2, nsf)
    real(wp) :: near(2)

    near = max(-1.0_wp, min(1.0_wp, xi))
    call element_functions(surface, e, near, shp, dshp)
    if (any(abs(xi) > 1.0_wp)) shp = shp + matmul(xi - near, dshp)
  end subroutine sliding_functions

  !> Position of a sliding point, which may lie beyond a surface (sliding_functions).
  pure subroutine sliding_position(surface, e, xi, x, work, at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: at(3)
    integer :: j, n

    n = surface%basis(surface%ibasis(e))%nsf
    call sliding_functions(surface, e, xi, work%shp(:n), work%dshp(:, :n))
    at = 0.0_wp
    do j = 1, n
      at = at + work%shp(j)*x(:, surface%node(surface%first(e) + j - 1))
    end do
  end subroutine sliding_position

  !> Position of a parametric point of a surface.
  pure subroutine position_on(surface, e, xi, x, work, at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: at(3)
    integer :: n

    n = surface%basis(surface%ibasis(e))%nsf
    call position_at(surface, e, xi, x, work%shp(:n), work%dshp(:, :n), at)
  end subroutine position_on

  !> Position of a parametric point of a surface, and the functions there.
  pure subroutine position_at(surface, e, xi, x, shp, dshp, at)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2), x(:, :)     !! (3, nnode) current positions
    real(wp), intent(out) :: shp(:), dshp(:, :) !! (n), (2, n) functions and derivatives
    real(wp), intent(out) :: at(3)
    integer :: j

    call element_functions(surface, e, xi, shp, dshp)
    at = 0.0_wp
    do j = 1, size(shp)
      at = at + shp(j)*x(:, surface%node(surface%first(e) + j - 1))
    end do
  end subroutine position_at

  !> Unit normal and contravariant tangents at the point of the last position_on.
  pure subroutine tangents_on(surface, e, x, work, n, up)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: x(:, :)
    type(work_t), intent(in) :: work
    real(wp), intent(out) :: n(3), up(3, 2)    !! [-], [1/L]
    real(wp) :: a(3, 2), area
    integer :: j

    a = 0.0_wp
    do j = 1, surface%first(e + 1) - surface%first(e)
      associate (xj => x(:, surface%node(surface%first(e) + j - 1)))
        a(:, 1) = a(:, 1) + work%dshp(1, j)*xj
        a(:, 2) = a(:, 2) + work%dshp(2, j)*xj
      end associate
    end do
    call raise(a, n, up, area)
  end subroutine tangents_on

  !> Position of integration point q, contravariant tangents, and area per unit area of the
  !! parameters.
  pure subroutine measure(own, e, q, x, work, xq, up, area)
    type(surface_t), intent(in) :: own
    integer, intent(in) :: e, q
    real(wp), intent(in) :: x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: xq(3), up(3, 2), area
    real(wp) :: a(3, 2), n(3)
    integer :: j

    associate (basis => own%basis(own%ibasis(e)), &
               node => own%node(own%first(e):own%first(e + 1) - 1))
      work%own(:basis%nsf) = basis%shp(:, q)
      work%down(:, :basis%nsf) = basis%dshp(:, :, q)
      if (allocated(own%w)) call make_rational(own%w(own%first(e):own%first(e + 1) - 1), &
                                               work%own(:basis%nsf), work%down(:, :basis%nsf))
      xq = 0.0_wp
      a = 0.0_wp
      do j = 1, basis%nsf
        xq = xq + work%own(j)*x(:, node(j))
        a(:, 1) = a(:, 1) + work%down(1, j)*x(:, node(j))
        a(:, 2) = a(:, 2) + work%down(2, j)*x(:, node(j))
      end do
    end associate
    call raise(a, n, up, area)
  end subroutine measure

  !> Unit normal, contravariant tangents and area, from two tangents. All are zero if the tangents
  !! are parallel.
  pure subroutine raise(a, n, up, area)
    real(wp), intent(in) :: a(3, 2)
    real(wp), intent(out) :: n(3), up(3, 2), area
    real(wp) :: m(2, 2)

    n = cross(a(:, 1), a(:, 2))
    area = norm2(n)
    m = matmul(transpose(a), a)
    up = 0.0_wp
    if (.not. area > 0.0_wp) return
    n = n/area
    up(:, 1) = (m(2, 2)*a(:, 1) - m(1, 2)*a(:, 2))/area**2
    up(:, 2) = (m(1, 1)*a(:, 2) - m(1, 2)*a(:, 1))/area**2
  end subroutine raise

  !> Zero the sums of an element before its first active point.
  pure subroutine clear(work)
    type(work_t), intent(inout) :: work

    if (work%npartner > 0) return
    work%ncross = 0
    work%r = 0.0_wp
    work%kk(:, :3*work%nk) = 0.0_wp
  end subroutine clear

  !> Add the force on the nodes of the element, and its derivatives with respect to these nodes, on
  !! which the position of the point and its area depend.
  pure subroutine add_own(t, dtdx, up, da, work)
    real(wp), intent(in) :: t(3)                 !! traction [F/L^2]
    real(wp), intent(in) :: dtdx(3, 3)           !! derivative with respect to the point
    real(wp), intent(in) :: up(3, 2), da         !! contravariant tangents, area [L^2]
    type(work_t), intent(inout) :: work
    real(wp) :: v(3)
    integer :: b, j, n

    n = work%nk
    do b = 1, n
      work%r(:, b) = work%r(:, b) - work%own(b)*da*t
      v = up(:, 1)*work%down(1, b) + up(:, 2)*work%down(2, b)
      do j = 1, 3
        work%own_q(:, j, b) = dtdx(:, j)*work%own(b) + t*v(j)
      end do
    end do
    call spread_rows(n, n, work%own, work%own_q, da, size(work%kk, 1), work%kk)
  end subroutine add_own

  !> Add the derivatives of the force of add_own with respect to the nodes of an element of the
  !! other side.
  pure subroutine add_partner(other, e, xi, dtdx, dtda, da, work)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)                !! of a projection, sliding point or bonded partner
    real(wp), intent(in) :: dtdx(3, 3)           !! derivative with respect to the point xi of e
    real(wp), intent(in) :: dtda(3, 3, 2), da !! derivative with respect to the tangents; area [L^2]
    type(work_t), intent(inout) :: work
    integer :: b, n, slot

    call find_slot(e, work)
    slot = work%slot
    n = other%basis(other%ibasis(e))%nsf
    call sliding_functions(other, e, xi, work%shp(:n), work%dshp(:, :n))
    do b = 1, n
      work%q(:, :, b) = dtdx*work%shp(b) + dtda(:, :, 1)*work%dshp(1, b) &
                        + dtda(:, :, 2)*work%dshp(2, b)
    end do
    call spread_rows(work%nk, n, work%own, work%q, da, size(work%kl, 1), work%kl(:, :, slot))
  end subroutine add_partner

  !> Find the slot of a partner. A partner without a slot is assigned a new one.
  pure subroutine find_slot(e, work)
    integer, intent(in) :: e
    type(work_t), intent(inout) :: work
    integer :: slot

    do slot = 1, work%npartner
      if (work%partner(slot) == e) exit
    end do
    if (slot > work%npartner) then
      work%npartner = slot
      work%partner(slot) = e
      work%kl(:, :, slot) = 0.0_wp
      if (allocated(work%back)) then
        work%back(:, :, slot) = 0.0_wp
        work%lk(:, :, slot) = 0.0_wp
        work%ll(:, :, slot) = 0.0_wp
      end if
    end if
    work%slot = slot
  end subroutine find_slot

  !> With BALAnced, add the opposite force on the partner of the last add_partner. add_own and
  !! add_partner must have been called for this traction, because the columns that they set are
  !! used.
  pure subroutine add_back(other, e, t, da, work, foot, x)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: t(3)                 !! traction on the side of the point [F/L^2]
    real(wp), intent(in) :: da                   !! area [L^2], as in add_own
    type(work_t), intent(inout) :: work
    type(foot_t), intent(in), optional :: foot   !! projection where it acts; absent: fixed xi
    real(wp), intent(in), optional :: x(3)       !! the point [L]
    real(wp) :: h(3, 2), c(2, 2), g(3), q(3, 3, size(work%shp)), slope(size(work%shp))
    integer :: a, b, n

    n = other%basis(other%ibasis(e))%nsf
    associate (slot => work%slot)
      do b = 1, n
        work%back(:, b, slot) = work%back(:, b, slot) + work%shp(b)*da*t
      end do
      call spread_rows(n, work%nk, work%shp, work%own_q, -da, size(work%lk, 1), &
                       work%lk(:, :, slot))
      call spread_rows(n, n, work%shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
      work%back_slot = slot
      work%back_shp(:n) = work%shp(:n)
      if (.not. present(foot)) return
      call vary_projection(foot, x, h, c, g) ! sum_a M_c,a t dxi_a da
      do a = 1, 2
        slope(:n) = work%dshp(a, :n)
        do b = 1, work%nk
          q(:, :, b) = outer(t, work%own(b)*h(:, a))
        end do
        call spread_rows(n, work%nk, slope, q, -da, size(work%lk, 1), work%lk(:, :, slot))
        do b = 1, n
          q(:, :, b) = outer(t, (c(a, 1)*work%dshp(1, b) + c(a, 2)*work%dshp(2, b))*g &
                             - work%shp(b)*h(:, a))
        end do
        call spread_rows(n, n, slope, q, -da, size(work%ll, 1), work%ll(:, :, slot))
      end do
    end associate
  end subroutine add_back

  !> With BALAnced and friction, add the derivative of the force of the last add_back with respect
  !! to the sliding point, for which add_partner has been called in the meantime.
  pure subroutine add_cross(other, da, work)
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: da
    type(work_t), intent(inout) :: work
    integer :: i

    associate (slot => work%back_slot, &
               n => other%basis(other%ibasis(work%partner(work%back_slot)))%nsf, &
               m => other%basis(other%ibasis(work%partner(work%slot)))%nsf)
      if (work%slot == slot) then
        call spread_rows(n, m, work%back_shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
        return
      end if
      do i = 1, work%ncross
        if (all(work%pair(:, i) == [slot, work%slot])) exit
      end do
      if (i > work%ncross) then
        work%ncross = i
        work%pair(:, i) = [slot, work%slot]
        work%cross(:, :, i) = 0.0_wp
      end if
      call spread_rows(n, m, work%back_shp, work%q, -da, size(work%cross, 1), work%cross(:, :, i))
    end associate
  end subroutine add_cross

  !> k(i a, j b) = k(i a, j b) - N_a q(i, j, b) da.
  pure subroutine spread_rows(na, nb, shp, q, da, ld, k)
    integer, intent(in) :: na, nb, ld
    real(wp), intent(in) :: shp(na), q(3, 3*nb), da
    real(wp), intent(inout) :: k(ld, 3*nb)
    real(wp) :: s(3*na)
    integer :: a, c, i

    do a = 1, na
      s(3*a - 2:3*a) = shp(a)*da
    end do
    do c = 1, 3*nb
      do a = 1, na
        do i = 1, 3
          k(3*(a - 1) + i, c) = k(3*(a - 1) + i, c) - s(3*(a - 1) + i)*q(i, c)
        end do
      end do
    end do
  end subroutine spread_rows

end module contact_work
