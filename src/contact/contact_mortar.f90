!> The mortar scheme (SCHEme MORTar): one energy for the normal contact of both sides, integrated
!! over cells.
!!
!! Each side k that is not rigid is integrated over its cells (contact_cells). Its share c of the
!! energy is 1/2, or 1 if the other side is rigid. W and p are the energy and the pressure of the
!! normal law, N_A the functions of the control points, g the gap to the closest point of the other
!! side, and w the reference areas of the points:
!!
!!   E   = c sum_i w_i W(g_i; eps_1) + c sum_A a_A W(g_A; eps_2),    a_A = sum_i w_i N_A,
!!   g_A = sum_i w_i N_A g_i/a_A,     p_i = p(g_i; eps_1) + sum_A N_A q_A,    q_A = p(g_A; eps_2).
!!
!! The gradient of E consists of forces c w_i p_i n_i. Each of them acts on its point and, reversed,
!! on the projection of the point, so the forces of the two sides are equal and opposite. The part
!! eps_1 of the penalty acts at points and resolves the edge of the contact area. If the penalty is
!! stiff, the rest of it, eps_2, acts at control points, where it does not cause locking.
!!
!! Friction acts at the points of the cells, too (mortar_slide).
module contact_mortar
  use base_comm, only: is_root, owns
  use base_kinds, only: wp
  use base_threads, only: thread_count, this_thread
  use contact_active, only: pairs_t, need_pair
  use contact_cells, only: cells_t, cut_cells
  use contact_facets, only: facets_t, divide_surface
  use contact_pair, only: contact_t, contact_state_t, is_integrated
  use contact_point, only: vary_projection
  use contact_scatter, only: scatter_element
  use contact_work, only: work_t, element_functions
  use csr, only: block_matrix_t
  use mortar_control, only: find_pressures, need_lists, add_control_tangent
  use mortar_kernel, only: form_cells
  use mortar_slide, only: find_slides
  use mortar_type, only: crew_t, mortar_t, mortar_side_t, size_of_element
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use self_contact, only: project_on_itself
  use surface_geometry, only: update_shape
  implicit none
  private
  public :: find_mortar, add_mortar

  !> Cells are cut again if, since the last cut, a node has moved farther than this many times the
  !! size of the smallest facet.
  real(wp), parameter :: MOVED_FAR = 1.0_wp
  !> The iteration has settled when its last increment is below this fraction of the size of the
  !! smallest facet.
  real(wp), parameter :: SETTLES = 0.3_wp
  !> Once the iteration has settled, cells are cut again if a node has moved farther than this
  !! fraction of the size of the smallest facet. The converged state then does not depend on where
  !! the iteration began. Without friction, the forces in this state have a potential, and the state
  !! rotates with the bodies.
  real(wp), parameter :: MOVED = 1.0e-8_wp
  !> The same fraction for cells that have been cut as often as possible: they may alternate between
  !! two states, but must not belong to positions that differ visibly.
  real(wp), parameter :: MATTERS = 4.0e-3_wp
  !> A step with friction in which no node moves farther than this fraction of the size of the
  !! smallest element keeps the cells of the previous step.
  real(wp), parameter :: RESTS = 1.0e-5_wp
  !> Largest number of times that cells are cut again after the iteration has settled. The count
  !! starts anew in each step, and whenever a later increment is large again.
  integer, parameter :: MOST_CUTS = 8
  !> The same with friction, including cuts after increments that are smaller than DECREASES times
  !! the smallest one before, which do not count in MOST_CUTS.
  integer, parameter :: MOST_SLOW_CUTS = 12
  !> Facets may touch up to this multiple of the distances between surfaces and their facets.
  real(wp), parameter :: BEYOND = 1.5_wp
  real(wp), parameter :: DECREASES = 0.7_wp
  !> A point of a surface moves at most this many times as far as the nodes, because shape functions
  !! may be negative.
  real(wp), parameter :: OVERSHOOT = 2.0_wp

