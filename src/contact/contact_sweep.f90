!> Finds points of contact that pass through the other surface within a step, wherever they end: on
!! the far side of the body, or beside it. At the end of the step such points are outside the body
!! or opposite nothing, and no projection shows that they have been inside.
!!
!! The motion of each surface is described by the rigid motion that fits it best, plus a remainder
!! that grows linearly in the step. Straight paths would be wrong, because they would cut through a
!! shaft that turns in its hole. The faces of the other surface are divided into triangles, which
!! are described in a frame that moves with that surface. A point enters the body where its distance
!! from a triangle changes from positive to negative, and leaves it where it changes back.
module contact_sweep
  use base_kinds, only: wp
  use contact_pair, only: contact_t, surface_t
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use screw_motion, only: screw_t, continue_screw, fit_screw, rotate
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: find_sweep

  integer, parameter :: NPOINT = 3        !! points of an element in each of its two directions
  integer, parameter :: NPART = 4         !! parts of a stage in which crossings are sought
  real(wp), parameter :: STAGE = 0.1_wp !! largest rotation in a straight stage of the step [rad]
  integer, parameter :: MOST_STAGES = 40
  integer, parameter :: MOST_CROSSINGS = 16 !! largest number of crossings stored for a point
  !> A point that was inside at the start of the step has passed through if it is now deeper than
  !! TWICE*DEPTh. By default, this is the thickness of the thinner body.
  real(wp), parameter :: TWICE = 2.0_wp
  real(wp), parameter :: ON_EDGE = 1.0e-9_wp

  !> Triangles of a surface at the start of the step and now, and the boxes that they sweep.
  type :: triangles_t
    integer :: n = 0
    real(wp), allocatable :: x(:, :, :, :) !! (3, corner, start or now, n) [L]
    real(wp), allocatable :: low(:, :), high(:, :) !! (3, n) [L]
  end type triangles_t

  !> A passage of a point through a triangle.
  type :: crossing_t
    real(wp) :: t = 0.0_wp                 !! 0: at the start of the step, 1: at its end
    integer :: triangle = 0
    logical :: enters = .false.
  end type crossing_t

