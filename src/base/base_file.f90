!> Files and folders: inspect, make, replace, remove and lock them.
module base_file
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_kinds, only: i8
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_char, c_null_char, c_ptr, c_associated
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_int16_t, c_int32_t, c_int64_t
  implicit none
  private
  public :: file_t, inspect, make_folder, replace_file, remove_file, cut_file, &
            file_size, lock_file, unlock_file, &
            lock_t, folder_of, base_name, system_reason, detach, note_input, input_of

  integer, parameter, public :: FILE_ABSENT = 0, FILE_REGULAR = 1, FILE_FOLDER = 2, FILE_OTHER = 3

  !> The file, folder or other object to which a path points.
  type :: file_t
    integer :: kind = FILE_ABSENT
    integer(i8) :: size = 0         !! bytes
    integer(i8) :: identity(2) = 0  !! device and inode: equal for two names of one file
    character(:), allocatable :: reason !! why nothing was found at the path
  end type file_t

  !> A lock that is held.
  type :: lock_t
    private
    character(:), allocatable :: path
    integer(c_int) :: fd = -1
  end type lock_t

  !> A file that the process has read.
  type :: input_t
    character(:), allocatable :: path
    integer(i8) :: identity(2) = 0
    logical :: checkpoint = .false. !! the run may replace it with its own checkpoints
  end type input_t

  type(input_t), allocatable :: inputs(:) !! all files that the process has read

  integer(c_int), parameter :: AT_FDCWD = -100, AT_EMPTY_PATH = 4096, F_TLOCK = 2
  integer(c_int), parameter :: AT_SYMLINK_NOFOLLOW = 256
  integer(c_int), parameter :: STATX_BASIC = 2047

  !> The structure statx of the C library, which is the same on every architecture.
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

    function c_truncate(path, length) bind(C, name='truncate') result(failed)
      import :: c_int, c_long, c_char
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_long), value :: length
      integer(c_int) :: failed
    end function c_truncate

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

