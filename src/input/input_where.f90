!> WHERE of the deck names a place: faces, an edge, a node, the node nearest to a point, a plane, or
!! a named group. This module finds its nodes and element faces.
module input_where
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: lower, to_text, quoted
  use deck_record, only: record_t, get_word
  use deck_stream, only: deck_t, get_integer, get_real
  use input_plane, only: plane_t, warn_plane
  use mesh, only: mesh_t, body_t, body_boundary, body_faces, mark_rigid, ALL_FACES, INSIDE
  implicit none
  private
  public :: where_t, read_where, read_face, find_nodes, find_faces, body_index, unknown_face
  public :: equally_near, nearest_nodes, check_near, warn_between, warn_far, warn_rigid

  integer, parameter, public :: W_FACES = 1, W_EDGE = 2, W_NODE = 3, W_POINT = 4, W_PLANE = 5, &
                                W_GROUP = 6

  character(*), parameter :: FACE_HINT = 'faces are 1- 1+ 2- 2+ 3- 3+ SIDEs ALL; an edge is ' &
                             //'given by its two faces: 1-,3+'
  character(*), parameter :: ONE_FACE_HINT = 'faces are 1- 1+ 2- 2+ 3- 3+; give one record for ' &
                             //'each face'
  real(wp), parameter :: ON_PLANE = 1.0e-3_wp !! distance from a plane within which nodes are found,
  !! relative to the mesh's extent divided by the square root of the number of nodes (as EBOUndary)
  real(wp), parameter :: POINT_GAP = 1.0e-10_wp !! nodes are equally near to a point if the
  !! squares of their distances differ by no more than this times the square of the extent (FEAP)

  !> A place in the reference mesh, resolved after TIE. W_GROUP stands for any name that is not the
  !! name of a face; the body must then be a MESH or a SPLIne.
  type :: where_t
    integer :: type = 0                !! W_FACES to W_GROUP; 0: not given
    character(:), allocatable :: body  !! name of the body as written
    character(:), allocatable :: face  !! name of a face or a group as written
    integer :: mask = 0                !! bit f-1 of each face f
    integer :: node = 0
    integer :: direction = 0           !! normal of a plane
    real(wp) :: x(3) = 0.0_wp          !! point, or coordinate of a plane in x(1) [L]
    type(place_t) :: place, face_place
  end type where_t

