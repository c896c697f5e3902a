!> Warnings about commands that are probably not intended; they are issued when the whole deck has
!! been read.
module command_doubts
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use command_type, only: run_t
  use inertia, only: count_scaled
  use mesh, only: is_rigid
  use program_position, only: begins_step, spans_step
  use table_use, only: warn_tables
  implicit none
  private
  public :: warn_commands, warn_kept_multipliers

  character(4), parameter :: GIVES(3) = ['tang', 'utan', 'solv'] !! commands that solve
  character(4), parameter :: SOLVES(4) = ['tang', 'utan', 'solv', 'form']

contains

  !> Warn about load tables without loads, about commands that come after all commands that they
  !! could affect, and about commands that have no effect without other commands.
  subroutine warn_commands(run)
    type(run_t), intent(in) :: run

    call warn_tables(run)
    call warn_late(run)
    call warn_multipliers(run)
    call warn_late_output(run)
    call warn_length(run)
    if (first(run, 'tran') == 0) then
      if (.not. may_add_inertia(run)) then
        call warn_idle(run, 'mass', 'MASS has no effect without TRANsient', &
                       'add TRANsient to compute with inertia, or remove MASS')
      end if
    else if (first(run, 'time') == 0) then
      call warn_idle(run, 'tran', 'TRANsient has no effect without TIME: the single step at t = ' &
                     //'0 has no inertia', 'add DT,,dt and a loop with TIME to the commands')
    else
      call warn_scaled(run)
    end if
  end subroutine warn_commands

  !> May the continuation add inertia to a step that fails? It may with AUTO if ARCLength does not
  !! exclude it or, in a deck without ARCLength, if there are bonds.
  pure logical function may_add_inertia(run) result(yes)
    type(run_t), intent(in) :: run
    integer :: i

    yes = .false.
    if (first(run, 'auto') == 0) return
    yes = first(run, 'arcl') == 0 .and. any(run%model%contact%cohesive%given)
    associate (list => run%program%command)
      do i = 1, size(list)
        yes = yes .or. list(i)%record%key(1) == 'arcl' .and. list(i)%record%key(2) /= 'off '
      end do
    end associate
  end function may_add_inertia

  !> Warn of ARCLength,LENGth without PROP, because its unknown is the time of the load tables.
  subroutine warn_length(run)
    type(run_t), intent(in) :: run
    integer :: i

    if (first(run, 'prop') > 0) return
    do i = 1, size(run%program%command)
      associate (record => run%program%command(i)%record)
        if (record%key(1) /= 'arcl' .or. record%key(2) /= 'leng') cycle
        call warn('ARCLength,LENGth has no effect without PROP, because it varies the time of ' &
                  //'load tables', record%place(1), 'write PROP,,1 before the steps, and its ' &
                  //'table after END')
        return
      end associate
    end do
  end subroutine warn_length

  !> Warn of elements with which a uniform acceleration causes stress if masses are lumped.
  subroutine warn_scaled(run)
    type(run_t), intent(in) :: run
    integer :: b, i, n

    do i = 1, size(run%program%command)
      associate (command => run%program%command(i))
        if (command%record%key(1) /= 'mass' .or. command%record%key(2) /= 'lump') cycle
        do b = 1, size(run%model%mesh%block)
          associate (block => run%model%mesh%block(b))
            if (is_rigid(block)) cycle
            if (.not. run%model%material(block%material)%density > 0.0_wp) cycle
            n = count_scaled(block, run%model%mesh%xr)
            if (n == 0) cycle
            call warn('the masses of '//to_text(n)//' of '//to_text(block%nelem)//' elements ' &
                      //trim(block%name)//' are a scaled diagonal, because row sums of their ' &
                      //'mass matrices are not positive: a uniform acceleration causes stress in ' &
                      //'them', command%record%place(1), 'use MASS,CONSistent')
          end associate
        end do
        return
      end associate
    end do
  end subroutine warn_scaled

  !> Warn of steps without AUGMent after steps with it, because multipliers change only in AUGMent.
  subroutine warn_multipliers(run)
    type(run_t), intent(in) :: run
    integer :: i

    if (first(run, 'augm') == 0) return
    associate (list => run%program%command)
      do i = first(run, 'augm'), size(list)
        if (.not. lacks_augment(run, i)) cycle
        call warn('the steps of this '//opening(run, i)//' have no ' &
                  //'AUGMent, but steps before them have: their multipliers stay as they are, so ' &
                  //'that contact forces act across gaps that open', list(i)%record%place(1), &
                  'put AUGMent into these steps, too, as in LOOP,augment,n of the steps before')
        return
      end do
    end associate
  end subroutine warn_multipliers

  !> The word that begins a step: that of the command, or BATCh if the command is only the first one
  !! of a further batch.
  pure function opening(run, i) result(word)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(:), allocatable :: word

    associate (command => run%program%command(i))
      associate (row => run%program%row(command%row))
        word = trim(row%word)
        if (command%record%key(1) /= 'time' .and. .not. row%closes) word = 'BATCh'
      end associate
    end associate
  end function opening

  !> Warn of steps without AUGMent, or of a deck without it, after the RESTart of a run with it. If
  !! AUGMent comes before these steps, warn_multipliers has warned.
  subroutine warn_kept_multipliers(run, restart)
    type(run_t), intent(in) :: run
    integer, intent(in) :: restart       !! position of RESTart
    integer :: i

    associate (list => run%program%command)
      do i = restart, size(list)
        if (list(i)%record%key(1) == 'augm') return
        if (lacks_augment(run, i)) exit
      end do
      if (i > size(list) .and. .not. has_any(run, restart, size(list), GIVES)) return
      call warn('the checkpoint contains multipliers of AUGMent, but steps after this RESTart ' &
                //'have no AUGMent: their multipliers stay as they are, so that contact forces ' &
                //'act across gaps that open', list(restart)%record%place(1), &
                'put AUGMent into these steps, too, as in LOOP,augment,n of the first run')
    end associate
  end subroutine warn_kept_multipliers

  !> Does command i begin steps with solves, but without AUGMent?
  pure logical function lacks_augment(run, i) result(yes)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    integer :: from, to

    yes = begins_step(run%program, i)
    if (.not. yes) return
    call find_step(run, i, from, to)
    yes = has_any(run, from, to, GIVES) .and. .not. has_any(run, from, to, ['augm'])
  end function lacks_augment

  !> The commands of the steps that the command at a position begins: those from it to the next
  !! command that begins a step, and in a loop the whole loop if no other one is in it.
  pure subroutine find_step(run, at, from, to)
    type(run_t), intent(in) :: run
    integer, intent(in) :: at
    integer, intent(out) :: from, to
    integer :: i

    associate (list => run%program%command)
      from = at
      do to = at, size(list) - 1
        if (begins_step(run%program, to + 1)) exit
      end do
      do i = at - 1, 1, -1
        if (list(i)%record%key(1) /= 'loop' .or. list(i)%matching < at) cycle
        if (list(i)%matching > to) return
        from = i
        to = list(i)%matching
        return
      end do
    end associate
  end subroutine find_step

  !> Does the program contain one of the given commands between two positions?
  pure logical function has_any(run, from, to, key)
    type(run_t), intent(in) :: run
    integer, intent(in) :: from, to
    character(4), intent(in) :: key(:)
    integer :: i

    has_any = any([(any(key == run%program%command(i)%record%key(1)), i=from, to)])
  end function has_any

  !> Warn about commands that prepare steps or solves if all of these come before them.
  subroutine warn_late(run)
    type(run_t), intent(in) :: run
    integer :: i

    do i = 1, size(run%program%command)
      select case (run%program%command(i)%record%key(1))
      case ('tol ', 'fact')
        if (is_late(run, i, SOLVES)) call warn_here(run, i, 'TANG or UTAN')
      case ('arcl', 'auto', 'tplo')
        if (.not. is_late(run, i, [SOLVES, 'time'])) cycle
        associate (record => run%program%command(i)%record)
          if (record%key(1) == 'tplo' .and. record%is_empty(3)) cycle ! it has no interval
        end associate
        call warn_here(run, i, 'TIME, TANG or UTAN')
      case ('dt  ', 'tran', 'mass')
        if (is_late(run, i, ['time'])) call warn_here(run, i, 'TIME')
      case default
        cycle
      end select
    end do
  end subroutine warn_late

  !> Warn if the first OUTPut comes after all steps: of several steps, only the last one is then
  !! written, when it closes. The only step of a deck may come before it. If a PLOT follows, OUTPut
  !! may be there to choose its fields.
  subroutine warn_late_output(run)
    type(run_t), intent(in) :: run
    integer :: i

    i = first(run, 'outp')
    if (i == 0) return
    if (.not. is_late(run, i, [SOLVES, 'time']) .or. .not. has_steps(run, i)) return
    if (has_any(run, i, size(run%program%command), ['plot'])) return
    call warn_here(run, i, 'TIME, TANG or UTAN', 'put it before the steps that it is to write; ' &
                   //'PLOT writes the last step alone')
  end subroutine warn_late_output

  subroutine warn_here(run, i, needed, hint)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(*), intent(in) :: needed
    character(*), intent(in), optional :: hint
    character(:), allocatable :: advice

    advice = 'put it before the commands that it is to affect'
    if (present(hint)) advice = hint
    associate (command => run%program%command(i))
      call warn(trim(run%program%row(command%row)%word)//' comes too late: no '//needed &
                //' follows it', command%record%place(1), advice)
    end associate
  end subroutine warn_here

  !> Does more than one step begin before command i, which no loop contains? A command other than
  !! TIME ends a step only if that was solved, and a solve begins one if there is none.
  pure logical function has_steps(run, i)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    integer :: j, n
    logical :: begun, solved             !! the current step has begun, and has a solve

    n = 0
    begun = .false.
    solved = .false.
    associate (list => run%program%command)
      do j = 1, i - 1
        associate (key => list(j)%record%key(1))
          if (key == 'time' .or. (solved .and. begins_step(run%program, j))) begun = .false.
          if (key == 'loop' .and. list(j)%passes > 1) then
            if (spans_step(run%program, j) .and. &
                has_any(run, j, list(j)%matching, [SOLVES, 'time'])) n = n + 2
          end if
          if (.not. begun .and. any([SOLVES, 'time'] == key)) then
            n = n + 1
            begun = .true.
            solved = .false.
          end if
          solved = solved .or. any(SOLVES == key)
        end associate
      end do
    end associate
    has_steps = n > 1
  end function has_steps

  !> Do commands with the given names run, but only before command i? Those that are before it in a
  !! loop that contains it also run after it, in the next pass.
  pure logical function is_late(run, i, key) result(late)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(4), intent(in) :: key(:)
    integer :: j, start

    associate (list => run%program%command)
      start = i
      do j = 1, i - 1
        if (list(j)%record%key(1) == 'loop' .and. list(j)%matching > i) exit
      end do
      if (j < i) start = j
      late = .not. any([(any(key == list(j)%record%key(1)), j=start, size(list))]) .and. &
             any([(any(key == list(j)%record%key(1)), j=1, start)])
    end associate
  end function is_late

  !> Warn at the first command with a given name, if there is one.
  subroutine warn_idle(run, key, message, hint)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key
    character(*), intent(in) :: message, hint
    integer :: i

    i = first(run, key)
    if (i > 0) call warn(message, run%program%command(i)%record%place(1), hint)
  end subroutine warn_idle

  !> Position of the first command with a given name; 0: there is none.
  pure integer function first(run, key) result(i)
    type(run_t), intent(in) :: run
    character(4), intent(in) :: key

    do i = 1, size(run%program%command)
      if (run%program%command(i)%record%key(1) == key) return
    end do
    i = 0
  end function first

end module command_doubts
