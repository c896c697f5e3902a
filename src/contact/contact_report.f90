!> What the log says of contacts: bonds and warnings before the first step, contacts that close or
!! are lost in a step.
!!
!! Before the first step all points are projected in the reference configuration. Points that are
!! inside the other body already mean a press fit or a mistake; if the outward normals of two
!! surfaces point the same way where these are nearest, the deck names the wrong faces.
module contact_report
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_bond, only: find_bonds
  use contact_history, only: new_contact_state, had_touched
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, MORTAR
  use contact_resultant, only: resultant_t, side_resultant
  use contact_type, only: OPEN, STICK, NORMAL
  use model, only: model_t, state_t
  use projection, only: project
  use projection_search, only: grid_t, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use surface_geometry, only: update_shape, surface_point
  use tensor, only: cross
  implicit none
  private
  public :: start_t, look_at_start, warn_contacts, report_contact_changes, measure_contacts, &
            find_jump, warn_soft_penalty

  !> Fraction of the size of an element: a smaller gap is rounding.
  real(wp), parameter :: INSIDE = 1.0e-6_wp
  real(wp), parameter :: UNBALANCED = 0.02_wp !! difference of the forces that is worth a warning
  real(wp), parameter :: TOO_DEEP = 0.02_wp   !! and penetration, relative to an element
  real(wp), parameter :: HALF = 0.5_wp        !! of a motion
  real(wp), parameter :: SOFT = 0.2_wp        !! of the work of supports and loads, by penetration
  real(wp), parameter :: NEAREST = 0.01_wp    !! of an element's width: gaps that are hardly larger
  real(wp), parameter :: NO_FORCE = 1.0e-9_wp !! relative to the largest force so far

  !> How two surfaces are placed at the start.
  type :: start_t
    integer :: npoint = 0                !! points of both sides
    integer :: ninside = 0               !! of them, points that penetrate
    real(wp) :: deepest = 0.0_wp         !! largest penetration [L]
    real(wp) :: x(3) = 0.0_wp            !! and the point that has it [L]
    integer :: nnear = 0                 !! points about as near the other surface as the nearest
    integer :: naway(2) = 0              !! of them, where side 1 and where side 2 faces away
    real(wp) :: overlap = 0.0_wp         !! largest penetration beyond DEPTh, not through a body [L]
    real(wp) :: x_overlap(3) = 0.0_wp    !! the point that has it [L]
    integer :: nbehind = 0               !! nearest points that are behind the whole other body
    real(wp) :: width(2) = 0.0_wp        !! mean width of the elements that are nearest [L]
    real(wp) :: gap = huge(1.0_wp)       !! smallest gap of a point outside the other body [L]
    real(wp) :: x_gap(3) = 0.0_wp        !! the point that has it [L]
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
        else if (start%nnear > 0 .and. 2*start%nbehind > start%nnear) then
          call warn(name//'the faces '//contact%side(1)%name//' and '//contact%side(2)%name &
                    //' face away from each other: a whole body lies between them', &
                    contact%place, 'check the faces; 3- and 3+, for example, are on opposite ' &
                    //'sides of a patch')
        else if (start%nnear == 0) then
          call warn(name//'the faces '//contact%side(1)%name//' and '//contact%side(2)%name &
                    //' are not opposite each other at the start', contact%place, &
                    'they touch only if a motion brings them together')
        else if (start%ninside > 0) then
          call warn(name//to_text(start%ninside)//' of '//to_text(start%npoint) &
                    //' points penetrate at the start, by up to '//to_text(start%deepest, 3) &
                    //' at ('//to_text(start%x(1), 4)//', '//to_text(start%x(2), 4)//', ' &
                    //to_text(start%x(3), 4)//')', contact%place, 'the first step pushes them ' &
                    //'out; if no press fit is intended, move one of the bodies')
        else if (start%gap < huge(start%gap)) then
          call log_line('contact '//contact%name//': smallest gap at the start ' &
                        //to_text(start%gap, 3)//' at ('//to_text(start%x_gap(1), 4)//', ' &
                        //to_text(start%x_gap(2), 4)//', '//to_text(start%x_gap(3), 4)//')')
        end if
      end associate
    end do
  end subroutine warn_contacts

  !> Project all points of a contact at the positions x, no farther than the thickness of the
  !! thicker body plus the width of an element.
  subroutine look_at_start(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp), allocatable :: gap(:)      ! of the points that have a projection [L]
    integer, allocatable :: away(:)      ! the side that faces away there; 0: none
    real(wp), allocatable :: reach_of(:, :) ! distance of an element to the other surface [L]
    logical, allocatable :: behind(:)    ! it is behind the other body
    real(wp) :: thin                     ! thickness of the thinner body [L]; huge: unknown
    real(wp) :: h, reach, near, beside, xp(3), a(3, 2), b(3, 3)
    integer :: e, k, n, q

    h = huge(1.0_wp)
    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      if (.not. contact%side(3 - k)%rigid) call update_grid(contact%side(k), shape(k), grid(k))
      h = min(h, sum(maxval(shape(k)%high - shape(k)%low, dim=1))/max(1, contact%side(k)%nelem))
      if (contact%side(k)%rigid) cycle
      start%npoint = start%npoint + contact%side(k)%nelem*contact%nplain
    end do
    allocate (reach_of(maxval(contact%side%nelem), 2), source=huge(h))
    allocate (gap(start%npoint), away(start%npoint), behind(start%npoint))
    thin = huge(thin)
    if (any(contact%side%thickness > 0.0_wp)) thin = minval(contact%side%thickness, &
                                                            contact%side%thickness > 0.0_wp)
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
            reach_of(e, k) = min(reach_of(e, k), abs(foot%gap))
            away(n) = 0
            behind(n) = foot%gap < -thin*(1.0_wp - INSIDE)
            if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp) then
              ! from outside the other body one sees its front, from inside its back
              away(n) = merge(3 - k, k, foot%gap < 0.0_wp)
            end if
          end if
          if (foot%gap >= 0.0_wp .and. foot%gap < start%gap) then
            start%gap = foot%gap
            start%x_gap = xp
          end if
          if (foot%gap < -contact%depth .and. foot%gap > -thin*(1.0_wp - INSIDE) .and. &
              -foot%gap > start%overlap) then
            if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) < 0.0_wp) then
              start%overlap = -foot%gap
              start%x_overlap = xp
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
    where (abs(start%x) < INSIDE*h) start%x = 0.0_wp ! rounding, whose digits mean nothing
    ! surfaces must face each other only where they are nearest: the far side of a ball need not
    near = minval(abs(gap(:n))) + h
    do k = 1, 2
      associate (width => contact%side(k)%width)
        if (.not. allocated(contact%side(k)%width)) cycle
        ! on graded meshes a wider band would take in large elements far from the contact
        beside = huge(beside)
        if (any(reach_of(:size(width), k) < huge(h))) then
          e = minloc(reach_of(:size(width), k), dim=1)
          beside = reach_of(e, k) + NEAREST*width(e)
        end if
        e = count(reach_of(:size(width), k) <= beside)
        start%width(k) = sqrt(sum(width**2, mask=reach_of(:size(width), k) <= beside)/max(1, e))
      end associate
    end do
    start%nnear = count(abs(gap(:n)) <= near)
    start%nbehind = count(abs(gap(:n)) <= near .and. behind(:n))
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
          call warn("contact '"//contact%name//"': "//to_text(sum(n))//' points that were ' &
                    //'in contact are deeper than '//to_text(contact%depth)//' (DEPTh) and no ' &
                    //'longer count as contact: the bodies pass through each other', &
                    contact%place, 'use a stiffer penalty or a larger DEPTh')
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

  !> Balance and penetration of an accepted step; warnings if they mean wrong results.
  subroutine measure_contacts(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(resultant_t) :: side(2)
    real(wp) :: largest, deepest
    integer :: c, k

    call follow_penalty_work(model, state)
    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        do k = 1, 2
          call side_resultant(model, state, c, k, [0.0_wp, 0.0_wp, 0.0_wp], side(k))
        end do
        largest = max(norm2(side(1)%force), norm2(side(2)%force))
        now%largest_force = max(now%largest_force, largest)
        if (largest > NO_FORCE*now%largest_force) then
          now%balance = max(now%balance, norm2(side(1)%force + side(2)%force)/largest)
        end if
        deepest = 0.0_wp
        do k = 1, 2
          if (contact%side(k)%rigid) cycle
          if (contact%scheme == MORTAR) then
            deepest = max(deepest, now%penetration(k)/smallest(contact))
          else
            deepest = max(deepest, deepest_point(contact, k, now%side(k)))
          end if
        end do
        now%deepest = max(now%deepest, deepest)
        if (now%balance > UNBALANCED .and. .not. now%balance_warned) then
          now%balance_warned = .true.
          call warn("contact '"//contact%name//"': the forces on its two sides differ by " &
                    //to_text(100*now%balance, 3)//' %', contact%place, 'two half passes do ' &
                    //'not balance on coarse or unequal meshes: remove SCHEme HALFpass')
        end if
        if (contact%friction%given .and. .not. now%friction_warned) then
          if (is_soft(contact, now, state%u)) then
            now%friction_warned = .true.
            call warn("contact '"//contact%name//"': the elastic slip is as large as the motion: " &
                      //'friction hardly acts', contact%place, 'use a stiffer penalty: FRICtion ' &
                      //'COULomb mu PENAlty AUTO')
          end if
        end if
        if (deepest > TOO_DEEP .and. .not. now%penetration_warned) then
          now%penetration_warned = .true.
          call warn("contact '"//contact%name//"': surfaces penetrate by " &
                    //to_text(100*deepest, 3)//' % of an element or of the thickness', &
                    contact%place, 'use a stiffer penalty, NORMal PENAlty AUTO 10, or AUGMent')
        end if
      end associate
    end do
  end subroutine measure_contacts

  !> Keep the largest work against the pressure so far, and its fraction of the work of supports and
  !! loads then. Bonds and inertia work too, so models with them are left out.
  pure subroutine follow_penalty_work(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state

    if (size(model%contact) == 0 .or. .not. state%energy%on .or. state%dynamics%on) return
    if (any(model%contact%cohesive%given)) return
    associate (now => state%contact(1), work => state%energy%contact(NORMAL))
      if (work <= now%penalty_work .or. .not. state%energy%outer > 0.0_wp) return
      now%penalty_work = work
      now%penalty_share = work/state%energy%outer
    end associate
  end subroutine follow_penalty_work

  !> At the end of a run: warn if penetration has taken so much of the work that the bodies deform
  !! much less than they should. The fraction does not depend on the units.
  subroutine warn_soft_penalty(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state

    if (size(model%contact) == 0) return
    if (.not. state%contact(1)%penalty_share > SOFT) return
    call warn('penetration takes '//to_text(100*state%contact(1)%penalty_share, 3) &
              //' % of the work of supports and loads: the penalty is too soft', &
              model%contact(1)%place, 'use a stiffer one, NORMal PENAlty AUTO, or a finer mesh')
  end subroutine warn_soft_penalty

  !> The smallest width of the elements of both sides that are not rigid, or thickness [L].
  pure real(wp) function smallest(contact) result(h)
    type(contact_t), intent(in) :: contact
    integer :: k

    h = huge(h)
    do k = 1, 2
      if (contact%side(k)%thickness > 0.0_wp) h = min(h, contact%side(k)%thickness)
      if (.not. contact%side(k)%rigid) h = min(h, sum(contact%side(k)%width) &
                                               /contact%side(k)%nelem)
    end do
  end function smallest

  !> Is the elastic slip of a point that sticks about as large as the motion of its surface, and not
  !! small?
  pure logical function is_soft(contact, state, u) result(yes)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) displacements [L]
    real(wp) :: elastic, motion
    integer :: i, k

    yes = .false.
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      elastic = 0.0_wp
      associate (points => state%side(k))
        do i = 1, size(points%state)
          if (points%state(i) == STICK) elastic = max(elastic, norm2(points%elastic(:, i)))
        end do
      end associate
      motion = maxval(norm2(u(:, contact%side(1)%node), 1))
      motion = max(motion, maxval(norm2(u(:, contact%side(2)%node), 1)))
      yes = yes .or. (elastic > HALF*motion .and. &
                      elastic > TOO_DEEP*minval(contact%side(k)%width))
    end do
  end function is_soft

  !> Largest penetration of the points of side k, relative to the smallest of the widths of the two
  !! elements and the thicknesses of the two bodies.
  pure real(wp) function deepest_point(contact, k, points) result(deepest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    real(wp) :: h
    integer :: i

    deepest = 0.0_wp
    do i = 1, size(points%state)
      if (points%state(i) == OPEN .or. points%gap(i) >= 0.0_wp .or. points%closest(i) == 0) cycle
      if (points%bond(i) > 0) cycle
      h = contact%side(k)%width((i - 1)/contact%nq + 1)
      associate (other => contact%side(3 - k))
        if (.not. other%rigid) h = min(h, other%width(points%closest(i)))
      end associate
      if (any(contact%side%thickness > 0.0_wp)) then
        h = min(h, minval(contact%side%thickness, contact%side%thickness > 0.0_wp))
      end if
      deepest = max(deepest, -points%gap(i)/h)
    end do
  end function deepest_point

  !> Find a point that was outside the other body at the start of the step, and is now behind its
  !! surface and deeper than DEPTh: contact would never act on it. `trouble` is allocated if there
  !! is such a point.
  subroutine find_jump(model, state, trouble)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable, intent(out) :: trouble
    real(wp), allocatable :: x(:, :), x_start(:, :)
    type(shape_t) :: shape(2), start(2)
    type(grid_t) :: grid(2), start_grid(2)
    type(foot_t) :: foot
    real(wp) :: far, xp(3, 1), a(3, 2), b(3, 3), gap
    integer :: c, e, k, q

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        far = 0.0_wp ! how far a point may have come
        do k = 1, 2
          far = far + maxval(abs(state%u(:, contact%side(k)%node) &
                                 - state%u_step(:, contact%side(k)%node)))
        end do
        if (far < contact%depth) cycle
        if (.not. allocated(x)) then
          x = model%mesh%xr + state%u
          x_start = model%mesh%xr + state%u_step
        end if
        do k = 1, 2
          call update_shape(contact%side(k), x, shape(k))
          call update_shape(contact%side(k), x_start, start(k))
          if (contact%side(3 - k)%rigid) cycle
          call update_grid(contact%side(k), shape(k), grid(k))
          call update_grid(contact%side(k), start(k), start_grid(k))
        end do
        do k = 1, 2
          if (contact%side(k)%rigid) cycle
          do e = 1, contact%side(k)%nelem
            do q = 1, contact%nplain
              call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp(:, 1), a, b)
              foot%elem = 0
              call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp(:, 1), foot)
              if (foot%elem == 0 .or. foot%gap >= -contact%depth) cycle
              gap = foot%gap
              if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) >= 0.0_wp) cycle
              call surface_point(contact%side(k), start(k), e, contact%xi(:, q), xp(:, 1), a, b)
              call project(contact%side(3 - k), start(3 - k), start_grid(3 - k), xp(:, 1), foot)
              if (foot%elem == 0 .or. foot%gap < -contact%depth) cycle
              trouble = 'in contact '//contact%name//' a point of '//contact%side(k)%name &
                        //' has passed through '//contact%side(3 - k)%name//' to a depth of ' &
                        //to_text(-gap, 3)//', more than DEPTh '//to_text(contact%depth, 3)
              return
            end do
          end do
        end do
      end associate
    end do
  end subroutine find_jump

end module contact_report
