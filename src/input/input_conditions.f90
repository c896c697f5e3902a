!> Conditions at nodes and control points, which are given by number or by position.
!!
!! The order is that of FEAP: BOUN, FORC, DISP and FPRO act as they are read; then the records of
!! EBOU, EDIS, EFOR, EPRO, CBOU, CFOR, CDIS and CSUR act, in this order of the words; the records of
!! one word act in deck order.
!!
!! Nodes that TIE joins share the conditions that BOUN, FORC, DISP and FPRO give to any of them, and
!! count as one node for the words that find nodes by their position. Different displacements, or
!! loads of different load numbers, cannot be shared.
module input_conditions
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_sort, only: unique
  use base_text, only: to_text
  use boundary, only: boundary_t, note_load_number, place_of_number
  use input_draft, only: draft_t, condition_entry_t, C_FIXED, C_VALUE, C_FORCE, C_TABLE
  use input_plane, only: plane_t, warn_plane
  use input_surface, only: mark_surface, load_surface
  use input_where, only: equally_near, warn_between, warn_far, warn_rigid
  use mesh, only: mesh_t, solid_nodes
  use word_position, only: R_EBOU, R_EDIS, R_EFOR, R_EPRO, R_CBOU, R_CFOR, R_CDIS, R_CSUR
  implicit none
  private
  public :: apply_conditions, kind_of, mark, mark_active

  real(wp), parameter :: PLANE = 1.0e-3_wp  !! default distance from a plane within which nodes
  !! are selected (FEAP), relative to the extent of the mesh; for EBOUndary and EPROportional it is
  !! divided by the square root of the number of nodes
  real(wp), parameter :: POINT_GAP = 1.0e-10_wp !! default difference of the squared distances of
  !! nodes that are equally near to a point, relative to the square of the extent (FEAP)

  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! displacements whose relative difference is less
  !! are equal

  !> Names of the words R_EBOU to R_CSUR; then, for C_FIXED to C_TABLE, names of the words that give
  !! these conditions by node number.
  character(13), parameter, public :: &
    WORDS(8) = ['EBOUndary    ', 'EDISplacement', 'EFORce       ', 'EPROportional', &
                'CBOUndary    ', 'CFORce       ', 'CDISplacement', 'CSURface     '], &
    NODAL_WORDS(4) = ['BOUNdary     ', 'DISPlacement ', 'FORCe        ', 'FPROportional']
  !> Names of their values.
  character(13), parameter :: &
    VALUES(4) = ['restraint    ', 'displacement ', 'force        ', 'load number  ']

