!> The mortar scheme (SCHEme MORTar): one energy of the normal contact of both sides, integrated
!! over cells.
!!
!! Each side k that is not rigid is integrated over its cells (contact_cells), with the share c of
!! 1/2, or 1 if the other side is rigid. N_A are the functions of its control points, g the gap to
!! the closest point of the other side, and w the reference areas of the points:
!!
!!   E   = c sum_i w_i W(g_i; eps_1) + c sum_A a_A W(g_A; eps_2),    a_A = sum_i w_i N_A,
!!   g_A = sum_i w_i N_A g_i/a_A,     p_i = p(g_i; eps_1) + sum_A N_A q_A,    q_A = p(g_A; eps_2).
!!
!! Its gradient, c w_i p_i n_i, acts on the point and, reversed, on its projection: the forces of
!! the two sides are equal and opposite. The part eps_1 of the penalty acts at points and resolves
!! the edge of the contact area; the rest, of stiff penalties, acts at control points, where it does
!! not lock.
!!
!! Friction acts at the points of the cells too, so that its bound is mu times their pressure. When
!! cells are cut, a point takes over the elastic slip of the nearest point of the last step in its
!! element: its sliding point is where it faced the other side at the start of the step, less that
!! slip.
module contact_mortar
  use base_kinds, only: wp
  use contact_active, only: pairs_t, need_pair
  use contact_cells, only: cells_t, facets_t, divide_surface, cut_cells
  use contact_history, only: trail_behind
  use contact_pair, only: contact_t, surface_t, control_points_t, contact_state_t, friction_points_t
  use contact_point, only: point_t, traction_derivatives_t, vary_normal, add_friction, outer
  use contact_scatter, only: scatter_element
  use contact_type, only: PENALTY, OPEN, STICK, SLIP, TOUCH
  use contact_work, only: work_t, reserve_partners, clear, add_own, add_partner, add_back, &
                          add_forces, add_cross, own_share, element_functions, position_on
  use csr, only: block_matrix_t, clique_t, block_position
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use rigid_surface, only: put_force
  use surface_geometry, only: update_shape, surface_point
  use tensor, only: cross
  implicit none
  private
  public :: mortar_t, new_mortar, find_mortar, mortar_clique, add_mortar, accept_mortar, &
            split_mortar_forces

  !> Cells are cut again while a node has moved by more than this fraction of the smallest facet:
  !! until the iteration ends, since an area that is cut off wrongly is missing in the forces.
  real(wp), parameter :: MOVED = 1.0e-4_wp
  !> But no more than so often in a step, unless a node has moved by the larger fraction.
  integer, parameter :: MOST_CUTS = 2
  real(wp), parameter :: MOVED_FAR = 0.1_wp
  !> Overlap of a control point, relative to the largest, that does not count.
  real(wp), parameter :: NO_OVERLAP = 1.0e-10_wp
  real(wp), parameter :: FIXED_AREA(3, 2) = 0.0_wp !! the reference area does not change

  !> Nodes that the pressure and friction of a control point couple, ascending in no order.
  type :: node_list_t
    integer, allocatable :: node(:)
  end type node_list_t

  !> Work space of one side.
  type :: mortar_side_t
    type(cells_t) :: cells
    real(wp), allocatable :: p(:), dp(:)      !! (n) pressure of a point, and its part's derivative
    integer, allocatable :: slide(:)          !! (n) element of the sliding point; 0: not looked for
    !! yet, negative: there is none
    real(wp), allocatable :: slide_xi(:, :)   !! (2, n)
    !> (n) Slip over time that is expected [L/T]; negative: none.
    real(wp), allocatable :: ahead(:)
    real(wp), allocatable :: friction(:, :)   !! (3, n) traction of friction [F/L^2]
    real(wp), allocatable :: elastic(:, :)    !! (3, n) see friction_law_i [L]
    real(wp), allocatable :: slip(:)          !! (n) [L]
    integer, allocatable :: state(:)          !! (n) OPEN, STICK, SLIP, TOUCH
    real(wp), allocatable :: q(:), dq(:)      !! (ncontrol) pressure there and its derivative
    real(wp), allocatable :: a(:)             !! (ncontrol) reference area of the overlap [L^2]
    real(wp), allocatable :: volume(:)        !! (ncontrol) sum of w N g [L^3]
    integer, allocatable :: round_first(:)    !! (ncontrol+1)
    integer, allocatable :: round(:)          !! elements round a control point
    type(node_list_t), allocatable :: known(:) !! (ncontrol) couplings of the current pattern
  end type mortar_side_t

  !> Work space of one contact.
  type :: mortar_t
    integer :: step = -1                      !! of the last projection
    integer :: cuts = 0                       !! of cells, in this step
    real(wp) :: least = 0.0_wp                !! size of the smallest facet [L]
    real(wp), allocatable :: x_cut(:, :)      !! (3, nnode) positions when the cells were cut
    logical :: slides = .false.               !! friction acts
    logical :: fresh = .false.                !! forces of this step have not been formed yet
    type(shape_t) :: reference(2)
    type(shape_t) :: start(2)                 !! at the start of the step, with friction
    type(grid_t) :: start_grid(2)
    type(mortar_side_t) :: side(2)
  end type mortar_t

