!> PROP: load tables; PARAmeter: parameters in the solution part of the deck.
module command_load
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_sort, only: unique
  use base_text, only: to_text
  use command_type, only: run_t, program_t, command_t, command_row_t, new_row, data_t, &
                          assignment_t, whole_field, check_fields
  use continuation, only: follow_slopes
  use deck_expression, only: set_parameter
  use deck_record, only: record_t, check_count, RECORD_COMMENT, RECORD_WORDS
  use deck_stream, only: deck_t, get_integer, get_real, get_assignment
  use load_curve, only: load_table_t
  use solution_state, only: set_factors, factor_slopes
  use step, only: begin_again
  use table_use, only: note_definition, warn_jump
  implicit none
  private
  public :: load_rows, name_end_of_table

  integer, parameter :: MOST_TABLES = 1000

contains

  function load_rows() result(row)
    type(command_row_t) :: row(2)

    row(1) = new_row('PROP', 'PROP,,k1[,k2]; its tables, one per number, come after END', 3, &
                     run_prop, read_tables)
    row(1)%closes = .true.
    row(2) = new_row('PARAmeter', 'PARAmeter; its records name = value come after END', 0, &
                     run_para, read_assignments)
  end function load_rows

  !> Find the numbers of the first and the last table that a PROP defines.
  subroutine table_range(command, first, last, error)
    type(command_t), intent(in) :: command
    integer, intent(out) :: first, last
    type(error_t), allocatable, intent(out) :: error

    call check_fields(command, 2, 'PROP,,k1[,k2]', error, option=.false.)
    call whole_field(command, 1, first, error)
    call whole_field(command, 2, last, error)
    if (allocated(error)) return
    if (last > 0 .and. last < first) then
      call fail(error, DECK_ERROR, 'the last table number '//to_text(last)//' is less than the ' &
                //'first one, '//to_text(first), command%record%place(4), 'write PROP,,k1,k2 ' &
                //'with k1 <= k2')
      return
    end if
    first = max(1, first)
    last = max(first, last)
    if (any(command%x(:2) < 0.0_wp) .or. last > MOST_TABLES) then
      call fail(error, DECK_ERROR, 'expected table numbers from 1 to '//to_text(MOST_TABLES), &
                command%record%place(3), 'write PROP,,k')
    end if
  end subroutine table_range

  !> Read tables: a blank record alone, `1 e tmin tmax a1 a2 a3 a4 a5`, or `2 n` and its pairs.
  subroutine read_tables(run, command, data, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(data_t), intent(out) :: data
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(place_t) :: place
    character(:), allocatable :: end_of_table
    real(wp) :: kind
    integer :: i, j, first, last

    call table_range(command, first, last, error)
    if (allocated(error)) return
    allocate (data%table(last - first + 1))
    do i = 1, size(data%table)
      call run%deck%next_of_set(record, error)
      if (allocated(error)) return
      if (record%kind /= RECORD_WORDS) then
        if (.not. record%is_end()) cycle
      end if
      if (is_past_data(record)) then
        call fail(error, DECK_ERROR, 'the data of this PROP are missing', command%record%place(1), &
                  'give a table after the END of BATCh, or a blank record for p = t')
        return
      end if
      associate (table => data%table(i))
        call get_real(run%deck, record, 1, kind, error)
        if (allocated(error)) then
          if (any(record%key(1) == ['disp', 'reac'])) then
            error%message = "expected a table of PROP, found the record '"//record%text(1) &
                            //"' of TPLOt"
            error%hint = 'the data after END follow in the order in which the commands run: ' &
                         //'tables of a PROP that runs before TPLOt come first'
          end if
          return
        end if
        table%kind = findloc(abs([1.0_wp, 2.0_wp] - kind) <= 8*epsilon(kind), .true., 1)
        select case (table%kind)
        case (1)
          call check_count(record, 1, 9, '1 e tmin tmax a1 a2 a3 a4 a5', error)
          if (.not. allocated(error)) call get_integer(run%deck, record, 2, table%power, error, 0)
          if (.not. allocated(error)) call get_real(run%deck, record, 3, table%tmin, error, 0.0_wp)
          if (.not. allocated(error)) call get_real(run%deck, record, 4, table%tmax, error, 0.0_wp)
          do j = 1, 5
            if (allocated(error)) return
            call get_real(run%deck, record, 4 + j, table%a(j), error, 0.0_wp)
          end do
          if (.not. allocated(error) .and. table%tmax <= table%tmin) then
            call fail(error, DECK_ERROR, 'expected tmax greater than tmin = ' &
                      //to_text(table%tmin)//', found '//to_text(table%tmax), record%place(4), &
                      '1 e tmin tmax a1 a2 a3 a4 a5')
          end if
        case (2)
          call check_count(record, 1, 2, '''2 n'', then records of n pairs t p each, and a ' &
                           //'blank record', error)
          if (.not. allocated(error)) call read_pairs(run, record, table, end_of_table, error)
        case default
          call fail(error, DECK_ERROR, "unknown type '"//record%text(1)//"' of load table", &
                    record%place(1), 'known types: 1 (formula) and 2 (pairs)')
        end select
      end associate
      if (allocated(error)) then
        place = record%place(1)
        if (error%place%line == place%line) call name_end_of_table(run%program, error)
        return
      end if
      call move_alloc(end_of_table, run%program%end_of_table)
    end do
    run%program%ntable = max(run%program%ntable, last)
    if (.not. allocated(run%program%prop_at)) then
      allocate (run%program%prop_at(MOST_TABLES), source=0)
    end if
    where (run%program%prop_at(first:last) == 0) run%program%prop_at(first:last) = &
      run%program%counter
    run%program%defined = unique([run%program%defined, [(i, i=first, last)]])
  end subroutine read_tables

  !> Add to the hint of an error in a record what ended the load table before it, because the record
  !! may have been meant as a part of this table.
  pure subroutine name_end_of_table(program, error)
    type(program_t), intent(in) :: program
    type(error_t), intent(inout) :: error

    if (.not. allocated(program%end_of_table)) return
    if (allocated(error%hint)) then
      error%hint = error%hint//'; '//program%end_of_table
    else
      error%hint = program%end_of_table
    end if
  end subroutine name_end_of_table

  !> Does the record come after all data of a batch? If so, it is the end of the deck or a word such
  !! as STOP.
  pure logical function is_past_data(record)
    type(record_t), intent(in) :: record

    is_past_data = record%is_end()
    if (record%kind == RECORD_WORDS .and. record%n == 1) then
      is_past_data = any(record%key(1) == ['stop', 'batc', 'inte', 'end '])
    end if
  end function is_past_data

  !> Read the data of a load table of type 2: after `2 n`, records of n pairs (t, p) up to a blank
  !! record. A pair 0 0 that is not the first pair, or a record with fewer than n pairs, ends the
  !! table; the blank record after it may be missing (FEAP).
  subroutine read_pairs(run, opening, table, end_of_table, error)
    type(run_t), intent(inout) :: run
    type(record_t), intent(in) :: opening
    type(load_table_t), intent(inout) :: table
    character(:), allocatable, intent(out) :: end_of_table !! see program_t
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(place_t) :: place
    character(:), allocatable :: reason
    integer :: n
    logical :: done

    call get_integer(run%deck, opening, 2, n, error, 1)
    if (allocated(error)) return
    allocate (table%t(0), table%p(0))
    done = .false.
    do
      call run%deck%next_of_set(record, error)
      if (allocated(error)) return
      if (record%kind == RECORD_COMMENT) then
        end_of_table = 'the comment line '//to_text(record%line)//' ended the load table before ' &
                       //'this record (FEAP); put comments behind the pairs of a record'
      end if
      if (record%kind /= RECORD_WORDS) exit
      if (done) then
        call run%deck%put_back(record)
        end_of_table = reason//' ended the load table before this record (FEAP); end each table ' &
                       //'of pairs with a blank record'
        exit
      end if
      call check_count(record, 2, 2*max(n, 1), 'pairs t p, at most '//to_text(max(n, 1)) &
                       //' in each record of this table', error)
      if (.not. allocated(error)) call take_pairs(run%deck, record, table, done, error)
      if (allocated(error)) return
      place = record%place(1)
      if (done) then
        reason = 'the pair 0 0 in line '//to_text(place%line)//', which is not the first pair,'
      else
        reason = 'the record with fewer than '//to_text(n)//' pairs in line '//to_text(place%line)
      end if
      done = done .or. record%n < 2*n
    end do
    if (size(table%t) == 0) then
      call fail(error, DECK_ERROR, 'the load table has no pairs', opening%place(1), &
                'after the record ''2 n'' give records of n pairs t p each, and a blank record')
    end if
  end subroutine read_pairs

  !> Read the pairs of one record.
  subroutine take_pairs(deck, record, table, done, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    type(load_table_t), intent(inout) :: table
    logical, intent(out) :: done !! a pair 0 0 followed others
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: t, p
    integer :: i

    done = .false.
    if (mod(record%n, 2) /= 0) then
      call fail(error, DECK_ERROR, 'the last time of this record has no factor', &
                record%place(record%n), 'write pairs t p')
      return
    end if
    do i = 1, record%n, 2
      call get_real(deck, record, i, t, error)
      if (.not. allocated(error)) call get_real(deck, record, i + 1, p, error)
      if (allocated(error)) return
      if (size(table%t) > 0) then
        done = .not. (abs(t) + abs(p) > 0.0_wp)
        if (done .and. size(table%t) == 1 .and. table%t(1) > 0.0_wp) then
          call fail(error, DECK_ERROR, 'the pair 0 0 comes after time '//to_text(table%t(1)), &
                    record%place(i), 'list the pairs in the order of increasing time; a pair 0 0 ' &
                    //'that is not the first one ends the table (FEAP), so that the factor of ' &
                    //'this table would be constant')
        end if
        if (done .and. table%t(size(table%t)) < 0.0_wp) then
          call fail(error, DECK_ERROR, 'the pair 0 0 would end the table after time ' &
                    //to_text(table%t(size(table%t)))//' (FEAP)', record%place(i), 'if a factor ' &
                    //'of 0 at time 0 is meant, write a time such as 1e-12; otherwise end the ' &
                    //'table with a blank record')
          return
        end if
        if (done) then
          if (.not. allocated(error)) call check_rest(deck, record, i + 2, error)
          return
        end if
        if (t <= table%t(size(table%t))) then
          call fail(error, DECK_ERROR, 'the times of a load table must increase, found ' &
                    //to_text(t)//' after '//to_text(table%t(size(table%t))), record%place(i))
          return
        end if
      end if
      table%t = [table%t, t]
      table%p = [table%p, p]
    end do
  end subroutine take_pairs

  !> Check that only zeros follow the pair 0 0 that ends a table in its record.
  subroutine check_rest(deck, record, first, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: first !! the first field after the pair
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: t, p
    integer :: i

    do i = first, record%n, 2
      call get_real(deck, record, i, t, error)
      if (.not. allocated(error)) call get_real(deck, record, i + 1, p, error)
      if (allocated(error)) return
      if (.not. abs(t) + abs(p) > 0.0_wp) cycle
      call fail(error, DECK_ERROR, 'the pair 0 0 ended the load table before this pair', &
                record%place(i), 'list the pairs in the order of increasing time; a pair 0 0 ' &
                //'that is not the first one ends the table (FEAP)')
      return
    end do
  end subroutine check_rest

  subroutine run_prop(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(load_table_t), allocatable :: longer(:)
    real(wp), allocatable :: slopes(:)
    integer :: first, last, n

    call table_range(command, first, last, error)
    if (allocated(error) .or. run%program%dry) return
    associate (table => command%data(command%visit)%table)
      do n = first, last
        call warn_jump(run, n, table(n - first + 1), command%record%place(1))
      end do
    end associate
    slopes = factor_slopes(run%state, ahead=.true.)
    n = size(run%state%table)
    if (last > n) then
      allocate (longer(last))
      longer(:n) = run%state%table
      longer(n + 1:)%kind = 1                     ! without data, the factor of a table is 0
      call move_alloc(longer, run%state%table)
    end if
    run%state%table(first:last) = command%data(command%visit)%table
    call note_definition(run, first, last)
    call follow_slopes(run%step, run%state, slopes)
    if (run%step%open) then
      call begin_again(run%step, run%model, run%state)
    else
      call set_factors(run%state)
    end if
  end subroutine run_prop

  !> Read records `name = expression` up to a blank one.
  subroutine read_assignments(run, command, data, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(data_t), intent(out) :: data
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    type(assignment_t) :: new
    character(:), allocatable :: name
    real(wp) :: value

    allocate (data%assignment(0))
    if (allocated(run%program%end_of_table)) deallocate (run%program%end_of_table)
    do
      call run%deck%next_of_set(record, error)
      if (allocated(error)) return
      if (is_past_data(record) .and. size(data%assignment) == 0) then
        call fail(error, DECK_ERROR, 'the data of this PARAmeter are missing', &
                  command%record%place(1), &
                  'give records name = value after the END of BATCh, and a blank record')
      end if
      if (allocated(error)) return
      if (record%kind /= RECORD_WORDS) exit
      call get_assignment(run%deck, record, name, value, error)
      if (allocated(error)) return
      new%name = name
      new%value = value
      data%assignment = [data%assignment, new]
    end do
  end subroutine read_assignments

  subroutine run_para(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (run%program%dry) return
    associate (data => command%data(command%visit))
      do i = 1, size(data%assignment)
        call set_parameter(run%deck%params, data%assignment(i)%name, data%assignment(i)%value)
      end do
    end associate
  end subroutine run_para

end module command_load
