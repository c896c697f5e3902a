!> Forces and derivatives of the points of one element with the mortar scheme.
!!
!! A point of element e contributes -N_b w t to the internal force r_b of node b of e, and
!! M_c(xi) w t to that of node c of the element that it faces. Here N and M are the functions of the
!! two elements, w is the weight of the point times own_share, and t is its traction; t and xi vary.
!! For all points of e that face the same element, the derivatives of the forces with respect to the
!! positions x_d of the nodes of both elements are products of matrices, which BLAS computes:
!!
!!   dr_b = -sum N_b (w dt/dx_d),
!!   dr_c =  sum M_c (w dt/dx_d) + sum_a sum (M_c,a t) (w dxi_a/dx_d),   M_c,a = dM_c/dxi_a.
!!
!! Friction also varies with the sliding point, which may belong to another element. The columns of
!! the matrices are the first components of all nodes of e, then the second and the third
!! components, and then the same for the other element.
module mortar_kernel
  use base_kinds, only: wp
  use contact_pair, only: contact_t, surface_t
  use contact_point, only: point_t, traction_derivatives_t, vary_normal, vary_projection, &
                           add_friction, outer
  use contact_type, only: OPEN, TOUCH
  use contact_work, only: work_t, reserve_partners, reserve_crosses, element_functions, own_share
  use lapack, only: dgemm
  use mortar_control, only: GAP_ERROR
  use mortar_type, only: mortar_side_t, kernel_t
  use projection_type, only: foot_t
  implicit none
  private
  public :: form_cells

