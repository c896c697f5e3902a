!> A point of a surface that may be the closest one: what is known there, and the next step.
module projection_iterate
  use base_kinds, only: wp
  use projection_type, only: shape_t
  use contact_pair, only: surface_t
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: iterate_t, look_at, find_step, find_push, move_spot, shift_spot, is_rounding

  !> Parameters that differ by less are the same.
  real(wp), parameter :: SAME_XI = 1.0e-13_wp
  !> Share of a coordinate that is rounding.
  real(wp), parameter :: ROUNDING = 4.0_wp*epsilon(1.0_wp)
  !> Squared sine between tangents that span no plane.
  real(wp), parameter :: FLAT = 1.0e-12_wp
  !> Share of the metric's determinant that the Hessian's needs for Newton's step.
  real(wp), parameter :: PROPER = 1.0e-6_wp
  !> Such a share lets Newton's step square the error.
  real(wp), parameter :: WELL = 0.1_wp
  !> Steps this short are taken without a test: the distance does not tell any more.
  real(wp), parameter :: SHORT = 1.0e-4_wp
  integer, parameter :: MOST_HALVINGS = 30
  !> Share of the way to an edge that is a point which a step may go.
  real(wp), parameter :: NEARLY = 0.9_wp

  !> Without initial values: they would cost as much as an evaluation.
  type :: iterate_t
    integer :: elem
    real(wp) :: xi(2)
    real(wp) :: x(3)              !! position [L]
    real(wp) :: a(3, 2)
    real(wp) :: b(3, 3)
    real(wp) :: r(3)              !! from here to the point [L]
    real(wp) :: f                 !! r.r
    real(wp) :: g(2)              !! r.a: descent
    real(wp) :: m(2), m12         !! metric
    real(wp) :: noise             !! square of the rounding of positions [L^2]
    logical :: regular            !! the tangents span a plane
  end type iterate_t

