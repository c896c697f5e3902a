!> Checkpoints: the values that they contain in addition to the state, when they are written, and
!! how a run continues from a checkpoint.
module command_checkpoint
  use base_agreement, only: agree
  use base_comm, only: is_root, largest
  use base_error, only: error_t, fail, SYSTEM_ERROR, STOPPED
  use base_kinds, only: wp, i8
  use base_log, only: log_line, message_count, get_warning, recall_warning
  use base_system, only: stop_requested, wall_seconds
  use base_text, only: quoted, to_text
  use command_files, only: cut_tables, close_files, row_label
  use command_type, only: files_t, plan_t, program_t, run_t
  use contact_augment, only: is_augmented, share_penalty
  use deck_expression, only: params_t
  use deck_params, only: parameter_names, find_parameter, set_parameter
  use linear_system, only: FULL
  use model, only: state_t
  use named_values, only: named_values_t, put, get
  use program_position, only: rewind_program
  use program_version, only: VERSION
  use restart_file, only: fingerprint_t, make_fingerprint, store => write_checkpoint, &
                          read_checkpoint
  use solution_state, only: new_state
  use step, only: abandon_step
  implicit none
  private
  public :: write_checkpoint, set_restart_point, restore_run, check_checkpoint, recall_rows, &
            stop_wanted, stop_run, keep_multipliers

  ! FORMAT of restart_file must be increased whenever the names or the meaning of the values here
  ! change.

  !> Named values that are put into a checkpoint or taken from one, so that one list of names serves
  !! both.
  type :: exchange_t
    type(named_values_t) :: values
    logical :: writes = .true.
    logical :: whole = .true.          !! no value of the checkpoint was missing or invalid
  end type exchange_t

  interface exchange
    module procedure exchange_scalar, exchange_list
  end interface exchange

