!> Contact in the global system: projects all points, finds the element pairs that contact couples,
!! and adds their forces and derivatives. When a step is accepted, it moves the sliding points.
module contact_assembly
  use base_comm, only: owns
  use base_kinds, only: wp
  use contact_active, only: pairs_t, new_pairs, need_pair, forget_need, has_idle, prune_pairs, &
                            pair_clique, map_pairs, project_side, follow_silent
  use contact_bond, only: needs_projection
  use contact_corners, only: deepest_corner
  use contact_element, only: form_element
  use contact_energy, only: measure_energy
  use contact_history, only: side_positions, mark_beside, BESIDE, accept_slides, enter_slide
  use contact_mortar, only: find_mortar, add_mortar
  use contact_pair, only: contact_t, contact_points_t, contact_state_t, is_integrated, MORTAR
  use contact_scatter, only: scatter_element
  use contact_work, only: work_t, new_work, loads_both
  use csr, only: block_matrix_t, clique_t
  use model, only: model_t, state_t
  use mortar_control, only: mortar_clique
  use mortar_results, only: accept_mortar, measure_corners, spread_cells
  use mortar_type, only: mortar_t, new_mortar
  use projection_search, only: grid_t, place_surfaces
  use projection_type, only: foot_t, shape_t, touches
  use rigid_surface, only: react
  use subcell_quadrature, only: acting
  use tensor, only: cross
  implicit none
  private
  public :: contact_work_t, new_contact_work, begin_contact, set_secant, set_patience, &
            find_contact, contact_cliques, map_contact, add_contact, accept_contact, &
            friction_acts, overlap_found, overlap_accepted, has_stale_cells, has_followed

  integer, parameter, public :: CLIQUES = 4  !! groups of couplings of each contact
  real(wp), parameter :: AT_ONCE = 1.0e-6_wp !! tolerance of AFTEr, relative to the time step

  !> Projections of the points of one side onto the other side.
  type :: feet_t
    type(foot_t), allocatable :: at(:)   !! (np)
  end type feet_t

  !> Work space of one contact.
  type :: contact_work_t
    integer :: step = -1                 !! step of the last projection
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(feet_t) :: feet(2)
    type(pairs_t) :: pairs(2)
    type(work_t) :: element(2)
    !> Surfaces at the start of the step. Points that come into contact in this step get their
    !! sliding points on these surfaces.
    logical :: started = .false.         !! the surfaces have been found in this step
    type(shape_t) :: start(2)
    type(grid_t) :: start_grid(2)
    type(mortar_t) :: mortar             !! work space of the mortar scheme
  end type contact_work_t

