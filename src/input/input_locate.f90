!> Finds the element that contains a reference point, and the parent coordinates of the point.
!!
!! Tetrahedra, wedges, pyramids and prisms of enriched layers are collapsed cubes, and patches of
!! splines may have sides of length zero. Their maps are singular at some edges or corners, where
!! Newton's method fails. The closest point of each element is therefore found by the method of
!! Levenberg and Marquardt within the cube; the point lies in the element whose distance is zero.
module input_locate
  use base_kinds, only: wp
  use element_type, only: cell_t
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use tensor, only: det3, inv3
  implicit none
  private
  public :: locate_point, is_within

  integer, parameter :: MAX_ITER = 100
  real(wp), parameter :: OUTSIDE = 1.0e-6_wp !! a point this far outside an element, relative to the
  !! size of the element, still counts as inside
  real(wp), parameter :: EXACT = 1.0e-12_wp  !! a distance that is due to rounding, relative to the
  !! size of the element
  real(wp), parameter :: WIDER = 0.5_wp      !! margin of the box around an element's nodes relative
  !! to its size, because a curved element may extend beyond its nodes
  real(wp), parameter :: FLAT = 1.0e-6_wp    !! a map is nearly singular where its determinant is
  !! smaller than this, relative to that in the middle of the element
  real(wp), parameter :: RETREAT = 1.0e-7_wp !! distance by which such points are moved towards the
  !! middle, in parent coordinates; the errors of stresses due to rounding and to the motion are
  !! then similar
  real(wp), parameter :: DAMPING(2) = [1.0e-12_wp, 1.0e8_wp] !! least and largest damping
  real(wp), parameter :: ASIDE = 0.6_wp      !! parent coordinates of further starting points

