!> What an integration point adds to its element's forces and to their derivatives.
module contact_work
  use base_kinds, only: wp
  use surface_basis, only: surface_functions_at, make_rational
  use contact_pair, only: contact_t, surface_t
  implicit none
  private
  public :: work_t, new_work, clear, add_own, add_partner, measure, position_on, position_at, &
            tangents_on, element_functions, own_share, spread_rows

  !> Room for one element and the elements of the other side that its points see.
  type :: work_t
    integer :: nk = 0                          !! nodes of the element
    integer :: npartner = 0
    integer, allocatable :: partner(:)         !! elements of the other side
    real(wp), allocatable :: r(:, :)           !! (3, nk) force on the nodes, reversed [F]
    real(wp), allocatable :: kk(:, :)          !! (3*nk, 3*nk) dr/du of the own nodes [F/L]
    real(wp), allocatable :: kl(:, :, :)       !! (3*nk, 3*nl, npartner) and of the partners' nodes
    !> BALAnced: force on the partners' nodes, and its derivatives by the own nodes and by theirs.
    real(wp), allocatable :: back(:, :, :)     !! (3, nl, npartner) [F]
    real(wp), allocatable :: lk(:, :, :)       !! (3*nl, 3*nk, npartner) [F/L]
    real(wp), allocatable :: ll(:, :, :)       !! (3*nl, 3*nl, npartner)
    integer :: slot = 0                        !! partner that add_partner was asked for
    !> And by those of another partner: of slot pair(1) by slot pair(2).
    integer :: ncross = 0
    integer, allocatable :: pair(:, :)         !! (2, ncross)
    real(wp), allocatable :: cross(:, :, :)    !! (3*nl, 3*nl, ncross)
    integer :: foot = 0                        !! slot that add_back was asked for,
    real(wp), allocatable :: foot_shp(:)       !! and the functions there
    real(wp), allocatable :: own(:), down(:, :) !! own functions at a point
    real(wp), allocatable :: shp(:), dshp(:, :) !! the partner's
    !> (3, 3, n) derivatives of a point's traction by its own nodes, and by the partner's.
    real(wp), allocatable :: own_q(:, :, :), q(:, :, :)
  end type work_t

contains

  !> Room for side k of a contact.
  subroutine new_work(contact, k, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(work_t), intent(out) :: work
    integer :: mk, ml, m

    mk = maxval(contact%side(k)%basis%nsf)
    ml = maxval(contact%side(3 - k)%basis%nsf)
    m = max(mk, ml)
    allocate (work%partner(3*contact%nq), work%r(3, mk), work%kk(3*mk, 3*mk))
    allocate (work%kl(3*mk, 3*ml, 3*contact%nq), work%shp(m), work%dshp(2, m), work%own(m))
    allocate (work%down(2, m), work%own_q(3, 3, mk), work%q(3, 3, ml))
    if (.not. contact%balanced) return
    allocate (work%back(3, ml, 3*contact%nq), work%lk(3*ml, 3*mk, 3*contact%nq))
    allocate (work%ll(3*ml, 3*ml, 3*contact%nq))
    allocate (work%foot_shp(ml))
    if (.not. contact%friction%given) return
    allocate (work%pair(2, contact%nq), work%cross(3*ml, 3*ml, contact%nq))
  end subroutine new_work

  !> Of its traction a point loads its own side with all, or where it loads both sides with half.
  pure real(wp) function own_share(contact)
    type(contact_t), intent(in) :: contact

    own_share = merge(0.5_wp, 1.0_wp, contact%balanced)
  end function own_share

  !> Functions of element e of a surface at a point, weights included.
  pure subroutine element_functions(surface, e, xi, shp, dshp)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: shp(:), dshp(:, :) !! (nsf), (2, nsf)

    call surface_functions_at(surface%basis(surface%ibasis(e)), xi, shp, dshp)
    if (allocated(surface%w)) call make_rational(surface%w(surface%first(e): &
                                                           surface%first(e + 1) - 1), shp, dshp)
  end subroutine element_functions

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

  !> The same, the functions to a place of the caller's.
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

  !> Unit normal and contravariant tangents at the point that position_on was asked for.
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

  !> Position of integration point q, contravariant tangents and area.
  pure subroutine measure(own, e, q, x, work, xq, up, area)
    type(surface_t), intent(in) :: own
    integer, intent(in) :: e, q
    real(wp), intent(in) :: x(:, :)
    type(work_t), intent(inout) :: work
    real(wp), intent(out) :: xq(3), up(3, 2), area
    real(wp) :: a(3, 2), n(3)
    integer :: j

    associate (basis => own%basis(own%ibasis(e)), node => own%node(own%first(e):own%first(e + 1) - 1))
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

  !> Unit normal, contravariant tangents and area of two tangents; zero where they are parallel.
  pure subroutine raise(a, n, up, area)
    real(wp), intent(in) :: a(3, 2)
    real(wp), intent(out) :: n(3), up(3, 2), area
    real(wp) :: m(2, 2)

    n = [a(2, 1)*a(3, 2) - a(3, 1)*a(2, 2), a(3, 1)*a(1, 2) - a(1, 1)*a(3, 2), &
         a(1, 1)*a(2, 2) - a(2, 1)*a(1, 2)]
    area = norm2(n)
    m = matmul(transpose(a), a)
    up = 0.0_wp
    if (.not. area > 0.0_wp) return
    n = n/area
    up(:, 1) = (m(2, 2)*a(:, 1) - m(1, 2)*a(:, 2))/area**2
    up(:, 2) = (m(1, 1)*a(:, 2) - m(1, 2)*a(:, 1))/area**2
  end subroutine raise

  !> Before the first point of an element that acts.
  pure subroutine clear(work)
    type(work_t), intent(inout) :: work

    if (work%npartner > 0) return
    work%ncross = 0
    work%r = 0.0_wp
    work%kk(:, :3*work%nk) = 0.0_wp
  end subroutine clear

  !> Force on the own nodes, its change with the point, and with the area the point stands for.
  pure subroutine add_own(t, dtdx, up, da, work)
    real(wp), intent(in) :: t(3), dtdx(3, 3), up(3, 2), da
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

  !> Change with the nodes of an element of the other side, at a point of it.
  pure subroutine add_partner(other, e, xi, dtdx, dtda, da, work)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(in) :: dtdx(3, 3), dtda(3, 3, 2), da
    type(work_t), intent(inout) :: work
    integer :: b, n, slot

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
    n = other%basis(other%ibasis(e))%nsf
    call element_functions(other, e, xi, work%shp(:n), work%dshp(:, :n))
    do b = 1, n
      work%q(:, :, b) = dtdx*work%shp(b) + dtda(:, :, 1)*work%dshp(1, b) &
                        + dtda(:, :, 2)*work%dshp(2, b)
    end do
    call spread_rows(work%nk, n, work%own, work%q, da, size(work%kl, 1), work%kl(:, :, slot))
  end subroutine add_partner

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
