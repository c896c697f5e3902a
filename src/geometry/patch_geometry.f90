!> The geometry of a patch (a box, a hemisphere or a NURBS patch), and the parameters at the ends of
!! its elements, which follow from ELEMents or KNOTs.
module patch_geometry
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text
  use bspline, only: spline_t, new_spline, greville, interpolate, span_list
  use nurbs, only: nurbs_t, new_nurbs, evaluate
  use patch_spec, only: patch_spec_t, knot_list_t, compose, GEO_BOX, GEO_HEMISPHERE
  implicit none
  private
  public :: geometry_t, new_geometry, sphere_deviation, point, greville_points

  !> The map from parameters to points.
  type :: geometry_t
    integer :: type = 0               !! GEO_BOX, GEO_HEMISPHERE or GEO_NURBS
    logical :: sampled = .false.      !! nodes lie on the exact map, not on its spline
    real(wp) :: origin(3) = 0.0_wp    !! corner of a box, centre of a hemisphere [L]
    real(wp) :: length(3) = 0.0_wp    !! edge lengths of a box [L]
    real(wp) :: radius = 0.0_wp       !! outer radius of a hemisphere [L]
    real(wp) :: inner = 0.0_wp        !! inner radius divided by the outer one [-]
    type(nurbs_t) :: coarse           !! the patch before degree elevation and knot insertion
    integer :: n(3) = 0               !! number of elements
    type(knot_list_t) :: breaks(3)    !! ends of the elements, n(d)+1 parameters
    type(knot_list_t) :: insert(3)    !! knots that `coarse` does not have
    real(wp) :: turn(3, 3) = 0.0_wp   !! placement: x -> turn x + shift
    real(wp) :: shift(3) = 0.0_wp
    logical :: placed = .false.
  end type geometry_t

