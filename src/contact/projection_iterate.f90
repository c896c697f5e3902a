!> Iterate of a projection: a point of an element with all quantities that Newton's method needs
!! there, and the step from it.
module projection_iterate
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use projection_type, only: shape_t
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: iterate_t, evaluate, find_step, find_active, take_step, take_last_step, is_rounding

  !> Parameters that differ by less than this count as equal.
  real(wp), parameter :: SAME_XI = 1.0e-13_wp
  !> Relative rounding error of a coordinate.
  real(wp), parameter :: ROUNDING = 4.0_wp*epsilon(1.0_wp)
  !> Tangents span no plane if the squared sine of the angle between them is smaller than this.
  real(wp), parameter :: FLAT = 1.0e-12_wp
  !> Newton's step needs a Hessian whose determinant is at least this fraction of the metric's.
  real(wp), parameter :: PROPER = 1.0e-6_wp
  !> Newton's step squares the error if the determinant is at least this fraction of the metric's.
  real(wp), parameter :: WELL = 0.1_wp
  !> Steps shorter than this are not tested, because rounding hides the decrease of the distance.
  real(wp), parameter :: SHORT = 1.0e-4_wp
  integer, parameter :: MOST_HALVINGS = 30
  !> Largest fraction of the distance to a collapsed edge that a step may cover.
  real(wp), parameter :: NEARLY = 0.9_wp

  !> The components have no default values, because setting these would take as long as an
  !! evaluation.
  type :: iterate_t
    integer :: elem
    real(wp) :: xi(2)
    real(wp) :: x(3)              !! position [L]
    real(wp) :: a(3, 2)           !! tangents
    real(wp) :: b(3, 3)           !! second derivatives 11, 22, 12
    real(wp) :: r(3)              !! vector from the iterate to the point [L]
    real(wp) :: f                 !! r.r, to be minimised
    real(wp) :: g(2)              !! r.a, the negative gradient of f/2
    real(wp) :: m(2), m12         !! metric
    real(wp) :: noise             !! square of the rounding error of positions [L^2]
    logical :: regular            !! the tangents span a plane
  end type iterate_t

