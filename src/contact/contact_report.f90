!> Reports on contacts during a run: contacts that close or open in a step, points that have passed
!! through the other body, and warnings about results that cannot be right.
module contact_report
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_bond, only: find_broken_bonds, find_opened_bonds
  use contact_energy, only: bond_energy
  use contact_history, only: had_touched
  use contact_patch, only: follow_patch
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, is_integrated, HALFPASS, &
                          MORTAR
  use contact_resultant, only: resultant_t, side_resultant
  use contact_sweep, only: find_sweep
  use contact_type, only: OPEN, STICK
  use model, only: model_t, state_t
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces
  use projection_type, only: foot_t, shape_t
  use self_search, only: find_own_jump
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: report_contact_changes, measure_contacts, find_jump, warn_soft_penalty, renew_warnings

  real(wp), parameter :: UNBALANCED = 0.02_wp !! relative difference of forces above which to warn
  !> Energy of penetration, divided by the work of supports and loads, above which this work cannot
  !! have supplied the energy, even if its sum over the steps is inaccurate.
  real(wp), parameter :: WITHOUT_WORK = 2.0_wp
  !> Limits above which a warning is issued.
  real(wp), parameter :: TOO_DEEP = 0.02_wp   !! penetration, relative to the size of an element
  real(wp), parameter :: HALF = 0.5_wp        !! elastic slip, relative to the motion
  real(wp), parameter :: ROUNDING = 1.0e-6_wp !! elastic slip that may be rounding, per element size
  real(wp), parameter :: SOFT = 0.2_wp        !! energy of penetration, relative to the work
  real(wp), parameter :: MUCH_MORE = 1.5_wp   !! energy of penetration, relative to an earlier one
  real(wp), parameter :: MOST = 0.5_wp        !! fraction of the bonds that break in one step
  real(wp), parameter :: NO_FORCE = 1.0e-9_wp !! negligible fraction of the largest force so far

