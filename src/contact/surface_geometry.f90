!> Current geometry of a surface: its Bezier points, and position, tangents and second derivatives
!! at any of its points.
module surface_geometry
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use hexa_shape, only: MAX_DEGREE
  use projection_type, only: shape_t
  implicit none
  private
  public :: update_shape, surface_point

contains

  !> Find the Bezier points of all elements at the current positions of the nodes, and the boxes
  !! around them.
  subroutine update_shape(surface, x, shape)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: x(:, :)       !! (3, nnode) current positions [L]
    type(shape_t), intent(inout) :: shape
    real(wp) :: c, w, p(3)
    integer :: e, a, b, k, n
    logical :: rational

    rational = allocated(surface%w)
    if (.not. allocated(shape%bez)) then
      n = maxval([(product(surface%basis(k)%degree + 1), k=1, size(surface%basis))])
      allocate (shape%bez(3, n, surface%nelem), source=0.0_wp)
      allocate (shape%low(3, surface%nelem), shape%high(3, surface%nelem))
      if (rational) allocate (shape%w(n, surface%nelem), source=1.0_wp)
    end if
    do e = 1, surface%nelem
      associate (basis => surface%basis(surface%ibasis(e)), first => surface%first(e))
        n = product(basis%degree + 1)
        do b = 1, n ! C^T x, or C^T (w x) over C^T w
          p = 0.0_wp
          w = 0.0_wp
          do a = 1, basis%nsf
            c = basis%c(a, b)
            if (.not. abs(c) > 0.0_wp) cycle
            if (rational) c = c*surface%w(first + a - 1)
            w = w + c
            p = p + c*x(:, surface%node(first + a - 1))
          end do
          if (rational) then
            p = p/w
            shape%w(b, e) = w
          end if
          shape%bez(:, b, e) = p
        end do
        shape%low(:, e) = shape%bez(:, 1, e)
        shape%high(:, e) = shape%bez(:, 1, e)
        do b = 2, n
          shape%low(:, e) = min(shape%low(:, e), shape%bez(:, b, e))
          shape%high(:, e) = max(shape%high(:, e), shape%bez(:, b, e))
        end do
      end associate
    end do
  end subroutine update_shape

  !> Find position, tangents and second derivatives 11, 22, 12 at a point of an element.
  pure subroutine surface_point(surface, shape, e, xi, x, a, b)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    integer :: p(2)

    p = surface%basis(surface%ibasis(e))%degree
    if (allocated(shape%w)) then
      call rational_point(p(1) + 1, p(2) + 1, shape%bez(1, 1, e), shape%w(1, e), xi, x, a, b)
    else if (p(1) == 2 .and. p(2) == 2) then
      call biquadratic(shape%bez(1, 1, e), xi, x, a, b)
    else if (p(1) == 1 .and. p(2) == 1) then
      call bilinear(shape%bez(1, 1, e), xi, x, a, b)
    else if (p(1) == 3 .and. p(2) == 3) then ! the compiler specialises for constant sizes
      call tensor_point(4, 4, shape%bez(1, 1, e), xi, x, a, b)
    else
      call tensor_point(p(1) + 1, p(2) + 1, shape%bez(1, 1, e), xi, x, a, b)
    end if
  end subroutine surface_point

  !> Evaluate a surface of degrees 1 x 1.
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

  !> Evaluate a surface of degrees 2 x 2: first along the rows of direction 1, then across them. All
  !! quantities of one component are scalars, which stay in registers.
  pure subroutine biquadratic(p, xi, x, a, b)
    real(wp), intent(in) :: p(3, 3, 3), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    real(wp) :: f1, f2, f3, g1, g2, g3       ! functions of the two directions
    real(wp) :: df1, df2, df3, dg1, dg2, dg3 ! their derivatives
    real(wp) :: row1, row2, row3, slope1, slope2, slope3, bend1, bend2, bend3
    integer :: c

    call quadratics(xi(1), f1, f2, f3, df1, df2, df3)
    call quadratics(xi(2), g1, g2, g3, dg1, dg2, dg3)
    do c = 1, 3
      row1 = f1*p(c, 1, 1) + f2*p(c, 2, 1) + f3*p(c, 3, 1)
      row2 = f1*p(c, 1, 2) + f2*p(c, 2, 2) + f3*p(c, 3, 2)
      row3 = f1*p(c, 1, 3) + f2*p(c, 2, 3) + f3*p(c, 3, 3)
      slope1 = df1*p(c, 1, 1) + df2*p(c, 2, 1) + df3*p(c, 3, 1)
      slope2 = df1*p(c, 1, 2) + df2*p(c, 2, 2) + df3*p(c, 3, 2)
      slope3 = df1*p(c, 1, 3) + df2*p(c, 2, 3) + df3*p(c, 3, 3)
      bend1 = 0.5_wp*(p(c, 1, 1) + p(c, 3, 1)) - p(c, 2, 1)
      bend2 = 0.5_wp*(p(c, 1, 2) + p(c, 3, 2)) - p(c, 2, 2)
      bend3 = 0.5_wp*(p(c, 1, 3) + p(c, 3, 3)) - p(c, 2, 3)
      x(c) = g1*row1 + g2*row2 + g3*row3
      a(c, 1) = g1*slope1 + g2*slope2 + g3*slope3
      a(c, 2) = dg1*row1 + dg2*row2 + dg3*row3
      b(c, 1) = g1*bend1 + g2*bend2 + g3*bend3
      b(c, 2) = 0.5_wp*(row1 + row3) - row2
      b(c, 3) = dg1*slope1 + dg2*slope2 + dg3*slope3
    end do
  end subroutine biquadratic

  !> Quadratic Bernstein polynomials on [-1,1] and their first derivatives.
  pure subroutine quadratics(xi, f1, f2, f3, df1, df2, df3)
    real(wp), intent(in) :: xi
    real(wp), intent(out) :: f1, f2, f3, df1, df2, df3
    real(wp) :: s, t

    s = 0.5_wp*(1.0_wp - xi)
    t = 0.5_wp*(1.0_wp + xi)
    f1 = s*s
    f2 = 2.0_wp*s*t
    f3 = t*t
    df1 = -s
    df2 = s - t
    df3 = t
  end subroutine quadratics

  !> Evaluate Bernstein polynomials on [-1,1] and their first two derivatives, without allocation.
  pure subroutine fill_basis(n, xi, f)
    integer, intent(in) :: n             !! degree + 1
    real(wp), intent(in) :: xi
    real(wp), intent(inout) :: f(0:MAX_DEGREE, 0:2)
    real(wp) :: low(-2:MAX_DEGREE), s, t
    integer :: p, q, i

    if (n == 4) then
      s = 0.5_wp*(1.0_wp - xi)
      t = 0.5_wp*(1.0_wp + xi)
      f(:3, 0) = [s**3, 3.0_wp*s*s*t, 3.0_wp*s*t*t, t**3]
      f(:3, 1) = 1.5_wp*[-s*s, s*(s - 2.0_wp*t), t*(2.0_wp*s - t), t*t]
      f(:3, 2) = 1.5_wp*[s, t - 2.0_wp*s, s - 2.0_wp*t, t]
      return
    end if
    p = n - 1
    low = 0.0_wp
    low(0) = 1.0_wp
    f(:p, 2) = 0.0_wp
    do q = 1, p
      if (q == p - 1) then ! low has degree p - 2
        do i = 0, p
          f(i, 2) = 0.25_wp*p*(p - 1)*(low(i - 2) - 2.0_wp*low(i - 1) + low(i))
        end do
      end if
      if (q == p) then
        do i = 0, p
          f(i, 1) = 0.5_wp*p*(low(i - 1) - low(i))
        end do
      end if
      do i = q, 0, -1
        low(i) = 0.5_wp*((1.0_wp - xi)*low(i) + (1.0_wp + xi)*low(i - 1))
      end do
    end do
    f(:p, 0) = low(0:p)
  end subroutine fill_basis

  !> Evaluate a polynomial surface of any degrees.
  pure subroutine tensor_point(n1, n2, p, xi, x, a, b)
    integer, intent(in) :: n1, n2
    real(wp), intent(in) :: p(3, n1, n2), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    real(wp) :: f(0:MAX_DEGREE, 0:2), g(0:MAX_DEGREE, 0:2), row(3), slope(3), bend(3)
    integer :: i, j

    call fill_basis(n1, xi(1), f)
    call fill_basis(n2, xi(2), g)
    x = 0.0_wp
    a = 0.0_wp
    b = 0.0_wp
    do j = 1, n2
      row = 0.0_wp
      slope = 0.0_wp
      bend = 0.0_wp
      do i = 1, n1
        row = row + f(i - 1, 0)*p(:, i, j)
        slope = slope + f(i - 1, 1)*p(:, i, j)
        bend = bend + f(i - 1, 2)*p(:, i, j)
      end do
      x = x + g(j - 1, 0)*row
      a(:, 1) = a(:, 1) + g(j - 1, 0)*slope
      a(:, 2) = a(:, 2) + g(j - 1, 1)*row
      b(:, 1) = b(:, 1) + g(j - 1, 0)*bend
      b(:, 2) = b(:, 2) + g(j - 1, 2)*row
      b(:, 3) = b(:, 3) + g(j - 1, 1)*slope
    end do
  end subroutine tensor_point

  !> Evaluate a rational surface of any degrees: w x and w as polynomials, then their quotient.
  pure subroutine rational_point(n1, n2, bez, w, xi, x, a, b)
    integer, intent(in) :: n1, n2
    real(wp), intent(in) :: bez(3, n1*n2), w(n1*n2), xi(2)
    real(wp), intent(out) :: x(3), a(3, 2), b(3, 3)
    integer, parameter :: FIRST(3) = [1, 2, 1], SECOND(3) = [1, 2, 2]
    real(wp) :: p(3, (MAX_DEGREE + 1)**2), q(3, (MAX_DEGREE + 1)**2)
    real(wp) :: h(3), ha(3, 2), hb(3, 3)
    integer :: i

    do i = 1, n1*n2
      p(:, i) = w(i)*bez(:, i)
      q(:, i) = w(i)
    end do
    call tensor_point(n1, n2, p, xi, x, a, b)
    call tensor_point(n1, n2, q, xi, h, ha, hb)
    x = x/h(1)
    do i = 1, 2
      a(:, i) = (a(:, i) - ha(1, i)*x)/h(1)
    end do
    do i = 1, 3
      b(:, i) = (b(:, i) - hb(1, i)*x - ha(1, FIRST(i))*a(:, SECOND(i)) &
                 - ha(1, SECOND(i))*a(:, FIRST(i)))/h(1)
    end do
  end subroutine rational_point

end module surface_geometry
