!> FIX, MOVE, PRESsure and CURVe: finds, after TIE, the nodes, faces and elements that their places
!! name.
module input_resolve
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: quoted, to_text
  use boundary, only: pressure_t
  use curve_type, only: Q_FORCE, Q_TORQUE, Q_STRESS, Q_MAX_DISP
  use element_type, only: cell_t
  use input_draft, only: draft_t
  use input_rigid, only: is_rigid_patch, warn_part_of_rigid
  use input_where, only: find_faces, find_nodes, body_index
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use model, only: model_t
  use tensor, only: det3
  use word_contact, only: contact_named
  implicit none
  private
  public :: resolve_supports, resolve_loads, resolve_curves, locate_point

  integer, parameter :: MAX_ITER = 50
  real(wp), parameter :: OUTSIDE = 1.0e-6_wp    !! a point this far outside an element, in parent
  !! coordinates, still counts as inside
  real(wp), parameter :: WIDER = 0.5_wp !! margin of the box around an element's nodes relative to
  !! its size, because a curved element may extend beyond its nodes
  real(wp), parameter :: SINGULAR = 1.0e-10_wp  !! a map is singular below this determinant,
  !! relative to the product of the lengths of its columns

contains

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

  !> Find the first element that contains a reference point. `block` is 0 if there is none.
  subroutine locate_point(mesh, body, x, block, elem, xi)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body     !! index of a body; 0: the whole mesh without rigid bodies
    real(wp), intent(in) :: x(3)    !! [L]
    integer, intent(out) :: block, elem
    real(wp), intent(out) :: xi(3)  !! parent coordinates
    real(wp), allocatable :: xe(:, :)
    real(wp) :: low(3), high(3), margin
    logical :: inside
    integer :: b, e

    do b = 1, size(mesh%block)
      if (body > 0 .and. mesh%block(b)%body /= body) cycle
      if (body == 0 .and. is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        xe = mesh%xr(:, mesh%block(b)%conn(:, e))
        low = minval(xe, 2)
        high = maxval(xe, 2)
        margin = WIDER*maxval(high - low) + rounding_of(x)
        if (any(x < low - margin) .or. any(x > high + margin)) cycle
        call invert_map(mesh%block(b), e, xe, x, xi, inside)
        if (.not. inside) cycle
        block = b
        elem = e
        return
      end do
    end do
    block = 0
    elem = 0
    xi = 0.0_wp
  end subroutine locate_point

  !> Rounding error of the difference between a point and a nearby node.
  pure real(wp) function rounding_of(x)
    real(wp), intent(in) :: x(3)    !! [L]

    rounding_of = 4.0_wp*epsilon(1.0_wp)*maxval(abs(x))
  end function rounding_of

  !> Solve x(xi) = x by Newton's method from the middle of the element; each step uses Cramer's
  !! rule. Positions are taken relative to the first node, so that the error does not grow with the
  !! distance of the element from the origin.
  subroutine invert_map(block, e, xe, x, xi, inside)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    real(wp), intent(in) :: xe(:, :), x(3) !! (3, nen) nodes, point [L]
    real(wp), intent(out) :: xi(3)
    logical, intent(out) :: inside
    type(cell_t) :: cell
    real(wp) :: shp(block%nen), dshp(3, block%nen), jac(3, 3), column(3, 3), r(3), step(3), det
    real(wp) :: node(3, block%nen), size_of
    integer :: it, i

    call block_cell(block, e, cell)
    node = xe - spread(xe(:, 1), 2, block%nen)
    xi = 0.0_wp
    inside = .false.
    do it = 1, MAX_ITER
      call block%row%functions(cell, xi, shp, dshp)
      jac = matmul(node, transpose(dshp))
      det = det3(jac)
      if (.not. abs(det) > SINGULAR*norm2(jac(:, 1))*norm2(jac(:, 2))*norm2(jac(:, 3))) return
      r = (x - xe(:, 1)) - matmul(node, shp)
      do i = 1, 3
        column = jac
        column(:, i) = r
        step(i) = det3(column)/det
      end do
      xi = xi + step
      if (maxval(abs(xi)) > 3.0_wp) return
      if (maxval(abs(step)) < 1.0e-12_wp) exit
    end do
    size_of = min(norm2(jac(:, 1)), norm2(jac(:, 2)), norm2(jac(:, 3)))
    inside = maxval(abs(xi)) <= 1.0_wp + OUTSIDE + rounding_of(x)/size_of .and. it <= MAX_ITER
    xi = max(-1.0_wp, min(1.0_wp, xi))
  end subroutine invert_map

end module input_resolve
