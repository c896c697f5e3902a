!> What the log says of contacts: bonds and warnings before the first step, contacts that close or
!! are lost in a step.
!!
!! Before the first step all points are projected in the reference configuration. Points that are
!! inside the other body already mean a press fit or a mistake; surfaces whose outward normals point
!! the same way where they are nearest are the wrong faces.
module contact_report
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_bond, only: find_bonds
  use contact_history, only: new_contact_state, had_touched
  use contact_pair, only: contact_t, contact_state_t
  use contact_type, only: OPEN
  use model, only: model_t, state_t
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use surface_geometry, only: update_shape, surface_point
  use tensor, only: cross
  implicit none
  private
  public :: start_t, look_at_start, warn_contacts, report_contact_changes

  !> Fraction of the size of an element: a smaller gap is rounding.
  real(wp), parameter :: INSIDE = 1.0e-6_wp

  !> How two surfaces are placed at the start.
  type :: start_t
    integer :: npoint = 0                !! points of both sides
    integer :: ninside = 0               !! of them, points that penetrate
    real(wp) :: deepest = 0.0_wp         !! largest penetration [L]
    real(wp) :: x(3) = 0.0_wp            !! and the point that has it [L]
    integer :: nnear = 0                 !! points about as near to the other surface as the nearest
    integer :: naway(2) = 0              !! of them, those at which side 1, side 2 faces away
  end type start_t

contains

  !> Log the bonds of all contacts, and warn of faces that look wrong and of initial penetrations.
  subroutine warn_contacts(model)
    type(model_t), intent(in) :: model
    type(contact_state_t) :: state
    type(start_t) :: start
    integer :: c, k, n(2)
    character(:), allocatable :: name

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        name = "contact '"//contact%name//"': "
        if (contact%cohesive%given) then
          call new_contact_state(contact, state)
          call find_bonds(contact, model%mesh%xr, state)
          n = [(count(state%side(k)%bond > 0), k=1, 2)]
          call log_line('contact '//contact%name//': bonded '//to_text(n(1))//' of ' &
                        //to_text(size(state%side(1)%bond))//' points of side 1, '//to_text(n(2)) &
                        //' of '//to_text(size(state%side(2)%bond))//' of side 2')
          if (sum(n) == 0) call warn(name//'no point is bonded', contact%place, 'the surfaces ' &
                                     //'are apart, or BONDed excludes all points; GAP d bonds ' &
                                     //'points up to a distance d')
        end if
        call look_at_start(contact, model%mesh%xr, start)
        if (2*sum(start%naway) > start%nnear) then
          k = merge(1, 2, start%naway(1) >= start%naway(2))
          call warn(name//contact%side(k)%name//' faces away from '//contact%side(3 - k)%name &
                    //': at '//to_text(sum(start%naway))//' of the '//to_text(start%nnear) &
                    //' nearest points both outward normals point the same way', contact%place, &
                    'check the faces; 3- and 3+, for example, are on opposite sides of a patch')
        else if (start%ninside > 0) then
          call warn(name//to_text(start%ninside)//' of '//to_text(start%npoint) &
                    //' points penetrate at the start, by up to '//to_text(start%deepest, 3) &
                    //' at ('//to_text(start%x(1), 4)//', '//to_text(start%x(2), 4)//', ' &
                    //to_text(start%x(3), 4)//')', contact%place, 'the first step pushes them ' &
                    //'out; if no press fit is intended, move one of the bodies')
        end if
      end associate
    end do
  end subroutine warn_contacts

  !> Project all points of a contact at the positions x, no farther than the thicker body and an
  !! element.
  subroutine look_at_start(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp), allocatable :: gap(:)      ! of the points that have a projection [L]
    integer, allocatable :: away(:)      ! the side that faces away there; 0: none
    real(wp) :: h, reach, near, xp(3), a(3, 2), b(3, 3)
    integer :: e, k, n, q

    h = huge(1.0_wp)
    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      if (.not. contact%side(3 - k)%rigid) call update_grid(contact%side(k), shape(k), grid(k))
      h = min(h, sum(maxval(shape(k)%high - shape(k)%low, dim=1))/max(1, contact%side(k)%nelem))
      if (contact%side(k)%rigid) cycle
      start%npoint = start%npoint + contact%side(k)%nelem*contact%nplain
    end do
    allocate (gap(start%npoint), away(start%npoint))
    reach = h + maxval(contact%side%thickness)
    n = 0
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot, reach)
          if (foot%elem == 0) cycle
          if (abs(foot%gap) <= reach) then
            n = n + 1
            gap(n) = foot%gap
            away(n) = 0
            if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp) then
              ! a point outside the other body sees its front, one inside its back
              away(n) = merge(3 - k, k, foot%gap < 0.0_wp)
            end if
          end if
          if (.not. (foot%gap < -INSIDE*h .and. touches(foot, contact%depth))) cycle
          start%ninside = start%ninside + 1
          if (-foot%gap <= start%deepest) cycle
          start%deepest = -foot%gap
          start%x = xp
        end do
      end do
    end do
    where (abs(start%x) < INSIDE*h) start%x = 0.0_wp ! rounding, not worth its digits
    ! surfaces must face each other only where they are nearest: the far side of a ball need not
    near = minval(abs(gap(:n))) + h
    start%nnear = count(abs(gap(:n)) <= near)
    start%naway = [(count(abs(gap(:n)) <= near .and. away(:n) == k), k=1, 2)]
  end subroutine look_at_start

  !> Log which contacts a step has closed or lost, before it is accepted, and warn of points that
  !! were in contact and are now deeper than DEPTh.
  subroutine report_contact_changes(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: c, k, n(2)

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), side => state%contact(c)%side)
        do k = 1, 2
          n(k) = count(side(k)%state_step /= OPEN .and. side(k)%state == OPEN &
                       .and. side(k)%closest > 0 .and. side(k)%gap < -contact%depth)
        end do
        if (sum(n) > 0 .and. .not. state%contact(c)%depth_warned) then
          state%contact(c)%depth_warned = .true.
          call warn("contact '"//contact%name//"': "//to_text(sum(n))//' points in contact ' &
                    //'penetrate deeper than '//to_text(contact%depth)//' (DEPTh) and are no ' &
                    //'longer in contact: the bodies pass through each other', contact%place, &
                    'use a stiffer penalty or a larger DEPTh')
        end if
        n = [(count(side(k)%state /= OPEN), k=1, 2)]
        if (had_touched(state%contact(c)) .eqv. any(n > 0)) cycle
        if (any(n > 0)) then
          call log_line('contact '//contact%name//': closed, '//to_text(n(1))//' + ' &
                        //to_text(n(2))//' points in contact')
        else
          call log_line('contact '//contact%name//': lost, no point is in contact')
        end if
      end associate
    end do
  end subroutine report_contact_changes

end module contact_report
