!> TYPE RIGId: patches that are moved, not solved for.
!!
!! Their control points are prescribed: by the MOVEs that name the patch, and fixed otherwise. A
!! rigid patch moves as a whole: any of its faces stands for the whole patch.
module input_rigid
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: quoted
  use curve_type, only: Q_MAX_DISP
  use input_draft, only: build_t
  use input_where, only: where_t, body_index, W_FACES, W_EDGE
  use model, only: model_t
  use word_patch, only: patch_named
  implicit none
  private
  public :: is_rigid_patch, check_rigid, hold_rigid

contains

  !> Is there a rigid PATCh of that name?
  pure logical function is_rigid_patch(build, name) result(rigid)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    integer :: p

    p = patch_named(build, name)
    rigid = .false.
    if (p > 0) rigid = build%patch(p)%spec%type == 'RIGID'
  end function is_rigid_patch

  !> Fails where records load a rigid patch or need its stresses; errors go to the list.
  subroutine check_rigid(build)
    type(build_t), intent(inout) :: build
    type(error_t), allocatable :: error
    integer :: i, j

    do i = 1, build%npress
      associate (at => build%press(i)%at)
        if (.not. names_rigid(build, at)) cycle
        call fail(error, DECK_ERROR, 'PRESsure acts on the rigid patch '//quoted(at%body), &
                  at%place, 'move the patch by MOVE, or load the body that it touches')
        call build%errors%add(error)
      end associate
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        associate (c => build%curve(i)%column(j))
          if (.not. allocated(c%body) .or. c%quantity%id == Q_MAX_DISP) cycle
          if (.not. is_rigid_patch(build, c%body)) cycle
          call fail(error, DECK_ERROR, 'the rigid patch '//quoted(c%body) &
                    //' has no stress and no energy', c%body_place, &
                    'name the body that it touches')
          call build%errors%add(error)
        end associate
      end do
    end do
  end subroutine check_rigid

  !> Does a place name a rigid patch?
  pure logical function names_rigid(build, at)
    type(build_t), intent(in) :: build
    type(where_t), intent(in) :: at

    names_rigid = .false.
    if (at%kind == W_FACES .or. at%kind == W_EDGE) names_rigid = is_rigid_patch(build, at%body)
  end function names_rigid

  !> Prescribe all control points of the rigid patches.
  subroutine hold_rigid(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    character(:), allocatable :: name
    logical, allocatable :: own(:)
    integer :: p, b, m, n

    do p = 1, size(build%patch)
      if (build%patch(p)%spec%type /= 'RIGID') cycle
      name = build%patch(p)%spec%name
      b = body_index(model%mesh, name)
      own = [(.false., n=1, model%mesh%nnode)]
      associate (node => model%mesh%body(b)%node, bc => model%bc)
        own(node) = .true.
        bc%fixed(:, node) = max(bc%fixed(:, node), 1)
        if (any(abs(bc%value(:, node)) > 0.0_wp)) then
          call fail(error, DECK_ERROR, 'a displacement is prescribed on the rigid patch ' &
                    //quoted(name), model%mesh%body(b)%place, 'move it by MOVE,'//name//',ALL')
          call build%errors%add(error)
        end if
        do m = 1, build%nmove
          if (names_rigid(build, build%move(m)%at)) then
            if (body_index(model%mesh, build%move(m)%at%body) == b) bc%motion(m)%node = node
          end if
          n = count(own(bc%motion(m)%node))
          if (n == 0 .or. n == count(own)) cycle
          call fail(error, DECK_ERROR, 'MOVE moves only a part of the rigid patch '//quoted(name), &
                    build%move(m)%at%place, 'move all of it by MOVE,'//name//',ALL')
          call build%errors%add(error)
        end do
      end associate
    end do
  end subroutine hold_rigid

end module input_rigid
