!> Univariate functions, tensor products, integration rules and faces of hexahedral elements. The
!! equation numbers are those of Corbett and Sauer 2015.
module hexa_shape
  use base_kinds, only: wp
  use bspline, only: bernstein
  use element_type, only: cell_t, rule_t, topology_t
  use quadrature, only: gauss_hex
  implicit none
  private
  public :: linear, quadratic, spline, corner_functions, tensor_functions, make_rational, nine_modes
  public :: tensor_rule, tensor_marks, join_faces
  public :: CORNER_MARKS

  !> Largest degree for which work arrays have room. Decks and files are limited to the MAX_DEGREE
  !! of patch_nurbs.
  integer, parameter, public :: MAX_DEGREE = 15
  integer, parameter, public :: VTK_BEZIER_HEXAHEDRON = 79

  !> Signs of the parent coordinates of the corners, counter-clockwise from (-,-), lower plane first
  !! (FEAP and VTK order).
  integer, parameter :: CORNER(3, 8) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, &
                                                -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1], [3, 8])

  !> Which corners lie on the faces xi-, xi+, eta-, eta+, zeta- and zeta+?
  logical, parameter :: CORNER_MARKS(8, 6) = &
                        reshape([CORNER(1, :) < 0, CORNER(1, :) > 0, CORNER(2, :) < 0, &
                                 CORNER(2, :) > 0, CORNER(3, :) < 0, CORNER(3, :) > 0], [8, 6])

  !> Entries of an extraction operator below this fraction of the largest entry in their column are
  !! taken as zero.
  real(wp), parameter :: ZERO_SHARE = 1.0e-12_wp

