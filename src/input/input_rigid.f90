!> TYPE RIGId: patches whose motion is prescribed, so that their displacements are not unknowns.
!!
!! The displacements of their control points are prescribed by the MOVEs that name the patch, and
!! zero otherwise. A rigid patch moves as a whole: any of its faces stands for the whole patch.
module input_rigid
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: quoted, to_text
  use curve_type, only: quantity_t, Q_MAX_DISP
  use input_draft, only: draft_t
  use input_where, only: where_t, body_index, W_FACES, W_EDGE
  use mesh, only: mesh_t, mark_rigid
  use model, only: model_t
  use word_patch, only: patch_named
  implicit none
  private
  public :: is_rigid_patch, check_rigid, hold_rigid, warn_part_of_rigid

contains

  !> Is there a rigid PATCh or SPLIne of that name?
  pure logical function is_rigid_patch(draft, name) result(rigid)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name
    integer :: p

    p = patch_named(draft, name)
    rigid = .false.
    if (p > 0) rigid = draft%patch(p)%spec%type == 'RIGID'
  end function is_rigid_patch

  !> Fail if records load a rigid patch or need its stresses or energy; errors go to `draft%errors`.
  subroutine check_rigid(draft)
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable :: error
    integer :: i, j

    do i = 1, draft%npressure
      associate (at => draft%pressure(i)%at)
        if (.not. names_rigid(draft, at)) cycle
        call fail(error, DECK_ERROR, 'PRESsure acts on the rigid patch '//quoted(at%body), &
                  at%place, 'move the patch with MOVE, or load the body that it touches')
        call draft%errors%add(error)
      end associate
    end do
    do i = 1, draft%ncurve
      do j = 1, size(draft%curve(i)%column)
        associate (c => draft%curve(i)%column(j))
          if (.not. allocated(c%body) .or. c%quantity%id == Q_MAX_DISP) cycle
          if (.not. is_rigid_patch(draft, c%body)) cycle
          call fail(error, DECK_ERROR, 'the rigid patch '//quoted(c%body) &
                    //' has no stress and no energy', c%body_place, &
                    'name the body that it touches')
          call draft%errors%add(error)
        end associate
      end do
    end do
  end subroutine check_rigid

  !> Does a place name a rigid patch?
  pure logical function names_rigid(draft, at)
    type(draft_t), intent(in) :: draft
    type(where_t), intent(in) :: at

    names_rigid = .false.
    if (at%type == W_FACES .or. at%type == W_EDGE) names_rigid = is_rigid_patch(draft, at%body)
  end function names_rigid

  !> Prescribe the displacements of all control points of the rigid patches.
  subroutine hold_rigid(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    character(:), allocatable :: name
    logical, allocatable :: own(:)
    integer :: p, b, m, n

    do p = 1, size(draft%patch)
      if (draft%patch(p)%spec%type /= 'RIGID') cycle
      name = draft%patch(p)%spec%name
      b = body_index(model%mesh, name)
      own = [(.false., n=1, model%mesh%nnode)]
      associate (node => model%mesh%body(b)%node, bc => model%bc)
        own(node) = .true.
        bc%fixed(:, node) = max(bc%fixed(:, node), 1)
        if (any(abs(bc%value(:, node)) > 0.0_wp)) then
          call fail(error, DECK_ERROR, 'a displacement is prescribed on the rigid patch ' &
                    //quoted(name), model%mesh%body(b)%place, 'move the patch with MOVE,'//name &
                    //',ALL')
          call draft%errors%add(error)
        end if
        do m = 1, draft%nmotion
          if (names_rigid(draft, draft%motion(m)%at)) then
            if (body_index(model%mesh, draft%motion(m)%at%body) == b) bc%motion(m)%node = node
          end if
          n = count(own(bc%motion(m)%node))
          if (n == 0 .or. n == count(own)) cycle
          call fail(error, DECK_ERROR, 'MOVE moves only a part of the rigid patch '//quoted(name), &
                    draft%motion(m)%at%place, 'move all of it with MOVE,'//name//',ALL')
          call draft%errors%add(error)
        end do
      end associate
    end do
  end subroutine hold_rigid

  !> Warn about a sum of reactions over single nodes of a rigid patch. Only the sum over the whole
  !! patch has a meaning, because its nodes may lie far from the surfaces that touch it.
  subroutine warn_part_of_rigid(mesh, quantity)
    type(mesh_t), intent(in) :: mesh
    type(quantity_t), intent(in) :: quantity
    logical, allocatable :: rigid(:)
    character(:), allocatable :: text
    integer :: n

    call mark_rigid(mesh, rigid)
    n = count(rigid(quantity%node))
    if (n == 0) return
    if (size(quantity%node) == 1) then
      text = 'node '//to_text(quantity%node(1))//' belongs to a rigid patch; the force at a ' &
             //'single node of a rigid patch has no meaning'
    else
      text = to_text(n)//' of the '//to_text(size(quantity%node))//' nodes belong to rigid ' &
             //'patches; forces at single nodes of a rigid patch have no meaning'
    end if
    call warn(text, quantity%place, 'FORCe of a CURVe with a face of the rigid patch gives its ' &
              //'whole reaction')
  end subroutine warn_part_of_rigid

end module input_rigid
