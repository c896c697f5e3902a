!> Active contact pairs: projects the integration points of a side, and keeps the list of element
!! pairs that contact couples, with the positions of their couplings in the tangent.
module contact_active
  use base_kinds, only: wp
  use contact_element, only: form_element
  use contact_history, only: side_positions
  use contact_pair, only: surface_t, contact_t, contact_points_t
  use contact_work, only: work_t
  use csr, only: block_matrix_t, clique_t
  use csr_coupling, only: coupling_map
  use projection, only: project
  use projection_search, only: grid_t
  use projection_type, only: foot_t, shape_t
  use subcell_quadrature, only: acting, begin_refinement, is_refined, silence
  implicit none
  private
  public :: pairs_t, new_pairs, need_pair, find_pair, forget_need, has_idle, prune_pairs, &
            pair_clique, map_pairs, project_side, follow_silent

  !> Positions of the blocks of one pair in the tangent matrix. nk and nl are the numbers of nodes
  !! of the element and of its partner.
  type :: map_t
    integer, allocatable :: at(:, :)     !! (nk, nl) rows of the element
    integer, allocatable :: back(:, :)   !! (nl, nk) rows of the partner, if both sides are loaded
    integer, allocatable :: there(:, :)  !! (nl, nl) diagonal block of the partner, likewise
  end type map_t

  !> Pairs of an element of one side and an element of the other side. The pairs of an element form
  !! a linked list.
  type :: pairs_t
    integer :: n = 0
    integer, allocatable :: head(:)      !! (nelem) first pair of an element, 0: none
    integer, allocatable :: next(:)      !! (>= n) next pair of the same element
    integer, allocatable :: own(:)       !! (>= n) element of this side
    integer, allocatable :: partner(:)   !! (>= n) element of the other side
    integer, allocatable :: used(:)      !! (>= n) last step in which the pair was needed
    type(map_t), allocatable :: map(:)   !! (n) positions in the current pattern
    type(map_t), allocatable :: self(:)  !! (nelem) diagonal blocks of elements with pairs
  end type pairs_t

