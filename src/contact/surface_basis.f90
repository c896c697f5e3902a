!> Shape functions of an element on one of its faces, in Bernstein form: N = C B.
!!
!! The extraction operator C is found by collocation from the shape functions of the element's row
!! in the table, so that every element type is covered. Weights are usually kept separately
!! (surface%w), so that C gives the functions without weights. The exceptions are lateral faces of
!! rational enriched elements, on which Lagrange nodes and control points share the denominator W of
!! the surface. There, C contains the weights (the functions of the Lagrange nodes are W N_b), and
!! surface%w is one.
module surface_basis
  use base_kinds, only: wp
  use bspline, only: bernstein
  use contact_pair, only: surface_basis_t
  use element_type, only: element_t, cell_t
  use face_rule, only: face_directions
  use hexa_shape, only: make_rational
  use lapack, only: dgesv
  use quadrature, only: gauss, gauss_quad
  implicit none
  private
  public :: find_basis, same_basis, is_mixed, surface_functions_at, make_rational

  !> Coefficients that differ by less than ROUNDING from a multiple of 1/FRACTION are rounded to it.
  real(wp), parameter :: ROUNDING = 1.0e-12_wp, FRACTION = 40320.0_wp

contains

  !> Find the shape functions on face `side`, and the local nodes to which they belong.
  subroutine find_basis(row, cell, nen, side, basis, local)
    type(element_t), intent(in) :: row
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: nen, side
    type(surface_basis_t), intent(out) :: basis
    integer, allocatable, intent(out) :: local(:)
    real(wp), allocatable :: x(:, :), w(:), v(:, :), c(:, :), dshp(:, :), below(:), m1(:, :), &
                             m2(:, :)
    type(cell_t) :: plain
    real(wp) :: xi(3)
    integer :: d(2), n1, n2, i, j, a, q

    basis%degree = face_degree(cell, nen, side)
    n1 = basis%degree(1) + 1
    n2 = basis%degree(2) + 1
    allocate (x(2, n1*n2), w(n1*n2), v(nen, n1*n2), c(nen, n1*n2), dshp(3, nen), below(nen))
    allocate (m1(n1, n1), m2(n2, n2))
    plain = cell ! without weights, the functions are the numerators of the rational ones
    if (allocated(plain%w)) deallocate (plain%w)
    d = directions(side)
    call gauss_quad(n1, n2, x, w)
    do q = 1, n1*n2
      xi((side + 1)/2) = merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
      xi(d) = x(:, q)
      if (is_mixed(cell, nen, side)) then
        call row%functions(cell, xi, v(:, q), dshp)
        call row%functions(plain, [xi(1), xi(2), -1.0_wp], below, dshp)
        v(:, q) = v(:, q)*dot_product(cell%w, below(:size(cell%w)))
      else
        call row%functions(plain, xi, v(:, q), dshp)
      end if
    end do
    call invert_collocation(n1, m1)
    call invert_collocation(n2, m2)
    do j = 1, n2 ! along direction 2, then along direction 1
      do i = 1, n1
        c(:, i + n1*(j - 1)) = matmul(v(:, i:i + n1*(n2 - 1):n1), m2(j, :))
      end do
    end do
    do j = 1, n2
      v(:, n1*(j - 1) + 1:n1*j) = matmul(c(:, n1*(j - 1) + 1:n1*j), transpose(m1))
    end do
    c = anint(v*FRACTION)/FRACTION ! for uniform knots, the coefficients are fractions
    where (abs(v - c) < ROUNDING) v = c
    local = pack([(a, a=1, nen)], [(any(abs(v(a, :)) > 0.0_wp), a=1, nen)])
    basis%nsf = size(local)
    basis%c = v(local, :)
  end subroutine find_basis

  !> Do only some of the nodes on the face have weights?
  pure logical function is_mixed(cell, nen, side)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: nen, side

    is_mixed = .false.
    if (allocated(cell%w)) is_mixed = size(cell%w) < nen .and. side < 5
  end function is_mixed

  !> Degrees in the directions of the face. The surface of an enriched element has more functions
  !! than the tensor product of the degrees of the bulk.
  pure function face_degree(cell, nen, side) result(p)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: nen, side
    integer :: p(2), full(3)
    logical :: enriched

    full = cell%degree
    enriched = nen /= product(cell%degree + 1)
    if (allocated(cell%c)) enriched = cell%degree(3) > 0
    if (is_mixed(cell, nen, side)) then
      full(:2) = full(:2) + full(3)
    else if (enriched .and. side == 6) then
      full(:2) = full(3)
    else if (enriched .and. side < 5) then
      full(:2) = max(full(:2), full(3))
    end if
    p = full(directions(side))
  end function face_degree

  !> Directions a and b of the element on a face, ordered such that a_1 x a_2 points out of the
  !! body.
  pure function directions(side) result(d)
    integer, intent(in) :: side
    integer :: d(2), normal

    call face_directions(side, normal, d(1), d(2))
    if (mod(side, 2) == 1) d = d([2, 1])
  end function directions

  !> Find m(b, q), the Bernstein coefficient b of the polynomial that is one at Gauss point q of n
  !! points and zero at the others.
  subroutine invert_collocation(n, m)
    integer, intent(in) :: n
    real(wp), intent(out) :: m(n, n)
    real(wp) :: a(n, n), b(n), db(n), x(n), w(n)
    integer :: pivot(n), info, q

    call gauss(n, x, w)
    m = 0.0_wp
    do q = 1, n
      call bernstein(n - 1, x(q), b, db)
      a(q, :) = b
      m(q, q) = 1.0_wp
    end do
    call dgesv(n, n, a, n, pivot, m, n, info)
  end subroutine invert_collocation

  !> Do two bases have the same functions?
  pure logical function same_basis(a, b)
    type(surface_basis_t), intent(in) :: a, b

    same_basis = all(a%degree == b%degree) .and. a%nsf == b%nsf
    if (same_basis) same_basis = all(abs(a%c - b%c) < ROUNDING)
  end function same_basis

  !> Evaluate N and its derivatives at any point of [-1,1]^2, without the weights of the surface.
  pure subroutine surface_functions_at(basis, xi, shp, dshp)
    type(surface_basis_t), intent(in) :: basis
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: shp(:)     !! (nsf)
    real(wp), intent(out) :: dshp(:, :) !! (2, nsf)
    real(wp) :: f1(basis%degree(1) + 1), d1(basis%degree(1) + 1)
    real(wp) :: f2(basis%degree(2) + 1), d2(basis%degree(2) + 1)
    real(wp) :: s(basis%nsf, 3), f(3)
    integer :: a, i, j, b, n

    n = basis%nsf
    call bernstein(basis%degree(1), xi(1), f1, d1)
    call bernstein(basis%degree(2), xi(2), f2, d2)
    s = 0.0_wp
    b = 0
    do j = 1, size(f2)
      do i = 1, size(f1)
        b = b + 1
        f = [f1(i)*f2(j), d1(i)*f2(j), f1(i)*d2(j)]
        !$omp simd
        do a = 1, n
          s(a, 1) = s(a, 1) + basis%c(a, b)*f(1)
          s(a, 2) = s(a, 2) + basis%c(a, b)*f(2)
          s(a, 3) = s(a, 3) + basis%c(a, b)*f(3)
        end do
      end do
    end do
    shp(:n) = s(:, 1)
    dshp(1, :n) = s(:, 2)
    dshp(2, :n) = s(:, 3)
  end subroutine surface_functions_at

end module surface_basis
