!> Named timers of the parts of a run.
module base_timer
  use base_kinds, only: wp
  use base_system, only: wall_seconds, cpu_seconds
  implicit none
  private
  public :: timers_t, new_timers

  integer, parameter :: MOST = 32

  type :: one_t
    character(24) :: name = ''
    integer :: calls = 0
    real(wp) :: wall = 0.0_wp, cpu = 0.0_wp           !! accumulated time [s]
    real(wp) :: wall_start = 0.0_wp, cpu_start = 0.0_wp
    logical :: running = .false.
  end type one_t

  type :: timers_t
    private
    integer :: n = 0
    type(one_t) :: timer(MOST)
    real(wp) :: born = 0.0_wp
  contains
    procedure :: start
    procedure :: stop => stop_one
    procedure :: add
    procedure :: seconds
    procedure :: cpu => cpu_of
    procedure :: names
    procedure :: table
  end type timers_t

contains

  !> Remove all timers and begin to measure the total time.
  subroutine new_timers(timers)
    type(timers_t), intent(out) :: timers

    timers%born = wall_seconds()
  end subroutine new_timers

  !> Start a timer; a new name creates a new timer.
  subroutine start(timers, name)
    class(timers_t), intent(inout) :: timers
    character(*), intent(in) :: name
    integer :: i

    i = place_of(timers, name)
    if (i == 0) then
      if (timers%n == MOST) return
      timers%n = timers%n + 1
      i = timers%n
      timers%timer(i)%name = name
    end if
    timers%timer(i)%running = .true.
    timers%timer(i)%wall_start = wall_seconds()
    timers%timer(i)%cpu_start = cpu_seconds()
  end subroutine start

  !> Stop a timer, and add the time since its last start to its total.
  subroutine stop_one(timers, name)
    class(timers_t), intent(inout) :: timers
    character(*), intent(in) :: name
    integer :: i

    i = place_of(timers, name)
    if (i == 0) return
    associate (t => timers%timer(i))
      if (.not. t%running) return
      t%running = .false.
      t%calls = t%calls + 1
      t%wall = t%wall + wall_seconds() - t%wall_start
      t%cpu = t%cpu + cpu_seconds() - t%cpu_start
    end associate
  end subroutine stop_one

  !> Add wall and processor seconds that were measured elsewhere.
  subroutine add(timers, name, seconds)
    class(timers_t), intent(inout) :: timers
    character(*), intent(in) :: name
    real(wp), intent(in) :: seconds(2)
    integer :: i

    call timers%start(name)
    call timers%stop(name)
    i = place_of(timers, name)
    if (i == 0) return
    timers%timer(i)%wall = timers%timer(i)%wall + seconds(1)
    timers%timer(i)%cpu = timers%timer(i)%cpu + seconds(2)
  end subroutine add

  !> Wall time of a timer [s]; that of 'total' is the time since new_timers was called.
  function seconds(timers, name) result(wall)
    class(timers_t), intent(in) :: timers
    character(*), intent(in) :: name
    real(wp) :: wall
    integer :: i

    wall = 0.0_wp
    i = place_of(timers, name)
    if (i > 0) then
      wall = timers%timer(i)%wall
    else if (name == 'total') then
      wall = wall_seconds() - timers%born
    end if
  end function seconds

  !> Processor time of a timer [s]; that of 'total' is the time of all threads of
  !! the process.
  function cpu_of(timers, name) result(cpu)
    class(timers_t), intent(in) :: timers
    character(*), intent(in) :: name
    real(wp) :: cpu
    integer :: i

    cpu = 0.0_wp
    i = place_of(timers, name)
    if (i > 0) then
      cpu = timers%timer(i)%cpu
    else if (name == 'total') then
      cpu = cpu_seconds()
    end if
  end function cpu_of

  !> Names of the timers, in the order of their first start.
  pure function names(timers) result(list)
    class(timers_t), intent(in) :: timers
    character(24), allocatable :: list(:)

    list = timers%timer(:timers%n)%name
  end function names

  !> A table with one line for each timer (calls, wall and processor seconds, and share of the total
  !! wall time) and a last line with the total times.
  function table(timers) result(text)
    class(timers_t), intent(in) :: timers
    character(:), allocatable :: text
    character(80) :: line
    real(wp) :: total
    integer :: i

    total = timers%seconds('total')
    text = 'part                        calls      wall [s]       cpu [s]   share'
    do i = 1, timers%n
      associate (t => timers%timer(i))
        write (line, '(a24, i9, 2f14.3, f7.1, " %")') t%name, t%calls, t%wall, t%cpu, &
          100*t%wall/max(total, tiny(total))
      end associate
      text = text//new_line('a')//trim(line)
    end do
    write (line, '(a24, 9x, 2f14.3)') 'total', total, cpu_seconds()
    text = text//new_line('a')//trim(line)
  end function table

  pure function place_of(timers, name) result(i)
    class(timers_t), intent(in) :: timers
    character(*), intent(in) :: name
    integer :: i

    do i = timers%n, 1, -1
      if (timers%timer(i)%name == name) return
    end do
  end function place_of

end module base_timer