contains

  !> Evaluate the linear Lagrange functions, eq. (17).
  pure subroutine linear(x, f, df)
    real(wp), intent(in) :: x
    real(wp), intent(out) :: f(2), df(2)

    f = [0.5_wp*(1.0_wp - x), 0.5_wp*(1.0_wp + x)]
    df = [-0.5_wp, 0.5_wp]
  end subroutine linear

  !> Evaluate the quadratic Lagrange functions of the nodes -1, 0, 1; eq. (18) lists them in another
  !! order.
  pure subroutine quadratic(x, f, df)
    real(wp), intent(in) :: x
    real(wp), intent(out) :: f(3), df(3)

    f = [0.5_wp*x*(x - 1.0_wp), (1.0_wp - x)*(1.0_wp + x), 0.5_wp*x*(x + 1.0_wp)]
    df = [x - 0.5_wp, -2.0_wp*x, x + 0.5_wp]
  end subroutine quadratic

  !> Evaluate the spline functions of a span in one direction: N = C B, eq. (8).
  pure subroutine spline(p, c, x, f, df)
    integer, intent(in) :: p
    real(wp), allocatable, intent(in) :: c(:, :) !! (p+1, p+1); not allocated: Bernstein polynomials
    real(wp), intent(in) :: x
    real(wp), intent(out) :: f(:), df(:) !! (p+1 or more)

    real(wp) :: b(MAX_DEGREE + 1), db(MAX_DEGREE + 1)

    if (.not. allocated(c)) then
      call bernstein(p, x, f(:p + 1), df(:p + 1))
    else
      call bernstein(p, x, b(:p + 1), db(:p + 1))
      f(:p + 1) = matmul(c, b(:p + 1))
      df(:p + 1) = matmul(c, db(:p + 1))
    end if
  end subroutine spline

  !> Evaluate the trilinear functions of the corners first to last, eq. (17).
  pure subroutine corner_functions(first, last, xi, shp, dshp)
    integer, intent(in) :: first, last
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: shp(first:)     !! (last)
    real(wp), intent(out) :: dshp(:, first:) !! (3, last)

    real(wp) :: f(2, 3), d(2, 3)
    integer :: a, n(3)

    do a = 1, 3
      call linear(xi(a), f(:, a), d(:, a))
    end do
    do a = first, last
      n = (CORNER(:, a) + 3)/2
      shp(a) = f(n(1), 1)*f(n(2), 2)*f(n(3), 3)
      dshp(1, a) = d(n(1), 1)*f(n(2), 2)*f(n(3), 3)
      dshp(2, a) = f(n(1), 1)*d(n(2), 2)*f(n(3), 3)
      dshp(3, a) = f(n(1), 1)*f(n(2), 2)*d(n(3), 3)
    end do
  end subroutine corner_functions

  !> Multiply the functions of three directions; the first one varies fastest.
  pure subroutine tensor_functions(f1, d1, f2, d2, f3, d3, shp, dshp)
    real(wp), intent(in) :: f1(:), d1(:) !! functions of direction 1 and their derivatives
    real(wp), intent(in) :: f2(:), d2(:)
    real(wp), intent(in) :: f3(:), d3(:)
    real(wp), intent(out) :: shp(:)      !! (n) with n the product of the numbers of functions
    real(wp), intent(out) :: dshp(:, :)  !! (3, n)

    integer :: i, j, k, a

    a = 0
    do k = 1, size(f3)
      do j = 1, size(f2)
        do i = 1, size(f1)
          a = a + 1
          shp(a) = f1(i)*f2(j)*f3(k)
          dshp(1, a) = d1(i)*f2(j)*f3(k)
          dshp(2, a) = f1(i)*d2(j)*f3(k)
          dshp(3, a) = f1(i)*f2(j)*d3(k)
        end do
      end do
    end do
  end subroutine tensor_functions

  !> Make functions rational: weighted functions divided by their sum, eqs (11) and (12).
  pure subroutine make_rational(w, f, df)
    real(wp), intent(in) :: w(:)         !! (n) weights
    real(wp), intent(inout) :: f(:)      !! (n)
    real(wp), intent(inout) :: df(:, :)  !! (ndirection, n)

    real(wp) :: total, slope(size(df, 1))
    integer :: a

    total = 0.0_wp
    slope = 0.0_wp
    do a = 1, size(f)
      f(a) = w(a)*f(a)
      df(:, a) = w(a)*df(:, a)
      total = total + f(a)
      slope = slope + df(:, a)
    end do
    do a = 1, size(f)
      f(a) = f(a)/total
      df(:, a) = (df(:, a) - f(a)*slope)/total
    end do
  end subroutine make_rational

  !> Evaluate the nine enhanced modes in the form of three covectors, (xi,0,0), (0,eta,0) and
  !! (0,0,zeta), each of which is multiplied by a vector of three parameters.
  pure subroutine nine_modes(xi, mode)
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: mode(:, :) !! (3, 3)

    integer :: i

    mode = 0.0_wp
    do i = 1, 3
      mode(i, i) = xi(i)
    end do
  end subroutine nine_modes

  !> Set a Gauss rule: `usual` points in the three directions, or q, q and qz if they are positive.
  subroutine tensor_rule(usual, q, qz, rule)
    integer, intent(in) :: usual(3), q, qz
    type(rule_t), intent(out) :: rule

    integer :: n(3)

    n = usual
    if (q > 0) n(:2) = q
    if (qz > 0) n(3) = qz
    rule%nq = product(n)
    allocate (rule%xi(3, rule%nq), rule%wgt(rule%nq))
    call gauss_hex(n(1), n(2), n(3), rule%xi, rule%wgt)
  end subroutine tensor_rule

  !> Find the functions of one direction that do not vanish at its lower end, and those that do not
  !! vanish at its upper end.
  pure subroutine touches(p, c, low, high)
    integer, intent(in) :: p
    real(wp), allocatable, intent(in) :: c(:, :)
    logical, intent(out) :: low(:), high(:) !! (p+1)

    low = .false.
    high = .false.
    if (allocated(c)) then ! only the first and the last Bernstein polynomial are not zero at an end
      low(:p + 1) = abs(c(:, 1)) > ZERO_SHARE*maxval(abs(c(:, 1)))
      high(:p + 1) = abs(c(:, p + 1)) > ZERO_SHARE*maxval(abs(c(:, p + 1)))
    else
      low(1) = .true.
      high(p + 1) = .true.
    end if
  end subroutine touches

  !> Mark the nodes of a tensor product that lie on each face; the first direction varies fastest.
  pure function tensor_marks(cell) result(on)
    type(cell_t), intent(in) :: cell
    logical :: on(product(cell%degree + 1), 6)

    logical :: low(MAX_DEGREE + 1, 3), high(MAX_DEGREE + 1, 3)
    integer :: n(3), i, j, k, a

    n = cell%degree + 1
    call touches(cell%degree(1), cell%c1, low(:, 1), high(:, 1))
    call touches(cell%degree(2), cell%c2, low(:, 2), high(:, 2))
    call touches(cell%degree(3), cell%c3, low(:, 3), high(:, 3))
    a = 0
    do k = 1, n(3)
      do j = 1, n(2)
        do i = 1, n(1)
          a = a + 1
          on(a, :) = [low(i, 1), high(i, 1), low(j, 2), high(j, 2), low(k, 3), high(k, 3)]
        end do
      end do
    end do
  end function tensor_marks

  !> Make the lists of the nodes of all faces from marks: on(a, f) is true if node a lies on face f.
  subroutine join_faces(on, topology)
    logical, intent(in) :: on(:, :) !! (nen, nface)
    type(topology_t), intent(inout) :: topology

    integer :: f, a

    topology%nen = size(on, 1)
    topology%nface = size(on, 2)
    allocate (topology%first(topology%nface + 1))
    topology%first(1) = 1
    do f = 1, topology%nface
      topology%first(f + 1) = topology%first(f) + count(on(:, f))
    end do
    topology%node = [((a, a=1, size(on, 1)), f=1, size(on, 2))]
    topology%node = pack(topology%node, [on])
  end subroutine join_faces

end module hexa_shape
