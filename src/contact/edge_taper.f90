!> BORDer: near an outer border of the other surface the load of a point fades out, over a share of
!! an element: a point that slides over the border loses nothing at once.
!!
!! With the share s of the foot's parameters and the potential W of the pressure the point has the
!! energy s W on its area, and from it the traction
!!
!!   t = s p n - W grad s,    grad s = sum_a s_,a a^a = v.
!!
!! The second part points outwards, along the surface. Without it a point could come in over the
!! border for nothing and be paid when it leaves through the face.
!! Limits: a^a are those at the foot; off a curved surface grad s differs by gap times curvature.
module edge_taper
  use base_kinds, only: wp
  use projection_type, only: foot_t
  use contact_point, only: point_t, traction_derivatives_t, foot_way, inverse, outer
  implicit none
  private
  public :: fade_border

contains

  !> From the traction of the laws and its derivatives to those of a point near a border.
  pure subroutine fade_border(width, outside, foot, point, dt)
    real(wp), intent(in) :: width          !! relative to the element
    logical, intent(in) :: outside(4)      !! edges of the foot's element that are outer borders
    type(foot_t), intent(in) :: foot
    type(point_t), intent(inout) :: point
    type(traction_derivatives_t), intent(inout) :: dt
    type(traction_derivatives_t) :: dv
    real(wp) :: share, slope(2), curve(2, 2), h(3, 2), c(2, 2), g(3), v(3), s(3), n(3)
    integer :: j

    call border_share(width, outside, foot%xi, share, slope, curve)
    if (.not. share < 1.0_wp) return
    call foot_way(foot, point%x, h, c, g)
    call vary_gradient(foot, slope, curve, h, c, g, v, dv)
    s = matmul(h, slope)
    n = point%n
    dt%x = share*dt%x + outer(point%t, s) + point%p*outer(v, n) - point%energy*dv%x
    dt%p = share*dt%p - outer(point%t, s) - point%p*outer(v, n) - point%energy*dv%p
    do j = 1, 2
      dt%a(:, :, j) = share*dt%a(:, :, j) + outer(point%t, dot_product(c(:, j), slope)*g) &
                      - point%energy*dv%a(:, :, j)
    end do
    dt%s = share*dt%s
    point%p = share*point%p
    point%t = share*point%t - point%energy*v
    point%friction = share*point%friction
  end subroutine fade_border

  !> v = sum_a s_,a a^a and how it varies. With the metric M, w = M^-1 s_,xi and v = A w
  !!
  !!   dv = sum_j (w_j (1 - sum_a a^a a_a) - a^j v) . da_j + sum_ab a^a s_,ab dxi_b.
  pure subroutine vary_gradient(foot, slope, curve, h, c, g, v, dv)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: slope(2), curve(2, 2)      !! s_,a and s_,ab
    real(wp), intent(in) :: h(3, 2), c(2, 2), g(3)     !! as of foot_way
    real(wp), intent(out) :: v(3)                      !! [1/L]
    type(traction_derivatives_t), intent(out) :: dv
    real(wp) :: metric(2, 2), w(2), up(3, 2), with(3, 2), across(3, 3)
    integer :: i, j

    metric = inverse(matmul(transpose(foot%a), foot%a), foot%free)
    up = matmul(foot%a, metric)
    w = matmul(metric, slope)
    v = matmul(foot%a, w)
    across = -matmul(up, transpose(foot%a))
    do i = 1, 3
      across(i, i) = across(i, i) + 1.0_wp
    end do
    do j = 1, 2
      dv%a(:, :, j) = w(j)*across - outer(up(:, j), v)
    end do
    with(:, 1) = matmul(dv%a(:, :, 1), foot%b(:, 1)) + matmul(dv%a(:, :, 2), foot%b(:, 3))
    with(:, 2) = matmul(dv%a(:, :, 1), foot%b(:, 3)) + matmul(dv%a(:, :, 2), foot%b(:, 2))
    with = with + matmul(up, curve)                    ! dv = with . dxi, the nodes at rest
    dv%x = matmul(with, transpose(h))
    dv%p = -dv%x
    do j = 1, 2
      dv%a(:, :, j) = dv%a(:, :, j) + outer(matmul(with, c(:, j)), g)
    end do
  end subroutine vary_gradient

  !> 1 inside, 0 on a border, and its derivatives by the parameters.
  pure subroutine border_share(width, outside, xi, share, slope, curve)
    real(wp), intent(in) :: width, xi(2)
    logical, intent(in) :: outside(4)      !! edges xi-, xi+, eta-, eta+
    real(wp), intent(out) :: share, slope(2), curve(2, 2)
    real(wp) :: f(2), df(2), d2f(2), s, ds, d2s, z
    integer :: i, j, k

    f = 1.0_wp
    df = 0.0_wp
    d2f = 0.0_wp
    do k = 1, 4
      i = (k + 1)/2
      j = merge(-1, 1, mod(k, 2) == 1)     ! of the way out
      z = max(0.0_wp, 0.5_wp*(1.0_wp - j*xi(i))/width)
      if (.not. outside(k) .or. z >= 1.0_wp) cycle
      s = z*z*(3.0_wp - 2*z)
      ds = -j*3*z*(1.0_wp - z)/width
      d2s = 1.5_wp*(1.0_wp - 2*z)/width**2
      d2f(i) = s*d2f(i) + 2*ds*df(i) + d2s*f(i)
      df(i) = s*df(i) + ds*f(i)
      f(i) = s*f(i)
    end do
    share = f(1)*f(2)
    slope = [df(1)*f(2), f(1)*df(2)]
    curve(:, 1) = [d2f(1)*f(2), df(1)*df(2)]
    curve(:, 2) = [df(1)*df(2), f(1)*d2f(2)]
  end subroutine border_share

end module edge_taper