contains

  !> Find cells, projections and pressures at the positions x. Also find the pairs of elements that
  !! contact couples, and the nodes that each control point couples. `grown` is set if the sparsity
  !! pattern of the tangent must be rebuilt.
  subroutine find_mortar(mortar, contact, x, x_start, step, slides, trial, shape, grid, state, &
                         pairs, grown)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) current positions [L]
    real(wp), intent(in) :: x_start(:, :)     !! (3, nnode) x at the start of the step [L]
    integer, intent(in) :: step
    logical, intent(in) :: slides             !! friction acts
    logical, intent(in) :: trial              !! trial of a line search, which needs only forces
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(contact_state_t), intent(inout) :: state
    type(pairs_t), intent(inout) :: pairs(2)
    logical, intent(inout) :: grown
    integer :: faced(2), slid(2)              ! the pairs that were needed last
    integer :: i, k

    mortar%slides = slides
    if (mortar%step /= step) then
      mortar%iterate = 0
      mortar%fresh = .not. any(abs(x - x_start) > 0.0_wp)
      do k = 1, 2
        if (.not. slides) exit
        call update_shape(contact%side(k), x_start, mortar%start(k))
        if (.not. is_integrated(contact, 3 - k)) cycle
        call update_grid(contact%side(k), mortar%start(k), mortar%start_grid(k))
      end do
    end if
    call add_travel(mortar, contact, x)
    call recut(mortar, contact, x, x_start, state%last_cut, step, trial, shape, grid)
    if (.not. trial) then
      mortar%x_iterate = x
      mortar%iterate = mortar%iterate + 1
    end if
    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      associate (cells => mortar%side(k)%cells, side => mortar%side(k))
        call project_points(contact, k, x, mortar%travel, mortar%reference(k), shape(3 - k), &
                            grid(3 - k), side)
        call find_pressures(contact, k, x, mortar%iterate, side, state%control(k))
        if (slides) call find_slides(mortar, contact, k, state%rubbed(k))
        faced = 0
        slid = 0
        do i = 1, cells%n
          if (.not. (side%p(i) > 0.0_wp .or. side%dp(i) < 0.0_wp)) cycle
          if (any([cells%elem(i), cells%foot(i)%elem] /= faced)) then
            faced = [cells%elem(i), cells%foot(i)%elem]
            call need_pair(pairs(k), faced(1), faced(2), step, grown)
          end if
          if (.not. slides) cycle
          if (side%slide(i) < 0 .or. all([cells%elem(i), side%slide(i)] == slid)) cycle
          slid = [cells%elem(i), side%slide(i)]
          call need_pair(pairs(k), slid(1), slid(2), step, grown)
        end do
        if (contact%control_penalty > 0.0_wp) then
          call need_lists(contact, k, side, size(x, 2), mortar%step /= step, grown)
        end if
      end associate
    end do
    mortar%step = step
  end subroutine find_mortar

  !> Add the motion of both sides since the last projection to `travel`, a bound on their motion
  !! since the cells were cut.
  subroutine add_travel(mortar, contact, x)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)
    integer :: k

    if (.not. allocated(mortar%x_last)) mortar%x_last = x
    do k = 1, 2
      mortar%travel = mortar%travel &
                      + OVERSHOOT*largest_motion(contact%side(k)%node, x, mortar%x_last)
    end do
    mortar%x_last = x
  end subroutine add_travel

  !> The largest distance that a node has moved.
  pure real(wp) function largest_motion(node, x, x_before) result(far)
    integer, intent(in) :: node(:)
    real(wp), intent(in) :: x(:, :), x_before(:, :) !! (3, nnode) [L]
    integer :: i

    far = 0.0_wp
    do i = 1, size(node)
      far = max(far, sum((x(:, node(i)) - x_before(:, node(i)))**2))
    end do
    far = sqrt(far)
  end function largest_motion

  !> Project the points of side k. Unless control points need all gaps, two kinds of points stay
  !! open without a projection: points that cannot have closed since their last projection, and
  !! points that face the same element as the last projected point if their distance from that
  !! point is less than the gap there.
  subroutine project_points(contact, k, x, travel, reference, shape, grid, side)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :), travel
    type(shape_t), intent(in) :: reference    !! shape of side k before it deformed
    type(shape_t), intent(in) :: shape        !! shape of the other side
    type(grid_t), intent(in) :: grid
    type(mortar_side_t), intent(inout) :: side
    integer :: e

    !$omp parallel do schedule(dynamic)
    do e = 1, contact%side(k)%nelem
      call project_element(contact, k, e, x, travel, reference, shape, grid, side)
    end do
    !$omp end parallel do
  end subroutine project_points

  !> Project the points of element e.
  subroutine project_element(contact, k, e, x, travel, reference, shape, grid, side)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: x(:, :), travel
    type(shape_t), intent(in) :: reference, shape
    type(grid_t), intent(in) :: grid
    type(mortar_side_t), intent(inout) :: side
    real(wp) :: at(3), from(3)                ! from: the last projected point [L]
    integer :: i, j, first, last, nk

    last = 0
    associate (own => contact%side(k), cells => side%cells)
      first = own%first(e) - 1
      nk = own%first(e + 1) - 1 - first
      do i = cells%first(e), cells%first(e + 1) - 1
        associate (foot => cells%foot(i))
          if (side%seen(i) >= 0.0_wp .and. foot%elem > 0 .and. &
              .not. contact%control_penalty > 0.0_wp) then
            if (foot%gap > travel - side%seen(i)) cycle
          end if
          if (contact%self) then
            call project_again(contact, shape, reference, i, cells)
            side%seen(i) = travel
            cycle
          end if
          at = 0.0_wp
          do j = 1, nk
            at = at + side%shp(j, i)*x(:, own%node(first + j))
          end do
          if (last > 0) then
            if (cells%faced(last) /= cells%faced(i)) last = 0
          end if
          if (last > 0) then
            associate (near => cells%foot(last))
              if (near%gap > norm2(at - from) .and. .not. contact%control_penalty > 0.0_wp) then
                foot%gap = near%gap - norm2(at - from)
                side%seen(i) = travel
                cycle
              end if
              if (side%seen(i) < 0.0_wp .and. foot%elem == near%elem) then
                call move_foot(near, from, at, foot%xi)
              end if
            end associate
          end if
          call project(contact%side(3 - k), shape, grid, at, foot, contact%depth)
          if (.not. touches(foot, contact%depth)) foot%elem = 0
          side%seen(i) = travel
          last = merge(i, 0, foot%elem > 0)
          from = at
        end associate
      end do
    end associate
  end subroutine project_element

  !> Find, to first order, where the projection of a point moves when the point moves.
  pure subroutine move_foot(foot, from, to, xi)
    type(foot_t), intent(in) :: foot          !! projection of the point at `from`
    real(wp), intent(in) :: from(3), to(3)    !! [L]
    real(wp), intent(out) :: xi(2)
    real(wp) :: h(3, 2), c(2, 2), g(3)

    call vary_projection(foot, from, h, c, g)
    xi = max(-1.0_wp, min(1.0_wp, foot%xi + matmul(to - from, h)))
  end subroutine move_foot

  !> Project a point of self-contact. The search starts where the point was projected last, or else
  !! at the facet that it faces.
  subroutine project_again(contact, shape, reference, i, cells)
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape, reference
    integer, intent(in) :: i
    type(cells_t), intent(inout) :: cells

    associate (foot => cells%foot(i))
      if (foot%elem == 0) then
        foot%elem = cells%faced(i)
        foot%xi = cells%faced_xi(:, i)
      end if
      call project_on_itself(contact, shape, reference, cells%elem(i), cells%xi(:, i), foot)
      if (.not. touches(foot, contact%depth)) foot%elem = 0
    end associate
  end subroutine project_again

  !> Cut the cells at the beginning of a step, and again if a surface has moved far enough since.
  subroutine recut(mortar, contact, x, x_start, last_cut, step, trial, shape, grid)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(in) :: x_start(:, :)     !! (3, nnode) x at the start of the step [L]
    real(wp), allocatable, intent(in) :: last_cut(:) !! see contact_state_t
    integer, intent(in) :: step
    !> A trial of a line search is compared with other forces on the same cells. Cells are then cut
    !! only after a motion beyond MOVED_FAR.
    logical, intent(in) :: trial
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    real(wp) :: far, increment ! motion since the last cut, and since the last iterate [L]
    logical :: new, may_cut

    new = mortar%step /= step .or. .not. allocated(mortar%x_cut)
    if (.not. trial) mortar%follows = .false.
    if (.not. new .and. mortar%keeps) then
      if (is_at_rest(contact, x, x_start)) return
      mortar%keeps = .false.
    end if
    if (.not. new) then
      far = motion_of_sides(contact, x, mortar%x_cut)
      increment = motion_of_sides(contact, x, mortar%x_iterate)
      if (.not. far > MOVED_FAR*mortar%least) then
        if (trial) return
        if (increment > SETTLES*mortar%least) then
          mortar%cuts = 0
          mortar%slow_cuts = 0
        end if
        may_cut = mortar%cuts < MOST_CUTS .and. mortar%slow_cuts < MOST_SLOW_CUTS
        mortar%stale = far > merge(MOVED, MATTERS, may_cut)*mortar%least
        if (increment > SETTLES*mortar%least .or. .not. mortar%stale) return
        mortar%follows = mortar%slides .and. mortar%patient
        mortar%slow_cuts = mortar%slow_cuts + 1
        if (mortar%slow_cuts == 1) mortar%increment = huge(increment)
        if (.not. (mortar%follows .and. increment < DECREASES*mortar%increment)) then
          mortar%cuts = mortar%cuts + 1
        end if
        mortar%increment = min(mortar%increment, increment)
      end if
    else
      mortar%cuts = 0
      mortar%slow_cuts = 0
    end if
    mortar%stale = .false.
    mortar%x_cut = x
    if (any(grid(1)%n == 0) .and. any(grid(2)%n == 0)) then ! a position is not finite
      mortar%travel = 0.0_wp
      return
    end if
    mortar%keeps = new .and. allocated(last_cut) .and. is_at_rest(contact, x, x_start)
    if (mortar%keeps) then
      call cut_again(mortar, contact, last_cut)
      mortar%keeps = .not. motion_of_sides(contact, x, mortar%x_cut) > MATTERS*mortar%least
      if (mortar%keeps) return
      mortar%x_cut = x
    end if
    call cut_both(mortar, contact, shape)
  end subroutine recut

  !> Cut the cells where those of the previous step were cut. At the start of a step, the state is
  !! then that of the end of the previous step, although that state may belong to cells of slightly
  !! different positions. A step in which nothing changes needs no iterations and changes nothing.
  subroutine cut_again(mortar, contact, last_cut)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: last_cut(:)       !! see contact_state_t
    type(shape_t) :: shape(2)
    integer :: k, n

    n = 0
    do k = 1, 2
      associate (node => contact%side(k)%node)
        mortar%x_cut(:, node) = reshape(last_cut(n + 1:n + 3*size(node)), [3, size(node)])
        n = n + 3*size(node)
      end associate
      call update_shape(contact%side(k), mortar%x_cut, shape(k))
    end do
    call cut_both(mortar, contact, shape)
  end subroutine cut_again

  !> Cut the cells of both sides. Facets that touch are closer than the smallest facet of one of the
  !! sides; a strongly curved surface may touch where its facets are farther away.
  subroutine cut_both(mortar, contact, shape)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    type(shape_t), intent(in) :: shape(2)
    type(facets_t) :: facets(2)
    real(wp) :: reach
    integer :: k

    mortar%travel = 0.0_wp                   ! motion is counted from this cut
    do k = 1, merge(1, 2, contact%self)
      call divide_surface(contact%side(k), shape(k), facets(k))
    end do
    if (contact%self) facets(2) = facets(1)
    mortar%least = min(facets(1)%least, facets(2)%least)
    reach = max(facets(1)%least, facets(2)%least, BEYOND*(facets(1)%bulge + facets(2)%bulge))
    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      call cut_cells(contact, k, shape, mortar%reference(k), facets, reach, mortar%side(k)%cells)
      call new_points(contact, k, mortar%side(k))
    end do
  end subroutine cut_both

  !> Have both sides hardly moved since they were at x_before?
  pure logical function is_at_rest(contact, x, x_before)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :), x_before(:, :) !! (3, nnode) [L]
    real(wp) :: width
    integer :: k

    width = huge(width)
    do k = 1, 2
      if (allocated(contact%side(k)%width)) width = min(width, minval(contact%side(k)%width))
    end do
    is_at_rest = motion_of_sides(contact, x, x_before) <= RESTS*width
  end function is_at_rest

  !> The largest distance that a node of either side has moved.
  pure real(wp) function motion_of_sides(contact, x, x_before) result(far)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :), x_before(:, :) !! (3, nnode) [L]

    far = max(largest_motion(contact%side(1)%node, x, x_before), &
              largest_motion(contact%side(2)%node, x, x_before))
  end function motion_of_sides

  !> Allocate and initialise the work space of the points of new cells.
  subroutine new_points(contact, k, side)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(mortar_side_t), intent(inout) :: side
    real(wp) :: dshp(2, size_of_element(contact%side(k)))
    integer :: i, n, nk

    n = side%cells%n
    if (allocated(side%p)) deallocate (side%p, side%dp, side%slide, side%slide_xi, side%ahead, &
                                       side%friction, side%elastic, side%slip, side%state, &
                                       side%shp, side%slide_shp, side%seen, side%limit)
    allocate (side%p(n), side%dp(n), side%slip(n), side%slide_xi(2, n), side%friction(3, n), &
              side%elastic(3, n), side%limit(n), source=0.0_wp)
    allocate (side%shp(size_of_element(contact%side(k)), n), &
              side%slide_shp(size_of_element(contact%side(3 - k)), n))
    allocate (side%slide(n), side%state(n), source=0)
    allocate (side%seen(n), side%ahead(n), source=-1.0_wp)
    associate (own => contact%side(k), cells => side%cells)
      do i = 1, n
        nk = own%first(cells%elem(i) + 1) - own%first(cells%elem(i))
        call element_functions(own, cells%elem(i), cells%xi(:, i), side%shp(:nk, i), dshp(:, :nk))
      end do
    end associate
  end subroutine new_points

  !> Add the forces of side k, and if `tangent` their derivatives, at the projections and pressures
  !! of find_mortar.
  subroutine add_mortar(mortar, contact, k, x, u, dt, tangent, state, pairs, work, a, f, rounding, &
                        largest)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :), u(:, :)  !! (3, nnode) current positions, displacements [L]
    real(wp), intent(in) :: dt                !! length of the step [T]
    logical, intent(in) :: tangent            !! .false.: forces only
    type(contact_state_t), intent(inout) :: state
    type(pairs_t), intent(in) :: pairs
    type(work_t), intent(in) :: work          !! sizes and options of the work space of a thread
    type(block_matrix_t), intent(inout) :: a
    real(wp), intent(inout) :: f(:, :)        !! (3, nnode) internal forces [F]
    real(wp), intent(inout) :: rounding, largest !! see sweep_t
    integer :: e, t
    logical :: owned                          ! this rank adds the tangent of the element

    call prepare_crew(thread_count(), work, mortar%crew(k))
    associate (own => contact%side(k), cells => mortar%side(k)%cells, crew => mortar%crew(k))
      !$omp parallel do ordered schedule(static, 1) private(t, owned)
      do e = 1, own%nelem
        t = this_thread()
        owned = owns(e)
        crew%work(t)%npartner = 0
        if (cells%first(e) < cells%first(e + 1)) then
          call form_cells(contact, k, e, x, merge(dt, -1.0_wp, mortar%fresh), mortar%slides, &
                          tangent .and. owned, mortar%side(k), crew%kernel(t), crew%work(t))
        end if
        !$omp ordered
        if (crew%work(t)%npartner > 0) then ! in the order of the elements
          call scatter_element(contact, k, e, crew%work(t), pairs, x, u, tangent .and. owned, &
                               state, a, f, rounding, largest)
        end if
        !$omp end ordered
      end do
      !$omp end parallel do
    end associate
    mortar%fresh = .false.
    if (.not. (contact%control_penalty > 0.0_wp .and. tangent .and. is_root())) return
    call add_control_tangent(mortar%side(k), contact, k, x, work%secant, a)
  end subroutine add_mortar

  !> Give each of n threads its work space.
  subroutine prepare_crew(n, work, crew)
    integer, intent(in) :: n
    type(work_t), intent(in) :: work
    type(crew_t), intent(inout) :: crew
    integer :: t

    if (allocated(crew%work)) then
      if (size(crew%work) < n) deallocate (crew%work, crew%kernel)
    end if
    if (.not. allocated(crew%work)) then
      allocate (crew%work(n), crew%kernel(n))
      do t = 1, n
        crew%work(t) = work
      end do
    end if
    crew%work%secant = work%secant
  end subroutine prepare_crew

end module contact_mortar
