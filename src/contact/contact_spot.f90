!> A point of a surface as a candidate for the closest point: what is known there, and the next step.
module contact_spot
  use base_kinds, only: wp
  use contact_foot, only: shape_t
  use contact_pair, only: surface_t
  use contact_shape, only: surface_point
  implicit none
  private
  public :: spot_t, look_at, find_step, find_push, move_spot

  !> Parameters that differ by less are the same.
  real(wp), parameter :: SAME_XI = 1.0e-13_wp
  !> Squared sine between tangents that span no plane.
  real(wp), parameter :: FLAT = 1.0e-12_wp
  !> Share of the metric's determinant that the Hessian's needs for Newton's step.
  real(wp), parameter :: PROPER = 1.0e-6_wp
  !> Steps this short are taken without a test: the distance does not tell any more.
  real(wp), parameter :: SHORT = 1.0e-4_wp
  integer, parameter :: MOST_HALVINGS = 30

  type :: spot_t
    integer :: elem = 0
    real(wp) :: xi(2) = 0.0_wp
    real(wp) :: x(3) = 0.0_wp         !! position [L]
    real(wp) :: a(3, 2) = 0.0_wp
    real(wp) :: b(3, 3) = 0.0_wp
    real(wp) :: r(3) = 0.0_wp         !! from here to the point [L]
    real(wp) :: f = huge(1.0_wp)      !! r.r
    real(wp) :: g(2) = 0.0_wp         !! r.a: descent
    real(wp) :: m11 = 0.0_wp, m22 = 0.0_wp, m12 = 0.0_wp !! metric
    real(wp) :: rounding(2) = SAME_XI !! parameters are not known better
    logical :: regular = .false.      !! the tangents span a plane
  end type spot_t

