!> Self-contact: finds the distances between parts of a surface that face each other, and whether
!! one part has passed through another one.
module self_search
  use base_kinds, only: wp
  use contact_facets, only: facets_t, divide_surface, find_near, FACING
  use contact_pair, only: contact_t
  use projection_type, only: foot_t, shape_t, touches
  use self_contact, only: may_touch, project_on_itself
  use surface_geometry, only: surface_point, update_shape
  implicit none
  private
  public :: nearness_t, search_itself, find_own_jump

  !> A gap that is smaller than this fraction of the size of an element counts as rounding.
  real(wp), parameter :: INSIDE = 1.0e-6_wp

  !> Distances between the parts of a surface that face each other.
  type :: nearness_t
    integer :: npoint = 0                 !! integration points
    integer :: ninside = 0                !! number of points that penetrate
    real(wp) :: deepest = 0.0_wp          !! largest penetration [L]
    real(wp) :: x(3) = 0.0_wp             !! point with this penetration [L]
    real(wp) :: gap = huge(1.0_wp)        !! smallest gap of a point [L]; huge: none
    real(wp) :: x_gap(3) = 0.0_wp         !! point with this gap [L]
    integer :: nthrough = 0               !! points within DEPTh of the body's far side
    real(wp) :: x_through(3) = 0.0_wp     !! one of them [L]
    real(wp), allocatable :: reach_of(:)  !! (nelem) distance of an element to what it faces [L]
  end type nearness_t