contains

  !> Examine a path without opening it.
  subroutine inspect(path, file)
    character(*), intent(in) :: path
    type(file_t), intent(out) :: file
    type(statx_t) :: buffer
    integer :: kind

    if (c_statx(AT_FDCWD, c_text(path), 0_c_int, STATX_BASIC, buffer) /= 0) then
      file%reason = system_reason()
      return
    end if
    kind = iand(ishft(int(buffer%mode), -12), 15)
    file%kind = FILE_OTHER
    if (kind == 8) file%kind = FILE_REGULAR
    if (kind == 4) file%kind = FILE_FOLDER
    file%size = buffer%size
    file%identity = identity_of(buffer)
  end subroutine inspect

  !> Record that a file is read, so that the output does not replace it.
  subroutine note_input(path, checkpoint)
    character(*), intent(in) :: path
    logical, intent(in), optional :: checkpoint !! the file contains checkpoints
    type(input_t), allocatable :: longer(:)
    type(file_t) :: file
    integer :: n

    call inspect(path, file)
    if (file%kind == FILE_ABSENT) return
    n = 0
    if (allocated(inputs)) n = size(inputs)
    allocate (longer(n + 1))
    if (n > 0) longer(:n) = inputs
    longer(n + 1)%path = path
    longer(n + 1)%identity = file%identity
    if (present(checkpoint)) longer(n + 1)%checkpoint = checkpoint
    call move_alloc(longer, inputs)
  end subroutine note_input

  !> The name under which the file at a path was read; blank if it was not read.
  function input_of(path, checkpoint) result(name)
    character(*), intent(in) :: path
    logical, intent(in), optional :: checkpoint !! ignore checkpoint files
    character(:), allocatable :: name
    type(file_t) :: file
    integer :: i

    name = ''
    call inspect(path, file)
    if (file%kind == FILE_ABSENT .or. .not. allocated(inputs)) return
    do i = 1, size(inputs)
      if (any(inputs(i)%identity /= file%identity)) cycle
      if (present(checkpoint)) then
        if (checkpoint .and. inputs(i)%checkpoint) cycle
      end if
      name = inputs(i)%path
      return
    end do
  end function input_of

  pure function identity_of(buffer) result(identity)
    type(statx_t), intent(in) :: buffer
    integer(i8) :: identity(2)

    identity = [ior(ishft(int(buffer%dev_major, i8), 32), int(buffer%dev_minor, i8)), &
                int(buffer%ino, i8)]
  end function identity_of

  !> Make a folder and its parent folders; they may exist already.
  subroutine make_folder(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(file_t) :: file
    character(:), allocatable :: reason
    integer :: i

    reason = 'its name is empty'
    do i = 1, len(path)
      if (i < len(path)) then
        if (path(i + 1:i + 1) /= '/' .or. path(i:i) == '/') cycle
      end if
      if (c_mkdir(c_text(path(:i)), int(o'777', c_int)) /= 0) reason = system_reason()
    end do
    call inspect(path, file)
    if (file%kind == FILE_FOLDER) return
    if (file%kind /= FILE_ABSENT) reason = 'it exists and is not a folder'
    call fail(error, SYSTEM_ERROR, "cannot create the folder '"//path//"': "//reason)
  end subroutine make_folder

  !> Rename a file. If the new name exists, its file is replaced atomically, so that one of the two
  !! files always exists.
  subroutine replace_file(from, to, error)
    character(*), intent(in) :: from, to
    type(error_t), allocatable, intent(out) :: error

    if (c_rename(c_text(from), c_text(to)) /= 0) then
      call fail(error, SYSTEM_ERROR, "cannot write '"//to//"': "//system_reason())
    end if
  end subroutine replace_file

  !> Remove a file if it is there.
  subroutine remove_file(path)
    character(*), intent(in) :: path
    integer(c_int) :: failed

    failed = c_unlink(c_text(path))
  end subroutine remove_file

  !> Shorten a file to a length. A file that is not longer remains as it is.
  subroutine cut_file(path, length, error)
    character(*), intent(in) :: path
    integer(i8), intent(in) :: length    !! [byte]
    type(error_t), allocatable, intent(out) :: error

    if (file_size(path) <= length) return
    if (c_truncate(c_text(path), int(length, c_long)) /= 0) then
      call fail(error, SYSTEM_ERROR, "cannot write '"//path//"': "//system_reason())
    end if
  end subroutine cut_file

  !> Size of a file [byte]; 0 if there is none.
  function file_size(path) result(size)
    character(*), intent(in) :: path
    integer(i8) :: size
    type(file_t) :: file

    call inspect(path, file)
    size = file%size
  end function file_size

  !> Remove a path that is a symbolic link, or one of several hard links to a file, so that creating
  !! a file at this path does not change any other file.
  subroutine detach(path)
    character(*), intent(in) :: path
    integer, parameter :: REGULAR = 8, LINK = 10
    type(statx_t) :: buffer
    integer :: kind

    if (c_statx(AT_FDCWD, c_text(path), AT_SYMLINK_NOFOLLOW, STATX_BASIC, buffer) /= 0) return
    kind = iand(ishft(int(buffer%mode), -12), 15)
    if (kind == LINK .or. (kind == REGULAR .and. buffer%nlink > 1)) call remove_file(path)
  end subroutine detach

  !> Take the lock `path`, which lasts until the process ends or unlock_file is called. If another
  !! process holds the lock, the procedure fails at once.
  subroutine lock_file(path, lock, error)
    character(*), intent(in) :: path
    type(lock_t), intent(out) :: lock
    type(error_t), allocatable, intent(out) :: error
    type(statx_t) :: opened
    type(file_t) :: file
    integer(c_int) :: failed
    integer :: try

    call detach(path)
    do try = 1, 100
      lock%fd = c_creat(c_text(path), int(o'666', c_int))
      if (lock%fd < 0) then
        call fail(error, SYSTEM_ERROR, "cannot write '"//path//"': "//system_reason())
        return
      end if
      if (c_lockf(lock%fd, F_TLOCK, 0_c_long) /= 0) then
        failed = c_close(lock%fd)
        call fail(error, SYSTEM_ERROR, "another run is using '"//path//"'", &
                  hint='wait until that run has ended, or give this run another folder (-o) or ' &
                  //'name (--name)')
        return
      end if
      ! Between these two calls, the previous holder of the lock may have removed the file. A lock
      ! on a removed file excludes nobody, so the loop tries again.
      failed = c_statx(lock%fd, c_text(''), AT_EMPTY_PATH, STATX_BASIC, opened)
      call inspect(path, file)
      if (failed /= 0) exit
      if (all(file%identity == identity_of(opened))) exit
      failed = c_close(lock%fd)
    end do
    lock%path = path
  end subroutine lock_file

  !> Release a lock.
  subroutine unlock_file(lock)
    type(lock_t), intent(inout) :: lock
    integer(c_int) :: failed

    if (lock%fd < 0) return
    failed = c_unlink(c_text(lock%path))
    failed = c_close(lock%fd)
    lock%fd = -1
  end subroutine unlock_file

  !> Folder of a path, with its last slash; blank if there is none.
  pure function folder_of(path) result(folder)
    character(*), intent(in) :: path
    character(:), allocatable :: folder

    folder = path(:index(path, '/', back=.true.))
  end function folder_of

  !> Name of a file from its path, without the folders.
  pure function base_name(path) result(name)
    character(*), intent(in) :: path
    character(:), allocatable :: name

    name = path(index(path, '/', back=.true.) + 1:)
  end function base_name

  !> Why the last call of the C library failed, in the words of the operating system.
  function system_reason() result(reason)
    character(:), allocatable :: reason
    integer(c_int), pointer :: number
    character(kind=c_char), pointer :: text(:)
    type(c_ptr) :: address
    integer :: i

    call c_f_pointer(c_errno(), number)
    address = c_strerror(number)
    reason = 'unknown reason'
    if (.not. c_associated(address)) return
    call c_f_pointer(address, text, [int(c_strlen(address))])
    reason = repeat(' ', size(text))
    do i = 1, size(text)
      reason(i:i) = text(i)
    end do
    if (reason(1:1) >= 'A' .and. reason(1:1) <= 'Z') reason(1:1) = achar(iachar(reason(1:1)) + 32)
  end function system_reason

  pure function c_text(text) result(c)
    character(*), intent(in) :: text
    character(kind=c_char) :: c(len(text) + 1)
    integer :: i

    do i = 1, len(text)
      c(i) = text(i:i)
    end do
    c(len(text) + 1) = c_null_char
  end function c_text

end module base_file
