!> Where a surface is now: its Bezier points, and points with tangents and curvatures on it.
module contact_shape
  use base_kinds, only: wp
  use bspline, only: bernstein
  use contact_foot, only: shape_t
  use contact_pair, only: surface_t
  implicit none
  private
  public :: update_shape, surface_point

contains

  !> Bezier points of all elements from the nodes' positions, and boxes round them.
  subroutine update_shape(surface, x, shape)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: x(:, :)       !! (3, nnode) current positions [L]
    type(shape_t), intent(inout) :: shape
    integer :: e, n

    if (.not. allocated(shape%bez)) call allocate_shape(surface, shape)
    do e = 1, surface%nelem
      associate (kind => surface%kind(surface%ikind(e)), first => surface%first(e))
        n = product(kind%degree + 1)
        if (allocated(surface%w)) then
          call find_rational(kind%c, surface%node(first:), surface%w(first:), x, &
            shape%bez(:, :n, e), shape%w(:n, e))
        else
          call find_points(kind%c, surface%node(first:), x, shape%bez(:, :n, e))
        end if
        shape%low(:, e) = minval(shape%bez(:, :n, e), dim=2)
        shape%high(:, e) = maxval(shape%bez(:, :n, e), dim=2)
      end associate
    end do
  end subroutine update_shape

  subroutine allocate_shape(surface, shape)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(inout) :: shape
    integer :: k, nb

    nb = 0
    do k = 1, size(surface%kind)
      nb = max(nb, product(surface%kind(k)%degree + 1))
    end do
    allocate (shape%bez(3, nb, surface%nelem), source=0.0_wp)
    allocate (shape%low(3, surface%nelem), shape%high(3, surface%nelem))
    if (allocated(surface%w)) allocate (shape%w(nb, surface%nelem), source=1.0_wp)
  end subroutine allocate_shape

  !> C^T x.
  pure subroutine find_points(c, node, x, bez)
    real(wp), intent(in) :: c(:, :)       !! (nsf, nb)
    integer, intent(in) :: node(:)        !! (nsf or more)
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(out) :: bez(:, :)    !! (3, nb)
    integer :: a, b

    do b = 1, size(c, 2)
      bez(:, b) = 0.0_wp
      do a = 1, size(c, 1)
        if (abs(c(a, b)) > 0.0_wp) bez(:, b) = bez(:, b) + c(a, b)*x(:, node(a))
      end do
    end do
  end subroutine find_points

  !> C^T (w x) over C^T w.
  pure subroutine find_rational(c, node, w, x, bez, wb)
    real(wp), intent(in) :: c(:, :)
    integer, intent(in) :: node(:)
    real(wp), intent(in) :: w(:)
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(out) :: bez(:, :), wb(:)
    integer :: a, b

    do b = 1, size(c, 2)
      bez(:, b) = 0.0_wp
      wb(b) = 0.0_wp
      do a = 1, size(c, 1)
        bez(:, b) = bez(:, b) + c(a, b)*w(a)*x(:, node(a))
        wb(b) = wb(b) + c(a, b)*w(a)
      end do
      bez(:, b) = bez(:, b)/wb(b)
    end do
  end subroutine find_rational

  !> Position, tangents and second derivatives 11, 22, 12 at a point of an element.
  pure subroutine surface_point(surface, shape, e, xi, x, a, b)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    integer :: p(2)

    p = surface%kind(surface%ikind(e))%degree
    if (allocated(shape%w)) then
      call rational_point(p + 1, shape%bez(:, :, e), shape%w(:, e), xi, x, a, b)
    else if (p(1) == 2 .and. p(2) == 2) then
      call biquadratic(shape%bez(1, 1, e), xi, x, a, b)
    else if (p(1) == 1 .and. p(2) == 1) then
      call bilinear(shape%bez(1, 1, e), xi, x, a, b)
    else
      call tensor_point(3, p(1) + 1, p(2) + 1, shape%bez(1, 1, e), xi, x, a, b)
    end if
  end subroutine surface_point

  pure subroutine bilinear(p, xi, x, a, b)
    real(wp), intent(in) :: p(3, 2, 2), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    real(wp) :: s, t

    s = 0.5_wp*(1.0_wp + xi(1))
    t = 0.5_wp*(1.0_wp + xi(2))
    a(:, 1) = 0.5_wp*((1.0_wp - t)*(p(:, 2, 1) - p(:, 1, 1)) + t*(p(:, 2, 2) - p(:, 1, 2)))
    a(:, 2) = 0.5_wp*((1.0_wp - s)*(p(:, 1, 2) - p(:, 1, 1)) + s*(p(:, 2, 2) - p(:, 2, 1)))
    x = (1.0_wp - t)*((1.0_wp - s)*p(:, 1, 1) + s*p(:, 2, 1)) &
      + t*((1.0_wp - s)*p(:, 1, 2) + s*p(:, 2, 2))
    b(:, :2) = 0.0_wp
    b(:, 3) = 0.25_wp*((p(:, 2, 2) - p(:, 1, 2)) - (p(:, 2, 1) - p(:, 1, 1)))
  end subroutine bilinear

  !> Rows in direction 1 first, then across them.
  pure subroutine biquadratic(p, xi, x, a, b)
    real(wp), intent(in) :: p(3, 3, 3), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    real(wp) :: f(3, 2), d(3, 2), s, t, row(3, 3), slope(3, 3), bend(3, 3)
    integer :: i, j

    do i = 1, 2
      s = 0.5_wp*(1.0_wp - xi(i))
      t = 0.5_wp*(1.0_wp + xi(i))
      f(1, i) = s*s
      f(2, i) = 2.0_wp*s*t
      f(3, i) = t*t
      d(1, i) = -s
      d(2, i) = s - t
      d(3, i) = t
    end do
    do j = 1, 3
      row(:, j) = f(1, 1)*p(:, 1, j) + f(2, 1)*p(:, 2, j) + f(3, 1)*p(:, 3, j)
      slope(:, j) = d(1, 1)*p(:, 1, j) + d(2, 1)*p(:, 2, j) + d(3, 1)*p(:, 3, j)
      bend(:, j) = 0.5_wp*(p(:, 1, j) + p(:, 3, j)) - p(:, 2, j)
    end do
    x = f(1, 2)*row(:, 1) + f(2, 2)*row(:, 2) + f(3, 2)*row(:, 3)
    a(:, 1) = f(1, 2)*slope(:, 1) + f(2, 2)*slope(:, 2) + f(3, 2)*slope(:, 3)
    a(:, 2) = d(1, 2)*row(:, 1) + d(2, 2)*row(:, 2) + d(3, 2)*row(:, 3)
    b(:, 1) = f(1, 2)*bend(:, 1) + f(2, 2)*bend(:, 2) + f(3, 2)*bend(:, 3)
    b(:, 2) = 0.5_wp*(row(:, 1) + row(:, 3)) - row(:, 2)
    b(:, 3) = d(1, 2)*slope(:, 1) + d(2, 2)*slope(:, 2) + d(3, 2)*slope(:, 3)
  end subroutine biquadratic

  !> Any degrees, nc components.
  pure subroutine tensor_point(nc, n1, n2, p, xi, x, a, b)
    integer, intent(in) :: nc, n1, n2
    real(wp), intent(in) :: p(nc, n1, n2), xi(2)
    real(wp), intent(out) :: x(nc), a(nc, 2), b(nc, 3)
    real(wp) :: f1(n1), d1(n1), b1(n1), f2(n2), d2(n2), b2(n2), row(nc), slope(nc), bend(nc)
    integer :: i, j

    call bernstein(n1 - 1, xi(1), f1, d1, b1)
    call bernstein(n2 - 1, xi(2), f2, d2, b2)
    x = 0.0_wp
    a = 0.0_wp
    b = 0.0_wp
    do j = 1, n2
      row = 0.0_wp
      slope = 0.0_wp
      bend = 0.0_wp
      do i = 1, n1
        row = row + f1(i)*p(:, i, j)
        slope = slope + d1(i)*p(:, i, j)
        bend = bend + b1(i)*p(:, i, j)
      end do
      x = x + f2(j)*row
      a(:, 1) = a(:, 1) + f2(j)*slope
      a(:, 2) = a(:, 2) + d2(j)*row
      b(:, 1) = b(:, 1) + f2(j)*bend
      b(:, 2) = b(:, 2) + b2(j)*row
      b(:, 3) = b(:, 3) + d2(j)*slope
    end do
  end subroutine tensor_point

  !> The same in four homogeneous components, then the quotient.
  pure subroutine rational_point(n, bez, w, xi, x, a, b)
    integer, intent(in) :: n(2)
    real(wp), intent(in) :: bez(:, :), w(:), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    integer, parameter :: FIRST(3) = [1, 2, 1], SECOND(3) = [1, 2, 2]
    real(wp) :: p(4, n(1)*n(2)), h(4), ha(4, 2), hb(4, 3)
    integer :: i

    do i = 1, size(p, 2)
      p(:3, i) = w(i)*bez(:, i)
      p(4, i) = w(i)
    end do
    call tensor_point(4, n(1), n(2), p, xi, h, ha, hb)
    x = h(:3)/h(4)
    do i = 1, 2
      a(:, i) = (ha(:3, i) - ha(4, i)*x)/h(4)
    end do
    do i = 1, 3
      b(:, i) = (hb(:3, i) - hb(4, i)*x - ha(4, FIRST(i))*a(:, SECOND(i)) &
        - ha(4, SECOND(i))*a(:, FIRST(i)))/h(4)
    end do
  end subroutine rational_point

end module contact_shape
