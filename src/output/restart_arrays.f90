!> Arrays and numbered names of a checkpoint.
module restart_arrays
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use hdf5_file, only: hdf5_t, reserve, put, get, get_shape, AS_REAL
  implicit none
  private
  public :: write_reals, read_reals, write_integers, read_integers, write_matrix, read_matrix, name

contains

  subroutine write_reals(file, path, values, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), intent(in), contiguous :: values(:)
    type(error_t), allocatable, intent(out) :: error

    call reserve(file, path, AS_REAL, 0, size(values, kind=i8), error)
    if (.not. allocated(error)) call put(file, path, values, error)
  end subroutine write_reals

  subroutine write_integers(file, path, values, kind, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in), contiguous :: values(:)
    integer, intent(in) :: kind
    type(error_t), allocatable, intent(out) :: error

    call reserve(file, path, kind, 0, size(values, kind=i8), error)
    if (.not. allocated(error)) call put(file, path, values, error)
  end subroutine write_integers

  !> A matrix without rows or columns is not stored.
  subroutine write_matrix(file, path, values, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), intent(in), contiguous :: values(:, :)
    type(error_t), allocatable, intent(out) :: error

    if (size(values) == 0) return
    call reserve(file, path, AS_REAL, size(values, 1), size(values, 2, i8), error)
    if (.not. allocated(error)) call put(file, path, values, error)
  end subroutine write_matrix

  subroutine read_reals(file, path, values, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), allocatable, intent(inout) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: ncol, nrow

    call get_shape(file, path, ncol, nrow, error)
    if (allocated(error)) return
    if (allocated(values)) deallocate (values)
    allocate (values(nrow))
    call get(file, path, values, error)
  end subroutine read_reals

  subroutine read_integers(file, path, values, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, allocatable, intent(inout) :: values(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: ncol, nrow

    call get_shape(file, path, ncol, nrow, error)
    if (allocated(error)) return
    if (allocated(values)) deallocate (values)
    allocate (values(nrow))
    call get(file, path, values, error)
  end subroutine read_integers

  !> The shape must be as expected.
  subroutine read_matrix(file, path, values, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), intent(inout), contiguous :: values(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer :: ncol, nrow

    if (size(values) == 0) return
    call get_shape(file, path, ncol, nrow, error)
    if (allocated(error)) return
    if (ncol /= size(values, 1) .or. nrow /= size(values, 2)) then
      call fail(error, SYSTEM_ERROR, 'damaged')
    else
      call get(file, path, values, error)
    end if
  end subroutine read_matrix

  pure function name(stem, k)
    character(*), intent(in) :: stem
    integer, intent(in) :: k
    character(:), allocatable :: name
    character(12) :: digits

    write (digits, '("_", i0)') k
    name = stem//trim(digits)
  end function name

end module restart_arrays
