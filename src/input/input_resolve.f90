!> FIX, MOVE, PRESsure and CURVe: finds, after TIE, the nodes, faces and elements that their places
!! name.
module input_resolve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: quoted, to_text
  use boundary, only: pressure_t
  use curve_type, only: Q_FORCE, Q_TORQUE, Q_STRESS, Q_MAX_DISP
  use input_draft, only: draft_t
  use input_locate, only: locate_point
  use input_rigid, only: is_rigid_patch, warn_part_of_rigid
  use input_where, only: where_t, find_faces, find_nodes, body_index, W_NODE
  use mesh, only: mesh_t, is_rigid
  use model, only: model_t
  use word_contact, only: contact_named
  implicit none
  private
  public :: follow_ties, resolve_supports, resolve_loads, resolve_curves

contains

  !> Let NODE n of FIX, MOVE and CURVe name the node that replaces node n after TIE.
  subroutine follow_ties(draft, new)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: new(:) !! (nnode)
    integer :: i, j

    do i = 1, draft%nsupport
      call follow(draft%support(i)%at)
    end do
    do i = 1, draft%nmotion
      call follow(draft%motion(i)%at)
    end do
    do i = 1, draft%ncurve
      do j = 1, size(draft%curve(i)%column)
        call follow(draft%curve(i)%column(j)%at)
      end do
    end do

  contains

    subroutine follow(at)
      type(where_t), intent(inout) :: at

      if (at%type /= W_NODE .or. at%node < 1 .or. at%node > size(new)) return
      at%node = new(at%node)
    end subroutine follow

  end subroutine follow_ties

  !> Find the nodes of FIX and MOVE records. FIX adds restraints, and MOVE becomes a prescribed
  !! motion.
  subroutine resolve_supports(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer, allocatable :: node(:)
    integer :: i, j

    do i = 1, draft%nsupport
      call find_nodes(model%mesh, draft%support(i)%at, node, error, all_near=.true., &
                      no_rigid=.true.)
      if (allocated(error)) call draft%errors%add(error)
      do j = 1, size(node)
        associate (fixed => model%bc%fixed(:, node(j)))
          fixed = max(fixed, abs(draft%support(i)%code))
        end associate
      end do
      call move_alloc(node, draft%support(i)%node)
    end do
    allocate (model%bc%motion(draft%nmotion))
    do i = 1, draft%nmotion
      model%bc%motion(i) = draft%motion(i)%motion
      call find_nodes(model%mesh, draft%motion(i)%at, model%bc%motion(i)%node, error, &
                      all_near=.true., no_rigid=.false.)
      if (allocated(error)) call draft%errors%add(error)
    end do
  end subroutine resolve_supports

  !> Find the faces of the pressures.
  subroutine resolve_loads(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer :: i

    allocate (model%bc%pressure(draft%npressure))
    do i = 1, draft%npressure
      associate (p => model%bc%pressure(i))
        p = draft%pressure(i)%pressure
        call find_faces(model%mesh, draft%pressure(i)%at, p%block, p%elem, p%side, error)
      end associate
      if (allocated(error)) call draft%errors%add(error)
    end do
    if (draft%errors%count() > 0) return
    do i = 2, draft%npressure
      call warn_repeated(model%bc%pressure(:i))
    end do
  end subroutine resolve_loads

  !> Warn if the last of the given pressures is equal to an earlier one.
  subroutine warn_repeated(pressure)
    type(pressure_t), intent(in) :: pressure(:)
    character(:), allocatable :: follows
    integer :: i

    associate (p => pressure(size(pressure)))
      do i = 1, size(pressure) - 1
        associate (q => pressure(i))
          if (size(p%elem) /= size(q%elem) .or. p%table /= q%table) cycle
          if (abs(p%value - q%value) > 0.0_wp .or. .not. abs(p%value) > 0.0_wp) cycle
          if (any(p%block /= q%block .or. p%elem /= q%elem .or. p%side /= q%side)) cycle
          follows = ''
          if (p%follower .and. .not. q%follower) follows = ' without FOLLower'
          if (q%follower .and. .not. p%follower) follows = ' with FOLLower'
          call warn('the same PRESsure is already given in line '//to_text(q%place%line)//follows &
                    //', so the face bears the sum of both', p%place, &
                    'remove one of them, or give the sum in one record')
          return
        end associate
      end do
    end associate
  end subroutine warn_repeated

  !> Find the nodes, bodies, contacts and elements of the curves.
  subroutine resolve_curves(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    character(:), allocatable :: body
    logical :: whole
    logical, allocatable :: on(:)
    integer :: i, j, n

    allocate (model%curve(draft%ncurve))
    do i = 1, draft%ncurve
      model%curve(i)%name = draft%curve(i)%name
      model%curve(i)%place = draft%curve(i)%place
      allocate (model%curve(i)%quantity(size(draft%curve(i)%column)))
      do j = 1, size(draft%curve(i)%column)
        associate (column => draft%curve(i)%column(j), quantity => model%curve(i)%quantity(j), &
                   mesh => model%mesh)
          quantity = column%quantity
          if (allocated(column%body)) quantity%body = body_index(mesh, column%body)
          if (allocated(column%contact)) quantity%contact = contact_named(draft, column%contact)
          if (column%at%type /= 0) then
            call find_nodes(mesh, column%at, quantity%node, error, no_rigid=.false., &
                            all_near=any(quantity%id == [Q_FORCE, Q_TORQUE]))
            if (allocated(error)) call draft%errors%add(error)
            if (any(quantity%id == [Q_FORCE, Q_TORQUE])) then
              whole = allocated(column%at%body)
              if (whole) whole = is_rigid_patch(draft, column%at%body)
              if (whole) then ! the whole reaction of its supports
                quantity%node = mesh%body(body_index(mesh, column%at%body))%node
              else
                call warn_part_of_rigid(mesh, quantity)
              end if
            end if
          end if
          if (quantity%id == Q_STRESS) then
            call locate_point(mesh, quantity%body, quantity%point, quantity%block, quantity%elem, &
                              quantity%xi)
            if (quantity%block > 0) cycle
            body = 'the mesh'
            if (allocated(column%body)) body = 'patch '//quoted(column%body)
            call fail(error, DECK_ERROR, 'the point lies outside '//body, quantity%place, &
                      'give its coordinates in the reference configuration')
            call draft%errors%add(error)
          else if (quantity%id == Q_MAX_DISP) then
            on = mesh%used
            if (quantity%body > 0) then
              on = .false.
              on(mesh%body(quantity%body)%node) = .true.
              on = on .and. mesh%used
            end if
            quantity%node = pack([(n, n=1, mesh%nnode)], on)
          end if
        end associate
      end do
    end do
  end subroutine resolve_curves

end module input_resolve
