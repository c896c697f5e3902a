!> Checks and measures of a spline surface: its orientation, the corners that its elements share,
!! the inner nodes of its layer, its area and the thickness of the body behind it.
module spline_check
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index, hash
  use base_text, only: to_text, quoted
  use element_type, only: cell_t
  use patch_spec, only: patch_spec_t
  use quadrature, only: gauss_quad
  use spline_surface, only: spline_surface_t, transpose_surface
  use surface_shape, only: surface_functions
  use tensor, only: det3, cross
  implicit none
  private
  public :: check_layer, orient_layer, orient_tool, number_corners, corner_point, &
            surface_measures, surface_at, spline_thickness

  real(wp), parameter :: NOTHING = 1.0e-12_wp  !! smaller values at a corner are taken as zero
  real(wp), parameter :: ALIKE = 1.0e-9_wp     !! function values this close are taken as equal
  integer, parameter :: MORE = 6               !! additional Gauss points, for rational functions
  integer, parameter :: MOST_SAMPLES = 3000
  !> Limits for elements that face each other: the cosine of the angle between their normals is at
  !! most OPPOSITE, and the cosine of the angle between a normal and the line that joins the
  !! elements exceeds STRAIGHT.
  real(wp), parameter :: OPPOSITE = -0.5_wp, STRAIGHT = 0.8_wp
  !> A surface is closed if |sum of area vectors|/area is below this limit.
  real(wp), parameter :: CLOSED = 1.0e-6_wp

  !> The functions that do not vanish at a corner, sorted by control point, and their values.
  type :: corner_t
    integer, allocatable :: node(:)
    real(wp), allocatable :: value(:)
  end type corner_t

