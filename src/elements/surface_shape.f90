!> Functions of the isogeometric surface of an element: either a tensor product, or any number of
!! functions with an extraction operator for the whole element (at extraordinary points and
!! T-junctions). The equation numbers are those of Corbett and Sauer 2015.
module surface_shape
  use base_kinds, only: wp
  use bspline, only: bernstein
  use element_type, only: cell_t, topology_t
  use hexa_shape, only: spline, tensor_marks, join_faces, make_rational, MAX_DEGREE, &
                        VTK_BEZIER_HEXAHEDRON
  implicit none
  private
  public :: surface_functions, surface_count, surface_touches, layer_functions, layer_faces

  !> Entries of an operator below this limit are taken as zero; the largest entry is about one.
  real(wp), parameter :: NOTHING = 1.0e-12_wp

contains

  !> Number of functions of an isogeometric surface.
  pure integer function surface_count(cell) result(n)
    type(cell_t), intent(in) :: cell

    if (allocated(cell%c)) then
      n = size(cell%c, 1)
    else
      n = (cell%degree(1) + 1)*(cell%degree(2) + 1)
    end if
  end function surface_count

  !> Evaluate the functions of an isogeometric surface, eqs (10) to (12); the first direction runs
  !! fastest.
  pure subroutine surface_functions(cell, xi, f, df)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: f(:)     !! (ncp)
    real(wp), intent(out) :: df(:, :) !! (2, ncp)

    real(wp) :: f1(MAX_DEGREE + 1), f2(MAX_DEGREE + 1), d1(MAX_DEGREE + 1), d2(MAX_DEGREE + 1)
    integer :: i, j, a, n1, n2

    n1 = cell%degree(1) + 1
    n2 = cell%degree(2) + 1
    if (allocated(cell%c)) then
      call extracted(cell, xi, f, df)
      if (allocated(cell%w)) call make_rational(cell%w, f, df)
      return
    end if
    call spline(cell%degree(1), cell%c1, xi(1), f1, d1)
    call spline(cell%degree(2), cell%c2, xi(2), f2, d2)
    a = 0
    do j = 1, n2
      do i = 1, n1
        a = a + 1
        f(a) = f1(i)*f2(j)
        df(1, a) = d1(i)*f2(j)
        df(2, a) = f1(i)*d2(j)
      end do
    end do
    if (allocated(cell%w)) call make_rational(cell%w(:a), f(:a), df(:, :a))
  end subroutine surface_functions

  !> Multiply the surface functions by a function of the third direction, which gives the
  !! isogeometric layer of an element.
  pure subroutine layer_functions(cell, xi, f3, d3, shp, dshp)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(3)
    real(wp), intent(in) :: f3, d3      !! function of the third direction and its derivative
    real(wp), intent(out) :: shp(:)     !! (ncp)
    real(wp), intent(out) :: dshp(:, :) !! (3, ncp)

    call surface_functions(cell, xi(:2), shp, dshp(:2, :))
    dshp(3, :) = shp*d3
    dshp(:2, :) = dshp(:2, :)*f3
    shp = shp*f3
  end subroutine layer_functions

  !> Evaluate N = C B with the operator of the whole element (extraordinary points, T-junctions).
  pure subroutine extracted(cell, xi, f, df)
    type(cell_t), intent(in) :: cell
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: f(:)     !! (nf)
    real(wp), intent(out) :: df(:, :) !! (2, nf)

    real(wp) :: f1(MAX_DEGREE + 1), f2(MAX_DEGREE + 1), d1(MAX_DEGREE + 1), d2(MAX_DEGREE + 1)
    integer :: i, j, b, n1, n2

    n1 = cell%degree(1) + 1
    n2 = cell%degree(2) + 1
    call bernstein(n1 - 1, xi(1), f1(:n1), d1(:n1))
    call bernstein(n2 - 1, xi(2), f2(:n2), d2(:n2))
    f = 0.0_wp
    df = 0.0_wp
    b = 0
    do j = 1, n2
      do i = 1, n1
        b = b + 1
        f = f + cell%c(:, b)*(f1(i)*f2(j))
        df(1, :) = df(1, :) + cell%c(:, b)*(d1(i)*f2(j))
        df(2, :) = df(2, :) + cell%c(:, b)*(f1(i)*d2(j))
      end do
    end do
  end subroutine extracted

  !> Find the functions of a surface that are not zero on its edges xi-, xi+, eta-, eta+.
  pure subroutine surface_touches(cell, on)
    type(cell_t), intent(in) :: cell
    logical, intent(out) :: on(:, :) !! (nf, 4)

    logical :: marks(product(cell%degree + 1), 6)
    integer :: a, n1, nb

    n1 = cell%degree(1) + 1
    nb = n1*(cell%degree(2) + 1)
    if (allocated(cell%c)) then
      do a = 1, size(on, 1)
        on(a, 1) = lives(cell%c(a, 1:nb:n1))
        on(a, 2) = lives(cell%c(a, n1:nb:n1))
        on(a, 3) = lives(cell%c(a, :n1))
        on(a, 4) = lives(cell%c(a, nb - n1 + 1:nb))
      end do
      return
    end if
    marks = tensor_marks(cell)
    on = marks(:nb, :4)
  end subroutine surface_touches

  !> Set the faces of an element whose face zeta- is the isogeometric surface.
  subroutine layer_faces(cell, upper, topology)
    type(cell_t), intent(in) :: cell
    logical, intent(in) :: upper(:, :) !! (other nodes, 6) faces on which the other nodes lie
    type(topology_t), intent(inout) :: topology

    logical, allocatable :: on(:, :)
    integer :: ncp

    ncp = surface_count(cell)
    allocate (on(ncp + size(upper, 1), 6), source=.false.)
    call surface_touches(cell, on(:ncp, :4))
    on(:ncp, 5) = .true.
    on(ncp + 1:, :) = upper
    call join_faces(on, topology)
    topology%vtk = VTK_BEZIER_HEXAHEDRON
  end subroutine layer_faces

  !> Is a function nonzero on an edge? Its coefficients for the Bernstein polynomials of the edge
  !! are c.
  pure logical function lives(c)
    real(wp), intent(in) :: c(:)

    lives = any(abs(c) > NOTHING)
  end function lives

end module surface_shape