contains

  !> Project all integration points onto the parts of the surface that face them at the positions x.
  subroutine search_itself(contact, xr, x, reach, near)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :), x(:, :) !! (3, nnode) before the deformation, and now [L]
    real(wp), intent(in) :: reach             !! largest distance [L]
    type(nearness_t), intent(out) :: near
    type(shape_t) :: reference, shape
    type(facets_t) :: facets
    type(foot_t) :: foot
    integer, allocatable :: list(:)
    real(wp) :: at(3), a(3, 2), b(3, 3), h, least
    integer :: e, i, j, n, q
    logical :: through, is_through

    call start_search(contact, xr, x, reference, shape, facets)
    allocate (list(facets%n))
    near%npoint = contact%side(1)%nelem*contact%nplain
    allocate (near%reach_of(contact%side(1)%nelem), source=huge(h))
    h = sum(maxval(shape%high - shape%low, 1))/max(1, contact%side(1)%nelem)
    do i = 1, facets%n
      e = facets%elem(i)
      call find_facing(contact, reference, shape, facets, i, reach, list, n)
      do q = 1, merge(contact%nplain, 0, n > 0)
        if (.not. is_in(facets, i, contact%xi(:, q))) cycle
        call surface_point(contact%side(1), shape, e, contact%xi(:, q), at, a, b)
        least = huge(least)
        is_through = .false.
        do j = 1, n
          call begin_at(facets, list(j), foot)
          call project_on_itself(contact, shape, reference, e, contact%xi(:, q), foot, through)
          is_through = is_through .or. through
          if (.not. touches(foot, contact%depth) .or. abs(foot%gap) > reach) cycle
          if (abs(foot%gap) < abs(least)) least = foot%gap
        end do
        if (is_through) then
          near%nthrough = near%nthrough + 1
          near%x_through = at
        end if
        near%reach_of(e) = min(near%reach_of(e), abs(least))
        if (max(least, 0.0_wp) < near%gap) then
          near%gap = max(least, 0.0_wp)
          near%x_gap = at
        end if
        if (.not. least < -INSIDE*h) cycle
        near%ninside = near%ninside + 1
        if (-least <= near%deepest) cycle
        near%deepest = -least
        near%x = at
      end do
    end do
  end subroutine search_itself

  subroutine start_search(contact, xr, x, reference, shape, facets)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :), x(:, :)
    type(shape_t), intent(inout) :: reference, shape
    type(facets_t), intent(out) :: facets

    call update_shape(contact%side(1), xr, reference)
    call update_shape(contact%side(1), x, shape)
    call divide_surface(contact%side(1), shape, facets)
  end subroutine start_search

  !> Find the facets that face facet i and may touch it.
  subroutine find_facing(contact, reference, shape, facets, i, reach, list, n)
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: reference, shape
    type(facets_t), intent(in) :: facets
    integer, intent(in) :: i
    real(wp), intent(in) :: reach
    integer, intent(inout) :: list(:)
    integer, intent(out) :: n
    integer :: j, nnear

    call find_near(facets, i, facets, reach, list, nnear)
    n = 0
    do j = 1, nnear
      if (dot_product(facets%normal(:, i), facets%normal(:, list(j))) > FACING) cycle
      if (.not. may_touch(contact%side(1), reference, shape, facets%elem(i), &
                          facets%elem(list(j)))) cycle
      n = n + 1
      list(n) = list(j)
    end do
  end subroutine find_facing

  !> Do the parameters xi, of the element of facet i, lie in this facet?
  pure logical function is_in(facets, i, xi)
    type(facets_t), intent(in) :: facets
    integer, intent(in) :: i
    real(wp), intent(in) :: xi(2)

    is_in = all(xi >= facets%from(:, i) .and. xi <= facets%to(:, i))
  end function is_in

  !> Set the point from which a projection onto facet j begins: the middle of the facet.
  pure subroutine begin_at(facets, j, foot)
    type(facets_t), intent(in) :: facets
    integer, intent(in) :: j
    type(foot_t), intent(inout) :: foot

    foot%elem = facets%elem(j)
    foot%xi = 0.5_wp*(facets%from(:, j) + facets%to(:, j))
  end subroutine begin_at

  !> Find a point that was in front of a part of its own surface at the start of the step and is now
  !! behind this part, deeper than DEPTh.
  subroutine find_own_jump(contact, xr, x_start, x, far, gap)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)          !! (3, nnode) before the deformation [L]
    real(wp), intent(in) :: x_start(:, :)     !! (3, nnode) x at the start of the step [L]
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) current positions [L]
    real(wp), intent(in) :: far               !! distance that points may have moved [L]
    real(wp), intent(out) :: gap              !! gap of the point [L]; positive: there is none
    type(shape_t) :: reference, shape, start
    type(facets_t) :: facets
    type(foot_t) :: foot
    integer, allocatable :: list(:)
    real(wp) :: at(3), before(3), middle(3), a(3, 2), b(3, 3)
    integer :: e, i, j, n, q

    gap = huge(gap)
    call start_search(contact, xr, x, reference, shape, facets)
    call update_shape(contact%side(1), x_start, start)
    allocate (list(facets%n))
    do i = 1, facets%n
      e = facets%elem(i)
      call find_facing(contact, reference, shape, facets, i, far, list, n)
      do q = 1, merge(contact%nplain, 0, n > 0)
        if (.not. is_in(facets, i, contact%xi(:, q))) cycle
        call surface_point(contact%side(1), shape, e, contact%xi(:, q), at, a, b)
        call surface_point(contact%side(1), start, e, contact%xi(:, q), before, a, b)
        do j = 1, n
          if (dot_product(at - facets%x(:, 1, list(j)), facets%normal(:, list(j))) > 0.0_wp) cycle
          call begin_at(facets, list(j), foot)
          call surface_point(contact%side(1), start, foot%elem, foot%xi, middle, a, b)
          if (dot_product(before - middle, facets%normal(:, list(j))) < -far - contact%depth) cycle
          call project_on_itself(contact, shape, reference, e, contact%xi(:, q), foot)
          if (foot%elem == 0 .or. foot%gap >= -contact%depth) cycle
          gap = foot%gap
          call project_on_itself(contact, start, reference, e, contact%xi(:, q), foot)
          if (foot%elem > 0 .and. foot%gap >= -contact%depth) return
          gap = huge(gap)
        end do
      end do
    end do
  end subroutine find_own_jump

end module self_search
