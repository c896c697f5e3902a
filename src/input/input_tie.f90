!> TIE: nodes at the same position become one node, the one with the lowest number.
!!
!! The default tolerance is FEAP's: in each direction, 1e-3 times the extent of the mesh, divided by
!! the square root of the number of nodes.
!!
!! Source: FEAPpv's manual
module input_tie
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_sort, only: sort_index, unique
  use base_text, only: to_text
  use constraint, only: join_constraints
  use input_draft, only: draft_t, tie_entry_t
  use mesh, only: mesh_t, is_rigid
  implicit none
  private
  public :: find_tied, tie_nodes, tie_tolerance

  real(wp), parameter :: TOLERANCE = 1.0e-3_wp
  integer, parameter :: PER_CELL = 4, MOST_CELLS = 200 !! mean number of nodes in a cell; largest
  !! number of cells in a direction

  !> Search grid: each cell lists those of its nodes that are not replaced by another node. Cells
  !! are at least twice as wide as the tolerance, unless there is only one.
  type :: grid_t
    real(wp) :: low(3), width(3)       !! origin of the grid, size of a cell [L]
    real(wp) :: tol(3)                 !! largest distance of tied nodes in each direction [L]
    integer :: cells(3)
    integer, allocatable :: head(:, :, :), next(:)
  end type grid_t