contains

  !> Find the forces of element e and their derivatives at fixed pressures of the control points.
  pure subroutine form_cells(contact, k, e, x, dt_first, slides, tangent, side, kernel, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) [L]
    real(wp), intent(in) :: dt_first !! length of the step if it begins, otherwise negative [T]
    logical, intent(in) :: slides
    logical, intent(in) :: tangent            !! .false.: forces only
    type(mortar_side_t), intent(inout) :: side
    type(kernel_t), intent(inout) :: kernel
    type(work_t), intent(inout) :: work
    integer :: faced, from, m, n, nk, nl, slot

    associate (own => contact%side(k), other => contact%side(3 - k))
      nk = own%first(e + 1) - own%first(e)
      work%nk = nk
      call list_points(side, e, slides, kernel, work, n, faced)
      if (n == 0) return
      kernel%xe = x(:, own%node(own%first(e):own%first(e + 1) - 1))
      call clear(nk, tangent, work)
      from = 1
      do slot = 1, faced
        m = count(kernel%slot(from:n) == slot)
        nl = other%first(work%partner(slot) + 1) - other%first(work%partner(slot))
        call reserve(nk, nl, m, kernel)
        call form_points(contact, k, slot, from, nk, nl, m, x, dt_first, tangent, side, kernel, &
                         work)
        if (tangent) then
          call add_products(nk, nl, 3*(nk + nl), m, slot, kernel%own, kernel%shp, kernel%slope, &
                            kernel%dt, kernel%dxi, kernel%k, work)
          if (any(kernel%slide_slot(from:from + m - 1) > 0 .and. &
                  kernel%slide_slot(from:from + m - 1) /= slot)) then
            call add_away(contact, k, slot, nk, nl, m, kernel%point(from:from + m - 1), &
                          kernel%slide_slot(from:from + m - 1), side%slide_shp, kernel%own, &
                          kernel%shp, kernel%ds, work)
          end if
        end if
        from = from + m
      end do
    end associate
  end subroutine form_cells

  !> Find the points of element e that are in contact, sorted by the elements that they face. The
  !! first partners are these elements, followed by the elements of the sliding points. The results
  !! of all points are cleared.
  pure subroutine list_points(side, e, slides, kernel, work, n, faced)
    type(mortar_side_t), intent(inout) :: side
    integer, intent(in) :: e
    logical, intent(in) :: slides
    type(kernel_t), intent(inout) :: kernel
    type(work_t), intent(inout) :: work
    integer, intent(out) :: n                  !! number of points
    integer, intent(out) :: faced              !! number of partners that points face
    integer :: list(side%cells%first(e + 1) - side%cells%first(e)), slot(size(list))
    integer :: i, j, s

    n = 0
    do i = side%cells%first(e), side%cells%first(e + 1) - 1
      side%state(i) = OPEN
      side%friction(:, i) = 0.0_wp
      side%elastic(:, i) = 0.0_wp
      side%slip(i) = 0.0_wp
      if (.not. (side%p(i) > 0.0_wp .or. side%dp(i) < 0.0_wp)) cycle
      n = n + 1
      list(n) = i
    end do
    faced = 0
    work%npartner = 0
    work%ncross = 0
    if (n == 0) return
    if (.not. allocated(kernel%point)) allocate (kernel%point(0))
    if (n > size(kernel%point)) then
      kernel%point = list
      kernel%slot = list
      kernel%slide_slot = list
    end if
    do j = 1, n
      call find_slot(side%cells%foot(list(j))%elem, work, slot(j))
    end do
    faced = work%npartner
    i = 0
    do s = 1, faced
      do j = 1, n
        if (slot(j) /= s) cycle
        i = i + 1
        kernel%point(i) = list(j)
        kernel%slot(i) = s
      end do
    end do
    kernel%slide_slot(:n) = 0
    if (.not. slides) return
    do i = 1, n
      j = side%slide(kernel%point(i))
      if (j > 0) call find_slot(j, work, kernel%slide_slot(i))
    end do
  end subroutine list_points

  !> Find the slot of a partner. A partner without a slot is assigned a new one.
  pure subroutine find_slot(partner, work, slot)
    integer, intent(in) :: partner
    type(work_t), intent(inout) :: work
    integer, intent(out) :: slot

    do slot = work%npartner, 1, -1
      if (work%partner(slot) == partner) return
    end do
    slot = work%npartner + 1
    call reserve_partners(slot, work)
    work%npartner = slot
    work%partner(slot) = partner
  end subroutine find_slot

  !> Zero the sums of an element.
  pure subroutine clear(nk, tangent, work)
    integer, intent(in) :: nk
    logical, intent(in) :: tangent
    type(work_t), intent(inout) :: work
    integer :: n

    n = work%npartner
    work%r(:, :nk) = 0.0_wp
    work%back(:, :, :n) = 0.0_wp
    if (.not. tangent) return
    work%kk(:, :3*nk) = 0.0_wp
    work%kl(:, :, :n) = 0.0_wp
    work%lk(:, :, :n) = 0.0_wp
    work%ll(:, :, :n) = 0.0_wp
  end subroutine clear

  !> Make room for m points.
  pure subroutine reserve(nk, nl, m, kernel)
    integer, intent(in) :: nk, nl, m
    type(kernel_t), intent(inout) :: kernel
    integer :: nd

    nd = 3*(nk + nl)
    if (allocated(kernel%dt)) then
      if (size(kernel%own) >= nk*m .and. size(kernel%shp) >= nl*m .and. &
          size(kernel%dt) >= 3*nd*m .and. size(kernel%ds, 3) >= m .and. &
          size(kernel%k) >= 3*max(nk, nl)*nd) return
      deallocate (kernel%own, kernel%shp, kernel%slope, kernel%dt, kernel%dxi, kernel%ds, kernel%k)
    end if
    allocate (kernel%own(2*nk*m), kernel%shp(2*nl*m), kernel%slope(12*nl*m), kernel%dt(6*nd*m), &
              kernel%dxi(4*nd*m), kernel%ds(3, 3, 2*m), kernel%k(3*max(nk, nl)*nd))
  end subroutine reserve

  !> For the m points that face one partner, find the tractions, the states, the forces, and with
  !! `tangent` the factors of the derivatives of the forces.
  pure subroutine form_points(contact, k, slot, from, nk, nl, m, x, dt_first, tangent, side, &
                              kernel, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, slot, nk, nl, m
    integer, intent(in) :: from               !! the first of the m points in `kernel%point`
    real(wp), intent(in) :: x(:, :), dt_first
    logical, intent(in) :: tangent
    type(mortar_side_t), intent(inout) :: side
    type(kernel_t), intent(inout) :: kernel
    type(work_t), intent(inout) :: work
    type(point_t) :: at
    type(traction_derivatives_t) :: d
    real(wp) :: shp(nl), dshp(2, nl), load, share
    integer :: i, p, s

    share = own_share(contact)
    associate (other => contact%side(3 - k))
      do p = 1, m
        i = kernel%point(from + p - 1)
        s = kernel%slide_slot(from + p - 1)
        call find_traction(contact, other, i, s > 0, nk, kernel%xe, side%shp(:, i), x, dt_first, &
                           work%secant, side, at, d)
        call element_functions(other, work%partner(slot), side%cells%foot(i)%xi, shp, dshp)
        load = share*side%cells%weight(i)
        call add_forces(nk, nl, side%shp(:, i), shp, load*at%t, work%r, work%back(:, :, slot))
        if (.not. tangent) cycle
        call find_factors(nk, nl, m, p, side%cells%foot(i), side%shp(:, i), shp, dshp, at, d, &
                          load, kernel)
        if (s == slot) call add_sliding(nk, nl, p, side%slide_shp(:, i), kernel)
      end do
    end associate
  end subroutine form_points

  !> Find the traction of point i and its derivatives, and store the state and the friction of the
  !! point.
  pure subroutine find_traction(contact, other, i, slides, nk, xe, own_shp, x, dt_first, secant, &
                                side, at, d)
    type(contact_t), intent(in) :: contact
    type(surface_t), intent(in) :: other      !! the surface that the point faces
    integer, intent(in) :: i, nk
    logical, intent(in) :: slides             !! friction acts, and the point has a sliding point
    real(wp), intent(in) :: xe(3, nk)         !! positions of the nodes of its element [L]
    real(wp), intent(in) :: own_shp(nk)       !! their functions at the point
    real(wp), intent(in) :: x(:, :), dt_first !! see form_cells
    logical, intent(in) :: secant             !! see add_friction
    type(mortar_side_t), intent(inout) :: side
    type(point_t), intent(out) :: at
    type(traction_derivatives_t), intent(out) :: d
    type(traction_derivatives_t) :: dn
    integer :: b, j

    associate (foot => side%cells%foot(i), dpdx => side%dp(i))
      at%p = side%p(i)
      at%state = merge(TOUCH, OPEN, at%p > 0.0_wp)
      do b = 1, nk
        at%x = at%x + own_shp(b)*xe(:, b)
      end do
      call vary_normal(foot, at%x, at%n, dn)
      at%t = at%p*at%n
      d%x = outer(at%n, dpdx*at%n) + at%p*dn%x
      d%p = -outer(at%n, dpdx*at%n) + at%p*dn%p
      d%a = at%p*dn%a
      at%slides = slides
      if (slides) then
        b = other%first(side%slide(i)) - 1
        do j = 1, other%first(side%slide(i) + 1) - 1 - b
          at%xs = at%xs + side%slide_shp(j, i)*x(:, other%node(b + j))
        end do
        if (dt_first > 0.0_wp) at%ahead = side%ahead(i)*dt_first
        at%no_slip = touching_length(foot%gap, side%no_slip, GAP_ERROR*maxval(abs(xe)))
        call add_friction(contact, dn, dpdx*at%n, secant, at, d)
      end if
    end associate
    side%state(i) = at%state
    side%friction(:, i) = at%friction
    side%elastic(:, i) = at%elastic
    side%slip(i) = at%slip
  end subroutine find_traction

  !> Add the forces that the traction of a point exerts on both elements.
  pure subroutine add_forces(nk, nl, own_shp, shp, t, r, back)
    integer, intent(in) :: nk, nl
    real(wp), intent(in) :: own_shp(nk), shp(nl)
    real(wp), intent(in) :: t(3)                 !! traction times weight [F]
    real(wp), intent(inout) :: r(3, nk), back(3, nl) !! [F]
    integer :: b

    do b = 1, nk
      r(:, b) = r(:, b) - own_shp(b)*t
    end do
    do b = 1, nl
      back(:, b) = back(:, b) + shp(b)*t
    end do
  end subroutine add_forces

  !> Find the factors of the derivatives of the forces of point p of m: functions, slopes times
  !! traction, and the derivatives of traction and parameters.
  pure subroutine find_factors(nk, nl, m, p, foot, own_shp, shp, dshp, at, d, load, kernel)
    integer, intent(in) :: nk, nl, m, p
    type(foot_t), intent(in) :: foot
    real(wp), intent(in) :: own_shp(nk), shp(nl), dshp(2, nl)
    type(point_t), intent(in) :: at
    type(traction_derivatives_t), intent(in) :: d
    real(wp), intent(in) :: load              !! weight [L^2]
    type(kernel_t), intent(inout) :: kernel
    real(wp) :: h(3, 2), c(2, 2), g(3)
    integer :: b, i, n, nd

    nd = 3*(nk + nl)
    kernel%own(nk*(p - 1) + 1:nk*p) = own_shp
    kernel%shp(nl*(p - 1) + 1:nl*p) = shp
    do i = 1, 3
      n = 2*nl*(m*(i - 1) + p - 1)
      do b = 1, nl
        kernel%slope(n + b) = at%t(i)*dshp(1, b)
        kernel%slope(n + nl + b) = at%t(i)*dshp(2, b)
      end do
    end do
    call vary_projection(foot, at%x, h, c, g)
    call vary_both(nk, nl, own_shp, shp, dshp, load, d, h, c, g, kernel%dt(3*nd*(p - 1) + 1), &
                   kernel%dxi(2*nd*(p - 1) + 1))
    kernel%ds(:, :, p) = load*d%s
  end subroutine find_factors

  !> Add to the derivatives of the traction of point p those by way of its sliding point, which lies
  !! on the element that the point faces.
  pure subroutine add_sliding(nk, nl, p, slide_shp, kernel)
    integer, intent(in) :: nk, nl, p
    real(wp), intent(in) :: slide_shp(nl)     !! functions at the sliding point
    type(kernel_t), intent(inout) :: kernel
    integer :: i, j, n, nd

    nd = 3*(nk + nl)
    do i = 1, 3
      do j = 1, 3
        n = nd*(3*(p - 1) + i - 1) + 3*nk + (j - 1)*nl
        kernel%dt(n + 1:n + nl) = kernel%dt(n + 1:n + nl) + kernel%ds(i, j, p)*slide_shp
      end do
    end do
  end subroutine add_sliding

  !> Slip up to which a point of two surfaces that just touch has the stiffness of sticking;
  !! negative: the surfaces do not just touch. A penetration larger than the rounding error is real:
  !! the bodies may be so stiff that their penetrations are much smaller than `no_slip`.
  pure real(wp) function touching_length(gap, no_slip, error) result(length)
    real(wp), intent(in) :: gap       !! [L]
    real(wp), intent(in) :: no_slip   !! see mortar_side_t [L]
    real(wp), intent(in) :: error     !! rounding error of the gap [L]

    length = -1.0_wp
    if (gap >= 0.0_wp .and. gap <= no_slip) length = no_slip
    if (gap < 0.0_wp .and. gap >= -error) length = min(error, no_slip)
  end function touching_length

  !> Find the derivatives of the traction and of the parameters of a point with respect to the nodes
  !! of both elements.
  pure subroutine vary_both(nk, nl, own_shp, shp, dshp, load, d, h, c, g, dt, dxi)
    integer, intent(in) :: nk, nl
    real(wp), intent(in) :: own_shp(nk), shp(nl), dshp(2, nl), load
    type(traction_derivatives_t), intent(in) :: d
    real(wp), intent(in) :: h(3, 2), c(2, 2), g(3) !! see vary_projection
    real(wp), intent(out) :: dt(3*(nk + nl), 3), dxi(3*(nk + nl), 2)
    real(wp) :: p, r(2)
    integer :: b, i, j, n

    do j = 1, 3
      n = (j - 1)*nk
      do i = 1, 3
        p = load*d%x(i, j)
        do b = 1, nk
          dt(n + b, i) = p*own_shp(b)
        end do
      end do
      do i = 1, 2
        p = load*h(j, i)
        do b = 1, nk
          dxi(n + b, i) = p*own_shp(b)
        end do
      end do
      n = 3*nk + (j - 1)*nl
      do i = 1, 3
        p = load*d%p(i, j)
        r = load*d%a(i, j, :)
        do b = 1, nl
          dt(n + b, i) = p*shp(b) + r(1)*dshp(1, b) + r(2)*dshp(2, b)
        end do
      end do
      do i = 1, 2
        p = -load*h(j, i)
        r = load*g(j)*c(i, :)
        do b = 1, nl
          dxi(n + b, i) = p*shp(b) + r(1)*dshp(1, b) + r(2)*dshp(2, b)
        end do
      end do
    end do
  end subroutine vary_both

  !> Add the derivatives of the forces of m points that face one partner.
  pure subroutine add_products(nk, nl, nd, m, slot, own_shp, shp, slope, dt, dxi, product, work)
    integer, intent(in) :: nk, nl, nd, m, slot
    real(wp), intent(in) :: own_shp(nk, m), shp(nl, m), slope(nl, 2, m, 3), dt(nd, 3, m), &
                            dxi(nd, 2, m)
    real(wp), intent(inout) :: product(3*max(nk, nl)*nd)
    type(work_t), intent(inout) :: work
    integer :: i

    call dgemm('N', 'T', nk, 3*nd, m, -1.0_wp, own_shp, nk, dt, 3*nd, 0.0_wp, product, nk)
    call add_block(nk, nk, nd, 0, product, work%kk)
    call add_block(nk, nl, nd, 3*nk, product, work%kl(:, :, slot))
    call dgemm('N', 'T', nl, 3*nd, m, 1.0_wp, shp, nl, dt, 3*nd, 0.0_wp, product, nl)
    do i = 1, 3
      call dgemm('N', 'T', nl, nd, 2*m, 1.0_wp, slope(1, 1, 1, i), nl, dxi, nd, 1.0_wp, &
                 product(1 + (i - 1)*nl*nd), nl)
    end do
    call add_block(nl, nk, nd, 0, product, work%lk(:, :, slot))
    call add_block(nl, nl, nd, 3*nk, product, work%ll(:, :, slot))
  end subroutine add_products

  !> Add columns of a product to a block. The columns are those of n nodes, after column `before`.
  pure subroutine add_block(nrow, n, nd, before, product, block)
    integer, intent(in) :: nrow, n, nd, before
    real(wp), intent(in) :: product(nrow, nd, 3)
    real(wp), intent(inout) :: block(:, :)     !! (3*nrow, 3*n)
    integer :: a, b, i, j

    do b = 1, n
      do j = 1, 3
        do a = 1, nrow
          do i = 1, 3
            block(3*(a - 1) + i, 3*(b - 1) + j) = block(3*(a - 1) + i, 3*(b - 1) + j) &
                                                  + product(a, before + b + (j - 1)*n, i)
          end do
        end do
      end do
    end do
  end subroutine add_block

  !> Add the derivatives with respect to the sliding points of those integration points whose
  !! sliding point lies on another element than the one that they face.
  pure subroutine add_away(contact, k, slot, nk, nl, m, point, slide_slot, slide_shp, own_shp, &
                           shp, ds, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, slot, nk, nl, m
    integer, intent(in) :: point(m), slide_slot(m)
    real(wp), intent(in) :: slide_shp(:, :), own_shp(nk, m), shp(nl, m), ds(:, :, :)
    type(work_t), intent(inout) :: work
    integer :: b, c, f, j, n, p, s
    real(wp) :: q(3)

    associate (other => contact%side(3 - k))
      do p = 1, m
        s = slide_slot(p)
        if (s == 0 .or. s == slot) cycle
        f = work%partner(s)
        n = other%first(f + 1) - other%first(f)
        call find_cross(slot, s, work, c)
        do b = 1, n
          do j = 1, 3
            q = ds(:, j, p)*slide_shp(b, point(p))
            call add_rows(nk, own_shp(:, p), -q, work%kl(:3*nk, 3*(b - 1) + j, s))
            call add_rows(nl, shp(:, p), q, work%cross(:3*nl, 3*(b - 1) + j, c))
          end do
        end do
      end do
    end associate
  end subroutine add_away

  !> Add a vector times the functions of n nodes to the rows of these nodes in a column.
  pure subroutine add_rows(n, shp, q, column)
    integer, intent(in) :: n
    real(wp), intent(in) :: shp(n), q(3)
    real(wp), intent(inout) :: column(3, n)
    integer :: a

    do a = 1, n
      column(:, a) = column(:, a) + shp(a)*q
    end do
  end subroutine add_rows

  !> Find the number of a pair of slots. A pair without a number is assigned a new one.
  pure subroutine find_cross(slot, other, work, c)
    integer, intent(in) :: slot, other
    type(work_t), intent(inout) :: work
    integer, intent(out) :: c

    do c = work%ncross, 1, -1
      if (work%pair(1, c) == slot .and. work%pair(2, c) == other) return
    end do
    c = work%ncross + 1
    call reserve_crosses(c, work)
    work%ncross = c
    work%pair(:, c) = [slot, other]
    work%cross(:, :, c) = 0.0_wp
  end subroutine find_cross

end module mortar_kernel
