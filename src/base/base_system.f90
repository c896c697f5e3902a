!> The C library's calls that we use, as they are (glibc, Linux). base_system gives them a Fortran
!! face.
!!
!! What the operating system does for us: the end of the process, signals, terminal, time and
!! memory.
module base_system
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_char, c_ptr, c_funptr, c_int16_t, &
      c_int32_t, c_int64_t, c_size_t, c_funloc, c_intptr_t
  use base_kinds, only: wp, i8
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  implicit none
  private
  public :: c_exit, c_leave, c_isatty, c_statx, c_mkdir, c_rename, c_creat, c_close, c_lockf, &
            c_unlink, c_signal, c_sigemptyset, c_sigaddset, c_sigprocmask, sigset_t, c_mallopt, &
            c_malloc_trim, c_getpid, c_errno, c_strerror, c_strlen, statx_t, finish, finish_now, &
            stderr_is_terminal, catch_signals, hold_signals, let_signals_in, stop_requested, &
            stop_signal, start_clock, wall_seconds, cpu_seconds, process_id, peak_memory_mb, &
            available_memory_mb, keep_memory, return_memory

  integer(c_int), parameter, public :: AT_FDCWD = -100, AT_EMPTY_PATH = 4096, F_TLOCK = 2
  integer(c_int), parameter, public :: M_TRIM_THRESHOLD = -1, M_MMAP_MAX = -4 !! mallopt
  integer(c_int), parameter, public :: STATX_BASIC = 2047
  integer(c_int), parameter, public :: SIGINT = 2, SIGUSR1 = 10, SIGPIPE = 13, SIGTERM = 15, &
                                       SIGXFSZ = 25

  integer(c_int), parameter, public :: SIG_BLOCK = 0, SIG_SETMASK = 2

  !> A set of signals: 1024 bits.
  type, bind(C) :: sigset_t
    integer(c_int64_t) :: bits(16)
  end type sigset_t

  !> struct statx: the same on every architecture.
  type, bind(C) :: statx_t
    integer(c_int32_t) :: mask, blksize
    integer(c_int64_t) :: attributes
    integer(c_int32_t) :: nlink, uid, gid
    integer(c_int16_t) :: mode, spare
    integer(c_int64_t) :: ino, size, blocks, attributes_mask
    integer(c_int64_t) :: times(8)
    integer(c_int32_t) :: rdev_major, rdev_minor, dev_major, dev_minor
    integer(c_int64_t) :: more(14)
  end type statx_t

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

    function c_statx(folder, path, flags, mask, buffer) bind(C, name='statx') result(failed)
      import :: c_int, c_char, statx_t
      implicit none
      integer(c_int), value :: folder, flags, mask
      character(kind=c_char), intent(in) :: path(*)
      type(statx_t), intent(out) :: buffer
      integer(c_int) :: failed
    end function c_statx

    function c_mkdir(path, mode) bind(C, name='mkdir') result(failed)
      import :: c_int, c_char
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      integer(c_int) :: failed
    end function c_mkdir

    function c_rename(from, to) bind(C, name='rename') result(failed)
      import :: c_int, c_char
      implicit none
      character(kind=c_char), intent(in) :: from(*), to(*)
      integer(c_int) :: failed
    end function c_rename

    function c_creat(path, mode) bind(C, name='creat') result(fd)
      import :: c_int, c_char
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: mode
      integer(c_int) :: fd
    end function c_creat

    function c_close(fd) bind(C, name='close') result(failed)
      import :: c_int
      implicit none
      integer(c_int), value :: fd
      integer(c_int) :: failed
    end function c_close

    function c_lockf(fd, command, length) bind(C, name='lockf') result(failed)
      import :: c_int, c_long
      implicit none
      integer(c_int), value :: fd, command
      integer(c_long), value :: length
      integer(c_int) :: failed
    end function c_lockf

    function c_unlink(path) bind(C, name='unlink') result(failed)
      import :: c_int, c_char
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int) :: failed
    end function c_unlink

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

    function c_errno() bind(C, name='__errno_location') result(address)
      import :: c_ptr
      implicit none
      type(c_ptr) :: address
    end function c_errno

    function c_strerror(number) bind(C, name='strerror') result(text)
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: number
      type(c_ptr) :: text
    end function c_strerror

    function c_strlen(text) bind(C, name='strlen') result(n)
      import :: c_ptr, c_long
      implicit none
      type(c_ptr), value :: text
      integer(c_long) :: n
    end function c_strlen
  end interface

  type(sigset_t) :: before               !! hold_signals: the mask before it
  integer(c_int), volatile :: caught = 0 !! number of the signal that asked us to stop
  integer(i8) :: origin = -huge(0_i8)    !! count of the clock when the run began