contains

  !> Make the geometry of a patch; `degree` is the degree of the surface of a hemisphere.
  subroutine new_geometry(spec, degree, geo, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: degree
    type(geometry_t), intent(out) :: geo
    type(error_t), allocatable, intent(out) :: error
    type(spline_t) :: dir(3)
    real(wp) :: x(3, 8)
    integer :: d, i

    geo%type = spec%geometry
    geo%origin = spec%origin
    geo%length = spec%length
    geo%n = spec%nelem
    if (allocated(spec%placement)) then
      geo%placed = size(spec%placement) > 0
      call compose(spec%placement, geo%turn, geo%shift)
    end if
    if (geo%type == GEO_BOX .or. geo%type == GEO_HEMISPHERE) then
      do d = 1, 3
        if (allocated(spec%knots(d)%u)) then
          geo%breaks(d)%u = [0.0_wp, spec%knots(d)%u, 1.0_wp]
          call check_rising(spec, d, geo%breaks(d)%u, error)
          if (allocated(error)) return
        else ! whole numbers, so that all spans are exactly equal
          geo%breaks(d)%u = [(real(i, wp), i=0, spec%nelem(d))]
        end if
        allocate (geo%insert(d)%u(0))
      end do
    end if
    select case (geo%type)
    case (GEO_BOX)
      do d = 1, 3
        dir(d) = new_spline(1, [geo%breaks(d)%u(1), geo%breaks(d)%u(geo%n(d) + 1)])
        geo%insert(d)%u = geo%breaks(d)%u(2:geo%n(d))
      end do
      do i = 0, 7
        x(:, i + 1) = geo%origin + geo%length*[mod(i, 2), mod(i/2, 2), i/4]
      end do
      call new_nurbs(geo%coarse, dir, x)
    case (GEO_HEMISPHERE)
      geo%radius = spec%radius
      geo%inner = (spec%radius - spec%thickness)/spec%radius
      geo%sampled = spec%type == 'Q2' .and. size(spec%enrich) == 0
      call hemisphere_patch(geo, degree)
    case default
      geo%coarse = spec%nurbs
      do d = 1, 3
        call nurbs_breaks(spec, d, geo%breaks(d)%u, geo%insert(d)%u, error)
        if (allocated(error)) return
      end do
    end select
  end subroutine new_geometry

  !> Make the patch of a hemisphere. The surface spline interpolates the map `hemisphere` at its
  !! Greville points, and direction 3 is linear.
  subroutine hemisphere_patch(geo, degree)
    type(geometry_t), intent(inout) :: geo
    integer, intent(in) :: degree
    type(spline_t) :: dir(3)
    real(wp), allocatable :: v(:, :, :), x(:, :), g1(:), g2(:)
    integer :: i, j, n1, n2, last
    logical :: ok

    dir(1) = new_spline(degree, geo%breaks(1)%u)
    dir(2) = new_spline(degree, geo%breaks(2)%u)
    last = geo%n(3) + 1
    dir(3) = new_spline(1, [geo%breaks(3)%u(1), geo%breaks(3)%u(last)])
    geo%insert(3)%u = geo%breaks(3)%u(2:geo%n(3))
    g1 = greville(dir(1))/geo%breaks(1)%u(geo%n(1) + 1)
    g2 = greville(dir(2))/geo%breaks(2)%u(geo%n(2) + 1)
    n1 = size(g1)
    n2 = size(g2)
    allocate (v(n1, n2, 3))
    do j = 1, n2
      do i = 1, n1
        v(i, j, :) = geo%radius*hemisphere(g1(i), g2(j))
      end do
    end do
    x = reshape(v, [n1, 3*n2])
    call interpolate(dir(1), x, ok)
    v = reshape(x, [n2, n1, 3], order=[2, 1, 3])
    x = reshape(v, [n2, 3*n1])
    call interpolate(dir(2), x, ok)
    v = reshape(x, [n1, n2, 3], order=[2, 1, 3])
    x = transpose(reshape(v, [n1*n2, 3]))
    x = reshape([x, geo%inner*x], [3, 2*n1*n2])
    x = x + spread(geo%origin, 2, 2*n1*n2)
    call new_nurbs(geo%coarse, dir, x)
  end subroutine hemisphere_patch

  !> Map the unit square to the lower unit hemisphere: an elliptical map to the unit disc, followed
  !! by an azimuthal equidistant map to the hemisphere.
  pure function hemisphere(u, v) result(x)
    real(wp), intent(in) :: u, v !! in [0,1]
    real(wp) :: x(3)
    real(wp), parameter :: HALF_PI = acos(0.0_wp)
    real(wp) :: s, t, a, b, r

    s = 2.0_wp*u - 1.0_wp
    t = 2.0_wp*v - 1.0_wp
    a = s*sqrt(1.0_wp - 0.5_wp*t*t)
    b = t*sqrt(1.0_wp - 0.5_wp*s*s)
    r = sqrt(a*a + b*b)
    x = [0.0_wp, 0.0_wp, -1.0_wp]
    if (max(abs(s), abs(t)) >= 1.0_wp) then
      x = [a/r, b/r, 0.0_wp] ! exactly on the rim
    else if (r > 0.0_wp) then
      x = [a/r*sin(HALF_PI*r), b/r*sin(HALF_PI*r), -cos(HALF_PI*r)]
    end if
  end function hemisphere

  !> Find the largest distance between the outer surface of a hemisphere's spline and the sphere,
  !! relative to the radius.
  pure function sphere_deviation(geo) result(largest)
    type(geometry_t), intent(in) :: geo
    real(wp) :: largest
    integer, parameter :: N = 64 ! intervals between sampling points; even, for the pole
    real(wp) :: u(3), x(3)
    integer :: d, i, j

    largest = 0.0_wp
    do j = 0, N
      do i = 0, N
        u = [real(i, wp)/N, real(j, wp)/N, 0.0_wp]
        do d = 1, 2
          u(d) = u(d)*geo%breaks(d)%u(geo%n(d) + 1)
        end do
        call evaluate(geo%coarse, u, x)
        largest = max(largest, abs(norm2(x - geo%origin)/geo%radius - 1.0_wp))
      end do
    end do
  end function sphere_deviation

  !> Position of the point with parameters u, after the placement.
  pure function point(geo, u) result(x)
    type(geometry_t), intent(in) :: geo
    real(wp), intent(in) :: u(3)
    real(wp) :: x(3), t(3)
    integer :: d

    if (geo%type == GEO_BOX) then
      do d = 1, 3
        associate (last => geo%breaks(d)%u(geo%n(d) + 1))
          x(d) = geo%origin(d) + geo%length(d) ! exact at the upper end
          if (u(d) < last) x(d) = geo%origin(d) + geo%length(d)*u(d)/last
        end associate
      end do
    else if (geo%sampled) then
      do d = 1, 3
        t(d) = u(d)/geo%breaks(d)%u(geo%n(d) + 1)
      end do
      x = geo%origin + geo%radius*(1.0_wp - t(3)*(1.0_wp - geo%inner))*hemisphere(t(1), t(2))
    else
      call evaluate(geo%coarse, u, x)
    end if
    if (geo%placed) x = matmul(geo%turn, x) + geo%shift
  end function point

  !> Find the positions of the control points of a spline space over the patch, without weights and
  !! after the placement.
  subroutine greville_points(geo, space, dir, fixed, x)
    type(geometry_t), intent(in) :: geo
    type(nurbs_t), intent(in) :: space            !! has size(dir) directions
    integer, intent(in) :: dir(:)                 !! the corresponding directions of the patch
    real(wp), intent(in) :: fixed(3)              !! parameters of the other directions
    real(wp), allocatable, intent(out) :: x(:, :) !! (3, ncp), direction 1 fastest [L]
    type(knot_list_t) :: g(3)
    integer :: n(4), i, j, k, d, a
    real(wp) :: u(3)

    n = shape(space%cp)
    do d = 1, 3
      g(d)%u = greville(space%dir(d))
    end do
    allocate (x(3, product(n(2:))))
    a = 0
    do k = 1, n(4)
      do j = 1, n(3)
        do i = 1, n(2)
          a = a + 1
          if (geo%type == GEO_BOX) then ! avoids the rounding errors of knot insertion
            u = fixed
            u(dir(1)) = g(1)%u(i)
            u(dir(2)) = g(2)%u(j)
            if (size(dir) == 3) u(dir(3)) = g(3)%u(k)
            x(:, a) = point(geo, u)
          else
            x(:, a) = space%cp(:3, i, j, k)/space%cp(4, i, j, k)
            if (geo%placed) x(:, a) = matmul(geo%turn, x(:, a)) + geo%shift
          end if
        end do
      end do
    end do
  end subroutine greville_points

  !> Check that the ends of the elements increase strictly.
  subroutine check_rising(spec, d, breaks, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), intent(in) :: breaks(:)
    type(error_t), allocatable, intent(out) :: error

    if (all(breaks(2:) > breaks(:size(breaks) - 1))) return
    call fail(error, DECK_ERROR, 'the knots in direction '//to_text(d)//" of patch '"//spec%name &
              //"' are not in ascending order between "//to_text(breaks(1))//' and ' &
              //to_text(breaks(size(breaks))), spec%place, &
              'KNOTs,dir lists each interior knot once and omits the two ends')
  end subroutine check_rising

  !> Find the ends of the elements of a NURBS patch and the knots to insert.
  subroutine nurbs_breaks(spec, d, breaks, insert, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: d
    real(wp), allocatable, intent(out) :: breaks(:), insert(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), parameter :: SAME = 1.0e-10_wp ! of the range; closer knots are taken as equal
    real(wp), allocatable :: old(:)
    logical, allocatable :: is_old(:)
    integer, allocatable :: k(:)
    integer :: e, i, m

    associate (s => spec%nurbs%dir(d))
      call span_list(s, k)
      allocate (old, source=[s%knots(k), s%knots(size(s%knots))])
    end associate
    if (allocated(spec%knots(d)%u)) then ! the list must contain the knots of the patch
      breaks = [old(1), spec%knots(d)%u, old(size(old))]
      call check_rising(spec, d, breaks, error)
      if (allocated(error)) return
      is_old = [(.false., i=1, size(breaks))]
      do e = 1, size(old)
        i = minloc(abs(breaks - old(e)), 1)
        if (abs(breaks(i) - old(e)) > SAME*(old(size(old)) - old(1))) then
          call fail(error, DECK_ERROR, "patch '"//spec%name//"' has a knot at "//to_text(old(e)) &
                    //' in direction '//to_text(d)//' that is missing from KNOTs', spec%place, &
                    'knots of the patch cannot be removed: add this knot to the list')
          return
        end if
        breaks(i) = old(e)
        is_old(i) = .true.
      end do
      insert = pack(breaks,.not. is_old)
      return
    end if
    m = spec%nelem(d)/size(k)
    if (m*size(k) /= spec%nelem(d)) then
      call fail(error, DECK_ERROR, &
                "the number of elements of patch '"//spec%name//"' in direction "//to_text(d) &
                //' is '//to_text(spec%nelem(d))//', which is not a multiple of its ' &
                //to_text(size(k))//' knot spans', spec%place, 'give a multiple of ' &
                //to_text(size(k))//' in ELEMents, or list the knots in KNOTs,'//to_text(d))
      return
    end if
    breaks = [((old(e) + (old(e + 1) - old(e))*i/m, i=0, m - 1), e=1, size(k)), &
              old(size(old))]
    insert = pack(breaks, [(mod(e - 1, m) /= 0, e=1, size(breaks))])
  end subroutine nurbs_breaks

end module patch_geometry
