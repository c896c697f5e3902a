!> HDF5 files, groups and attributes. The module `hdf5_file` adds datasets; other modules use only
!! `hdf5_file`.
!!
!! A call that finds `error` allocated does nothing, so that a sequence of calls is checked once at
!! its end. Opening and closing a file are exceptions: they always act.
module hdf5_object
  use, intrinsic :: iso_c_binding, only: c_int, c_char, c_null_char, c_ptr, c_loc
  use hdf5, only: HID_T, HSIZE_T, SIZE_T, H5F_ACC_TRUNC_F, H5F_ACC_RDONLY_F, H5F_ACC_RDWR_F, &
                  H5F_CLOSE_STRONG_F, H5F_SCOPE_GLOBAL_F, H5P_FILE_ACCESS_F, H5S_SCALAR_F, &
                  H5T_FORTRAN_S1, H5T_STD_I64LE, H5T_NATIVE_INTEGER, h5open_f, h5eset_auto_f, &
                  h5fcreate_f, h5fopen_f, h5fclose_f, h5fflush_f, h5pcreate_f, h5pclose_f, &
                  h5pset_fclose_degree_f, h5gcreate_f, h5gclose_f, h5acreate_by_name_f, &
                  h5aopen_by_name_f, h5aclose_f, h5awrite_f, h5aread_f, h5aexists_by_name_f, &
                  h5aget_type_f, h5tcopy_f, h5tclose_f, h5tset_size_f, h5tget_size_f, h5screate_f, &
                  h5screate_simple_f, h5sclose_f, h5lexists_f, h5ocopy_f, h5aget_storage_size_f, &
                  h5oopen_f, h5oclose_f, h5aopen_f, h5acreate_f, h5pset_meta_block_size_f
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_file, only: detach
  use base_system, only: set_variable
  use byte_file, only: reason
  implicit none
  private
  public :: hdf5_t, create_file, open_file, close_file, flush_file, make_group, has_object
  public :: copy_object, put_attribute, get_attribute, refuse

  !> An open file.
  type :: hdf5_t
    integer(HID_T) :: id = -1
    character(:), allocatable :: path
  end type hdf5_t

  !> put_attribute(file, object, name, value, error) stores text, or integers with 64 bits.
  interface put_attribute
    module procedure put_text, put_integers
  end interface put_attribute

  !> get_attribute(file, object, name, value, error) reads text or integers.
  interface get_attribute
    module procedure get_text, get_integers
  end interface get_attribute

  interface
    function h5dont_atexit() bind(C, name='H5dont_atexit') result(status)
      import :: c_int
      implicit none
      integer(c_int) :: status
    end function h5dont_atexit
  end interface

