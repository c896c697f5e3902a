!> Warnings and notes about loads, materials, rigid bodies and increments that have no effect.
module input_idle
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: quoted, to_text
  use boundary, only: boundary_t, moved_dofs
  use contact_pair, only: contact_t
  use input_draft, only: draft_t
  use input_loads, only: add_pressure
  use mesh, only: is_rigid, mesh_t
  implicit none
  private
  public :: warn_idle_loads, warn_idle_bodies, warn_increments, note_idle_materials, &
            warn_idle_transform

  real(wp), parameter :: NEGLIGIBLE = 1.0e-9_wp !! relative to the largest nodal force of a pressure

contains

  !> Log a note about materials that no body uses; included files often contain some.
  subroutine note_idle_materials(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical :: used(size(draft%model%material))
    integer :: b, m

    used = .false.
    do b = 1, size(mesh%block)
      if (.not. is_rigid(mesh%block(b))) used(mesh%block(b)%material) = .true.
    end do
    do m = 1, size(used)
      if (used(m)) cycle
      associate (set => draft%model%material(m))
        call log_line('note: no element uses material '//to_text(set%number)//', which line ' &
                      //to_text(set%place%line)//' defines')
      end associate
    end do
  end subroutine note_idle_materials

  !> Warn about the last TRANsform if nothing to which it applies has followed it.
  subroutine warn_idle_transform(draft)
    type(draft_t), intent(inout) :: draft

    if (.not. allocated(draft%idle_transform)) return
    call warn('this TRANsform has no effect: no COORdinates, NURBs, BLOCk, FORCe or DISPlacement ' &
              //'follow it', draft%idle_transform, 'it does not apply to PATCh, MESH and SPLIne: ' &
              //'move these bodies by records ROTAte and TRANslate of their own')
    deallocate (draft%idle_transform)
  end subroutine warn_idle_transform

  !> Warn about the increment of the last element of each ELEMents, which generates nothing, if the
  !! next element that it could generate has defined nodes of which some belong to no element.
  subroutine warn_increments(draft)
    type(draft_t), intent(in) :: draft
    logical, allocatable :: free(:)   ! nodes that belong to no element
    integer, allocatable :: node(:)
    integer :: e, i

    if (size(draft%last_of_set) == 0 .or. draft%nodes%top == 0) return
    free = draft%nodes%given(:draft%nodes%top)
    do e = 1, draft%elements%top
      node = draft%elements%node(:draft%elements%nen(e), e)
      free(pack(node, node <= size(free))) = .false.
    end do
    do i = 1, size(draft%last_of_set)
      associate (last => draft%last_of_set(i))
        node = draft%elements%node(:draft%elements%nen(last%number), last%number) + last%increment
        if (any(node < 1 .or. node > size(free))) cycle
        if (.not. (all(draft%nodes%given(node)) .and. any(free(node)))) cycle
        call warn('the increment '//to_text(last%increment)//' of element ' &
                  //to_text(last%number)//' generates no elements, because no other element ' &
                  //'follows in its ELEMents; node ' &
                  //to_text(node(findloc(free(node), .true., 1)))//' belongs to no element', &
                  draft%places%at(last%place), 'give the last element of the row, too, or give ' &
                  //'this one the increment 0')
      end associate
    end do
  end subroutine warn_increments

  !> Warn about each rigid body that acts on no other body, because it is in no contact and its
  !! nodes belong to no deformable element and to no constraint.
  subroutine warn_idle_bodies(mesh, contact)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical :: acts(mesh%nnode)            ! nodes of deformable elements and of constraints
    logical :: idle(0:size(mesh%body))
    integer :: b, c, e, k

    acts = .false.
    idle = .false.
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) then
        idle(mesh%block(b)%body) = .true.
      else
        do e = 1, mesh%block(b)%nelem
          acts(mesh%block(b)%conn(:, e)) = .true.
        end do
      end if
    end do
    if (.not. any(idle)) return
    associate (list => mesh%constraint)
      if (list%n > 0) then
        acts(list%slave(:list%n)) = .true.
        acts(list%master(:list%first(list%n + 1) - 1)) = .true.
      end if
    end associate
    do c = 1, size(contact)
      do k = 1, 2
        idle(mesh%block(contact(c)%side(k)%block)%body) = .false.
      end do
    end do
    do b = 1, size(mesh%body)
      if (.not. idle(b)) cycle
      if (any(acts(mesh%body(b)%node))) cycle
      call warn('the rigid body '//quoted(mesh%body(b)%name)//' acts on no other body, because ' &
                //'no CONTact names its faces', mesh%body(b)%place, 'name its faces and those ' &
                //'that they touch in a CONTact')
    end do
  end subroutine warn_idle_bodies

  !> Warn about forces on nodes that belong to no element, which have no effect. Warn about nodal
  !! forces in directions that supports or motions prescribe, if FORCe gives one of these forces or
  !! if all nodal forces act in such directions; and about pressures on faces all of whose nodes are
  !! prescribed. Such loads only change reactions.
  subroutine warn_idle_loads(draft, mesh, tied, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: tied(:)         !! (nnode) the node that replaces each node after TIE
    type(boundary_t), intent(in) :: bc
    real(wp), allocatable :: f(:, :)
    logical, allocatable :: held(:, :), acts(:, :)
    character(:), allocatable :: text
    integer :: j, n

    allocate (held(3, mesh%nnode), acts(3, mesh%nnode))
    held = bc%fixed /= 0 .or. moved_dofs(bc, mesh%nnode)
    associate (list => mesh%constraint)
      do j = 1, list%n ! a slave follows its masters
        held(:, list%slave(j)) = all(held(:, list%master(list%first(j):list%first(j + 1) - 1)), 2)
      end do
    end associate
    acts = abs(bc%force) > 0.0_wp
    n = count(any(acts, 1) .and. .not. mesh%used)
    if (n > 0) then
      call warn('forces act on nodes that belong to no element, and have no effect (number of ' &
                //'nodes: '//to_text(n)//', the first is node ' &
                //to_text(findloc(any(acts, 1) .and. .not. mesh%used, .true., 1))//')', &
                hint='compare the node numbers of FORCe with those of the elements')
      acts = acts .and. spread(mesh%used, 1, 3)
    end if
    n = count(acts .and. held)
    if (n > 0) then
      text = to_text(n)//' of '//to_text(count(acts))//' nodal forces act in directions in ' &
             //'which supports or MOVE prescribe the motion, first at node ' &
             //to_text(findloc(any(acts .and. held, 1), .true., 1))
      if (n == count(acts) .or. any_given(draft, held(:, tied))) then
        call warn(text, hint='such forces only change reactions: compare FORC, EFOR, CFOR and ' &
                  //'CSUR with BOUN, EBOU, CBOU, FIX and MOVE')
      else ! a loaded plane often ends at a support
        call log_line('note: '//text)
      end if
    end if
    if (size(bc%pressure) == 0) return
    allocate (f(3, mesh%nnode))
    do j = 1, size(bc%pressure)
      f = 0.0_wp
      call add_pressure(mesh, bc%pressure(j), f)
      acts = abs(f) > NEGLIGIBLE*maxval(abs(f))
      if (.not. any(acts) .or. any(acts .and. .not. held)) cycle
      call warn('this PRESsure acts on a face whose nodes are all prescribed by supports or MOVE', &
                bc%pressure(j)%place, 'a pressure there only changes reactions: choose another ' &
                //'face, or leave directions free with 0 in FIX or * in MOVE')
    end do
  end subroutine warn_idle_loads

  !> Does a record of FORCe give a force in a direction that is restrained or prescribed?
  pure logical function any_given(draft, held)
    type(draft_t), intent(in) :: draft
    logical, intent(in) :: held(:, :) !! (3, nnode)
    integer :: n

    any_given = .false.
    if (.not. allocated(draft%nodes%force)) return
    do n = 1, min(size(held, 2), size(draft%nodes%force, 2))
      any_given = any_given .or. any(abs(draft%nodes%force(:, n)) > 0.0_wp .and. held(:, n))
    end do
  end function any_given

end module input_idle