contains

  !> Work space of all contacts of a model.
  subroutine new_contact_work(model, work)
    type(model_t), intent(in) :: model
    type(contact_work_t), allocatable, intent(out) :: work(:)
    integer :: c, k

    allocate (work(size(model%contact)))
    do c = 1, size(work)
      do k = 1, 2
        associate (contact => model%contact(c))
          call new_pairs(work(c)%pairs(k), contact%side(k)%nelem)
          call new_work(contact, k, work(c)%element(k))
          if (.not. is_integrated(contact, k)) cycle
          allocate (work(c)%feet(k)%at(contact%nq*contact%side(k)%nelem))
        end associate
      end do
      if (model%contact(c)%scheme /= MORTAR) cycle
      associate (mesh => model%mesh)
        call new_mortar(model%contact(c), mesh%xr - spread(mesh%origin, 2, mesh%nnode), &
                        work(c)%mortar)
      end associate
    end do
  end subroutine new_contact_work

  !> Begin a step, or begin it again after a cut-back. The pattern of the step must not depend on
  !! the couplings of earlier attempts, because a restarted run does not know these attempts.
  pure subroutine begin_contact(work)
    type(contact_work_t), intent(inout) :: work(:)
    integer :: c, k

    do c = 1, size(work)
      work(c)%step = -1
      work(c)%started = .false.
      work(c)%mortar%step = -1
      do k = 1, 2
        call forget_need(work(c)%pairs(k))
      end do
    end do
  end subroutine begin_contact

  !> Choose whether the derivatives of friction are secants (see add_friction).
  pure subroutine set_secant(work, secant)
    type(contact_work_t), intent(inout) :: work(:)
    logical, intent(in) :: secant
    integer :: c

    do c = 1, size(work)
      work(c)%element%secant = secant
    end do
  end subroutine set_secant

  !> Choose whether cells may be cut more often in a frictional iteration that converges slowly.
  !! They may not while springs and anchors stabilise bodies.
  pure subroutine set_patience(work, patient)
    type(contact_work_t), intent(inout) :: work(:)
    logical, intent(in) :: patient
    integer :: c

    do c = 1, size(work)
      work(c)%mortar%patient = patient
    end do
  end subroutine set_patience

  !> Does friction act in this step? If the contact has friction, it acts in all steps that start at
  !! the time AFTEr or later.
  pure logical function friction_acts(contact, state) result(acts)
    type(contact_t), intent(in) :: contact
    type(state_t), intent(in) :: state

    acts = contact%friction%given .and. &
           state%time - state%dt >= contact%after - AT_ONCE*state%dt
  end function friction_acts

  !> Project all points. `grown` means that the pattern must be rebuilt, either because new elements
  !! are coupled, or because a step begins with fewer couplings. The pattern of a step must not
  !! depend on earlier steps, because a restarted run does not know their couplings.
  subroutine find_contact(work, model, state, grown, only_forces)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    logical, intent(out) :: grown
    logical, intent(in), optional :: only_forces !! skip the tangent (line search)
    real(wp), allocatable :: x(:, :)
    logical :: slides, trial
    integer :: c, k

    grown = .false.
    if (size(work) == 0) return
    trial = .false.
    if (present(only_forces)) trial = only_forces
    x = positions(model, state%u)
    do c = 1, size(work)
      associate (contact => model%contact(c))
        slides = friction_acts(contact, state)
        call place_surfaces(contact, x, work(c)%shape, work(c)%grid)
        if (contact%scheme == MORTAR) then
          call find_mortar(work(c)%mortar, contact, x, positions(model, state%u_step), state%step, &
                           slides, trial, work(c)%shape, work(c)%grid, state%contact(c), &
                           work(c)%pairs, grown)
        end if
        do k = 1, 2
          if (.not. is_integrated(contact, k)) cycle
          if (contact%scheme /= MORTAR) then
            call project_side(contact, k, work(c)%shape(3 - k), work(c)%grid(3 - k), x, &
                              work(c)%feet(k)%at, state%contact(c)%side(k))
            if (slides) call enter_slides(work(c), model, c, k, state%u_step, &
                                          state%contact(c)%side(k))
            call need_pairs(work(c), contact, k, x, state%contact(c)%side(k), slides, state%step, &
                            grown)
          end if
          if (work(c)%step /= state%step) grown = grown .or. has_idle(work(c)%pairs(k), state%step)
        end do
        work(c)%step = state%step
      end associate
    end do
  end subroutine find_contact

  !> Do the cells of a contact belong to other positions than those of find_contact, and will they
  !! be cut again? The forces of such cells may be in equilibrium by chance, for example where a
  !! surface has slid along another one.
  pure logical function has_stale_cells(work) result(yes)
    type(contact_work_t), intent(in) :: work(:)
    integer :: c

    yes = .false.
    do c = 1, size(work)
      yes = yes .or. work(c)%mortar%stale
    end do
  end function has_stale_cells

  !> Were cells of a contact with friction cut in the last find_contact because the iteration has
  !! settled? Their change is not part of the tangent.
  pure logical function has_followed(work) result(yes)
    type(contact_work_t), intent(in) :: work(:)
    integer :: c

    yes = .false.
    do c = 1, size(work)
      yes = yes .or. work(c)%mortar%follows
    end do
  end function has_followed

  !> Largest penetration of the mortar contacts at the positions of find_contact, relative to the
  !! size of the smallest facet.
  pure real(wp) function overlap_found(work) result(overlap)
    type(contact_work_t), intent(in) :: work(:)
    integer :: c, i, k

    overlap = 0.0_wp
    do c = 1, size(work)
      if (.not. work(c)%mortar%least > 0.0_wp) cycle
      do k = 1, 2
        associate (side => work(c)%mortar%side(k))
          if (.not. allocated(side%p)) cycle
          do i = 1, side%cells%n
            if (.not. side%p(i) > 0.0_wp) cycle
            overlap = max(overlap, -side%cells%foot(i)%gap/work(c)%mortar%least)
          end do
        end associate
      end do
    end do
  end function overlap_found

  !> Largest penetration of the mortar contacts at the end of the previous step, relative to the
  !! size of the smallest facet. In contrast to overlap_found, it includes the corners of elements.
  pure real(wp) function overlap_accepted(work, state) result(overlap)
    type(contact_work_t), intent(in) :: work(:)
    type(state_t), intent(in) :: state
    integer :: c

    overlap = 0.0_wp
    do c = 1, size(work)
      if (.not. work(c)%mortar%least > 0.0_wp) cycle
      overlap = max(overlap, maxval(state%contact(c)%penetration)/work(c)%mortar%least)
    end do
  end function overlap_accepted

  !> Give sliding points to the points that touch the other side and have none. In the first step,
  !! these are all points that touch; later, they are those that were far from the other side when
  !! the previous step was accepted.
  subroutine enter_slides(work, model, c, k, u_step, points)
    type(contact_work_t), intent(inout) :: work
    type(model_t), intent(in) :: model
    integer, intent(in) :: c, k                !! side k of contact c
    real(wp), intent(in) :: u_step(:, :)       !! (3, nnode) u at the start of the step [L]
    type(contact_points_t), intent(inout) :: points
    real(wp), allocatable :: x(:, :)
    integer :: i

    associate (contact => model%contact(c))
      do i = 1, size(points%slide)
        if (points%slide(i) > 0) cycle
        if (.not. touches(work%feet(k)%at(i), contact%depth)) cycle
        if (.not. allocated(x)) x = positions(model, u_step)
        if (.not. work%started) call place_surfaces(contact, x, work%start, work%start_grid)
        work%started = .true.
        call enter_slide(contact, k, work%start(3 - k), work%start_grid(3 - k), x, i, points)
      end do
    end associate
  end subroutine enter_slides

  !> Mark the pairs of elements that bonded points and points in contact couple.
  subroutine need_pairs(work, contact, k, x, points, slides, step, grown)
    type(contact_work_t), intent(inout) :: work
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, step
    real(wp), intent(in) :: x(:, :)
    type(contact_points_t), intent(in) :: points
    logical, intent(in) :: slides
    logical, intent(inout) :: grown
    real(wp) :: p, dp, energy, xp(3, contact%nq)
    integer :: act(2), e, i, q
    logical :: needed

    do e = 1, contact%side(k)%nelem
      if (contact%on_pair) call side_positions(contact%side(k), e, x, xp)
      act = acting(contact, points, e)
      do q = act(1), act(2)
        i = (e - 1)*contact%nq + q
        if (points%bond(i) > 0) then
          call need_pair(work%pairs(k), e, points%bond(i), step, grown)
          call needs_projection(contact, contact%side(3 - k), x, i, xp(:, q), points, &
                                work%element(k), needed)
          if (.not. needed) cycle
        end if
        associate (foot => work%feet(k)%at(i))
          if (.not. touches(foot, contact%depth)) cycle
          call contact%normal%law%normal(contact%normal%prop, foot%gap, points%multiplier(i), p, &
                                         dp, energy)
          if (.not. p > 0.0_wp) cycle
          call need_pair(work%pairs(k), e, foot%elem, step, grown)
          if (slides .and. points%slide(i) > 0) then
            call need_pair(work%pairs(k), e, points%slide(i), step, grown)
          end if
        end associate
      end do
    end do
  end subroutine need_pairs

  !> List the couplings for the sparsity pattern, in CLIQUES groups for each contact, and remove the
  !! pairs that this step does not need.
  subroutine contact_cliques(work, model, step, clique)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    integer, intent(in) :: step
    type(clique_t), intent(out) :: clique(:) !! (CLIQUES*size(work))
    integer :: c, k

    do c = 1, size(work)
      do k = 1, 2
        call prune_pairs(work(c)%pairs(k), step)
        associate (contact => model%contact(c))
          call pair_clique(work(c)%pairs(k), contact%side(k), contact%side(3 - k), &
                           loads_both(contact) .and. contact%friction%given, &
                           clique(CLIQUES*(c - 1) + k))
          if (contact%scheme == MORTAR .and. is_integrated(contact, k)) then
            call mortar_clique(work(c)%mortar, k, clique(CLIQUES*(c - 1) + 2 + k))
          else
            allocate (clique(CLIQUES*(c - 1) + 2 + k)%conn(0, 0))
          end if
        end associate
      end do
    end do
  end subroutine contact_cliques

  !> Find the positions of all couplings in a new matrix.
  subroutine map_contact(work, model, a)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    type(block_matrix_t), intent(in) :: a
    integer :: c, k

    do c = 1, size(work)
      do k = 1, 2
        associate (contact => model%contact(c))
          call map_pairs(work(c)%pairs(k), contact%side(k), contact%side(3 - k), &
                         loads_both(contact), a)
        end associate
      end do
    end do
  end subroutine map_contact

  !> Add the forces and derivatives of all contacts, at the projections of find_contact.
  subroutine add_contact(work, model, state, a, f, rounding, largest, only_forces)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(block_matrix_t), intent(inout) :: a
    real(wp), intent(inout) :: f(:, :)             !! (3, nnode) internal forces [F]
    real(wp), intent(inout) :: rounding, largest   !! see sweep_t
    logical, intent(in), optional :: only_forces   !! with MORTar, skip the tangent
    real(wp), allocatable :: x(:, :)
    logical :: tangent
    integer :: c, k

    if (size(work) == 0) return
    tangent = .true.
    if (present(only_forces)) tangent = .not. only_forces
    x = positions(model, state%u)
    do c = 1, size(work)
      state%contact(c)%force = 0.0_wp
      state%contact(c)%moment = 0.0_wp
      do k = 1, 2
        if (.not. is_integrated(model%contact(c), k)) cycle
        state%contact(c)%side(k)%dt = state%dt
        if (model%contact(c)%scheme == MORTAR) then
          call add_mortar(work(c)%mortar, model%contact(c), k, x, state%u, state%dt, &
                          tangent, state%contact(c), work(c)%pairs(k), work(c)%element(k), a, f, &
                          rounding, largest)
          cycle
        end if
        call add_side(work(c), model%contact(c), k, x, friction_acts(model%contact(c), state), &
                      state%u, state%contact(c), a, f, rounding, largest)
      end do
      do k = 1, 2
        associate (force => state%contact(c)%force(:, k), moment => state%contact(c)%moment(:, k))
          moment = moment + cross(model%mesh%origin, force)
        end associate
      end do
    end do
  end subroutine add_contact

  !> Positions relative to the origin of the model. Differences of reference positions are used, so
  !! that small displacements are not lost to rounding in a model far from the origin of its
  !! coordinates.
  pure function positions(model, u) result(x)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) [L]
    real(wp) :: x(3, size(u, 2))         !! [L]
    integer :: n

    do n = 1, size(u, 2)
      x(:, n) = (model%mesh%xr(:, n) - model%mesh%origin) + u(:, n)
    end do
  end function positions

  !> Add the forces and derivatives of one side of one contact.
  subroutine add_side(work, contact, k, x, slides, u, state, a, f, rounding, largest)
    type(contact_work_t), intent(inout) :: work
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: x(:, :), u(:, :)
    logical, intent(in) :: slides
    type(contact_state_t), intent(inout) :: state
    type(block_matrix_t), intent(inout) :: a
    real(wp), intent(inout) :: f(:, :), rounding, largest
    integer :: e, i

    associate (part => work%element(k))
      do e = 1, contact%side(k)%nelem
        i = (e - 1)*contact%nq
        call form_element(contact, k, e, x, work%feet(k)%at(i + 1:i + contact%nq), slides, &
                          state%side(k), part)
        if (part%npartner == 0) cycle
        if (contact%side(3 - k)%rigid) then
          call react(contact%side(3 - k), work%feet(k)%at(i + 1:i + contact%nq), state%side(k), &
                     i, f)
        end if
        call scatter_element(contact, k, e, part, work%pairs(k), x, u, owns(e), state, a, f, &
                             rounding, largest)
      end do
    end associate
    state%side(k)%new_step = .false.
  end subroutine add_side

  !> Accept a step: find the energies and the penetration of the corners, and move the stored
  !! sliding points.
  subroutine accept_contact(work, model, state)
    type(contact_work_t), intent(inout) :: work(:)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: x(:, :)
    integer :: c, k

    if (size(work) == 0) return
    x = positions(model, state%u)
    do c = 1, size(work)
      associate (contact => model%contact(c), point => state%contact(c)%side)
        do k = 1, 2
          if (.not. is_integrated(contact, k)) cycle
          if (contact%scheme == MORTAR) then
            call accept_mortar(work(c)%mortar, contact, k, work(c)%shape, work(c)%grid, &
                               state%contact(c))
            cycle
          end if
          call follow_silent(contact, k, work(c)%shape(3 - k), work(c)%grid(3 - k), x, &
                             friction_acts(contact, state), work(c)%feet(k)%at, point(k), &
                             work(c)%element(k))
          call measure_energy(contact, k, state%contact(c))
          call mark_beside(work(c)%feet(k)%at, BESIDE*contact%depth, point(k))
          call accept_slides(contact%scheme, contact%side(k), contact%side(3 - k), &
                             work(c)%shape(3 - k), x, work(c)%feet(k)%at, point(k))
          state%contact(c)%penetration(k) = deepest_corner(contact, k, work(c)%shape, &
                                                           work(c)%grid(3 - k), point(k))
        end do
        if (contact%scheme == MORTAR) then
          call measure_corners(work(c)%mortar, contact, work(c)%shape, work(c)%grid, &
                               state%contact(c))
          call spread_cells(work(c)%mortar, contact, work(c)%shape, state%contact(c))
        end if
      end associate
    end do
  end subroutine accept_contact

end module contact_assembly
