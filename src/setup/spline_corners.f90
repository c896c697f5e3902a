!> Corners of surface elements that are one point: files of extracted splines do not say which.
!!
!! Two corners are the same point where the same functions have the same values.
module spline_corners
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index, hash
  use spline_surface, only: spline_surface_t
  implicit none
  private
  public :: number_corners, corner_point

  real(wp), parameter :: NOTHING = 1.0e-12_wp !! a function that vanishes at the corner
  real(wp), parameter :: ALIKE = 1.0e-9_wp    !! values are shares of one

  !> Functions that live at a corner, in the order of their control points, and their values.
  type :: corner_t
    integer :: n = 0
    integer, allocatable :: node(:)
    real(wp), allocatable :: value(:)
  end type corner_t

contains

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

end module spline_corners