contains

  !> Find for each node the node that replaces it after all TIE records: itself, or one with a lower
  !! number.
  subroutine find_tied(draft, mesh, new)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: new(:) !! (nnode)
    integer, allocatable :: before(:) ! (nnode)
    logical, allocatable :: acts(:)   ! (nnode) has a node that the record selects been joined?
    logical, allocatable :: idle(:)   ! (records) does a record join no nodes?
    logical, allocatable :: loose(:)  ! (nnode) joined within the default tolerance
    integer :: i, n

    new = [(n, n=1, mesh%nnode)]
    if (size(draft%tie) == 0) return
    allocate (idle(size(draft%tie)), acts(mesh%nnode))
    allocate (loose(mesh%nnode), source=.false.)
    do i = 1, size(draft%tie)
      before = new
      call find_pairs(draft, draft%tie(i), mesh, new, acts)
      idle(i) = .not. any(acts)
      if (.not. draft%tie(i)%tolerance > 0.0_wp) loose = loose .or. new /= before
    end do
    n = count(new /= [(i, i=1, mesh%nnode)])
    call log_line('TIE       joins '//to_text(n)//' nodes with others')
    do i = 1, size(idle)
      if (.not. idle(i)) cycle
      call warn(trim(merge('TIE     ', 'this TIE', n == 0))//' joins no nodes', &
                draft%tie(i)%place, 'check the positions: no two of the nodes that TIE selects ' &
                //'coincide')
      if (n == 0) exit
    end do
    do n = 1, mesh%nnode
      new(n) = new(new(n)) ! numbers only decrease, so the target is final
    end do
    call warn_distant(draft, mesh, new, loose)
  end subroutine find_tied

  !> Warn if the default tolerance, which is a fraction of the extent of the whole mesh, joins nodes
  !! across a gap that is not small compared with their elements.
  subroutine warn_distant(draft, mesh, new, loose)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: new(:)          !! (nnode)
    logical, intent(in) :: loose(:)        !! (nnode) joined within the default tolerance
    real(wp), parameter :: VISIBLE = 0.05_wp !! distance over element size above which to warn
    real(wp) :: distance(mesh%nnode), edge(mesh%nnode), length
    integer :: a, b, e, i, n, worst

    distance = [(norm2(mesh%xr(:, n) - mesh%xr(:, new(n))), n=1, mesh%nnode)]
    where (.not. loose) distance = 0.0_wp
    if (.not. any(distance > 0.0_wp)) return
    edge = huge(edge) ! shortest distance to another node of an element
    do b = 1, size(mesh%block)
      do i = 1, mesh%block(b)%nelem
        associate (node => mesh%block(b)%conn(:, i))
          do e = 2, size(node)
            do a = 1, e - 1
              length = norm2(mesh%xr(:, node(a)) - mesh%xr(:, node(e)))
              if (.not. length > 0.0_wp) cycle ! a collapsed element
              if (new(node(a)) == new(node(e))) return ! another check refuses such elements
              edge(node(a)) = min(edge(node(a)), length)
              edge(node(e)) = min(edge(node(e)), length)
            end do
          end do
        end associate
      end do
    end do
    worst = maxloc(distance/min(edge, edge(new)), 1)
    if (.not. distance(worst) > VISIBLE*min(edge(worst), edge(new(worst)))) return
    call warn('TIE joins nodes that are '//to_text(distance(worst), 3) &
              //' apart in elements of size '//to_text(min(edge(worst), edge(new(worst))), 3), &
              draft%tie(1)%place, 'the default tolerance is a fraction of the mesh extent; ' &
              //"give a smaller one in the fifth field of TIE, such as 'TIE,,,,tolerance'")
  end subroutine warn_distant

  !> Replace tied nodes in elements, constraints and bodies, and update `used` of the mesh.
  subroutine tie_nodes(new, mesh)
    integer, intent(in) :: new(:) !! (nnode)
    type(mesh_t), intent(inout) :: mesh
    integer, allocatable :: order(:)
    integer :: i, n, b

    if (all(new == [(n, n=1, mesh%nnode)])) return
    mesh%used = .false.
    do b = 1, size(mesh%block)
      do i = 1, mesh%block(b)%nelem
        mesh%block(b)%conn(:, i) = new(mesh%block(b)%conn(:, i))
        mesh%used(mesh%block(b)%conn(:, i)) = .true.
      end do
    end do
    call join_constraints(mesh%constraint, new)
    do b = 1, size(mesh%body)
      associate (body => mesh%body(b)) ! keep each node once, with the faces of all nodes tied to it
        if (allocated(body%group)) then
          do i = 1, size(body%group)
            body%group(i)%node = unique(new(body%group(i)%node))
          end do
        end if
        if (allocated(body%label)) deallocate (body%label)
        body%node = new(body%node)
        if (allocated(order)) deallocate (order)
        allocate (order(size(body%node)))
        call sort_index(body%node, order)
        body%mask = body%mask(order)
        body%node = body%node(order)
        n = min(1, size(order))
        do i = 2, size(order)
          if (body%node(i) == body%node(n)) then
            body%mask(n) = ior(body%mask(n), body%mask(i))
          else
            n = n + 1
            body%node(n) = body%node(i)
            body%mask(n) = body%mask(i)
          end if
        end do
        body%node = body%node(:n)
        body%mask = body%mask(:n)
      end associate
    end do
  end subroutine tie_nodes

  !> Find for each node the node that replaces it after one TIE record.
  subroutine find_pairs(draft, tie, mesh, new, acts)
    type(draft_t), intent(in) :: draft
    type(tie_entry_t), intent(in) :: tie
    type(mesh_t), intent(in) :: mesh
    integer, intent(inout) :: new(:) !! (nnode)
    logical, intent(out) :: acts(:)  !! (nnode) the record selects the node, and it is joined now
    type(grid_t) :: grid
    integer, allocatable :: class(:) ! (nnode) 0: not tied; bits 0 and 1: two materials
    real(wp) :: high(3)
    integer :: b, d, e, m, n, number, at(3)

    acts = .false.
    if (.not. any(mesh%used)) return
    do d = 1, 3
      grid%low(d) = minval(mesh%xr(d, :), mesh%used)
      high(d) = maxval(mesh%xr(d, :), mesh%used)
    end do
    grid%tol = (high - grid%low)*tie_tolerance(tie, mesh%nnode)
    grid%cells = max(1, min(MOST_CELLS, int((real(mesh%nnode, wp)/PER_CELL)**(1.0_wp/3.0_wp))))
    grid%width = (high - grid%low)/grid%cells
    where (grid%width < 2.0_wp*grid%tol .or. .not. grid%width > 0.0_wp)
      grid%cells = 1
      grid%width = max(high - grid%low, tiny(1.0_wp))
    end where
    allocate (grid%head(grid%cells(1), grid%cells(2), grid%cells(3)), source=0)
    allocate (grid%next(mesh%nnode), source=0)
    allocate (class(mesh%nnode), source=0)
    do b = 1, size(mesh%block)
      number = 0 ! no material, because the body is rigid
      if (.not. is_rigid(mesh%block(b))) then
        number = draft%model%material(mesh%block(b)%material)%number
      end if
      if (tie%material(1) > 0 .and. all(tie%material /= number)) cycle
      do e = 1, mesh%block(b)%nelem
        associate (c => class(mesh%block(b)%conn(:, e)))
          class(mesh%block(b)%conn(:, e)) = ior(c, merge(2, 1, number == tie%material(2)))
        end associate
      end do
    end do
    where ([(n < tie%from .or. n > tie%to, n=1, mesh%nnode)]) class = 0
    d = tie%direction
    if (d > 0) then
      where (abs(mesh%xr(d, :) - tie%coordinate) > grid%tol(d)) class = 0
    end if
    do n = 1, mesh%nnode ! a node stands for those that earlier records have joined with it
      m = root(new, n)
      class(m) = ior(class(m), class(n))
    end do
    do n = 1, mesh%nnode
      if (class(n) == 0 .or. new(n) /= n) cycle
      at = max(1, min(grid%cells, int((mesh%xr(:, n) - grid%low)/grid%width) + 1))
      call join(grid, tie, mesh, n, at, class, new)
      if (new(n) == n) then
        grid%next(n) = grid%head(at(1), at(2), at(3))
        grid%head(at(1), at(2), at(3)) = n
      end if
    end do
    do n = 1, mesh%nnode
      if (new(n) /= n) acts([n, root(new, n)]) = .true.
    end do
    acts = acts .and. class > 0
  end subroutine find_pairs

  !> In each direction, nodes are tied if they are not farther apart than this fraction of the
  !! extent of the mesh.
  pure real(wp) function tie_tolerance(tie, nnode) result(fraction)
    type(tie_entry_t), intent(in) :: tie
    integer, intent(in) :: nnode

    fraction = tie%tolerance
    if (.not. fraction > 0.0_wp) fraction = TOLERANCE/sqrt(real(nnode, wp))
  end function tie_tolerance

  !> Join node n, which lies in cell `at`, with a listed node at its position, if there is one. If
  !! nodes of one material are tied to those of another one, it joins all of them: several bodies of
  !! the first material may meet at one node of the second, whatever their order.
  subroutine join(grid, tie, mesh, n, at, class, new)
    type(grid_t), intent(in) :: grid
    type(tie_entry_t), intent(in) :: tie
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: n, at(3)
    integer, intent(inout) :: class(:), new(:) !! (nnode)
    integer :: i, j, k, m, low, high

    do k = max(1, at(3) - 1), min(grid%cells(3), at(3) + 1)
      do j = max(1, at(2) - 1), min(grid%cells(2), at(2) + 1)
        do i = max(1, at(1) - 1), min(grid%cells(1), at(1) + 1)
          m = grid%head(i, j, k)
          do while (m > 0)
            low = min(root(new, m), root(new, n))
            high = max(root(new, m), root(new, n))
            if (low < high .and. all(abs(mesh%xr(:, n) - mesh%xr(:, m)) <= grid%tol)) then
              if (tie%material(1) == tie%material(2)) then
                new(n) = m
                return
              end if
              if (ior(class(low), class(high)) == 3) then
                new(high) = low
                class(low) = 3
              end if
            end if
            m = grid%next(m)
          end do
        end do
      end do
    end do
  end subroutine join

  !> The node that replaces node n.
  pure integer function root(new, n) result(m)
    integer, intent(in) :: new(:)        !! (nnode)
    integer, intent(in) :: n

    m = n
    do while (new(m) /= m)
      m = new(m)
    end do
  end function root

end module input_tie
