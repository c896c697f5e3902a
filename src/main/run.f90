!> A whole analysis on one page: reads the deck, executes its commands, and returns an error if the
!! analysis fails or is stopped.
!!
!! TIME closes the previous step and begins a new one, in which TANG and similar commands iterate.
!! When a step is cut back, or is accepted before its target, the command counter goes back to the
!! TIME of that step (see the modules step and command_step).
module run
  use base_log, only: warn
  use base_error, only: error_t, fail, NO_SOLUTION, error_list_t
  use command_checkpoint, only: set_restart_point, stop_wanted, stop_run
  use command_doubts, only: warn_commands
  use command_files, only: remove_results, open_files, close_files, cut_tables
  use command_line, only: options_t
  use command_program, only: read_program, has_command, execute_next
  use contact_augment, only: share_penalty
  use contact_missed, only: note_missed
  use contact_report, only: warn_soft_penalty
  use command_step, only: finish_step
  use command_type, only: run_t
  use command_watch, only: watch_end
  use deck_stream, only: open_deck, check_settings, warn_of_comma, deck_text
  use dof_map, only: number_equations
  use input_inside, only: warn_moved_inside
  use input_model, only: build_model
  use input_overlap, only: warn_crossed
  use solution_state, only: new_state
  use table_check, only: check_tables, warn_sum
  use unresisted, only: warn_unresisted
  implicit none
  private
  public :: read_deck, execute

contains

  !> Read the whole deck; nothing is solved and no file is changed.
  subroutine read_deck(options, job, errors, error)
    type(options_t), intent(in) :: options
    type(run_t), intent(inout) :: job
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    call open_deck(job%deck, options%deck, options%settings, error)
    if (allocated(error)) return
    call build_model(job%deck, job%model, errors, error)
    if (allocated(error) .or. errors%count() > 0) return
    call number_equations(job%model%mesh, job%model%bc, job%model%eq, job%model%neq, job%model%ndof)
    call read_program(job, errors, error)
    if (allocated(error) .or. errors%count() > 0) return
    if (has_command(job, 'augm')) then
      do i = 1, size(job%model%contact)
        call share_penalty(job%model%contact(i))
      end do
    end if
    call check_settings(job%deck, error)
    if (allocated(error)) return
    call check_tables(job%model%bc, job%program%defined, error)
    if (allocated(error)) return
    call warn_of_comma(job%deck)
    call warn_commands(job)
    call warn_sum(job%model, size(job%program%defined))
    job%files%deck_text = deck_text(job%deck)
    call new_state(job%model, job%state)
  end subroutine read_deck

  !> Execute one command after another, and then close the last step.
  subroutine execute(job, error)
    type(run_t), intent(inout) :: job
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: ignored
    logical :: rewound, unsolved, stops

    stops = .false.
    if (allocated(job%files%kept)) then
      call open_files(job, error) ! removes what a killed run wrote after its last checkpoint
      if (allocated(error)) return
    else if (.not. has_command(job, 'rest')) then
      call remove_results(job)
    end if
    call set_restart_point(job)
    do
      stops = stop_wanted(job) .or. stops
      if (stops .and. .not. awaits_restart(job)) then
        call stop_run(job, error)
        return
      end if
      if (job%program%counter <= size(job%program%command)) then
        call execute_next(job, error)
      else
        unsolved = job%step%open .and. job%step%timed .and. .not. job%step%solved
        call finish_step(job, rewound, error)
        if (.not. (allocated(error) .or. rewound)) exit
      end if
      if (allocated(error)) then
        call cut_tables(job, ignored)
        return
      end if
      job%program%counter = job%program%counter + 1
    end do
    call close_files(job, error)
    if (allocated(error)) return
    call watch_end(job)
    if (job%step%total%iterations == 0 .and. job%model%neq > 0) then
      call warn('no system was solved: displacements have not changed since the start', &
                hint='TANG,,1 and UTAN,,1 solve; TANG and UTAN alone only form the tangent')
    else if (unsolved) then
      call warn('the last step that TIME began was not solved: the results end with the step ' &
                //'before it', hint='in a loop, TIME comes before TANG,,1 or UTAN,,1')
    end if
    call warn_soft_penalty(job%model, job%state)
    call warn_crossed(job%model%mesh, job%model%contact, job%state%contact%touched, &
                      job%model%mesh%xr + job%state%u)
    call warn_moved_inside(job%model%mesh, job%model%contact, job%state%contact%touched .or. &
                           job%model%contact%cohesive%given, job%model%mesh%xr + job%state%u)
    call note_missed(job%model, job%state)
    call warn_unresisted(job%model, job%state)
    if (job%step%total%unconverged) then
      call fail(error, NO_SOLUTION, 'some steps were closed before they converged', &
                hint='see the warnings in the log')
    end if
  end subroutine execute

  !> Has RESTart still to be executed? A run is not stopped before it, because the checkpoint of its
  !! start would replace the one that RESTart reads.
  logical function awaits_restart(job)
    type(run_t), intent(in) :: job

    awaits_restart = has_command(job, 'rest') .and. .not. allocated(job%files%kept)
  end function awaits_restart

end module run
