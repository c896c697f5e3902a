!> Represents an element exactly by a Bezier hexahedron of VTK, or a surface element by a Bezier
!! quadrilateral.
!!
!! The functions of an element on a tensor grid are N_A = n_A / W with polynomials n_A and W:
!!
!!   N_A W = sum_i a_iA B_i,  W = sum_i W_i B_i,  P_i = sum_A (a_iA / W_i) x_A
!!
!! with Bernstein polynomials B_i. The rational Bezier cell with the points P_i and weights W_i is
!! thus identical to the element: positions, displacements and fields at the nodes are mapped by the
!! coefficients a_iA / W_i. In general the cell has the degrees of the element. If only the surface
!! is rational (an enriched element with surface weights W(xi, eta)), the degrees of W and of the
!! bulk functions add up in their products. In both directions of the surface, the degree of the
!! cell is then higher by that of the bulk functions (one or two), and the cell is still exact. Its
!! weights are positive, because degree elevation takes means of the coefficients of W.
!!
!! The a_iA are found by interpolation, which needs only the functions and degrees of the element.
module view_bezier
  use base_kinds, only: wp
  use element_type, only: element_t, cell_t
  implicit none
  private
  public :: bezier_cell, bernstein_values, vtk_position

contains

  !> Find the points of the cell, in the order of VTK, as combinations of the nodes of the element.
  subroutine bezier_cell(row, cell, nen, degree, coef, weight)
    type(element_t), intent(in) :: row
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: nen
    integer, intent(out) :: degree(3)                  !! degrees of the Bezier cell
    real(wp), allocatable, intent(out) :: coef(:, :)   !! (nen, npoint)
    real(wp), allocatable, intent(out) :: weight(:)    !! (npoint)
    real(wp), allocatable :: a(:, :, :, :) !! (nen+1, n1, n2, n3); last row: weight
    real(wp), allocatable :: m1(:, :), m2(:, :), m3(:, :)
    integer :: i, j, k, n

    degree = cell%degree
    if (is_rational(cell) .and. on_surface(cell)) degree(1:2) = degree(1:2) + degree(3)
    allocate (a(nen + 1, degree(1) + 1, degree(2) + 1, degree(3) + 1))
    call sample(row, cell, degree, a)
    ! Transform values at the grid to Bernstein coefficients, in one direction after the other.
    call inverse_transposed(degree(1), m1)
    call inverse_transposed(degree(2), m2)
    call inverse_transposed(degree(3), m3)
    do k = 1, size(a, 4)
      do j = 1, size(a, 3)
        a(:, :, j, k) = matmul(a(:, :, j, k), m1)
      end do
      do i = 1, size(a, 2)
        a(:, i, :, k) = matmul(a(:, i, :, k), m2)
      end do
    end do
    do j = 1, size(a, 3)
      do i = 1, size(a, 2)
        a(:, i, j, :) = matmul(a(:, i, j, :), m3)
      end do
    end do
    allocate (coef(nen, product(degree + 1)), weight(product(degree + 1)))
    do k = 0, degree(3)
      do j = 0, degree(2)
        do i = 0, degree(1)
          n = vtk_position(i, j, k, degree)
          weight(n) = a(nen + 1, i + 1, j + 1, k + 1)
          coef(:, n) = a(:nen, i + 1, j + 1, k + 1)/weight(n)
        end do
      end do
    end do
    if (.not. is_rational(cell)) weight = 1.0_wp
  end subroutine bezier_cell

  !> Evaluate the functions times their denominator W, and W itself, at a grid of points.
  subroutine sample(row, cell, degree, a)
    type(element_t), intent(in) :: row
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: degree(3)
    real(wp), intent(out) :: a(:, :, :, :)
    type(cell_t) :: plain
    real(wp) :: w, xi(3)
    real(wp), allocatable :: shp(:), dshp(:, :)
    integer :: i, j, k, nen

    nen = size(a, 1) - 1
    allocate (shp(nen), dshp(3, nen))
    plain = cell
    if (allocated(plain%w)) deallocate (plain%w)
    do k = 1, size(a, 4)
      do j = 1, size(a, 3)
        do i = 1, size(a, 2)
          xi = [abscissa(degree(1), i), abscissa(degree(2), j), abscissa(degree(3), k)]
          w = 1.0_wp
          if (is_rational(cell)) then ! the control points come first
            if (on_surface(cell)) then
              call row%functions(plain, [xi(1:2), -1.0_wp], shp, dshp)
            else
              call row%functions(plain, xi, shp, dshp)
            end if
            w = dot_product(cell%w, shp(:size(cell%w)))
          end if
          call row%functions(cell, xi, shp, dshp)
          a(:nen, i, j, k) = shp*w
          a(nen + 1, i, j, k) = w
        end do
      end do
    end do
  end subroutine sample

  !> Find the inverse of M(i, s) = B_i(t_s). The coefficients of a polynomial with the values v_s at
  !! the points t_s are b_i = sum_s v_s inverse(s, i).
  subroutine inverse_transposed(degree, inverse)
    integer, intent(in) :: degree
    real(wp), allocatable, intent(out) :: inverse(:, :)
    real(wp), allocatable :: m(:, :), line(:)
    integer :: n, s, p

    n = degree + 1
    allocate (m(n, 2*n), line(2*n))
    m = 0.0_wp
    do s = 1, n
      m(:, s) = bernstein_values(degree, abscissa(degree, s))
      m(s, n + s) = 1.0_wp
    end do
    do s = 1, n ! Gauss-Jordan elimination with row exchange
      p = s - 1 + maxloc(abs(m(s:, s)), dim=1)
      line = m(p, :)
      m(p, :) = m(s, :)
      m(s, :) = line/line(s)
      do p = 1, n
        if (p /= s) m(p, :) = m(p, :) - m(p, s)*m(s, :)
      end do
    end do
    inverse = m(:, n + 1:)
  end subroutine inverse_transposed

  !> Interpolation points: both ends and Chebyshev points between them.
  pure function abscissa(degree, s) result(t)
    integer, intent(in) :: degree, s
    real(wp) :: t
    real(wp), parameter :: PI = acos(-1.0_wp)

    t = -cos(PI*real(s - 1, wp)/real(max(degree, 1), wp))
    if (2*(s - 1) == degree) t = 0.0_wp
  end function abscissa

  !> Bernstein polynomials of the given degree on [-1, 1].
  pure function bernstein_values(degree, t) result(b)
    integer, intent(in) :: degree
    real(wp), intent(in) :: t
    real(wp) :: b(degree + 1)
    integer :: i, n

    b = 0.0_wp
    b(1) = 1.0_wp
    do n = 1, degree
      do i = n + 1, 2, -1
        b(i) = 0.5_wp*((1.0_wp - t)*b(i) + (1.0_wp + t)*b(i - 1))
      end do
      b(1) = 0.5_wp*(1.0_wp - t)*b(1)
    end do
  end function bernstein_values

  !> Do the weights differ from one another?
  pure function is_rational(cell)
    type(cell_t), intent(in) :: cell
    logical :: is_rational

    is_rational = .false.
    if (allocated(cell%w)) then
      is_rational = maxval(cell%w) - minval(cell%w) > 10*epsilon(1.0_wp)*maxval(abs(cell%w))
    end if
  end function is_rational

  !> Do the weights belong to the surface zeta = -1 alone?
  pure function on_surface(cell)
    type(cell_t), intent(in) :: cell
    logical :: on_surface

    on_surface = .false.
    if (allocated(cell%w)) on_surface = size(cell%w) < product(cell%degree + 1)
    if (allocated(cell%c)) on_surface = cell%degree(3) > 0
  end function on_surface

  !> Position, counted from 1, of the Bezier point (i, j, k), counted from 0, in the list of VTK:
  !! corners, then edges, faces and interior (the rule of
  !! vtkHigherOrderHexahedron::PointIndexFromIJK).
  pure function vtk_position(i, j, k, degree) result(n)
    integer, intent(in) :: i, j, k
    integer, intent(in) :: degree(3)
    integer :: n
    integer :: m(3)
    logical :: end_of(3)

    m = degree - 1
    end_of = [i, j, k] == 0 .or. [i, j, k] == degree
    if (degree(3) == 0) then ! a quadrilateral
      if (end_of(1) .and. end_of(2)) then
        n = corner(i, j)
      else if (end_of(2)) then
        n = 4 + i - 1 + merge(m(1) + m(2), 0, j > 0)
      else if (end_of(1)) then
        n = 4 + j - 1 + merge(m(1), 2*m(1) + m(2), i > 0)
      else
        n = 4 + 2*(m(1) + m(2)) + i - 1 + m(1)*(j - 1)
      end if
    else if (count(end_of) == 3) then
      n = corner(i, j) + merge(4, 0, k > 0)
    else if (count(end_of) == 2) then
      n = 8
      if (.not. end_of(1)) then
        n = n + i - 1 + merge(m(1) + m(2), 0, j > 0) + merge(2*(m(1) + m(2)), 0, k > 0)
      else if (.not. end_of(2)) then
        n = n + j - 1 + merge(m(1), 2*m(1) + m(2), i > 0) + merge(2*(m(1) + m(2)), 0, k > 0)
      else
        n = n + 4*(m(1) + m(2)) + k - 1 + m(3)*corner(i, j)
      end if
    else if (count(end_of) == 1) then
      n = 8 + 4*sum(m)
      if (end_of(1)) then
        n = n + j - 1 + m(2)*(k - 1) + merge(m(2)*m(3), 0, i > 0)
      else if (end_of(2)) then
        n = n + 2*m(2)*m(3) + i - 1 + m(1)*(k - 1) + merge(m(3)*m(1), 0, j > 0)
      else
        n = n + 2*m(3)*(m(1) + m(2)) + i - 1 + m(1)*(j - 1) + merge(m(1)*m(2), 0, k > 0)
      end if
    else
      n = 8 + 4*sum(m) + 2*(m(2)*m(3) + m(3)*m(1) + m(1)*m(2)) + i - 1 + m(1)*(j - 1 + m(2)*(k - 1))
    end if
    n = n + 1
  end function vtk_position

  !> Number of a corner of a quadrilateral, counter-clockwise from 0.
  pure function corner(i, j)
    integer, intent(in) :: i, j
    integer :: corner

    if (j > 0) then
      corner = merge(2, 3, i > 0)
    else
      corner = merge(1, 0, i > 0)
    end if
  end function corner

end module view_bezier
