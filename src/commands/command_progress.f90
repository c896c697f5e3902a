!> A line an iteration: in the log, and on a terminal the one that the next overwrites.
module command_progress
  use base_kinds, only: wp
  use base_log, only: log_line, progress
  use base_system, only: wall_seconds
  use base_text, only: to_text
  use command_type, only: run_t
  implicit none
  private
  public :: show_iteration

contains

  subroutine show_iteration(run)
    type(run_t), intent(in) :: run
    character(160) :: line

    write (line, '(a,i6,a,es12.5,a,i3,3(a,es10.3))') 'step', run%state%step, '  time', &
      run%state%time, '  iteration', run%newton%iterations, '  residual', run%pass%residual, &
      '  energy', run%pass%energy, '  ratio', run%pass%ratio
    if (run%pass%solve%iterations > 1) then
      line = trim(line)//'  krylov '//to_text(run%pass%solve%iterations)
    end if
    if (run%pass%line < 1.0_wp) line = trim(line)//'  line '//to_text(run%pass%line)
    call log_line(trim(line))
    write (line, '(a,i0,a,f0.4,a,i0,a,es8.1,a)') 'step ', run%state%step, '  load ', load(run), &
      '  iteration ', run%newton%iterations, '  residual ', run%pass%residual, time_left(run)
    call progress(trim(line))
  end subroutine show_iteration

  !> The sum of the load tables; the time where there are none.
  pure function load(run)
    type(run_t), intent(in) :: run
    real(wp) :: load

    load = run%state%time
    if (size(run%state%factor) > 0) load = sum(run%state%factor)
  end function load

  !> Wall time that the loops over time still need, if they go on as they went.
  function time_left(run) result(text)
    type(run_t), intent(in) :: run
    character(:), allocatable :: text
    real(wp) :: done
    integer :: i, seconds

    text = ''
    done = 0.0_wp
    do i = 1, size(run%loop)
      if (.not. run%command(run%loop(i)%at)%holds_time) cycle
      done = real(run%loop(i)%count - 1, wp)/run%loop(i)%limit
    end do
    if (done <= 0.0_wp) return
    seconds = nint(min(wall_seconds()*(1.0_wp - done)/done, 1.0e9_wp))
    text = '  left '//to_text(seconds)//' s'
    if (seconds > 600) text = '  left '//to_text(seconds/60)//' min'
  end function time_left

end module command_progress
