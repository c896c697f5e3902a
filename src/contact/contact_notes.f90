!> What is said of contacts before the first step, and when the last point parts.
!!
!! Before the first step all points are projected in the reference configuration. Points that lie
!! inside the other body already are a press fit or a mistake; surfaces whose outward normals point
!! the same way where they are nearest are the wrong faces.
module contact_notes
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_bond, only: find_bonds
  use projection_type, only: foot_t, shape_t, touches
  use contact_history, only: new_contact_state, had_touched
  use contact_pair, only: contact_t, contact_state_t, surface_t
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use surface_geometry, only: update_shape, surface_point
  use contact_type, only: OPEN
  use model, only: model_t, state_t
  use tensor, only: cross
  implicit none
  private
  public :: start_t, look_at_start, warn_contacts, note_lost_contacts

  real(wp), parameter :: INSIDE = 1.0e-6_wp !! of an element's size: a gap below is no rounding

  !> How two surfaces stand to each other at the start.
  type :: start_t
    integer :: npoint = 0                !! points of both sides
    integer :: ninside = 0               !! of them, points that penetrate
    real(wp) :: deepest = 0.0_wp         !! the deepest of these [L]
    real(wp) :: x(3) = 0.0_wp            !! and where it is [L]
    integer :: nnear = 0                 !! points about as near to the other surface as the nearest
    integer :: naway(2) = 0              !! of them, those at which side 1, side 2 faces away
  end type start_t

  !> Points of both sides that have a foot.
  type :: points_t
    integer :: n = 0
    integer, allocatable :: side(:)
    real(wp), allocatable :: gap(:)      !! [L]
    logical, allocatable :: same(:)      !! both normals point the same way
  end type points_t

