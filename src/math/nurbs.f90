!> NURBS patches of one, two or three directions in homogeneous coordinates.
module nurbs
  use base_kinds, only: wp
  use bspline, only: spline_t, nfunction, find_span, basis_derivatives, with_knots, &
                     elevated, insertion_row, elevation_row
  implicit none
  private
  public :: nurbs_t, new_nurbs, elevate, insert_knots, evaluate, face_of, is_rational

  !> A patch. A direction that is not used has degree 0 and one function.
  type :: nurbs_t
    type(spline_t) :: dir(3)
    real(wp), allocatable :: cp(:, :, :, :) !! (4, n1, n2, n3) w x, w y, w z [L], w [-]
  end type nurbs_t

  abstract interface
    !> Express control point i of the space `to` by the control points of the space `from`.
    pure subroutine row_i(from, to, i, first, w)
      import :: spline_t, wp
      implicit none
      type(spline_t), intent(in) :: from, to
      integer, intent(in) :: i
      integer, intent(out) :: first
      real(wp), intent(out) :: w(:)
    end subroutine row_i
  end interface

contains

  !> Make a patch from its spaces and control points.
  subroutine new_nurbs(patch, dir, x, w)
    type(nurbs_t), intent(out) :: patch
    type(spline_t), intent(in) :: dir(:)            !! one to three directions
    real(wp), intent(in) :: x(:, :)                 !! (3, n) positions, direction 1 fastest [L]
    real(wp), intent(in), optional :: w(:)          !! (n) weights [-]
    real(wp), allocatable :: h(:, :)
    integer :: n(3), d, i

    n = 1
    do d = 1, 3
      if (d <= size(dir)) then
        patch%dir(d) = dir(d)
        n(d) = nfunction(dir(d))
      else
        patch%dir(d)%degree = 0
        patch%dir(d)%knots = [0.0_wp, 1.0_wp]
      end if
    end do
    allocate (h(4, size(x, 2)), source=1.0_wp)
    if (present(w)) h(4, :) = w
    do i = 1, 3
      h(i, :) = x(i, :)*h(4, :)
    end do
    patch%cp = reshape(h, [4, n(1), n(2), n(3)])
  end subroutine new_nurbs

  !> Do the weights differ?
  pure logical function is_rational(patch)
    type(nurbs_t), intent(in) :: patch

    is_rational = any(abs(patch%cp(4, :, :, :) - patch%cp(4, 1, 1, 1)) &
                      > 4*epsilon(1.0_wp)*abs(patch%cp(4, 1, 1, 1)))
  end function is_rational

  !> Raise the degree of direction d by t; spans and continuity are kept.
  subroutine elevate(patch, d, t)
    type(nurbs_t), intent(inout) :: patch
    integer, intent(in) :: d, t
    type(spline_t) :: to
    integer :: i

    do i = 1, t
      to = elevated(patch%dir(d))
      call change_space(patch, d, to, elevation_row)
    end do
  end subroutine elevate

  !> Insert knots in direction d.
  subroutine insert_knots(patch, d, list)
    type(nurbs_t), intent(inout) :: patch
    integer, intent(in) :: d
    real(wp), intent(in) :: list(:) !! inside the range, in any order
    type(spline_t) :: to

    if (size(list) == 0) return
    to = with_knots(patch%dir(d), list)
    call change_space(patch, d, to, insertion_row)
  end subroutine insert_knots

  !> Represent the patch in a space of direction d that contains the old one.
  subroutine change_space(patch, d, to, row)
    type(nurbs_t), intent(inout) :: patch
    integer, intent(in) :: d
    type(spline_t), intent(in) :: to
    procedure(row_i) :: row
    real(wp), allocatable :: fine(:, :, :, :)
    real(wp) :: w(patch%dir(d)%degree + 1)
    integer :: n(4), i, first, a

    n = shape(patch%cp)
    n(d + 1) = nfunction(to)
    allocate (fine(n(1), n(2), n(3), n(4)), source=0.0_wp)
    do i = 1, n(d + 1)
      call row(patch%dir(d), to, i, first, w)
      do a = 1, size(w)
        associate (old => patch%cp, b => first + a - 1)
          select case (d)
          case (1)
            fine(:, i, :, :) = fine(:, i, :, :) + w(a)*old(:, b, :, :)
          case (2)
            fine(:, :, i, :) = fine(:, :, i, :) + w(a)*old(:, :, b, :)
          case default
            fine(:, :, :, i) = fine(:, :, :, i) + w(a)*old(:, :, :, b)
          end select
        end associate
      end do
    end do
    call move_alloc(fine, patch%cp)
    patch%dir(d) = to
  end subroutine change_space

  !> Evaluate the position of a point and its derivatives with respect to the parameters.
  pure subroutine evaluate(patch, u, x, dx)
    type(nurbs_t), intent(in) :: patch
    real(wp), intent(in) :: u(3)                !! parameters, in the ranges of the knots
    real(wp), intent(out) :: x(3)               !! [L]
    real(wp), intent(out), optional :: dx(3, 3) !! d x_i / d u_j
    real(wp) :: n1(patch%dir(1)%degree + 1), d1(patch%dir(1)%degree + 1)
    real(wp) :: n2(patch%dir(2)%degree + 1), d2(patch%dir(2)%degree + 1)
    real(wp) :: n3(patch%dir(3)%degree + 1), d3(patch%dir(3)%degree + 1)
    real(wp) :: h(4, 0:3)
    integer :: k(3), i, j, l, d

    do d = 1, 3
      k(d) = find_span(patch%dir(d), u(d))
    end do
    call basis_derivatives(patch%dir(1), k(1), u(1), n1, d1)
    call basis_derivatives(patch%dir(2), k(2), u(2), n2, d2)
    call basis_derivatives(patch%dir(3), k(3), u(3), n3, d3)
    k = k - patch%dir%degree - 1
    h = 0.0_wp
    do l = 1, size(n3)
      do j = 1, size(n2)
        do i = 1, size(n1)
          associate (c => patch%cp(:, k(1) + i, k(2) + j, k(3) + l))
            h(:, 0) = h(:, 0) + n1(i)*n2(j)*n3(l)*c
            h(:, 1) = h(:, 1) + d1(i)*n2(j)*n3(l)*c
            h(:, 2) = h(:, 2) + n1(i)*d2(j)*n3(l)*c
            h(:, 3) = h(:, 3) + n1(i)*n2(j)*d3(l)*c
          end associate
        end do
      end do
    end do
    x = h(:3, 0)/h(4, 0)
    if (.not. present(dx)) return
    do d = 1, 3
      dx(:, d) = (h(:3, d) - x*h(4, d))/h(4, 0)
    end do
  end subroutine evaluate

  !> Extract a face of a trivariate patch as a bivariate patch. Its directions are the two
  !! directions of the face, in the order in which the trivariate patch has them.
  subroutine face_of(patch, d, side, face)
    type(nurbs_t), intent(in) :: patch
    integer, intent(in) :: d     !! direction normal to the face
    integer, intent(in) :: side  !! 0: minimum, 1: maximum
    type(nurbs_t), intent(out) :: face
    integer :: n(4), i

    n = shape(patch%cp)
    i = 1
    if (side == 1) i = n(d + 1)
    select case (d)
    case (1)
      face%dir(:2) = patch%dir(2:3)
      face%cp = reshape(patch%cp(:, i, :, :), [4, n(3), n(4), 1])
    case (2)
      face%dir(1) = patch%dir(1)
      face%dir(2) = patch%dir(3)
      face%cp = reshape(patch%cp(:, :, i, :), [4, n(2), n(4), 1])
    case default
      face%dir(:2) = patch%dir(:2)
      face%cp = reshape(patch%cp(:, :, :, i), [4, n(2), n(3), 1])
    end select
    face%dir(3)%degree = 0
    face%dir(3)%knots = [0.0_wp, 1.0_wp]
  end subroutine face_of

end module nurbs
