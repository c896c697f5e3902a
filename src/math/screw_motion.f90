!> Rigid motions in space: find the one that best fits the motion of a set of points, and continue
!! it.
!!
!! A rigid motion x -> R (x - c0) + c1 consists of a rotation by the vector w and a translation. If
!! the rate of the motion is constant, a fraction s of it rotates by s w. With y = x - c1, the same
!! motion continues from the points x as
!!
!!   y -> R(w) y + V(w) v,   R = exp([w]),   V = int_0^1 exp([s w]) ds,
!!
!! so that a fraction s of the motion is described by (s w, s v).
module screw_motion
  use base_kinds, only: wp
  use lapack, only: dsyev
  use tensor, only: cross
  implicit none
  private
  public :: screw_t, fit_screw, continue_screw, rotate

  !> Below this angle, the first terms of series replace the formulas, because the next term is
  !! below rounding.
  real(wp), parameter :: SMALL_ANGLE = 1.0e-4_wp

  type :: screw_t
    real(wp) :: origin(3) = 0.0_wp !! c1 [L]
    real(wp) :: w(3) = 0.0_wp      !! rotation vector [rad]
    real(wp) :: v(3) = 0.0_wp      !! velocity at the origin times the duration of the motion [L]
  end type screw_t

contains

  !> Find the rigid motion that moves the points `from` as near as possible to the points `to` in
  !! the sense of least squares. The quaternion of the rotation is an eigenvector of a 4 x 4 matrix
  !! (Horn 1987).
  subroutine fit_screw(from, to, screw)
    real(wp), intent(in) :: from(:, :), to(:, :) !! (3, n), n > 0 [L]
    type(screw_t), intent(out) :: screw
    real(wp) :: c0(3), c1(3), d(3), s(3, 3), k(4, 4), q(4), w(3), angle, value(4), work(64), f
    integer :: i, info

    c0 = sum(from, 2)/size(from, 2)
    c1 = sum(to, 2)/size(to, 2)
    s = 0.0_wp
    do i = 1, size(from, 2)
      d = to(:, i) - c1
      s(:, 1) = s(:, 1) + (from(1, i) - c0(1))*d
      s(:, 2) = s(:, 2) + (from(2, i) - c0(2))*d
      s(:, 3) = s(:, 3) + (from(3, i) - c0(3))*d
    end do
    k(1, 1) = s(1, 1) + s(2, 2) + s(3, 3)
    k(2:, 1) = [s(3, 2) - s(2, 3), s(1, 3) - s(3, 1), s(2, 1) - s(1, 2)]
    k(2:, 2:) = s + transpose(s)
    do i = 2, 4
      k(i, i) = k(i, i) - k(1, 1)
    end do
    call dsyev('V', 'L', 4, k, 4, value, work, size(work), info)
    screw%origin = c1
    screw%v = c1 - c0
    if (info /= 0) return
    q = sign(1.0_wp, k(1, 4))*k(:, 4)
    angle = 2.0_wp*atan2(norm2(q(2:)), q(1))
    if (.not. angle > 0.0_wp) return
    w = angle*q(2:)/norm2(q(2:))
    screw%w = w
    ! V(w)^-1 d = d - w x d/2 + f w x (w x d)
    f = 1.0_wp/12.0_wp
    if (angle > SMALL_ANGLE) f = (1.0_wp - 0.5_wp*angle*sin(angle)/(1.0_wp - cos(angle)))/angle**2
    d = rotate(w, c1 - c0)
    c0 = cross(w, d)
    screw%v = d - 0.5_wp*c0 + f*cross(w, c0)
  end subroutine fit_screw

  !> The position of the point x after the motion has been continued by a fraction s of itself.
  pure function continue_screw(screw, s, x) result(y)
    type(screw_t), intent(in) :: screw
    real(wp), intent(in) :: s, x(3)
    real(wp) :: y(3), w(3), v(3), c(3), angle, f, g

    w = s*screw%w
    v = s*screw%v
    angle = norm2(w)
    f = 0.5_wp
    g = 1.0_wp/6.0_wp
    if (angle > SMALL_ANGLE) then
      f = (1.0_wp - cos(angle))/angle**2
      g = (angle - sin(angle))/angle**3
    end if
    c = cross(w, v)
    y = screw%origin + rotate(w, x - screw%origin) + v + f*c + g*cross(w, c)
  end function continue_screw

  !> The vector a, rotated by the rotation vector w (Rodrigues' formula).
  pure function rotate(w, a) result(b)
    real(wp), intent(in) :: w(3), a(3)
    real(wp) :: b(3), c(3), angle, f, g

    angle = norm2(w)
    f = 1.0_wp
    g = 0.5_wp
    if (angle > SMALL_ANGLE) then
      f = sin(angle)/angle
      g = (1.0_wp - cos(angle))/angle**2
    end if
    c = cross(w, a)
    b = a + f*c + g*cross(w, c)
  end function rotate

end module screw_motion