contains

  !> Evaluate the surface at a point of an element, and the distance to x.
  pure subroutine evaluate(surface, shape, elem, xi, x, iterate)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), x(3)
    type(iterate_t), intent(inout) :: iterate

    iterate%elem = elem
    iterate%xi = xi
    call surface_point(surface, shape, elem, xi, iterate%x, iterate%a, iterate%b)
    iterate%r = x - iterate%x
    iterate%f = dot3(iterate%r, iterate%r)
    iterate%g = [dot3(iterate%r, iterate%a(:, 1)), dot3(iterate%r, iterate%a(:, 2))]
    iterate%m = [dot3(iterate%a(:, 1), iterate%a(:, 1)), dot3(iterate%a(:, 2), iterate%a(:, 2))]
    iterate%m12 = dot3(iterate%a(:, 1), iterate%a(:, 2))
    iterate%regular = iterate%m(1)*iterate%m(2) - iterate%m12**2 &
                      > FLAT*iterate%m(1)*iterate%m(2)
    iterate%noise = (ROUNDING*max(abs(x(1)), abs(x(2)), abs(x(3))))**2
  end subroutine evaluate

  !> Scalar product with a fixed order of summation.
  pure real(wp) function dot3(a, b)
    real(wp), intent(in) :: a(3), b(3)

    dot3 = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
  end function dot3

  !> Is a change d of parameter i no more than rounding?
  pure logical function is_rounding(iterate, i, d)
    type(iterate_t), intent(in) :: iterate
    integer, intent(in) :: i
    real(wp), intent(in) :: d

    is_rounding = abs(d) <= SAME_XI .or. d*d*iterate%m(i) <= iterate%noise
  end function is_rounding

  !> Find the active bounds, which are the edges on which the iterate lies and beyond which the
  !! distance would decrease further.
  pure subroutine find_active(iterate, edge, push)
    type(iterate_t), intent(in) :: iterate
    integer, intent(out) :: edge(2)     !! active bound of each parameter; 0: none
    real(wp), intent(out) :: push(2)    !! how far the distance would decrease, as a change of
    !! the parameter
    integer :: i

    edge = 0
    push = 0.0_wp
    do i = 1, 2
      if (abs(iterate%xi(i)) < 1.0_wp .or. .not. iterate%g(i)*iterate%xi(i) > 0.0_wp) cycle
      push(i) = abs(iterate%g(i))/iterate%m(i)
      if (is_rounding(iterate, i, push(i))) cycle
      edge(i) = merge(2*i, 2*i - 1, iterate%xi(i) > 0.0_wp)
    end do
  end subroutine find_active

  !> Find Newton's step for the parameters that are not held fixed, or a Gauss-Newton step if the
  !! Hessian is not positive definite. From an edge, the step never leads out of the element.
  pure subroutine find_step(iterate, held, d, definite, squares)
    type(iterate_t), intent(in) :: iterate
    logical, intent(in) :: held(2)
    real(wp), intent(out) :: d(2)
    logical, intent(out) :: definite     !! the Hessian is positive definite
    logical, intent(out) :: squares      !! the step squares the error
    real(wp) :: h(2), h12, det, area
    integer :: i, j

    h(1) = iterate%m(1) - dot3(iterate%r, iterate%b(:, 1))
    h(2) = iterate%m(2) - dot3(iterate%r, iterate%b(:, 2))
    h12 = iterate%m12 - dot3(iterate%r, iterate%b(:, 3))
    squares = .false.
    definite = .true.
    if (any(held)) then
      do i = 1, 2
        d(i) = 0.0_wp
        if (.not. held(i)) call step_alone(h(i), iterate%m(i), iterate%g(i), d(i), definite)
      end do
      return
    end if
    det = h(1)*h(2) - h12*h12
    area = iterate%m(1)*iterate%m(2) - iterate%m12**2
    definite = h(1) > PROPER*iterate%m(1) .and. det > PROPER*area
    squares = h(1) > WELL*iterate%m(1) .and. det > WELL*area
    if (.not. definite) then
      h = iterate%m
      h12 = iterate%m12
      det = area
    end if
    d = [h(2)*iterate%g(1) - h12*iterate%g(2), h(1)*iterate%g(2) - h12*iterate%g(1)]/det
    do i = 1, 2
      if (abs(iterate%xi(i)) < 1.0_wp .or. .not. iterate%xi(i)*d(i) > 0.0_wp) cycle
      ! If the step leaves the element, move only the other parameter; if the other parameter does
      ! not move either, move this one inwards.
      squares = .false.
      j = 3 - i
      d(i) = 0.0_wp
      call step_alone(h(j), iterate%m(j), iterate%g(j), d(j), definite)
      if (abs(iterate%xi(j)) >= 1.0_wp .and. iterate%xi(j)*d(j) > 0.0_wp) d(j) = 0.0_wp
      if (.not. is_rounding(iterate, j, d(j))) return
      d(j) = 0.0_wp
      d(i) = iterate%g(i)/iterate%m(i)
      if (iterate%xi(i)*d(i) > 0.0_wp) d(i) = 0.0_wp
      return
    end do
  end subroutine find_step

  !> Find the step of one parameter while the other one is held fixed.
  pure subroutine step_alone(h, m, g, d, definite)
    real(wp), intent(in) :: h, m, g
    real(wp), intent(out) :: d
    logical, intent(inout) :: definite

    definite = definite .and. h > PROPER*m
    d = g/merge(h, m, h > PROPER*m)
  end subroutine step_alone

  !> Take a step up to the first edge, and halve it until the distance decreases.
  pure subroutine take_step(surface, shape, x, d, iterate, ok)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    real(wp), intent(in) :: x(3), d(2)
    type(iterate_t), intent(inout) :: iterate
    logical, intent(out) :: ok
    real(wp) :: fraction, f, xi(2), from(2), step(2)
    integer :: i, halving, meets

    fraction = 1.0_wp
    meets = 0
    from = iterate%xi
    f = iterate%f
    step = d
    where (abs(from) >= 1.0_wp .and. from*d > 0.0_wp) step = 0.0_wp ! only rounding
    do i = 1, 2
      if ((from(i) + fraction*step(i))*sign(1.0_wp, step(i)) < 1.0_wp) cycle ! ends before the edge
      if (.not. abs(step(i)) > 0.0_wp) cycle
      fraction = min(fraction, max(0.0_wp, (sign(1.0_wp, step(i)) - from(i))/step(i)))
      meets = i
    end do
    if (meets > 0 .and. allocated(surface%point)) then
      i = merge(2*meets - 1, 2*meets, d(meets) < 0.0_wp)
      if (surface%point(i, iterate%elem)) then ! a tangent vanishes at a collapsed edge
        fraction = NEARLY*fraction
        meets = 0
      end if
    end if
    do halving = 1, MOST_HALVINGS
      xi = from + fraction*step
      if (meets > 0) xi(meets) = sign(1.0_wp, step(meets))
      xi = max(-1.0_wp, min(1.0_wp, xi))
      call evaluate(surface, shape, iterate%elem, xi, x, iterate)
      ok = iterate%f < f .or. fraction*maxval(abs(step)) < SHORT
      if (ok) return
      meets = 0
      fraction = 0.5_wp*fraction
    end do
  end subroutine take_step

  !> Take a step so short that a Taylor series is exact up to rounding.
  pure subroutine take_last_step(x, d, iterate)
    real(wp), intent(in) :: x(3), d(2)
    type(iterate_t), intent(inout) :: iterate

    associate (a => iterate%a, b => iterate%b)
      iterate%xi = iterate%xi + d
      iterate%x = iterate%x + d(1)*(a(:, 1) + 0.5_wp*d(1)*b(:, 1) + d(2)*b(:, 3)) &
                  + d(2)*(a(:, 2) + 0.5_wp*d(2)*b(:, 2))
      a(:, 1) = a(:, 1) + d(1)*b(:, 1) + d(2)*b(:, 3)
      a(:, 2) = a(:, 2) + d(1)*b(:, 3) + d(2)*b(:, 2)
      iterate%r = x - iterate%x
      iterate%f = dot3(iterate%r, iterate%r)
    end associate
  end subroutine take_last_step

end module projection_iterate