contains

  !> Write a checkpoint between two steps. From here on, this run and a restarted run behave in the
  !! same way.
  subroutine write_checkpoint(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    call set_restart_point(run)
    call store_restart_point(run, error)
    if (allocated(error)) return
    call log_line('checkpoint after step '//to_text(run%restart_point%state%step)//' written to ' &
                  //restart_path(run))
  end subroutine write_checkpoint

  !> Make the current state the point at which a run can restart, and forget kept factors. From here
  !! on, this run and a restarted run behave in the same way.
  subroutine set_restart_point(run)
    type(run_t), intent(inout) :: run
    type(exchange_t) :: exchanged

    if (run%step%newton%ready) call run%step%newton%system%force_refactor()
    call exchange_run(exchanged, run)
    run%restart_point%values = exchanged%values
    run%restart_point%state = run%state
    run%restart_point%set = .true.
  end subroutine set_restart_point

  !> Read the checkpoint from which the run is to continue; no file is changed.
  subroutine restore_run(run, path, error)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print
    type(exchange_t) :: exchanged

    call make_fingerprint(VERSION, run%files%deck_text, run%model, print)
    call read_checkpoint(path, print, run%state, exchanged%values, error)
    if (allocated(error)) return
    call keep_multipliers(run)
    exchanged%writes = .false.
    call exchange_run(exchanged, run)
    if (.not. exchanged%whole) then
      call fail(error, SYSTEM_ERROR, quoted(path)//' contains no complete checkpoint', &
                hint='start the analysis again, without --restart')
      return
    end if
    run%files%kept = run%state%step
    run%files%checkpoint = path
    call log_line('restarted after step '//to_text(run%state%step)//' from '//path)
  end subroutine restore_run

  !> Can a run continue from a checkpoint? Nothing is changed.
  subroutine check_checkpoint(run, path, error)
    type(run_t), intent(in) :: run
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print
    type(named_values_t) :: values
    type(state_t) :: state

    call make_fingerprint(VERSION, run%files%deck_text, run%model, print)
    call new_state(run%model, state)
    call read_checkpoint(path, print, state, values, error)
    call agree(error)
  end subroutine check_checkpoint

  !> After the state has been read: multipliers of control points act together with a penalty there,
  !! also if the deck has no AUGMent.
  subroutine keep_multipliers(run)
    type(run_t), intent(inout) :: run
    integer :: c

    do c = 1, size(run%model%contact)
      if (is_augmented(run%state%contact(c))) call share_penalty(run%model%contact(c))
    end do
  end subroutine keep_multipliers

  !> Has a signal to stop been received, or has the time limit been reached, on any rank?
  function stop_wanted(run) result(yes)
    type(run_t), intent(in) :: run
    logical :: yes

    yes = stop_requested()
    if (.not. yes .and. run%time_limit > 0.0_wp) yes = wall_seconds() > run%time_limit
    yes = largest(merge(1, 0, yes)) == 1
  end function stop_wanted

  !> Discard the current step, write a checkpoint, and end with code 4. The checkpoint contains the
  !! state after the previous step or, if factors are kept, the last restart point.
  subroutine stop_run(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    if (run%step%open) then
      call abandon_step(run%step, run%state)
      call rewind_program(run%program, run%deck%params, run%plan%prints)
      call cut_tables(run, error)
      call agree(error)
      if (allocated(error)) return
    end if
    if (.not. (run%step%newton%system%keeps_factors() .and. run%restart_point%set)) then
      call write_checkpoint(run, error)
    else
      call store_restart_point(run, error)
    end if
    if (allocated(error)) return
    call close_files(run, error)
    if (allocated(error)) return
    call fail(error, STOPPED, 'stopped after step '//to_text(run%state%step) &
              //'; the checkpoint contains step '//to_text(run%restart_point%state%step), &
              hint='continue with --restart '//restart_path(run))
  end subroutine stop_run

  subroutine store_restart_point(run, error)
    type(run_t), intent(in) :: run
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print

    if (is_root()) then
      call make_fingerprint(VERSION, run%files%deck_text, run%model, print)
      call store(restart_path(run), print, run%restart_point%state, run%restart_point%values, error)
    end if
    call agree(error)
  end subroutine store_restart_point

  function restart_path(run) result(path)
    type(run_t), intent(in) :: run
    character(:), allocatable :: path

    path = run%files%stem//'.restart.h5'
  end function restart_path

  !> Exchange everything besides the state that a restarted run needs between two steps.
  subroutine exchange_run(x, run)
    type(exchange_t), intent(inout) :: x
    type(run_t), intent(inout) :: run

    call exchange_program(x, run%program)
    call exchange_parameters(x, run%deck%params)
    call exchange(x, 'step_retry', run%step%retry)
    call exchange(x, 'step_cutbacks', run%step%cutbacks)
    call exchange(x, 'step_needs_secant', run%step%needs_secant)
    call exchange(x, 'step_secant', run%step%secant)
    call exchange(x, 'step_secant_attempts', run%step%secant_attempts)
    call exchange(x, 'step_exhausted', run%step%exhausted)
    associate (total => run%step%total)
      call exchange(x, 'total_iterations', total%iterations)
      call exchange(x, 'total_cutbacks', total%cutbacks)
      call exchange(x, 'total_negative_pivots', total%negative_pivots)
      call exchange(x, 'total_unconverged', total%unconverged)
      call exchange(x, 'total_inertia', total%inertia)
    end associate
    associate (newton => run%step%newton)
      call exchange(x, 'newton_tolerance', newton%tolerance)
      call exchange(x, 'newton_mode', newton%mode)
      call exchange(x, 'newton_eps', newton%eps)
      call exchange(x, 'newton_symmetric', newton%symmetric)
    end associate
    associate (control => run%step%control)
      call exchange(x, 'control_dt', control%dt)
      call exchange(x, 'control_origin', control%origin)
      call exchange(x, 'control_target', control%target)
      call exchange(x, 'control_size', control%size)
      call exchange(x, 'control_automatic', control%automatic)
      call exchange(x, 'control_dtmin', control%dtmin)
      call exchange(x, 'control_dtmax', control%dtmax)
      call exchange(x, 'control_from', control%from)
      call exchange(x, 'control_to', control%to)
      call exchange(x, 'control_passed', control%passed)
      call exchange(x, 'control_accepted', control%accepted)
      call exchange(x, 'control_failed', control%failed)
    end associate
    associate (hold => run%step%newton%hold)
      call exchange(x, 'hold_active', hold%active)
      call exchange(x, 'hold_fell', hold%fell)
      call exchange(x, 'hold_warned', hold%warned)
      call exchange(x, 'hold_warned_share', hold%warned_share)
      call exchange(x, 'hold_energy', hold%energy)
      call exchange(x, 'hold_work', hold%work)
    end associate
    associate (path => run%step%continuation)
      call exchange(x, 'path_method', path%method)
      call exchange(x, 'path_given', path%given)
      call exchange(x, 'path_active', path%active)
      call exchange(x, 'path_trial', path%trial)
      call exchange(x, 'path_steps', path%steps)
      call exchange(x, 'path_wait', path%wait)
      call exchange(x, 'path_next_wait', path%next_wait)
      call exchange(x, 'path_density', path%density)
      call exchange(x, 'path_release', path%release)
      call exchange(x, 'path_largest_release', path%largest_release)
      call exchange(x, 'path_length', path%length)
      call exchange(x, 'path_shortest', path%shortest)
      call exchange(x, 'path_longest', path%longest)
      call exchange(x, 'path_multiple', path%multiple)
      call exchange(x, 'path_released', path%released)
      call exchange(x, 'path_opening', path%opening)
      call exchange(x, 'path_patience', path%patience)
    end associate
    call exchange(x, 'path_warned_length', run%step%continuation%warned_length)
    call exchange(x, 'path_warned_inertia', run%step%continuation%warned_inertia)
    call exchange(x, 'path_warned_energy', run%step%continuation%warned_energy)
    call exchange(x, 'total_unstable', run%step%total%unstable)
    call exchange(x, 'total_jumped', run%step%total%jumped)
    call exchange(x, 'total_uneven', run%step%total%uneven)
    call exchange(x, 'total_lost_time', run%step%total%lost_time)
    call exchange(x, 'total_untimed', run%step%total%untimed)
    call exchange(x, 'total_still', run%step%total%still)
    call exchange(x, 'total_load', run%step%total%load)
    call exchange(x, 'total_rounding', run%step%total%rounding)
    call exchange(x, 'total_rounding_step', run%step%total%rounding_step)
    call exchange(x, 'turn_warned', run%plan%turn_warned)
    call exchange(x, 'strain_warned', run%plan%strain_warned)
    call exchange(x, 'inverted_warned', run%plan%inverted_warned)
    call exchange(x, 'idle_warned', run%plan%idle_warned)
    call exchange(x, 'unsolved_warned', run%plan%unsolved_warned)
    call exchange(x, 'restarted_at', run%plan%restarted_at)
    call exchange(x, 'loads_changed', run%plan%loads_changed)
    call exchange_warnings(x)
    call exchange_tables(x, run%plan)
    call exchange(x, 'output_every', run%plan%every)
    call exchange(x, 'tplot_every', run%plan%tplot_every)
    call exchange(x, 'prints', run%plan%prints)
    call exchange_printed(x, run%files)
    call exchange(x, 'fields_step', run%files%fields_step)
    call exchange(x, 'fields_time', run%files%fields_time)
    if (x%writes) then
      call keep_rows(run, x%values)
    else
      call recall_rows(run, x%values)
    end if
  end subroutine exchange_run

  !> Store the last row of every curve, so that a restarted run recognises its files.
  subroutine keep_rows(run, values)
    type(run_t), intent(in) :: run
    type(named_values_t), intent(inout) :: values
    real(wp), allocatable :: row(:)
    character(:), allocatable :: labels
    integer, allocatable :: length(:)
    integer :: i

    labels = ''
    allocate (length(0), row(0))
    if (allocated(run%files%last_row)) then
      do i = 1, size(run%files%last_row)
        if (.not. allocated(run%files%last_row(i)%value)) cycle
        labels = labels//row_label(run, i)//new_line('a')
        length = [length, size(run%files%last_row(i)%value)]
        row = [row, run%files%last_row(i)%value]
      end do
    end if
    call put(values, 'row_labels', labels)
    call put(values, 'row_lengths', length)
    call put(values, 'rows', row)
  end subroutine keep_rows

  !> Take from a checkpoint the last rows of those curves that have the same columns in this deck,
  !! and the names of those that this deck does not have.
  subroutine recall_rows(run, values)
    type(run_t), intent(inout) :: run
    type(named_values_t), intent(in) :: values
    real(wp), allocatable :: row(:)
    character(:), allocatable :: labels
    integer, allocatable :: length(:)
    integer :: blank, c, first, i, k, last
    logical :: has, there(3)

    if (allocated(run%files%recalled)) deallocate (run%files%recalled)
    allocate (run%files%recalled(size(run%model%curve)))
    run%files%ended = ''
    call get(values, 'row_labels', labels, there(1))
    call get(values, 'row_lengths', length, there(2))
    call get(values, 'rows', row, there(3))
    if (.not. all(there)) return
    if (any(length < 2) .or. sum(length) /= size(row)) return
    first = 1
    k = 0
    do i = 1, size(length)
      last = first + index(labels(first:), new_line('a')) - 2
      if (last < first) return
      has = .false.
      do c = 1, size(run%model%curve)
        has = has .or. index(labels(first:last)//' ', run%model%curve(c)%name//' ') == 1
        if (row_label(run, c) == labels(first:last)) run%files%recalled(c)%value &
          = row(k + 1:k + length(i))
      end do
      if (.not. has) then
        blank = first + index(labels(first:last)//' ', ' ') - 1
        run%files%ended = run%files%ended//labels(first:blank - 1)//new_line('a')
      end if
      k = k + length(i)
      first = last + 2
    end do
  end subroutine recall_rows

  !> Exchange the length of the printed tables of the closed steps.
  subroutine exchange_printed(x, files)
    type(exchange_t), intent(inout) :: x
    type(files_t), intent(inout) :: files
    real(wp) :: length ! a whole number that may be too large for an integer of the checkpoint

    length = real(files%printed, wp)
    call exchange(x, 'printed', length)
    if (x%writes .or. .not. x%whole) return
    x%whole = length >= 0.0_wp .and. length < 2.0_wp**digits(length)
    if (x%whole) files%printed = int(length, i8)
  end subroutine exchange_printed

  !> Exchange what has been seen of the load tables (see table_use).
  subroutine exchange_tables(x, plan)
    type(exchange_t), intent(inout) :: x
    type(plan_t), intent(inout) :: plan
    integer, allocatable :: acted(:), ended(:), defined(:)
    integer :: n

    call exchange(x, 'corner_warned', plan%corner_warned)
    if (x%writes) then
      acted = [integer ::]
      ended = [integer ::]
      defined = [integer ::]
      if (allocated(plan%defined_at)) defined = reshape(plan%defined_at, [size(plan%defined_at)])
      if (allocated(plan%acted)) acted = merge(1, 0, plan%acted)
      if (allocated(plan%ended)) ended = merge(1, 0, plan%ended)
    end if
    call exchange(x, 'table_acted', acted)
    call exchange(x, 'table_ended', ended)
    call exchange(x, 'table_defined_at', defined)
    if (x%writes .or. .not. x%whole) return
    plan%defined_at = reshape(defined(:2*(size(defined)/2)), [2, size(defined)/2])
    n = size(ended)
    if (size(acted) /= n + 1) return ! no step has been closed
    if (allocated(plan%acted)) deallocate (plan%acted, plan%ended)
    allocate (plan%acted(0:n), plan%ended(n))
    plan%acted = acted > 0
    plan%ended = ended > 0
  end subroutine exchange_tables

  subroutine exchange_program(x, program)
    type(exchange_t), intent(inout) :: x
    type(program_t), intent(inout) :: program
    integer, allocatable :: at(:), count(:), limit(:), visit(:)

    call exchange(x, 'command', program%counter)
    if (x%writes) then
      at = program%loop(:)%at
      count = program%loop(:)%count
      limit = program%loop(:)%limit
      visit = program%command(:)%visit
    end if
    call exchange(x, 'loop_at', at)
    call exchange(x, 'loop_count', count)
    call exchange(x, 'loop_limit', limit)
    call exchange(x, 'visits', visit)
    if (x%writes .or. .not. x%whole) return
    x%whole = size(visit) == size(program%command) .and. size(count) == size(at) &
              .and. size(limit) == size(at)
    if (x%whole) x%whole = program%counter >= 1 .and. program%counter <= size(visit) + 1 &
                           .and. all(at >= 1 .and. at <= size(visit)) .and. all(visit >= 0) &
                           .and. all(count >= 0)
    if (.not. x%whole) return
    if (allocated(program%loop)) deallocate (program%loop)
    allocate (program%loop(size(at)))
    program%loop(:)%at = at
    program%loop(:)%count = count
    program%loop(:)%limit = limit
    program%command(:)%visit = visit
  end subroutine exchange_program

  !> Exchange all parameters by name: PARAmeter may have defined some that are not in the mesh part
  !! of the deck. The names are stored with blanks up to a common length.
  subroutine exchange_parameters(x, params)
    type(exchange_t), intent(inout) :: x
    type(params_t), intent(inout) :: params
    character(:), allocatable :: names
    real(wp), allocatable :: value(:)
    logical :: there(2)
    integer :: i, length

    if (x%writes) then
      names = ''
      associate (name => parameter_names(params))
        allocate (value(size(name)))
        do i = 1, size(name)
          names = names//name(i)
          call find_parameter(params, trim(name(i)), value(i), there(1))
        end do
      end associate
      call put(x%values, 'parameter_names', names)
      call put(x%values, 'parameters', value)
      return
    end if
    call get(x%values, 'parameter_names', names, there(1))
    call get(x%values, 'parameters', value, there(2))
    x%whole = x%whole .and. all(there)
    if (.not. x%whole .or. size(value) == 0) return
    length = len(names)/size(value)
    x%whole = length > 0 .and. len(names) == length*size(value)
    if (.not. x%whole) return
    do i = 1, size(value)
      call set_parameter(params, trim(names(length*(i - 1) + 1:length*i)), value(i))
    end do
  end subroutine exchange_parameters

  !> Exchange the messages of the warnings, one on each line, so that the report of a restarted run
  !! contains all of them.
  subroutine exchange_warnings(x)
    type(exchange_t), intent(inout) :: x
    character(:), allocatable :: message, text
    integer :: first, i, length
    logical :: there

    if (x%writes) then
      text = ''
      do i = 1, message_count()
        call get_warning(i, message)
        text = text//message//new_line('a')
      end do
      call put(x%values, 'warnings', text)
      return
    end if
    call get(x%values, 'warnings', text, there)
    x%whole = x%whole .and. there
    if (.not. there) return
    first = 1
    do
      length = index(text(first:), new_line('a')) - 1
      if (length < 0) exit
      call recall_warning(text(first:first + length - 1))
      first = first + length + 1
    end do
  end subroutine exchange_warnings

  !> Exchange a number or a logical.
  subroutine exchange_scalar(x, name, value)
    type(exchange_t), intent(inout) :: x
    character(*), intent(in) :: name
    class(*), intent(inout) :: value
    logical :: there

    there = x%writes
    select type (value)
    type is (real(wp))
      if (x%writes) call put(x%values, name, value)
      if (.not. x%writes) call get(x%values, name, value, there)
    type is (integer)
      if (x%writes) call put(x%values, name, value)
      if (.not. x%writes) call get(x%values, name, value, there)
    type is (logical)
      if (x%writes) call put(x%values, name, value)
      if (.not. x%writes) call get(x%values, name, value, there)
    end select
    x%whole = x%whole .and. there
  end subroutine exchange_scalar

  subroutine exchange_list(x, name, value)
    type(exchange_t), intent(inout) :: x
    character(*), intent(in) :: name
    integer, allocatable, intent(inout) :: value(:)
    logical :: there

    there = x%writes
    if (x%writes) call put(x%values, name, value)
    if (.not. x%writes) call get(x%values, name, value, there)
    x%whole = x%whole .and. there
  end subroutine exchange_list

end module command_checkpoint
