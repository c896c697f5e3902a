!> FIX, MOVE, PRESsure and CURVe: from names and places to nodes, faces and elements. After TIE.
module input_resolve
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted
  use curve_type, only: curve_t, quantity_t, Q_STRESS, Q_MAX_DISP
  use model, only: model_t
  use input_draft, only: build_t, column_t
  use word_contact, only: contact_named
  use input_locate, only: locate_point
  use input_where, only: find_faces, find_nodes, body_index
  implicit none
  private
  public :: resolve_supports, resolve_loads, resolve_curves

contains

  !> FIX adds to the restraints; MOVE becomes a motion.
  subroutine resolve_supports(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer, allocatable :: node(:)
    integer :: i, j

    do i = 1, build%nsupport
      call find_nodes(model%mesh, build%support(i)%at, node, error)
      if (allocated(error)) call build%errors%add(error)
      do j = 1, size(node)
        associate (fixed => model%bc%fixed(:, node(j)))
          fixed = max(fixed, abs(build%support(i)%code))
        end associate
      end do
    end do
    allocate (model%bc%motion(build%nmove))
    do i = 1, build%nmove
      model%bc%motion(i) = build%move(i)%motion
      call find_nodes(model%mesh, build%move(i)%at, model%bc%motion(i)%node, error)
      if (allocated(error)) call build%errors%add(error)
    end do
  end subroutine resolve_supports

  !> Faces of the pressures.
  subroutine resolve_loads(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer :: i

    allocate (model%bc%pressure(build%npress))
    do i = 1, build%npress
      associate (p => model%bc%pressure(i))
        p = build%press(i)%pressure
        call find_faces(model%mesh, build%press(i)%at, p%block, p%elem, p%side, error)
      end associate
      if (allocated(error)) call build%errors%add(error)
    end do
  end subroutine resolve_loads

  subroutine resolve_curves(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer :: i, j

    allocate (model%curve(build%ncurve))
    do i = 1, build%ncurve
      associate (from => build%curve(i))
        model%curve(i)%name = from%name
        model%curve(i)%place = from%place
        allocate (model%curve(i)%quantity(size(from%column)))
        do j = 1, size(from%column)
          call resolve_column(model, from%column(j), model%curve(i)%quantity(j), error)
          if (allocated(error)) call build%errors%add(error)
          if (allocated(from%column(j)%contact)) model%curve(i)%quantity(j)%contact = &
            contact_named(build, from%column(j)%contact)
        end do
      end associate
    end do
  end subroutine resolve_curves

  subroutine resolve_column(model, column, quantity, error)
    type(model_t), intent(in) :: model
    type(column_t), intent(in) :: column
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: on(:)
    integer :: i

    quantity = column%quantity
    if (allocated(column%body)) quantity%body = body_index(model%mesh, column%body)
    if (column%at%kind /= 0) call find_nodes(model%mesh, column%at, quantity%node, error)
    if (quantity%id == Q_STRESS) then
      call locate_point(model%mesh, quantity%body, quantity%point, quantity%block, quantity%elem, &
                        quantity%xi)
      if (quantity%block > 0) return
      if (allocated(column%body)) then
        call fail(error, DECK_ERROR, 'the point lies outside patch '//quoted(column%body), &
                  quantity%place, &
                  'it is a point of the reference configuration')
      else
        call fail(error, DECK_ERROR, 'the point lies outside the mesh', quantity%place, &
                  'it is a point of the reference configuration')
      end if
    else if (quantity%id == Q_MAX_DISP) then
      on = model%mesh%used
      if (quantity%body > 0) then
        on = .false.
        on(model%mesh%body(quantity%body)%node) = .true.
        on = on .and. model%mesh%used
      end if
      quantity%node = pack([(i, i=1, model%mesh%nnode)], on)
    end if
  end subroutine resolve_column

end module input_resolve