contains

  !> Read WHERE from field i on, and set i to the field after it.
  subroutine read_where(deck, record, i, place, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    integer, intent(inout) :: i
    type(where_t), intent(out) :: place
    type(error_t), allocatable, intent(out) :: error
    integer :: d, f, second

    call get_word(record, i, place%body, error)
    if (allocated(error)) return
    place%place = record%place(i)
    select case (record%key(i))
    case ('node')
      place%type = W_NODE
      call get_integer(deck, record, i + 1, place%node, error)
      i = i + 2
    case ('poin')
      place%type = W_POINT
      do d = 1, 3
        call get_real(deck, record, i + d, place%x(d), error)
        if (allocated(error)) return
      end do
      i = i + 4
    case ('plan')
      place%type = W_PLANE
      call get_integer(deck, record, i + 1, place%direction, error)
      if (allocated(error)) return
      if (place%direction < 1 .or. place%direction > 3) then
        call fail(error, DECK_ERROR, 'unknown direction '//to_text(place%direction), &
                  record%place(i + 1), 'directions are 1, 2 and 3')
        return
      end if
      call get_real(deck, record, i + 2, place%x(1), error)
      i = i + 3
    case default ! `patch face` or `patch face,face`
      if (record%is_empty(i + 1)) then
        call fail(error, DECK_ERROR, 'the face of '//quoted(place%body)//' is missing', &
                  record%place(i + 1), FACE_HINT)
        return
      end if
      place%type = W_FACES
      place%face_place = record%place(i + 1)
      place%face = record%text(i + 1)
      select case (lower(place%face)) ! a group may be called sidewall
      case ('side', 'sides')
        place%mask = 15
      case ('all')
        place%mask = ALL_FACES
      case default
        f = face_number(place%face)
        if (f == 0) then
          place%type = W_GROUP
          i = i + 2
          return
        end if
        place%mask = ibset(0, f - 1)
        if (i + 2 <= record%n) then
          second = face_number(record%text(i + 2))
          if (second == 0 .and. is_like_face(record%text(i + 2))) then
            call unknown_face(record%text(i + 2), record%place(i + 2), error)
            return
          end if
          if (second > 0) then
            if ((second + 1)/2 == (f + 1)/2) then
              call fail(error, DECK_ERROR, 'faces '//record%text(i + 1)//' and ' &
                        //record%text(i + 2)//' have no common edge', record%place(i + 2), &
                        FACE_HINT)
              return
            end if
            place%type = W_EDGE
            place%mask = ibset(place%mask, second - 1)
            i = i + 1
          end if
        end if
      end select
      i = i + 2
    end select
  end subroutine read_where

  !> Read the number of the face in field i: 1 to 6 for 1- 1+ 2- 2+ 3- 3+.
  subroutine read_face(record, i, f, error)
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    integer, intent(out) :: f
    type(error_t), allocatable, intent(out) :: error

    f = face_number(record%text(i))
    if (f > 0) return
    call unknown_face(record%text(i), record%place(i), error)
    if (error%hint == FACE_HINT) error%hint = ONE_FACE_HINT
  end subroutine read_face

  subroutine unknown_face(text, place, error)
    character(*), intent(in) :: text
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    call fail(error, DECK_ERROR, 'unknown face '//quoted(text), place, face_hint_for(text))
  end subroutine unknown_face

  !> A hint for a name that is not a face: what its direction and its sign may mean, or a list of
  !! all faces.
  pure function face_hint_for(text) result(hint)
    character(*), intent(in) :: text
    character(:), allocatable :: hint
    character :: direction
    integer :: at

    hint = FACE_HINT
    at = verify(text, '+-')
    if (at == 0 .or. len(text) > 3) return
    direction = lower(text(at:at))
    if (index('123xyz', direction) == 0 .or. verify(text, '+-', back=.true.) /= at) return
    if (index('xyz', direction) > 0) then
      direction = '123' (index('xyz', direction):index('xyz', direction))
      hint = 'faces belong to the directions 1, 2 and 3 of a patch'
    else
      hint = 'a face is written as a direction and a sign'
    end if
    if (scan(text, '+') > 0 .eqv. scan(text, '-') > 0) then
      hint = hint//': '//direction//'- or '//direction//'+'
    else if (scan(text, '-') > 0) then
      hint = hint//': '//direction//'-'
    else
      hint = hint//': '//direction//'+'
    end if
    hint = hint//'; direction '//direction//' begins at '//direction//'- and ends at '//direction &
           //'+'
  end function face_hint_for

  !> Is a field written like a face, as one digit and a sign? Letters may be the name of a patch.
  pure logical function is_like_face(text)
    character(*), intent(in) :: text

    is_like_face = len(text) == 2
    if (is_like_face) is_like_face = scan(text(1:1), '0123456789') > 0 &
                                     .and. scan(text(2:2), '+-') > 0
  end function is_like_face

  pure integer function face_number(text) result(f)
    character(*), intent(in) :: text
    character(2), parameter :: NAME(6) = ['1-', '1+', '2-', '2+', '3-', '3+']
    integer :: j

    f = 0
    if (len(text) /= 2) return
    do j = 1, 6
      if (text == NAME(j)) f = j
    end do
  end function face_number

  !> Index of a body by its name; 0: there is none.
  pure integer function body_index(mesh, name) result(b)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: name

    do b = size(mesh%body), 1, -1
      if (lower(mesh%body(b)%name) == lower(name)) return
    end do
  end function body_index

  !> Find the nodes of a place, each once, in increasing order; after an error, the list is empty.
  !! At a POINt, a node of a rigid body is taken only if no other body is equally near.
  subroutine find_nodes(mesh, place, node, error, all_near, no_rigid)
    type(mesh_t), intent(in) :: mesh
    type(where_t), intent(in) :: place
    integer, allocatable, intent(out) :: node(:)
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in) :: all_near !! take all nodes equally near to a POINt, otherwise the first
    logical, intent(in) :: no_rigid !! ignore rigid bodies at a POINt
    logical, allocatable :: on(:)
    type(plane_t) :: plane
    integer :: g, i, n

    allocate (on(mesh%nnode), source=.false.)
    allocate (node(0))
    select case (place%type)
    case (W_FACES, W_EDGE, W_GROUP)
      associate (body => mesh%body(body_index(mesh, place%body)))
        g = group_index(body, place%face)
        if (g > 0 .and. place%mask /= ALL_FACES) then
          on(body%group(g)%node) = .true.
        else
          do i = 1, size(body%node)
            n = iand(body%mask(i), place%mask)
            if (n == 0) cycle
            if (place%mask == ALL_FACES .and. btest(body%mask(i), INSIDE)) cycle
            if (n == place%mask .or. place%type == W_FACES) on(body%node(i)) = .true.
          end do
          if (g > 0) call warn_all(body, place, all(on(body%group(g)%node)) .and. &
                                   count(on) == size(body%group(g)%node))
        end if
      end associate
    case (W_NODE)
      if (place%node < 1 .or. place%node > mesh%nnode) then
        call fail(error, DECK_ERROR, 'node '//to_text(place%node)//' is not in the mesh', &
                  place%place, 'the largest node number is '//to_text(mesh%nnode))
        return
      else if (.not. mesh%used(place%node)) then
        call fail(error, DECK_ERROR, 'node '//to_text(place%node)//' belongs to no element', &
                  place%place)
        return
      end if
      on(place%node) = .true.
    case (W_POINT)
      call nearest_nodes(mesh, place%x, no_rigid, on)
      i = findloc(on, .true., 1)
      call check_near(mesh, place%x, i, place%place, error)
      if (allocated(error)) return
      call warn_between(mesh, on, all_near, place%place)
      if (.not. all_near) on(i + 1:) = .false.
    case default ! W_PLANE
      associate (x => mesh%xr(place%direction, :))
        plane%gap = ON_PLANE*(maxval(x, mesh%used) - minval(x, mesh%used)) &
                    /sqrt(real(mesh%nnode, wp))
        on = mesh%used .and. abs(x - place%x(1)) <= plane%gap
      end associate
      plane%direction = place%direction
      plane%place = place%place
      plane%hint = 'name a face of a patch instead of the plane, or use EBOUndary or ' &
                   //'EDISplacement with GAP d'
      call warn_plane(mesh, plane, on)
    end select
    on = on .and. mesh%used
    node = pack([(i, i=1, mesh%nnode)], on)
    if (size(node) == 0) call fail(error, DECK_ERROR, 'no node lies at this place', place%place)
  end subroutine find_nodes

  !> Mark the nodes that are equally near to a point, nearer than all others. Those of rigid bodies
  !! are left out if another body is equally near, and with `no_rigid` always.
  pure subroutine nearest_nodes(mesh, x, no_rigid, on)
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: x(3) !! [L]
    logical, intent(in) :: no_rigid
    logical, allocatable, intent(out) :: on(:) !! (nnode)
    logical, allocatable :: rigid(:)

    call mark_rigid(mesh, rigid)
    on = mesh%used
    if (no_rigid) on = on .and. .not. rigid
    call equally_near(mesh, x, on)
    if (any(on .and. .not. rigid)) on = on .and. .not. rigid
  end subroutine nearest_nodes

  !> Of the marked nodes, keep those that are nearest to a point. As in FEAP, squares of distances
  !! are compared.
  pure subroutine equally_near(mesh, x, on)
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: x(3) !! [L]
    logical, intent(inout) :: on(:) !! (nnode)
    real(wp), allocatable :: square(:)
    integer :: i

    if (.not. any(on)) return
    square = [(sum((mesh%xr(:, i) - x)**2), i=1, mesh%nnode)]
    on = on .and. square <= minval(square, on) + POINT_GAP*extent_of(mesh, on)**2
  end subroutine equally_near

  !> Largest extent of the marked nodes [L].
  pure real(wp) function extent_of(mesh, on) result(extent)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: on(:) !! (nnode)
    integer :: i

    extent = 0.0_wp
    do i = 1, 3
      extent = max(extent, maxval(mesh%xr(i, :), on) - minval(mesh%xr(i, :), on))
    end do
  end function extent_of

  !> Warn if the node nearest to a POINt is farther from the point than from any other node of its
  !! elements. Fail if its distance from the point is larger than the extent of the model.
  subroutine check_near(mesh, x, node, place, error)
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: x(3)       !! the point [L]
    integer, intent(in) :: node        !! node nearest to the point
    type(place_t), intent(in) :: place !! place of the point in the deck
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: away, extent

    away = norm2(mesh%xr(:, node) - x)
    extent = extent_of(mesh, mesh%used)
    if (away > extent) then
      call fail(error, DECK_ERROR, far_text(node, away)//', more than the extent of the model (' &
                //to_text(extent, 3)//')', place, 'give a point in or on a body')
    else
      call warn_far(mesh, x, node, place)
    end if
  end subroutine check_near

  !> Warn about a point between nodes that are equally near. Nodes of several bodies at the same
  !! position cause no warning, because the point may mean all of them.
  subroutine warn_between(mesh, on, all_near, place)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: on(:)       !! (nnode) the nodes that are equally near
    logical, intent(in) :: all_near    !! all of them are taken, otherwise the first
    type(place_t), intent(in) :: place !! place of the point in the deck
    character(:), allocatable :: taken

    if (extent_of(mesh, on) <= sqrt(POINT_GAP)*extent_of(mesh, mesh%used)) return
    taken = 'all are selected, so a support may prevent a rotation, and FORCe of a CURVe adds up ' &
            //'the forces of all of them'
    if (.not. all_near) taken = 'the first is selected'
    call warn(to_text(count(on))//' nodes at different places are equally near to the point; ' &
              //taken, place, 'move the point closer to the intended node')
  end subroutine warn_between

  !> Warn about a point that is farther from its nearest node than this node is from the other nodes
  !! of its elements.
  subroutine warn_far(mesh, x, node, place)
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: x(3)       !! the point [L]
    integer, intent(in) :: node        !! node nearest to the point
    type(place_t), intent(in) :: place !! place of the point in the deck
    real(wp) :: away, reach
    integer :: b, e, i

    away = norm2(mesh%xr(:, node) - x)
    if (away <= sqrt(POINT_GAP)*extent_of(mesh, mesh%used)) return ! no search is needed
    reach = 0.0_wp
    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        associate (conn => mesh%block(b)%conn(:, e))
          if (all(conn /= node)) cycle
          do i = 1, size(conn)
            reach = max(reach, norm2(mesh%xr(:, conn(i)) - mesh%xr(:, node)))
          end do
        end associate
      end do
    end do
    if (away <= reach) return
    call warn(far_text(node, away)//', more than the size of an element ('//to_text(reach, 3) &
              //')', place, 'give a point in or on a body')
  end subroutine warn_far

  !> Warn about a point that is nearer to a node of a rigid patch than to the selected node.
  subroutine warn_rigid(mesh, x, node, place)
    type(mesh_t), intent(in) :: mesh
    real(wp), intent(in) :: x(3)       !! the point [L]
    integer, intent(in) :: node        !! selected node
    type(place_t), intent(in) :: place !! place of the point in the deck
    logical, allocatable :: rigid(:)
    real(wp) :: away
    integer :: i

    away = norm2(mesh%xr(:, node) - x)
    if (away <= sqrt(POINT_GAP)*extent_of(mesh, mesh%used)) return ! no search is needed
    call mark_rigid(mesh, rigid)
    if (.not. any([(rigid(i) .and. norm2(mesh%xr(:, i) - x) < (1.0_wp - sqrt(POINT_GAP))*away, &
                    i=1, mesh%nnode)])) return
    call warn('the point is nearest to a node of a rigid patch, on which this word has no ' &
              //'effect; it acts on node '//to_text(node)//', '//to_text(away, 3)//' away', place, &
              'MOVE moves a rigid patch; give a point of a deformable body')
  end subroutine warn_rigid

  function far_text(node, away) result(text)
    integer, intent(in) :: node
    real(wp), intent(in) :: away
    character(:), allocatable :: text

    text = 'the nearest node, '//to_text(node)//', is '//to_text(away, 3)//' away from this point'
  end function far_text

  !> Index of a named group of a body; 0: there is none.
  pure integer function group_index(body, name) result(g)
    type(body_t), intent(in) :: body
    character(*), intent(in) :: name

    g = 0
    if (.not. allocated(body%group)) return
    do g = size(body%group), 1, -1 ! names may differ only in case
      if (body%group(g)%name == name) return
    end do
    do g = size(body%group), 1, -1
      if (lower(body%group(g)%name) == lower(name)) return
    end do
  end function group_index

  !> Warn that ALL means the whole boundary of a body that has a group of this name, unless both
  !! are the same or only the boundary can be meant.
  subroutine warn_all(body, place, is_same)
    type(body_t), intent(in) :: body
    type(where_t), intent(in) :: place
    logical, intent(in) :: is_same

    if (is_same) return
    call warn('ALL is the whole boundary of '//quoted(body%name)//', not its group ' &
              //quoted(place%face), place%face_place, 'give the group another name, or put it ' &
              //'into a second group, if the group is meant')
  end subroutine warn_all

  !> Find the element faces that belong to the named faces or the named group of a body.
  subroutine find_faces(mesh, place, block, elem, side, error)
    type(mesh_t), intent(in) :: mesh
    type(where_t), intent(in) :: place
    integer, allocatable, intent(out) :: block(:), elem(:), side(:) !! as in body_face_t
    type(error_t), allocatable, intent(out) :: error
    integer :: b, g, n

    allocate (block(0), elem(0), side(0))
    if (place%type /= W_FACES .and. place%type /= W_GROUP) then
      call fail(error, DECK_ERROR, 'expected a face of a patch', place%place, FACE_HINT)
      return
    end if
    b = body_index(mesh, place%body)
    g = group_index(mesh%body(b), place%face)
    if (g > 0 .and. place%mask /= ALL_FACES) then
      associate (group => mesh%body(b)%group(g))
        block = group%face%block
        elem = group%face%elem
        side = group%face%side
        if (group%inner > 0) then
          call fail(error, DECK_ERROR, 'surface elements of group '//quoted(group%name) &
                    //' are not on the boundary of '//quoted(place%body)//' (number: ' &
                    //to_text(group%inner)//' of '//to_text(group%inner + size(elem))//')', &
                    place%face_place, 'loads and contact act on the boundary; these elements lie ' &
                    //'inside the body, also where TIE joins its faces, or on no element')
        else if (size(elem) == 0) then
          call fail(error, DECK_ERROR, 'group '//quoted(group%name)//' of '//quoted(place%body) &
                    //' has no surface elements', place%face_place, 'name a physical surface')
        end if
      end associate
      return
    end if
    if (place%mask == ALL_FACES) then
      call body_boundary(mesh, b, block, elem, side)
    else
      call body_faces(mesh, b, place%mask, block, elem, side)
    end if
    if (g > 0) then
      n = size(mesh%body(b)%group(g)%face%elem)
      call warn_all(mesh%body(b), place, n == 0 .or. n == size(elem))
    end if
    if (size(elem) == 0) call fail(error, DECK_ERROR, quoted(place%body)//' has no face ' &
                                   //quoted(place%face), place%face_place, &
                                   '3- and ALL name the whole surface of a spline')
  end subroutine find_faces

end module input_where
