!> The C library's calls that we use, as they are (glibc, Linux). base_system gives them a Fortran
!! face.
module base_libc
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_char, c_ptr, c_funptr
  use, intrinsic :: iso_c_binding, only: c_int16_t, c_int32_t, c_int64_t, c_size_t
  implicit none
  private
  public :: c_exit, c_leave, c_isatty, c_statx, c_mkdir, c_rename, c_creat, c_close, c_lockf, &
            c_unlink, c_signal, c_sigemptyset, c_sigaddset, c_sigprocmask, sigset_t, c_mallopt, &
            c_malloc_trim, c_getpid, c_errno, c_strerror, c_strlen, statx_t

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

end module base_libc
