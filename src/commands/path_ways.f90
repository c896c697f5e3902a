!> Ways that a run takes where load control ends: by the length of its steps, or with inertia.
module path_ways
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_forces, only: bonded_area, find_release
  use command_type, only: run_t
  use dynamics_type, only: new_dynamics, BACKWARD_EULER
  use inertia, only: mass_t, find_masses, energy_of_rate
  use path_type, only: PATH_OFF, PATH_LOCAL, BY_INERTIA, leave_statics, end_trial, &
                       begin_way_along, adapt_length, note_gain, runs_back, opens_again
  implicit none
  private
  public :: goes_along, goes_with_inertia, give_up, look_after_arc, look_at_energy

  !> Kinetic energy of the mean motion since the start, relative to the work done: what the density
  !! of a snap is chosen by.
  real(wp), parameter :: SHARE = 1.0e-3_wp

contains

  !> The next steps go on along the last one.
  subroutine goes_along(run, what)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: what
    real(wp) :: length

    length = norm2(run%state%last_increment)
    call begin_way_along(run%path, length)
    call log_line('path: '//what)
    call log_line('path: on by the length of the step, first '//to_text(length))
  end subroutine goes_along

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

  !> On by load, in smaller steps, and by nothing else any more.
  subroutine give_up(run)
    type(run_t), intent(inout) :: run

    call end_trial(run%path)
    run%path%given = .true.
    run%path%method = PATH_OFF
  end subroutine give_up

  !> The next step along the last one; back to the release of the bonds once it grows again.
  subroutine look_after_arc(run)
    type(run_t), intent(inout) :: run
    real(wp), allocatable :: slope(:, :)
    real(wp) :: now, before

    associate (model => run%model, state => run%state)
      allocate (slope(3, model%mesh%nnode))
      call find_release(model, state, state%u - state%last_increment, before, slope)
      call find_release(model, state, state%u, now, slope)
      now = now - before                  ! without bonds: nothing
      if (abs(now) > 0.0_wp) now = now/bonded_area(model, state)
      call note_gain(run%path, now)
      if (.not. run%newton%local%at_limit) then
        call adapt_length(run%path, run%newton%iterations - run%newton%before, now)
      end if
      if (run%path%method /= PATH_LOCAL) return
      if (runs_back(run%path)) then
        if (goes_with_inertia(run, 'control of the length ends', 'bonds close again')) return
        call give_up(run)
      else if (opens_again(run%path, now)) then
        call log_line('path: by the release of the bonds again from time '//to_text(state%time))
      end if
    end associate
  end subroutine look_after_arc

  !> More motion than work was done: contact has made energy, which its two half passes can.
  subroutine look_at_energy(run)
    type(run_t), intent(inout) :: run
    character(:), allocatable :: hint

    associate (energy => run%state%energy)
      if (run%path%told_energy .or. energy%kinetic <= abs(energy%outer)) return
      run%path%told_energy = .true.
      hint = 'smaller steps: AUTO,,dtmin,dtmax with a smaller dtmax'
      if (size(run%model%contact) > 0) then
        hint = 'contact has made energy, what follows means little: bonds peeled to their ' &
               //'end want NORMal ... BORDer 0.2 and BALAnced; see BOOK NORMal'
      end if
      call warn('step '//to_text(run%state%step)//': the motion of the path has an energy of ' &
                //to_text(energy%kinetic)//', but the work done is only '//to_text(energy%outer), &
                hint=hint)
    end associate
  end subroutine look_at_energy

end module path_ways
