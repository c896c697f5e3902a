!> Reads the solution part of a deck: BATCh ... END and the data records behind it.
!!
!! Everything is read and checked before anything is solved or written: the commands run once dry,
!! and those with data read their records then, in the order in which they will run.
module command_program
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR, error_list_t
  use base_text, only: nearest
  use command_table, only: load_commands
  use command_type, only: run_t, command_t, command_row_t, loop_t, data_t
  use deck_expression, only: params_t
  use deck_record, only: record_t, RECORD_WORDS, RECORD_END
  use deck_stream, only: check_count, get_real
  use step_control, only: step_control_t
  implicit none
  private
  public :: read_program, refresh

contains

  !> All batches of the deck, one program.
  subroutine read_program(run, errors, error)
    type(run_t), intent(inout) :: run
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(params_t) :: params
    type(step_control_t) :: control

    call load_commands(run%row)
    allocate (run%command(0), run%loop(0))
    allocate (run%noted(size(run%row)), source=.false.)
    params = run%deck%params
    control = run%control
    run%dry = .true.
    do
      call run%deck%next(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_END) exit
      if (record%kind /= RECORD_WORDS) cycle
      if (record%key(1) == 'stop') exit
      if (record%key(1) /= 'batc') then
        call fail(error, DECK_ERROR, "unexpected '"//record%text(1)//"'", record%place(1), &
                  'after the mesh come BATCh ... END, the data of its commands and STOP')
        if (scan(record%text(1)//' ', '0123456789.+-') == 1) then
          error%hint = 'no command is left that reads it; a blank record is the table p = t ' &
                       //'where a PROP reads one'
        end if
        return
      end if
      call read_batch(run, record, errors, error)
      if (allocated(error)) return
    end do
    run%dry = .false.
    run%deck%params = params
    run%control = control
    run%command(:)%visit = 0
    run%pc = 1
    run%loop = run%loop(:0)
  end subroutine read_program

  !> One batch: its commands up to END, then their data.
  subroutine read_batch(run, opening, errors, error)
    type(run_t), intent(inout) :: run
    type(record_t), intent(in) :: opening
    type(error_list_t), intent(inout) :: errors
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(error_t), allocatable :: found
    type(command_t), allocatable :: list(:)
    integer :: first, n

    first = size(run%command) + 1
    n = size(run%command)
    call move_alloc(run%command, list)
    do
      call run%deck%next_command(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_END) then
        call fail(error, DECK_ERROR, 'BATCh has no END', opening%place(1), &
                  'close the commands with END')
        return
      end if
      if (record%key(1) == 'end') exit
      if (record%key(1) == 'incl') then
        call run%deck%include(record, error)
        if (allocated(error)) return
        cycle
      end if
      call add_command(run%row, record, list, n, found)
      if (allocated(found)) call errors%add(found)
    end do
    run%command = list(:n)
    if (errors%count() > 0) return
    call match_loops(run, first, error)
    if (allocated(error)) return
    call run_dry(run, first, error)
  end subroutine read_batch

  !> Put one command behind the first n of a list that is longer.
  subroutine add_command(row, record, list, n, error)
    type(command_row_t), intent(in) :: row(:)
    type(record_t), intent(in) :: record
    type(command_t), allocatable, intent(inout) :: list(:)
    integer, intent(inout) :: n
    type(error_t), allocatable, intent(out) :: error
    type(command_t), allocatable :: longer(:)
    type(command_t) :: command
    integer :: i

    command%row = 0
    do i = 1, size(row)
      if (row(i)%key == record%key(1)) command%row = i
    end do
    if (command%row == 0) then
      call fail(error, DECK_ERROR, "unknown command '"//record%text(1)//"'", record%place(1), &
                'nearest known: '//nearest(record%text(1), row(:)%word))
      return
    end if
    call check_count(record, 1, row(command%row)%nmax + 1, trim(row(command%row)%usage), error)
    if (allocated(error)) return
    command%record = record
    allocate (command%data(0))
    if (n == size(list)) then
      allocate (longer(2*n + 32))
      longer(:n) = list
      call move_alloc(longer, list)
    end if
    n = n + 1
    list(n) = command
  end subroutine add_command

  !> Pair LOOP and NEXT.
  subroutine match_loops(run, first, error)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: first
    type(error_t), allocatable, intent(out) :: error
    integer :: loop(64), depth, i

    depth = 0
    do i = first, size(run%command)
      select case (run%command(i)%record%key(1))
      case ('loop')
        if (depth == size(loop)) then
          call fail(error, DECK_ERROR, 'loops are nested deeper than 64', &
                    run%command(i)%record%place(1))
          return
        end if
        depth = depth + 1
        loop(depth) = i
      case ('next')
        if (depth == 0) then
          call fail(error, DECK_ERROR, 'NEXT without LOOP', run%command(i)%record%place(1), &
                    'remove it, or put LOOP,name,n before')
        else
          call check_next(run%command(loop(depth))%record, run%command(i)%record, &
                          loop(depth) == i - 1, error)
        end if
        if (allocated(error)) return
        run%command(i)%matching = loop(depth)
        run%command(loop(depth))%matching = i
        depth = depth - 1
      case ('time')
        if (depth > 0) run%command(loop(depth))%holds_time = .true.
      case ('tang', 'utan', 'solv')
        if (depth > 0) run%command(loop(depth))%solves = .true.
      case default
        cycle
      end select
    end do
    if (depth > 0) then
      call fail(error, DECK_ERROR, 'LOOP has no NEXT', run%command(loop(depth))%record%place(1), &
                'close it with NEXT before END')
    end if
  end subroutine match_loops

  !> Does this NEXT belong to that LOOP?
  subroutine check_next(loop, next, is_empty, error)
    type(record_t), intent(in) :: loop, next
    logical, intent(in) :: is_empty !! nothing stands between them
    type(error_t), allocatable, intent(out) :: error

    if (is_empty) then
      call fail(error, DECK_ERROR, 'this loop does nothing', loop%place(1), &
                'put commands between LOOP and NEXT, or remove both')
    else if (next%n > 1 .and. loop%n > 1) then
      if (next%key(2) /= loop%key(2)) then
        call fail(error, DECK_ERROR, "NEXT closes '"//loop%text(2)//"', not '"//next%text(2)//"'", &
                  next%place(2), 'loops are closed inside out')
      end if
    end if
  end subroutine check_next

  !> Walk through the commands without solving: fields are evaluated and data records read. A loop
  !! is repeated only where a command in it reads data.
  subroutine run_dry(run, first, error)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: first
    type(error_t), allocatable, intent(out) :: error
    type(command_t) :: command
    integer :: top

    run%pc = first
    do while (run%pc <= size(run%command))
      call refresh(run, error)
      if (allocated(error)) return
      command = run%command(run%pc)
      call run%row(command%row)%run(run, command, error)
      if (allocated(error)) return
      if (command%record%key(1) == 'next') then
        top = size(run%loop)
        run%loop(top)%count = run%loop(top)%count + 1
        if (run%loop(top)%count <= run%loop(top)%limit .and. has_data(run, run%loop(top)%at)) then
          run%pc = run%loop(top)%at
        else
          run%loop = run%loop(:top - 1)
        end if
      end if
      run%pc = run%pc + 1
    end do
  end subroutine run_dry

  !> A loop in which some command reads data.
  pure function has_data(run, at) result(yes)
    type(run_t), intent(in) :: run
    integer, intent(in) :: at
    logical :: yes
    integer :: i

    yes = .false.
    do i = at, run%command(at)%matching
      yes = yes .or. associated(run%row(run%command(i)%row)%data)
    end do
  end function has_data

  !> The command at the counter with its fields as they are now, and its data: read when dry.
  subroutine refresh(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(data_t) :: data
    integer :: i

    associate (command => run%command(run%pc))
      command%option = command%record%key(2)
      command%x = 0.0_wp
      do i = 1, merge(0, min(size(command%x), command%record%n - 2), run%row(command%row)%reads)
        call get_real(run%deck, command%record, i + 2, command%x(i), error, 0.0_wp)
        if (allocated(error)) return
      end do
      command%visit = command%visit + 1
      if (.not. associated(run%row(command%row)%data)) return
      if (.not. run%dry) then
        command%visit = min(command%visit, size(command%data))
        return
      end if
    end associate
    call run%row(run%command(run%pc)%row)%data(run, run%command(run%pc), data, error)
    if (allocated(error)) return
    run%command(run%pc)%data = [run%command(run%pc)%data, data]
  end subroutine refresh

end module command_program