contains

  !> Create a file. An existing file or link of that name is replaced.
  subroutine create_file(file, path, error)
    type(hdf5_t), intent(out) :: file
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    integer(HID_T) :: access
    integer :: status

    call start_library(access)
    file%path = path
    call detach(path)
    call h5fcreate_f(path, H5F_ACC_TRUNC_F, file%id, status, access_prp=access)
    if (status /= 0) call refuse(file, 'cannot create', error)
    call h5pclose_f(access, status)
  end subroutine create_file

  !> Open an existing file.
  subroutine open_file(file, path, writable, error)
    type(hdf5_t), intent(out) :: file
    character(*), intent(in) :: path
    logical, intent(in) :: writable
    type(error_t), allocatable, intent(out) :: error
    integer(HID_T) :: access
    integer :: status

    call start_library(access)
    file%path = path
    call h5fopen_f(path, merge(H5F_ACC_RDWR_F, H5F_ACC_RDONLY_F, writable), file%id, status, &
                   access_prp=access)
    if (status /= 0) call refuse(file, 'cannot open', error)
    call h5pclose_f(access, status)
  end subroutine open_file

  !> Close a file. A full disk may be noticed only here.
  subroutine close_file(file, error)
    type(hdf5_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: status

    if (file%id < 0) return
    call h5fclose_f(file%id, status)
    file%id = -1
    if (status /= 0) call refuse(file, 'cannot finish', error)
  end subroutine close_file

  !> Hand everything written so far to the operating system.
  subroutine flush_file(file, error)
    type(hdf5_t), intent(in) :: file
    type(error_t), allocatable, intent(inout) :: error
    integer :: status

    if (allocated(error)) return
    call h5fflush_f(file%id, H5F_SCOPE_GLOBAL_F, status)
    if (status /= 0) call refuse(file, 'cannot write', error)
  end subroutine flush_file

  subroutine make_group(file, name, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(inout) :: error
    integer(HID_T) :: group
    integer :: status

    if (allocated(error)) return
    call h5gcreate_f(file%id, name, group, status)
    if (status == 0) call h5gclose_f(group, status)
    if (status /= 0) call refuse(file, 'cannot write', error)
  end subroutine make_group

  !> Does an object of that name exist? Its parents must exist.
  function has_object(file, name) result(exists)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    logical :: exists
    integer :: status

    call h5lexists_f(file%id, name, exists, status)
    if (status /= 0) exists = .false.
  end function has_object

  !> Copy a group or a dataset with its contents.
  subroutine copy_object(from, name, to, new_name, error)
    type(hdf5_t), intent(in) :: from, to
    character(*), intent(in) :: name, new_name
    type(error_t), allocatable, intent(inout) :: error
    integer :: status

    if (allocated(error)) return
    call h5ocopy_f(from%id, name, to%id, new_name, status)
    if (status /= 0) call refuse(to, 'cannot write', error)
  end subroutine copy_object

  !> Store text as a string of fixed length. An attribute holds less than 64 kB.
  subroutine put_text(file, object, name, value, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: object, name
    character(*), intent(in), target :: value
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable, target :: buffer
    integer(HID_T) :: type, space, attribute
    integer :: status, ignored

    if (allocated(error)) return
    buffer = value
    if (len(value) == 0) buffer = ' '
    call h5tcopy_f(H5T_FORTRAN_S1, type, status)
    call h5tset_size_f(type, int(len(buffer), SIZE_T), status)
    call h5screate_f(H5S_SCALAR_F, space, status)
    call h5acreate_by_name_f(file%id, object, name, type, space, attribute, status)
    if (status == 0) then
      call h5awrite_f(attribute, type, c_loc(buffer(1:1)), status)
      call h5aclose_f(attribute, ignored)
    end if
    if (status /= 0) call refuse(file, 'cannot write', error)
    call h5sclose_f(space, ignored)
    call h5tclose_f(type, ignored)
  end subroutine put_text

  !> Store integers; a single one becomes a scalar. An existing attribute is overwritten in place.
  subroutine put_integers(file, object, name, value, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer, intent(in), target, contiguous :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(HID_T) :: space, attribute, holder
    integer :: status, ignored
    logical :: exists

    if (allocated(error)) return
    call h5oopen_f(file%id, object, holder, status)
    if (status /= 0) then
      call refuse(file, 'cannot write', error)
      return
    end if
    call h5aexists_by_name_f(file%id, object, name, exists, status)
    if (exists) then ! HDF5 1.10.8 cannot write an attribute opened by name
      call h5aopen_f(holder, name, attribute, status)
    else
      if (size(value) == 1) then
        call h5screate_f(H5S_SCALAR_F, space, status)
      else
        call h5screate_simple_f(1, [size(value, kind=HSIZE_T)], space, status)
      end if
      call h5acreate_f(holder, name, H5T_STD_I64LE, space, attribute, status)
      call h5sclose_f(space, ignored)
    end if
    if (status == 0) then
      call h5awrite_f(attribute, H5T_NATIVE_INTEGER, c_loc(value), status)
      call h5aclose_f(attribute, ignored)
    end if
    call h5oclose_f(holder, ignored)
    if (status /= 0) call refuse(file, 'cannot write', error)
  end subroutine put_integers

  !> Read a string.
  subroutine get_text(file, object, name, value, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: object, name
    character(:), allocatable, intent(out), target :: value
    type(error_t), allocatable, intent(inout) :: error
    integer(HID_T) :: type, attribute
    integer(SIZE_T), parameter :: LONGEST = 2_SIZE_T**30
    integer(SIZE_T) :: length
    integer(HSIZE_T) :: bytes
    type(c_ptr) :: place
    integer :: status, ignored

    value = ''
    if (allocated(error)) return
    call h5aopen_by_name_f(file%id, object, name, attribute, status)
    if (status == 0) then
      call h5aget_type_f(attribute, type, status)
      call h5tget_size_f(type, length, status)
      call h5aget_storage_size_f(attribute, bytes, ignored)
      if (length < 1 .or. length > LONGEST .or. bytes /= length) status = -1 ! a damaged file
      if (status == 0) then
        deallocate (value)
        allocate (character(int(length)) :: value)
        place = c_loc(value(1:1))
      end if
      if (status == 0) call h5aread_f(attribute, type, place, status)
      call h5tclose_f(type, ignored)
      call h5aclose_f(attribute, ignored)
    end if
    if (status /= 0) call refuse(file, 'cannot read '''//name//''' of', error)
  end subroutine get_text

  !> Read as many integers as `value` holds. It is an error if the file contains a different number
  !! of them.
  subroutine get_integers(file, object, name, value, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: object, name
    integer, intent(out), target, contiguous :: value(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(HID_T) :: attribute
    integer(HSIZE_T) :: bytes
    type(c_ptr) :: place
    integer :: status, ignored

    value = 0
    if (allocated(error)) return
    place = c_loc(value)
    call h5aopen_by_name_f(file%id, object, name, attribute, status)
    if (status == 0) then
      call h5aget_storage_size_f(attribute, bytes, status)
      if (bytes /= 8*size(value)) status = -1
      if (status == 0) call h5aread_f(attribute, H5T_NATIVE_INTEGER, place, status)
      call h5aclose_f(attribute, ignored)
    end if
    if (status /= 0) call refuse(file, 'cannot read '''//name//''' of', error)
  end subroutine get_integers

  !> Start the library without its own messages, and without locks, because a viewer may have the
  !! file open. Closing a file closes every object that is open in it.
  subroutine start_library(access)
    integer(HID_T), intent(out) :: access !! properties for creating or opening a file
    logical :: done
    integer :: status

    call set_variable('HDF5_USE_FILE_LOCKING', 'FALSE', done)
    ! The clean-up of HDF5 1.10.8 at exit crashes after a write to a full disk.
    status = h5dont_atexit()
    call h5open_f(status)
    call h5eset_auto_f(0, status)
    call h5pcreate_f(H5P_FILE_ACCESS_F, access, status)
    call h5pset_fclose_degree_f(access, H5F_CLOSE_STRONG_F, status)
    call h5pset_meta_block_size_f(access, 32768_HSIZE_T, status) ! keeps metadata together
  end subroutine start_library

  !> Report a failure of the library with the reason that the operating system gives.
  subroutine refuse(file, verb, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: verb !! e.g. 'cannot write'
    type(error_t), allocatable, intent(out) :: error

    call fail(error, SYSTEM_ERROR, verb//' '''//file%path//''''// &
              reason(file%path, writes=verb == 'cannot write' .or. verb == 'cannot create' .or. &
                     verb == 'cannot finish'))
  end subroutine refuse

end module hdf5_object
