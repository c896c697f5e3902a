!> Reads the solution part of a deck: BATCh ... END and the data records that follow it.
!!
!! Everything is read and checked before anything is solved or written. To this end there is a dry
!! run, in which each command with data reads its records, in the order of execution.
module command_program
  use base_error, only: error_t, fail, DECK_ERROR, error_list_t
  use base_kinds, only: wp
  use base_text, only: nearest
  use command_load, only: name_end_of_table
  use command_step, only: finish_solved_step
  use command_table, only: load_commands
  use command_type, only: run_t, program_t, command_t, data_t
  use deck_expression, only: params_t
  use deck_feap, only: command_hint
  use deck_record, only: record_t, check_count, check_numbers, RECORD_WORDS, RECORD_END
  use deck_stream, only: get_real
  use program_position, only: has_data
  use step_control, only: step_control_t
  implicit none
  private
  public :: read_program, has_command, execute_next

contains

  !> Does the program contain a command?
  pure logical function has_command(run, key)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key
    integer :: i

    has_command = any([(run%program%command(i)%record%key(1) == key, &
                        i=1, size(run%program%command))])
  end function has_command

  !> Read all batches of the deck into one program.
  subroutine read_program(run, errors, error)
    type(run_t), intent(inout) :: run
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(params_t) :: params
    type(step_control_t) :: control

    call load_commands(run%program%row)
    allocate (run%program%command(0), run%program%loop(0))
    allocate (run%program%defined(0))
    allocate (run%program%noted(size(run%program%row)), source=.false.)
    params = run%deck%params
    control = run%step%control
    run%program%dry = .true.
    do
      call run%deck%next(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_END) exit
      if (record%kind /= RECORD_WORDS) cycle
      if (record%key(1) == 'stop') then
        call check_numbers(record, 2, 'STOP takes no numbers', error)
        exit
      end if
      if (record%key(1) /= 'batc') then
        if (errors%count() > 0 .and. is_number(record)) cycle ! data of commands that were not read
        call fail(error, DECK_ERROR, "unexpected '"//record%text(1)//"'", record%place(1), &
                  'after the mesh come BATCh ... END, the data of its commands and STOP')
        if (is_number(record)) then
          error%hint = 'no remaining command reads this record'
          if (allocated(run%program%end_of_table)) then
            call name_end_of_table(run%program, error)
          else
            error%hint = error%hint//'; note that a blank record in place of the table of a PROP ' &
                         //'means p = t'
          end if
        end if
        return
      end if
      call check_numbers(record, 2, 'BATCh takes no numbers', error)
      if (.not. allocated(error)) call read_batch(run, record, errors, error)
      if (allocated(error)) return
    end do
    if (allocated(error)) return
    ! Undo what the dry run changed.
    run%program%dry = .false.
    run%program%counter = 1
    run%program%loop = run%program%loop(:0)
    run%program%command(:)%visit = 0
    run%deck%params = params
    run%step%control = control
  end subroutine read_program

  !> Does a record begin with a number, as data of commands do?
  pure logical function is_number(record)
    type(record_t), intent(in) :: record

    is_number = scan(record%text(1)//' ', '0123456789.+-') == 1
  end function is_number

  !> Read one batch: its commands up to END, then their data.
  subroutine read_batch(run, opening, errors, error)
    type(run_t), intent(inout) :: run
    type(record_t), intent(in) :: opening
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(error_t), allocatable :: found
    type(command_t), allocatable :: list(:), longer(:) !! may be longer than the n commands in it
    character(:), allocatable :: hint
    integer :: first, n, i

    n = size(run%program%command)
    first = n + 1
    call move_alloc(run%program%command, list)
    do
      call run%deck%next_command(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_END) then
        call fail(error, DECK_ERROR, 'BATCh has no END', opening%place(1), &
                  'close the commands with END')
        return
      end if
      if (record%key(1) == 'end') then
        call check_numbers(record, 2, 'END takes no numbers', error)
        if (allocated(error)) return
        exit
      end if
      if (record%key(1) == 'incl') then
        call run%deck%include(record, error)
        if (allocated(error)) return
        cycle
      end if
      associate (row => run%program%row)
        do i = size(row), 1, -1
          if (row(i)%key == record%key(1)) exit
        end do
        if (i == 0) then
          hint = command_hint(record%text(1))
          if (len(hint) == 0) hint = 'nearest known: '//nearest(record%text(1), row(:)%word)
          call fail(found, DECK_ERROR, "unknown command '"//record%text(1)//"'", record%place(1), &
                    hint)
        else
          call check_count(record, 1, row(i)%nmax + 1, trim(row(i)%usage), found)
        end if
      end associate
      if (allocated(found)) then
        call errors%add(found)
        cycle
      end if
      if (n == size(list)) then
        allocate (longer(2*n + 32))
        longer(:n) = list
        call move_alloc(longer, list)
      end if
      n = n + 1
      list(n)%row = i
      list(n)%record = record
      list(n)%begins_batch = n == first .and. first > 1
      allocate (list(n)%data(0))
    end do
    run%program%command = list(:n)
    if (errors%count() > 0) return
    call match_loops(run%program, first, error)
    if (allocated(error)) return
    call run_dry(run, first, error)
  end subroutine read_batch

  !> Pair LOOP and NEXT, beginning with the command `first`.
  subroutine match_loops(program, first, error)
    type(program_t), intent(inout) :: program
    integer, intent(in) :: first
    type(error_t), allocatable, intent(out) :: error
    integer :: loop(64), depth, i

    depth = 0
    do i = first, size(program%command)
      associate (next => program%command(i)%record)
        select case (next%key(1))
        case ('loop')
          if (depth == size(loop)) then
            call fail(error, DECK_ERROR, 'LOOP is nested more than 64 levels deep', next%place(1))
            return
          end if
          depth = depth + 1
          loop(depth) = i
        case ('next')
          if (depth == 0) then
            call fail(error, DECK_ERROR, 'NEXT has no LOOP', next%place(1), &
                      'remove it, or put LOOP,name,n before it')
            return
          end if
          associate (opening => program%command(loop(depth))%record)
            if (loop(depth) == i - 1) then
              call fail(error, DECK_ERROR, 'the loop is empty', opening%place(1), &
                        'put commands between LOOP and NEXT, or remove both')
            else if (.not. (next%is_empty(2) .or. opening%is_empty(2))) then
              if (next%key(2) /= opening%key(2)) then
                call fail(error, DECK_ERROR, "expected the NEXT of loop '"//opening%text(2) &
                          //"', found '"//next%text(2)//"'", next%place(2), &
                          'close inner loops first')
              end if
            end if
          end associate
          if (allocated(error)) return
          program%command(i)%matching = loop(depth)
          program%command(loop(depth))%matching = i
          depth = depth - 1
        case ('time')
          if (depth > 0) program%command(loop(depth))%holds_time = .true.
          program%command(loop(:depth))%spans_time = .true.
        case ('tang', 'utan', 'solv')
          if (depth > 0) program%command(loop(depth))%solves = .true.
        case default
          cycle
        end select
      end associate
    end do
    if (depth > 0) then
      call fail(error, DECK_ERROR, 'LOOP has no NEXT', &
                program%command(loop(depth))%record%place(1), 'close it with NEXT before END')
    end if
  end subroutine match_loops

  !> Walk through the commands without solving: fields are evaluated and data records are read. A
  !! loop is repeated only if a command in it reads data.
  subroutine run_dry(run, first, error)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: first
    type(error_t), allocatable, intent(out) :: error
    integer :: top, at

    associate (program => run%program)
      program%counter = first
      do while (program%counter <= size(program%command))
        call execute_next(run, error)
        if (allocated(error)) return
        if (program%command(program%counter)%record%key(1) == 'next') then
          top = size(program%loop)
          program%loop(top)%count = program%loop(top)%count + 1
          at = program%loop(top)%at
          if (program%loop(top)%count <= program%loop(top)%limit .and. has_data(program, at)) then
            program%counter = at
          else
            program%loop = program%loop(:top - 1)
          end if
        end if
        program%counter = program%counter + 1
      end do
    end associate
  end subroutine run_dry

  !> Execute the command at the counter: evaluate its fields, find its data and run it. Before the
  !! first command of a further batch, the END of the batch before it closes the step. A step is
  !! closed before the visit is counted, because a checkpoint that is then written contains the
  !! position before this command.
  subroutine execute_next(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(command_t) :: command
    type(data_t) :: data
    integer :: at, i
    logical :: rewound

    at = run%program%counter
    command = run%program%command(at)
    if (command%begins_batch .or. run%program%row(command%row)%closes) then
      call finish_solved_step(run, rewound, error)
      if (allocated(error) .or. rewound) return
    end if
    associate (row => run%program%row(command%row))
      command%option = command%record%key(2)
      command%x = 0.0_wp
      do i = 1, merge(0, min(size(command%x), command%record%n - 2), row%reads)
        call get_real(run%deck, command%record, i + 2, command%x(i), error, 0.0_wp)
        if (allocated(error)) return
      end do
      command%visit = command%visit + 1
      if (associated(row%data)) then
        if (run%program%dry) then
          call row%data(run, command, data, error)
          if (allocated(error)) return
          command%data = [command%data, data]
          run%program%command(at)%data = command%data
        else
          command%visit = min(command%visit, size(command%data))
        end if
      end if
      run%program%command(at)%visit = command%visit
      call row%run(run, command, error)
    end associate
  end subroutine execute_next

end module command_program