contains

  !> Set the conditions of the deck in `bc`; errors go to `draft%errors`.
  subroutine apply_conditions(draft, mesh, new, bc)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh !! before TIE
    integer, intent(in) :: new(:)    !! (nnode) the node that replaces each node after TIE
    type(boundary_t), intent(inout) :: bc
    logical, allocatable :: active(:)
    type(error_t), allocatable :: error
    real(wp), allocatable :: before(:, :), force(:, :), value(:, :)
    real(wp), allocatable :: others(:, :) ! (3, nnode) conditions before the records of a word
    logical :: may_lose, replaces, said(R_CSUR) ! one warning per word
    integer :: word, i, n

    allocate (bc%fixed(3, mesh%nnode), bc%table(3, mesh%nnode), source=0)
    allocate (bc%value(3, mesh%nnode), bc%force(3, mesh%nnode), source=0.0_wp)
    allocate (bc%numbered(mesh%nnode), source=.false.)
    if (allocated(draft%nodes%given)) then
      n = min(mesh%nnode, size(draft%nodes%given))
      bc%fixed(:, :n) = abs(draft%nodes%code(:, :n))
      bc%table(:, :n) = draft%nodes%table(:, :n)
      bc%numbered(:n) = draft%nodes%numbered(:n)
      bc%value(:, :n) = draft%nodes%value(:, :n)
      bc%force(:, :n) = draft%nodes%force(:, :n)
    end if
    do i = 1, draft%named_nodes%place%n ! nodes that records name
      n = draft%named_nodes%node(i)
      if (n > draft%nodes%top .and. n <= mesh%nnode) cycle ! the node belongs to a patch
      if (n <= draft%nodes%top) then
        if (draft%nodes%given(n)) cycle
      end if
      call fail(error, DECK_ERROR, 'node '//to_text(n)//' is not defined', &
                draft%named_nodes%place%at(i), 'define it with COORdinates or BLOCk; the ' &
                //'largest node number is '//to_text(mesh%nnode))
      call draft%errors%add(error)
    end do
    call mark_active(draft, mesh, active)
    call share_conditions(draft, mesh, active, new, bc)
    force = bc%force
    value = bc%value
    said = .false.
    do word = R_EBOU, R_CSUR
      call get_condition(bc, kind_of(word), others)
      replaces = any(abs(others) > 0.0_wp)
      do i = 1, draft%ncondition
        if (draft%condition(i)%word /= word) cycle
        may_lose = .false.
        if (.not. said(word)) may_lose = replaces_later(draft, i)
        if (may_lose) call get_condition(bc, kind_of(word), before)
        call apply(draft%condition(i), mesh, active, new, bc, error)
        if (allocated(error)) then
          call draft%errors%add(error)
        else if (may_lose) then
          call warn_replaced(draft, i, mesh, active, new, bc, before, said(word))
        end if
        if (replaces .and. .not. (said(word) .or. allocated(error))) then
          call warn_default(draft%condition(i), mesh, active, new, bc, others, said(word))
        end if
      end do
    end do
    call warn_idle_numbers(draft, mesh, active, new, bc)
    call warn_idle_nodal_numbers(draft, new, bc)
    if (.not. allocated(bc%rival)) return
    where (.not. (bc%split .or. abs(bc%force - force) > 0.0_wp .or. &
                  abs(bc%value - value) > 0.0_wp)) bc%rival = -1 ! no load by position at the node
  end subroutine apply_conditions

  !> Give each node the conditions of the nodes that it replaces after TIE: restraints are combined,
  !! and forces are added. The load number is that of the first node with a force or a displacement
  !! or, if there is none, the first that is not 0.
  subroutine share_conditions(draft, mesh, active, new, bc)
    type(draft_t), intent(inout) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    integer, intent(in) :: new(:) !! (nnode)
    type(boundary_t), intent(inout) :: bc
    logical, allocatable :: acts(:, :) ! (3, nnode) there is a force or displacement
    logical, allocatable :: set(:) ! (nnode) EDIS or CDIS replaces the displacement of DISP
    logical, allocatable :: on(:)
    type(error_t), allocatable :: error
    logical :: differ(3), takes(3)
    integer :: i, n

    if (all(new == [(n, n=1, size(new))])) return
    allocate (set(size(new)), source=.false.)
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (r%adds .or. kind_of(r%word) /= C_VALUE) cycle
        call mark(mesh, r, active, on)
        set = set .or. on
      end associate
    end do
    acts = abs(bc%value) > 0.0_wp .or. abs(bc%force) > 0.0_wp
    do n = 1, size(new)
      associate (m => new(n))
        if (m == n) cycle
        if (.not. (allocated(error) .or. any(set([m, n])))) then
          call check_displacements(draft, bc, m, n, error)
        end if
        takes = .not. acts(:, m) .and. (acts(:, n) .or. bc%table(:, m) == 0)
        differ = bc%table(:, m) /= bc%table(:, n) .and. (acts(:, m) .or. bc%table(:, m) > 0) &
                 .and. (acts(:, n) .or. bc%table(:, n) > 0)
        if (any(differ)) then
          if (.not. allocated(bc%rival)) then
            allocate (bc%rival(3, size(new)), source=-1)
            allocate (bc%split(3, size(new)), source=.false.)
            bc%tied = draft%tie(1)%place
          end if
          where (differ .and. .not. bc%split(:, m))
            bc%rival(:, m) = merge(bc%table(:, m), bc%table(:, n), takes)
            bc%split(:, m) = acts(:, m) .and. acts(:, n)
          end where
        end if
        where (takes) bc%table(:, m) = bc%table(:, n)
        bc%numbered(m) = bc%numbered(m) .or. bc%numbered(n)
        acts(:, m) = acts(:, m) .or. acts(:, n)
        where (.not. abs(bc%value(:, m)) > 0.0_wp) bc%value(:, m) = bc%value(:, n)
        bc%fixed(:, m) = max(bc%fixed(:, m), bc%fixed(:, n))
        bc%force(:, m) = bc%force(:, m) + bc%force(:, n)
        bc%force(:, n) = 0.0_wp
      end associate
    end do
    if (allocated(error)) call draft%errors%add(error)
  end subroutine share_conditions

  !> Fail if the displacements of two nodes that TIE joins contradict each other. A node that BOUN
  !! restrains and that no record moves has the displacement 0.
  subroutine check_displacements(draft, bc, m, n, error)
    type(draft_t), intent(in) :: draft
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: m, n
    type(error_t), allocatable, intent(out) :: error
    logical :: both ! both nodes have a displacement
    integer :: d

    associate (u => bc%value(:, m), v => bc%value(:, n))
      do d = 1, 3
        both = abs(u(d)) > 0.0_wp .and. abs(v(d)) > 0.0_wp .or. &
               all(bc%fixed(d, [m, n]) /= 0)
        if (.not. both) cycle
        if (abs(u(d) - v(d)) <= ROUNDING*max(norm2(u), norm2(v))) cycle
        call fail(error, DECK_ERROR, 'TIE joins nodes '//to_text(m)//' and '//to_text(n) &
                  //', whose prescribed displacements in direction '//to_text(d)//' are ' &
                  //to_text(u(d))//' and '//to_text(v(d)), draft%tie(1)%place, &
                  'give both nodes the same DISPlacement, restrain only one of them, or leave ' &
                  //'both out of TIE')
        return
      end do
    end associate
  end subroutine check_displacements

  !> Mark the nodes that FEAP would find. These are all nodes with a position, except control points
  !! that only define geometry and nodes of rigid patches, which MOVE moves.
  subroutine mark_active(draft, mesh, active)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: active(:)
    integer :: n

    call solid_nodes(mesh, active)
    n = draft%nodes%top
    if (n > 0) active(:n) = active(:n) .or. (draft%nodes%given(:n) .and. .not. mesh%is_control(:n))
  end subroutine mark_active

  !> Apply one record to the nodes that it finds.
  subroutine apply(r, mesh, active, new, bc, error)
    type(condition_entry_t), intent(in) :: r
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    integer, intent(in) :: new(:) !! (nnode)
    type(boundary_t), intent(inout) :: bc
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: on(:), near(:)
    type(plane_t) :: plane
    logical :: kept ! the surface keeps restraints that the record does not give
    integer :: n

    call mark(mesh, r, active, on)
    if (any(on) .and. .not. allocated(r%surface)) then
      if (r%direction == 0) then
        call warn_far(mesh, r%at, findloc(on, .true., 1), r%place)
        call warn_rigid(mesh, r%at, findloc(on, .true., 1), r%place)
        near = active
        call equally_near(mesh, r%at, near)
        if (.not. (takes_all_near(r%word) .and. r%gap >= 0.0_wp)) then
          call warn_between(mesh, near, takes_all_near(r%word), r%place)
        end if
        if (.not. takes_all_near(r%word)) call warn_untied_point(mesh, near, new, r)
      else
        plane%direction = r%direction
        plane%gap = plane_gap(mesh, r, active)
        plane%gap_is_given = r%gap >= 0.0_wp
        plane%place = r%place
        plane%hint = 'give a smaller distance with GAP'
        call warn_plane(mesh, plane, on, new)
      end if
    end if
    if (.not. any(active)) then
      call fail(error, DECK_ERROR, 'the mesh has no nodes', r%place)
      return
    else if (.not. any(on) .and. r%direction > 0) then
      associate (x => mesh%xr(r%direction, :))
        call fail(error, DECK_ERROR, 'no node lies on the plane x'//to_text(r%direction)//' = ' &
                  //to_text(r%at(1)), r%place, 'the mesh extends from ' &
                  //to_text(minval(x, active))//' to '//to_text(maxval(x, active)) &
                  //' in that direction')
      end associate
      return
    else if (r%word == R_CSUR .and. allocated(r%surface)) then
      call load_surface(mesh, r, on, new, bc, error)
      return
    else if (.not. any(on)) then
      call fail(error, DECK_ERROR, 'no node lies on the surface', r%place, &
                'widen the search with GAP d')
      return
    end if
    do n = 1, mesh%nnode
      if (on(n)) on(new(n)) = .true. ! new(n) <= n, so the loop has passed it
    end do
    if (r%word == R_EPRO) then
      do n = 1, size(r%value)
        call note_load_number(bc, abs(nint(r%value(n))), r%place)
      end do
    end if
    kept = .false.
    do n = 1, mesh%nnode
      if (.not. on(n) .or. new(n) /= n) cycle
      select case (r%word)
      case (R_EBOU, R_CBOU)
        if (allocated(r%surface)) then
          kept = kept .or. any(bc%fixed(:, n) /= 0 .and. nint(r%value) == 0)
          bc%fixed(:, n) = bc%fixed(:, n) + abs(nint(r%value))
        else if (r%adds) then
          bc%fixed(:, n) = max(bc%fixed(:, n), abs(nint(r%value)))
        else
          bc%fixed(:, n) = abs(nint(r%value))
        end if
      case (R_EDIS, R_CDIS)
        bc%value(:, n) = r%value + merge(bc%value(:, n), 0.0_wp, r%adds)
      case (R_EFOR, R_CFOR)
        bc%force(:, n) = r%value + merge(bc%force(:, n), 0.0_wp, r%adds)
      case default
        bc%table(:, n) = abs(nint(r%value))
        bc%numbered(n) = .true.
        if (allocated(bc%rival)) bc%rival(:, n) = -1
      end select
    end do
    if (kept .and. r%sets) call warn('SET has no effect on SURFace, which adds to the restraints ' &
                                     //'of its nodes', r%place, 'remove unwanted restraints of ' &
                                     //'these nodes from the other records')
  end subroutine apply

  !> Warn if nodes of several bodies that nothing joins lie at the point of a word that acts on one
  !! node.
  subroutine warn_untied_point(mesh, near, new, r)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: near(:)         !! (nnode) nodes equally near to the point
    integer, intent(in) :: new(:)          !! (nnode)
    type(condition_entry_t), intent(in) :: r
    integer, allocatable :: node(:)

    allocate (node, source=unique(pack(new, near)))
    if (size(node) < 2) return
    associate (x => mesh%xr(:, node))
      if (any(maxval(x, 2) > minval(x, 2))) return
    end associate
    call warn(to_text(size(node))//' nodes, which nothing joins, lie at this point; ' &
              //trim(WORDS(r%word))//' acts on the first of them, node '//to_text(node(1)), &
              r%place, 'join them with TIE, or give a node by its number with ' &
              //trim(NODAL_WORDS(kind_of(r%word))))
  end subroutine warn_untied_point

  !> Does a word act on all nodes that are equally near to a point, or within GAP of the nearest
  !! one? The other words act on one node.
  pure logical function takes_all_near(word) result(all_near)
    integer, intent(in) :: word

    all_near = any(word == [R_CBOU, R_CDIS])
  end function takes_all_near

  !> Kind of condition that the records of a word set, C_FIXED to C_TABLE.
  pure integer function kind_of(word) result(kind)
    integer, intent(in) :: word

    select case (word)
    case (R_EBOU, R_CBOU)
      kind = C_FIXED
    case (R_EDIS, R_CDIS)
      kind = C_VALUE
    case (R_EPRO)
      kind = C_TABLE
    case default
      kind = C_FORCE
    end select
  end function kind_of

  !> The values of one kind of condition.
  pure subroutine get_condition(bc, kind, value)
    type(boundary_t), intent(in) :: bc
    integer, intent(in) :: kind
    real(wp), allocatable, intent(out) :: value(:, :) !! (3, nnode)

    select case (kind)
    case (C_FIXED)
      value = real(bc%fixed, wp)
    case (C_VALUE)
      value = bc%value
    case (C_FORCE)
      value = bc%force
    case default
      value = real(bc%table, wp)
    end select
  end subroutine get_condition

  !> Does record j set the same kind of condition as record i, and act before record i although it
  !! comes later in the deck?
  pure logical function is_overtaken(draft, i, j) result(yes)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: i, j

    associate (r => draft%condition(i), s => draft%condition(j))
      yes = j > i .and. s%word < r%word .and. kind_of(s%word) == kind_of(r%word)
    end associate
  end function is_overtaken

  !> May record i replace a condition that comes after it in the deck?
  pure logical function replaces_later(draft, i) result(yes)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: i
    integer :: j

    associate (r => draft%condition(i))
      yes = .not. (r%adds .or. r%word == R_CSUR .or. allocated(r%surface))
      if (yes .and. allocated(draft%nodes%after)) then
        if (any(draft%nodes%after(kind_of(r%word), :) >= i)) return
      end if
      if (yes) yes = any([(is_overtaken(draft, i, j), j=i + 1, draft%ncondition)])
    end associate
  end function replaces_later

  !> Warn if record i has replaced a condition that comes after it in the deck.
  subroutine warn_replaced(draft, i, mesh, active, new, bc, before, found)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: i
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    integer, intent(in) :: new(:)          !! (nnode)
    type(boundary_t), intent(in) :: bc
    real(wp), intent(in) :: before(:, :)   !! (3, nnode) values before record i was applied
    logical, intent(out) :: found
    character(:), allocatable :: word, other, hint
    real(wp), allocatable :: now(:, :)
    logical, allocatable :: lost(:, :), on(:)
    integer :: d, j, n, kind

    associate (r => draft%condition(i))
      kind = kind_of(r%word)
      call get_condition(bc, kind, now)
      call mark(mesh, r, active, on)
      on(pack(new, on)) = .true.
      allocate (lost, source=abs(before) > 0.0_wp .and. spread(on, 1, 3))
      select case (kind)
      case (C_FIXED) ! a code has no magnitude that could be compared
        lost = lost .and. .not. abs(now) > 0.0_wp
      case (C_VALUE, C_TABLE)
        lost = lost .and. abs(before - now) > 0.0_wp
      case default ! without this record the forces would add up, so that even equal ones are lost
      end select
      found = .false.
      do j = i + 1, draft%ncondition
        if (.not. (any(lost) .and. is_overtaken(draft, i, j))) cycle
        associate (s => draft%condition(j))
          call mark(mesh, s, active, on)
          on(pack(new, on)) = .true.
          do d = 1, 3
            if (abs(s%value(d)) > 0.0_wp .and. any(on .and. lost(d, :))) found = .true.
          end do
          word = trim(WORDS(s%word))
          other = word//' in line '//to_text(s%place%line)
          n = findloc(on .and. any(lost, 1), .true., 1)
        end associate
        if (found) exit
      end do
      if (.not. found .and. any(lost) .and. allocated(draft%nodes%after)) then
        on = .false.
        do j = 1, min(size(new), size(draft%nodes%after, 2))
          if (draft%nodes%after(kind, j) >= i) on(new(j)) = .true.
        end do
        n = findloc(on .and. any(lost, 1), .true., 1)
        found = n > 0
        word = trim(NODAL_WORDS(kind))
        other = 'a later '//word
      end if
      if (.not. found) return
      hint = 'give both load numbers in '//trim(WORDS(r%word))
      if (kind /= C_TABLE) hint = 'write '//trim(WORDS(r%word))//',ADD to keep both'
      call warn(trim(WORDS(r%word))//' replaces the '//trim(VALUES(kind))//' that '//other &
                //' gives to node '//to_text(n)//': '//trim(WORDS(r%word))//' acts after ' &
                //word//', regardless of their order in the deck', r%place, hint)
    end associate
  end subroutine warn_replaced

  !> Warn if a record without SET or ADD, which means SET, has replaced what other words give.
  subroutine warn_default(r, mesh, active, new, bc, others, found)
    type(condition_entry_t), intent(in) :: r
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    integer, intent(in) :: new(:)          !! (nnode)
    type(boundary_t), intent(in) :: bc
    real(wp), intent(in) :: others(:, :)   !! (3, nnode) values that the other words give
    logical, intent(out) :: found
    character(:), allocatable :: word
    real(wp), allocatable :: now(:, :)
    logical, allocatable :: lost(:, :), on(:)
    integer :: kind

    found = .false.
    kind = kind_of(r%word)
    if (r%adds .or. r%sets .or. kind == C_TABLE .or. allocated(r%surface)) return
    call get_condition(bc, kind, now)
    call mark(mesh, r, active, on)
    on(pack(new, on)) = .true.
    allocate (lost, source=abs(others) > 0.0_wp .and. spread(on, 1, 3))
    if (kind == C_FIXED) lost = lost .and. .not. abs(now) > 0.0_wp
    if (kind == C_VALUE) lost = lost .and. abs(others - now) > 0.0_wp
    found = any(lost)
    if (.not. found) return
    word = trim(WORDS(r%word))
    call warn(word//' replaces the '//trim(VALUES(kind))//' that other records give to node ' &
              //to_text(findloc(any(lost, 1), .true., 1)), r%place, &
              'write '//word//',ADD to keep both, or '//word//',SET if this is meant')
  end subroutine warn_default

  !> Warn about records of EPRO that give load numbers to no force and no displacement.
  subroutine warn_idle_numbers(draft, mesh, active, new, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    integer, intent(in) :: new(:)          !! (nnode)
    type(boundary_t), intent(in) :: bc
    logical, allocatable :: on(:)
    logical :: acts
    integer :: d, i

    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (r%word /= R_EPRO .or. all(nint(r%value) == 0)) cycle
        call mark(mesh, r, active, on)
        on(pack(new, on)) = .true.
        acts = .false.
        do d = 1, 3
          if (nint(r%value(d)) == 0) cycle
          acts = acts .or. any(on .and. (abs(bc%force(d, :)) > 0.0_wp .or. &
                                         abs(bc%value(d, :)) > 0.0_wp))
        end do
        if (acts .or. .not. any(on)) cycle
        call warn('the load numbers of this record have no effect: no node on the plane has a ' &
                  //'nodal force or displacement in the directions of these numbers', r%place, &
                  'give a force or ' &
                  //'displacement there, for instance with EFORce, FORCe or EDISplacement; ' &
                  //'PRESsure and MOVE have their own PROP k')
      end associate
    end do
  end subroutine warn_idle_numbers

  !> Warn about load numbers that FPRO gives only to nodes without a force and a displacement in
  !! their direction. A number that acts at some node may have been generated at the others.
  subroutine warn_idle_nodal_numbers(draft, new, bc)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: new(:)          !! (nnode)
    type(boundary_t), intent(in) :: bc
    type(place_t) :: place
    integer, allocatable :: number(:)
    logical :: acts
    integer :: d, i, n

    if (.not. allocated(draft%nodes%table)) return
    number = unique(pack(draft%nodes%table, draft%nodes%table > 0))
    do i = 1, size(number)
      acts = .false.
      do n = 1, min(size(new), size(draft%nodes%table, 2))
        do d = 1, 3
          if (draft%nodes%table(d, n) /= number(i)) cycle
          acts = acts .or. abs(bc%force(d, new(n))) > 0.0_wp .or. abs(bc%value(d, new(n))) > 0.0_wp
        end do
        if (acts) exit
      end do
      if (acts) cycle
      call place_of_number(bc, number(i), place)
      call warn('load number '//to_text(number(i))//' of FPROportional has no effect: no node ' &
                //'with this number has a nodal force or displacement in its direction', place, &
                'compare the node numbers with those of FORCe and DISPlacement; PRESsure and ' &
                //'MOVE have their own PROP k')
    end do
  end subroutine warn_idle_nodal_numbers

  !> Mark the nodes that a record finds. In the search for nodes on a plane, FEAP's gap shrinks with
  !! the number of nodes for EBOU and EPRO, but not for the other words. At a point, CBOU and CDIS
  !! take all nodes that are equally near.
  subroutine mark(mesh, r, active, on)
    type(mesh_t), intent(in) :: mesh
    type(condition_entry_t), intent(in) :: r
    logical, intent(in) :: active(:)
    logical, allocatable, intent(out) :: on(:)
    real(wp), allocatable :: d(:)
    real(wp) :: least, size
    integer :: i

    if (allocated(r%surface)) then
      call mark_surface(mesh, r, active, on)
      return
    else if (r%direction > 0) then
      on = active .and. abs(mesh%xr(r%direction, :) - r%at(1)) <= plane_gap(mesh, r, active)
      return
    end if
    allocate (d(mesh%nnode), on(mesh%nnode))
    on = .false.
    if (.not. any(active)) return
    size = 0.0_wp
    do i = 1, 3
      size = max(size, maxval(mesh%xr(i, :), active) - minval(mesh%xr(i, :), active))
    end do
    do i = 1, mesh%nnode
      d(i) = norm2(mesh%xr(:, i) - r%at)
    end do
    least = minval(d, active)
    if (.not. takes_all_near(r%word)) then
      on(minloc(d, 1, active)) = .true.
    else if (r%gap >= 0.0_wp) then
      on = active .and. d <= least + r%gap
    else ! FEAP compares squares of distances
      on = active .and. d*d <= least*least + POINT_GAP*size*size
    end if
  end subroutine mark

  !> Distance from a plane within which a record finds nodes [L].
  pure real(wp) function plane_gap(mesh, r, active) result(gap)
    type(mesh_t), intent(in) :: mesh
    type(condition_entry_t), intent(in) :: r
    logical, intent(in) :: active(:)

    gap = r%gap
    if (gap >= 0.0_wp) return
    associate (x => mesh%xr(r%direction, :))
      gap = PLANE*(maxval(x, active) - minval(x, active))
    end associate
    if (r%word == R_EBOU .or. r%word == R_EPRO) gap = gap/sqrt(real(max(1, mesh%nnode), wp))
  end function plane_gap

end module input_conditions
