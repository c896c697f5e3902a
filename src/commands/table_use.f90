!> Which loads and motions follow which load table, and warnings if a table probably does not act as
!! intended.
module table_use
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: note, warn
  use base_text, only: to_text
  use boundary, only: boundary_t, place_of_number
  use command_type, only: run_t
  use load_curve, only: load_factor, load_table_t, table_factor, next_extremum
  implicit none
  private
  public :: use_t, find_uses, warn_tables, watch_tables, warn_jump, note_definition, &
            watch_tables_end, warn_continued

  !> The first load or motion, nonzero if there is such a one, that follows a table.
  type :: use_t
    integer :: table = 0               !! 0: the sum of all tables
    character(:), allocatable :: what  !! name for messages, such as MOVE or 'a load'
    logical :: acts = .false.          !! some load or motion of this table is not zero
    type(place_t) :: place             !! in the deck; `file` is not allocated if it is unknown
  end type use_t

contains

  !> List the tables in use, each once.
  subroutine find_uses(bc, uses)
    type(boundary_t), intent(in) :: bc
    type(use_t), allocatable, intent(out) :: uses(:)
    type(place_t) :: place
    integer :: i, d, n

    allocate (uses(0))
    do i = 1, size(bc%motion)
      associate (m => bc%motion(i))
        call add(m%table, 'MOVE', m%place, m%rotates .or. any(abs(m%vector) > 0.0_wp))
      end associate
    end do
    do i = 1, size(bc%pressure)
      associate (p => bc%pressure(i))
        call add(p%table, 'PRESsure', p%place, abs(p%value) > 0.0_wp)
      end associate
    end do
    do i = 1, size(bc%dead)
      if (size(bc%dead(i)%node) > 0) call add(bc%dead(i)%table, 'a load', bc%dead(i)%place, .true.)
    end do
    do n = 1, size(bc%table, 2)
      do d = 1, 3
        if (.not. (abs(bc%force(d, n)) > 0.0_wp .or. &
                   (abs(bc%value(d, n)) > 0.0_wp .and. bc%fixed(d, n) /= 0))) cycle
        if (any(uses%table == bc%table(d, n) .and. uses%acts)) cycle
        call place_of_number(bc, bc%table(d, n), place)
        call add(bc%table(d, n), 'a nodal load or displacement', place, .true.)
      end do
    end do

  contains

    subroutine add(table, what, where, acts)
      integer, intent(in) :: table
      character(*), intent(in) :: what
      type(place_t), intent(in) :: where
      logical, intent(in) :: acts
      type(use_t) :: new
      integer :: u

      do u = 1, size(uses)
        if (uses(u)%table /= table) cycle
        if (uses(u)%acts .or. .not. acts) return
        uses(u)%acts = .true.
        uses(u)%place = where
        uses(u)%what = what
        return
      end do
      new%table = table
      new%what = what
      new%place = where
      new%acts = acts
      uses = [uses, new]
    end subroutine add
  end subroutine find_uses

  !> When the whole deck has been read, warn about loads with a table number if there is no PROP at
  !! all, and about a PROP after the first solve. Only log a note about tables that no load follows,
  !! because decks that are run in stages may contain some.
  subroutine warn_tables(run)
    type(run_t), intent(in) :: run
    type(use_t), allocatable :: uses(:)
    integer :: solve, i, k, u

    call find_uses(run%model%bc, uses)
    associate (program => run%program)
      if (size(program%defined) == 0) then
        do u = 1, size(uses)
          if (uses(u)%table == 0 .or. .not. uses(u)%acts) cycle
          call warn('load table '//to_text(uses(u)%table)//' is not defined: the deck has no ' &
                    //'PROP, so its factor is 1', uses(u)%place, 'add PROP,,' &
                    //to_text(uses(u)%table)//' to the commands and its data after END')
          return
        end do
        return
      end if
      do solve = 1, size(program%command)
        if (any(program%command(solve)%record%key(1) == ['tang', 'utan', 'solv'])) exit
      end do
      do i = 1, size(program%defined)
        k = program%defined(i)
        associate (record => program%command(program%prop_at(k))%record)
          if (all(uses%table /= k .and. uses%table /= 0)) then
            call note('no load follows load table '//to_text(k)//', which PROP in line ' &
                      //to_text(record%line)//' defines')
          else if (program%prop_at(k) > solve) then
            call warn('PROP defines load table '//to_text(k)//' after the first solve, so ' &
                      //'earlier steps do not follow it', record%place(1), 'put PROP before the ' &
                      //'first TIME, TANG or UTAN')
          end if
        end associate
      end do
    end associate
  end subroutine warn_tables

  !> Warn if a PROP, after steps have been closed, replaces a table by one with another factor at
  !! the present time: the loads then jump in the next step. Warn too if it replaces another table
  !! that has not acted, because nothing was solved since its PROP.
  subroutine warn_jump(run, k, new, place)
    type(run_t), intent(in) :: run
    integer, intent(in) :: k               !! number of the table
    type(load_table_t), intent(in) :: new
    type(place_t), intent(in) :: place     !! place of the PROP in the deck
    type(use_t), allocatable :: uses(:)
    real(wp) :: before, after
    character(5) :: next

    if (k > size(run%state%table)) return
    associate (old => run%state%table(k))
      if (old%kind == 1 .and. .not. old%tmax > old%tmin) return ! no PROP has defined it
      if (has_not_acted(run, k)) then
        if (.not. equal(old, new)) then
          next = merge('first', 'next ', run%state%step == 0)
          call warn('PROP defines load table '//to_text(k)//' again before the '//trim(next) &
                    //' step, so the previous table never acts', place, &
                    'give one of them another number: PROP,,k')
        end if
        return
      end if
      before = table_factor(old, run%state%time)
    end associate
    after = table_factor(new, run%state%time)
    if (abs(after - before) <= 1.0e-9_wp*max(abs(after), abs(before))) return
    call find_uses(run%model%bc, uses)
    if (all(uses%table /= k .and. uses%table /= 0)) return
    call warn('PROP redefines load table '//to_text(k)//' at time '//to_text(run%state%time) &
              //': its factor changes from '//to_text(before)//' to '//to_text(after), place, &
              'let the new table begin with the current factor, or use one table for all steps')
  end subroutine warn_jump

  !> Warn, after the first step that follows RESTart, if the loads have jumped in it because the
  !! tables of this deck do not continue those of the checkpoint. The plan still has the time at
  !! which this step began.
  subroutine warn_continued(run, before)
    type(run_t), intent(in) :: run
    real(wp), intent(in) :: before(:)      !! factors of the tables of the checkpoint
    type(use_t), allocatable :: uses(:)
    real(wp) :: now(size(run%state%table)), old, new
    type(place_t) :: place
    character(:), allocatable :: name
    integer :: i, u

    associate (time => run%plan%closed_at, table => run%state%table)
      now = [(table_factor(table(i), time), i=1, size(table))]
      call find_uses(run%model%bc, uses)
      do u = 1, size(uses)
        if (.not. uses(u)%acts .or. uses(u)%table > max(1, size(before))) cycle
        old = load_factor(before, uses(u)%table)
        new = load_factor(now, uses(u)%table)
        if (abs(new - old) <= 1.0e-9_wp*max(abs(new), abs(old))) cycle
        name = 'the factor of load table '//to_text(uses(u)%table)
        if (uses(u)%table == 0) name = 'the sum of the factors of all load tables'
        if (size(table) == 0) name = 'the load factor without PROP'
        do i = 1, size(run%program%command)
          associate (record => run%program%command(i)%record)
            if (record%key(1) == 'rest') place = record%place(1)
          end associate
        end do
        call warn('the loads jump in the first step after RESTart: at time '//to_text(time)//', ' &
                  //name//' is '//to_text(new)//', but was '//to_text(old)//' in the checkpoint', &
                  place, 'a checkpoint contains no load tables: give PROP with a table that ' &
                  //'continues at this time')
        return
      end do
    end associate
  end subroutine warn_continued

  !> Note that PROP defines tables now.
  subroutine note_definition(run, first, last)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: first, last  !! their numbers
    integer, allocatable :: longer(:, :)
    integer :: n

    if (.not. allocated(run%plan%defined_at)) allocate (run%plan%defined_at(2, 0))
    n = size(run%plan%defined_at, 2)
    if (last > n) then
      allocate (longer(2, last), source=-1)
      longer(:, :n) = run%plan%defined_at
      call move_alloc(longer, run%plan%defined_at)
    end if
    run%plan%defined_at(:, first:last) = spread(moment(run), 2, last - first + 1)
  end subroutine note_definition

  !> Has nothing been solved since PROP defined this table?
  logical function has_not_acted(run, k)
    type(run_t), intent(in) :: run
    integer, intent(in) :: k

    has_not_acted = .false.
    if (.not. allocated(run%plan%defined_at)) return
    if (k > size(run%plan%defined_at, 2)) return
    has_not_acted = all(run%plan%defined_at(:, k) == moment(run))
  end function has_not_acted

  !> The closed steps and the iterations so far.
  pure function moment(run)
    type(run_t), intent(in) :: run
    integer :: moment(2)

    moment = [run%state%step, run%step%total%iterations]
  end function moment

  !> Have two tables the same data?
  pure logical function equal(a, b)
    type(load_table_t), intent(in) :: a, b

    equal = a%kind == b%kind .and. a%power == b%power .and. abs(a%tmin - b%tmin) <= 0.0_wp .and. &
            abs(a%tmax - b%tmax) <= 0.0_wp .and. all(abs(a%a - b%a) <= 0.0_wp) .and. &
            (allocated(a%t) .eqv. allocated(b%t))
    if (equal .and. allocated(a%t)) equal = size(a%t) == size(b%t)
    if (equal .and. allocated(a%t)) then
      equal = all(abs(a%t - b%t) <= 0.0_wp) .and. all(abs(a%p - b%p) <= 0.0_wp)
    end if
  end function equal

  !> After a step, warn about formulas whose range has ended, once for each table, and about a peak
  !! or trough of a table that the steps miss, once in a run.
  subroutine watch_tables(run)
    type(run_t), intent(inout) :: run
    type(use_t), allocatable :: uses(:)
    logical, allocatable :: acted(:), more(:)
    integer :: u, k

    associate (state => run%state, plan => run%plan)
      if (size(state%table) == 0) return
      if (.not. allocated(plan%acted)) then
        allocate (plan%acted(0:size(state%table)), plan%ended(size(state%table)), source=.false.)
      else if (size(plan%ended) < size(state%table)) then
        more = spread(.false., 1, size(state%table) - size(plan%ended))
        call move_alloc(plan%acted, acted)
        allocate (plan%acted(0:size(state%table)), source=[acted, more])
        plan%ended = [plan%ended, more]
      end if
      call find_uses(run%model%bc, uses)
      do u = 1, size(uses)
        if (.not. uses(u)%acts .or. uses(u)%table > size(state%table)) cycle
        associate (factor => load_factor(state%factor, uses(u)%table))
          plan%acted(uses(u)%table) = plan%acted(uses(u)%table) .or. abs(factor) > 0.0_wp
          do k = 1, size(state%table)
            if (uses(u)%table /= 0 .and. uses(u)%table /= k) cycle
            call watch_corners(run, k, uses(u)%table == 0)
            call watch_extremum(run, k)
            if (uses(u)%table == 0) call watch_shared_end(run, k)
            if (plan%ended(k) .or. abs(factor) > 0.0_wp .or. state%dynamics%on) cycle
            if (uses(u)%table == 0 .and. is_followed(state%table, k)) cycle
            plan%ended(k) = has_ended(state%table(k), state%time)
            if (plan%ended(k)) call warn('load table '//to_text(k)//' ends at time ' &
                                         //to_text(state%table(k)%tmax)//', so its factor is 0 ' &
                                         //'in step '//to_text(state%step)//', which ends at ' &
                                         //'time '//to_text(state%time), uses(u)%place, 'a table ' &
                                         //'of type 1 is 0 before tmin and after tmax: set tmax ' &
                                         //'to the end of the run, or use type 2')
          end do
        end associate
      end do
    end associate
  end subroutine watch_tables

  !> Does another table of the sum act after the range of table k?
  pure logical function is_followed(table, k)
    type(load_table_t), intent(in) :: table(:)
    integer, intent(in) :: k
    integer :: j

    is_followed = any([(j /= k .and. (table(j)%kind /= 1 .or. table(j)%tmax > table(k)%tmax), &
                        j=1, size(table))])
  end function is_followed

  !> Warn if a step ends where the range of table k ends and that of another formula begins: both
  !! ends belong to the ranges, so both factors count in the sum.
  subroutine watch_shared_end(run, k)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: k
    real(wp) :: gap
    integer :: j

    associate (state => run%state, table => run%state%table)
      if (run%plan%corner_warned .or. table(k)%kind /= 1) return
      gap = 8*epsilon(gap)*max(abs(state%time), abs(table(k)%tmin), abs(table(k)%tmax))
      if (abs(state%time - table(k)%tmax) > gap) return
      do j = 1, size(table)
        if (j == k .or. table(j)%kind /= 1 .or. abs(table(j)%tmin - state%time) > gap) cycle
        if (.not. abs(state%factor(j)*state%factor(k)) > 0.0_wp) cycle
        run%plan%corner_warned = .true.
        call warn('at time '//to_text(state%time)//' load table '//to_text(k)//' ends and load ' &
                  //'table '//to_text(j)//' begins, and both factors count in the sum of the ' &
                  //'tables: '//to_text(state%factor(k))//' and '//to_text(state%factor(j)), &
                  run%program%command(run%program%prop_at(j))%record%place(1), 'let the first ' &
                  //'table end 1e-7 of DT before this time, or use one table of type 2')
        return
      end do
    end associate
  end subroutine watch_shared_end

  !> Is the time beyond the range of a formula that does not go to zero at its end?
  pure logical function has_ended(table, time) result(ended)
    type(load_table_t), intent(in) :: table
    real(wp), intent(in) :: time

    ended = .false.
    if (table%kind /= 1 .or. .not. table%tmax > table%tmin) return
    if (abs(table_factor(table, time)) > 0.0_wp .or. time <= table%tmax) return
    ended = abs(table_factor(table, table%tmax)) > 1.0e-9_wp*largest_factor(table)
  end function has_ended

  !> Largest factor of a formula at eleven times in its range.
  pure real(wp) function largest_factor(table) result(largest)
    type(load_table_t), intent(in) :: table
    integer :: i

    largest = maxval([(abs(table_factor(table, table%tmin &
                                        + 0.1_wp*i*(table%tmax - table%tmin))), i=0, 10)])
  end function largest_factor

  !> Warn about a peak or a trough at a corner of a table (a pair, or an end of the range of a
  !! formula) that lies inside the step, or in the time since the previous step if a TIME was not
  !! followed by a solve. In a sum of tables, that of all factors counts at the ends of a range,
  !! where another formula may follow. Automatic steps end at corners, but a TIME without a solve
  !! may have ended at one.
  subroutine watch_corners(run, k, in_sum)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: k
    logical, intent(in) :: in_sum        !! a load follows the sum of all tables
    real(wp), allocatable :: t(:), p(:)
    real(wp) :: start, until, gap, ends(2), range
    integer :: i

    associate (state => run%state, table => run%state%table(k))
      if (run%plan%corner_warned .or. .not. state%dt > 0.0_wp) return
      if (table%kind == 2) then
        t = table%t
        p = table%p
      else if (table%kind == 1 .and. table%tmax > table%tmin) then
        t = [table%tmin, table%tmax]
        p = [level(table%tmin, .true.), level(table%tmax, .false.)]
      else
        return
      end if
      start = state%time - state%dt
      gap = 1.0e-6_wp*state%dt
      until = state%time - gap
      if (run%step%control%automatic) until = start + gap
      start = min(start, run%plan%closed_at)
      ends = [table_factor(table, start), table_factor(table, state%time)]
      if (in_sum .and. table%kind == 1) then
        ends(1) = sum([(table_factor(state%table(i), start), i=1, size(state%table))])
        ends(2) = sum([(table_factor(state%table(i), state%time), i=1, size(state%table))])
      end if
      do i = 1, size(t)
        if (t(i) <= start + gap .or. t(i) >= until) cycle
        range = 1.0e-6_wp*max(maxval(abs(ends)), abs(p(i)))
        if (p(i) <= maxval(ends) + range .and. p(i) >= minval(ends) - range) cycle
        run%plan%corner_warned = .true.
        call warn_missed(run, k, p(i), t(i), 'choose DT such that a step ends there, or use ' &
                         //'AUTO, whose steps end at corners')
        return
      end do
    end associate

  contains

    !> Factor at an end of the range of the table; in a sum, without formulas that only meet it
    !! there.
    real(wp) function level(time, begins)
      real(wp), intent(in) :: time
      logical, intent(in) :: begins
      integer :: j

      level = table_factor(run%state%table(k), time)
      if (.not. in_sum) return
      do j = 1, size(run%state%table)
        associate (other => run%state%table(j))
          if (j == k) cycle
          if (other%kind == 1 .and. abs(merge(other%tmax, other%tmin, begins) - time) &
              <= 8*epsilon(time)*abs(time)) cycle
          level = level + table_factor(other, time)
        end associate
      end do
    end function level

  end subroutine watch_corners

  !> Warn about an extremum of the sine of a formula that lies inside the step, or in the time since
  !! the previous step if a TIME was not followed by a solve, and is missed by more than a tenth of
  !! the amplitude. The second extremum in this time may be missed by more than the first one.
  subroutine watch_extremum(run, k)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: k
    real(wp), parameter :: MISSED = 0.1_wp
    real(wp) :: ends(2), peak, start, time
    integer :: i

    associate (state => run%state, table => run%state%table(k))
      if (run%plan%corner_warned .or. .not. state%dt > 0.0_wp) return
      start = min(state%time - state%dt, run%plan%closed_at)
      ends = [table_factor(table, start), table_factor(table, state%time)]
      time = start
      do i = 1, 2
        time = next_extremum(table, time)
        if (.not. time < state%time) return
        peak = table_factor(table, time)
        if (max(peak - maxval(ends), minval(ends) - peak) > MISSED*abs(table%a(3))) exit
      end do
      if (i > 2) return
      run%plan%corner_warned = .true.
      call warn_missed(run, k, peak, time, 'choose DT so small that a period of the sine has at ' &
                       //'least ten steps')
    end associate
  end subroutine watch_extremum

  !> Warn that no step ends where a table has a peak or a trough.
  subroutine warn_missed(run, k, factor, time, otherwise)
    type(run_t), intent(in) :: run
    integer, intent(in) :: k             !! number of the table
    real(wp), intent(in) :: factor       !! at the peak
    real(wp), intent(in) :: time         !! of the peak [T]
    character(*), intent(in) :: otherwise !! hint if no TIME without a solve skips the peak
    character(:), allocatable :: text, hint

    associate (state => run%state)
      text = 'load table '//to_text(k)//' reaches '//to_text(factor)//' at time '//to_text(time)
      if (time < state%time - state%dt + 1.0e-6_wp*state%dt) then
        text = text//', which a TIME without a solve skips'
        hint = 'solve after each TIME'
      else
        text = text//', inside step '//to_text(state%step)//', which ends at time ' &
               //to_text(state%time)
        hint = otherwise
      end if
    end associate
    call warn(text//'; this value is never applied', &
              run%program%command(run%program%prop_at(k))%record%place(1), hint)
  end subroutine warn_missed

  !> At the end of a run, warn about loads whose factor was zero in all steps.
  subroutine watch_tables_end(run)
    type(run_t), intent(in) :: run
    type(use_t), allocatable :: uses(:)
    character(:), allocatable :: name
    integer :: u

    if (.not. allocated(run%plan%acted)) return
    call find_uses(run%model%bc, uses)
    do u = 1, size(uses)
      if (.not. uses(u)%acts .or. uses(u)%table > size(run%plan%ended)) cycle
      if (run%plan%acted(uses(u)%table)) cycle
      name = 'load table '//to_text(uses(u)%table)//' is'
      if (uses(u)%table == 0) name = 'all load tables are'
      call warn(name//' 0 at the end of every step, so '//uses(u)%what//' never acts', &
                uses(u)%place, 'let steps end at times at which the table is not 0: see DT, TIME ' &
                //'and the data of PROP')
    end do
  end subroutine watch_tables_end

end module table_use
