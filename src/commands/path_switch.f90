!> Load control is left where it fails, and taken up again.
module path_switch
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use command_type, only: run_t
  use dynamics_type, only: new_dynamics, BACKWARD_EULER
  use inertia, only: mass_t, find_masses, energy_of_rate
  use path_type, only: PATH_OFF, PATH_DYNAMIC, may_leave, leave_statics, is_quiet, begin_trial, &
                       end_trial, fail_trial
  implicit none
  private
  public :: another_way, look_after_step

  !> Kinetic energy of the mean motion since the start, relative to the work done: what the density
  !! of a snap is chosen by.
  real(wp), parameter :: SHARE = 1.0e-3_wp

contains

  !> A step has failed. .true.: it is to be tried again from its start, another way.
  function another_way(run, why) result(yes)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why
    logical :: yes

    yes = .true.
    if (run%path%trial) then
      call fail_trial(run%path)
      run%state%dynamics%on = .true.
      call log_line('  load control fails: '//why//'; on with inertia, next try after ' &
                    //to_text(run%path%wait)//' steps')
      return
    end if
    if (.not. run%path%given) then
      run%path%method = merge(PATH_DYNAMIC, PATH_OFF, size(run%model%contact) > 0)
    end if
    yes = may_leave(run%path, (run%control%to - run%control%from)/run%control%dt)
    if (.not. yes) return
    call find_density(run, yes)
    if (.not. yes) return
    call leave_statics(run%path)
    run%state%dynamics%on = .true.
    if (.not. (run%path%given .or. run%path%told)) then
      run%path%told = .true.
      call warn('load control ends at time '//to_text(run%plan%time) &
                //'; the run goes on with inertia where it must', &
                hint='the log says where and why; ARCLength,OFF in the deck: the run ends here')
    end if
    call log_line('path: load control ends at time '//to_text(run%plan%time)//': '//why)
    call log_line('path: on with inertia, implicit Euler steps, density ' &
                  //to_text(run%state%dynamics%density)//' in units of force, length and TIME')
  end function another_way

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

  !> A step is accepted: is the motion so slow that load control is worth a try?
  subroutine look_after_step(run, largest)
    type(run_t), intent(inout) :: run
    real(wp), intent(in) :: largest    !! largest nodal force of an element [F]

    if (.not. run%path%away) return
    if (run%path%trial) then
      call end_trial(run%path)
      call log_line('path: load control again from time '//to_text(run%state%time))
    else if (is_quiet(run%path, maxval(abs(run%newton%asm%f_inert)), largest)) then
      call begin_trial(run%path)
      run%state%dynamics%on = .false.
    end if
  end subroutine look_after_step

end module path_switch