contains

  !> The one place that ends the process.
  subroutine finish(code)
    integer, intent(in) :: code

    flush (output_unit)
    flush (error_unit)
    call c_exit(int(code, c_int))
  end subroutine finish

  !> End the process without what libraries do at the end: a thread of OpenBLAS that waits for
  !! memory is waited for there, for ever.
  subroutine finish_now(code)
    integer, intent(in) :: code

    flush (error_unit)
    call c_leave(int(code, c_int))
  end subroutine finish_now

  function stderr_is_terminal() result(yes)
    logical :: yes

    yes = c_isatty(2_c_int) == 1
  end function stderr_is_terminal

  ! --- signals ---------------------------------------------------------------------------------

  !> From now on SIGTERM, SIGINT and SIGUSR1 ask for a stop. A second SIGINT ends the process as
  !! usual.
  !! A closed pipe and a full file are then reported by the write that meets them.
  subroutine catch_signals()
    type(c_funptr) :: old

    caught = 0
    old = c_signal(SIGTERM, c_funloc(note_signal))
    old = c_signal(SIGINT, c_funloc(note_signal))
    old = c_signal(SIGUSR1, c_funloc(note_signal))
    old = c_signal(SIGPIPE, transfer(1_c_intptr_t, old))  ! SIG_IGN
    old = c_signal(SIGXFSZ, transfer(1_c_intptr_t, old))
  end subroutine catch_signals

  subroutine note_signal(number) bind(C)
    integer(c_int), value :: number
    type(c_funptr) :: old

    caught = number
    if (number == SIGINT) old = c_signal(SIGINT, transfer(0_c_intptr_t, old)) ! SIG_DFL
  end subroutine note_signal

  !> SIGTERM waits until it is let in again: for libraries that catch it for ends of their own.
  subroutine hold_signals()
    type(sigset_t) :: set
    integer(c_int) :: failed

    failed = c_sigemptyset(set)
    failed = c_sigaddset(set, SIGTERM)
    failed = c_sigprocmask(SIG_BLOCK, set, before)
  end subroutine hold_signals

  !> As it was before hold_signals; one that came meanwhile is heard now.
  subroutine let_signals_in()
    type(sigset_t) :: set
    integer(c_int) :: failed

    failed = c_sigprocmask(SIG_SETMASK, before, set)
  end subroutine let_signals_in

  function stop_requested() result(yes)
    logical :: yes

    yes = caught /= 0
  end function stop_requested

  !> Name of the signal that asked for the stop, blank: none did.
  function stop_signal() result(name)
    character(:), allocatable :: name

    select case (caught)
    case (0); name = ''
    case (SIGTERM); name = 'SIGTERM'
    case (SIGINT); name = 'SIGINT'
    case default; name = 'SIGUSR1'
    end select
  end function stop_signal

  ! --- time and memory -------------------------------------------------------------------------

  !> The run begins; without this call it begins with the first look at the clock.
  subroutine start_clock()
    call system_clock(origin)
  end subroutine start_clock

  !> Seconds since the run began.
  function wall_seconds() result(seconds)
    real(wp) :: seconds
    integer(i8) :: count, rate

    if (origin < 0) call start_clock()
    call system_clock(count, rate)
    seconds = real(count - origin, wp)/real(rate, wp)
  end function wall_seconds

  !> Processor time of all threads [s].
  function cpu_seconds() result(seconds)
    real(wp) :: seconds

    call cpu_time(seconds)
  end function cpu_seconds

  function process_id() result(id)
    integer :: id

    id = int(c_getpid())
  end function process_id

  !> Largest memory that the process has held [MiB]; 0: unknown.
  function peak_memory_mb() result(mb)
    real(wp) :: mb

    mb = value_of('/proc/self/status', 'VmHWM:')/1024.0_wp
  end function peak_memory_mb

  !> Memory once had stays with the process: a factorisation that gets fresh pages each time has the
  !! system zero them each time, 8 % of a run with 26,000 equations.
  subroutine keep_memory()
    integer(c_int) :: done

    done = c_mallopt(M_MMAP_MAX, 0_c_int)
    done = c_mallopt(M_TRIM_THRESHOLD, huge(done))
  end subroutine keep_memory

  !> Give what is not in use back to the system, as others, or its count of free memory, need it.
  subroutine return_memory()
    integer(c_int) :: done

    done = c_malloc_trim(0_c_size_t)
  end subroutine return_memory

  !> Memory that can still be had [MiB], the limits of a container and of `ulimit -v` included;
  !! huge: unknown.
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

  !> The number behind a name at the start of a line of a system file; 0 where there is none.
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
