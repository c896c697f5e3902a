!> Turns the files of a deck into a stream of records; INCLude, LOOP and NEXT are executed as they
!! are read.
module deck_reader
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_file, only: file_t, inspect, FILE_ABSENT
  use base_kinds, only: wp
  use base_text, only: quoted, to_text
  use deck_expression, only: evaluate, params_t
  use deck_lexer, only: read_record
  use deck_record, only: record_t, check_count, resolve_path, RECORD_WORDS, RECORD_END
  use deck_source, only: source_line, source_list_t, find_source, add_source, joined
  implicit none
  private
  public :: reader_t, open_reader, next_record, next_unrolled, include_file, cancel_loops, &
            check_loops, source_text

  integer, parameter :: MOST_FILES = 16         !! largest depth of nested INCLude records
  integer, parameter :: MOST_LOOPS = 10         !! largest depth of nested loops
  integer, parameter :: MOST_PASSES = 1000000   !! largest number of passes of one loop
  integer, parameter :: MOST_REPEATED = 10000000 !! limit on `repeated`
  integer, parameter :: MOST_INCLUDED = 100000   !! largest number of INCLude records executed

  !> A file that is being read.
  type :: frame_t
    integer :: source = 0 !! position in the list of files
    integer :: line = 1   !! next line
  end type frame_t

  !> A loop that is being executed.
  type :: loop_t
    integer :: frame = 0, line = 0 !! where its body begins
    integer :: left = 0            !! number of passes that follow this one
    integer :: passes = 1
    integer :: nrecord = 0         !! records read in its body and NEXT; counted only up to 6
    type(place_t) :: place
  end type loop_t

  type :: reader_t
    private
    type(source_list_t) :: files !! every file of the deck that has been read
    integer :: nframe = 0, nloop = 0
    integer :: repeated = 0      !! records read in loops, plus lines of files included again
    integer :: nincluded = 0     !! INCLude records executed
    type(frame_t) :: frame(MOST_FILES)
    type(loop_t) :: loop(MOST_LOOPS)
  end type reader_t

