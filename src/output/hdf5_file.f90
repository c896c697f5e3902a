!> HDF5 files for the other modules: files, groups and attributes of `hdf5_object`, and datasets.
!!
!! Objects are named by their path in the file (`VTKHDF/PointData/stress`). When a dataset is
!! created, space on disk is allocated for all rows that it may get. Rows that are written later
!! therefore do not move anything in the file. The file stays readable if the program is killed,
!! and other programs may read it during the analysis. The rule for `error` is that of
!! `hdf5_object`.
module hdf5_file
  use, intrinsic :: iso_c_binding, only: c_ptr, c_loc
  use hdf5, only: HID_T, HSIZE_T, H5S_SELECT_SET_F, H5D_ALLOC_TIME_EARLY_F, H5D_FILL_TIME_NEVER_F, &
                  H5P_DATASET_CREATE_F, H5T_IEEE_F64LE, H5T_STD_I64LE, H5T_STD_I32LE, &
                  H5T_STD_U8LE, H5T_NATIVE_DOUBLE, H5T_NATIVE_INTEGER, h5pcreate_f, h5pclose_f, &
                  h5pset_alloc_time_f, h5pset_fill_time_f, h5dcreate_f, h5dopen_f, h5dclose_f, &
                  h5dwrite_f, h5dread_f, h5dget_space_f, h5screate_simple_f, h5sclose_f, &
                  h5sselect_hyperslab_f, h5sget_simple_extent_dims_f, &
                  h5sget_simple_extent_ndims_f, h5pset_chunk_f, h5dset_extent_f
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use hdf5_object, only: hdf5_t, create_file, open_file, close_file, flush_file, make_group, &
                         has_object, copy_object, put_attribute, get_attribute, refuse
  implicit none
  private
  public :: hdf5_t, create_file, open_file, close_file, flush_file, make_group, has_object
  public :: copy_object, put_attribute, get_attribute
  public :: reserve, set_length, put, get, get_shape

  integer, parameter, public :: AS_REAL = 1, AS_INT64 = 2, AS_INT32 = 3, AS_UINT8 = 4 !! on disk

  !> put(file, name, values, error[, first]) writes rows, the first of them to row `first` (counted
  !! from 1).
  interface put
    module procedure put_real_1, put_real_2, put_integer_1
  end interface put

  !> get(file, name, values, error[, first]) reads as many rows as `values` holds.
  interface get
    module procedure get_real_1, get_real_2, get_integer_1
  end interface get

