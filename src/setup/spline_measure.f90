!> Sizes of a spline surface by integration: which side is out, and how thick the body behind is.
module spline_measure
  use base_kinds, only: wp
  use element_type, only: cell_t
  use quadrature, only: gauss_quad
  use spline_surface, only: spline_surface_t
  use surface_shape, only: surface_functions
  use tensor, only: cross
  implicit none
  private
  public :: surface_measures, surface_at, spline_thickness

  integer, parameter :: MORE = 6 !! Gauss points beyond the degree: surfaces may be rational
  integer, parameter :: MOST_SAMPLES = 3000
  real(wp), parameter :: OPPOSITE = -0.5_wp, STRAIGHT = 0.8_wp !! cosines

contains

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

end module spline_measure
