!> TYPE RIGId: patches that are moved, not solved for.
!!
!! Their control points are prescribed: by the MOVEs that name the patch, and fixed otherwise. A
!! rigid patch moves as one: any face of it names all of it.
module input_rigid
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: quoted
  use curve_type, only: Q_MAX_DISP
  use model, only: model_t
  use input_draft, only: build_t
  use word_patch, only: patch_named
  use input_where, only: where_t, body_index, W_FACES, W_EDGE
  implicit none
  private
  public :: is_rigid_patch, check_rigid, hold_rigid

contains

  !> A PATCh of that name is there and rigid.
  pure logical function is_rigid_patch(build, name) result(rigid)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    integer :: p

    p = patch_named(build, name)
    rigid = .false.
    if (p > 0) rigid = build%patch(p)%spec%type == 'RIGID'
  end function is_rigid_patch

  !> Records that ask for stresses or loads of a rigid patch; errors go to the list.
  subroutine check_rigid(build)
    type(build_t), intent(inout) :: build
    integer :: i, j

    do i = 1, build%npress
      associate (at => build%press(i)%at)
        if (names_rigid(build, at)) call complain(build, 'PRESsure on', at%body, at%place, &
                                                  'MOVE moves it; load the body that it touches')
      end associate
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        call check_column(build, i, j)
      end do
    end do
  end subroutine check_rigid

  subroutine check_column(build, i, j)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: i, j

    associate (c => build%curve(i)%column(j))
      if (.not. allocated(c%body) .or. c%quantity%id == Q_MAX_DISP) return
      if (.not. is_rigid_patch(build, c%body)) return
      call complain(build, 'stress or energy of', c%body, c%body_place, &
                    'ask for the body that it touches')
    end associate
  end subroutine check_column

  pure logical function names_rigid(build, at)
    type(build_t), intent(in) :: build
    type(where_t), intent(in) :: at

    names_rigid = .false.
    if (at%kind == W_FACES .or. at%kind == W_EDGE) names_rigid = is_rigid_patch(build, at%body)
  end function names_rigid

  subroutine complain(build, what, name, place, hint)
    type(build_t), intent(inout) :: build
    character(*), intent(in) :: what, name, hint
    type(place_t), intent(in) :: place
    type(error_t), allocatable :: error

    call fail(error, DECK_ERROR, what//' the rigid patch '//quoted(name), place, hint)
    call build%errors%add(error)
  end subroutine complain

  !> Prescribe all control points of the rigid patches.
  subroutine hold_rigid(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    integer :: p

    do p = 1, size(build%patch)
      if (build%patch(p)%spec%type == 'RIGID') call hold(build, model, build%patch(p)%spec%name)
    end do
  end subroutine hold_rigid

  !> One patch.
  subroutine hold(build, model, name)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    character(*), intent(in) :: name
    type(error_t), allocatable :: error
    logical, allocatable :: own(:)
    integer :: b, m, n

    b = body_index(model%mesh, name)
    allocate (own(model%mesh%nnode), source=.false.)
    associate (node => model%mesh%body(b)%node)
      own(node) = .true.
      model%bc%fixed(:, node) = max(model%bc%fixed(:, node), 1)
      if (any(abs(model%bc%value(:, node)) > 0.0_wp)) then
        call fail(error, DECK_ERROR, 'a displacement is prescribed on the rigid patch ' &
                  //quoted(name), model%mesh%body(b)%place, 'MOVE,'//name//',ALL moves it')
        call build%errors%add(error)
      end if
    end associate
    do m = 1, build%nmove
      if (names_rigid(build, build%move(m)%at)) then
        if (body_index(model%mesh, build%move(m)%at%body) == b) then
          model%bc%motion(m)%node = model%mesh%body(b)%node
        end if
      end if
      n = count(own(model%bc%motion(m)%node))
      if (n == 0 .or. n == count(own)) cycle
      call fail(error, DECK_ERROR, 'MOVE moves a part of the rigid patch '//quoted(name), &
                build%move(m)%at%place, 'MOVE,'//name//',ALL moves all of it')
      call build%errors%add(error)
    end do
  end subroutine hold

end module input_rigid
