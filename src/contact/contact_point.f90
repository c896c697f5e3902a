!> Traction at one point of a surface and its derivatives, from the laws and the kinematics of the
!! projection.
!!
!! The point x belongs to side k; its projection x_p = x_l(xi_p) and its sliding point x_s =
!! x_l(xi_s) belong to side l. The independent variations are those of x, of x_p at fixed xi_p, of
!! the tangents of l at xi_p, and of x_s at fixed xi_s; the variation of xi_p follows from (x -
!! x_p).a_alpha = 0 and is eliminated here. If the projection lies on an interior edge that is a
!! ridge, only the parameter along the edge varies; at a vertex, no parameter varies.
module contact_point
  use base_kinds, only: wp
  use contact_pair, only: assigned_law_t, contact_t
  use contact_type, only: OPEN, TOUCH, SLIP, MU, TANGENTIAL_PENALTY
  use projection_type, only: foot_t
  use smooth_step, only: smoothstep
  implicit none
  private
  public :: point_t, traction_derivatives_t, vary_projection, vary_normal, traction_at, &
            add_friction, secant_of_friction, inverse, outer, energy_at_rest

  !> A distance that is smaller than this, relative to the tangents, has no meaningful direction.
  real(wp), parameter :: NO_DIRECTION = 1.0e-12_wp

  !> Kinematics and tractions of a point.
  type :: point_t
    real(wp) :: x(3) = 0.0_wp          !! position [L]
    logical :: slides = .false.        !! friction acts, and there is a stored sliding point
    real(wp) :: xs(3) = 0.0_wp         !! position of the sliding point [L]
    real(wp) :: ahead = -1.0_wp        !! [L] see friction_law_i
    real(wp) :: no_slip = -1.0_wp      !! [L] see add_friction; negative: surfaces do not just touch
    real(wp) :: multiplier = 0.0_wp    !! multiplier of the augmentation [F/L^2]
    real(wp) :: full = -1.0_wp         !! [L] depth from which the pressure decreases; negative: it
    !! never does
    real(wp) :: last = 0.0_wp          !! [L] depth beyond which no pressure acts, > 2*full
    integer :: state = OPEN
    real(wp) :: n(3) = 0.0_wp          !! normal of the other side, if in contact
    real(wp) :: p = 0.0_wp             !! pressure [F/L^2]
    real(wp) :: energy = 0.0_wp        !! energy of the pressure up to this gap [F/L]
    real(wp) :: rest = 0.0_wp          !! energy due to the multiplier at a gap of zero [F/L]
    real(wp) :: t(3) = 0.0_wp          !! traction on side k [F/L^2]
    real(wp) :: friction(3) = 0.0_wp   !! part of t that is friction [F/L^2]
    real(wp) :: elastic(3) = 0.0_wp    !! [L] see friction_law_i
    real(wp) :: slip = 0.0_wp  !! [L] length of the slipped part of the tangential displacement
  end type point_t

  !> Derivatives of a vector with respect to the independent variations.
  type :: traction_derivatives_t
    real(wp) :: x(3, 3) = 0.0_wp       !! derivative with respect to x
    real(wp) :: p(3, 3) = 0.0_wp       !! derivative with respect to x_p at fixed xi_p
    real(wp) :: a(3, 3, 2) = 0.0_wp    !! derivative with respect to the tangents of l there
    real(wp) :: s(3, 3) = 0.0_wp       !! derivative with respect to x_s at fixed xi_s
  end type traction_derivatives_t

