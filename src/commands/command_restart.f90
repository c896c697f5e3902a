!> RESTart: continues from the state in a checkpoint, with the commands of this deck.
module command_restart
  use base_agreement, only: agree
  use base_error, only: error_t, fail, DECK_ERROR
  use base_file, only: file_t, inspect, FILE_ABSENT
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text, quoted
  use command_checkpoint, only: keep_multipliers, recall_rows, set_restart_point
  use command_doubts, only: warn_kept_multipliers
  use command_files, only: continue_tables, open_files
  use command_type, only: run_t, command_t, command_row_t, new_row
  use deck_record, only: resolve_path
  use contact_augment, only: is_augmented
  use continuation_type, only: BY_ARC, BY_RELEASE
  use contact_report, only: renew_warnings
  use dynamics_type, only: dynamics_t, new_dynamics
  use load_curve, only: load_table_t
  use model, only: state_t
  use model_hash, only: LOAD_PART, PART
  use named_values, only: named_values_t, get
  use program_version, only: VERSION
  use restart_file, only: fingerprint_t, make_fingerprint, read_checkpoint
  use solution_state, only: new_state, set_factors
  use step_control, only: set_dt
  use uneven_steps, only: warn_scheme
  implicit none
  private
  public :: restart_rows

contains

  function restart_rows() result(row)
    type(command_row_t) :: row(1)

    row(1) = new_row('RESTart', 'RESTart[,file][,CONStants]', 2, run_restart)
    row(1)%reads = .true.
  end function restart_rows

  !> Read displacements, rates, history, time and step number from the checkpoint. The load tables
  !! and the time integration remain those of this deck, and targets of DT are counted from the time
  !! of the checkpoint. The model must be the same, except for its loads and, with CONStants, the
  !! constants of its materials and contacts.
  subroutine run_restart(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(load_table_t), allocatable :: table(:)
    type(dynamics_t) :: dynamics
    type(state_t) :: state
    type(named_values_t) :: values
    type(file_t) :: file
    character(:), allocatable :: changed
    integer :: i

    do i = 1, run%program%counter - 1
      associate (record => run%program%command(i)%record)
        if (all(record%key(1) /= ['time', 'tang', 'utan', 'form', 'plot', 'save', 'disp', 'reac', &
                                  'stre', 'rest'])) cycle
        call fail(error, DECK_ERROR, 'RESTart comes after '//quoted(record%text(1)), &
                  command%record%place(1), 'use RESTart once, before all steps, solves, ' &
                  //'printed tables, PLOT and SAVE')
      end associate
      return
    end do
    if (size(run%program%loop) > 0) then
      call fail(error, DECK_ERROR, 'RESTart is in a LOOP, each pass of which would begin again ' &
                //'from the checkpoint', command%record%place(1), 'put RESTart before the LOOP')
      return
    end if
    if (.not. command%record%is_empty(3)) then
      if (command%record%key(3) /= 'cons') then
        call fail(error, DECK_ERROR, 'expected CONStants, found '//quoted(command%record%text(3)), &
                  command%record%place(3), 'RESTart[,file][,CONStants]')
        return
      end if
    end if
    if (run%program%dry) then          ! report a wrong file before anything is written
      call new_state(run%model, state)
      call read_state(run, command, state, values, changed, error)
      if (.not. allocated(error)) return
      call inspect(path_of(run, command), file)
      if (file%kind == FILE_ABSENT) error%code = DECK_ERROR
      if (error%code /= DECK_ERROR) deallocate (error) ! the real run reports this error
      return
    end if
    table = run%state%table
    dynamics = run%state%dynamics
    call read_state(run, command, run%state, values, changed, error)
    if (allocated(error)) return
    call move_alloc(table, run%state%table)
    call keep_integration(run, command, dynamics)
    call warn_path(command, values)
    call keep_multipliers(run)
    call set_factors(run%state)
    associate (control => run%step%control)
      if (control%dt > 0) call set_dt(control, run%state%time, control%dt)
    end associate
    run%files%kept = run%state%step
    run%plan%restarted_at = run%state%step
    run%plan%loads_changed = index(changed, trim(PART(LOAD_PART))) > 0
    run%files%checkpoint = path_of(run, command)
    call keep_printed(run, command, values)
    call recall_fields(run, values)
    call recall_rows(run, values)
    call recall_loads(run, values)
    call log_line('restarted after step '//to_text(run%state%step)//' from '//path_of(run, command))
    if (changed == '') changed = 'nothing'
    call log_line('changed since the analysis that wrote the checkpoint: '//changed)
    call renew_warnings(run%model, run%state)
    if (any([(is_augmented(run%state%contact(i)), i=1, size(run%state%contact))])) then
      call warn_kept_multipliers(run, run%program%counter)
    end if
    call open_files(run, error)
    if (allocated(error)) return
    run%program%counter = run%program%counter + 1 ! the run can restart after this RESTart
    call set_restart_point(run)
    run%program%counter = run%program%counter - 1
  end subroutine run_restart

  !> Take the rates of a motion from the checkpoint, but all else from the TRANsient and MASS of
  !! this deck. After static steps a motion begins from rest. Warn if the checkpoint is from
  !! dynamics and this deck has no TRANsient.
  subroutine keep_integration(run, command, deck)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(dynamics_t), intent(in) :: deck !! dynamics before the checkpoint was read
    logical :: lumped, stops
    integer :: i

    associate (dynamics => run%state%dynamics)
      stops = dynamics%on .and. dynamics%density < 0.0_wp ! otherwise the continuation added inertia
      if (allocated(dynamics%v) .and. .not. stops) call new_dynamics(dynamics, size(dynamics%v, 2))
      if (stops .and. deck%on) then
        call warn_scheme(run%model, run%state, deck%method, command%record%place(1))
      end if
      dynamics%on = deck%on
      if (deck%on .or. .not. stops) dynamics%method = deck%method ! otherwise a TRANsient follows
      lumped = dynamics%lumped .and. .not. deck%lumped
      dynamics%lumped = deck%lumped
      dynamics%beta = deck%beta
      dynamics%gamma = deck%gamma
      dynamics%alpha = deck%alpha
      dynamics%density = deck%density
      dynamics%continues = stops
    end associate
    associate (list => run%program%command)
      lumped = lumped .and. stops .and. .not. any([(list(i)%record%key(1) == 'mass', &
                                                    i=1, size(list))])
      stops = stops .and. .not. any([(list(i)%record%key(1) == 'tran', i=1, size(list))])
    end associate
    if (lumped .and. .not. stops) then
      call warn('the motion of the checkpoint had lumped masses, but this deck has no MASS, so ' &
                //'they are consistent now', command%record%place(1), 'put MASS,LUMPed among the ' &
                //'commands')
    end if
    if (stops) call warn('the checkpoint contains a motion with inertia, but this deck has no ' &
                         //'TRANsient, so the run continues without inertia', &
                         command%record%place(1), 'put TRANsient among the commands to continue ' &
                         //'the motion, or TRANsient,OFF to end it')
  end subroutine keep_integration

  !> Warn if the run of the checkpoint did not control the loads by time: its state need not be
  !! stable under load control, with which this deck goes on.
  subroutine warn_path(command, values)
    type(command_t), intent(in) :: command
    type(named_values_t), intent(in) :: values
    integer :: active
    logical :: there

    call get(values, 'path_active', active, there)
    if (.not. there) return
    if (all(active /= [BY_ARC, BY_RELEASE])) return
    call warn('the checkpoint lies on a path of ARCLength, but the first step after RESTart is ' &
              //'under load control and may jump to a distant state', command%record%place(1), &
              'continue the deck that wrote the checkpoint with bezel --restart')
  end subroutine warn_path

  !> Keep the printed tables up to the checkpoint. Only the checkpoint under the name of this run
  !! knows the length of its file of tables; with any other one the whole file remains.
  subroutine keep_printed(run, command, values)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(named_values_t), intent(in) :: values
    type(file_t) :: found, own
    real(wp) :: length !! [byte]
    logical :: there

    call inspect(path_of(run, command), found)
    call inspect(own_path(run), own)
    call get(values, 'printed', length, there)
    if (there .and. all(found%identity == own%identity)) then
      call continue_tables(run, length)
    else
      call continue_tables(run)
    end if
  end subroutine keep_printed

  !> Recall the last step whose fields the run of the checkpoint had written.
  subroutine recall_fields(run, values)
    type(run_t), intent(inout) :: run
    type(named_values_t), intent(in) :: values
    logical :: there

    call get(values, 'fields_step', run%files%fields_step, there)
    call get(values, 'fields_time', run%files%fields_time, there)
  end subroutine recall_fields

  !> Recall which load tables have acted and the largest load of the run so far. Before a PROP, all
  !! loads have the factor 1.
  subroutine recall_loads(run, values)
    type(run_t), intent(inout) :: run
    type(named_values_t), intent(in) :: values
    integer, allocatable :: acted(:)
    logical :: there

    call get(values, 'total_load', run%step%total%load, there)
    call get(values, 'table_acted', acted, there)
    if (.not. there) return
    if (size(acted) == 0) acted = [merge(1, 0, run%state%step > 0)]
    allocate (run%plan%acted(0:size(acted) - 1), source=acted > 0)
    allocate (run%plan%ended(size(acted) - 1), source=.false.)
  end subroutine recall_loads

  !> Read the state and the named values in the file that the command names.
  subroutine read_state(run, command, state, values, changed, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    type(state_t), intent(inout) :: state
    type(named_values_t), intent(out) :: values
    character(:), allocatable, intent(out) :: changed !! accepted differences
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: text
    type(fingerprint_t) :: print

    text = ''
    if (allocated(run%files%deck_text)) text = run%files%deck_text
    call make_fingerprint(VERSION, text, run%model, print)
    call read_checkpoint(path_of(run, command), print, state, values, error, any_deck=.true., &
                         constants=.not. command%record%is_empty(3), changed=changed)
    call agree(error)
    if (.not. allocated(error)) return
    error%place = command%record%place(1)
    if (index(error%message, 'belongs to another model') > 0) then
      error%hint = 'the decks may differ only in loads, load tables, steps, tolerances and ' &
                   //'output, and with RESTart,file,CONStants also in the constants of materials ' &
                   //'and contacts'
    end if
  end subroutine read_state

  !> The path of the checkpoint: beside the deck or, if it is not there, from the working folder.
  function path_of(run, command) result(path)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    character(:), allocatable :: path
    type(file_t) :: file

    path = own_path(run)
    if (command%record%is_empty(2)) return
    path = resolve_path(command%record, 2)
    call inspect(path, file)
    if (file%kind == FILE_ABSENT) path = command%record%text(2)
  end function path_of

  !> The path of the checkpoints that this run writes.
  function own_path(run) result(path)
    type(run_t), intent(in) :: run
    character(:), allocatable :: path

    path = run%files%stem//'.restart.h5'
  end function own_path

end module command_restart
