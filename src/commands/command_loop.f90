!> LOOP and NEXT.
module command_loop
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use command_step, only: take_outcome, finish_step
  use command_type, only: run_t, command_t, command_row_t, loop_t, new_row
  use program_position, only: has_data, may_pass_targets
  use step, only: cut_step, test_again, STEP_REWOUND
  use step_control, only: on_target
  implicit none
  private
  public :: loop_rows

  integer, parameter :: MOST_PASSES = 1000000000

contains

  function loop_rows() result(row)
    type(command_row_t) :: row(2)

    row(1) = new_row('LOOP', 'LOOP,name,n', 2, run_loop)
    row(2) = new_row('NEXT', 'NEXT,name', 1, run_next)
  end function loop_rows

  subroutine run_loop(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    associate (program => run%program, n => command%x(1))
      if (anint(n) < 1 .or. n > MOST_PASSES .or. abs(n - anint(n)) > 4*epsilon(n)*n) then
        call fail(error, DECK_ERROR, 'expected a whole number of passes from 1 to ' &
                  //to_text(MOST_PASSES)//', found '//to_text(n), command%record%place(3), &
                  'write LOOP,name,n')
        return
      end if
      program%command(program%counter)%passes = nint(n)
      program%loop = [program%loop, loop_t(at=program%counter, count=1, limit=nint(n))]
    end associate
  end subroutine run_loop

  !> End a pass of a loop. With automatic step sizes, a loop over time counts targets instead of
  !! steps: the pass goes on at its last TIME if the step ended before its target, and as many
  !! passes are counted as there are targets if it passed several. A step with automatic size is cut
  !! back if its Newton loop ends without convergence, which the last solve may have reached.
  subroutine run_next(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: top, passes
    logical :: rewound

    if (run%program%dry) return
    associate (opening => run%program%command(command%matching), step => run%step)
      if (opening%holds_time .and. step%control%automatic .and. step%solved) then
        if (.not. on_target(step%control)) then
          call finish_step(run, rewound, error)
          if (allocated(error) .or. rewound) return
        end if
      end if
    end associate
    associate (program => run%program, opening => run%program%command(command%matching), &
               control => run%step%control)
      top = size(program%loop)
      passes = 1
      if (control%automatic .and. may_pass_targets(program, command%matching)) then
        passes = max(1, control%passed)
      end if
      program%loop(top)%count = program%loop(top)%count + passes
      if (program%loop(top)%count <= program%loop(top)%limit) then
        program%counter = program%loop(top)%at
        return
      end if
      program%loop = program%loop(:top - 1)
      ! The last pass of a loop over time or data ends like the others: closing the step tests it.
      if (.not. (control%automatic .and. opening%solves) .or. opening%holds_time) return
      if (has_data(program, command%matching)) return
    end associate
    if (.not. run%step%solved .or. run%step%newton%converged) return
    call test_again(run%step, run%model, run%state, error)
    if (allocated(error) .or. run%step%newton%converged) return
    call cut_step(run%step, run%model, run%state, 'no convergence after ' &
                  //to_text(run%step%newton%iterations)//' iterations', &
                  command%record%place(1), error)
    if (.not. allocated(error)) call take_outcome(run, STEP_REWOUND, error)
  end subroutine run_next

end module command_loop
