!> Which way a spline surface looks, and whether the inner nodes of a layer belong to it.
module spline_check
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use patch_spec, only: patch_spec_t
  use spline_corners, only: number_corners, corner_point
  use spline_measure, only: surface_at, surface_measures
  use spline_surface, only: spline_surface_t, transpose_surface
  use tensor, only: det3
  implicit none
  private
  public :: check_layer, orient_layer, orient_tool

  real(wp), parameter :: CLOSED = 1.0e-6_wp !! share of the area that the area vectors may sum up to

contains

  !> The normal of a tool points away from it: out of a closed surface, along a_1 x a_2 of an open
  !! one; REVErse turns it.
  subroutine orient_tool(s, reverse)
    type(spline_surface_t), intent(inout) :: s
    logical, intent(in) :: reverse
    real(wp) :: area, vector(3), volume
    logical :: turn

    call surface_measures(s, area, vector, volume)
    turn = norm2(vector) <= CLOSED*area .and. volume < 0.0_wp
    if (turn .neqv. reverse) call transpose_surface(s)
  end subroutine orient_tool

  !> In an element of the layer a_1 x a_2 points to the inner nodes: transpose all, or say which
  !! element looks the other way.
  subroutine orient_layer(spec, xr, inner, error)
    type(patch_spec_t), intent(inout) :: spec
    real(wp), intent(in) :: xr(:, :)
    integer, intent(inout) :: inner(:, :) !! (4, nelem) nodes
    type(error_t), allocatable, intent(out) :: error
    integer :: e, first(2)

    first = 0
    associate (s => spec%spline%surface)
      do e = 1, s%nelem
        associate (side => merge(1, 2, middle_jacobian(s, e, xr(:, inner(:, e))) > 0.0_wp))
          if (first(side) == 0) first(side) = e
        end associate
      end do
      if (all(first > 0)) then
        call fail(error, DECK_ERROR, 'the inner nodes of elements '//to_text(minval(first)) &
                  //' and '//to_text(maxval(first))//' of layer '//quoted(spec%name) &
                  //' lie on different sides of the surface', spec%spline%layer_place, &
                  'normals of all elements point the same way, and the layer is thinner than ' &
                  //'the surface is curved')
        return
      end if
      if (first(1) > 0) return
      call transpose_surface(s)
      inner = inner([1, 4, 3, 2], :)
    end associate
  end subroutine orient_layer

  !> Jacobian of the hexahedron at its middle.
  real(wp) function middle_jacobian(s, e, x) result(jac)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e
    real(wp), intent(in) :: x(3, 4) !! inner nodes [L]
    real(wp) :: c(3, 4), a(3, 3), at(3), n(3)
    integer :: i

    do i = 1, 4
      c(:, i) = 0.5_wp*(corner_point(s, e, i) + x(:, i))
    end do
    call surface_at(s, e, [0.0_wp, 0.0_wp], at, n)
    a(:, 1) = c(:, 2) + c(:, 3) - c(:, 1) - c(:, 4)
    a(:, 2) = c(:, 3) + c(:, 4) - c(:, 1) - c(:, 2)
    a(:, 3) = 0.25_wp*sum(x, 2) - at
    jac = det3(a)
  end function middle_jacobian

  !> Inner nodes stand in the order of the corners, and corners that are one point have one node.
  subroutine check_layer(spec, xr, inner, error)
    type(patch_spec_t), intent(in) :: spec
    real(wp), intent(in) :: xr(:, :)
    integer, intent(in) :: inner(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: point(:, :), node(:), elem(:)
    integer :: e, c

    associate (s => spec%spline%surface)
      call number_corners(s, point)
      allocate (node(maxval(point)), elem(maxval(point)), source=0)
      do e = 1, s%nelem
        call check_order(spec, e, xr(:, inner(:, e)), error)
        if (allocated(error)) return
        do c = 1, 4
          associate (p => point(c, e))
            if (node(p) == 0) then
              node(p) = inner(c, e)
              elem(p) = e
            else if (node(p) /= inner(c, e)) then
              call fail(error, DECK_ERROR, 'elements '//to_text(elem(p))//' and '//to_text(e) &
                        //' of layer '//quoted(spec%name)//' have a corner in common, but the ' &
                        //'inner nodes '//to_text(node(p))//' and '//to_text(inner(c, e)) &
                        //' there', spec%spline%layer_place, &
                        'at one corner of the surface all elements have one inner node')
              return
            end if
          end associate
        end do
      end do
    end associate
  end subroutine check_layer

  !> No other order of the four brings them nearer to the corners.
  subroutine check_order(spec, e, x, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: e
    real(wp), intent(in) :: x(3, 4)
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: c(3, 4), way(4)
    integer :: i, k

    do i = 1, 4
      c(:, i) = corner_point(spec%spline%surface, e, i)
    end do
    do k = 1, 4
      way(k) = sum(norm2(x - cshift(c, k - 1, 2), 1))
    end do
    if (way(1) <= minval(way(2:))) return
    call fail(error, DECK_ERROR, 'the inner nodes of element '//to_text(e)//' of layer ' &
              //quoted(spec%name)//' stand in another order than its corners', &
              spec%spline%layer_place, 'the order is (-,-) (+,-) (+,+) (-,+)')
  end subroutine check_order

end module spline_check