contains

  !> Evaluate the surface at a point of an element, seen from x.
  pure subroutine look_at(surface, shape, elem, xi, x, spot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), x(3)
    type(iterate_t), intent(inout) :: spot

    spot%elem = elem
    spot%xi = xi
    call surface_point(surface, shape, elem, xi, spot%x, spot%a, spot%b)
    spot%r = x - spot%x
    spot%f = dot3(spot%r, spot%r)
    spot%g = [dot3(spot%r, spot%a(:, 1)), dot3(spot%r, spot%a(:, 2))]
    spot%m = [dot3(spot%a(:, 1), spot%a(:, 1)), dot3(spot%a(:, 2), spot%a(:, 2))]
    spot%m12 = dot3(spot%a(:, 1), spot%a(:, 2))
    spot%regular = spot%m(1)*spot%m(2) - spot%m12**2 > FLAT*spot%m(1)*spot%m(2)
    spot%noise = (ROUNDING*max(abs(x(1)), abs(x(2)), abs(x(3))))**2
  end subroutine look_at

  pure real(wp) function dot3(a, b)
    real(wp), intent(in) :: a(3), b(3)

    dot3 = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
  end function dot3

  !> Is a step of parameter i no more than rounding?
  pure logical function is_rounding(spot, i, d)
    type(iterate_t), intent(in) :: spot
    integer, intent(in) :: i
    real(wp), intent(in) :: d

    is_rounding = abs(d) <= SAME_XI .or. d*d*spot%m(i) <= spot%noise
  end function is_rounding

  !> Edges that the spot stands on and over which the distance falls; 0: none. Also how far, in
  !! parameters.
  pure subroutine find_push(spot, edge, push)
    type(iterate_t), intent(in) :: spot
    integer, intent(out) :: edge(2)
    real(wp), intent(out) :: push(2)
    integer :: i

    edge = 0
    push = 0.0_wp
    do i = 1, 2
      if (abs(spot%xi(i)) < 1.0_wp .or. .not. spot%g(i)*spot%xi(i) > 0.0_wp) cycle
      push(i) = abs(spot%g(i))/spot%m(i)
      if (is_rounding(spot, i, push(i))) cycle
      edge(i) = merge(2*i, 2*i - 1, spot%xi(i) > 0.0_wp)
    end do
  end subroutine find_push

  !> Newton's step for the parameters that are not held, Gauss and Newton's where the Hessian is not
  !! definite. It never leads out of the element from a border.
  pure subroutine find_step(spot, held, d, definite, squares)
    type(iterate_t), intent(in) :: spot
    logical, intent(in) :: held(2)
    real(wp), intent(out) :: d(2)
    logical, intent(out) :: definite
    logical, intent(out) :: squares      !! the step squares the error
    real(wp) :: h(2), h12, det, area
    integer :: i, j

    h(1) = spot%m(1) - dot3(spot%r, spot%b(:, 1))
    h(2) = spot%m(2) - dot3(spot%r, spot%b(:, 2))
    h12 = spot%m12 - dot3(spot%r, spot%b(:, 3))
    squares = .false.
    definite = .true.
    if (any(held)) then
      do i = 1, 2
        d(i) = 0.0_wp
        if (.not. held(i)) call step_alone(h(i), spot%m(i), spot%g(i), d(i), definite)
      end do
      return
    end if
    det = h(1)*h(2) - h12*h12
    area = spot%m(1)*spot%m(2) - spot%m12**2
    definite = h(1) > PROPER*spot%m(1) .and. det > PROPER*area
    squares = h(1) > WELL*spot%m(1) .and. det > WELL*area
    if (.not. definite) then
      h = spot%m
      h12 = spot%m12
      det = area
    end if
    d = [h(2)*spot%g(1) - h12*spot%g(2), h(1)*spot%g(2) - h12*spot%g(1)]/det
    do i = 1, 2
      if (abs(spot%xi(i)) < 1.0_wp .or. .not. spot%xi(i)*d(i) > 0.0_wp) cycle
      squares = .false.
      j = 3 - i
      d(i) = 0.0_wp ! the other one alone, and if that rests, this one inwards
      call step_alone(h(j), spot%m(j), spot%g(j), d(j), definite)
      if (abs(spot%xi(j)) >= 1.0_wp .and. spot%xi(j)*d(j) > 0.0_wp) d(j) = 0.0_wp
      if (.not. is_rounding(spot, j, d(j))) return
      d(j) = 0.0_wp
      d(i) = spot%g(i)/spot%m(i)
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
    type(iterate_t), intent(inout) :: spot
    logical, intent(out) :: ok
    real(wp) :: share, f, xi(2), from(2), way(2)
    integer :: i, halving, meets

    share = 1.0_wp
    meets = 0
    from = spot%xi
    f = spot%f
    way = d
    where (abs(from) >= 1.0_wp .and. from*d > 0.0_wp) way = 0.0_wp ! rounding stops nothing
    do i = 1, 2
      if ((from(i) + share*way(i))*sign(1.0_wp, way(i)) < 1.0_wp) cycle ! of the border ahead
      if (.not. abs(way(i)) > 0.0_wp) cycle
      share = min(share, max(0.0_wp, (sign(1.0_wp, way(i)) - from(i))/way(i)))
      meets = i
    end do
    if (meets > 0 .and. allocated(surface%point)) then
      if (surface%point(edge_ahead(meets, d), spot%elem)) then ! tangents vanish there
        share = NEARLY*share
        meets = 0
      end if
    end if
    do halving = 1, MOST_HALVINGS
      xi = from + share*way
      if (meets > 0) xi(meets) = sign(1.0_wp, way(meets))
      xi = max(-1.0_wp, min(1.0_wp, xi))
      call look_at(surface, shape, spot%elem, xi, x, spot)
      ok = spot%f < f .or. share*maxval(abs(way)) < SHORT
      if (ok) return
      meets = 0
      share = 0.5_wp*share
    end do
  end subroutine move_spot

  !> The edge that a step of parameter i meets.
  pure integer function edge_ahead(i, d)
    integer, intent(in) :: i
    real(wp), intent(in) :: d(2)

    edge_ahead = merge(2*i - 1, 2*i, d(i) < 0.0_wp)
  end function edge_ahead

  !> Take a step so short that a Taylor series is exact to rounding.
  pure subroutine shift_spot(x, d, spot)
    real(wp), intent(in) :: x(3), d(2)
    type(iterate_t), intent(inout) :: spot

    spot%xi = spot%xi + d
    spot%x = spot%x + d(1)*(spot%a(:, 1) + 0.5_wp*d(1)*spot%b(:, 1) + d(2)*spot%b(:, 3)) &
             + d(2)*(spot%a(:, 2) + 0.5_wp*d(2)*spot%b(:, 2))
    spot%a(:, 1) = spot%a(:, 1) + d(1)*spot%b(:, 1) + d(2)*spot%b(:, 3)
    spot%a(:, 2) = spot%a(:, 2) + d(1)*spot%b(:, 3) + d(2)*spot%b(:, 2)
    spot%r = x - spot%x
    spot%f = dot3(spot%r, spot%r)
  end subroutine shift_spot

end module projection_iterate
