!> Files written through C streams, because a Fortran write to a full disk fails silently
!! (libgfortran 12 returns iostat 0 from write, flush and close).
module byte_file
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_file, only: detach, replace_file, remove_file, system_reason
  use base_kinds, only: i8
  use, intrinsic :: iso_c_binding, only: c_int, c_size_t, c_char, c_ptr, c_null_ptr, c_null_char, &
                                                                            c_loc, c_associated
  implicit none
  private
  public :: byte_file_t, open_bytes, write_text, write_bytes, flush_bytes, close_bytes
  public :: write_whole, take_room, reason

  !> An open stream.
  type :: byte_file_t
    character(:), allocatable :: path
    type(c_ptr), private :: stream = c_null_ptr
  end type byte_file_t

  ! allow(assumed-size)
  interface
    function c_fopen(path, mode) bind(C, name='fopen') result(stream)
      import :: c_ptr, c_char
      implicit none
      character(kind=c_char), intent(in) :: path(*), mode(*)
      type(c_ptr) :: stream
    end function c_fopen

    function c_fwrite(buffer, size, count, stream) bind(C, name='fwrite') result(done)
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: buffer, stream
      integer(c_size_t), value :: size, count
      integer(c_size_t) :: done
    end function c_fwrite

    function c_fflush(stream) bind(C, name='fflush') result(status)
      import :: c_ptr, c_int
      implicit none
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fflush

    function c_fclose(stream) bind(C, name='fclose') result(status)
      import :: c_ptr, c_int
      implicit none
      type(c_ptr), value :: stream
      integer(c_int) :: status
    end function c_fclose
  end interface

contains

  !> Open a file for writing: either append to the file at the path, or replace it by an empty one.
  !! If the path of a file to be replaced is a link, only the link is removed, and the file to which
  !! it points is not changed.
  subroutine open_bytes(file, path, appends, error)
    type(byte_file_t), intent(out) :: file
    character(*), intent(in) :: path
    logical, intent(in) :: appends
    type(error_t), allocatable, intent(out) :: error

    file%path = path
    if (.not. appends) call detach(path)
    file%stream = c_fopen(path//c_null_char, merge('ab', 'wb', appends)//c_null_char)
    if (.not. c_associated(file%stream)) call refuse('create', path, error)
  end subroutine open_bytes

  subroutine write_text(file, text, error)
    type(byte_file_t), intent(in) :: file
    character(*), intent(in), target :: text
    type(error_t), allocatable, intent(out) :: error

    if (len(text) > 0) call write_bytes(file, c_loc(text), int(len(text), c_size_t), error)
  end subroutine write_text

  subroutine write_bytes(file, buffer, count, error)
    type(byte_file_t), intent(in) :: file
    type(c_ptr), intent(in) :: buffer
    integer(c_size_t), intent(in) :: count
    type(error_t), allocatable, intent(out) :: error

    if (count == 0) return
    if (c_fwrite(buffer, 1_c_size_t, count, file%stream) /= count) then
      call refuse('write', file%path, error)
    end if
  end subroutine write_bytes

  !> Pass everything that was written to the operating system, so that it is not lost if the program
  !! crashes.
  subroutine flush_bytes(file, error)
    type(byte_file_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error

    if (c_fflush(file%stream) /= 0) call refuse('write', file%path, error)
  end subroutine flush_bytes

  subroutine close_bytes(file, error)
    type(byte_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error

    if (.not. c_associated(file%stream)) return
    if (c_fclose(file%stream) /= 0) call refuse('write', file%path, error)
    file%stream = c_null_ptr
  end subroutine close_bytes

  !> Write a small file under a temporary name and then rename it, so that an incomplete file never
  !! appears at the path.
  subroutine write_whole(path, text, error)
    character(*), intent(in) :: path, text
    type(error_t), allocatable, intent(out) :: error
    type(byte_file_t) :: file

    call open_bytes(file, path//'.part', .false., error)
    if (allocated(error)) return
    call write_text(file, text, error)
    if (.not. allocated(error)) call close_bytes(file, error)
    if (.not. allocated(error)) call replace_file(path//'.part', path, error)
    if (allocated(error)) call remove_file(path//'.part')
  end subroutine write_whole

  !> Extend a file by `count` blanks, in order to reserve this space on the disk.
  subroutine take_room(path, count, error)
    character(*), intent(in) :: path
    integer(i8), intent(in) :: count
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: ignored
    type(byte_file_t) :: file
    character(:), allocatable :: piece
    integer(i8) :: done

    call open_bytes(file, path, .true., error)
    if (allocated(error)) return
    piece = repeat(' ', 1048576)
    done = 0
    do while (done < count .and. .not. allocated(error))
      call write_text(file, piece(:min(int(len(piece), i8), count - done)), error)
      done = done + len(piece)
    end do
    if (.not. allocated(error)) call flush_bytes(file, error)
    call close_bytes(file, ignored)
  end subroutine take_room

  !> The reason why a library could not write or read a file, found by trying to do so: for example
  !! ': no space left on device', or '' if the system reports no error.
  function reason(path, writes) result(text)
    character(*), intent(in) :: path
    logical, intent(in) :: writes
    character(:), allocatable :: text
    type(byte_file_t) :: probe
    type(error_t), allocatable :: error

    text = ''
    probe%stream = c_fopen(path//c_null_char, merge('r+', 'rb', writes)//c_null_char)
    if (.not. c_associated(probe%stream)) text = ': '//system_reason()
    call close_bytes(probe, error)
    if (.not. writes) return
    probe%path = path//'.probe'
    probe%stream = c_fopen(probe%path//c_null_char, 'wb'//c_null_char)
    if (.not. c_associated(probe%stream)) then
      text = ': '//system_reason()
      return
    end if
    call write_text(probe, repeat(' ', 65536), error)
    if (.not. allocated(error)) call flush_bytes(probe, error)
    if (allocated(error)) text = ': '//system_reason()
    call close_bytes(probe, error)
    call remove_file(path//'.probe')
  end function reason

  subroutine refuse(verb, path, error)
    character(*), intent(in) :: verb, path
    type(error_t), allocatable, intent(out) :: error

    call fail(error, SYSTEM_ERROR, &
              'cannot '//verb//' '''//path//''': '//system_reason())
  end subroutine refuse

end module byte_file
