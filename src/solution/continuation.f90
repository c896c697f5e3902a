!> Continuation: changes the method of a step when it fails, and tries load control again later.
module continuation
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_release, only: bonded_area, find_release
  use continuation_type, only: continuation_t, path_constraint_t, PATH_OFF, PATH_RELEASE, &
                               PATH_ARC, BY_LOAD, BY_INERTIA, BY_RELEASE, BY_ARC, may_leave, &
                               leave_load_control, is_quiet, is_forward, begin_trial, end_trial, &
                               fail_trial, controls_release, adapt_release, cut_release, &
                               controls_arc, begin_arc, adapt_arc, note_release, runs_back, &
                               opens_again, cut_arc, constrain_release, constrain_arc, &
                               is_all_released
  use contact_pair, only: BALANCED
  use dynamics_type, only: new_dynamics, BACKWARD_EULER
  use load_curve, only: next_corner, next_extremum
  use inertia, only: mass_t, find_masses, energy_of_rate
  use model, only: model_t, state_t
  use solution_state, only: open_step, factor_slopes
  use step_control, only: next_time, next_target, NEARLY
  use step_type, only: step_t
  implicit none
  private
  public :: begin_increment, change_method, adapt_method, follow_slopes

  !> An increment, or a change of the rate of a load, counts as zero if its relative size is below
  !! this.
  real(wp), parameter :: NOTHING = 1.0e-9_wp
  !> Kinetic energy of the mean motion since the start, relative to the work done. This ratio
  !! determines the density that is used for a snap-through.
  real(wp), parameter :: KINETIC_FRACTION = 1.0e-3_wp