contains

  !> Start reading the main file of the deck.
  subroutine open_reader(reader, path, error)
    type(reader_t), intent(out) :: reader
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call add_source(reader%files, path, reader%frame(1)%source, error)
    if (.not. allocated(error)) reader%nframe = 1
  end subroutine open_reader

  !> Text of all files as they were read, one after another.
  pure function source_text(reader) result(text)
    type(reader_t), intent(in) :: reader
    character(:), allocatable :: text

    text = joined(reader%files)
  end function source_text

  !> Read the next record of the current file, without executing INCLude, LOOP or NEXT.
  subroutine next_record(reader, record, error)
    type(reader_t), intent(inout) :: reader
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    do
      associate (frame => reader%frame(reader%nframe), &
                 source => reader%files%item(reader%frame(reader%nframe)%source)%file)
        if (frame%line <= source%nline) then
          call read_record(source, frame%line, record, error)
          return
        end if
        if (reader%nloop > 0) then
          if (reader%loop(reader%nloop)%frame == reader%nframe) then
            call fail(error, DECK_ERROR, 'LOOP has no NEXT', reader%loop(reader%nloop)%place, &
                      'close it with NEXT in the same file')
            reader%nloop = reader%nloop - 1
            return
          end if
        end if
        if (reader%nframe == 1) then
          record%kind = RECORD_END
          record%file = source%path
          record%line = max(source%nline, 1)
          record%raw = source_line(source, source%nline)
          record%start = [1]
          return
        end if
      end associate
      reader%nframe = reader%nframe - 1
    end do
  end subroutine next_record

  !> Read the next record other than INCLude, LOOP and NEXT, and execute those that come before it.
  subroutine next_unrolled(reader, params, record, error)
    type(reader_t), intent(inout) :: reader
    type(params_t), intent(in) :: params
    type(record_t), intent(out) :: record
    type(error_t), allocatable, intent(out) :: error

    do
      call next_record(reader, record, error)
      if (allocated(error)) exit
      if (record%kind == RECORD_END) return
      if (reader%nloop > 0) then
        associate (n => reader%loop(reader%nloop)%nrecord)
          if (record%kind == RECORD_WORDS) n = min(n, 5) + 1
        end associate
        reader%repeated = reader%repeated + 1
        if (reader%repeated > MOST_REPEATED) then
          call fail(error, DECK_ERROR, 'loops repeat more than '//to_text(MOST_REPEATED) &
                    //' records', reader%loop(1)%place, 'use fewer passes')
          call stop_reading(reader)
          exit
        end if
      end if
      if (record%kind /= RECORD_WORDS) return
      if (record%assigns()) return ! a parameter may have a name such as `incline`
      select case (record%key(1))
      case ('incl')
        call include_file(reader, record, error)
      case ('loop')
        call begin_loop(reader, params, record, error)
      case ('next')
        call end_pass(reader, record, error)
      case default
        return
      end select
      if (allocated(error)) exit
    end do
    call cancel_loops(reader)
  end subroutine next_unrolled

  !> Check that no loop is open at END.
  subroutine check_loops(reader, error)
    type(reader_t), intent(in) :: reader
    type(error_t), allocatable, intent(out) :: error

    if (reader%nloop == 0) return
    call fail(error, DECK_ERROR, 'LOOP has no NEXT before END', reader%loop(reader%nloop)%place, &
              'close it with NEXT in the same part of the deck')
  end subroutine check_loops

  !> Make the current pass of every open loop its last one, because repeating a record with an error
  !! would only repeat the message.
  subroutine cancel_loops(reader)
    type(reader_t), intent(inout) :: reader

    reader%loop(:reader%nloop)%left = 0
  end subroutine cancel_loops

  !> Go to the end of the deck after an error that would only be reported again if reading
  !! continued.
  subroutine stop_reading(reader)
    type(reader_t), intent(inout) :: reader

    reader%nloop = 0
    reader%nframe = 1
    reader%frame(1)%line = reader%files%item(1)%file%nline + 1
  end subroutine stop_reading

  !> Continue reading in the file that an INCLude record names.
  subroutine include_file(reader, record, error)
    type(reader_t), intent(inout) :: reader
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: path, chain
    type(file_t) :: file
    integer :: i, k

    call check_count(record, 2, 2, 'INCLude file', error)
    if (allocated(error)) return
    if (record%is_empty(2)) then
      call fail(error, DECK_ERROR, 'expected the name of a file', record%place(2), 'INCLude file')
      return
    end if
    path = resolve_path(record, 2)
    call inspect(path, file)
    do i = 1, reader%nframe
      if (file%kind == FILE_ABSENT) exit
      if (any(reader%files%item(reader%frame(i)%source)%file%identity /= file%identity)) cycle
      chain = ''
      do k = i + 1, reader%nframe
        chain = chain//trim(merge(' through ', ',        ', k == i + 1))//' ' &
                //quoted(reader%files%item(reader%frame(k)%source)%file%path)
      end do
      call fail(error, DECK_ERROR, quoted(path)//' includes itself'//chain, record%place(2), &
                'remove one of the INCLude records')
      return
    end do
    if (reader%nframe == MOST_FILES) then
      call fail(error, DECK_ERROR, 'INCLude is nested more than '//to_text(MOST_FILES)//' levels ' &
                //'deep', record%place(2))
      return
    end if
    i = find_source(reader%files, file)
    if (i > 0) reader%repeated = reader%repeated + reader%files%item(i)%file%nline
    if (i == 0) call add_source(reader%files, path, i, error, record%place(2))
    if (allocated(error)) return
    reader%nincluded = reader%nincluded + 1
    if (reader%nincluded > MOST_INCLUDED .or. reader%repeated > MOST_REPEATED) then
      call fail(error, DECK_ERROR, 'more than '//to_text(MOST_INCLUDED)//' files or ' &
                //to_text(MOST_REPEATED)//' lines are included', record%place(2), 'look for ' &
                //'INCLude records in included files and in loops: each repetition reads the ' &
                //'file again')
      call stop_reading(reader)
      return
    end if
    reader%nframe = reader%nframe + 1
    reader%frame(reader%nframe) = frame_t(source=i, line=1)
  end subroutine include_file

  !> Begin a loop (LOOP,n). If n is wrong, the body is read once, so that NEXT still finds its LOOP.
  subroutine begin_loop(reader, params, record, error)
    type(reader_t), intent(inout) :: reader
    type(params_t), intent(in) :: params
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(loop_t) :: loop
    real(wp) :: n

    if (reader%nloop == MOST_LOOPS) then
      call fail(error, DECK_ERROR, 'LOOP is nested more than '//to_text(MOST_LOOPS)//' levels ' &
                //'deep', record%place(1))
      return
    end if
    loop%frame = reader%nframe
    loop%line = reader%frame(reader%nframe)%line
    loop%place = record%place(1)
    reader%nloop = reader%nloop + 1
    reader%loop(reader%nloop) = loop
    call check_count(record, 2, 2, 'LOOP,n ... NEXT', error)
    if (allocated(error)) return
    call evaluate(params, record%text(2), n, record%place(2), error)
    if (allocated(error)) return
    if (anint(n) < 1.0_wp .or. n > MOST_PASSES .or. abs(n - anint(n)) > 4*epsilon(n)*n) then
      call fail(error, DECK_ERROR, 'expected a whole number of passes from 1 to ' &
                //to_text(MOST_PASSES)//', found '//to_text(n), record%place(2), 'LOOP,n ... NEXT')
      return
    end if
    reader%loop(reader%nloop)%left = nint(n) - 1
    reader%loop(reader%nloop)%passes = nint(n)
    n = product(real(reader%loop(:reader%nloop)%passes, wp))
    if (n > MOST_REPEATED) then
      call fail(error, DECK_ERROR, 'nested loops make '//to_text(n)//' passes, more than ' &
                //to_text(MOST_REPEATED), record%place(2), 'use fewer passes')
      call cancel_loops(reader)
    end if
  end subroutine begin_loop

  !> End a pass (NEXT): return to the body of the loop, or continue after it.
  subroutine end_pass(reader, record, error)
    type(reader_t), intent(inout) :: reader
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    logical :: paired

    paired = reader%nloop > 0
    if (paired) paired = reader%loop(reader%nloop)%frame == reader%nframe
    if (.not. paired) then
      call fail(error, DECK_ERROR, 'NEXT has no LOOP', record%place(1), &
                'remove it, or put LOOP,n before it in the same file')
      return
    end if
    call check_count(record, 1, 2, 'NEXT', error)
    associate (loop => reader%loop(reader%nloop))
      if (loop%nrecord <= 1 .and. .not. allocated(error)) then
        call fail(error, DECK_ERROR, 'the loop is empty', loop%place, &
                  'put records between LOOP and NEXT, or remove both')
      end if
      if (loop%left > 0 .and. .not. allocated(error)) then
        loop%left = loop%left - 1
        loop%nrecord = 2
        reader%frame(reader%nframe)%line = loop%line
      else
        reader%nloop = reader%nloop - 1
      end if
    end associate
  end subroutine end_pass

end module deck_reader