contains

  !> Work space of a contact.
  subroutine new_mortar(contact, xr, mortar)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)          !! (3, nnode) reference positions [L]
    type(mortar_t), intent(out) :: mortar
    integer :: i, k, n

    do k = 1, 2
      call update_shape(contact%side(k), xr, mortar%reference(k))
      n = contact%side(k)%ncontrol
      associate (side => mortar%side(k))
        allocate (side%q(n), side%dq(n), side%a(n), side%volume(n), source=0.0_wp)
        allocate (side%known(n))
        do i = 1, n
          allocate (side%known(i)%node(0))
        end do
        call find_rounds(contact%side(k), side)
      end associate
    end do
  end subroutine new_mortar

  !> The elements round each control point.
  subroutine find_rounds(surface, side)
    type(surface_t), intent(in) :: surface
    type(mortar_side_t), intent(inout) :: side
    integer :: a, e, i
    integer :: last(surface%ncontrol), n(surface%ncontrol)

    n = 0
    last = 0
    do e = 1, surface%nelem
      do i = surface%control_first(e), surface%control_first(e + 1) - 1
        a = surface%control(i)
        if (last(a) == e) cycle
        last(a) = e
        n(a) = n(a) + 1
      end do
    end do
    allocate (side%round_first(surface%ncontrol + 1), side%round(sum(n)))
    side%round_first(1) = 1
    do a = 1, surface%ncontrol
      side%round_first(a + 1) = side%round_first(a) + n(a)
    end do
    n = side%round_first(:surface%ncontrol)
    last = 0
    do e = 1, surface%nelem
      do i = surface%control_first(e), surface%control_first(e + 1) - 1
        a = surface%control(i)
        if (last(a) == e) cycle
        last(a) = e
        side%round(n(a)) = e
        n(a) = n(a) + 1
      end do
    end do
  end subroutine find_rounds

  !> Functions of the control points of element e at xi; `shp` are those of its nodes.
  pure subroutine control_functions(surface, xi, shp, psi)
    type(surface_t), intent(in) :: surface
    real(wp), intent(in) :: xi(2), shp(:)
    real(wp), intent(out) :: psi(:)

    if (surface%hats) then
      psi(:4) = 0.25_wp*[(1 - xi(1))*(1 - xi(2)), (1 + xi(1))*(1 - xi(2)), &
                         (1 - xi(1))*(1 + xi(2)), (1 + xi(1))*(1 + xi(2))]
    else
      psi(:size(shp)) = shp
    end if
  end subroutine control_functions

  !> Cells, projections and pressures at the positions x; the pairs of elements and the nodes that
  !! they couple. `grown`: the pattern must be rebuilt.
  subroutine find_mortar(mortar, contact, x, x_start, step, slides, shape, grid, state, pairs, &
                         grown)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)           !! (3, nnode) current positions [L]
    real(wp), intent(in) :: x_start(:, :)     !! (3, nnode) at the start of the step [L]
    integer, intent(in) :: step
    logical, intent(in) :: slides             !! friction acts
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(contact_state_t), intent(inout) :: state
    type(pairs_t), intent(inout) :: pairs(2)
    logical, intent(inout) :: grown
    integer :: e, i, k
    real(wp) :: at(3), a(3, 2), b(3, 3)

    mortar%slides = slides
    if (mortar%step /= step) then
      mortar%fresh = .true.
      do k = 1, 2
        if (.not. slides) exit
        call update_shape(contact%side(k), x_start, mortar%start(k))
        if (contact%side(3 - k)%rigid) cycle
        call update_grid(contact%side(k), mortar%start(k), mortar%start_grid(k))
      end do
    end if
    call recut(mortar, contact, x, step, shape, grid)
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      associate (cells => mortar%side(k)%cells, other => contact%side(3 - k))
        do i = 1, cells%n
          call surface_point(contact%side(k), shape(k), cells%elem(i), cells%xi(:, i), at, a, b)
          call project(other, shape(3 - k), grid(3 - k), at, cells%foot(i), contact%depth)
          if (.not. touches(cells%foot(i), contact%depth)) cells%foot(i)%elem = 0
        end do
        call find_pressures(contact, k, mortar%side(k), state%control(k))
        do i = 1, cells%n
          if (.not. mortar%side(k)%p(i) > 0.0_wp) cycle
          e = cells%elem(i)
          call need_pair(pairs(k), e, cells%foot(i)%elem, step, grown)
          if (.not. slides) cycle
          if (mortar%side(k)%slide(i) == 0) call find_slide(mortar, contact, k, i, state%rubbed(k))
          if (mortar%side(k)%slide(i) < 0) cycle
          call need_pair(pairs(k), e, mortar%side(k)%slide(i), step, grown)
        end do
        if (contact%control_penalty > 0.0_wp) then
          call need_lists(contact, k, mortar%side(k), size(x, 2), mortar%step /= step, grown)
        end if
      end associate
    end do
    mortar%step = step
  end subroutine find_mortar

  !> The sliding point of a point that touches: where it faced the other side at the start of the
  !! step, less the elastic slip that it takes over.
  subroutine find_slide(mortar, contact, k, i, rubbed)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, i
    type(friction_points_t), intent(in) :: rubbed
    type(foot_t) :: foot
    real(wp) :: at(3), a(3, 2), b(3, 3), n(3)
    integer :: j

    associate (side => mortar%side(k), cells => mortar%side(k)%cells)
      call surface_point(contact%side(k), mortar%start(k), cells%elem(i), cells%xi(:, i), at, a, b)
      foot%elem = cells%foot(i)%elem
      foot%xi = cells%foot(i)%xi
      call project(contact%side(3 - k), mortar%start(3 - k), mortar%start_grid(3 - k), at, foot)
      side%slide(i) = -1
      if (foot%elem > 0) then
        side%slide(i) = foot%elem
        side%slide_xi(:, i) = foot%xi
      else if (foot%outer > 0) then ! it comes from beyond the border
        side%slide(i) = foot%outer
        side%slide_xi(:, i) = foot%outer_xi
        return
      else
        return
      end if
      j = nearest_rubbed(rubbed, cells%elem(i), cells%xi(:, i))
      if (j == 0) return
      side%ahead(i) = -1.0_wp
      if (rubbed%slip_rate(j) > 0.0_wp) side%ahead(i) = rubbed%slip_rate(j)
      if (.not. any(abs(rubbed%elastic(:, j)) > 0.0_wp)) return
      n = foot%n
      call trail_behind(contact%side(3 - k), mortar%start(3 - k), at, foot, &
                        rubbed%elastic(:, j) - dot_product(rubbed%elastic(:, j), n)*n, &
                        side%slide(i), side%slide_xi(:, i))
    end associate
  end subroutine find_slide

  !> The nearest point of the last step in an element; 0: it had none.
  pure integer function nearest_rubbed(rubbed, e, xi) result(j)
    type(friction_points_t), intent(in) :: rubbed
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    integer :: low, high, middle
    real(wp) :: d, least

    j = 0
    low = 1
    high = size(rubbed%elem) + 1
    do while (low < high) ! the first point of element e
      middle = (low + high)/2
      if (rubbed%elem(middle) < e) then
        low = middle + 1
      else
        high = middle
      end if
    end do
    least = huge(least)
    do while (low <= size(rubbed%elem))
      if (rubbed%elem(low) /= e) exit
      d = sum((rubbed%xi(:, low) - xi)**2)
      if (d < least) then
        least = d
        j = low
      end if
      low = low + 1
    end do
  end function nearest_rubbed

  !> Cut the cells at the beginning of a step, and where a surface has moved since.
  subroutine recut(mortar, contact, x, step, shape, grid)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)
    integer, intent(in) :: step
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(facets_t) :: facets(2)
    real(wp) :: far
    integer :: i, k
    logical :: new

    new = mortar%step /= step .or. .not. allocated(mortar%x_cut)
    if (.not. new) then
      far = 0.0_wp
      do k = 1, 2
        do i = 1, size(contact%side(k)%node)
          associate (node => contact%side(k)%node(i))
            far = max(far, maxval(abs(x(:, node) - mortar%x_cut(:, node))))
          end associate
        end do
      end do
      if (far <= MOVED*mortar%least) return
      if (mortar%cuts >= MOST_CUTS .and. far <= MOVED_FAR*mortar%least) return
    end if
    if (new) mortar%cuts = 0
    mortar%cuts = mortar%cuts + 1
    mortar%x_cut = x
    if (any(grid(1)%n == 0) .and. any(grid(2)%n == 0)) return ! a surface is not finite
    do k = 1, 2
      call divide_surface(contact%side(k), shape(k), facets(k))
    end do
    mortar%least = min(facets(1)%least, facets(2)%least)
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      associate (side => mortar%side(k), cells => mortar%side(k)%cells)
        call cut_cells(contact, k, shape, mortar%reference(k), facets, &
                       max(facets(1)%least, facets(2)%least), cells)
        if (allocated(side%p)) deallocate (side%p, side%dp, side%slide, side%slide_xi, side%ahead, &
                                           side%friction, side%elastic, side%slip, side%state)
        allocate (side%p(cells%n), side%dp(cells%n), side%slip(cells%n), side%ahead(cells%n), &
                  side%slide_xi(2, cells%n), side%friction(3, cells%n), side%elastic(3, cells%n), &
                  source=0.0_wp)
        allocate (side%slide(cells%n), side%state(cells%n), source=0)
      end associate
    end do
  end subroutine recut

  !> Weighted gaps and pressures of the control points, and the pressures of the points.
  subroutine find_pressures(contact, k, side, control)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(mortar_side_t), intent(inout) :: side
    type(control_points_t), intent(inout) :: control
    real(wp) :: energy, prop(size(contact%normal%prop))
    real(wp) :: psi(size_of_element(contact%side(k)))
    integer :: a, i, j

    associate (own => contact%side(k), cells => side%cells, law => contact%normal%law)
      control%gap = huge(1.0_wp)
      control%pressure = 0.0_wp
      side%q = 0.0_wp
      side%dq = 0.0_wp
      side%a = 0.0_wp
      prop = contact%normal%prop
      if (contact%control_penalty > 0.0_wp) then
        side%volume = 0.0_wp
        do i = 1, cells%n
          if (cells%foot(i)%elem == 0) cycle
          call control_at(own, cells, i, psi)
          do j = 1, number_at(own, cells%elem(i))
            a = own%control(own%control_first(cells%elem(i)) + j - 1)
            side%a(a) = side%a(a) + cells%weight(i)*psi(j)
            side%volume(a) = side%volume(a) + cells%weight(i)*psi(j)*cells%foot(i)%gap
          end do
        end do
        prop(PENALTY) = contact%control_penalty
        do a = 1, own%ncontrol
          if (.not. side%a(a) > NO_OVERLAP*maxval(side%a)) cycle
          control%gap(a) = side%volume(a)/side%a(a)
          call law%normal(prop, control%gap(a), control%multiplier(a), side%q(a), &
                          side%dq(a), energy)
        end do
        control%pressure = side%q
      end if
      prop(PENALTY) = contact%normal%prop(PENALTY) - contact%control_penalty
      side%p = 0.0_wp
      side%dp = 0.0_wp
      do i = 1, cells%n
        if (cells%foot(i)%elem == 0) cycle
        call law%normal(prop, cells%foot(i)%gap, 0.0_wp, side%p(i), side%dp(i), energy)
        if (.not. contact%control_penalty > 0.0_wp) cycle
        call control_at(own, cells, i, psi)
        do j = 1, number_at(own, cells%elem(i))
          a = own%control(own%control_first(cells%elem(i)) + j - 1)
          side%p(i) = side%p(i) + psi(j)*side%q(a)
        end do
      end do
    end associate
  end subroutine find_pressures

  !> Most functions of an element of a surface, of its nodes or control points.
  pure integer function size_of_element(surface) result(n)
    type(surface_t), intent(in) :: surface

    n = max(4, maxval(surface%basis%nsf))
  end function size_of_element

  pure integer function number_at(surface, e) result(n)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e

    n = surface%control_first(e + 1) - surface%control_first(e)
  end function number_at

  !> Functions of the control points at point i.
  pure subroutine control_at(surface, cells, i, psi)
    type(surface_t), intent(in) :: surface
    type(cells_t), intent(in) :: cells
    integer, intent(in) :: i
    real(wp), intent(out) :: psi(:)
    real(wp) :: shp(size(psi)), dshp(2, size(psi))
    integer :: n

    n = surface%first(cells%elem(i) + 1) - surface%first(cells%elem(i))
    if (.not. surface%hats) then
      call element_functions(surface, cells%elem(i), cells%xi(:, i), shp(:n), dshp(:, :n))
    end if
    call control_functions(surface, cells%xi(:, i), shp(:n), psi)
  end subroutine control_at

  !> Nodes that each control point couples.
  subroutine need_lists(contact, k, side, nnode, new, grown)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(mortar_side_t), intent(inout) :: side
    integer, intent(in) :: nnode
    logical, intent(in) :: new               !! the step begins: earlier couplings are forgotten
    logical, intent(inout) :: grown
    integer, allocatable :: mark(:), list(:)
    integer :: a, e, i, n, r

    allocate (mark(nnode), source=0)
    allocate (list(nnode))
    associate (own => contact%side(k), other => contact%side(3 - k), cells => side%cells)
      do a = 1, own%ncontrol
        n = 0
        if (side%dq(a) < 0.0_wp) then
          do r = side%round_first(a), side%round_first(a + 1) - 1
            e = side%round(r)
            if (cells%first(e) == cells%first(e + 1)) cycle
            call put_element(own, e)
            do i = cells%first(e), cells%first(e + 1) - 1
              if (cells%foot(i)%elem == 0) cycle
              call put_element(other, cells%foot(i)%elem)
            end do
          end do
        end if
        mark(list(:n)) = 0
        associate (known => side%known(a))
          if (new) then ! a list that is the same needs no new pattern
            if (n /= size(known%node)) then
              grown = .true.
            else if (n > 0) then
              mark(known%node) = 1
              grown = grown .or. any(mark(list(:n)) == 0)
              mark(known%node) = 0
            end if
            known%node = list(:n)
          else if (n > 0) then
            mark(known%node) = 1
            r = 0
            do i = 1, n
              if (mark(list(i)) > 0) cycle
              r = r + 1
              list(r) = list(i)
            end do
            mark(known%node) = 0
            if (r > 0) then
              grown = .true.
              known%node = [known%node, list(:r)]
            end if
          end if
        end associate
      end do
    end associate

  contains

    subroutine put_element(surface, e)
      type(surface_t), intent(in) :: surface
      integer, intent(in) :: e
      integer :: j

      do j = surface%first(e), surface%first(e + 1) - 1
        if (mark(surface%node(j)) > 0) cycle
        mark(surface%node(j)) = 1
        n = n + 1
        list(n) = surface%node(j)
      end do
    end subroutine put_element
  end subroutine need_lists

  !> Nodes that are coupled by the control points of side k, for the pattern.
  subroutine mortar_clique(mortar, k, clique)
    type(mortar_t), intent(in) :: mortar
    integer, intent(in) :: k
    type(clique_t), intent(out) :: clique
    integer :: a, m, n, size_of(size(mortar%side(k)%known))

    size_of = [(size(mortar%side(k)%known(a)%node), a=1, size(size_of))]
    m = 0
    if (size(size_of) > 0) m = maxval(size_of)
    allocate (clique%conn(m, count(size_of > 0)))
    n = 0
    do a = 1, size(size_of)
      if (size_of(a) == 0) cycle
      n = n + 1
      clique%conn(:, n) = mortar%side(k)%known(a)%node(1)
      clique%conn(:size_of(a), n) = mortar%side(k)%known(a)%node
    end do
  end subroutine mortar_clique

  !> Forces and derivatives of side k at the projections and pressures of find_mortar.
  subroutine add_mortar(mortar, contact, k, x, u, dt, tangent, state, pairs, work, a, f, rounding, &
                        largest)
    type(mortar_t), intent(inout) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :), u(:, :)  !! (3, nnode) current positions, displacements [L]
    real(wp), intent(in) :: dt                !! of the step [T]
    logical, intent(in) :: tangent            !! .false.: forces only
    type(contact_state_t), intent(inout) :: state
    type(pairs_t), intent(in) :: pairs
    type(work_t), intent(inout) :: work
    type(block_matrix_t), intent(inout) :: a
    real(wp), intent(inout) :: f(:, :)        !! (3, nnode) internal forces [F]
    real(wp), intent(inout) :: rounding, largest !! see sweep_t
    integer :: e

    associate (own => contact%side(k), cells => mortar%side(k)%cells)
      do e = 1, own%nelem
        if (cells%first(e) == cells%first(e + 1)) cycle
        call reserve_partners(count_partners(cells, e), work)
        call form_cells(contact, k, e, x, merge(dt, -1.0_wp, mortar%fresh), mortar%slides, &
                        tangent, mortar%side(k), work)
        if (work%npartner == 0) cycle
        call scatter_element(contact, k, e, work, pairs, x, u, tangent, state, a, f, rounding, &
                             largest)
      end do
    end associate
    mortar%fresh = .false.
    if (.not. (contact%control_penalty > 0.0_wp .and. tangent)) return
    call add_control_tangent(mortar%side(k), contact, k, x, a)
  end subroutine add_mortar

  !> A bound of the number of elements that the points of element e face.
  pure integer function count_partners(cells, e) result(n)
    type(cells_t), intent(in) :: cells
    integer, intent(in) :: e
    integer :: i

    n = 1
    do i = cells%first(e) + 1, cells%first(e + 1) - 1
      if (cells%foot(i)%elem /= cells%foot(i - 1)%elem) n = n + 1
    end do
  end function count_partners

  !> Forces of element e and their derivatives where the pressures of control points are fixed.
  pure subroutine form_cells(contact, k, e, x, dt_first, slides, tangent, side, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(in) :: dt_first          !! [T] of the step, if it begins; otherwise negative
    logical, intent(in) :: slides
    logical, intent(in) :: tangent            !! .false.: forces only
    type(mortar_side_t), intent(inout) :: side
    type(work_t), intent(inout) :: work
    type(point_t) :: point
    type(traction_derivatives_t) :: dt, dn
    real(wp) :: load
    integer :: i, j

    associate (own => contact%side(k), other => contact%side(3 - k), cells => side%cells)
      work%nk = own%basis(own%ibasis(e))%nsf
      work%npartner = 0
      do i = cells%first(e), cells%first(e + 1) - 1
        side%state(i) = OPEN
        side%friction(:, i) = 0.0_wp
        side%elastic(:, i) = 0.0_wp
        side%slip(i) = 0.0_wp
        if (.not. side%p(i) > 0.0_wp) cycle
        call clear(work)
        call element_functions(own, e, cells%xi(:, i), work%own(:work%nk), work%down(:, :work%nk))
        point = point_t(p=side%p(i), state=TOUCH)
        do j = 1, work%nk
          point%x = point%x + work%own(j)*x(:, own%node(own%first(e) + j - 1))
        end do
        call vary_normal(cells%foot(i), point%x, point%n, dn)
        point%t = point%p*point%n
        dt%x = outer(point%n, side%dp(i)*point%n) + point%p*dn%x
        dt%p = -outer(point%n, side%dp(i)*point%n) + point%p*dn%p
        dt%a = point%p*dn%a
        point%slides = slides .and. side%slide(i) > 0
        if (point%slides) then
          call position_on(other, side%slide(i), side%slide_xi(:, i), x, work, point%xs)
          if (dt_first > 0.0_wp) point%ahead = side%ahead(i)*dt_first
          call add_friction(contact, dn, side%dp(i)*point%n, point, dt)
        end if
        side%state(i) = point%state
        side%friction(:, i) = point%friction
        side%elastic(:, i) = point%elastic
        side%slip(i) = point%slip
        load = cells%weight(i)*own_share(contact)
        if (.not. tangent) then
          call add_forces(other, cells%foot(i)%elem, cells%foot(i)%xi, point%t, load, work)
          cycle
        end if
        call add_own(point%t, dt%x, FIXED_AREA, load, work)
        call add_partner(other, cells%foot(i)%elem, cells%foot(i)%xi, dt%p, dt%a, load, work)
        call add_back(other, cells%foot(i)%elem, point%t, load, work, cells%foot(i), point%x)
        if (.not. point%slides) cycle
        call add_partner(other, side%slide(i), side%slide_xi(:, i), dt%s, 0.0_wp*dt%a, load, work)
        call add_cross(other, load, work)
      end do
    end associate
  end subroutine form_cells

  !> The part of the tangent that couples all nodes round a control point: the pressure there varies
  !! with the positions of all of them.
  subroutine add_control_tangent(side, contact, k, x, a)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)
    type(block_matrix_t), intent(inout) :: a
    real(wp), allocatable :: slope(:, :)     ! (3, nodes) of the sum of w N g
    real(wp), allocatable :: rows(:, :)      ! (3, nodes) forces by the pressure, friction included
    integer, allocatable :: at(:), list(:)
    real(wp) :: psi(size_of_element(contact%side(k)))
    real(wp) :: shp(size_of_element(contact%side(k))), dshp(2, size_of_element(contact%side(k)))
    real(wp) :: there(size_of_element(contact%side(3 - k))), &
                dthere(2, size_of_element(contact%side(3 - k)))
    type(traction_derivatives_t) :: dn
    real(wp) :: xi(3), n(3), t(3), w, stiffness
    integer :: c, e, i, j, l, most, r, nk, nl, p

    most = 0
    do c = 1, size(side%known)
      most = max(most, size(side%known(c)%node))
    end do
    allocate (at(size(x, 2)), source=0)
    allocate (slope(3, most), rows(3, most))
    associate (own => contact%side(k), other => contact%side(3 - k), cells => side%cells)
      do c = 1, own%ncontrol
        if (.not. side%dq(c) < 0.0_wp) cycle
        list = side%known(c)%node
        do j = 1, size(list)
          at(list(j)) = j
        end do
        slope = 0.0_wp
        rows = 0.0_wp
        do r = side%round_first(c), side%round_first(c + 1) - 1
          e = side%round(r)
          nk = own%first(e + 1) - own%first(e)
          do i = cells%first(e), cells%first(e + 1) - 1
            if (cells%foot(i)%elem == 0) cycle
            call element_functions(own, e, cells%xi(:, i), shp(:nk), dshp(:, :nk))
            call control_functions(own, cells%xi(:, i), shp(:nk), psi)
            w = 0.0_wp
            do j = 1, number_at(own, e)
              if (own%control(own%control_first(e) + j - 1) == c) w = w + psi(j)
            end do
            w = w*cells%weight(i)
            if (.not. abs(w) > 0.0_wp) cycle
            xi = 0.0_wp
            do j = 1, nk
              xi = xi + shp(j)*x(:, own%node(own%first(e) + j - 1))
            end do
            call vary_normal(cells%foot(i), xi, n, dn)
            t = n                              ! traction by pressure
            if (side%state(i) == SLIP) t = n + side%friction(:, i)/side%p(i)
            do j = 1, nk
              l = at(own%node(own%first(e) + j - 1))
              slope(:, l) = slope(:, l) + w*shp(j)*n
              rows(:, l) = rows(:, l) + w*shp(j)*t
            end do
            associate (first => other%first(cells%foot(i)%elem))
              nl = other%first(cells%foot(i)%elem + 1) - first
              call element_functions(other, cells%foot(i)%elem, cells%foot(i)%xi, there(:nl), &
                                     dthere(:, :nl))
              do j = 1, nl
                l = at(other%node(first + j - 1))
                slope(:, l) = slope(:, l) - w*there(j)*n
                rows(:, l) = rows(:, l) - w*there(j)*t
              end do
            end associate
          end do
        end do
        stiffness = -own_share(contact)*side%dq(c)/side%a(c)
        do j = 1, size(list)
          do i = 1, size(list)
            if (a%symmetric .and. list(i) > list(j)) cycle
            p = block_position(a, list(i), list(j))
            if (a%symmetric) then
              a%val(:, :, p) = a%val(:, :, p) + 0.5_wp*stiffness*(outer(rows(:, i), slope(:, j)) &
                                                                  + outer(slope(:, i), rows(:, j)))
            else
              a%val(:, :, p) = a%val(:, :, p) + outer(rows(:, i), stiffness*slope(:, j))
            end if
          end do
        end do
        at(list) = 0
      end do
    end associate
  end subroutine add_control_tangent

  !> A step is accepted: where friction acted, the work of slip, and the results at the integration
  !! points, which serve fields, curves and reports: tractions on the current area.
  subroutine accept_mortar(mortar, contact, k, shape, grid, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid(2)
    type(contact_state_t), intent(inout) :: state
    type(foot_t) :: foot
    type(traction_derivatives_t) :: dn
    real(wp) :: at(3), a(3, 2), b(3, 3), n(3), p, reference, stretch
    integer :: e, i, j, q

    call keep_friction(mortar%side(k), contact, state%side(k)%dt, state%rubbed(k), state%dissipated)
    call measure_cells(mortar, contact, k, shape(k), state)
    associate (own => contact%side(k), side => mortar%side(k), points => state%side(k))
      points%traction = 0.0_wp
      points%friction = 0.0_wp
      points%elastic = 0.0_wp
      points%slip = 0.0_wp
      points%pressure = 0.0_wp
      points%state = OPEN
      do e = 1, own%nelem
        do q = 1, contact%nq
          i = (e - 1)*contact%nq + q
          call surface_point(own, mortar%reference(k), e, contact%xi(:, q), at, a, b)
          reference = norm2(cross(a(:, 1), a(:, 2)))
          call surface_point(own, shape(k), e, contact%xi(:, q), at, a, b)
          stretch = norm2(cross(a(:, 1), a(:, 2)))
          points%area(i) = contact%wgt(q)*stretch
          foot%elem = points%closest(i)
          foot%xi = points%closest_xi(:, i)
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), at, foot, contact%depth)
          points%closest(i) = foot%elem
          points%closest_xi(:, i) = foot%xi
          points%gap(i) = foot%gap
          if (.not. touches(foot, contact%depth)) cycle
          p = pressure_at(side, contact, k, e, contact%xi(:, q), foot%gap)
          if (.not. (p > 0.0_wp .and. stretch > 0.0_wp)) cycle
          j = nearest_closed(side, e, contact%xi(:, q))
          if (j == 0) cycle                  ! beyond the border of the other side, or looking away
          call vary_normal(foot, at, n, dn)
          p = p*reference/stretch
          points%pressure(i) = p
          points%state(i) = side%state(j)
          points%friction(:, i) = p/side%p(j)*(side%friction(:, j) &
                                               - dot_product(side%friction(:, j), n)*n)
          points%traction(:, i) = p*n + points%friction(:, i)
          points%elastic(:, i) = side%elastic(:, j)
          points%slip(i) = side%slip(j)
        end do
      end do
    end associate
  end subroutine accept_mortar

  !> What the points of the next step take over, and the work of the slip of this one.
  subroutine keep_friction(side, contact, dt, rubbed, dissipated)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: dt               !! [T]
    type(friction_points_t), intent(inout) :: rubbed
    real(wp), intent(inout) :: dissipated    !! [F L]
    logical :: rubs(side%cells%n)
    integer :: e, i, n

    associate (cells => side%cells)
      rubs = .false. ! whole elements: open points beside those in contact count as well
      do e = 1, size(cells%first) - 1
        i = cells%first(e)
        n = cells%first(e + 1) - 1
        rubs(i:n) = any(side%state(i:n) == STICK .or. side%state(i:n) == SLIP)
      end do
      n = cells%n
      rubbed%elem = pack(cells%elem(:n), rubs)
      rubbed%xi = reshape(pack(cells%xi(:, :n), spread(rubs, 1, 2)), [2, count(rubs)])
      rubbed%elastic = reshape(pack(side%elastic, spread(rubs, 1, 3)), [3, count(rubs)])
      rubbed%slip_rate = pack(merge(side%slip, 0.0_wp, side%state == SLIP), rubs) &
                         /max(dt, tiny(1.0_wp))
      do i = 1, n
        dissipated = dissipated + own_share(contact)*cells%weight(i)*norm2(side%friction(:, i)) &
                     *side%slip(i)
      end do
    end associate
  end subroutine keep_friction

  !> Pressure on the reference area at a point with a given gap.
  pure real(wp) function pressure_at(side, contact, k, e, xi, gap) result(p)
    type(mortar_side_t), intent(in) :: side
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    real(wp), intent(in) :: xi(2), gap
    real(wp) :: psi(size_of_element(contact%side(k))), prop(size(contact%normal%prop)), dp, energy
    integer :: j

    prop = contact%normal%prop
    prop(PENALTY) = prop(PENALTY) - contact%control_penalty
    call contact%normal%law%normal(prop, gap, 0.0_wp, p, dp, energy)
    if (.not. contact%control_penalty > 0.0_wp) return
    associate (own => contact%side(k))
      call functions_at(own, e, xi, psi)
      do j = 1, number_at(own, e)
        p = p + psi(j)*side%q(own%control(own%control_first(e) + j - 1))
      end do
    end associate
  end function pressure_at

  !> The nearest point of the cells of an element that carries a pressure; 0: there is none.
  pure integer function nearest_closed(side, e, xi) result(j)
    type(mortar_side_t), intent(in) :: side
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp) :: d, least
    integer :: i, n

    j = 0
    least = huge(least)
    do i = side%cells%first(e), side%cells%first(e + 1) - 1
      if (.not. side%p(i) > 0.0_wp) cycle
      d = sum((side%cells%xi(:, i) - xi)**2)
      if (d >= least) cycle
      least = d
      j = i
    end do
    n = max(1, side%cells%first(e + 1) - side%cells%first(e))
    if (least > 16.0_wp/n) j = 0 ! farther than about two points are from each other
  end function nearest_closed

  !> Area in contact, its parts that stick and slip, and the largest penetration of side k.
  subroutine measure_cells(mortar, contact, k, shape, state)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape       !! of side k
    type(contact_state_t), intent(inout) :: state
    real(wp) :: x(3), a(3, 2), b(3, 3), area, reference
    integer :: i

    state%area(k) = 0.0_wp
    state%sticks(k) = 0.0_wp
    state%slips(k) = 0.0_wp
    state%penetration(k) = 0.0_wp
    state%sheared(k) = 0.0_wp
    associate (side => mortar%side(k), cells => mortar%side(k)%cells)
      do i = 1, cells%n
        if (.not. side%p(i) > 0.0_wp) cycle
        call surface_point(contact%side(k), mortar%reference(k), cells%elem(i), cells%xi(:, i), x, &
                           a, b)
        reference = norm2(cross(a(:, 1), a(:, 2)))
        if (.not. reference > 0.0_wp) cycle
        call surface_point(contact%side(k), shape, cells%elem(i), cells%xi(:, i), x, a, b)
        area = cells%weight(i)*norm2(cross(a(:, 1), a(:, 2)))/reference
        state%area(k) = state%area(k) + area
        if (side%state(i) == STICK) state%sticks(k) = state%sticks(k) + area
        if (side%state(i) == SLIP) state%slips(k) = state%slips(k) + area
        state%penetration(k) = max(state%penetration(k), -cells%foot(i)%gap)
        state%sheared(k) = state%sheared(k) + 0.5_wp*own_share(contact)*cells%weight(i) &
                           *norm2(side%friction(:, i))*norm2(side%elastic(:, i))
      end do
    end associate
  end subroutine measure_cells

  !> Functions of the control points of element e at xi.
  pure subroutine functions_at(surface, e, xi, psi)
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)
    real(wp), intent(out) :: psi(:)
    real(wp) :: shp(size(psi)), dshp(2, size(psi))
    integer :: n

    n = surface%first(e + 1) - surface%first(e)
    call element_functions(surface, e, xi, shp(:n), dshp(:, :n))
    call control_functions(surface, xi, shp(:n), psi)
  end subroutine functions_at

  !> Internal forces of the pressure on side k at the last assembly. The work of friction is that of
  !! the slip (keep_friction).
  subroutine split_mortar_forces(mortar, contact, k, x, f)
    type(mortar_t), intent(in) :: mortar
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :)
    real(wp), intent(inout) :: f(:, :)       !! (3, nnode) [F]
    real(wp) :: shp(size_of_element(contact%side(k))), dshp(2, size_of_element(contact%side(k)))
    type(traction_derivatives_t) :: dn
    real(wp) :: at(3), n(3), t(3)
    integer :: e, i, j, nk

    associate (own => contact%side(k), side => mortar%side(k), cells => mortar%side(k)%cells)
      do i = 1, cells%n
        if (.not. side%p(i) > 0.0_wp) cycle
        e = cells%elem(i)
        nk = own%first(e + 1) - own%first(e)
        call element_functions(own, e, cells%xi(:, i), shp(:nk), dshp(:, :nk))
        at = 0.0_wp
        do j = 1, nk
          at = at + shp(j)*x(:, own%node(own%first(e) + j - 1))
        end do
        call vary_normal(cells%foot(i), at, n, dn)
        t = cells%weight(i)*own_share(contact)*side%p(i)*n
        call put_force(own, e, cells%xi(:, i), -t, f)
        call put_force(contact%side(3 - k), cells%foot(i)%elem, cells%foot(i)%xi, t, f)
      end do
    end associate
  end subroutine split_mortar_forces

end module contact_mortar
