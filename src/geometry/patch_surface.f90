!> The spline space of an enriched face: control points, and the functions of each element.
module patch_surface
  use base_kinds, only: wp
  use nurbs, only: nurbs_t, elevate, insert_knots, face_of, is_rational
  use patch_spec, only: patch_spec_t
  use patch_geometry, only: geometry_t, greville_points
  use patch_draft, only: draft_t, span_t, add_node, add_operators
  implicit none
  private
  public :: surface_t, make_surfaces, surface_functions, axis_of, side_of, local_side

  !> Patch directions of xi and eta on each face, chosen such that zeta points into the body.
  integer, parameter :: XI_OF(6) = [2, 3, 3, 1, 1, 2], ETA_OF(6) = [3, 2, 1, 3, 2, 1]

  !> One enriched face.
  type :: surface_t
    integer :: face = 0, axis = 0, side = 0 !! side 0: minimum, 1: maximum
    integer :: xi = 0, eta = 0        !! patch directions of xi and eta
    integer :: dir(2) = 0             !! the same two directions in ascending order, as in `space`
    integer :: degree(3) = 0          !! degree in each patch direction
    logical :: rational = .false.
    type(nurbs_t) :: space
    integer, allocatable :: node(:, :) !! (n1, n2) control points
    type(span_t) :: span(3)           !! spans in each patch direction
  end type surface_t

contains

  pure integer function axis_of(face)
    integer, intent(in) :: face

    axis_of = (face + 1)/2
  end function axis_of

  pure integer function side_of(face)
    integer, intent(in) :: face

    side_of = mod(face + 1, 2)
  end function side_of

  !> The local face of an element in the layer of surface s that points in the same direction of the
  !! patch as face `face` of the patch.
  pure integer function local_side(s, face)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: face

    if (axis_of(face) == s%xi) then
      local_side = 1 + side_of(face)
    else if (axis_of(face) == s%eta) then
      local_side = 3 + side_of(face)
    else if (face == s%face) then
      local_side = 5
    else
      local_side = 6
    end if
  end function local_side

  !> Make the spaces and control points of all enriched faces; two faces share the control points of
  !! their common edge. First the degree is elevated, then knots are inserted, and then RAISe
  !! elevates the degree again (Corbett and Sauer 2015, section 2.5).
  subroutine make_surfaces(spec, geo, draft, surface)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(draft_t), intent(inout) :: draft
    type(surface_t), allocatable, intent(out) :: surface(:)
    real(wp), allocatable :: x(:, :)
    real(wp) :: fixed(3)
    integer :: i, j, l, n(2), mask

    allocate (surface(size(spec%enrich)))
    do l = 1, size(surface)
      associate (s => surface(l), e => spec%enrich(l))
        s%face = e%face
        s%axis = axis_of(e%face)
        s%side = side_of(e%face)
        s%xi = XI_OF(e%face)
        s%eta = ETA_OF(e%face)
        s%dir = [min(s%xi, s%eta), max(s%xi, s%eta)]
        call face_of(geo%coarse, s%axis, s%side, s%space)
        do i = 1, 2
          call elevate(s%space, i, e%degree - s%space%dir(i)%degree)
          call insert_knots(s%space, i, geo%insert(s%dir(i))%u)
          call elevate(s%space, i, e%raise)
        end do
        s%rational = is_rational(s%space)
        n = [size(s%space%cp, 2), size(s%space%cp, 3)]
        allocate (s%node(n(1), n(2)), source=0)
        do i = 1, 2
          s%degree(s%dir(i)) = s%space%dir(i)%degree
          call add_operators(draft, s%space%dir(i), s%span(s%dir(i)))
        end do
        do i = 1, l - 1
          if (surface(i)%axis /= s%axis) call share_edge(surface(i), s)
        end do
        fixed = 0.0_wp
        fixed(s%axis) = geo%breaks(s%axis)%u(1 + s%side*geo%n(s%axis))
        call greville_points(geo, s%space, s%dir, fixed, x)
        do j = 1, n(2)
          do i = 1, n(1)
            if (s%node(i, j) > 0) cycle
            mask = ibset(0, s%face - 1)
            if (i == 1) mask = ibset(mask, 2*s%dir(1) - 2)
            if (i == n(1)) mask = ibset(mask, 2*s%dir(1) - 1)
            if (j == 1) mask = ibset(mask, 2*s%dir(2) - 2)
            if (j == n(2)) mask = ibset(mask, 2*s%dir(2) - 1)
            call add_node(draft, x(:, i + n(1)*(j - 1)), .true., mask, s%node(i, j))
          end do
        end do
      end associate
    end do
  end subroutine make_surfaces

  !> Give surface b the control points of surface a on the edge that they share.
  subroutine share_edge(a, b)
    type(surface_t), intent(in) :: a
    type(surface_t), intent(inout) :: b
    integer, allocatable :: edge(:)

    if (a%dir(1) == b%axis) then
      edge = a%node(at_end(a, 1, b%side), :)
    else
      edge = a%node(:, at_end(a, 2, b%side))
    end if
    if (b%dir(1) == a%axis) then
      b%node(at_end(b, 1, a%side), :) = edge
    else
      b%node(:, at_end(b, 2, a%side)) = edge
    end if
  end subroutine share_edge

  !> Index of the first (side 0) or last (side 1) row of control points in direction d.
  pure integer function at_end(s, d, side)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: d, side

    at_end = merge(1, size(s%node, d), side == 0)
  end function at_end

  !> Find the control points and weights of the functions over one cell; xi varies fastest.
  subroutine surface_functions(s, cell, node, w)
    type(surface_t), intent(in) :: s
    integer, intent(in) :: cell(3) !! index of the element in each patch direction
    integer, intent(out) :: node(:)  !! (ncp)
    real(wp), intent(out) :: w(:)    !! (ncp)
    integer :: i, j, a, at(3)

    a = 0
    do j = 0, s%degree(s%eta)
      do i = 0, s%degree(s%xi)
        a = a + 1
        at(s%xi) = s%span(s%xi)%first(cell(s%xi)) + i
        at(s%eta) = s%span(s%eta)%first(cell(s%eta)) + j
        node(a) = s%node(at(s%dir(1)), at(s%dir(2)))
        w(a) = s%space%cp(4, at(s%dir(1)), at(s%dir(2)), 1)
      end do
    end do
  end subroutine surface_functions

end module patch_surface
