!> The main program, from arguments to exit code. Start reading at run.f90.
program main
  use base_agreement, only: agree
  use base_comm, only: start_comm, stop_comm, is_root, rank_count, ranks_here
  use base_error, only: error_t, render, DECK_ERROR, error_list_t
  use base_file, only: make_folder, lock_file, unlock_file, lock_t, note_input
  use base_log, only: open_log, close_log, log_line, set_quiet, mute_log, progress, &
                      summary, warn
  use base_system, only: finish_now, catch_signals, release_signals, start_clock, &
                         keep_signals_waiting, wall_seconds, keep_memory, set_default
  use base_text, only: to_text
  use base_threads, only: machine_cores, own_cores, thread_count
  use base_timer, only: new_timers
  use blas_choice, only: prepare_blas
  use blas_threads, only: set_threads
  use check_deck, only: print_check
  use command_checkpoint, only: check_checkpoint, restore_run
  use command_line, only: options_t, read_command_line, print_help
  use command_type, only: run_t
  use listing, only: list_model
  use output_guard, only: check_outputs
  use program_list, only: print_list
  use program_version, only: VERSION
  use run, only: read_deck, execute
  use run_report, only: reserve_report, drop_reserve, report_run, run_summary
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  type(options_t) :: options
  type(run_t), allocatable :: job
  type(error_list_t) :: errors
  type(error_t), allocatable :: error, unreported, unlogged, refused
  type(lock_t) :: lock
  integer :: code

  call keep_signals_waiting() ! until catch_signals
  call start_clock()
  call keep_memory()
  call prepare_blas()
  call start_comm()
  if (.not. is_root()) call mute_log()
  call read_command_line(options, error)
  call stop_on(error)
  if (options%help) then
    call print_help()
    call stop_comm(0, '')
  else if (options%version) then
    print '(a)', 'bezel '//VERSION
    call stop_comm(0, '')
  else if (allocated(options%list)) then
    call print_list(options%list)
    call stop_comm(0, '')
  end if

  call catch_signals()
  if (options%check) call release_signals()
  call set_quiet(options%quiet)
  call set_threads(options%threads, error)
  if (allocated(error)) then
    write (error_unit, '(a)') render(error)
    call finish_now(error%code)
  end if
  allocate (job)
  call new_timers(job%timers)
  job%files%stem = options%outdir//'/'//options%stem
  call read_deck(options, job, errors, error)
  call agree(error)
  if (errors%count() > 0) then
    if (allocated(error)) call errors%add(error)
    write (error_unit, '(a)') errors%render()
    call stop_comm(1, errors%render())
  end if
  call stop_on(error)
  if (allocated(options%restart)) call note_input(options%restart, checkpoint=.true.)
  call check_outputs(job, error)
  call stop_on(error)
  if (options%check) then
    if (allocated(options%restart)) call check_checkpoint(job, options%restart, error)
    call stop_on(error)
    call print_check(job, error)
    call stop_on(error)
    call stop_comm(0, '')
  end if

  ! A checkpoint of another deck counts as an error in the deck. No file may have been changed
  ! before such an error.
  if (allocated(options%restart)) call restore_run(job, options%restart, refused)
  call agree(refused)
  if (allocated(refused)) then
    if (refused%code == DECK_ERROR) call stop_on(refused)
  end if
  if (is_root()) call make_folder(options%outdir, error)
  call agree(error)
  call stop_on(error)
  job%time_limit = options%time_limit
  if (is_root()) call lock_file(job%files%stem//'.lock', lock, error)
  call agree(error)
  call stop_on(error)
  if (is_root()) then
    call reserve_report(job)
    call open_log(job%files%stem//'.log', error)
    if (allocated(error)) call drop_reserve(job)
  end if
  call agree(error)
  if (allocated(error)) then
    call unlock_file(lock)
    call stop_on(error)
  end if
  call log_line('bezel '//VERSION//', deck '//options%deck)
  if (rank_count() > 1) call log_line('runs on '//to_text(rank_count())//' ranks')
  if (thread_count() > 1) call log_line('uses '//to_text(thread_count())//' threads on each rank')
  call warn_of_cores()
  call list_model(job%model)

  ! Factors that do not fit into memory go to files beside the results. MUMPS rejects long names.
  if (len(options%outdir) < 200) call set_default('MUMPS_OOC_TMPDIR', options%outdir)
  call set_default('MUMPS_OOC_PREFIX', 'factors')
  if (.not. allocated(refused)) call execute(job, error)
  call job%step%newton%system%free() ! this removes the files of the factors
  if (allocated(refused)) call move_alloc(refused, error)
  call progress('')
  if (is_root()) call drop_reserve(job) ! the last lines of the log need space too
  code = 0
  if (allocated(error)) then
    code = error%code
    write (error_unit, '(a)') render(error)
    call log_line(render(error))
  end if
  call log_line('')
  call log_line(job%timers%table())
  call log_line('exit code '//to_text(code)//', '//to_text(wall_seconds(), 4)//' s')
  if (is_root()) call report_run(job, options%deck, code, unreported)
  call agree(unreported)
  call summary(run_summary(job, code))
  call close_log(unlogged)
  call agree(unlogged)
  call unlock_file(lock)
  if (code == 0) call stop_on(unreported)
  if (code == 0) call stop_on(unlogged)
  call stop_comm(code, '')

contains

  !> Warn if there are more threads than cores: threads and ranks then wait for each other.
  subroutine warn_of_cores()
    associate (n => thread_count())
      if (n*ranks_here() > machine_cores()) then
        call warn(to_text(ranks_here())//' ranks with '//to_text(n)//' threads each share ' &
                  //to_text(machine_cores())//' cores', hint='use fewer threads or ranks')
      else if (n > own_cores()) then
        call warn(to_text(n)//' threads share '//to_text(own_cores())//' cores, to which this ' &
                  //'process is bound', hint='mpirun --bind-to none, or taskset, changes this')
      end if
    end associate
  end subroutine warn_of_cores

  subroutine stop_on(error)
    type(error_t), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    write (error_unit, '(a)') render(error)
    call stop_comm(error%code, render(error))
  end subroutine stop_on

end program main
