!> Which surface elements are coupled by contact, and where their couplings stand in the tangent.
!!
!! Feet of a side's points on the other one, of those that act and, when a step ends, of the others.
module contact_active
  use contact_pair, only: surface_t, contact_t, contact_points_t
  use csr, only: block_matrix_t, clique_t
  use csr_coupling, only: coupling_map
  use base_kinds, only: wp
  use subcell_quadrature, only: acting, begin_cuts, is_cut, silence
  use contact_element, only: form_element
  use projection_type, only: foot_t, shape_t
  use projection, only: project
  use projection_search, only: grid_t
  use contact_history, only: side_positions
  use contact_work, only: work_t
  implicit none
  private
  public :: pairs_t, map_t, new_pairs, need_pair, find_pair, has_idle, prune_pairs, pair_clique, &
            map_pairs, find_feet, follow_silent

  !> Block positions of one pair.
  type :: map_t
    integer, allocatable :: at(:, :)     !! (nk, nl)
    integer, allocatable :: back(:, :)   !! (nl, nk) BALAnced: rows of the partner
    integer, allocatable :: there(:, :)  !! (nl, nl) its own
  end type map_t

  !> Pairs of an element of one side and one of the other. The list of an element is chained.
  type :: pairs_t
    integer :: n = 0
    integer, allocatable :: head(:)      !! (nelem) first pair of an element, 0: none
    integer, allocatable :: next(:)      !! (>= n) next pair of the same element
    integer, allocatable :: own(:)       !! (>= n) element of this side
    integer, allocatable :: partner(:)   !! (>= n) element of the other side
    integer, allocatable :: used(:)      !! (>= n) step in which it was needed last
    type(map_t), allocatable :: map(:)   !! (n) of the pattern as it stands
    type(map_t), allocatable :: self(:)  !! (nelem) of an element with itself, where it has pairs
  end type pairs_t