contains

  !> Find a point of one side that has passed through the other side to a depth of more than
  !! least_depth; side = 0 if there is none. Self-contact is not examined.
  subroutine find_sweep(contact, x_start, x, depth, side)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x_start(:, :), x(:, :) !! (3, nnode) at the start and now [L]
    real(wp), intent(out) :: depth                 !! depth of the point along its path [L]
    integer, intent(out) :: side                   !! side to which the point belongs
    type(screw_t) :: screw(2)
    integer :: k

    side = 0
    depth = 0.0_wp
    if (contact%self) return
    do k = 1, 2
      associate (node => contact%side(k)%node)
        call fit_screw(x_start(:, node), x(:, node), screw(k))
      end associate
    end do
    do k = 1, 2
      call sweep_points(contact, k, screw(k), screw(3 - k), x_start, x, depth)
      if (.not. depth > 0.0_wp) cycle
      side = k
      return
    end do
  end subroutine find_sweep

  !> Positions of the nodes of a surface at the fraction s of the step, relative to a frame that
  !! follows the screw motion `frame` from the start of the step.
  subroutine place(surface, screw, frame, s, x_start, x, y)
    type(surface_t), intent(in) :: surface
    type(screw_t), intent(in) :: screw, frame  !! motions of the surface and of the frame
    real(wp), intent(in) :: s
    real(wp), intent(in) :: x_start(:, :), x(:, :)
    real(wp), intent(inout) :: y(:, :)         !! (3, nnode) positions; those of other nodes stay
    real(wp) :: rest(3), back(3)
    integer :: i

    do i = 1, size(surface%node)
      associate (n => surface%node(i))
        back = continue_screw(screw, -1.0_wp, x(:, n))
        rest = rotate(screw%w, x_start(:, n) - back)
        rest = continue_screw(screw, s - 1.0_wp, x(:, n)) &
               + (1.0_wp - s)*rotate((s - 1.0_wp)*screw%w, rest)
        y(:, n) = continue_screw(frame, -s, rest)
      end associate
    end do
  end subroutine place

  !> Depth beyond which a point has passed through: DEPTh or half the thickness of the thinner body,
  !! whichever is less [L].
  pure real(wp) function least_depth(contact) result(depth)
    type(contact_t), intent(in) :: contact
    integer :: k

    depth = contact%depth
    do k = 1, 2
      if (contact%side(k)%thickness > 0.0_wp) depth = min(depth, 0.5_wp*contact%side(k)%thickness)
    end do
  end function least_depth

  !> Find a point of side k that passes through the other side.
  subroutine sweep_points(contact, k, screw, frame, x_start, x, depth)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(screw_t), intent(in) :: screw, frame !! motions of side k and of the other side
    real(wp), intent(in) :: x_start(:, :), x(:, :)
    real(wp), intent(out) :: depth            !! depth of the point that is found; 0: none
    type(triangles_t) :: other
    type(shape_t), allocatable :: shape(:)    ! shapes of side k at the ends of the stages
    type(shape_t) :: far_shape(2)             ! the other side at the start and now
    type(grid_t) :: grid(2)
    type(crossing_t) :: crossing(MOST_CROSSINGS)
    real(wp), allocatable :: y(:, :)          ! positions in the frame [L]
    real(wp), allocatable :: p(:, :), n(:, :) ! path of a point, and its normal along the path
    real(wp) :: a(3, 2), b(3, 3), low(3), high(3)
    integer, allocatable :: near(:)           ! triangles that the points of an element may cross
    integer :: e, i, m, q, ncrossing

    depth = 0.0_wp
    m = min(MOST_STAGES, 1 + int((norm2(screw%w) + norm2(frame%w))/STAGE))
    allocate (y, source=x_start)
    call place(contact%side(3 - k), frame, frame, 1.0_wp, x_start, x, y)
    call place(contact%side(k), screw, frame, 1.0_wp, x_start, x, y)
    if (.not. (maxval(abs(y(:, contact%side(k)%node) - x_start(:, contact%side(k)%node))) &
               + maxval(abs(y(:, contact%side(3 - k)%node) &
                            - x_start(:, contact%side(3 - k)%node))))*sqrt(3.0_wp) &
        > least_depth(contact)) return
    call divide(contact%side(3 - k), x_start, y, other)
    low = minval(other%low, 2)
    high = maxval(other%high, 2)
    allocate (shape(0:m), p(3, 0:m), n(3, 0:m))
    associate (own => contact%side(k), opposite => contact%side(3 - k))
      call update_shape(opposite, x_start, far_shape(1))
      call update_shape(opposite, y, far_shape(2))
      do i = 1, 2
        call update_grid(opposite, far_shape(i), grid(i))
      end do
      do i = 0, m
        call place(own, screw, frame, real(i, wp)/m, x_start, x, y)
        call update_shape(own, y, shape(i))
      end do
      do i = 1, m ! the boxes of the first shape contain the others
        shape(0)%low = min(shape(0)%low, shape(i)%low)
        shape(0)%high = max(shape(0)%high, shape(i)%high)
      end do
      do e = 1, own%nelem
        if (any(shape(0)%low(:, e) > high) .or. any(shape(0)%high(:, e) < low)) cycle
        near = pack([(i, i=1, other%n)], is_near(other, shape(0)%low(:, e), shape(0)%high(:, e)))
        do q = 0, NPOINT**2 - 1
          do i = 0, m
            call surface_point(own, shape(i), e, (2*[mod(q, NPOINT), q/NPOINT] + 1) &
                               /real(NPOINT, wp) - 1.0_wp, p(:, i), a, b)
            n(:, i) = cross(a(:, 1), a(:, 2))
          end do
          call find_crossings(other, near, p, crossing, ncrossing)
          call measure_depth(contact, opposite, far_shape, grid, other, p, n, &
                             crossing(:ncrossing), depth)
          if (depth > least_depth(contact)) return
          depth = 0.0_wp
        end do
      end do
    end associate
  end subroutine sweep_points

  !> The depth to which a point enters the other side without contact acting on it [L]; 0 if it
  !! stays outside, or if contact pushes it back at the end of the step.
  subroutine measure_depth(contact, opposite, shape, grid, other, p, n, crossing, depth)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: opposite
    type(shape_t), intent(in) :: shape(2)     !! shapes of the other side at the start and now
    type(grid_t), intent(in) :: grid(2)
    type(triangles_t), intent(in) :: other
    real(wp), intent(in) :: p(:, 0:), n(:, 0:) !! (3, 0:m) path of the point, and its normal
    type(crossing_t), intent(in) :: crossing(:) !! crossings in chronological order
    real(wp), intent(out) :: depth
    type(foot_t) :: foot, start
    real(wp) :: out(3)
    integer :: first, last, m

    depth = 0.0_wp
    m = ubound(p, 2)
    last = size(crossing)
    first = first_entry(other, n, crossing)
    if (first > 0) then
      depth = depth_of_way(other, p, crossing(first:))
      if (depth > least_depth(contact) .and. crossing(last)%enters) then
        call find_foot(opposite, shape(2), grid(2), p(:, m), contact%depth, foot)
        if (is_pushed(foot, normal(other, crossing(first)%triangle, 1.0_wp))) depth = 0.0_wp
      end if
      return
    end if
    ! the point may be inside from the start
    call find_foot(opposite, shape(1), grid(1), p(:, 0), contact%depth, foot)
    if (.not. is_pushed(foot, -n(:, 0))) return
    start = foot
    call find_foot(opposite, shape(2), grid(2), p(:, m), huge(depth), foot)
    out = foot%n
    if (last > 0) out = normal(other, crossing(last)%triangle, 1.0_wp)
    if ((last > 0 .or. foot%elem > 0) .and. dot_product(start%n, out) < 0.0_wp) then
      depth = -dot_product(p(:, m) - start%x, start%n)
    else if (foot%elem > 0 .and. foot%gap < -TWICE*contact%depth) then
      depth = -foot%gap
    end if
  end subroutine measure_depth

  !> Mark the triangles whose boxes overlap a given box.
  pure function is_near(other, low, high) result(near)
    type(triangles_t), intent(in) :: other
    real(wp), intent(in) :: low(3), high(3)
    logical :: near(other%n)
    integer :: d

    near = .true.
    do d = 1, 3
      near = near .and. other%low(d, :) <= high(d) .and. other%high(d, :) >= low(d)
    end do
  end function is_near

  !> Project a point onto a surface. A point deeper below the surface than `deepest` has no
  !! projection.
  subroutine find_foot(surface, shape, grid, x, deepest, foot)
    type(surface_t), intent(in) :: surface
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(3), deepest     !! [L]
    type(foot_t), intent(out) :: foot

    foot%elem = 0
    call project(surface, shape, grid, x, foot)
    if (.not. touches(foot, deepest)) foot%elem = 0
  end subroutine find_foot

  !> Is a point inside the body, and does contact push it out on the side to which a normal points?
  pure logical function is_pushed(foot, normal) result(yes)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: normal(3)

    yes = foot%elem > 0
    if (yes) yes = foot%gap <= 0.0_wp .and. dot_product(foot%n, normal) > 0.0_wp
  end function is_pushed

  !> Divide the elements of a surface into triangles. Elements of higher degree are divided into
  !! more triangles.
  subroutine divide(surface, x_start, x, mesh)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: x_start(:, :), x(:, :)
    type(triangles_t), intent(out) :: mesh
    type(shape_t) :: shape
    real(wp), allocatable :: grid(:, :, :)     ! (3, 0:m, 0:m)
    real(wp) :: a(3, 2), b(3, 3)
    integer :: e, i, j, m, n, time

    mesh%n = 2*sum([(parts(surface, e)**2, e=1, surface%nelem)])
    allocate (mesh%x(3, 3, 2, mesh%n))
    do time = 1, 2
      if (time == 1) call update_shape(surface, x_start, shape)
      if (time == 2) call update_shape(surface, x, shape)
      n = 0
      do e = 1, surface%nelem
        m = parts(surface, e)
        allocate (grid(3, 0:m, 0:m))
        do j = 0, m
          do i = 0, m
            call surface_point(surface, shape, e, 2*[i, j]/real(m, wp) - 1.0_wp, grid(:, i, j), &
                               a, b)
          end do
        end do
        do j = 1, m
          do i = 1, m
            mesh%x(:, 1, time, n + 1) = grid(:, i - 1, j - 1)
            mesh%x(:, 2, time, n + 1) = grid(:, i, j - 1)
            mesh%x(:, 3, time, n + 1) = grid(:, i, j)
            mesh%x(:, 1, time, n + 2) = grid(:, i - 1, j - 1)
            mesh%x(:, 2, time, n + 2) = grid(:, i, j)
            mesh%x(:, 3, time, n + 2) = grid(:, i - 1, j)
            n = n + 2
          end do
        end do
        deallocate (grid)
      end do
    end do
    mesh%low = minval(minval(mesh%x, 3), 2)
    mesh%high = maxval(maxval(mesh%x, 3), 2)
  end subroutine divide

  !> Number of parts of an element in each direction.
  pure integer function parts(surface, e)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    parts = min(maxval(surface%basis(surface%ibasis(e))%degree), 3)
  end function parts

  !> Find the crossings of a point with the triangles, in chronological order.
  subroutine find_crossings(other, near, p, crossing, ncrossing)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: near(:)            !! triangles to examine
    real(wp), intent(in) :: p(:, 0:)          !! (3, 0:m) path of the point
    type(crossing_t), intent(out) :: crossing(MOST_CROSSINGS)
    integer, intent(out) :: ncrossing
    type(crossing_t) :: new
    real(wp) :: low(3), high(3), t(0:NPART*(size(p, 2) - 1)), h(0:NPART*(size(p, 2) - 1))
    integer :: i, j, m

    ncrossing = 0
    low = minval(p, 2)
    high = maxval(p, 2)
    do m = 1, size(near)
      j = near(m)
      if (any(other%low(:, j) > high .or. other%high(:, j) < low)) cycle
      do i = 0, ubound(t, 1)
        t(i) = real(i, wp)/ubound(t, 1)
        h(i) = height(other, j, p, t(i))
      end do
      do i = 1, ubound(t, 1)
        if (h(i - 1) < 0.0_wp .eqv. h(i) < 0.0_wp) cycle
        new%t = root(other, j, p, t(i - 1), t(i), h(i - 1), h(i))
        new%triangle = j
        new%enters = h(i) < 0.0_wp
        if (is_over(other, j, p, new%t)) call insert(new, crossing, ncrossing)
      end do
    end do
  end subroutine find_crossings

  !> The first crossing at which a point enters through a face whose normal is opposed to that of
  !! the point; 0: there is none.
  pure integer function first_entry(other, n, crossing) result(first)
    type(triangles_t), intent(in) :: other
    real(wp), intent(in) :: n(:, 0:)          !! (3, 0:m) normal of the point along its path
    type(crossing_t), intent(in) :: crossing(:)

    do first = 1, size(crossing)
      if (.not. crossing(first)%enters) cycle
      associate (t => crossing(first)%t)
        if (dot_product(on_way(n, t), normal(other, crossing(first)%triangle, t)) < 0.0_wp) return
      end associate
    end do
    first = 0
  end function first_entry

  !> Insert a crossing in chronological order, unless the list is full.
  pure subroutine insert(new, list, n)
    type(crossing_t), intent(in) :: new
    type(crossing_t), intent(inout) :: list(:)
    integer, intent(inout) :: n
    integer :: i

    if (n == size(list)) return
    do i = n, 1, -1
      if (list(i)%t <= new%t) exit
      list(i + 1) = list(i)
    end do
    list(i + 1) = new
    n = n + 1
  end subroutine insert

  !> Depth that a point reaches between its entry and its exit, or the end of its path [L]. The
  !! depth is measured from the plane of the triangle through which the point enters. If the point
  !! leaves on the same side of the body, the depth below the plane of the exit is a further bound.
  pure real(wp) function depth_of_way(other, p, crossing) result(depth)
    type(triangles_t), intent(in) :: other
    real(wp), intent(in) :: p(:, 0:)
    type(crossing_t), intent(in) :: crossing(:) !! crossings, of which the first is an entry
    real(wp) :: t, last, d
    integer :: i, out

    last = 1.0_wp
    out = 0
    do i = 2, size(crossing)
      if (crossing(i)%enters) cycle
      out = crossing(i)%triangle
      last = crossing(i)%t
      if (dot_product(normal(other, crossing(1)%triangle, last), normal(other, out, last)) &
          < 0.0_wp) out = 0
      exit
    end do
    depth = 0.0_wp
    do i = 1, NPART*(size(p, 2) - 1)
      t = crossing(1)%t + (last - crossing(1)%t)*i/(NPART*(size(p, 2) - 1))
      d = -height(other, crossing(1)%triangle, p, t)
      if (out > 0) d = min(d, -height(other, out, p, t))
      depth = max(depth, d)
    end do
  end function depth_of_way

  !> Position at time t on a path that consists of straight stages.
  pure function on_way(p, t) result(x)
    real(wp), intent(in) :: p(:, 0:), t
    real(wp) :: x(3), s
    integer :: i, m

    m = ubound(p, 2)
    i = max(0, min(m - 1, int(t*m)))
    s = t*m - i
    x = (1.0_wp - s)*p(:, i) + s*p(:, i + 1)
  end function on_way

  !> Corners of a triangle at time t.
  pure function corners(other, j, t) result(x)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: j
    real(wp), intent(in) :: t
    real(wp) :: x(3, 3)

    x = (1.0_wp - t)*other%x(:, :, 1, j) + t*other%x(:, :, 2, j)
  end function corners

  !> Unit outward normal of a triangle at time t; zero if it has no area.
  pure function normal(other, j, t) result(n)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: j
    real(wp), intent(in) :: t
    real(wp) :: n(3), x(3, 3)

    x = corners(other, j, t)
    n = cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))
    n = n/max(norm2(n), tiny(1.0_wp))
  end function normal

  !> Height of a point above the plane of a triangle at time t [L].
  pure real(wp) function height(other, j, p, t) result(h)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: j
    real(wp), intent(in) :: p(:, 0:), t
    real(wp) :: x(3, 3)

    x = corners(other, j, t)
    h = dot_product(on_way(p, t) - x(:, 1), normal(other, j, t))
  end function height

  !> Time at which the height changes its sign, by the secant method with bisection.
  pure real(wp) function root(other, j, p, t_low, t_high, h_low, h_high) result(t)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: j
    real(wp), intent(in) :: p(:, 0:), t_low, t_high, h_low, h_high
    real(wp) :: a, b, ha, hb, h
    integer :: i

    a = t_low
    b = t_high
    ha = h_low
    hb = h_high
    t = a
    do i = 1, 40
      t = a - ha*(b - a)/(hb - ha)
      if (mod(i, 3) == 0 .or. .not. (t >= a .and. t <= b)) t = 0.5_wp*(a + b)
      h = height(other, j, p, t)
      if (abs(h) <= 1.0e-12_wp*abs(h_high - h_low)) return
      if (h < 0.0_wp .eqv. ha < 0.0_wp) then
        a = t
        ha = h
      else
        b = t
        hb = h
      end if
    end do
  end function root

  !> Does a point that lies in the plane of a triangle at time t lie inside the triangle?
  pure logical function is_over(other, j, p, t) result(yes)
    type(triangles_t), intent(in) :: other
    integer, intent(in) :: j
    real(wp), intent(in) :: p(:, 0:), t
    real(wp) :: x(3, 3), y(3), n(3), part(3)
    integer :: i

    x = corners(other, j, t)
    y = on_way(p, t)
    n = cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))
    do i = 1, 3
      part(i) = dot_product(n, cross(x(:, mod(i, 3) + 1) - y, x(:, mod(i + 1, 3) + 1) - y))
    end do
    yes = dot_product(n, n) > 0.0_wp .and. all(part >= -ON_EDGE*dot_product(n, n))
  end function is_over

end module contact_sweep