contains

  !> Make an empty list.
  subroutine new_pairs(pairs, nelem)
    type(pairs_t), intent(out) :: pairs
    integer, intent(in) :: nelem

    allocate (pairs%head(nelem), source=0)
    allocate (pairs%next(64), pairs%own(64), pairs%partner(64), pairs%used(64), source=0)
    allocate (pairs%map(0), pairs%self(nelem))
  end subroutine new_pairs

  !> Position of a pair; 0: there is none.
  pure integer function find_pair(pairs, e, partner) result(i)
    type(pairs_t), intent(in) :: pairs
    integer, intent(in) :: e, partner

    i = pairs%head(e)
    do while (i > 0)
      if (pairs%partner(i) == partner) return
      i = pairs%next(i)
    end do
  end function find_pair

  !> Mark a pair as needed in a step; `grown` becomes true if the pair is new.
  subroutine need_pair(pairs, e, partner, step, grown)
    type(pairs_t), intent(inout) :: pairs
    integer, intent(in) :: e, partner, step
    logical, intent(inout) :: grown
    integer :: i

    i = find_pair(pairs, e, partner)
    if (i == 0) then
      grown = .true.
      i = pairs%n + 1
      if (i > size(pairs%next)) then
        pairs%next = [pairs%next, spread(0, 1, pairs%n)]
        pairs%own = [pairs%own, spread(0, 1, pairs%n)]
        pairs%partner = [pairs%partner, spread(0, 1, pairs%n)]
        pairs%used = [pairs%used, spread(0, 1, pairs%n)]
      end if
      pairs%n = i
      pairs%own(i) = e
      pairs%partner(i) = partner
      pairs%next(i) = pairs%head(e)
      pairs%head(e) = i
    end if
    pairs%used(i) = step
  end subroutine need_pair

  !> Are there pairs that were last needed before `step`?
  pure logical function has_idle(pairs, step)
    type(pairs_t), intent(in) :: pairs
    integer, intent(in) :: step

    has_idle = any(pairs%used(:pairs%n) < step)
  end function has_idle

  !> Begin a step, or repeat it: no pair has been needed in this step so far.
  pure subroutine forget_need(pairs)
    type(pairs_t), intent(inout) :: pairs

    pairs%used(:pairs%n) = -1
  end subroutine forget_need

  !> Remove the pairs that were last needed before `step`.
  subroutine prune_pairs(pairs, step)
    type(pairs_t), intent(inout) :: pairs
    integer, intent(in) :: step
    integer :: e, i, m

    m = 0
    pairs%head = 0
    do i = 1, pairs%n
      if (pairs%used(i) < step) cycle
      m = m + 1
      e = pairs%own(i)
      pairs%own(m) = e
      pairs%partner(m) = pairs%partner(i)
      pairs%used(m) = pairs%used(i)
      pairs%next(m) = pairs%head(e)
      pairs%head(e) = m
    end do
    pairs%n = m
  end subroutine prune_pairs

  !> List the coupled nodes for the sparsity pattern. There is one column for each pair or, if the
  !! partners of an element are coupled to each other, one for each element that has pairs. Unused
  !! entries of a column repeat its first node.
  subroutine pair_clique(pairs, own, other, whole, clique)
    type(pairs_t), intent(in) :: pairs
    type(surface_t), intent(in) :: own, other
    logical, intent(in) :: whole         !! are the partners of an element coupled to each other?
    type(clique_t), intent(out) :: clique
    integer, allocatable :: mark(:)      ! the last column to which a node was appended
    integer, allocatable :: conn(:, :), length(:)
    integer :: e, i, n, npair(size(pairs%head))

    npair = 0
    do i = 1, pairs%n
      npair(pairs%own(i)) = npair(pairs%own(i)) + 1
    end do
    allocate (mark(max(maxval(own%node), maxval(other%node))), source=0)
    n = maxval(own%basis%nsf) + maxval(other%basis%nsf)*merge(maxval([0, npair]), 1, whole)
    allocate (conn(n, merge(count(npair > 0), pairs%n, whole)))
    allocate (length(size(conn, 2)), source=0)
    n = 0
    if (whole) then
      do e = 1, size(npair)
        if (npair(e) == 0) cycle
        n = n + 1
        call add(own, e)
        i = pairs%head(e)
        do while (i > 0)
          call add(other, pairs%partner(i))
          i = pairs%next(i)
        end do
      end do
    else
      do n = 1, pairs%n
        call add(own, pairs%own(n))
        call add(other, pairs%partner(n))
      end do
    end if
    allocate (clique%conn(maxval([0, length]), size(length)))
    do n = 1, size(length) ! unused entries repeat the first node
      clique%conn(:, n) = conn(1, n)
      clique%conn(:length(n), n) = conn(:length(n), n)
    end do

  contains

    !> Append the nodes of element e that column n does not contain yet.
    subroutine add(surface, e)
      type(surface_t), intent(in) :: surface
      integer, intent(in) :: e
      integer :: j

      do j = surface%first(e), surface%first(e + 1) - 1
        if (mark(surface%node(j)) == n) cycle
        mark(surface%node(j)) = n
        length(n) = length(n) + 1
        conn(length(n), n) = surface%node(j)
      end do
    end subroutine add
  end subroutine pair_clique

  !> Find the positions of all pairs in a matrix.
  subroutine map_pairs(pairs, own, other, balanced, a)
    type(pairs_t), intent(inout) :: pairs
    type(surface_t), intent(in) :: own, other
    logical, intent(in) :: balanced      !! include the rows of the partners
    type(block_matrix_t), intent(in) :: a
    integer :: i, nk, nl

    deallocate (pairs%map)
    allocate (pairs%map(pairs%n))
    do i = 1, size(pairs%self)
      if (allocated(pairs%self(i)%at)) deallocate (pairs%self(i)%at)
    end do
    do i = 1, pairs%n
      associate (e => pairs%own(i), p => pairs%partner(i))
        associate (mine => own%node(own%first(e):own%first(e + 1) - 1), &
                   theirs => other%node(other%first(p):other%first(p + 1) - 1))
          nk = size(mine)
          nl = size(theirs)
          allocate (pairs%map(i)%at(nk, nl))
          call coupling_map(a, mine, theirs, pairs%map(i)%at)
          if (balanced) then
            allocate (pairs%map(i)%back(nl, nk), pairs%map(i)%there(nl, nl))
            call coupling_map(a, theirs, mine, pairs%map(i)%back)
            call coupling_map(a, theirs, theirs, pairs%map(i)%there)
          end if
          if (allocated(pairs%self(e)%at)) cycle
          allocate (pairs%self(e)%at(nk, nk))
          call coupling_map(a, mine, mine, pairs%self(e)%at)
        end associate
      end associate
    end do
  end subroutine map_pairs

  !> Project the active points of side k; this may refine elements.
  subroutine project_side(contact, k, shape, grid, x, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape             !! shape of the other side
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)         !! (np) projections
    type(contact_points_t), intent(inout) :: points
    integer :: e, i

    if (points%new_step) call begin_refinement(contact, points)
    !$omp parallel do schedule(dynamic) private(i)
    do e = 1, contact%side(k)%nelem
      call project_points(contact, k, shape, grid, x, e, feet, points)
      if (contact%nq == contact%nplain) cycle
      i = (e - 1)*contact%nq
      if (.not. points%refined(e)) then
        points%refined(e) = is_refined(contact, feet(i + 1:i + contact%nplain))
        if (points%refined(e)) call project_points(contact, k, shape, grid, x, e, feet, points)
      end if
      if (points%refined(e)) then
        call silence(points, i + 1, i + contact%nplain)
      else
        call silence(points, i + contact%nplain + 1, i + contact%nq)
      end if
    end do
    !$omp end parallel do
  end subroutine project_side

  !> Project the active points of element e.
  subroutine project_points(contact, k, shape, grid, x, e, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    real(wp) :: xp(3, contact%nq)
    integer :: act(2), i, q

    act = acting(contact, points, e)
    call side_positions(contact%side(k), e, x, xp(:, act(1):act(2)), from=act(1) - 1)
    do q = act(1), act(2)
      i = (e - 1)*contact%nq + q
      associate (foot => feet(i))
        foot%elem = points%closest(i)
        foot%xi = points%closest_xi(:, i)
        call project(contact%side(3 - k), shape, grid, xp(:, q), foot, contact%depth)
        points%closest(i) = foot%elem
        points%closest_xi(:, i) = foot%xi
      end associate
    end do
  end subroutine project_points

  !> At the end of a step, find projections and states for the points that were not active, because
  !! these points may become active later.
  subroutine follow_silent(contact, k, shape, grid, x, slides, feet, points, work)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)
    logical, intent(in) :: slides                  !! friction acts
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: work
    integer :: act(2), e, i

    if (contact%nq == contact%nplain) return
    do e = 1, contact%side(k)%nelem
      points%refined(e) = .not. points%refined(e)
      act = acting(contact, points, e)
      i = (e - 1)*contact%nq
      call project_points(contact, k, shape, grid, x, e, feet, points)
      call form_element(contact, k, e, x, feet(i + 1:i + contact%nq), slides, points, work)
      call silence(points, i + act(1), i + act(2))
      points%refined(e) = .not. points%refined(e)
    end do
  end subroutine follow_silent

end module contact_active
