!> The position in the commands: the open loops, the position at which a step began, and the return
!! to this position.
module program_position
  use base_error, only: place_t
  use command_type, only: program_t
  use deck_expression, only: params_t
  implicit none
  private
  public :: save_position, rewind_program, leave_loop, iterates, has_data, targets_left, &
            may_pass_targets, is_last_pass, current_place, begins_step, spans_step

contains

  !> Save the position: a step begins with the command at the counter.
  subroutine save_position(program, params, prints)
    type(program_t), intent(inout) :: program
    type(params_t), intent(in) :: params !! parameters of the deck
    logical, intent(in) :: prints        !! printed tables are on

    associate (position => program%step_start)
      position%counter = program%counter
      position%loop = program%loop
      position%visit = program%command(:)%visit
      position%params = params
      position%prints = prints
    end associate
  end subroutine save_position

  !> Go back to the position at which the step began: the counter is that of the command that began
  !! it.
  subroutine rewind_program(program, params, prints)
    type(program_t), intent(inout) :: program
    type(params_t), intent(inout) :: params
    logical, intent(inout) :: prints

    associate (position => program%step_start)
      program%counter = position%counter
      program%loop = position%loop
      program%command(:)%visit = position%visit
      params = position%params
      prints = position%prints
    end associate
  end subroutine rewind_program

  !> Leave the innermost loop (as in FEAP) if it iterates.
  subroutine leave_loop(program)
    type(program_t), intent(inout) :: program
    integer :: top

    top = size(program%loop)
    if (top == 0) return
    if (.not. iterates(program, program%loop(top)%at)) return
    program%counter = program%command(program%loop(top)%at)%matching
    program%loop = program%loop(:top - 1)
  end subroutine leave_loop

  !> Does the command at a position begin a step? TIME does, and so does a command before which a
  !! step that was solved is closed.
  pure logical function begins_step(program, at) result(yes)
    type(program_t), intent(in) :: program
    integer, intent(in) :: at

    associate (command => program%command(at))
      yes = command%record%key(1) == 'time' .or. command%begins_batch .or. &
            program%row(command%row)%closes
    end associate
  end function begins_step

  !> Does the LOOP at a position contain a command that begins a step?
  pure logical function spans_step(program, at) result(yes)
    type(program_t), intent(in) :: program
    integer, intent(in) :: at
    integer :: i

    yes = any([(begins_step(program, i), i=at + 1, program%command(at)%matching)])
  end function spans_step

  !> Do the passes of the LOOP at a position iterate, so that it ends when a step has converged?
  !! They do not if the loop contains TIME or a command with data, such as PROP, because each pass
  !! then has its own step or its own data.
  pure logical function iterates(program, at) result(yes)
    type(program_t), intent(in) :: program
    integer, intent(in) :: at

    yes = .not. (program%command(at)%spans_time .or. has_data(program, at))
  end function iterates

  !> Does the LOOP at a position contain a command with data?
  pure logical function has_data(program, at)
    type(program_t), intent(in) :: program
    integer, intent(in) :: at
    integer :: i

    has_data = any([(associated(program%row(program%command(i)%row)%data), &
                     i=at, program%command(at)%matching)])
  end function has_data

  !> Number of time targets that remain in the innermost loop, including the target of the next
  !! TIME. It is 1 if the loop contains several TIMEs, so that no step passes the target of another
  !! TIME, and if its passes have data of their own, so that each pass has its step.
  pure integer function targets_left(program) result(left)
    type(program_t), intent(in) :: program
    integer :: top

    left = 1
    top = size(program%loop)
    if (top == 0) return
    associate (loop => program%loop(top))
      if (may_pass_targets(program, loop%at)) left = loop%limit - loop%count + 1
    end associate
  end function targets_left

  !> May a step pass several targets of the LOOP at a position? The loop must contain exactly one
  !! TIME, which is outside its inner loops, and no command with data, such as PROP, because each
  !! pass takes its own.
  pure logical function may_pass_targets(program, at) result(yes)
    type(program_t), intent(in) :: program
    integer, intent(in) :: at
    integer :: i

    associate (command => program%command)
      yes = command(at)%holds_time
      if (yes) yes = count([(command(i)%record%key(1) == 'time', &
                             i=at, command(at)%matching)]) == 1
      if (yes) yes = .not. has_data(program, at)
    end associate
  end function may_pass_targets

  !> Is the innermost loop in its last pass, and does it iterate?
  pure logical function is_last_pass(program) result(yes)
    type(program_t), intent(in) :: program
    integer :: top

    top = size(program%loop)
    yes = top > 0
    if (yes) yes = program%loop(top)%count == program%loop(top)%limit &
                   .and. iterates(program, program%loop(top)%at)
  end function is_last_pass

  !> Place in the deck of the command at the counter, or of the last command if all have been
  !! executed. It is unknown if there are no commands.
  function current_place(program) result(place)
    type(program_t), intent(in) :: program
    type(place_t) :: place

    if (size(program%command) == 0) return
    associate (command => program%command(min(program%counter, size(program%command))))
      place = command%record%place(1)
    end associate
  end function current_place

end module program_position