contains

  !> Log which contacts a step has closed or opened, and warn about points that were in contact and
  !! are now deeper than DEPTh, and about bonds that break suddenly. The results of the step at the
  !! integration points must have been set (accept_contact), but not kept (accept_step_state).
  subroutine report_contact_changes(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    character(:), allocatable :: text
    integer :: c, k, n(2)

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), side => state%contact(c)%side)
        if (.not. state%contact(c)%depth_warned) then
          n = count_lost(contact, model%mesh%xr + state%u, state%contact(c))
          if (sum(n) > 0) then
            state%contact(c)%depth_warned = .true.
            call warn("contact '"//contact%name//"': "//to_text(sum(n)) &
                      //' integration points that were in contact are now deeper than DEPTh ' &
                      //to_text(contact%depth)//', where contact no longer acts: the bodies ' &
                      //'pass through each other', contact%place, &
                      'use a stiffer penalty or a larger DEPTh')
          end if
        end if
        call report_break(contact, model%mesh%xr, state, state%contact(c))
        n = [(count(side(k)%state /= OPEN), k=1, 2)]
        if (had_touched(state%contact(c)) .eqv. any(n > 0)) cycle
        if (any(n > 0)) then
          text = to_text(n(1))
          if (.not. contact%self) text = text//' + '//to_text(n(2))
          call log_line('contact '//contact%name//': closed, '//text//' points in contact')
        else
          call log_line('contact '//contact%name//': opened, no points in contact')
        end if
      end associate
    end do
  end subroutine report_contact_changes

  !> Count the points of each side that were in contact at the start of the step, and are now deeper
  !! than DEPTh. The search near a surface finds no projection of a point that is deeper than DEPTh
  !! below every part of it. Such points are therefore projected again, at any distance.
  function count_lost(contact, x, state) result(n)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(contact_state_t), intent(in) :: state
    integer :: n(2)
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp) :: xp(3), a(3, 2), b(3, 3)
    integer :: e, i, k, q
    logical :: placed

    n = 0
    placed = .false.
    do k = 1, 2
      associate (points => state%side(k))
        do i = 1, size(points%state)
          if (points%state_step(i) == OPEN .or. points%state(i) /= OPEN) cycle
          if (points%closest(i) > 0) then
            if (points%gap(i) < -contact%depth) n(k) = n(k) + 1
            cycle
          end if
          if (contact%self) cycle
          if (.not. placed) call place_surfaces(contact, x, shape, grid)
          placed = .true.
          e = (i - 1)/contact%nq + 1
          q = mod(i - 1, contact%nq) + 1
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = points%closest_step(i)
          foot%xi = points%closest_xi_step(:, i)
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot)
          if (foot%elem == 0 .or. foot%gap >= -contact%depth) cycle
          if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) < 0.0_wp) n(k) = n(k) + 1
        end do
      end associate
    end do
  end function count_lost

  !> Warn if most bonds of a contact break within one step, before which they had not reached their
  !! strength: no row of a curve then shows the largest force. Steps in which the inertia of
  !! ARCLength carries the model over a snap are excepted, because bonds are meant to break in them.
  subroutine report_break(contact, xr, state, now)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)     !! (3, nnode) [L]
    type(state_t), intent(in) :: state
    type(contact_state_t), intent(inout) :: now
    real(wp) :: part, widest, strongest
    integer :: n

    if (.not. contact%cohesive%given .or. now%break_warned) return
    if (state%dynamics%on .and. state%dynamics%density >= 0.0_wp) return
    part = find_broken_bonds(contact, now)
    if (part < MOST) return
    if (state%step == 1) then ! contact_start has reported bonds that are open at the start
      call find_opened_bonds(contact, xr, now, n, widest, strongest)
      if (n > 0) return
    end if
    now%break_warned = .true.
    call warn("contact '"//contact%name//"': "//to_text(100*part, 3)//' % of the bonds break ' &
              //'within step '//to_text(state%step)//', before which their traction was still ' &
              //'increasing; they now bear almost nothing, and the curves miss the largest force', &
              contact%place, 'take smaller steps before time '//to_text(state%time) &
              //': DT with a smaller dt')
  end subroutine report_break

  !> Record the balance of the forces and the penetration of an accepted step. Warn if these, or the
  !! elastic slip, show that results are wrong. Without loads, and far below the largest one, forces
  !! of contact consist of rounding errors, whose balance and work have no meaning.
  subroutine measure_contacts(model, state, load)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: load         !! largest nodal load or reaction so far [F]
    type(resultant_t) :: side(2)
    character(:), allocatable :: hint
    real(wp) :: largest, deepest
    integer :: c, k

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        do k = 1, 2
          call side_resultant(model, state, c, k, [0.0_wp, 0.0_wp, 0.0_wp], side(k))
        end do
        largest = max(norm2(side(1)%force), norm2(side(2)%force))
        if (largest > now%largest_force) call follow_patch(contact, model%mesh%xr + state%u, now)
        now%largest_force = max(now%largest_force, largest)
        if (load > 0.0_wp .and. largest > NO_FORCE*max(load, now%largest_force) .and. &
            .not. contact%self) then
          now%balance = max(now%balance, norm2(side(1)%force + side(2)%force)/largest)
        end if
        deepest = 0.0_wp
        do k = 1, 2
          if (.not. is_integrated(contact, k)) cycle
          deepest = max(deepest, now%penetration(k)/smallest(contact))
          if (contact%scheme == MORTAR) cycle
          deepest = max(deepest, deepest_point(contact, k, now%side(k)))
        end do
        now%deepest = max(now%deepest, deepest)
        if (now%balance > UNBALANCED .and. .not. now%balance_warned) then
          now%balance_warned = .true.
          hint = 'use smaller elements'
          if (contact%scheme == HALFPASS) then
            hint = 'with HALFpass, they differ on coarse or unequal meshes: remove this scheme'
          end if
          call warn("contact '"//contact%name//"': the forces on its two sides differ by " &
                    //to_text(100*now%balance, 3)//' %', contact%place, hint)
        end if
        if (contact%friction%given .and. .not. now%friction_warned) then
          if (is_soft(contact, now, state%u)) then
            now%friction_warned = .true.
            hint = 'use a stiffer penalty in FRICtion'
            if (contact%friction%auto) hint = 'use a stiffer penalty in NORMal or FRICtion'
            call warn("contact '"//contact%name//"': the elastic slip is more than half of " &
                      //'the motion, so friction hardly acts', contact%place, hint)
          end if
        end if
        if (now%deepest > TOO_DEEP .and. .not. now%penetration_warned) then
          now%penetration_warned = .true.
          call warn("contact '"//contact%name//"': surfaces penetrate by " &
                    //to_text(100*now%deepest, 3)//' % of the width of an element or of the ' &
                    //'thickness of a body', contact%place, stiffer(contact))
        end if
      end associate
    end do
    if (load > 0.0_wp) call follow_penetration(model, state)
  end subroutine measure_contacts

  !> After RESTart, let the warnings of the run that wrote the checkpoint come again, because this
  !! run has a report of its own. Those about measured values come in the next step. Those about
  !! events, which do not occur again, are issued here.
  subroutine renew_warnings(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer :: c

    do c = 1, size(model%contact)
      associate (contact => model%contact(c), now => state%contact(c))
        now%balance_warned = .false.
        now%friction_warned = .false.
        now%penetration_warned = .false.
        if (now%depth_warned) then
          call warn("contact '"//contact%name//"': before the checkpoint, points that were in " &
                    //'contact have become deeper than DEPTh, where contact no longer acts: the ' &
                    //'bodies pass through each other', contact%place, &
                    'use a stiffer penalty or a larger DEPTh in the run that wrote the checkpoint')
        end if
        if (now%break_warned) then
          call warn("contact '"//contact%name//"': before the checkpoint, most bonds broke " &
                    //'within one step, so that the curves miss the largest force', contact%place, &
                    'take smaller steps in the run that wrote the checkpoint')
        end if
        if (now%oblique_warned) then
          call warn("contact '"//contact%name//"': before the checkpoint, a force suddenly acted " &
                    //'between faces that are not opposite each other: a body may stand on its ' &
                    //'edge', contact%place, 'see the warning in the log of the run that wrote ' &
                    //'the checkpoint')
        end if
      end associate
    end do
  end subroutine renew_warnings

  !> Keep the energy of penetration, where it is largest so far, and its fraction of the work of
  !! supports and loads at that time. Work of friction makes this fraction smaller, so that a larger
  !! one remains until the energy has risen by half. Bonds may do work too, if they have a gap at
  !! the start, so their energies are added to this work. Models with inertia are left out, because
  !! inertia does work.
  pure subroutine follow_penetration(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp) :: stored, bonds, share
    integer :: c

    if (size(model%contact) == 0 .or. state%dynamics%on) return
    stored = sum([(sum(state%contact(c)%pressed), c=1, size(model%contact))])
    bonds = sum([(sum(bond_energy(model%contact(c), state%contact(c))), c=1, size(model%contact))])
    associate (energy => state%energy)
      if (stored <= energy%penetration .or. .not. energy%outer > 0.0_wp) return
      share = stored/(energy%outer + max(0.0_wp, bonds))
      if (share < energy%penetration_share .and. energy%penetration_share <= WITHOUT_WORK .and. &
          stored <= MUCH_MORE*energy%penetration) return
      energy%penetration = stored
      energy%penetration_share = share
    end associate
  end subroutine follow_penetration

  !> At the end of a run, warn if penetration has taken so large a share of the work that the bodies
  !! deform much less than they should. The fraction does not depend on the units.
  subroutine warn_soft_penalty(model, state)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable :: sources ! of the work
    integer :: c

    if (size(model%contact) == 0) return
    if (.not. state%energy%penetration_share > SOFT) return
    sources = ' the work of supports and loads'
    if (any(model%contact%cohesive%given)) sources = sources//' and the energy of bonds'
    if (state%energy%penetration_share > WITHOUT_WORK) then
      call warn('the energy stored in penetration exceeds'//sources, &
                model%contact(1)%place, 'surfaces overlapped before a force acted on them: take ' &
                //'smaller steps until they meet, or move the bodies apart at the start')
      return
    end if
    c = maxloc([(sum(state%contact(c)%pressed), c=1, size(model%contact))], 1)
    call warn('penetration absorbs '//to_text(100*state%energy%penetration_share, 3) &
              //' % of'//sources//': the penalty is too soft', &
              model%contact(c)%place, stiffer(model%contact(c)))
  end subroutine warn_soft_penalty

  !> Hint: the penalty of AUTO or, if it is stiffer, ten times the penalty of the deck.
  function stiffer(contact) result(hint)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: hint
    real(wp) :: factor

    factor = 10*contact%normal%factor
    hint = "use a stiffer penalty, such as 'NORMal PENAlty AUTO"
    if (factor > 1.0_wp) hint = hint//' '//to_text(factor, 2)
    hint = hint//"', or a finer mesh"
  end function stiffer

  !> The smallest of the thicknesses of both sides and of the mean widths of the elements of those
  !! sides that are not rigid [L].
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

  !> Is the elastic slip of a point that sticks more than half of the largest displacement of the
  !! two surfaces, and not small beside the elements? If it is small, it counts if it is more than
  !! half of the largest displacement of the model: a block that sticks to a support, for instance,
  !! moves by its elastic slip alone where it touches it.
  pure logical function is_soft(contact, state, u) result(yes)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) displacements [L]
    real(wp) :: elastic, motion, all_motion
    integer :: i, k

    yes = .false.
    all_motion = maxval(norm2(u, 1))
    do k = 1, 2
      if (.not. is_integrated(contact, k)) cycle
      elastic = 0.0_wp
      associate (points => state%side(k))
        do i = 1, size(points%state)
          if (points%state(i) == STICK) elastic = max(elastic, norm2(points%elastic(:, i)))
        end do
      end associate
      motion = maxval(norm2(u(:, contact%side(1)%node), 1))
      motion = max(motion, maxval(norm2(u(:, contact%side(2)%node), 1)))
      associate (width => minval(contact%side(k)%width))
        yes = yes .or. (elastic > HALF*motion .and. elastic > TOO_DEEP*width) .or. &
              (elastic > HALF*all_motion .and. elastic > ROUNDING*width)
      end associate
    end do
  end function is_soft

  !> Largest penetration of the points of side k, relative to the smallest of the widths of the two
  !! elements and the thicknesses of the two bodies.
  pure real(wp) function deepest_point(contact, k, points) result(deepest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_points_t), intent(in) :: points
    real(wp) :: h
    integer :: e, i

    deepest = 0.0_wp
    do i = 1, size(points%state)
      e = points%closest(i)
      if (e == 0) e = points%bond(i)         ! PAIR: the gap is that to the partner
      if (points%state(i) == OPEN .or. points%gap(i) >= 0.0_wp .or. e == 0) cycle
      h = contact%side(k)%width((i - 1)/contact%nq + 1)
      associate (other => contact%side(3 - k))
        if (.not. other%rigid) h = min(h, other%width(e))
      end associate
      if (any(contact%side%thickness > 0.0_wp)) then
        h = min(h, minval(contact%side%thickness, contact%side%thickness > 0.0_wp))
      end if
      deepest = max(deepest, -points%gap(i)/h)
    end do
  end function deepest_point

  !> Find a point that was not deeper than DEPTh below the other surface at the start of the step,
  !! and is now deeper than that, or has passed through the other body within the step. Contact
  !! would never act on such a point. `trouble`, a text for the user, is allocated if there is one.
  subroutine find_jump(model, state, trouble)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable, intent(out) :: trouble
    real(wp), allocatable :: x(:, :), x_start(:, :)
    real(wp) :: far, gap
    integer :: c, k, side

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        far = 0.0_wp ! how far points may have moved towards each other
        do k = 1, 2
          far = far + maxval(abs(state%u(:, contact%side(k)%node) &
                                 - state%u_step(:, contact%side(k)%node)))
        end do
        if (.not. far > 0.0_wp) cycle
        if (.not. allocated(x)) then
          x = model%mesh%xr + state%u
          x_start = model%mesh%xr + state%u_step
        end if
        side = 0
        if (contact%self) then
          if (far < contact%depth) cycle
          call find_own_jump(contact, model%mesh%xr, x_start, x, far, gap)
          if (.not. gap < 0.0_wp) cycle
          trouble = contact%side(1)%name//' has passed through its own surface'
        else
          if (far >= contact%depth) call find_jump_through(contact, x_start, x, gap, side)
          if (side == 0) then
            call find_sweep(contact, x_start, x, gap, side)
            gap = -gap
          end if
          if (side == 0) cycle
          trouble = contact%side(side)%name//' has passed through '//contact%side(3 - side)%name
        end if
        trouble = 'in contact '//contact%name//', a point of '//trouble//' to a depth of ' &
                  //to_text(-gap, 6)
        if (-gap > contact%depth) trouble = trouble//', more than DEPTh ' &
                                            //to_text(contact%depth, 6)
        return
      end associate
    end do
  end subroutine find_jump

  !> Find, for a contact of two surfaces, a point that is now behind the other surface and deeper
  !! than DEPTh, and was not deeper than DEPTh at the start of the step.
  subroutine find_jump_through(contact, x_start, x, gap, side)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x_start(:, :), x(:, :) !! (3, nnode) at the start and now [L]
    real(wp), intent(out) :: gap                   !! gap of the point [L]; positive: there is none
    integer, intent(out) :: side                   !! the side to which the point belongs
    type(shape_t) :: shape(2), start(2)
    type(grid_t) :: grid(2), start_grid(2)
    type(foot_t) :: foot
    real(wp) :: xp(3), a(3, 2), b(3, 3)
    integer :: e, k, q

    call place_surfaces(contact, x, shape, grid)
    call place_surfaces(contact, x_start, start, start_grid)
    side = 0
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot)
          if (foot%elem == 0 .or. foot%gap >= -contact%depth) cycle
          gap = foot%gap
          if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) >= 0.0_wp) cycle
          call surface_point(contact%side(k), start(k), e, contact%xi(:, q), xp, a, b)
          call project(contact%side(3 - k), start(3 - k), start_grid(3 - k), xp, foot)
          if (foot%elem == 0 .or. foot%gap < -contact%depth) cycle
          side = k
          return
        end do
      end do
    end do
    gap = huge(gap)
  end subroutine find_jump_through

end module contact_report
