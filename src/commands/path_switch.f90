!> Load control is left where it fails, and taken up again.
module path_switch
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use bond_release, only: bonded_area
  use command_type, only: run_t
  use dynamics_type, only: new_dynamics, BACKWARD_EULER
  use inertia, only: mass_t, find_masses, energy_of_rate
  use local_type, only: local_t, begin_local, is_all_released
  use path_type, only: PATH_OFF, PATH_LOCAL, BY_LOAD, BY_INERTIA, BY_RELEASE, &
                       may_leave, leave_statics, is_quiet, is_forward, begin_trial, end_trial, &
                       fail_trial, controls_release, adapt_piece, cut_piece
  use solution_state, only: open_step
  use step_control, only: next_step, next_target, end_step
  implicit none
  private
  public :: begin_way, note_time, another_way, look_after_step

  !> Kinetic energy of the mean motion since the start, relative to the work done: what the density
  !! of a snap is chosen by.
  real(wp), parameter :: SHARE = 1.0e-3_wp

contains

  !> A step opens: its time is given, or the release of the bonds that it adds.
  subroutine begin_way(run, left)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: left        !! targets that remain in the loop, this one included
    real(wp) :: to

    run%newton%local = local_t()
    if (controls_release(run%path)) then
      to = next_target(run%control, run%state%time)
      call begin_local(run%newton%local, run%model, run%state, &
                       run%path%piece*bonded_area(run%model, run%state), to)
      to = run%state%time
    else
      to = next_step(run%control, run%state%time, left)
    end if
    call open_step(run%state, to)
  end subroutine begin_way

  !> Under local control a step knows its time only when it has been solved for.
  subroutine note_time(run)
    type(run_t), intent(inout) :: run

    if (run%newton%local%on) then
      call end_step(run%control, run%state%time, run%newton%local%at_limit)
    end if
  end subroutine note_time

  !> A step has failed. .true.: it is to be tried again from its start, another way.
  function another_way(run, why) result(yes)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why
    logical :: static, yes

    yes = .true.
    if (run%path%trial) then
      call fail_trial(run%path)
      run%state%dynamics%on = run%path%way == BY_INERTIA
      call log_line('  load control fails: '//why//'; on as before, next try after ' &
                    //to_text(run%path%wait)//' steps')
      return
    end if
    if (run%path%way == BY_RELEASE) then
      yes = smaller_piece(run, why)
      return
    end if
    if (.not. run%path%given) then
      run%path%method = merge(PATH_LOCAL, PATH_OFF, size(run%model%contact) > 0)
    end if
    yes = may_leave(run%path, (run%control%to - run%control%from)/run%control%dt)
    if (.not. yes) return
    static = .false.
    if (run%path%method == PATH_LOCAL) static = knows_release(run)
    if (static) then
      call leave_statics(run%path, BY_RELEASE)
      call log_line('path: load control ends at time '//to_text(run%plan%time)//': '//why)
      call log_line('path: on by the release of the bonds, '//to_text(100*run%path%largest) &
                    //' % of them a step at most')
    else
      yes = goes_with_inertia(run, 'load control ends', why)
    end if
  end function another_way

  !> A step of given release has failed: less of it, or inertia.
  function smaller_piece(run, why) result(yes)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why
    logical :: yes

    yes = cut_piece(run%path)
    if (yes) then
      run%plan%cutbacks = run%plan%cutbacks + 1
      run%cutbacks = run%cutbacks + 1
      call log_line('  step '//to_text(run%state%step)//' is cut: '//why//'; next try releases ' &
                    //to_text(100*run%path%piece)//' % of the bonds')
    else
      yes = goes_with_inertia(run, 'control of the release ends', why)
    end if
    if (yes) return
    call end_trial(run%path) ! by load, in smaller steps, and by nothing else any more
    run%path%given = .true.
    run%path%method = PATH_OFF
  end function smaller_piece

  !> The next steps have inertia.
  function goes_with_inertia(run, what, why) result(yes)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: what, why
    logical :: yes

    call find_density(run, yes)
    if (.not. yes) return
    call leave_statics(run%path, BY_INERTIA)
    run%state%dynamics%on = .true.
    if (.not. (run%path%given .or. run%path%told)) then
      run%path%told = .true.
      call warn('load control ends at time '//to_text(run%plan%time) &
                //'; the run goes on with inertia where it must', &
                hint='the log says where and why; ARCLength,OFF in the deck: the run ends here')
    end if
    call log_line('path: '//what//' at time '//to_text(run%plan%time)//': '//why)
    call log_line('path: on with inertia, implicit Euler steps, density ' &
                  //to_text(run%state%dynamics%density)//' in units of force, length and TIME')
  end function goes_with_inertia

  !> There are bonds whose release a load can change, none that depends on the speed, and a load has
  !! worked on them: closed bonds do not say which way they open.
  logical function knows_release(run) result(yes)
    type(run_t), intent(in) :: run

    yes = size(run%state%table) > 0 .and. .not. any(run%model%contact(:)%tau > 0.0_wp)
    if (yes) yes = run%plan%time > 0.0_wp .and. abs(run%state%energy%outer) > 0.0_wp
    if (yes) yes = .not. is_all_released(run%model, run%state)
  end function knows_release

  !> The deck's density, or one with which the mean motion since the start has little energy; that
  !! is the motion that inertia begins with.
  subroutine find_density(run, found)
    type(run_t), intent(inout) :: run
    logical, intent(out) :: found
    type(mass_t), allocatable :: mass(:)
    real(wp) :: work, rate

    associate (dynamics => run%state%dynamics)
      if (.not. allocated(dynamics%v)) call new_dynamics(dynamics, run%model%mesh%nnode)
      dynamics%method = BACKWARD_EULER
      dynamics%a = 0.0_wp
      if (run%plan%time > 0.0_wp) dynamics%v = run%state%u_step/run%plan%time
      found = .true.
      dynamics%density = run%path%density
      if (dynamics%density < 0.0_wp) then
        dynamics%density = 1.0_wp
        call find_masses(run%model, dynamics, mass)
        work = abs(run%state%energy%outer)
        rate = energy_of_rate(run%model, mass, run%state%u_step)
        found = run%plan%time > 0.0_wp .and. work > 0.0_wp .and. rate > 0.0_wp
        if (found) dynamics%density = SHARE*work*run%plan%time**2/rate
      end if
    end associate
    if (allocated(run%newton%asm%mass)) deallocate (run%newton%asm%mass)
  end subroutine find_density

  !> A step is accepted: is load control worth a try?
  subroutine look_after_step(run, largest)
    type(run_t), intent(inout) :: run
    real(wp), intent(in) :: largest    !! largest nodal force of an element [F]
    logical :: due

    if (run%path%way == BY_LOAD) return
    if (run%path%trial) then
      call end_trial(run%path)
      call log_line('path: load control again from time '//to_text(run%state%time))
      return
    end if
    if (run%path%way == BY_RELEASE) then
      call adapt_piece(run%path, run%newton%iterations - run%newton%before)
      if (is_all_released(run%model, run%state)) then
        call end_trial(run%path)
        call log_line('path: load control again from time '//to_text(run%state%time) &
                      //': all bonds are released')
        return
      end if
      due = is_forward(run%path, run%newton%local%at_limit)
    else
      call look_at_energy(run)
      due = is_quiet(run%path, maxval(abs(run%newton%asm%f_inert)), largest)
    end if
    if (.not. due) return
    call begin_trial(run%path)
    run%state%dynamics%on = .false.
  end subroutine look_after_step

  !> More motion than work was done: contact has made energy, which its two half passes can.
  subroutine look_at_energy(run)
    type(run_t), intent(inout) :: run

    associate (energy => run%state%energy)
      if (run%path%told_energy .or. energy%kinetic <= abs(energy%outer)) return
      run%path%told_energy = .true.
      call warn('step '//to_text(run%state%step)//': the motion of the path has an energy of ' &
                //to_text(energy%kinetic)//', but the work done is only '//to_text(energy%outer), &
                hint='contact has made energy, what follows means little: bonds peeled to their ' &
                //'end want NORMal ... PAIR BORDer 0.2; see BOOK NORMal')
    end associate
  end subroutine look_at_energy

end module path_switch
