!> Services of the operating system (glibc, Linux): exit, signals, terminal, time and memory.
module base_system
  use base_kinds, only: wp, i8
  use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_intptr_t, c_size_t, &
                                                                            c_char, c_null_char
  use, intrinsic :: iso_c_binding, only: c_funptr, c_funloc
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  implicit none
  private
  public :: finish, finish_now, stderr_is_terminal, catch_signals, release_signals, &
            keep_signals_waiting, hold_signals, let_signals_in, &
            stop_requested, stop_signal, start_clock, wall_seconds, cpu_seconds, &
            seconds_of_both, process_id, clock_text, &
            peak_memory_mb, available_memory_mb, keep_memory, return_memory, &
            set_variable, set_default

  integer(c_int), parameter :: M_TRIM_THRESHOLD = -1, M_MMAP_MAX = -4 ! mallopt
  integer(c_int), parameter :: SIGHUP = 1, SIGINT = 2, SIGUSR1 = 10, SIGUSR2 = 12, SIGPIPE = 13, &
                               SIGTERM = 15, SIGXCPU = 24, SIGXFSZ = 25
  !> The signals that request a stop, and their names.
  integer(c_int), parameter :: STOPS(6) = [SIGTERM, SIGINT, SIGUSR1, SIGUSR2, SIGHUP, SIGXCPU]
  character(7), parameter :: STOP_NAMES(6) = ['SIGTERM', 'SIGINT ', 'SIGUSR1', 'SIGUSR2', &
                                              'SIGHUP ', 'SIGXCPU']
  integer(c_int), parameter :: SIG_BLOCK = 0, SIG_UNBLOCK = 1, SIG_SETMASK = 2

  integer(c_intptr_t), parameter :: SIG_IGN = 1
  character(*), parameter, public :: CLOCK_NAME = 'BEZEL_CLOCK'
  !> Environment variable for tests: if its value is n, the n-th call of stop_requested finds a
  !! request to stop.
  character(*), parameter :: STOP_NAME = 'BEZEL_STOP'

  !> A set of signals: 1024 bits.
  type, bind(C) :: sigset_t
    integer(c_int64_t) :: bits(16)
  end type sigset_t

  ! allow(assumed-size)
  interface
    subroutine c_exit(code) bind(C, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: code
    end subroutine c_exit

    subroutine c_leave(code) bind(C, name='_exit')
      import :: c_int
      implicit none
      integer(c_int), value :: code
    end subroutine c_leave

    integer(c_int) function c_setenv(name, value, overwrite) bind(C, name='setenv')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: name(*), value(*)
      integer(c_int), value :: overwrite
    end function c_setenv

    function c_mallopt(option, value) bind(C, name='mallopt') result(done)
      import :: c_int
      implicit none
      integer(c_int), value :: option, value
      integer(c_int) :: done
    end function c_mallopt

    function c_malloc_trim(pad) bind(C, name='malloc_trim') result(done)
      import :: c_int, c_size_t
      implicit none
      integer(c_size_t), value :: pad
      integer(c_int) :: done
    end function c_malloc_trim

    function c_isatty(fd) bind(C, name='isatty') result(yes)
      import :: c_int
      implicit none
      integer(c_int), value :: fd
      integer(c_int) :: yes
    end function c_isatty

    function c_signal(number, handler) bind(C, name='signal') result(old)
      import :: c_int, c_funptr
      implicit none
      integer(c_int), value :: number
      type(c_funptr), value :: handler
      type(c_funptr) :: old
    end function c_signal

    function c_sigemptyset(set) bind(C, name='sigemptyset') result(failed)
      import :: c_int, sigset_t
      implicit none
      type(sigset_t), intent(out) :: set
      integer(c_int) :: failed
    end function c_sigemptyset

    function c_sigaddset(set, number) bind(C, name='sigaddset') result(failed)
      import :: c_int, sigset_t
      implicit none
      type(sigset_t), intent(inout) :: set
      integer(c_int), value :: number
      integer(c_int) :: failed
    end function c_sigaddset

    function c_sigprocmask(how, set, old) bind(C, name='sigprocmask') result(failed)
      import :: c_int, sigset_t
      implicit none
      integer(c_int), value :: how
      type(sigset_t), intent(in) :: set
      type(sigset_t), intent(out) :: old
      integer(c_int) :: failed
    end function c_sigprocmask

    function c_getpid() bind(C, name='getpid') result(id)
      import :: c_int
      implicit none
      integer(c_int) :: id
    end function c_getpid
  end interface

  type(sigset_t) :: before               !! the signal mask before hold_signals was called
  integer(c_int), volatile :: caught = 0 !! number of the signal that requested a stop
  integer(i8) :: origin = -huge(0_i8)    !! reading of the clock when the run began
  integer :: calls_left = huge(0)        !! calls of stop_requested before STOP_NAME requests a stop

contains

  !> End the process in the usual way.
  subroutine finish(code)
    integer, intent(in) :: code

    flush (output_unit)
    flush (error_unit)
    call c_exit(int(code, c_int))
  end subroutine finish

  !> End the process at once, without the usual clean-up of the libraries, which would wait forever
  !! for a thread of OpenBLAS that is waiting for memory.
  subroutine finish_now(code)
    integer, intent(in) :: code

    flush (error_unit)
    call c_leave(int(code, c_int))
  end subroutine finish_now

  function stderr_is_terminal() result(yes)
    logical :: yes

    yes = c_isatty(2_c_int) == 1
  end function stderr_is_terminal

  !> Let the signals of STOPS request a stop from now on; a second SIGINT ends the process. If
  !! SIGHUP is ignored, as under nohup, it stays ignored. SIGPIPE and SIGXFSZ are ignored, because
  !! the write that fails reports a closed pipe or a file that has grown too large.
  subroutine catch_signals()
    type(c_funptr) :: old
    character(24) :: text
    integer :: i, calls, io

    caught = 0
    old = c_signal(SIGPIPE, transfer(SIG_IGN, old))
    old = c_signal(SIGXFSZ, transfer(SIG_IGN, old))
    do i = 1, size(STOPS)
      old = c_signal(STOPS(i), c_funloc(note_signal))
      if (STOPS(i) /= SIGHUP .or. transfer(old, SIG_IGN) /= SIG_IGN) cycle
      old = c_signal(SIGHUP, transfer(SIG_IGN, old))
    end do
    call block_stops(SIG_UNBLOCK)
    call get_environment_variable(STOP_NAME, text, status=io)
    if (io == 0) read (text, *, iostat=io) calls
    if (io == 0) calls_left = calls
  end subroutine catch_signals

  !> Block the signals that request a stop until catch_signals is called, either by this program or
  !! by the program that replaces it in this process.
  subroutine keep_signals_waiting()
    call block_stops(SIG_BLOCK)
  end subroutine keep_signals_waiting

  !> Let signals end the process again. This is for runs that have nothing to save.
  subroutine release_signals()
    type(c_funptr) :: old
    integer :: i

    do i = 1, size(STOPS)
      old = c_signal(STOPS(i), transfer(0_c_intptr_t, old)) ! SIG_DFL
      if (transfer(old, SIG_IGN) == SIG_IGN) old = c_signal(STOPS(i), transfer(SIG_IGN, old))
    end do
  end subroutine release_signals

  subroutine block_stops(how)
    integer(c_int), intent(in) :: how
    type(sigset_t) :: set, old
    integer(c_int) :: failed
    integer :: i

    failed = c_sigemptyset(set)
    do i = 1, size(STOPS)
      failed = c_sigaddset(set, STOPS(i))
    end do
    failed = c_sigprocmask(how, set, old)
  end subroutine block_stops

  subroutine note_signal(number) bind(C)
    integer(c_int), value :: number
    type(c_funptr) :: old

    caught = number
    if (number == SIGINT) old = c_signal(SIGINT, transfer(0_c_intptr_t, old)) ! SIG_DFL
  end subroutine note_signal

  !> Block SIGTERM until let_signals_in is called, because some libraries catch it for their own
  !! purposes.
  subroutine hold_signals()
    type(sigset_t) :: set
    integer(c_int) :: failed

    failed = c_sigemptyset(set)
    failed = c_sigaddset(set, SIGTERM)
    failed = c_sigprocmask(SIG_BLOCK, set, before)
  end subroutine hold_signals

  !> Restore the signal mask as it was before hold_signals; a signal that has arrived in the
  !! meantime is delivered now.
  subroutine let_signals_in()
    type(sigset_t) :: set
    integer(c_int) :: failed

    failed = c_sigprocmask(SIG_SETMASK, before, set)
  end subroutine let_signals_in

  !> Has a signal requested a stop? This function is called before each command, and between
  !! iterations if one command makes several.
  function stop_requested() result(yes)
    logical :: yes

    calls_left = max(calls_left - 1, 0)
    if (calls_left == 0 .and. caught == 0) caught = SIGTERM
    yes = caught /= 0
  end function stop_requested

  !> Name of the signal that requested the stop; blank if there is none.
  function stop_signal() result(name)
    character(:), allocatable :: name
    integer :: i

    name = ''
    do i = 1, size(STOPS)
      if (STOPS(i) == caught) name = trim(STOP_NAMES(i))
    end do
  end function stop_signal

  !> Set the time at which the run began; without this call, it is the time at which the clock is
  !! first read. If this program has replaced another one in the same process, the run began when
  !! the other program did.
  subroutine start_clock()
    integer(i8), parameter :: LONGEST = 60 !! seconds that loading a program may take
    character(24) :: text
    integer(i8) :: earlier, rate
    integer :: io

    call system_clock(origin, rate)
    call get_environment_variable(CLOCK_NAME, text, status=io)
    if (io == 0) read (text, *, iostat=io) earlier
    if (io /= 0) return
    if (earlier <= origin .and. origin - earlier < LONGEST*rate) origin = earlier
  end subroutine start_clock

  !> The time at which the run began, in the form in which start_clock reads it from the environment
  !! variable CLOCK_NAME.
  function clock_text() result(text)
    character(:), allocatable :: text
    character(24) :: digits

    if (origin < 0) call start_clock()
    write (digits, '(i0)') origin
    text = trim(digits)
  end function clock_text

  !> Seconds since the run began.
  function wall_seconds() result(seconds)
    real(wp) :: seconds
    integer(i8) :: count, rate

    if (origin < 0) call start_clock()
    call system_clock(count, rate)
    seconds = real(count - origin, wp)/real(rate, wp)
  end function wall_seconds

  !> Wall time since the run began, and processor time of all threads [s].
  function seconds_of_both() result(seconds)
    real(wp) :: seconds(2)

    seconds = [wall_seconds(), cpu_seconds()]
  end function seconds_of_both

  !> Processor time of all threads [s].
  function cpu_seconds() result(seconds)
    real(wp) :: seconds

    call cpu_time(seconds)
  end function cpu_seconds

  !> Set an environment variable of this process; `done` becomes true if this succeeds.
  subroutine set_variable(name, value, done)
    character(*), intent(in) :: name, value
    logical, intent(inout) :: done

    if (c_setenv(name//c_null_char, value//c_null_char, 1_c_int) == 0) done = .true.
  end subroutine set_variable

  !> Set an environment variable of this process, unless the user has set it.
  subroutine set_default(name, value)
    character(*), intent(in) :: name, value
    integer(c_int) :: ignored

    ignored = c_setenv(name//c_null_char, value//c_null_char, 0_c_int)
  end subroutine set_default

  function process_id() result(id)
    integer :: id

    id = int(c_getpid())
  end function process_id

  !> Peak memory of the process [MiB]; 0 if it is unknown.
  function peak_memory_mb() result(mb)
    real(wp) :: mb

    mb = value_of('/proc/self/status', 'VmHWM:')/1024.0_wp
  end function peak_memory_mb

  !> Keep freed memory in the process. Otherwise each factorisation gets fresh pages, which the
  !! system fills with zeros; this took 8 % of the time of a run with 26,000 equations.
  subroutine keep_memory()
    integer(c_int) :: done

    done = c_mallopt(M_MMAP_MAX, 0_c_int)
    done = c_mallopt(M_TRIM_THRESHOLD, huge(done))
  end subroutine keep_memory

  !> Return unused memory to the system, so that other processes can use it and available_memory_mb
  !! includes it.
  subroutine return_memory()
    integer(c_int) :: done

    done = c_malloc_trim(0_c_size_t)
  end subroutine return_memory

  !> Memory that is still available [MiB], within the limits of a container and of `ulimit -v`;
  !! huge(1.0_wp) if it is unknown.
  function available_memory_mb() result(mb)
    real(wp) :: mb, limit, used, cache

    mb = value_of('/proc/meminfo', 'MemAvailable:')/1024.0_wp
    if (.not. mb > 0.0_wp) mb = huge(mb)
    limit = value_of('/sys/fs/cgroup/memory.max', '')
    used = value_of('/sys/fs/cgroup/memory.current', '')
    cache = value_of('/sys/fs/cgroup/memory.stat', 'inactive_file')
    if (.not. limit > 0.0_wp) then
      limit = value_of('/sys/fs/cgroup/memory/memory.limit_in_bytes', '')
      used = value_of('/sys/fs/cgroup/memory/memory.usage_in_bytes', '')
      cache = value_of('/sys/fs/cgroup/memory/memory.stat', 'total_inactive_file')
    end if
    if (limit > 0.0_wp) mb = min(mb, max(limit - max(used - cache, 0.0_wp), 0.0_wp)/1024.0_wp**2)
    limit = value_of('/proc/self/limits', 'Max address space')/1024.0_wp**2 ! ulimit -v
    used = value_of('/proc/self/status', 'VmSize:')/1024.0_wp
    if (limit > 0.0_wp) mb = min(mb, max(limit - used, 0.0_wp))
  end function available_memory_mb

  !> The number that follows a name at the start of a line of a system file; 0 if there is none.
  function value_of(path, name) result(value)
    character(*), intent(in) :: path, name
    real(wp) :: value, found
    character(256) :: line
    integer :: unit, io

    value = 0.0_wp
    open (newunit=unit, file=path, status='old', action='read', iostat=io)
    if (io /= 0) return
    do
      read (unit, '(a)', iostat=io) line
      if (io /= 0) exit
      if (line(:len(name)) /= name) cycle
      if (verify(line(len(name) + 1:len(name) + 1), ' 0123456789'//achar(9)) > 0) cycle
      read (line(len(name) + 1:), *, iostat=io) found
      if (io == 0) value = found
      exit
    end do
    close (unit)
  end function value_of

end module base_system
