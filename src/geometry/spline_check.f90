!> Which way a spline surface looks, and whether the inner nodes of a layer belong to it.
!!
!! Corners of surface elements that are one point: files of extracted splines do not say which.
!!
!! Two corners are the same point where the same functions have the same values.
!!
!! Sizes of a spline surface by integration: which side is out, and how thick the body behind is.
module spline_check
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use patch_spec, only: patch_spec_t
  use spline_surface, only: spline_surface_t, transpose_surface
  use tensor, only: det3, cross
  use base_sort, only: sort_index, hash
  use element_type, only: cell_t
  use quadrature, only: gauss_quad
  use surface_shape, only: surface_functions
  implicit none
  private
  public :: check_layer, orient_layer, orient_tool, number_corners, corner_point, &
            surface_measures, surface_at, spline_thickness

  real(wp), parameter :: NOTHING = 1.0e-12_wp !! a function that vanishes at the corner
  real(wp), parameter :: ALIKE = 1.0e-9_wp    !! values are shares of one

  !> Functions that live at a corner, in the order of their control points, and their values.
  type :: corner_t
    integer :: n = 0
    integer, allocatable :: node(:)
    real(wp), allocatable :: value(:)
  end type corner_t

  integer, parameter :: MORE = 6 !! Gauss points beyond the degree: surfaces may be rational
  integer, parameter :: MOST_SAMPLES = 3000
  real(wp), parameter :: OPPOSITE = -0.5_wp, STRAIGHT = 0.8_wp !! cosines

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

  !> Number of the point at each corner, counter-clockwise from (-,-).
  subroutine number_corners(s, point)
    type(spline_surface_t), intent(in) :: s
    integer, allocatable, intent(out) :: point(:, :) !! (4, nelem)
    type(corner_t), allocatable :: corner(:)
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:)
    integer :: i, j, from, n

    allocate (corner(4*s%nelem), key(4*s%nelem), order(4*s%nelem), point(4, s%nelem))
    do i = 1, size(corner)
      call look_at(s, (i + 3)/4, i - 4*((i - 1)/4), corner(i))
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

  !> Bernstein polynomial that lives at a corner alone.
  pure integer function corner_polynomial(degree, c) result(b)
    integer, intent(in) :: degree(2), c

    b = 1
    if (c == 2 .or. c == 3) b = b + degree(1)
    if (c > 2) b = b + (degree(1) + 1)*degree(2)
  end function corner_polynomial

  subroutine look_at(s, e, c, corner)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e, c
    type(corner_t), intent(out) :: corner
    integer, allocatable :: order(:)
    real(wp), allocatable :: value(:)
    integer :: a, n

    associate (node => s%node(s%first(e):s%first(e + 1) - 1))
      allocate (order(size(node)), value(size(node)))
      value = s%op(s%iop(e))%c(:, corner_polynomial(s%degree(:, e), c))
      call sort_index(node, order)
      order = pack(order, [(abs(value(order(a))) > NOTHING, a=1, size(order))])
      n = size(order)
      corner%n = n
      corner%node = node(order)
      corner%value = value(order)
    end associate
  end subroutine look_at

  pure logical function same(a, b)
    type(corner_t), intent(in) :: a, b

    same = a%n == b%n
    if (same) same = all(a%node == b%node)
    if (same) same = all(abs(a%value - b%value) <= ALIKE)
  end function same

  !> Where a corner is [L].
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

  !> Point, and tangents' cross product, at a place of an element.
  subroutine surface_at(s, e, xi, x, area)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: x(3)    !! [L]
    real(wp), intent(out) :: area(3) !! a_1 x a_2 [L^2]
    type(cell_t) :: cell
    real(wp), allocatable :: f(:), df(:, :)
    real(wp) :: a(3, 2)

    call element_cell(s, e, cell)
    allocate (f(size(cell%w)), df(2, size(cell%w)))
    call surface_functions(cell, xi, f, df)
    associate (node => s%node(s%first(e):s%first(e + 1) - 1))
      x = matmul(s%x(:, node), f)
      a = matmul(s%x(:, node), transpose(df))
    end associate
    area = cross(a(:, 1), a(:, 2))
  end subroutine surface_at

  subroutine element_cell(s, e, cell)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: e
    type(cell_t), intent(out) :: cell

    cell%degree = [s%degree(:, e), 0]
    cell%c = s%op(s%iop(e))%c
    cell%w = s%w(s%node(s%first(e):s%first(e + 1) - 1))
  end subroutine element_cell

  !> Area, sum of the area vectors (zero where the surface is closed) and the volume that the
  !! normals a_1 x a_2 point out of.
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

  !> Least distance [L] of points that face each other through the body, from the middles of
  !! elements, of some of them where there are many; `out` is 1 where a_1 x a_2 points out of the
  !! body, -1 where it points into it. 0: nothing faces each other.
  function spline_thickness(s, out) result(thickness)
    type(spline_surface_t), intent(in) :: s
    real(wp), intent(in) :: out
    real(wp) :: thickness
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