contains

  !> How many points a cohesive contact bonds.
  subroutine note_bonds(contact, xr)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)     !! (3, nnode) [L]
    type(contact_state_t) :: state
    integer :: k, n(2)

    if (.not. contact%has_cohesive) return
    call new_contact_state(contact, state)
    call find_bonds(contact, xr, state)
    do k = 1, 2
      n(k) = count(state%side(k)%bond > 0)
    end do
    call log_line('contact '//contact%name//': bonded '//to_text(n(1))//' of ' &
                  //to_text(size(state%side(1)%bond))//' points of side 1, '//to_text(n(2)) &
                  //' of '//to_text(size(state%side(2)%bond))//' of side 2')
    if (sum(n) == 0) call warn("contact '"//contact%name//"': no point is bonded", contact%place, &
                               'the surfaces lie apart, or BONDed leaves nothing; GAP d allows d')
  end subroutine note_bonds

  !> Warnings of all contacts.
  subroutine warn_contacts(model)
    type(model_t), intent(in) :: model
    type(start_t) :: start
    integer :: c, k
    character(:), allocatable :: name

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        call note_bonds(contact, model%mesh%xr)
        call look_at_start(contact, model%mesh%xr, start)
        name = "contact '"//contact%name//"': "
        if (2*sum(start%naway) > start%nnear) then
          k = merge(1, 2, start%naway(1) >= start%naway(2))
          call warn(name//contact%side(k)%name//' faces away from '//contact%side(3 - k)%name &
                    //': at '//to_text(sum(start%naway))//' of the '//to_text(start%nnear) &
                    //' nearest points both outward normals point the same way', contact%place, &
                    'is the face right? 3- and 3+, for one, lie on opposite sides of a patch')
        else if (start%ninside > 0) then
          call warn(name//to_text(start%ninside)//' of '//to_text(start%npoint) &
                    //' points penetrate at the start, by up to '//to_text(start%deepest, 3) &
                    //' at ('//to_text(start%x(1), 4)//', '//to_text(start%x(2), 4)//', ' &
                    //to_text(start%x(3), 4)//')', contact%place, &
                    'the first step pushes them out; where no press fit is meant, move a body')
        end if
      end associate
    end do
  end subroutine warn_contacts

  !> Project all points of a contact at the positions x.
  subroutine look_at_start(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(points_t) :: points
    real(wp) :: h
    integer :: k, np

    h = huge(1.0_wp)
    np = 0
    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      if (.not. contact%side(3 - k)%rigid) call update_grid(contact%side(k), shape(k), grid(k))
      h = min(h, element_size(shape(k)))
      if (.not. contact%side(k)%rigid) np = np + contact%side(k)%nelem*contact%nplain
    end do
    start%npoint = np
    allocate (points%side(np), points%gap(np), points%same(np))
    do k = 1, 2
      if (.not. contact%side(k)%rigid) call find_feet(contact, k, shape, grid(3 - k), h, points, &
                                                      start)
    end do
    where (abs(start%x) < INSIDE*h) start%x = 0.0_wp ! rounding, not worth its digits
    call compare_normals(h, points, start)
  end subroutine look_at_start

  !> Mean extent of the elements.
  pure function element_size(shape) result(h)
    type(shape_t), intent(in) :: shape
    real(wp) :: h                        !! [L]

    h = sum(maxval(shape%high - shape%low, dim=1))/max(1, size(shape%low, 2))
  end function element_size

  !> Feet of the points of side k, an element beyond the far side of the thicker body at most.
  subroutine find_feet(contact, k, shape, grid, h, points, start)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape(2)
    type(grid_t), intent(in) :: grid     !! of the other side
    real(wp), intent(in) :: h            !! size of an element [L]
    type(points_t), intent(inout) :: points
    type(start_t), intent(inout) :: start
    type(foot_t) :: foot
    real(wp) :: x(3), a(3, 2), b(3, 3), reach
    integer :: e, q

    reach = h + maxval(contact%side%thickness)
    do e = 1, contact%side(k)%nelem
      do q = 1, contact%nplain
        call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), x, a, b)
        foot%elem = 0
        call project(contact%side(3 - k), shape(3 - k), grid, x, foot, reach)
        if (foot%elem == 0) cycle
        if (abs(foot%gap) <= reach) then
          points%n = points%n + 1
          points%side(points%n) = k
          points%gap(points%n) = foot%gap
          points%same(points%n) = dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp
        end if
        if (.not. (foot%gap < -INSIDE*h .and. touches(foot, contact%depth))) cycle
        start%ninside = start%ninside + 1
        if (-foot%gap <= start%deepest) cycle
        start%deepest = -foot%gap
        start%x = x
      end do
    end do
  end subroutine find_feet

  !> Only where the surfaces are nearest must they face each other: the far side of a ball need not.
  !! A point outside the other body sees it, so that its own side faces away; one inside sees its
  !! back.
  subroutine compare_normals(h, points, start)
    real(wp), intent(in) :: h            !! size of an element [L]
    type(points_t), intent(in) :: points
    type(start_t), intent(inout) :: start
    real(wp) :: near
    integer :: i, k

    near = minval(abs(points%gap(:points%n))) + h
    do i = 1, points%n
      if (abs(points%gap(i)) > near) cycle
      start%nnear = start%nnear + 1
      if (.not. points%same(i)) cycle
      k = points%side(i)
      if (points%gap(i) < 0.0_wp) k = 3 - k
      start%naway(k) = start%naway(k) + 1
    end do
  end subroutine compare_normals

  !> A step is about to be accepted: say which contacts it has closed or lost.
  subroutine note_lost_contacts(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: c, n(2)

    do c = 1, size(model%contact)
      call warn_passed(model%contact(c), state%contact(c))
      associate (side => state%contact(c)%side)
        n = [count(side(1)%state /= OPEN), count(side(2)%state /= OPEN)]
      end associate
      if (had_touched(state%contact(c)) .eqv. any(n > 0)) cycle
      if (any(n > 0)) then
        call log_line('contact '//model%contact(c)%name//': closed, '//to_text(n(1))//' + ' &
                      //to_text(n(2))//' points touch')
      else
        call log_line('contact '//model%contact(c)%name//': lost, no point touches any more')
      end if
    end do
  end subroutine note_lost_contacts

  !> Points that were in contact and are now deeper than DEPTh: the bodies pass through each other.
  subroutine warn_passed(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(inout) :: state
    integer :: k, n

    if (state%passed) return
    n = 0
    do k = 1, 2
      associate (side => state%side(k))
        n = n + count(side%state_step /= OPEN .and. side%state == OPEN .and. side%foot > 0 &
                      .and. side%gap < -contact%depth)
      end associate
    end do
    state%passed = n > 0
    if (state%passed) then
      call warn("contact '"//contact%name//"': "//to_text(n)//' points in contact got deeper ' &
                //'than '//to_text(contact%depth)//' (DEPTh): they are none now, the bodies pass ' &
                //'through each other', contact%place, 'a stiffer penalty, or a larger DEPTh')
    end if
  end subroutine warn_passed

end module contact_notes
