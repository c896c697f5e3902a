!> Connects commands and steps: begins a step, acts on its outcome, closes it and writes what is
!! due.
module command_step
  use base_agreement, only: agree
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_checkpoint, only: write_checkpoint, set_restart_point
  use command_files, only: open_files, write_rows, write_fields, keep_tables, cut_tables
  use command_type, only: run_t
  use command_watch, only: watch_step
  use linear_system, only: FULL
  use listing_contact, only: list_contacts
  use program_position, only: save_position, rewind_program, leave_loop, current_place
  use step, only: begin_step, close_step, STEP_CONVERGED, STEP_ACCEPTED, STEP_REWOUND
  use step_control, only: on_target
  use table_use, only: warn_continued
  implicit none
  private
  public :: open_step_here, take_outcome, finish_step, finish_solved_step

  integer, parameter :: RESTART_EVERY = 10 !! steps between restart points if factors are kept

contains

  !> Begin a step, whose first command is the one at the counter.
  subroutine open_step_here(run, left)
    type(run_t), intent(inout) :: run
    integer, intent(in), optional :: left !! targets that remain in the loop; absent without TIME

    if (.not. allocated(run%plan%closed_at)) run%plan%closed_at = run%state%time
    call save_position(run%program, run%deck%params, run%plan%prints)
    run%step%reloaded = run%plan%loads_changed .and. run%state%step == run%plan%restarted_at
    call begin_step(run%step, run%model, run%state, left)
  end subroutine open_step_here

  !> Act on the outcome of a step: when it has converged, the iteration loop ends; after a cut-back
  !! the command that began the step is executed next.
  subroutine take_outcome(run, outcome, error)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: outcome
    type(error_t), allocatable, intent(out) :: error

    if (outcome == STEP_CONVERGED) call leave_loop(run%program)
    if (outcome /= STEP_REWOUND) return
    call rewind_program(run%program, run%deck%params, run%plan%prints)
    run%program%counter = run%program%counter - 1 ! the main loop adds one
    run%plan%plot = .false.
    run%plan%save = .false.
    call cut_tables(run, error)
    call agree(error)
  end subroutine take_outcome

  !> Close the current step, if any, and write what is due. `rewound` is true if the command that
  !! began the step is executed next, because the step failed its last test or ended before its
  !! target.
  subroutine finish_step(run, rewound, error)
    type(run_t), intent(inout) :: run
    logical, intent(out) :: rewound
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: before(:) ! load factors of the checkpoint, in the first step after it
    integer :: outcome
    logical :: formed, timed, short

    timed = run%step%open .and. run%step%timed
    formed = .not. (run%step%solved .or. run%step%newton%begins)
    if (run%state%step == run%plan%restarted_at + 1 .and. allocated(run%state%factor_step)) then
      before = run%state%factor_step
    end if
    call close_step(run%step, run%model, run%state, current_place(run%program), outcome, error)
    rewound = outcome == STEP_REWOUND
    if (allocated(error)) return
    call take_outcome(run, outcome, error)
    if (allocated(error)) return
    if (rewound) return
    call keep_tables(run)
    short = timed .and. run%step%control%automatic .and. .not. on_target(run%step%control)
    ! A checkpoint contains this position.
    if (short) call rewind_program(run%program, run%deck%params, run%plan%prints)
    if (outcome == STEP_ACCEPTED) then
      call watch_step(run)
      if (allocated(before)) call warn_continued(run, before)
      run%plan%closed_at = run%state%time
      call run%timers%start('output')
      call write_step(run, error)
      call run%timers%stop('output')
    else
      if (timed .and. formed) call warn_unsolved(run)
      call write_unsolved(run, timed, error)
    end if
    if (allocated(error)) return
    if (short) run%program%counter = run%program%counter - 1 ! the main loop adds one
    rewound = short
  end subroutine finish_step

  !> Warn once about a step, other than the last one, whose system was formed but not solved.
  subroutine warn_unsolved(run)
    type(run_t), intent(inout) :: run

    if (run%plan%unsolved_warned .or. run%program%counter > size(run%program%command)) return
    run%plan%unsolved_warned = .true.
    call warn('the step at time '//to_text(run%state%time)//' was not solved, so it has no ' &
              //'results', current_place(run%program), &
              'TANG,,1 and UTAN,,1 solve; TANG, UTAN and FORM alone only form the system')
  end subroutine warn_unsolved

  !> Write what PLOT and SAVE have requested in a step in which nothing was solved: its state is
  !! that of the step before. If time has passed, there is no result of the new time.
  subroutine write_unsolved(run, timed, error)
    type(run_t), intent(inout) :: run
    logical, intent(in) :: timed         !! TIME began the step
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word
    logical :: plots, saves

    plots = run%plan%plot
    saves = run%plan%save
    run%plan%plot = .false.
    run%plan%save = .false.
    if (.not. (plots .or. saves)) return
    if (timed) then
      word = 'PLOT has'
      if (.not. plots) word = 'SAVE has'
      if (plots .and. saves) word = 'PLOT and SAVE have'
      if (.not. run%plan%idle_warned) then
        call warn(word//' no effect after a TIME that no TANG,,1 or UTAN,,1 follows, because the ' &
                  //'state is that of the step before', hint='put the solve before it')
      end if
      run%plan%idle_warned = .true.
      return
    end if
    if (plots) then
      call open_files(run, error)
      if (.not. allocated(error)) call write_fields(run, error)
      if (allocated(error)) return
    end if
    if (saves) call write_checkpoint(run, error)
  end subroutine write_unsolved

  !> Close the current step if a system was solved in it, because its loads and its inertia follow
  !! from earlier commands. `rewound` is true if the command that began it is executed next.
  subroutine finish_solved_step(run, rewound, error)
    type(run_t), intent(inout) :: run
    logical, intent(out) :: rewound
    type(error_t), allocatable, intent(out) :: error

    rewound = .false.
    if (run%step%open .and. run%step%solved) call finish_step(run, rewound, error)
  end subroutine finish_solved_step

  !> Write the rows of the curves, the contacts in the log, fields and a checkpoint.
  subroutine write_step(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    logical :: fields

    call open_files(run, error)
    if (allocated(error)) return
    call write_rows(run, error)
    if (allocated(error)) return
    call list_contacts(run%model, run%state, run%step%newton%asm%f_ext)
    fields = run%plan%plot
    if (run%plan%every > 0) fields = fields .or. mod(run%state%step, run%plan%every) == 0
    if (fields) call write_fields(run, error)
    if (allocated(error)) return
    run%plan%plot = .false.
    if (run%plan%save) then
      run%plan%save = .false.
      call write_checkpoint(run, error)
    else if (run%step%newton%mode /= FULL .and. mod(run%state%step, RESTART_EVERY) == 0) then
      call set_restart_point(run)
    end if
  end subroutine write_step

end module command_step