contains

  !> Create a dataset of nrow rows of ncol numbers; it is one-dimensional if ncol = 0. With `most`,
  !! the length may change later up to that number of rows, and the space for these is allocated at
  !! once.
  subroutine reserve(file, name, type, ncol, nrow, error, most)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in) :: type      !! on disk: AS_REAL, AS_INT64, AS_INT32, AS_UINT8
    integer, intent(in) :: ncol
    integer(i8), intent(in) :: nrow
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: most
    integer(HSIZE_T) :: shape(2), longest(2)
    integer(HID_T) :: space, set, list, stored
    integer :: n, status

    if (allocated(error)) return
    select case (type)
    case (AS_INT64)
      stored = H5T_STD_I64LE
    case (AS_INT32)
      stored = H5T_STD_I32LE
    case (AS_UINT8)
      stored = H5T_STD_U8LE
    case default
      stored = H5T_IEEE_F64LE
    end select
    call set_shape(ncol, nrow, n, shape)
    longest = shape
    call h5pcreate_f(H5P_DATASET_CREATE_F, list, status)
    if (present(most)) then
      longest(n) = max(most, nrow)
      call h5pset_chunk_f(list, n, longest(1:n), status)
    end if
    call h5screate_simple_f(n, shape(1:n), space, status, longest(1:n))
    call h5pset_alloc_time_f(list, H5D_ALLOC_TIME_EARLY_F, status)
    call h5pset_fill_time_f(list, H5D_FILL_TIME_NEVER_F, status)
    call h5dcreate_f(file%id, name, stored, space, set, status, dcpl_id=list)
    if (status == 0) call h5dclose_f(set, status)
    if (status /= 0) call refuse(file, 'cannot write', error)
    call h5pclose_f(list, status)
    call h5sclose_f(space, status)
  end subroutine reserve

  !> Change the length of a one-dimensional dataset that was created with `most`.
  subroutine set_length(file, name, nrow, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(i8), intent(in) :: nrow
    type(error_t), allocatable, intent(inout) :: error
    integer(HID_T) :: set
    integer :: status, ignored

    if (allocated(error)) return
    call h5dopen_f(file%id, name, set, status)
    if (status == 0) then
      call h5dset_extent_f(set, [int(nrow, HSIZE_T)], status)
      call h5dclose_f(set, ignored)
    end if
    if (status /= 0) call refuse(file, 'cannot write', error)
  end subroutine set_length

  !> Get the numbers of rows and columns of a dataset; ncol = 0 if it is one-dimensional.
  subroutine get_shape(file, name, ncol, nrow, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(out) :: ncol, nrow
    type(error_t), allocatable, intent(inout) :: error
    integer(HSIZE_T) :: shape(2), most(2)
    integer(HID_T) :: set, space
    integer :: n, status

    ncol = 0
    nrow = 0
    if (allocated(error)) return
    call h5dopen_f(file%id, name, set, status)
    if (status /= 0) then
      call refuse(file, 'cannot find '''//name//''' in', error)
      return
    end if
    call h5dget_space_f(set, space, status)
    call h5sget_simple_extent_ndims_f(space, n, status)
    if (n == 1 .or. n == 2) then
      call h5sget_simple_extent_dims_f(space, shape(1:n), most(1:n), status)
      if (all(shape(1:n) <= huge(n))) then
        nrow = int(shape(n))
        if (n == 2) ncol = int(shape(1))
      else
        call refuse(file, 'cannot handle the size of '''//name//''' in', error)
      end if
    end if
    call h5sclose_f(space, status)
    call h5dclose_f(set, status)
  end subroutine get_shape

  !> Move rows between memory and a dataset.
  subroutine move_rows(file, name, memory, buffer, ncol, nrow, first, writes, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer(HID_T), intent(in) :: memory !! type of the numbers in memory
    type(c_ptr), intent(in) :: buffer
    integer, intent(in) :: ncol, nrow    !! ncol = 0 if one-dimensional
    integer(i8), intent(in) :: first     !! first row, counted from 1
    logical, intent(in) :: writes
    type(error_t), allocatable, intent(inout) :: error
    integer(HSIZE_T) :: shape(2), start(2)
    integer(HID_T) :: set, space, part
    type(c_ptr) :: place
    integer :: n, status, ignored

    if (nrow == 0 .or. allocated(error)) return
    call set_shape(ncol, int(nrow, i8), n, shape)
    place = buffer
    start = 0
    start(n) = int(first - 1, HSIZE_T)
    call h5dopen_f(file%id, name, set, status)
    if (status == 0) then
      call h5dget_space_f(set, space, status)
      call h5screate_simple_f(n, shape(1:n), part, status)
      call h5sselect_hyperslab_f(space, H5S_SELECT_SET_F, start(1:n), shape(1:n), status)
      if (status == 0 .and. writes) call h5dwrite_f(set, memory, place, status, part, space)
      if (status == 0 .and. .not. writes) call h5dread_f(set, memory, place, status, part, space)
      call h5sclose_f(part, ignored)
      call h5sclose_f(space, ignored)
      call h5dclose_f(set, ignored)
    end if
    if (status /= 0) then
      call refuse(file, trim(merge('cannot write', 'cannot read ', writes))//' '''//name// &
                  ''' of', error)
    end if
  end subroutine move_rows

  !> Set the rank and the extents of a dataset in the order of the library.
  pure subroutine set_shape(ncol, nrow, n, shape)
    integer, intent(in) :: ncol
    integer(i8), intent(in) :: nrow
    integer, intent(out) :: n
    integer(HSIZE_T), intent(out) :: shape(2)

    n = merge(2, 1, ncol > 0)
    shape = [int(ncol, HSIZE_T), int(nrow, HSIZE_T)]
    if (n == 1) shape(1) = shape(2)
  end subroutine set_shape

  subroutine put_real_1(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    real(wp), intent(in), target, contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_DOUBLE, c_loc(values), 0, &
                   size(values, 1), row(first), .true., error)
  end subroutine put_real_1

  subroutine put_real_2(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    real(wp), intent(in), target, contiguous :: values(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_DOUBLE, c_loc(values), size(values, 1), &
                   size(values, 2), row(first), .true., error)
  end subroutine put_real_2

  subroutine put_integer_1(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(in), target, contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_INTEGER, c_loc(values), 0, &
                   size(values, 1), row(first), .true., error)
  end subroutine put_integer_1

  subroutine get_real_1(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    real(wp), intent(out), target, contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_DOUBLE, c_loc(values), 0, &
                   size(values, 1), row(first), .false., error)
  end subroutine get_real_1

  subroutine get_real_2(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    real(wp), intent(out), target, contiguous :: values(:, :)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_DOUBLE, c_loc(values), size(values, 1), &
                   size(values, 2), row(first), .false., error)
  end subroutine get_real_2

  subroutine get_integer_1(file, name, values, error, first)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: name
    integer, intent(out), target, contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer(i8), intent(in), optional :: first

    call move_rows(file, name, H5T_NATIVE_INTEGER, c_loc(values), 0, &
                   size(values, 1), row(first), .false., error)
  end subroutine get_integer_1

  !> First row; 1 if it is not given.
  pure function row(first)
    integer(i8), intent(in), optional :: first
    integer(i8) :: row

    row = 1_i8
    if (present(first)) row = first
  end function row

end module hdf5_file
