!> Warnings about conditions at nodes that may act otherwise than intended. All conditions of the
!! deck must have been applied, because other records decide whether a condition has an effect.
module condition_doubts
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: boundary_t, moved_dofs, LOOSE_FREE, LOOSE_MOVED, LOOSE_ADDED
  use input_conditions, only: kind_of, mark, mark_active, NODAL_WORDS, WORDS
  use input_draft, only: draft_t, C_FIXED, C_VALUE, C_TABLE
  use input_plane, only: warn_inside
  use input_twice, only: same_place, is_repeated, warn_repeated
  use input_where, only: W_PLANE
  use mesh, only: mesh_t
  use word_position, only: R_EBOU, R_EDIS, R_CBOU, R_CDIS, R_CFOR, R_CSUR
  implicit none
  private
  public :: warn_supports_kept, warn_added, warn_planes_inside, warn_unused, &
            warn_same_nodes, note_loose

contains

  !> Warn about records with SET that free a direction in which FIX restrains some of their nodes,
  !! because FIX adds to the restraints of all other records.
  subroutine warn_supports_kept(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, allocatable :: active(:), on(:)
    integer :: d, i, j, n

    call mark_active(draft, mesh, active)
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (.not. r%sets .or. kind_of(r%word) /= C_FIXED .or. allocated(r%surface)) cycle
        call mark(mesh, r, active, on)
        search: do j = 1, draft%nsupport
          do d = 1, 3
            if (nint(r%value(d)) /= 0 .or. draft%support(j)%code(d) == 0) cycle
            n = count(on(draft%support(j)%node))
            if (n == 0) cycle
            call warn(trim(WORDS(r%word))//' SET leaves direction '//to_text(d)//' free, but FIX ' &
                      //'in line '//to_text(draft%support(j)%at%place%line) &
                      //' restrains it (number of these nodes: '//to_text(n)//'): FIX takes ' &
                      //'precedence', r%place, 'FIX adds to all other restraints: leave the ' &
                      //'direction free in FIX too')
            exit search
          end do
        end do search
      end associate
    end do
  end subroutine warn_supports_kept

  !> Warn, once, if a record of EDIS adds values to those of another plane at common nodes, in a
  !! direction that is restrained. All restraints must have been set before.
  subroutine warn_added(draft, mesh, new, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: new(:) !! (nnode)
    type(boundary_t), intent(in) :: bc
    integer, allocatable :: giver(:, :) ! (3, nnode) the last EDIS that gives a value; 0: none
    integer, parameter :: BY_NUMBER = -1 ! instead: DISPlacement gives a value
    logical, allocatable :: active(:), on(:)
    integer :: d, i, j, n

    call mark_active(draft, mesh, active)
    allocate (giver(3, mesh%nnode), source=0)
    if (allocated(draft%nodes%value)) then
      do n = 1, min(size(new), size(draft%nodes%value, 2))
        where (abs(draft%nodes%value(:, n)) > 0.0_wp) giver(:, new(n)) = BY_NUMBER
      end do
    end if
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (r%word /= R_EDIS) cycle
        call mark(mesh, r, active, on)
        on(pack(new, on)) = .true.
        do n = 1, size(new)
          if (.not. on(n) .or. new(n) /= n) cycle
          if (.not. r%adds) giver(:, n) = 0
          do d = 1, 3
            if (bc%fixed(d, n) == 0 .or. .not. abs(r%value(d)) > 0.0_wp) cycle
            j = giver(d, n)
            giver(d, n) = i
            if (j == 0) cycle
            if (j == BY_NUMBER) then
              call warn('this EDISplacement adds its values to those of DISPlacement, such as at ' &
                        //'node '//to_text(n)//' in direction '//to_text(d), r%place, &
                        'if the sum is not intended, write SET, which replaces all three values')
              return
            end if
            associate (s => draft%condition(j)) ! records of one plane cause another warning
              if (r%direction == s%direction .and. abs(r%at(1) - s%at(1)) <= 0.0_wp) cycle
              call warn('this EDISplacement adds its values to those in line ' &
                        //to_text(s%place%line)//' at common nodes of the two planes, such as ' &
                        //'node '//to_text(n)//' in direction '//to_text(d), r%place, &
                        'if the sum is not intended, write SET, which replaces all three values')
              return
            end associate
          end do
        end do
      end associate
    end do
  end subroutine warn_added

  !> Warn about planes inside bodies of splines that EBOUndary, FIX or MOVE restrains. All
  !! restraints and motions must have been set before.
  subroutine warn_planes_inside(draft, mesh, new, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: new(:) !! (nnode)
    type(boundary_t), intent(in) :: bc
    logical, allocatable :: active(:), on(:), free(:, :)
    integer :: i

    if (.not. any(mesh%block%row%spline)) return
    allocate (free, source=bc%fixed == 0 .and. .not. moved_dofs(bc, mesh%nnode))
    call mark_active(draft, mesh, active)
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (r%word /= R_EBOU) cycle
        call mark(mesh, r, active, on)
        on(pack(new, on)) = .true.
        call warn_inside(mesh, r%direction, on, is_free(nint(r%value) /= 0), r%place)
      end associate
    end do
    do i = 1, draft%nsupport
      associate (support => draft%support(i))
        if (support%at%type /= W_PLANE) cycle
        on = spread(.false., 1, mesh%nnode)
        on(support%node) = .true.
        call warn_inside(mesh, support%at%direction, on, is_free(support%code /= 0), &
                         support%at%place)
      end associate
    end do
    do i = 1, draft%nmotion
      associate (at => draft%motion(i)%at, motion => bc%motion(i))
        if (at%type /= W_PLANE) cycle
        on = spread(.false., 1, mesh%nnode)
        on(motion%node) = .true.
        call warn_inside(mesh, at%direction, on, is_free(motion%acts .or. motion%rotates), &
                         at%place)
      end associate
    end do

  contains

    !> Mark the nodes that are free in one of the given directions.
    pure function is_free(restrained) result(yes)
      logical, intent(in) :: restrained(3)
      logical :: yes(mesh%nnode)
      integer :: n

      yes = [(any(free(:, n) .and. restrained), n=1, mesh%nnode)]
    end function is_free

  end subroutine warn_planes_inside

  !> Warn, once for each word, about a point whose nearest node is also that of another point of its
  !! word, and whose values replace or repeat those of the other point.
  subroutine warn_same_nodes(draft, mesh, new)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: new(:)      !! (nnode) the node that replaces each node after TIE
    integer, allocatable :: nodes(:)
    integer, allocatable :: giver(:, :) ! (nnode, word) the last record that finds a node; 0: none
    logical, allocatable :: active(:), on(:)
    logical :: told(R_CSUR)
    integer :: i, j

    if (draft%ncondition == 0) return
    call mark_active(draft, mesh, active)
    allocate (giver(size(new), R_CSUR), source=0)
    told = .false.
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (all(r%word /= [R_CBOU, R_CFOR, R_CDIS]) .or. allocated(r%surface)) cycle
        if (told(r%word)) cycle
        call mark(mesh, r, active, on)
        nodes = pack(new, on)
        j = maxval([0, giver(nodes, r%word)])
        giver(nodes, r%word) = i
        if (j == 0) cycle
        if (same_place(r, draft%condition(j))) cycle ! reported by warn_repeated_conditions
        if (.not. is_repeated(r, draft%condition(j))) cycle
        told(r%word) = .true.
        call warn_repeated(r, draft%condition(j), 'the same node')
      end associate
    end do
  end subroutine warn_same_nodes

  !> Warn about restraints, displacements and load numbers that have no effect, because the nodes
  !! that BOUN, DISP and FPRO name, or all nodes that a record by position finds, belong to no
  !! element. TIE and constraints must have been applied. Forces are examined with all other loads.
  subroutine warn_unused(draft, mesh, new)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: new(:) !! (nnode) the node that replaces each node after TIE
    logical, allocatable :: active(:), on(:)
    logical :: given(4), all_given(4) ! kinds of conditions, C_FIXED to C_TABLE
    character(:), allocatable :: names
    integer :: i, n, first, number

    call mark_active(draft, mesh, active)
    if (allocated(draft%nodes%named)) then
      all_given = .false.
      number = 0
      do n = min(size(new), size(draft%nodes%named)), 1, -1
        if (mesh%used(new(n))) cycle
        given = named_conditions(draft, n)
        all_given = all_given .or. given
        if (.not. any(given)) cycle
        number = number + 1
        first = n
      end do
      names = ''
      do i = 1, 4
        if (.not. all_given(i)) cycle
        if (len(names) > 0) names = names//' and '
        names = names//trim(NODAL_WORDS(i))
      end do
      names = names//trim(merge(' gives', ' give ', count(all_given) == 1))
      if (number > 0) then
        call warn_of(names//' values to nodes that belong to no element, where they have no ' &
                     //'effect', first, number)
      end if
    end if
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (all(r%word /= [R_EBOU, R_EDIS, R_CBOU, R_CDIS])) cycle
        if (.not. any(abs(r%value) > 0.0_wp)) cycle
        call mark(mesh, r, active, on)
        on(pack(new, on)) = .true.
        if (.not. any(on) .or. any(on .and. mesh%used)) cycle
        call warn_of('this '//trim(WORDS(r%word))//' finds only nodes that belong to no element, ' &
                     //'and has no effect', findloc(on, .true., 1), count(on), r%place)
      end associate
    end do

  contains

    subroutine warn_of(text, node, number, place)
      character(*), intent(in) :: text
      integer, intent(in) :: node, number !! first node; number of nodes
      type(place_t), intent(in), optional :: place
      character(:), allocatable :: hint

      hint = 'compare their numbers and positions with those of the nodes of elements'
      if (mesh%is_control(node)) hint = 'control points of an NPATch that only gives a PATCh its ' &
                                        //'shape belong to no element: use FIX and MOVE with a ' &
                                        //'face of the PATCh'
      call warn(text//' (number of nodes: '//to_text(number)//', the first is node ' &
                //to_text(node)//')', place, hint)
    end subroutine warn_of

  end subroutine warn_unused

  !> Kinds of conditions that records of BOUN, DISP and FPRO which name node n give to it.
  pure function named_conditions(draft, n) result(given)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: n
    logical :: given(4)

    given = .false.
    associate (nodes => draft%nodes)
      if (btest(nodes%named(n), C_FIXED)) given(C_FIXED) = any(nodes%code(:, n) /= 0)
      if (btest(nodes%named(n), C_VALUE)) given(C_VALUE) = any(abs(nodes%value(:, n)) > 0.0_wp)
      if (btest(nodes%named(n), C_TABLE)) given(C_TABLE) = any(nodes%table(:, n) /= 0)
    end associate
  end function named_conditions

  !> Find, for warnings, the records that prescribe displacements at dofs without a restraint, where
  !! they have no effect (as in FEAP), and those that prescribe displacements at dofs that MOVE
  !! prescribes too. All restraints and motions must have been set before.
  subroutine note_loose(draft, mesh, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(inout) :: bc
    integer, allocatable :: state(:, :) ! (3, nnode) LOOSE_FREE, ...; 0: the value acts
    logical, allocatable :: active(:), on(:), moved(:, :)
    type(place_t), allocatable :: found(:)
    integer :: kind(draft%ncondition + 1), i, d, n

    allocate (moved, source=moved_dofs(bc, mesh%nnode))
    allocate (state(3, mesh%nnode), source=0)
    where (bc%fixed == 0) state = merge(LOOSE_MOVED, LOOSE_FREE, moved)
    where (bc%fixed /= 0 .and. moved) state = LOOSE_ADDED
    where (.not. (abs(bc%value) > 0.0_wp .and. spread(mesh%used, 1, 3))) state = 0
    if (all(state == 0)) return
    allocate (found(draft%ncondition + 1))
    n = 0
    call mark_active(draft, mesh, active)
    do i = 1, draft%ncondition
      associate (r => draft%condition(i))
        if (all(r%word /= [R_EDIS, R_CDIS])) cycle
        call mark(mesh, r, active, on)
        kind(n + 1) = 0
        do d = 1, 3
          if (.not. abs(r%value(d)) > 0.0_wp) cycle
          kind(n + 1) = max(kind(n + 1), maxval(state(d, :), on))
          where (on) state(d, :) = 0
        end do
        if (kind(n + 1) <= 0) cycle
        n = n + 1
        found(n) = r%place
      end associate
    end do
    if (any(state > 0)) then
      n = n + 1
      found(n) = draft%nodes%disp
      kind(n) = maxval(state)
    end if
    bc%loose = found(:n)
    bc%loose_kind = kind(:n)
  end subroutine note_loose

end module condition_doubts
