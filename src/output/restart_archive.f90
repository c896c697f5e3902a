!> Transfers values to and from a checkpoint, so that one list of names serves both directions.
!!
!! The rule for `error` is that of `hdf5_object`: a call that finds `error` allocated does nothing.
module restart_archive
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_hash, only: hash_t
  use base_text, only: to_text
  use hdf5_file, only: hdf5_t, make_group, reserve, put, get, get_shape, &
                       put_attribute, get_attribute, AS_REAL, AS_INT32, AS_UINT8
  use named_values, only: named_values_t, put_value => put, REAL_VALUE, INTEGER_VALUE, TEXT_VALUE
  implicit none
  private
  public :: archive_t, exchange, exchange_list, enter_group, numbered

  type :: archive_t
    type(hdf5_t) :: file
    logical :: writes = .true.
  end type archive_t

  !> exchange(archive, path, value, error) writes a value, or reads it if the archive is being read.
  !! Arrays have the sizes of the model; it is an error if the size in the file is different.
  interface exchange
    module procedure exchange_real, exchange_integer, exchange_logical, exchange_reals, &
      exchange_integers, exchange_logicals, exchange_matrix, exchange_values
  end interface exchange

contains

  !> Create a group if the archive is being written.
  subroutine enter_group(archive, path, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(inout) :: error

    if (archive%writes) call make_group(archive%file, path, error)
  end subroutine enter_group

  subroutine exchange_real(archive, path, value, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    real(wp), intent(inout) :: value
    type(error_t), allocatable, intent(inout) :: error
    real(wp) :: list(1)

    list = value
    call exchange_reals(archive, path, list, error)
    value = list(1)
  end subroutine exchange_real

  subroutine exchange_integer(archive, path, value, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    integer, intent(inout) :: value
    type(error_t), allocatable, intent(inout) :: error
    integer :: list(1)

    list = value
    call exchange_integers(archive, path, list, error)
    value = list(1)
  end subroutine exchange_integer

  subroutine exchange_logical(archive, path, value, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    logical, intent(inout) :: value
    type(error_t), allocatable, intent(inout) :: error
    logical :: list(1)

    list = value
    call exchange_logicals(archive, path, list, error)
    value = list(1)
  end subroutine exchange_logical

  subroutine exchange_reals(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    real(wp), intent(inout), contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error

    if (size(values) == 0) return
    call prepare(archive, path, AS_REAL, 0, size(values), error)
    if (archive%writes) then
      call put(archive%file, path, values, error)
    else if (.not. allocated(error)) then
      call get(archive%file, path, values, error)
    end if
    call sum_reals(archive, path, values, error)
  end subroutine exchange_reals

  subroutine exchange_integers(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    integer, intent(inout), contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error

    if (size(values) == 0) return
    call prepare(archive, path, AS_INT32, 0, size(values), error)
    if (archive%writes) then
      call put(archive%file, path, values, error)
    else if (.not. allocated(error)) then
      call get(archive%file, path, values, error)
    end if
    call sum_integers(archive, path, values, error)
  end subroutine exchange_integers

  subroutine exchange_logicals(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    logical, intent(inout) :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer :: numbers(size(values))

    numbers = merge(1, 0, values)
    call exchange_integers(archive, path, numbers, error)
    values = numbers == 1
  end subroutine exchange_logicals

  subroutine exchange_matrix(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    real(wp), intent(inout), contiguous :: values(:, :)
    type(error_t), allocatable, intent(inout) :: error

    if (size(values) == 0) return
    call prepare(archive, path, AS_REAL, size(values, 1), size(values, 2), error)
    if (archive%writes) then
      call put(archive%file, path, values, error)
    else if (.not. allocated(error)) then
      call get(archive%file, path, values, error)
    end if
    call sum_reals(archive, path, pack(values, .true.), error)
  end subroutine exchange_matrix

  !> Exchange a list. When it is read, its length comes from the file. If a list is not allocated,
  !! only the length -1 is stored.
  subroutine exchange_list(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    real(wp), allocatable, intent(inout) :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    integer :: length

    length = -1
    if (allocated(values)) length = size(values)
    call exchange(archive, path//'_length', length, error)
    if (allocated(error)) return
    if (.not. archive%writes) then
      if (allocated(values)) deallocate (values)
      if (length >= 0) allocate (values(length), source=0.0_wp)
    end if
    if (length > 0) call exchange(archive, path, values, error)
  end subroutine exchange_list

  !> Exchange named values. They are numbered in the file, because their names are free text.
  subroutine exchange_values(archive, group, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(named_values_t), intent(inout) :: values
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: path, name, text
    real(wp), allocatable :: reals(:)
    integer, allocatable :: integers(:)
    integer, parameter :: MOST = 10000 !! largest number of values
    integer, parameter :: BYTE = 255   !! largest number of a character, as in UTF-8
    integer :: i, k, count(1), ncol, nrow, type(1)

    call enter_group(archive, group, error)
    count = values%n
    if (archive%writes) then
      call put_attribute(archive%file, group, 'count', count, error)
    else
      call get_attribute(archive%file, group, 'count', count, error)
      if (count(1) < 0 .or. count(1) > MOST) call refuse_value(group, error)
    end if
    if (allocated(error)) return
    do k = 1, count(1)
      path = group//numbered('/value', k)
      if (archive%writes) then
        associate (value => values%value(k))
          select case (value%type)
          case (REAL_VALUE)
            call reserve(archive%file, path, AS_REAL, 0, size(value%reals, kind=i8), error)
            call put(archive%file, path, value%reals, error)
            call sum_reals(archive, path, value%reals, error)
          case (INTEGER_VALUE)
            call reserve(archive%file, path, AS_INT32, 0, size(value%integers, kind=i8), error)
            call put(archive%file, path, value%integers, error)
            call sum_integers(archive, path, value%integers, error)
          case default
            integers = [(iand(iachar(value%text(i:i)), BYTE), i=1, len(value%text))]
            call reserve(archive%file, path, AS_UINT8, 0, size(integers, kind=i8), error)
            call put(archive%file, path, integers, error)
            call sum_integers(archive, path, integers, error)
          end select
          call put_attribute(archive%file, path, 'name', value%name, error)
          call put_attribute(archive%file, path, 'type', [value%type], error)
        end associate
      else
        call get_attribute(archive%file, path, 'name', name, error)
        call get_attribute(archive%file, path, 'type', type, error)
        call get_shape(archive%file, path, ncol, nrow, error)
        if (all(type(1) /= [REAL_VALUE, INTEGER_VALUE, TEXT_VALUE])) call refuse_value(path, error)
        if (allocated(error)) return
        select case (type(1))
        case (REAL_VALUE)
          reals = spread(0.0_wp, 1, nrow)
          call get(archive%file, path, reals, error)
          call sum_reals(archive, path, reals, error)
          call put_value(values, name, reals)
        case default
          integers = spread(0, 1, nrow)
          call get(archive%file, path, integers, error)
          call sum_integers(archive, path, integers, error)
          if (any(integers < 0 .or. integers > BYTE) .and. type(1) == TEXT_VALUE) then
            call refuse_value(path, error)
          end if
          if (allocated(error)) return
          if (type(1) == INTEGER_VALUE) then
            call put_value(values, name, integers)
          else
            text = repeat(' ', nrow)
            do i = 1, nrow
              text(i:i) = char(integers(i))
            end do
            call put_value(values, name, text)
          end if
        end select
      end if
    end do
  end subroutine exchange_values

  !> Store the checksum of a dataset, or compare it with the values that were read.
  subroutine sum_reals(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    real(wp), intent(in) :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    type(hash_t) :: hash

    if (allocated(error)) return
    call hash%add(values)
    call check_sum(archive, path, hash, error)
  end subroutine sum_reals

  subroutine sum_integers(archive, path, values, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    integer, intent(in) :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    type(hash_t) :: hash

    if (allocated(error)) return
    call hash%add(values)
    call check_sum(archive, path, hash, error)
  end subroutine sum_integers

  !> Store a checksum or compare it with the stored one. It includes the path of the dataset without
  !! the first group, because the group `last` of a checkpoint is later copied to `before`.
  subroutine check_sum(archive, path, hash, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    type(hash_t), intent(inout) :: hash
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: found

    call hash%add(path(index(path, '/') + 1:))
    if (archive%writes) then
      call put_attribute(archive%file, path, 'checksum', hash%digits(), error)
    else
      call get_attribute(archive%file, path, 'checksum', found, error)
      if (found /= hash%digits() .and. .not. allocated(error)) call refuse_value(path, error)
    end if
  end subroutine check_sum

  subroutine refuse_value(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(inout) :: error

    if (.not. allocated(error)) call fail(error, SYSTEM_ERROR, ''''//path//''' is damaged')
  end subroutine refuse_value

  !> Create a dataset, or check the shape of an existing one.
  subroutine prepare(archive, path, type, ncol, nrow, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: path
    integer, intent(in) :: type, ncol, nrow !! see reserve
    type(error_t), allocatable, intent(inout) :: error
    integer :: found(2)

    if (archive%writes) then
      call reserve(archive%file, path, type, ncol, int(nrow, i8), error)
    else
      call get_shape(archive%file, path, found(1), found(2), error)
      if (allocated(error)) return
      if (any(found /= [ncol, nrow])) then
        call fail(error, SYSTEM_ERROR, ''''//path//''' does not match the size of the model')
      end if
    end if
  end subroutine prepare

  !> Name of item k: `stem_k`.
  pure function numbered(stem, k) result(name)
    character(*), intent(in) :: stem
    integer, intent(in) :: k
    character(:), allocatable :: name

    name = stem//'_'//to_text(k)
  end function numbered

end module restart_archive