contains

  !> Begin a step of the current method, which prescribes the time, the release of the bonds or the
  !! arc length.
  subroutine begin_increment(step, model, state, left)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: left          !! targets that remain in the loop, including this one
    real(wp) :: limit, to

    associate (path => step%continuation, constraint => step%newton%constraint)
      constraint = path_constraint_t()
      to = state%time
      if (controls_arc(path)) then
        limit = next_target(step%control, state%time)
        call constrain_arc(constraint, state, path%length, limit)
      else if (controls_release(path)) then
        limit = next_target(step%control, state%time)
        call constrain_release(constraint, model, state, &
                               path%release*bonded_area(model, state), limit)
      else
        to = next_time(step%control, state%time, left, &
                       next_change(model, state, NEARLY*step%control%dt), &
                       minval(next_extremum(state%table, state%time)))
      end if
    end associate
    call open_step(state, to)
  end subroutine begin_increment

  !> The next time at which a load table has a corner or friction sets in (AFTEr); huge: never.
  pure real(wp) function next_change(model, state, least) result(time)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: least        !! changes that are nearer than this do not count [T]

    time = next_corner(state%table, state%time + least)
    associate (past => state%time + max(least, 8*epsilon(time)*abs(state%time)), &
               after => model%contact%after)
      time = min(time, minval(after, mask=model%contact%friction%given .and. after > past))
    end associate
  end function next_change

  !> Act on a failed step. The result is true if the step must be repeated from its start, with
  !! another method or with a smaller increment of the constrained measure.
  function change_method(step, model, state, why) result(changed)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    character(*), intent(in) :: why
    logical :: changed

    associate (path => step%continuation)
      changed = .true.
      if (path%trial) then
        call fail_trial(path)
        state%dynamics%on = path%active == BY_INERTIA
        call log_line('  load control fails: '//why//'; the previous method continues, and load ' &
                      //'control is tried again after at least '//to_text(path%wait)//' steps')
      else if (path%active == BY_RELEASE) then
        if (cut_release(path)) then
          call log_cut('releases '//to_text(100*path%release)//' % of the bonds')
        else if (any(abs(state%last_increment) > 0.0_wp)) then
          call follow_arc(step, state, 'control of the release ends at time ' &
                          //to_text(step%start_time)//': '//why)
        else
          changed = adds_inertia(step, model, state, 'control of the release ends', why)
          if (.not. changed) call end_continuation(path)
        end if
      else if (path%active == BY_ARC) then
        if (cut_arc(path)) then
          call log_cut('has an arc length of '//to_text(path%length))
        else
          changed = adds_inertia(step, model, state, 'arc length control ends', why)
          if (.not. changed) call end_continuation(path)
        end if
      else
        if (.not. path%given) then
          path%method = merge(PATH_RELEASE, PATH_OFF, any(model%contact(:)%cohesive%given))
        end if
        changed = may_leave(path, (step%control%to - step%control%from)/step%control%dt)
        if (.not. changed) return
        if (can_control_release()) then
          call leave_load_control(path, BY_RELEASE)
          call log_line('path: load control ends at time '//to_text(step%start_time)//': '//why)
          call log_line('path: control of the release takes over; a step releases at most ' &
                        //to_text(100*path%largest_release)//' % of the bonds')
        else
          changed = adds_inertia(step, model, state, 'load control ends', why)
        end if
      end if
    end associate

  contains

    subroutine log_cut(next)
      character(*), intent(in) :: next   !! action of the next attempt

      step%cutbacks = step%cutbacks + 1
      step%total%cutbacks = step%total%cutbacks + 1
      call log_line('  step '//to_text(state%step)//' is cut back: '//why//'; the next attempt ' &
                    //next)
    end subroutine log_cut

    !> Can the release of bonds be controlled by varying a load? There must be a load table and
    !! bonds that are not yet released, and no bond may be viscous (VISCous). A load must already
    !! have done work, because closed bonds do not show in which direction they will open.
    logical function can_control_release() result(yes)
      yes = step%continuation%method == PATH_RELEASE .and. any(model%contact(:)%cohesive%given) &
            .and. size(state%table) > 0
      if (yes) yes = .not. any(model%contact(:)%cohesive%tau > 0.0_wp)
      if (yes) yes = step%start_time > 0.0_wp .and. abs(state%energy%outer) > 0.0_wp
      if (yes) yes = .not. is_all_released(model, state)
    end function can_control_release

  end function change_method

  !> After an accepted step, adapt the next increment, change the method, or try load control again.
  subroutine adapt_method(step, model, state, largest)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: largest      !! largest nodal force of an element [F]
    logical :: due, off

    associate (path => step%continuation)
      if (path%active == BY_LOAD) then
        if (path%method == PATH_ARC .and. .not. step%control%automatic &
            .and. .not. path%warned_length) then
          path%warned_length = .true.
          call warn('ARCLength,LENGth has no effect without AUTO', &
                    hint='write AUTO,,dtmin,dtmax before the steps')
        end if
        if (may_follow_arc(step, state)) call follow_arc(step, state, 'load control has begun')
        return
      end if
      if (path%trial) then
        call end_trial(path)
        call log_line('path: load control takes over again at time '//to_text(state%time))
        return
      end if
      if (path%active == BY_INERTIA) then
        call check_energy(path, model, state)
        due = is_quiet(path, maxval(abs(step%newton%asm%f_inert)), largest)
      else
        if (path%active == BY_ARC) then
          call adapt_arc_control(step, model, state)
        else
          call adapt_release(path, step%newton%iterations - step%newton%before)
        end if
        off = is_all_released(model, state)
        off = off .and. state%dt > 0.0_wp ! if the load decreased, the bonds would close again
        if (off .and. path%method == PATH_RELEASE) then
          call end_trial(path)
          call log_line('path: load control takes over again at time '//to_text(state%time) &
                        //': all bonds are released')
          return
        end if
        due = is_forward(path, step%newton%constraint%at_limit) .and. path%method /= PATH_ARC
        if (path%method == PATH_ARC .and. .not. may_follow_arc(step, state)) call end_trial(path)
      end if
      if (.not. due) return
      call begin_trial(path)
      state%dynamics%on = .false.
    end associate
  end subroutine adapt_method

  !> May a step follow the arc length (LENGth)? The previous step must have moved something, it must
  !! be possible to cut steps, and the rates of the loads must not change. If loads are constant or
  !! change their rates, one step of load control is taken.
  pure logical function may_follow_arc(step, state) result(yes)
    type(step_t), intent(in) :: step
    type(state_t), intent(in) :: state
    real(wp), allocatable :: before(:), ahead(:)

    yes = step%continuation%method == PATH_ARC .and. step%control%automatic
    if (yes) yes = norm2(state%last_increment) > NOTHING*norm2(state%u_step)
    if (.not. yes) return
    before = factor_slopes(state, ahead=.false.)
    ahead = factor_slopes(state, ahead=.true.)
    yes = any(abs(ahead) > 0.0_wp) .and. .not. any(abs(ahead - before) > NOTHING*abs(ahead))
  end function may_follow_arc

  !> After a change of load tables between two steps: return to load control for one step if the
  !! rate of a load has changed, because the direction of the path has changed, too (LENGth).
  subroutine follow_slopes(step, state, before)
    type(step_t), intent(inout) :: step
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: before(:)    !! rates of the load factors before the change [1/T]
    real(wp), allocatable :: ahead(:)
    integer :: n

    associate (path => step%continuation)
      if (.not. (path%method == PATH_ARC .and. path%active == BY_ARC)) return
      ahead = factor_slopes(state, ahead=.true.)
      n = size(before)
      if (.not. (any(abs(ahead(:n) - before) > NOTHING*abs(ahead(:n))) .or. &
                 any(abs(ahead(n + 1:)) > 0.0_wp))) return
      call end_trial(path)
      call log_line('path: a load table has changed its slope: a step of load control follows')
    end associate
  end subroutine follow_slopes

  !> Begin arc length control, in the direction of the previous step.
  subroutine follow_arc(step, state, what)
    type(step_t), intent(inout) :: step
    type(state_t), intent(in) :: state
    character(*), intent(in) :: what
    real(wp) :: length

    length = norm2(state%last_increment)
    call begin_arc(step%continuation, length)
    call log_line('path: '//what)
    call log_line('path: arc length control takes over, first length '//to_text(length))
  end subroutine follow_arc

  !> Add inertia to the next steps. The density is that of ARCLength,DYNAmic or, if it gives none,
  !! one with which the kinetic energy of the initial motion is small. The initial motion is the
  !! mean motion since the start. The result is false if there is no such density.
  function adds_inertia(step, model, state, what, why) result(added)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    character(*), intent(in) :: what, why
    logical :: added
    type(mass_t), allocatable :: mass(:)
    real(wp) :: work, rate

    associate (path => step%continuation, dynamics => state%dynamics)
      if (.not. allocated(dynamics%v)) call new_dynamics(dynamics, model%mesh%nnode)
      dynamics%method = BACKWARD_EULER
      dynamics%a = 0.0_wp
      if (step%start_time > 0.0_wp) dynamics%v = state%u_step/step%start_time
      added = .true.
      dynamics%density = path%density
      if (dynamics%density < 0.0_wp) then
        dynamics%density = 1.0_wp
        call find_masses(model, dynamics, mass)
        work = abs(state%energy%outer)
        rate = energy_of_rate(model, mass, state%u_step)
        added = step%start_time > 0.0_wp .and. work > 0.0_wp .and. rate > 0.0_wp
        if (added) dynamics%density = KINETIC_FRACTION*work*step%start_time**2/rate
      end if
      if (allocated(step%newton%asm%mass)) deallocate (step%newton%asm%mass)
      if (.not. added) return

      call leave_load_control(path, BY_INERTIA)
      dynamics%on = .true.
      if ((.not. path%given .or. path%method == PATH_ARC) .and. .not. path%warned_inertia) then
        path%warned_inertia = .true.
        call warn(what//' at time '//to_text(step%start_time)//'; the run continues ' &
                  //'with inertia where necessary', hint='the log says where and why; with ' &
                  //'ARCLength,OFF in the deck the run would end if smaller steps failed too')
      end if
      call log_line('path: '//what//' at time '//to_text(step%start_time)//': '//why)
      call log_line('path: the run continues with inertia (implicit Euler steps, density ' &
                    //to_text(dynamics%density)//' in units of force, length and TIME)')
    end associate
  end function adds_inertia

  !> Use load control in smaller steps from now on, because neither a constraint nor inertia helps.
  pure subroutine end_continuation(path)
    type(continuation_t), intent(inout) :: path

    call end_trial(path)
    path%given = .true.
    path%method = PATH_OFF
  end subroutine end_continuation

  !> Set the next arc length, or return to control of the release as soon as the bonds open again.
  !! If the bonds close instead, continue with inertia.
  subroutine adapt_arc_control(step, model, state)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), allocatable :: slope(:, :)
    real(wp) :: released, before

    associate (path => step%continuation)
      allocate (slope(3, model%mesh%nnode))
      call find_release(model, state, state%u - state%last_increment, before, slope)
      call find_release(model, state, state%u, released, slope)
      released = released - before       ! zero if there are no bonds
      if (abs(released) > 0.0_wp) released = released/bonded_area(model, state)
      call note_release(path, released)
      if (.not. step%newton%constraint%at_limit) then
        call adapt_arc(path, step%newton%iterations - step%newton%before, released)
      end if
      if (path%method /= PATH_RELEASE) return
      if (runs_back(path)) then
        if (.not. adds_inertia(step, model, state, 'arc length control ends', &
                               'bonds close again')) call end_continuation(path)
      else if (opens_again(path, released)) then
        call log_line('path: control of the release takes over again at time '//to_text(state%time))
      end if
    end associate
  end subroutine adapt_arc_control

  !> Warn if the kinetic energy exceeds the work done. In a model with contact, contact has then
  !! produced energy, which is possible with the two-half-pass algorithm.
  subroutine check_energy(path, model, state)
    type(continuation_t), intent(inout) :: path
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    character(:), allocatable :: hint

    if (path%warned_energy .or. state%energy%kinetic <= abs(state%energy%outer)) return
    path%warned_energy = .true.
    hint = 'use smaller steps: DT with a smaller dt and more passes of the loop, and AUTO with ' &
           //'dtmax = dt'
    if (size(model%contact) > 0) then
      hint = 'contact has produced energy (see BOOK CREAted), so later results are unreliable'
      if (.not. all(model%contact%taper > 0.0_wp .and. model%contact%scheme == BALANCED)) then
        hint = hint//'; if a body is peeled off completely, use NORMal ... BORDer 0.2 and SCHEme ' &
               //'BALAnced'
      end if
    end if
    call warn('step '//to_text(state%step)//': the kinetic energy is ' &
              //to_text(state%energy%kinetic)//', but the work done is only ' &
              //to_text(state%energy%outer), hint=hint)
  end subroutine check_energy

end module continuation