contains

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

  !> A pair is needed in a step; `grown` becomes true where it is new.
  subroutine need_pair(pairs, e, partner, step, grown)
    type(pairs_t), intent(inout) :: pairs
    integer, intent(in) :: e, partner, step
    logical, intent(inout) :: grown
    integer :: i

    i = find_pair(pairs, e, partner)
    if (i == 0) then
      grown = .true.
      i = pairs%n + 1
      if (i > size(pairs%next)) call grow(pairs)
      pairs%n = i
      pairs%own(i) = e
      pairs%partner(i) = partner
      pairs%next(i) = pairs%head(e)
      pairs%head(e) = i
    end if
    pairs%used(i) = step
  end subroutine need_pair

  subroutine grow(pairs)
    type(pairs_t), intent(inout) :: pairs
    integer :: n

    n = pairs%n
    pairs%next = [pairs%next, spread(0, 1, n)]
    pairs%own = [pairs%own, spread(0, 1, n)]
    pairs%partner = [pairs%partner, spread(0, 1, n)]
    pairs%used = [pairs%used, spread(0, 1, n)]
  end subroutine grow

  !> There are pairs that were not needed since a step.
  pure logical function has_idle(pairs, step)
    type(pairs_t), intent(in) :: pairs
    integer, intent(in) :: step

    has_idle = any(pairs%used(:pairs%n) < step)
  end function has_idle

  !> Forget the pairs that were not needed since a step.
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

  !> Nodes of all pairs, for the pattern; shorter lists are filled with their first node.
  subroutine pair_clique(pairs, own, other, whole, clique)
    type(pairs_t), intent(in) :: pairs
    type(surface_t), intent(in) :: own, other
    logical, intent(in) :: whole         !! the partners of an element are coupled too
    type(clique_t), intent(out) :: clique
    integer :: i, nk, nl, most

    if (whole) then
      call whole_clique(pairs, own, other, clique)
      return
    end if
    most = maxval(own%basis%nsf) + maxval(other%basis%nsf)
    allocate (clique%conn(most, pairs%n))
    do i = 1, pairs%n
      associate (e => pairs%own(i), p => pairs%partner(i))
        nk = own%first(e + 1) - own%first(e)
        nl = other%first(p + 1) - other%first(p)
        clique%conn(:, i) = own%node(own%first(e))
        clique%conn(:nk, i) = own%node(own%first(e):own%first(e + 1) - 1)
        clique%conn(nk + 1:nk + nl, i) = other%node(other%first(p):other%first(p + 1) - 1)
      end associate
    end do
  end subroutine pair_clique

  !> Nodes of each element that has pairs, and of all of its partners.
  subroutine whole_clique(pairs, own, other, clique)
    type(pairs_t), intent(in) :: pairs
    type(surface_t), intent(in) :: own, other
    type(clique_t), intent(out) :: clique
    integer :: e, i, m, n, npair(size(pairs%head))

    npair = 0
    do i = 1, pairs%n
      npair(pairs%own(i)) = npair(pairs%own(i)) + 1
    end do
    n = maxval(own%basis%nsf) + maxval(other%basis%nsf)*maxval([0, npair])
    allocate (clique%conn(n, count(npair > 0)))
    n = 0
    do e = 1, size(npair)
      if (npair(e) == 0) cycle
      n = n + 1
      clique%conn(:, n) = own%node(own%first(e))
      m = own%first(e + 1) - own%first(e)
      clique%conn(:m, n) = own%node(own%first(e):own%first(e + 1) - 1)
      i = pairs%head(e)
      do while (i > 0)
        associate (theirs => other%node(other%first(pairs%partner(i)): &
                                        other%first(pairs%partner(i) + 1) - 1))
          clique%conn(m + 1:m + size(theirs), n) = theirs
          m = m + size(theirs)
        end associate
        i = pairs%next(i)
      end do
    end do
  end subroutine whole_clique

  !> Positions of all pairs in a matrix.
  subroutine map_pairs(pairs, own, other, balanced, a)
    type(pairs_t), intent(inout) :: pairs
    type(surface_t), intent(in) :: own, other
    logical, intent(in) :: balanced      !! the partners' rows too
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

  !> Project the points of side k that act; elements that have come to be cut are told by the way.
  subroutine find_feet(contact, k, shape, grid, x, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape             !! of the other side
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)         !! (np)
    type(contact_points_t), intent(inout) :: points
    integer :: act(2), e, i

    if (points%fresh) call begin_cuts(contact, points)
    do e = 1, contact%side(k)%nelem
      act = acting(contact, points, e)
      call project_points(contact, k, shape, grid, x, e, act, feet, points)
      if (contact%nq == contact%nplain) cycle
      i = (e - 1)*contact%nq
      if (.not. points%cut(e)) then
        points%cut(e) = is_cut(contact, feet(i + 1:i + contact%nplain))
        act = acting(contact, points, e)
        if (points%cut(e)) call project_points(contact, k, shape, grid, x, e, act, feet, points)
      end if
      act = silent(contact, points, e)
      call silence(points, i + act(1), i + act(2))
    end do
  end subroutine find_feet

  !> First and last of the points of element e that do not act.
  pure function silent(contact, points, e) result(q)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: e
    integer :: q(2)

    q = [contact%nplain + 1, contact%nq]
    if (points%cut(e)) q = [1, contact%nplain]
  end function silent

  !> Points act(1) to act(2) of element e.
  subroutine project_points(contact, k, shape, grid, x, e, act, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e, act(2)
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    real(wp) :: xp(3, act(2) - act(1) + 1)
    integer :: i, q

    call side_positions(contact%side(k), e, x, xp, from=act(1) - 1)
    do q = act(1), act(2)
      i = (e - 1)*contact%nq + q
      associate (foot => feet(i))
        foot%elem = points%foot(i)
        foot%xi = points%foot_xi(:, i)
        call project(contact%side(3 - k), shape, grid, xp(:, q - act(1) + 1), foot, contact%depth)
        points%foot(i) = foot%elem
        points%foot_xi(:, i) = foot%xi
      end associate
    end do
  end subroutine project_points

  !> A step ends: the points that did not act get the feet and states they would have, so that they
  !! know where they stand when they do.
  subroutine follow_silent(contact, k, shape, grid, x, slides, feet, points, part)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)
    logical, intent(in) :: slides                  !! friction acts
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: part
    integer :: act(2), e, i

    if (contact%nq == contact%nplain) return
    do e = 1, contact%side(k)%nelem
      points%cut(e) = .not. points%cut(e)
      act = acting(contact, points, e)
      i = (e - 1)*contact%nq
      call project_points(contact, k, shape, grid, x, e, act, feet, points)
      call form_element(contact, k, e, x, feet(i + 1:i + contact%nq), slides, points, part)
      call silence(points, i + act(1), i + act(2))
      points%cut(e) = .not. points%cut(e)
    end do
  end subroutine follow_silent

end module contact_active
