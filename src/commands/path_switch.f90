!> Load control is left where it fails, and taken up again.
module path_switch
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_forces, only: bonded_area
  use command_type, only: run_t
  use local_type, only: local_t, begin_local, begin_arc, is_all_released
  use path_type, only: PATH_OFF, PATH_LOCAL, PATH_LENGTH, BY_LOAD, BY_INERTIA, BY_RELEASE, BY_ARC, &
                       may_leave, leave_statics, is_quiet, is_forward, begin_trial, end_trial, &
                       fail_trial, controls_release, adapt_piece, cut_piece, follows_arc, cut_length
  use path_ways, only: goes_along, goes_with_inertia, give_up, look_after_arc, look_at_energy
  use solution_state, only: open_step, factor_slopes
  use step_control, only: next_step, next_target, end_step
  implicit none
  private
  public :: begin_way, note_time, another_way, look_after_step

  real(wp), parameter :: REST = 1.0e-9_wp !! of a way, or of a load's rate: that is none

contains

  !> A step opens: its time is given, or the release of the bonds that it adds.
  subroutine begin_way(run, left)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: left        !! targets that remain in the loop, this one included
    real(wp) :: to

    run%newton%local = local_t()
    if (follows_arc(run%path)) then
      call begin_arc(run%newton%local, run%state, run%path%length, &
                     next_target(run%control, run%state%time))
      to = run%state%time
    else if (controls_release(run%path)) then
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
    if (run%path%way == BY_ARC) then
      yes = shorter_arc(run, why)
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
      call note_cut(run, why, 'releases '//to_text(100*run%path%piece)//' % of the bonds')
    else if (any(abs(run%state%last_increment) > 0.0_wp)) then
      yes = .true.
      call goes_along(run, 'control of the release ends at time '//to_text(run%plan%time) &
                      //': '//why)
    else
      yes = goes_with_inertia(run, 'control of the release ends', why)
      if (.not. yes) call give_up(run)
    end if
  end function smaller_piece

  !> A step along the last one has failed: a shorter one, or inertia.
  function shorter_arc(run, why) result(yes)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why
    logical :: yes

    yes = cut_length(run%path)
    if (yes) then
      call note_cut(run, why, 'has a length of '//to_text(run%path%length))
      return
    end if
    yes = goes_with_inertia(run, 'control of the length ends', why)
    if (.not. yes) call give_up(run)
  end function shorter_arc

  subroutine note_cut(run, why, next)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why, next !! what the next try does

    run%plan%cutbacks = run%plan%cutbacks + 1
    run%cutbacks = run%cutbacks + 1
    call log_line('  step '//to_text(run%state%step)//' is cut: '//why//'; next try '//next)
  end subroutine note_cut

  !> There are bonds whose release a load can change, none that depends on the speed, and a load has
  !! worked on them: closed bonds do not say which way they open.
  logical function knows_release(run) result(yes)
    type(run_t), intent(in) :: run

    yes = any(run%model%contact(:)%has_cohesive) .and. size(run%state%table) > 0
    if (yes) yes = .not. any(run%model%contact(:)%tau > 0.0_wp)
    if (yes) yes = run%plan%time > 0.0_wp .and. abs(run%state%energy%outer) > 0.0_wp
    if (yes) yes = .not. is_all_released(run%model, run%state)
  end function knows_release

  !> LENGth asks for steps that can be cut.
  subroutine tell_of_auto(run)
    type(run_t), intent(inout) :: run

    if (run%path%method /= PATH_LENGTH .or. run%control%automatic .or. run%path%told) return
    run%path%told = .true.
    call warn('ARCLength,LENGth does nothing without AUTO', &
              hint='write AUTO,,dtmin,dtmax before the steps')
  end subroutine tell_of_auto

  !> LENGth: a step has moved something, steps can be cut, and loads go on as they went. Where they
  !! rest or turn there is one step of load control.
  pure logical function may_go_along(run) result(yes)
    type(run_t), intent(in) :: run
    real(wp), allocatable :: before(:), ahead(:)

    yes = run%path%method == PATH_LENGTH .and. run%control%automatic
    if (yes) yes = norm2(run%state%last_increment) > REST*norm2(run%state%u_step)
    if (.not. yes) return
    before = factor_slopes(run%state, ahead=.false.)
    ahead = factor_slopes(run%state, ahead=.true.)
    yes = any(abs(ahead) > 0.0_wp) .and. .not. any(abs(ahead - before) > REST*abs(ahead))
  end function may_go_along

  !> A step is accepted: is load control worth a try?
  subroutine look_after_step(run, largest)
    type(run_t), intent(inout) :: run
    real(wp), intent(in) :: largest    !! largest nodal force of an element [F]
    logical :: due, off

    if (run%path%way == BY_LOAD) then
      call tell_of_auto(run)
      if (may_go_along(run)) call goes_along(run, 'load control has begun')
      return
    end if
    if (run%path%trial) then
      call end_trial(run%path)
      call log_line('path: load control again from time '//to_text(run%state%time))
      return
    end if
    if (run%path%way /= BY_INERTIA) then
      if (run%path%way == BY_ARC) then
        call look_after_arc(run)
      else
        call adapt_piece(run%path, run%newton%iterations - run%newton%before)
      end if
      off = is_all_released(run%model, run%state)
      off = off .and. run%state%dt > 0.0_wp ! else the load would lead back
      if (off .and. run%path%method == PATH_LOCAL) then
        call end_trial(run%path)
        call log_line('path: load control again from time '//to_text(run%state%time) &
                      //': all bonds are released')
        return
      end if
      due = is_forward(run%path, run%newton%local%at_limit) .and. run%path%method /= PATH_LENGTH
      if (run%path%method == PATH_LENGTH .and. .not. may_go_along(run)) call end_trial(run%path)
    else
      call look_at_energy(run)
      due = is_quiet(run%path, maxval(abs(run%newton%asm%f_inert)), largest)
    end if
    if (.not. due) return
    call begin_trial(run%path)
    run%state%dynamics%on = .false.
  end subroutine look_after_step

end module path_switch