contains

  !> Orient the normal of a rigid surface: out of the volume that a closed surface encloses, or
  !! along a_1 x a_2 of an open surface. REVErse reverses this normal.
  subroutine orient_tool(s, reverse)
    type(spline_surface_t), intent(inout) :: s
    logical, intent(in) :: reverse
    real(wp) :: area, vector(3), volume
    logical :: turn

    call surface_measures(s, area, vector, volume)
    turn = norm2(vector) <= CLOSED*area .and. volume < 0.0_wp
    if (turn .neqv. reverse) call transpose_surface(s)
  end subroutine orient_tool

  !> Make a_1 x a_2 point towards the inner nodes in all elements of the layer; fail if elements
  !! disagree. If a_1 x a_2 is reversed, the inner nodes are reordered accordingly.
  subroutine orient_layer(spec, xr, inner, error)
    type(patch_spec_t), intent(inout) :: spec
    real(wp), intent(in) :: xr(:, :)
    integer, intent(inout) :: inner(:, :) !! (4, nelem) nodes
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: a(3, 3), c(3, 4), at(3), n(3)
    integer :: e, i, first(2), side

    first = 0
    associate (s => spec%spline%surface)
      do e = 1, s%nelem
        associate (x => xr(:, inner(:, e)))
          do i = 1, 4
            c(:, i) = 0.5_wp*(corner_point(s, e, i) + x(:, i))
          end do
          call surface_at(s, e, [0.0_wp, 0.0_wp], at, n)
          a(:, 1) = c(:, 2) + c(:, 3) - c(:, 1) - c(:, 4)
          a(:, 2) = c(:, 3) + c(:, 4) - c(:, 1) - c(:, 2)
          a(:, 3) = 0.25_wp*sum(x, 2) - at
        end associate
        side = merge(1, 2, det3(a) > 0.0_wp) ! Jacobian at the middle of the hexahedron
        if (first(side) == 0) first(side) = e
      end do
      if (all(first > 0)) then
        call fail(error, DECK_ERROR, 'the inner nodes of elements '//to_text(minval(first)) &
                  //' and '//to_text(maxval(first))//' of layer '//quoted(spec%name) &
                  //' lie on different sides of the surface', spec%spline%layer_place, &
                  'give all elements the same orientation, and make the layer thinner than ' &
                  //'the radius of curvature of the surface')
        return
      end if
      if (first(1) > 0) return
      call transpose_surface(s)
      inner = inner([1, 4, 3, 2], :)
      if (allocated(spec%spline%inner)) spec%spline%inner = spec%spline%inner([1, 4, 3, 2], :)
    end associate
  end subroutine orient_layer

  !> Check that the inner nodes of each element are listed in the order of its corners, and that
  !! corners of different elements at the same point have the same inner node.
  subroutine check_layer(spec, xr, inner, error)
    type(patch_spec_t), intent(in) :: spec
    real(wp), intent(in) :: xr(:, :)
    integer, intent(in) :: inner(:, :) !! (4, nelem) nodes
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: point(:, :), node(:), elem(:), number(:), given(:, :)
    real(wp) :: x(3, 4), way(4)
    integer :: c, e, i, k

    associate (s => spec%spline%surface)
      call number_corners(s, point)
      allocate (node(maxval(point)), elem(maxval(point)), number(maxval(point)), source=0)
      given = inner ! their numbers in the message are those of the file of LAYEr
      if (allocated(spec%spline%inner)) given = spec%spline%inner
      do e = 1, s%nelem
        do i = 1, 4
          x(:, i) = corner_point(s, e, i)
        end do
        do k = 1, 4 ! fail if starting at another corner brings the nodes nearer to the corners
          way(k) = sum(norm2(xr(:, inner(:, e)) - cshift(x, k - 1, 2), 1))
        end do
        if (way(1) > minval(way(2:))) then
          call fail(error, DECK_ERROR, 'the inner nodes of element '//to_text(e)//' of layer ' &
                    //quoted(spec%name)//' are not in the order of the corners of the element', &
                    spec%spline%layer_place, 'list the nodes opposite the corners (-,-) (+,-) ' &
                    //'(+,+) (-,+), in this order')
          return
        end if
        do c = 1, 4
          associate (p => point(c, e))
            if (node(p) == 0) then
              node(p) = inner(c, e)
              elem(p) = e
              number(p) = given(c, e)
            else if (node(p) /= inner(c, e)) then
              call fail(error, DECK_ERROR, 'elements '//to_text(elem(p))//' and '//to_text(e) &
                        //' of layer '//quoted(spec%name)//' share a corner, but have different ' &
                        //'inner nodes there, '//to_text(number(p))//' and ' &
                        //to_text(given(c, e)), &
                        spec%spline%layer_place, 'elements that share a corner of the surface ' &
                        //'must share its inner node')
              return
            end if
          end associate
        end do
      end do
    end associate
  end subroutine check_layer

  !> Number the points at the corners of all elements. The corners of an element are listed
  !! counter-clockwise from (-,-). Two corners are the same point if the same functions have the
  !! same values there.
  subroutine number_corners(s, point)
    type(spline_surface_t), intent(in) :: s
    integer, allocatable, intent(out) :: point(:, :) !! (4, nelem)
    type(corner_t), allocatable :: corner(:)
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), sorted(:)
    real(wp), allocatable :: value(:)
    integer :: a, c, e, i, j, from, n

    allocate (corner(4*s%nelem), key(4*s%nelem), order(4*s%nelem), point(4, s%nelem))
    do i = 1, size(corner)
      e = (i + 3)/4
      c = i - 4*(e - 1)
      associate (node => s%node(s%first(e):s%first(e + 1) - 1))
        value = s%op(s%iop(e))%c(:, corner_polynomial(s%degree(:, e), c))
        sorted = node
        call sort_index(node, sorted)
        sorted = pack(sorted, [(abs(value(sorted(a))) > NOTHING, a=1, size(sorted))])
        corner(i)%node = node(sorted)
        corner(i)%value = value(sorted)
      end associate
      key(i) = hash(corner(i)%node)
    end do
    call sort_index(key, order)
    point = 0
    n = 0
    from = 1
    do i = 1, size(order)
      if (key(order(i)) /= key(order(from))) from = i
      associate (own => point(order(i) - 4*((order(i) - 1)/4), (order(i) + 3)/4))
        do j = from, i - 1
          if (.not. same(corner(order(i)), corner(order(j)))) cycle
          own = point(order(j) - 4*((order(j) - 1)/4), (order(j) + 3)/4)
          exit
        end do
        if (own > 0) cycle
        n = n + 1
        own = n
      end associate
    end do
  end subroutine number_corners

  !> Index of the only Bernstein polynomial that does not vanish at a corner.
  pure integer function corner_polynomial(degree, c) result(b)
    integer, intent(in) :: degree(2), c

    b = 1
    if (c == 2 .or. c == 3) b = b + degree(1)
    if (c > 2) b = b + (degree(1) + 1)*degree(2)
  end function corner_polynomial

  pure logical function same(a, b)
    type(corner_t), intent(in) :: a, b

    same = size(a%node) == size(b%node)
    if (same) same = all(a%node == b%node)
    if (same) same = all(abs(a%value - b%value) <= ALIKE)
  end function same

  !> Position of a corner [L].
  pure function corner_point(s, e, c) result(x)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e, c
    real(wp) :: x(3), w
    integer :: a, b, n

    b = corner_polynomial(s%degree(:, e), c)
    x = 0.0_wp
    w = 0.0_wp
    do a = 1, s%first(e + 1) - s%first(e)
      n = s%node(s%first(e) + a - 1)
      associate (f => s%op(s%iop(e))%c(a, b)*s%w(n))
        x = x + f*s%x(:, n)
        w = w + f
      end associate
    end do
    x = x/w
  end function corner_point

  !> Find the position and the area vector at a parent point of an element.
  subroutine surface_at(s, e, xi, x, area)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: x(3)    !! [L]
    real(wp), intent(out) :: area(3) !! a_1 x a_2 [L^2]
    type(cell_t) :: cell
    real(wp), allocatable :: f(:), df(:, :)
    real(wp) :: a(3, 2)

    associate (node => s%node(s%first(e):s%first(e + 1) - 1))
      cell%degree = [s%degree(:, e), 0]
      cell%c = s%op(s%iop(e))%c
      cell%w = s%w(node)
      allocate (f(size(node)), df(2, size(node)))
      call surface_functions(cell, xi, f, df)
      x = matmul(s%x(:, node), f)
      a = matmul(s%x(:, node), transpose(df))
    end associate
    area = cross(a(:, 1), a(:, 2))
  end subroutine surface_at

  !> Compute the area, the sum of the area vectors (zero if the surface is closed) and the enclosed
  !! volume, which is positive if the normals a_1 x a_2 point out of it.
  subroutine surface_measures(s, area, vector, volume)
    type(spline_surface_t), intent(in) :: s
    real(wp), intent(out) :: area, vector(3) !! [L^2]
    real(wp), intent(out) :: volume          !! [L^3]
    real(wp), allocatable :: xi(:, :), w(:)
    real(wp) :: x(3), n(3), middle(3)
    integer :: e, i, nq(2)

    area = 0.0_wp
    vector = 0.0_wp
    volume = 0.0_wp
    middle = sum(s%x(:, :s%nnode), 2)/s%nnode
    do e = 1, s%nelem
      nq = min(16, s%degree(:, e) + MORE)
      allocate (xi(2, product(nq)), w(product(nq)))
      call gauss_quad(nq(1), nq(2), xi, w)
      do i = 1, size(w)
        call surface_at(s, e, xi(:, i), x, n)
        n = n*w(i)
        area = area + norm2(n)
        vector = vector + n
        volume = volume + dot_product(x - middle, n)/3.0_wp
      end do
      deallocate (xi, w)
    end do
  end subroutine surface_measures

  !> Smallest distance between the midpoints of elements that face each other through the body. If
  !! there are many elements, only a sample of them is compared.
  function spline_thickness(s, out) result(thickness)
    type(spline_surface_t), intent(in) :: s
    real(wp), intent(in) :: out !! 1: a_1 x a_2 points out of the body, -1: into it
    real(wp) :: thickness       !! [L]; 0: no elements face each other
    real(wp), allocatable :: x(:, :), n(:, :)
    real(wp) :: d(3), length
    integer :: i, j, step, m

    step = (s%nelem - 1)/MOST_SAMPLES + 1
    m = (s%nelem - 1)/step + 1
    allocate (x(3, m), n(3, m))
    do i = 1, m
      call surface_at(s, 1 + (i - 1)*step, [0.0_wp, 0.0_wp], x(:, i), n(:, i))
      n(:, i) = out*n(:, i)/max(norm2(n(:, i)), tiny(1.0_wp))
    end do
    thickness = huge(thickness)
    do i = 1, m
      do j = 1, m
        if (dot_product(n(:, i), n(:, j)) > OPPOSITE) cycle
        d = x(:, i) - x(:, j)
        length = norm2(d)
        if (length >= thickness) cycle
        if (dot_product(d, n(:, i)) > STRAIGHT*length) thickness = length
      end do
    end do
    if (.not. thickness < huge(thickness)) thickness = 0.0_wp
  end function spline_thickness

end module spline_check
