!> Checks of a NURBS patch or surface: knots, weights, orientation.
module patch_nurbs
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text
  use bspline, only: span_list
  use nurbs, only: nurbs_t, evaluate
  use quadrature, only: gauss
  use tensor, only: det3
  implicit none
  private
  public :: check_nurbs, check_orientation, turn_right_handed, mirrored

  integer, parameter, public :: MAX_DEGREE = 10 !! largest degree in a deck or file

contains

  !> Check that knot vectors are open, coordinates finite and weights positive.
  subroutine check_nurbs(patch, ndir, what, place, error)
    type(nurbs_t), intent(in) :: patch
    integer, intent(in) :: ndir      !! 2 or 3
    character(*), intent(in) :: what !! name of the patch in the message
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: of
    integer :: d, i, last, p

    if (.not. allocated(patch%cp)) then
      call fail(error, DECK_ERROR, what//' has no control points', place)
      return
    end if
    do d = 1, ndir
      associate (s => patch%dir(d), n => size(patch%cp, d + 1))
        of = 'direction '//to_text(d)//' of '//what
        p = s%degree
        if (p < 1 .or. p > MAX_DEGREE) then
          call fail(error, DECK_ERROR, of//' has degree '//to_text(p), place, &
                    'degrees must be from 1 to '//to_text(MAX_DEGREE))
          return
        end if
        last = 0
        if (allocated(s%knots)) last = size(s%knots)
        if (last /= n + p + 1 .or. n < p + 1) then
          call fail(error, DECK_ERROR, of//' has '//to_text(last)//' knots for '//to_text(n) &
                    //' control points and degree '//to_text(p), place, &
                    'there must be at least (degree + 1) control points, and (control points ' &
                    //'+ degree + 1) knots')
        else if (any(.not. s%knots(2:) >= s%knots(:last - 1))) then
          call fail(error, DECK_ERROR, 'the knots in '//of//' are not in ascending order', place, &
                    'list them in ascending order; a knot may be repeated')
        else if (s%knots(p + 1) > s%knots(1) .or. s%knots(last - p) < s%knots(last) &
                 .or. .not. s%knots(last) > s%knots(1)) then
          call fail(error, DECK_ERROR, 'the knot vector in '//of//' is not open', place, &
                    'repeat its first and last knot '//to_text(p + 1)//' times each')
        end if
        if (allocated(error)) return
        do i = 2, last - p - 1
          if (s%knots(i + p) > s%knots(i)) cycle
          call fail(error, DECK_ERROR, 'the knot '//to_text(s%knots(i))//' in '//of &
                    //' is repeated more than '//to_text(p)//' times', place, &
                    'the patch is discontinuous there: make two patches')
          return
        end do
      end associate
    end do
    do i = 1, 4
      if (any(.not. abs(patch%cp(i, :, :, :)) <= huge(1.0_wp))) then
        call fail(error, DECK_ERROR, what//' has a coordinate or weight that is not a finite ' &
                  //'number', place)
        return
      end if
    end do
    if (any(.not. patch%cp(4, :, :, :) > 0.0_wp)) then
      call fail(error, DECK_ERROR, what//' has the weight ' &
                //to_text(minval(patch%cp(4, :, :, :))), place, 'weights must be positive')
    end if
  end subroutine check_nurbs

  !> Check that the map is right-handed everywhere: neither left-handed nor folded nor singular.
  subroutine check_orientation(patch, name, place, error)
    type(nurbs_t), intent(in) :: patch
    character(*), intent(in) :: name
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: least, most
    integer :: bad(3)

    call jacobian_range(patch, least, most, bad)
    if (least > 0.0_wp) return
    if (most <= 0.0_wp .and. least < 0.0_wp) then
      call fail(error, DECK_ERROR, "patch '"//name//"' is left-handed: its Jacobian is negative", &
                place, 'exchange directions 1 and 2 (numbers of control points, knot vectors, ' &
                //'and order of the control points), or reverse direction 3')
    else if (least < 0.0_wp) then
      call fail(error, DECK_ERROR, "patch '"//name//"' folds over: its Jacobian changes sign", &
                place, 'the Jacobian is smallest in knot span '//to_text(bad(1))//' ' &
                //to_text(bad(2))//' '//to_text(bad(3)))
    else
      call fail(error, DECK_ERROR, "patch '"//name//"' has no volume in knot span " &
                //to_text(bad(1))//' '//to_text(bad(2))//' '//to_text(bad(3)), place, &
                'check the control points of NPATch or FILE; for HEMIsphere, use more elements ' &
                //'or another order')
    end if
  end subroutine check_orientation

  !> Reverse direction 3 of a patch if the patch is left-handed. Files of other programs may contain
  !! left-handed patches.
  subroutine turn_right_handed(patch, turned)
    type(nurbs_t), intent(inout) :: patch
    logical, intent(out) :: turned
    real(wp) :: least, most
    integer :: bad(3), n

    call jacobian_range(patch, least, most, bad)
    turned = least < 0.0_wp .and. most <= 0.0_wp
    if (.not. turned) return
    n = size(patch%cp, 4)
    patch%cp = patch%cp(:, :, :, n:1:-1)
    patch%dir(3)%knots = mirrored(patch%dir(3)%knots, patch%dir(3)%knots)
  end subroutine turn_right_handed

  !> Mirror knots about the middle of a knot vector.
  pure function mirrored(u, knots) result(v)
    real(wp), intent(in) :: u(:), knots(:)
    real(wp) :: v(size(u))

    v = (knots(1) + knots(size(knots))) - u(size(u):1:-1)
  end function mirrored

  !> Find the smallest and the largest Jacobian of a patch, with respect to the parent coordinates
  !! of its knot spans in [-1,1]^3, and the span with the smallest one.
  subroutine jacobian_range(patch, least, most, bad)
    type(nurbs_t), intent(in) :: patch
    real(wp), intent(out) :: least, most
    integer, intent(out) :: bad(3)
    integer, allocatable :: k1(:), k2(:), k3(:)
    real(wp) :: range(2)
    integer :: i, j, l

    call span_list(patch%dir(1), k1)
    call span_list(patch%dir(2), k2)
    call span_list(patch%dir(3), k3)
    least = huge(1.0_wp)
    most = -huge(1.0_wp)
    bad = 1
    do l = 1, size(k3)
      do j = 1, size(k2)
        do i = 1, size(k1)
          range = span_jacobian(patch, [k1(i), k2(j), k3(l)])
          if (range(1) < least) bad = [i, j, l]
          least = min(least, range(1))
          most = max(most, range(2))
        end do
      end do
    end do
  end subroutine jacobian_range

  !> Find the smallest and the largest Jacobian at the Gauss points of a knot span, with respect to
  !! its parent coordinates. Values that may be rounding errors are taken as zero.
  function span_jacobian(patch, k) result(range)
    type(nurbs_t), intent(in) :: patch
    integer, intent(in) :: k(3)
    real(wp) :: range(2)
    real(wp) :: x(MAX_DEGREE + 1), w(MAX_DEGREE + 1), middle(3), h(3), p(3), dx(3, 3), size3, v
    integer :: q, r, s, m, d

    m = maxval(patch%dir%degree) + 1
    call gauss(m, x(:m), w(:m))
    do d = 1, 3
      h(d) = 0.5_wp*(patch%dir(d)%knots(k(d) + 1) - patch%dir(d)%knots(k(d)))
      middle(d) = patch%dir(d)%knots(k(d)) + h(d)
    end do
    range = [huge(1.0_wp), -huge(1.0_wp)]
    do s = 1, m
      do r = 1, m
        do q = 1, m
          call evaluate(patch, middle + h*[x(q), x(r), x(s)], p, dx)
          v = det3(dx)
          size3 = norm2(dx(:, 1))*norm2(dx(:, 2))*norm2(dx(:, 3))
          if (abs(v) <= 100*epsilon(v)*size3) v = 0.0_wp
          v = v*product(h)
          range = [min(range(1), v), max(range(2), v)]
        end do
      end do
    end do
  end function span_jacobian

end module patch_nurbs