contains

  !> Find the element that contains a reference point; `block` is 0 if there is none. If elements
  !! share the point, the first one is taken. Where the map of the element is singular, `xi` is a
  !! point beside it, so that derivatives of the functions exist.
  subroutine locate_point(mesh, body, x, block, elem, xi)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body     !! index of a body; 0: the whole mesh without rigid bodies
    real(wp), intent(in) :: x(3)    !! [L]
    integer, intent(out) :: block, elem
    real(wp), intent(out) :: xi(3)  !! parent coordinates
    real(wp), allocatable :: xe(:, :)
    real(wp) :: at(3), away, extent, high(3), least, low(3), margin, start(3)
    integer :: b, e, s

    block = 0
    elem = 0
    xi = 0.0_wp
    do s = 0, 8 ! strongly curved elements may need another start than the middle
      start = 0.0_wp
      if (s > 0) start = ASIDE*[merge(1, -1, btest(s, 0)), merge(1, -1, btest(s, 1)), &
                                merge(1, -1, btest(s, 2))]
      least = huge(1.0_wp)
      do b = 1, size(mesh%block)
        if (body > 0 .and. mesh%block(b)%body /= body) cycle
        if (body == 0 .and. is_rigid(mesh%block(b))) cycle
        do e = 1, mesh%block(b)%nelem
          xe = mesh%xr(:, mesh%block(b)%conn(:, e))
          low = minval(xe, 2)
          high = maxval(xe, 2)
          extent = maxval(high - low)
          margin = WIDER*extent + rounding_of(x)
          if (any(x < low - margin) .or. any(x > high + margin)) cycle
          at = start
          call find_closest(mesh%block(b), e, xe, x, EXACT*extent + rounding_of(x), at, away)
          if (away > OUTSIDE*extent + rounding_of(x) .or. away >= least) cycle
          least = away
          block = b
          elem = e
          xi = at
          if (away <= EXACT*extent + rounding_of(x)) exit
        end do
        if (e <= mesh%block(b)%nelem) exit
      end do
      if (block > 0) exit
    end do
    if (block > 0) call leave_singular(mesh, block, elem, xi)
  end subroutine locate_point

  !> Does a reference point lie in an element, where all parent coordinates are at most `most`?
  logical function is_within(mesh, b, e, x, most)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b, e     !! block and element
    real(wp), intent(in) :: x(3)    !! [L]
    real(wp), intent(in) :: most
    real(wp) :: xe(3, mesh%block(b)%nen), away, extent, xi(3)

    xe = mesh%xr(:, mesh%block(b)%conn(:, e))
    extent = maxval(maxval(xe, 2) - minval(xe, 2))
    xi = 0.0_wp
    call find_closest(mesh%block(b), e, xe, x, EXACT*extent + rounding_of(x), xi, away)
    is_within = away <= OUTSIDE*extent + rounding_of(x) .and. all(abs(xi) <= most)
  end function is_within

  !> Rounding error of the difference between a point and a nearby node.
  pure real(wp) function rounding_of(x)
    real(wp), intent(in) :: x(3)    !! [L]

    rounding_of = 4.0_wp*epsilon(1.0_wp)*maxval(abs(x))
  end function rounding_of

  !> Find the parent coordinates in [-1,1]^3 whose point is closest to x. A coordinate stays on the
  !! border of the cube as long as the distance would decrease only beyond it. Positions are taken
  !! relative to the first node, so that the error does not grow with the distance of the element
  !! from the origin.
  subroutine find_closest(block, e, xe, x, exact_at, xi, away)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    real(wp), intent(in) :: xe(:, :), x(3) !! (3, nen) nodes, point [L]
    real(wp), intent(in) :: exact_at       !! distance that is due to rounding [L]
    real(wp), intent(inout) :: xi(3)       !! in: start
    real(wp), intent(out) :: away          !! distance from x [L]
    type(cell_t) :: cell
    real(wp) :: a(3, 3), damping_now, det, g(3), inverse(3, 3), jac(3, 3), new(3), r(3)
    real(wp) :: node(3, block%nen), trial_jac(3, 3), trial_r(3)
    integer :: it, i

    call block_cell(block, e, cell)
    node = xe - spread(xe(:, 1), 2, block%nen)
    damping_now = DAMPING(1)
    call evaluate(xi, r, jac)
    do it = 1, MAX_ITER
      g = matmul(r, jac)
      a = matmul(transpose(jac), jac)
      do i = 1, 3
        if ((xi(i) <= -1.0_wp .and. g(i) < 0.0_wp) .or. (xi(i) >= 1.0_wp .and. g(i) > 0.0_wp) &
            .or. .not. a(i, i) > 0.0_wp) then
          g(i) = 0.0_wp
          a(i, :) = 0.0_wp
          a(:, i) = 0.0_wp
          a(i, i) = 1.0_wp
        end if
        a(i, i) = a(i, i)*(1.0_wp + damping_now)
      end do
      call solve(a, g)
      new = max(-1.0_wp, min(1.0_wp, xi + g))
      call evaluate(new, trial_r, trial_jac)
      if (norm2(trial_r) < norm2(r)) then
        g = new - xi
        xi = new
        r = trial_r
        jac = trial_jac
        damping_now = max(DAMPING(1), 0.01_wp*damping_now)
        if (maxval(abs(g)) < EXACT) exit
      else
        if (norm2(r) <= exact_at) exit ! rounding decides
        damping_now = 100.0_wp*damping_now
        if (damping_now > DAMPING(2)) exit
      end if
    end do
    away = norm2(r)

  contains

    !> Vector from the point of the element to x, and derivatives of the point.
    subroutine evaluate(at, r, jac)
      real(wp), intent(in) :: at(3)
      real(wp), intent(out) :: r(3), jac(3, 3)
      real(wp) :: shp(block%nen), dshp(3, block%nen)

      call block%row%functions(cell, at, shp, dshp)
      jac = matmul(node, transpose(dshp))
      r = (x - xe(:, 1)) - matmul(node, shp)
    end subroutine evaluate

    !> Solve a d = g; d = 0 if a is singular, so that the trial fails and the damping increases.
    !! The matrix is scaled to a diagonal of ones, because the derivatives of thin or nearly
    !! collapsed elements differ by many powers of ten.
    subroutine solve(a, g)
      real(wp), intent(in) :: a(3, 3)
      real(wp), intent(inout) :: g(3)
      real(wp) :: s(3)

      s = [(1.0_wp/sqrt(a(i, i)), i=1, 3)]
      call inv3(a*spread(s, 2, 3)*spread(s, 1, 3), inverse, det)
      g = s*matmul(inverse, s*g)
    end subroutine solve

  end subroutine find_closest

  !> Move a point at which the map of its element is nearly singular towards the middle. Enhanced
  !! strains grow without bound towards a collapsed edge or corner, since they are divided by the
  !! determinant of the map. In an element that has one, a point is moved towards the middle until
  !! the determinant is at least the smallest one at an integration point.
  subroutine leave_singular(mesh, block, elem, xi)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: block, elem
    real(wp), intent(inout) :: xi(3)
    real(wp) :: flat_below, least, kept, lost
    logical :: bounded                     !! no strain grows without bound
    integer :: i, q

    flat_below = FLAT*abs(determinant(spread(0.0_wp, 1, 3)))
    bounded = mesh%block(block)%row%nmode == 0
    if (.not. bounded) bounded = .not. is_collapsed()
    if (.not. bounded) then
      associate (rule => mesh%block(block)%rule)
        least = minval([(abs(determinant(rule%xi(:, q))), q=1, rule%nq)])
      end associate
      if (abs(determinant(xi)) >= least) return
      kept = 0.0_wp
      lost = 1.0_wp
      do i = 1, digits(1.0_wp) ! bisection
        associate (middle => 0.5_wp*(kept + lost))
          if (abs(determinant(middle*xi)) >= least) then
            kept = middle
          else
            lost = middle
          end if
        end associate
      end do
      xi = kept*xi
    else if (.not. abs(determinant(xi)) > flat_below) then
      xi = (1.0_wp - RETREAT)*xi
    end if

  contains

    !> Is the map singular at a corner?
    logical function is_collapsed()
      integer :: i
      real(wp) :: corner(3)

      is_collapsed = .false.
      do i = 0, 7
        corner = [merge(1, -1, btest(i, 0)), merge(1, -1, btest(i, 1)), merge(1, -1, btest(i, 2))]
        if (.not. abs(determinant(corner)) > flat_below) is_collapsed = .true.
      end do
    end function is_collapsed

    real(wp) function determinant(at)
      real(wp), intent(in) :: at(3)
      type(cell_t) :: cell
      real(wp) :: shp(mesh%block(block)%nen), dshp(3, mesh%block(block)%nen)

      associate (b => mesh%block(block))
        call block_cell(b, elem, cell)
        call b%row%functions(cell, at, shp, dshp)
        determinant = det3(matmul(mesh%xr(:, b%conn(:, elem)), transpose(dshp)))
      end associate
    end function determinant

  end subroutine leave_singular

end module input_locate
