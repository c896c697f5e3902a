!> Edge taper (BORDer): near the outer boundary of the other surface, the load of a point decreases
!! to zero over a fraction of an element, so that a point that slides across the boundary does not
!! lose its load suddenly.
!!
!! With the pressure p, its potential W, the normal n and the taper s(xi) at the projection, the
!! energy of the point is s W per area, from which the traction t follows:
!!
!!   t = s p n - W grad s,    grad s = sum_a s_,a a^a = v.
!!
!! The second part points outwards along the surface. Without it, a point could enter across the
!! boundary without doing work, and gain energy when it leaves through the face.
!!
!! Limits: the tangents a^a are taken at the projection; above a curved surface, the relative error
!!         of grad s is about the gap times the curvature.
module edge_taper
  use base_kinds, only: wp
  use contact_point, only: point_t, traction_derivatives_t, vary_projection, inverse, outer
  use projection_type, only: foot_t
  use smooth_step, only: smoothstep
  implicit none
  private
  public :: taper_edge

contains

  !> At a point near the outer boundary, replace the traction of the laws with t, and update its
  !! derivatives. With A = [a_1 a_2], the metric M = A^T A, w = M^-1 s_,xi and v = A w,
  !!
  !!   dv = sum_j (w_j (I - sum_a a^a a_a) - a^j v) . da_j + sum_ab a^a s_,ab dxi_b.
  pure subroutine taper_edge(width, outside, foot, point, dt)
    real(wp), intent(in) :: width          !! width relative to the element
    logical, intent(in) :: outside(4)      !! edges xi-, xi+, eta-, eta+ on the outer boundary
    type(foot_t), intent(in) :: foot
    type(point_t), intent(inout) :: point
    type(traction_derivatives_t), intent(inout) :: dt
    type(traction_derivatives_t) :: dv
    real(wp) :: s, ds(2), d2s(2, 2), h(3, 2), c(2, 2), g(3), v(3), dsdx(3), n(3)
    real(wp) :: metric(2, 2), w(2), up(3, 2), dvdxi(3, 2), across(3, 3)
    integer :: i, j

    call find_taper(width, outside, foot%xi, s, ds, d2s)
    if (.not. s < 1.0_wp) return
    call vary_projection(foot, point%x, h, c, g)
    metric = inverse(matmul(transpose(foot%a), foot%a), foot%free)
    up = matmul(foot%a, metric)
    w = matmul(metric, ds)
    v = matmul(foot%a, w)
    across = -matmul(up, transpose(foot%a))
    do i = 1, 3
      across(i, i) = across(i, i) + 1.0_wp
    end do
    do j = 1, 2
      dv%a(:, :, j) = w(j)*across - outer(up(:, j), v)
    end do
    dvdxi(:, 1) = matmul(dv%a(:, :, 1), foot%b(:, 1)) + matmul(dv%a(:, :, 2), foot%b(:, 3))
    dvdxi(:, 2) = matmul(dv%a(:, :, 1), foot%b(:, 3)) + matmul(dv%a(:, :, 2), foot%b(:, 2))
    dvdxi = dvdxi + matmul(up, d2s)
    dv%x = matmul(dvdxi, transpose(h))
    dv%p = -dv%x
    do j = 1, 2
      dv%a(:, :, j) = dv%a(:, :, j) + outer(matmul(dvdxi, c(:, j)), g)
    end do

    dsdx = matmul(h, ds)
    n = point%n
    dt%x = s*dt%x + outer(point%t, dsdx) + point%p*outer(v, n) - point%energy*dv%x
    dt%p = s*dt%p - outer(point%t, dsdx) - point%p*outer(v, n) - point%energy*dv%p
    do j = 1, 2
      dt%a(:, :, j) = s*dt%a(:, :, j) + outer(point%t, dot_product(c(:, j), ds)*g) &
                      - point%energy*dv%a(:, :, j)
    end do
    dt%s = s*dt%s
    point%p = s*point%p
    point%t = s*point%t - point%energy*v
    point%friction = s*point%friction
    point%energy = s*point%energy
  end subroutine taper_edge

  !> Find the taper, which is 1 inside and 0 on the outer boundary, and its derivatives with respect
  !! to the parameters.
  pure subroutine find_taper(width, outside, xi, s, ds, d2s)
    real(wp), intent(in) :: width, xi(2)
    logical, intent(in) :: outside(4)
    real(wp), intent(out) :: s, ds(2), d2s(2, 2)
    real(wp) :: f(2), df(2), d2f(2), e, de, d2e, z
    integer :: i, j, k

    f = 1.0_wp
    df = 0.0_wp
    d2f = 0.0_wp
    do k = 1, 4
      i = (k + 1)/2
      j = merge(-1, 1, mod(k, 2) == 1)     ! sign of the outward direction
      z = max(0.0_wp, 0.5_wp*(1.0_wp - j*xi(i))/width)
      if (.not. outside(k) .or. z >= 1.0_wp) cycle
      e = smoothstep(z)
      de = -j*3*z*(1.0_wp - z)/width
      d2e = 1.5_wp*(1.0_wp - 2*z)/width**2
      d2f(i) = e*d2f(i) + 2*de*df(i) + d2e*f(i)
      df(i) = e*df(i) + de*f(i)
      f(i) = e*f(i)
    end do
    s = f(1)*f(2)
    ds = [df(1)*f(2), f(1)*df(2)]
    d2s(:, 1) = [d2f(1)*f(2), df(1)*df(2)]
    d2s(:, 2) = [df(1)*df(2), f(1)*d2f(2)]
  end subroutine find_taper

end module edge_taper
