!> Conditions by number and by position, applied to the nodes and control points of the whole mesh.
!!
!! Order as in FEAP: BOUN FORC DISP FPRO as read; then all of EBOU, EDIS, EFOR, EPRO, CBOU, CFOR,
!! CDIS and CSUR, each in deck order.
module input_conditions
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text
  use boundary, only: boundary_t, note_load_number
  use mesh, only: mesh_t, solid_nodes
  use input_draft, only: build_t, request_t
  use input_lists, only: node_list_t
  use word_position, only: R_EBOU, R_EDIS, R_EFOR, R_EPRO, R_CBOU, R_CFOR, R_CDIS, R_CSUR
  use input_surface, only: mark_surface, load_surface
  implicit none
  private
  public :: apply_conditions, note_loose

  real(wp), parameter :: PLANE_SHARE = 1.0e-3_wp  !! FEAP's search gap, share of the mesh's extent
  real(wp), parameter :: POINT_SHARE = 1.0e-10_wp !! the same for points

contains

  !> Fill bc; errors go to the list.
  subroutine apply_conditions(build, mesh, bc)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(inout) :: bc
    logical, allocatable :: active(:)
    type(error_t), allocatable :: error
    integer :: kind, i

    call take_lists(build%nodes, mesh%nnode, bc)
    call check_mentions(build, mesh)
    call mark_active(build, mesh, active)
    do kind = R_EBOU, R_CSUR
      do i = 1, build%nrequest
        if (build%request(i)%kind /= kind) cycle
        call apply(build%request(i), mesh, active, bc, error)
        if (allocated(error)) call build%errors%add(error)
      end do
    end do
  end subroutine apply_conditions

  !> What BOUN, FORC, DISP and FPRO said.
  subroutine take_lists(list, nnode, bc)
    type(node_list_t), intent(in) :: list
    integer, intent(in) :: nnode
    type(boundary_t), intent(inout) :: bc
    integer :: n

    allocate (bc%fixed(3, nnode), bc%table(3, nnode), source=0)
    allocate (bc%value(3, nnode), bc%force(3, nnode), source=0.0_wp)
    if (.not. allocated(list%given)) return
    n = min(nnode, size(list%given))
    bc%fixed(:, :n) = abs(list%code(:, :n))
    bc%table(:, :n) = list%table(:, :n)
    bc%value(:, :n) = list%value(:, :n)
    bc%force(:, :n) = list%force(:, :n)
  end subroutine take_lists

  !> Nodes named before they were defined must have been defined by now.
  subroutine check_mentions(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    integer :: i, n

    do i = 1, build%mention%place%n
      n = build%mention%node(i)
      if (n > build%nodes%top .and. n <= mesh%nnode) cycle ! of a patch
      if (n <= build%nodes%top) then
        if (build%nodes%given(n)) cycle
      end if
      call fail(error, DECK_ERROR, 'node '//to_text(n)//' is not defined', &
                build%mention%place%at(i), &
                'nodes are 1 to '//to_text(mesh%nnode))
      call build%errors%add(error)
    end do
  end subroutine check_mentions

  !> Nodes that FEAP would look at: all with a position, but no control points that are
  !! geometry only, and none of rigid patches, which MOVE moves.
  subroutine mark_active(build, mesh, active)
    type(build_t), intent(in) :: build
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: active(:)
    integer :: n

    call solid_nodes(mesh, active)
    n = build%nodes%top
    if (n > 0) active(:n) = active(:n) .or. (build%nodes%given(:n) .and. .not. mesh%is_control(:n))
  end subroutine mark_active

  subroutine apply(r, mesh, active, bc, error)
    type(request_t), intent(in) :: r
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: active(:)
    type(boundary_t), intent(inout) :: bc
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: on(:)
    integer :: n

    call mark(mesh, r, active, on)
    if (.not. any(on)) then
      call complain(mesh, r, active, error)
      return
    end if
    if (r%kind == R_CSUR .and. allocated(r%surface)) then
      call load_surface(mesh, r, on, bc, error)
      return
    end if
    if (r%kind == R_EPRO) then
      do n = 1, size(r%value)
        call note_load_number(bc, abs(nint(r%value(n))), r%place)
      end do
    end if
    do n = 1, mesh%nnode
      if (on(n)) call set_node(r, n, bc)
    end do
  end subroutine apply

  !> Nodes that a record means.
  subroutine mark(mesh, r, active, on)
    type(mesh_t), intent(in) :: mesh
    type(request_t), intent(in) :: r
    logical, intent(in) :: active(:)
    logical, allocatable, intent(out) :: on(:)

    if (allocated(r%surface)) then
      call mark_surface(mesh, r, active, on)
    else if (r%direction > 0) then
      call mark_plane(mesh, r, active, on)
    else
      call mark_point(mesh, r, active, on)
    end if
  end subroutine mark

  !> Displacements act where a node is restrained (FEAP). Records that prescribe some elsewhere are
  !! kept, for a warning; to be called when all restraints are known.
  subroutine note_loose(build, mesh, bc)
    type(build_t), intent(in) :: build
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(inout) :: bc
    logical, allocatable :: loose(:, :), active(:), on(:)
    type(place_t), allocatable :: found(:)
    integer :: i, d, n

    loose = abs(bc%value) > 0.0_wp .and. bc%fixed == 0 .and. spread(mesh%used, 1, 3)
    if (.not. any(loose)) return
    allocate (found(build%nrequest + 1))
    n = 0
    call mark_active(build, mesh, active)
    do i = 1, build%nrequest
      associate (r => build%request(i))
        if (all(r%kind /= [R_EDIS, R_CDIS])) cycle
        call mark(mesh, r, active, on)
        if (.not. any([(abs(r%value(d)) > 0.0_wp .and. any(on .and. loose(d, :)), d=1, 3)])) cycle
        n = n + 1
        found(n) = r%place
        do d = 1, 3
          if (abs(r%value(d)) > 0.0_wp) loose(d, :) = loose(d, :) .and. .not. on
        end do
      end associate
    end do
    if (any(loose)) then
      n = n + 1
      found(n) = build%nodes%disp
    end if
    bc%loose = found(:n)
  end subroutine note_loose

  subroutine set_node(r, n, bc)
    type(request_t), intent(in) :: r
    integer, intent(in) :: n
    type(boundary_t), intent(inout) :: bc

    select case (r%kind)
    case (R_EBOU, R_CBOU)
      if (allocated(r%surface)) then
        bc%fixed(:, n) = bc%fixed(:, n) + abs(nint(r%value))
      else if (r%adds) then
        bc%fixed(:, n) = max(bc%fixed(:, n), abs(nint(r%value)))
      else
        bc%fixed(:, n) = abs(nint(r%value))
      end if
    case (R_EDIS, R_CDIS)
      bc%value(:, n) = r%value + merge(bc%value(:, n), 0.0_wp, r%adds .and. r%kind == R_EDIS)
    case (R_EFOR, R_CFOR, R_CSUR)
      bc%force(:, n) = r%value + merge(bc%force(:, n), 0.0_wp, r%adds)
    case default
      bc%table(:, n) = abs(nint(r%value))
    end select
  end subroutine set_node

  !> Nodes of a plane. FEAP's gap of EBOU and EPRO shrinks with the number of nodes, that of
  !! the others does not.
  subroutine mark_plane(mesh, r, active, on)
    type(mesh_t), intent(in) :: mesh
    type(request_t), intent(in) :: r
    logical, intent(in) :: active(:)
    logical, allocatable, intent(out) :: on(:)
    real(wp) :: gap

    gap = r%gap
    if (gap < 0.0_wp) then
      associate (x => mesh%xr(r%direction, :))
        gap = PLANE_SHARE*(maxval(x, active) - minval(x, active))
      end associate
      if (r%kind == R_EBOU .or. r%kind == R_EPRO) gap = gap/sqrt(real(max(1, mesh%nnode), wp))
    end if
    on = active .and. abs(mesh%xr(r%direction, :) - r%at(1)) <= gap
  end subroutine mark_plane

  !> The node nearest a point; CBOU and CDIS take all that are as near.
  subroutine mark_point(mesh, r, active, on)
    type(mesh_t), intent(in) :: mesh
    type(request_t), intent(in) :: r
    logical, intent(in) :: active(:)
    logical, allocatable, intent(out) :: on(:)
    real(wp) :: least, size
    real(wp), allocatable :: d(:)
    integer :: i

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
    if (r%kind == R_CBOU .or. r%kind == R_CDIS) then
      if (r%gap >= 0.0_wp) then
        on = active .and. d <= least + r%gap
      else ! FEAP compares squares of distances
        on = active .and. d*d <= least*least + POINT_SHARE*size*size
      end if
    else
      on(minloc(d, 1, active)) = .true.
    end if
  end subroutine mark_point

  subroutine complain(mesh, r, active, error)
    type(mesh_t), intent(in) :: mesh
    type(request_t), intent(in) :: r
    logical, intent(in) :: active(:)
    type(error_t), allocatable, intent(out) :: error

    if (.not. any(active)) then
      call fail(error, DECK_ERROR, 'the mesh has no nodes', r%place)
    else if (r%direction > 0) then
      associate (x => mesh%xr(r%direction, :))
        call fail(error, DECK_ERROR, 'no node lies on the plane x'//to_text(r%direction)//' = ' &
                  //to_text(r%at(1)), r%place, 'the mesh spans '//to_text(minval(x, active)) &
                  //' to '//to_text(maxval(x, active))//' in that direction')
      end associate
    else
      call fail(error, DECK_ERROR, 'no node lies on the surface', r%place, &
                'GAP d widens the search')
    end if
  end subroutine complain

end module input_conditions
