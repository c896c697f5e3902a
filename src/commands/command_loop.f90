!> LOOP and NEXT, and where a failed step goes back to.
module command_loop
  use base_kinds, only: wp
  use base_error, only: error_t, fail, NO_SOLUTION, DECK_ERROR
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use command_type, only: run_t, command_t, command_row_t, new_row, loop_t
  use newton_judge, only: turns_back
  use path_switch, only: another_way
  use solution_state, only: restore_step
  use step_control, only: cut_step, on_target
  implicit none
  private
  public :: describe_loop, describe_next, leave_loop, mark_step, rewind_step, cut_back

  integer, parameter :: MOST_PASSES = 1000000000

contains

  function describe_loop() result(row)
    type(command_row_t) :: row

    row = new_row('LOOP', 'LOOP,name,n', 2, run_loop)
  end function describe_loop

  function describe_next() result(row)
    type(command_row_t) :: row

    row = new_row('NEXT', 'NEXT,name', 1, run_next)
  end function describe_next

  subroutine run_loop(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(loop_t) :: loop

    if (command%x(1) < 1.0_wp .or. command%x(1) > MOST_PASSES .or. &
        abs(command%x(1) - anint(command%x(1))) > 0.0_wp) then
      call fail(error, DECK_ERROR, &
                'a loop runs a whole number of times, from 1 to 1000000000, not ' &
                //to_text(command%x(1)), command%record%place(3), 'write LOOP,name,n')
      return
    end if
    loop = loop_t(at=run%pc, count=1, limit=nint(command%x(1)))
    run%loop = [run%loop, loop]
  end subroutine run_loop

  !> End of a pass. Where the step under way stopped short of its target, the pass is run once more;
  !! where it passed several, so many passes are done.
  subroutine run_next(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: top, passes

    if (run%dry) return
    top = size(run%loop)
    passes = 1
    if (run%command(command%matching)%holds_time .and. run%control%automatic) then
      passes = max(1, run%control%passed)
      if (.not. on_target(run%control)) passes = 0
    end if
    run%loop(top)%count = run%loop(top)%count + passes
    if (run%loop(top)%count <= run%loop(top)%limit) then
      run%pc = run%loop(top)%at
    else
      run%loop = run%loop(:top - 1)
      if (run%control%automatic .and. run%command(command%matching)%solves .and. run%plan%solved &
          .and. .not. run%newton%converged) then
        call cut_back(run, 'no convergence after '//to_text(run%newton%iterations)//' iterations', &
                      error)
      end if
    end if
  end subroutine run_next

  !> The test has passed: out of the iteration loop (FEAP), but never out of a loop over time.
  subroutine leave_loop(run)
    type(run_t), intent(inout) :: run
    integer :: top

    top = size(run%loop)
    if (top == 0) return
    if (run%command(run%loop(top)%at)%holds_time) return
    run%pc = run%command(run%loop(top)%at)%matching
    run%loop = run%loop(:top - 1)
  end subroutine leave_loop

  !> A step failed: restore all of it and go back to its TIME with a smaller one; an error where
  !! that cannot be.
  subroutine cut_back(run, why, error)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: why
    type(error_t), allocatable, intent(out) :: error
    integer :: step
    logical :: possible

    step = run%state%step
    possible = run%plan%timed
    if (possible .and. run%control%automatic) then
      if (another_way(run, why)) then
        call try_again(run)
        return
      end if
    end if
    if (possible) possible = cut_step(run%control)
    if (.not. possible) then
      call give_up(run, step, why, error)
      return
    end if
    run%plan%cutbacks = run%plan%cutbacks + 1
    run%cutbacks = run%cutbacks + 1
    call log_line('  step '//to_text(step)//' is cut: '//why//'; next try dt = ' &
                  //to_text(run%control%size))
    call try_again(run)
  end subroutine cut_back

  !> The TIME of the step under way is next, with everything as it was.
  subroutine try_again(run)
    type(run_t), intent(inout) :: run

    call rewind_step(run)
    run%pc = run%pc - 1
    run%plan%retry = .true.
  end subroutine try_again

  !> A step begins with the command at the counter: remember what rewind_step brings back.
  subroutine mark_step(run)
    type(run_t), intent(inout) :: run

    run%plan%at = run%pc
    run%plan%loop = run%loop
    run%plan%visit = run%command(:)%visit
    run%plan%params = run%deck%params
    run%plan%step = run%state%step
    run%plan%time = run%state%time
    run%plan%open = .true.
    run%plan%solved = .false.
  end subroutine mark_step

  !> Everything as it was when the step began; the counter is at its first command.
  subroutine rewind_step(run)
    type(run_t), intent(inout) :: run

    call restore_step(run%state, run%plan%step, run%plan%time)
    run%loop = run%plan%loop
    run%command(:)%visit = run%plan%visit
    run%deck%params = run%plan%params
    run%pc = run%plan%at
    run%plan%open = .false.
    run%plan%solved = .false.
    run%plan%plot = .false.
    run%plan%save = .false.
  end subroutine rewind_step

  subroutine give_up(run, step, why, error)
    type(run_t), intent(in) :: run
    integer, intent(in) :: step
    character(*), intent(in) :: why
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: cuts, hint

    cuts = ''
    if (run%control%cuts > 0) cuts = ' after '//to_text(run%control%cuts)//' cut-backs'
    hint = ''
    if (run%pass%worst(2) > 0) then
      hint = 'residual '//to_text(run%pass%residual)//', largest at node ' &
             //to_text(run%pass%worst(2))//', dof u'//'xyz' (run%pass%worst(1):run%pass%worst(1)) &
             //'; '
    end if
    hint = hint//'smaller steps may help: AUTO,,dtmin,dtmax'
    if (run%control%automatic) hint = hint//' with a smaller dtmin'
    if (size(run%model%contact) > 0 .and. run%control%cuts > 2) then
      hint = hint//'; or points take turns at a border or in a gap of zero, where no step is ' &
             //'small enough: CONTact with BALAnced, or NORMal ... BORDer 0.2'
    end if
    if (turns_back(run%newton)) then
      hint = 'Newton goes to and fro between two states of contact whose tangents have ' &
             //'determinants of opposite sign: the load path turns back here, and smaller steps ' &
             //'do not help; a softer penalty may'
    end if
    if (run%pass%solve%singular) then
      hint = 'support the model: FIX or MOVE for patches, BOUN EBOU CBOU for nodes'
    end if
    call fail(error, NO_SOLUTION, 'step '//to_text(step)//' failed'//cuts//': '//why, &
              run%command(run%pc)%record%place(1), hint)
  end subroutine give_up

end module command_loop