contains

  !> Find the traction given by the normal law and the friction law, and its derivatives.
  pure subroutine traction_at(contact, foot, secant, point, dt)
    type(contact_t), intent(in) :: contact
    type(foot_t), intent(in) :: foot
    logical, intent(in) :: secant    !! see add_friction
    type(point_t), intent(inout) :: point
    type(traction_derivatives_t), intent(out) :: dt
    type(traction_derivatives_t) :: dn
    real(wp) :: n(3), dp, dpdx(3)

    point%t = 0.0_wp
    point%friction = 0.0_wp
    point%elastic = 0.0_wp
    point%slip = 0.0_wp
    point%state = OPEN
    point%rest = energy_at_rest(contact%normal, point%multiplier)
    call press(contact, foot%gap, point, dp)
    if (.not. point%energy > 0.0_wp) return
    point%state = TOUCH
    call vary_normal(foot, point%x, n, dn)
    point%n = n
    dpdx = dp*n                        ! the gap varies with n.(dx - dx_p)
    point%t = point%p*n
    dt%x = outer(n, dpdx) + point%p*dn%x
    dt%p = -outer(n, dpdx) + point%p*dn%p
    dt%a = point%p*dn%a
    if (point%slides .and. point%p > 0.0_wp) then
      call add_friction(contact, dn, dpdx, secant, point, dt)
    end if
  end subroutine traction_at

  !> Add the frictional traction at a point in contact, and its derivatives.
  !!
  !! Where surfaces just touch, there is no pressure yet, and hence no friction, or rounding alone
  !! decides whether there is any. As long as such a point has not slipped by more than
  !! point%no_slip, it has the stiffness of a point that sticks, because it will stick under the
  !! first loads unless they push it along the surface. If it had no stiffness, the first increment
  !! could let all points slip, from where Newton's iteration does not always return.
  pure subroutine add_friction(contact, dn, dpdx, secant, point, dt)
    type(contact_t), intent(in) :: contact
    type(traction_derivatives_t), intent(in) :: dn !! derivatives of the normal point%n
    real(wp), intent(in) :: dpdx(3)  !! dp/dx, which is the opposite of dp/dx_p
    logical, intent(in) :: secant    !! use the secant of the law where it slips
    type(point_t), intent(inout) :: point
    type(traction_derivatives_t), intent(inout) :: dt
    real(wp) :: y(3), d(3), yn, t(3), dtdd(3, 3), dtdp(3), project(3, 3), dddn(3, 3)
    integer :: i

    associate (n => point%n)
      y = point%x - point%xs             ! friction: d = (I - n n)(x - x_s)
      yn = dot_product(y, n)
      d = y - yn*n
      call contact%friction%law%friction(contact%friction%prop, d, point%p, point%ahead, t, dtdd, &
                                         dtdp, point%elastic, point%state)
      if (secant .and. point%state == SLIP) call secant_of_friction(d, t, dtdd, dtdp)
      if (norm2(d) <= point%no_slip) call begin_to_stick(contact%friction%prop, dtdd, dtdp)
      point%slip = max(0.0_wp, norm2(d) - norm2(point%elastic))
      if (.not. point%p > 0.0_wp) then ! the surfaces just touch
        point%state = OPEN
        point%slip = 0.0_wp
      end if
      point%friction = t
      point%t = point%t + t
      project = -outer(n, n)
      dddn = -outer(n, y)
      do i = 1, 3
        project(i, i) = project(i, i) + 1.0_wp
        dddn(i, i) = dddn(i, i) - yn
      end do
      project = matmul(dtdd, project)
      dddn = matmul(dtdd, dddn)
      dt%x = dt%x + project + matmul(dddn, dn%x) + outer(dtdp, dpdx)
      dt%p = dt%p + matmul(dddn, dn%p) - outer(dtdp, dpdx)
      do i = 1, 2
        dt%a(:, :, i) = dt%a(:, :, i) + matmul(dddn, dn%a(:, :, i))
      end do
      dt%s = -project
    end associate
  end subroutine add_friction

  !> Derivatives of the frictional traction of a point that sticks, if there is friction at all.
  pure subroutine begin_to_stick(prop, dtdd, dtdp)
    real(wp), intent(in) :: prop(:)        !! constants of the friction law
    real(wp), intent(inout) :: dtdd(3, 3), dtdp(3)
    integer :: i

    if (.not. prop(MU) > 0.0_wp) return
    dtdp = 0.0_wp
    dtdd = 0.0_wp
    do i = 1, 3
      dtdd(i, i) = -prop(TANGENTIAL_PENALTY)
    end do
  end subroutine begin_to_stick

  !> Secant of a frictional traction, -(|t|/|d|) I with the identity I. In contrast to the tangent,
  !! it has a stiffness along the slip and does not vary with the pressure.
  pure subroutine secant_of_friction(d, t, dtdd, dtdp)
    real(wp), intent(in) :: d(3), t(3)     !! [L], [F/L^2]
    real(wp), intent(out) :: dtdd(3, 3), dtdp(3)
    integer :: i

    dtdp = 0.0_wp
    dtdd = 0.0_wp
    if (.not. norm2(d) > 0.0_wp) return
    do i = 1, 3
      dtdd(i, i) = -norm2(t)/norm2(d)
    end do
  end subroutine secant_of_friction

  !> Find the pressure of the normal law. A point deeper than `full` is not pushed out through the
  !! face: its pressure decreases to zero between `full` and twice that depth. From there to `last`
  !! its energy decreases to zero, so that the pressure is negative.
  pure subroutine press(contact, gap, point, dp)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: gap            !! [L]
    type(point_t), intent(inout) :: point
    real(wp), intent(out) :: dp            !! [F/L^3]
    real(wp) :: z, w, y, rest

    z = -1.0_wp
    if (point%full > 0.0_wp) z = -gap/point%full - 1.0_wp
    call contact%normal%law%normal(contact%normal%prop, merge(-point%full, gap, z > 0.0_wp), &
                                   point%multiplier, point%p, dp, point%energy)
    if (.not. z > 0.0_wp) return
    w = point%p*point%full
    if (z < 1.0_wp) then
      dp = point%p*6*z*(1.0_wp - z)/point%full
      point%p = point%p*(1.0_wp - smoothstep(z))
      point%energy = point%energy + w*z*(1.0_wp - z*z*(1.0_wp - 0.5_wp*z))
    else
      w = point%energy + 0.5_wp*w
      rest = point%last - 2*point%full
      y = min((z - 1.0_wp)*point%full/rest, 1.0_wp)
      dp = w*6*(1.0_wp - 2*y)/rest**2
      point%p = -w*6*y*(1.0_wp - y)/rest
      point%energy = w*(1.0_wp - smoothstep(y))
    end if
  end subroutine press

  !> Energy of the pressure at a gap of zero, due to the multiplier. The energy of a contact
  !! excludes this part, so that it is zero where augmentation has closed the gap.
  pure real(wp) function energy_at_rest(normal, multiplier) result(energy)
    type(assigned_law_t), intent(in) :: normal
    real(wp), intent(in) :: multiplier     !! [F/L^2]
    real(wp) :: p, dp

    energy = 0.0_wp
    if (.not. multiplier > 0.0_wp) return
    call normal%law%normal(normal%prop, 0.0_wp, multiplier, p, dp, energy)
  end function energy_at_rest

  !> Find the unit normal at the projection and its derivatives.
  pure subroutine vary_normal(foot, x, n, dn)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: x(3)       !! the point
    real(wp), intent(out) :: n(3)
    type(traction_derivatives_t), intent(out) :: dn
    real(wp) :: g(3), h(3, 2), up(3, 2), c(2, 2), curvature(2, 2)
    integer :: i, j

    n = foot%n
    call vary_projection(foot, x, h, c, g)
    if (all(foot%free)) then
      up = matmul(foot%a, inverse(matmul(transpose(foot%a), foot%a), foot%free))
      curvature(1, 1) = dot_product(n, foot%b(:, 1))
      curvature(2, 2) = dot_product(n, foot%b(:, 2))
      curvature(1, 2) = dot_product(n, foot%b(:, 3))
      curvature(2, 1) = curvature(1, 2)
      h = matmul(up, matmul(curvature, c))
      dn%x = -matmul(h, transpose(foot%a))
      dn%p = -dn%x
      do j = 1, 2
        dn%a(:, :, j) = -outer(up(:, j), n) - outer(h(:, j), g)
      end do
    else if (abs(foot%gap) > NO_DIRECTION*maxval(abs(foot%a))) then
      n = g/foot%gap  ! direction of the distance, in the cone of the normals of the elements
      dn%x = -matmul(h, transpose(foot%a))
      do i = 1, 3
        dn%x(i, i) = dn%x(i, i) + 1.0_wp
      end do
      dn%x = (dn%x - outer(n, n))/foot%gap
      dn%p = -dn%x
      do j = 1, 2
        dn%a(:, :, j) = -outer(h(:, j), g)/foot%gap
      end do
    end if
  end subroutine vary_normal

  !> Find the variation of the parameters of the projection: dxi_a = h_a.(dx - dx_p) + sum_b c_ab
  !! g.da_b, where c is the inverse of the second derivative of half the squared distance.
  pure subroutine vary_projection(foot, x, h, c, g)
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: x(3)           !! the point
    real(wp), intent(out) :: h(3, 2)       !! [1/L]
    real(wp), intent(out) :: c(2, 2)       !! [1/L^2]
    real(wp), intent(out) :: g(3)          !! vector from the projection to the point [L]
    real(wp) :: metric(2, 2), hess(2, 2)

    g = x - foot%x
    metric = matmul(transpose(foot%a), foot%a)
    hess(1, 1) = metric(1, 1) - dot_product(g, foot%b(:, 1))
    hess(2, 2) = metric(2, 2) - dot_product(g, foot%b(:, 2))
    hess(1, 2) = metric(1, 2) - dot_product(g, foot%b(:, 3))
    hess(2, 1) = hess(1, 2)
    c = inverse(hess, foot%free)
    h = matmul(foot%a, c)
  end subroutine vary_projection

  !> Inverse of m in the free directions, zero elsewhere.
  pure function inverse(m, free) result(mi)
    real(wp), intent(in) :: m(2, 2)
    logical, intent(in) :: free(2)
    real(wp) :: mi(2, 2)

    mi = 0.0_wp
    if (all(free)) then
      mi(1, 1) = m(2, 2)
      mi(2, 2) = m(1, 1)
      mi(1, 2) = -m(1, 2)
      mi(2, 1) = -m(2, 1)
      mi = mi/(m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1))
    else if (free(1)) then
      mi(1, 1) = 1.0_wp/m(1, 1)
    else if (free(2)) then
      mi(2, 2) = 1.0_wp/m(2, 2)
    end if
  end function inverse

  !> The matrix a b^T. It is defined here and not in tensor, so that it is inlined in the loops of a
  !! point.
  pure function outer(a, b) result(c)
    real(wp), intent(in) :: a(3), b(3)
    real(wp) :: c(3, 3)
    integer :: j

    do j = 1, 3
      c(:, j) = a*b(j)
    end do
  end function outer

end module contact_point