contains

  !> Evaluate the surface at a point of an element, seen from x.
  pure subroutine look_at(surface, shape, elem, xi, x, spot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), x(3)
    type(spot_t), intent(inout) :: spot
    real(wp) :: noise

    spot%elem = elem
    spot%xi = xi
    call surface_point(surface, shape, elem, xi, spot%x, spot%a, spot%b)
    spot%r = x - spot%x
    spot%f = dot3(spot%r, spot%r)
    spot%g = [dot3(spot%r, spot%a(:, 1)), dot3(spot%r, spot%a(:, 2))]
    spot%m11 = dot3(spot%a(:, 1), spot%a(:, 1))
    spot%m22 = dot3(spot%a(:, 2), spot%a(:, 2))
    spot%m12 = dot3(spot%a(:, 1), spot%a(:, 2))
    spot%regular = spot%m11*spot%m22 - spot%m12**2 > FLAT*spot%m11*spot%m22
    if (.not. spot%regular) return
    noise = 4.0_wp*epsilon(1.0_wp)*max(abs(x(1)), abs(x(2)), abs(x(3)))
    spot%rounding = max(SAME_XI, noise/sqrt([spot%m11, spot%m22]))
  end subroutine look_at

  pure real(wp) function dot3(a, b)
    real(wp), intent(in) :: a(3), b(3)

    dot3 = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
  end function dot3

  !> How far, in parameters, the distance falls over a border the spot stands on, and which edge
  !! that is; 0: none.
  pure subroutine find_push(spot, edge, push)
    type(spot_t), intent(in) :: spot
    integer, intent(out) :: edge(2)
    real(wp), intent(out) :: push(2)
    integer :: i

    edge = 0
    push = spot%g/[spot%m11, spot%m22]
    do i = 1, 2
      if (spot%xi(i) <= -1.0_wp .and. push(i) < -spot%rounding(i)) then
        edge(i) = 2*i - 1
      else if (spot%xi(i) >= 1.0_wp .and. push(i) > spot%rounding(i)) then
        edge(i) = 2*i
      end if
    end do
    push = abs(push)
  end subroutine find_push

  !> Newton's step for the parameters that are not held, Gauss and Newton's where the Hessian is not
  !! definite. It never leads out of the element from a border.
  pure subroutine find_step(spot, held, d, definite)
    type(spot_t), intent(in) :: spot
    logical, intent(in) :: held(2)
    real(wp), intent(out) :: d(2)
    logical, intent(out) :: definite
    real(wp) :: h11, h22, h12, det
    integer :: i

    h11 = spot%m11 - dot3(spot%r, spot%b(:, 1))
    h22 = spot%m22 - dot3(spot%r, spot%b(:, 2))
    h12 = spot%m12 - dot3(spot%r, spot%b(:, 3))
    if (any(held)) then
      d = 0.0_wp
      definite = .true.
      if (.not. held(1)) call step_alone(h11, spot%m11, spot%g(1), d(1), definite)
      if (.not. held(2)) call step_alone(h22, spot%m22, spot%g(2), d(2), definite)
      return
    end if
    det = h11*h22 - h12*h12
    definite = h11 > PROPER*spot%m11 .and. &
      det > PROPER*(spot%m11*spot%m22 - spot%m12**2)
    if (.not. definite) then
      h11 = spot%m11
      h22 = spot%m22
      h12 = spot%m12
      det = h11*h22 - h12*h12
    end if
    d = [h22*spot%g(1) - h12*spot%g(2), h11*spot%g(2) - h12*spot%g(1)]/det
    do i = 1, 2
      if (abs(spot%xi(i)) < 1.0_wp .or. .not. spot%xi(i)*d(i) > 0.0_wp) cycle
      d(i) = 0.0_wp ! the other one alone, and if that rests, this one inwards
      if (i == 1) call step_alone(h22, spot%m22, spot%g(2), d(2), definite)
      if (i == 2) call step_alone(h11, spot%m11, spot%g(1), d(1), definite)
      if (abs(spot%xi(3 - i)) >= 1.0_wp .and. spot%xi(3 - i)*d(3 - i) > 0.0_wp) d(3 - i) = 0.0_wp
      if (abs(d(3 - i)) > spot%rounding(3 - i)) return
      d(3 - i) = 0.0_wp
      if (i == 1) d(1) = spot%g(1)/spot%m11
      if (i == 2) d(2) = spot%g(2)/spot%m22
      if (spot%xi(i)*d(i) > 0.0_wp) d(i) = 0.0_wp
      return
    end do
  end subroutine find_step

  pure subroutine step_alone(h, m, g, d, definite)
    real(wp), intent(in) :: h, m, g
    real(wp), intent(out) :: d
    logical, intent(inout) :: definite

    definite = definite .and. h > PROPER*m
    d = g/merge(h, m, h > PROPER*m)
  end subroutine step_alone

  !> Take a step, up to the first border, halved until the distance falls.
  pure subroutine move_spot(surface, shape, x, d, spot, ok)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3), d(2)
    type(spot_t), intent(inout) :: spot
    logical, intent(out) :: ok
    real(wp) :: share, f, xi(2), from(2)
    integer :: i, halving, meets

    share = 1.0_wp
    meets = 0
    from = spot%xi
    f = spot%f
    do i = 1, 2
      if (abs(from(i) + share*d(i)) < 1.0_wp) cycle
      if (.not. abs(d(i)) > 0.0_wp) cycle
      share = max(0.0_wp, (sign(1.0_wp, d(i)) - from(i))/d(i))
      meets = i
    end do
    do halving = 1, MOST_HALVINGS
      xi = from + share*d
      if (meets > 0) xi(meets) = sign(1.0_wp, d(meets))
      xi = max(-1.0_wp, min(1.0_wp, xi))
      call look_at(surface, shape, spot%elem, xi, x, spot)
      ok = spot%f < f .or. share*maxval(abs(d)) < SHORT
      if (ok) return
      meets = 0
      share = 0.5_wp*share
    end do
  end subroutine move_spot

end module contact_spot
