!> Files and folders: what a path is, making, replacing, locking.
module base_file
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_kinds, only: i8
  use base_system, only: c_statx, c_mkdir, c_rename, c_creat, c_close, c_lockf, c_unlink, c_errno, &
      c_strerror, c_strlen, statx_t, AT_FDCWD, AT_EMPTY_PATH, F_TLOCK, STATX_BASIC
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_char, c_null_char, c_ptr, c_associated, &
                                                                            c_f_pointer
  implicit none
  private
  public :: file_t, inspect, make_folder, replace_file, remove_file, lock_file, unlock_file, &
            lock_t, folder_of, base_name
  public :: system_reason

  integer, parameter, public :: FILE_ABSENT = 0, FILE_REGULAR = 1, FILE_FOLDER = 2, FILE_OTHER = 3

  !> What stands at a path.
  type :: file_t
    integer :: kind = FILE_ABSENT
    integer(i8) :: size = 0         !! bytes
    integer(i8) :: identity(2) = 0  !! device and number: equal for two names of one file
    character(:), allocatable :: reason !! why it cannot be had, where it is absent
  end type file_t

  !> A lock that is held.
  type :: lock_t
    private
    character(:), allocatable :: path
    integer(c_int) :: fd = -1
  end type lock_t

contains

  !> Look at a path without opening it.
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

  pure function identity_of(buffer) result(identity)
    type(statx_t), intent(in) :: buffer
    integer(i8) :: identity(2)

    identity = [ior(ishft(int(buffer%dev_major, i8), 32), int(buffer%dev_minor, i8)), &
                int(buffer%ino, i8)]
  end function identity_of

  !> Make a folder and those above it; one that is there already is fine.
  subroutine make_folder(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(file_t) :: file
    character(:), allocatable :: reason
    integer :: i

    reason = 'no name'
    do i = 1, len(path)
      if (i < len(path)) then
        if (path(i + 1:i + 1) /= '/' .or. path(i:i) == '/') cycle
      end if
      if (c_mkdir(c_text(path(:i)), int(o'777', c_int)) /= 0) reason = system_reason()
    end do
    call inspect(path, file)
    if (file%kind == FILE_FOLDER) return
    if (file%kind /= FILE_ABSENT) reason = 'it exists and is not a folder'
    call fail(error, SYSTEM_ERROR, "cannot make the folder '"//path//"': "//reason)
  end subroutine make_folder

  !> Rename; a file of the new name is replaced at once, so that one of the two always exists.
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

  !> Take the lock `path`, which ends with the process or with unlock_file. Fails at once where
  !! another
  !! process holds it.
  subroutine lock_file(path, lock, error)
    character(*), intent(in) :: path
    type(lock_t), intent(out) :: lock
    type(error_t), allocatable, intent(out) :: error
    type(statx_t) :: opened
    type(file_t) :: file
    integer(c_int) :: failed
    integer :: try

    do try = 1, 100
      lock%fd = c_creat(c_text(path), int(o'666', c_int))
      if (lock%fd < 0) then
        call fail(error, SYSTEM_ERROR, "cannot write '"//path//"': "//system_reason())
        return
      end if
      if (c_lockf(lock%fd, F_TLOCK, 0_c_long) /= 0) then
        failed = c_close(lock%fd)
        call fail(error, SYSTEM_ERROR, "another run holds '"//path//"'", &
                  hint='wait for it, or give this run another folder (-o) or name (--name)')
        return
      end if
      ! The holder before us may have removed the file between our two calls: then it locks nothing.
      failed = c_statx(lock%fd, c_text(''), AT_EMPTY_PATH, STATX_BASIC, opened)
      call inspect(path, file)
      if (failed /= 0) exit
      if (all(file%identity == identity_of(opened))) exit
      failed = c_close(lock%fd)
    end do
    lock%path = path
  end subroutine lock_file

  !> Give a lock back.
  subroutine unlock_file(lock)
    type(lock_t), intent(inout) :: lock
    integer(c_int) :: failed

    if (lock%fd < 0) return
    failed = c_unlink(c_text(lock%path))
    failed = c_close(lock%fd)
    lock%fd = -1
  end subroutine unlock_file

  !> The path's folder with its last slash; blank where there is none.
  pure function folder_of(path) result(folder)
    character(*), intent(in) :: path
    character(:), allocatable :: folder

    folder = path(:index(path, '/', back=.true.))
  end function folder_of

  !> The path without folders.
  pure function base_name(path) result(name)
    character(*), intent(in) :: path
    character(:), allocatable :: name

    name = path(index(path, '/', back=.true.) + 1:)
  end function base_name

  !> Why the last call of the C library failed, in its words.
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
