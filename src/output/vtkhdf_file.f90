!> The result file `<stem>.vtkhdf`: fields of all selected steps on one geometry.
!!
!! A step is written into space that the file has allocated, handed to the operating system, and
!! only then counted (NSteps). A run that is killed at any moment leaves all earlier steps readable.
!! When the space is used up, a file with twice the space is written next to the old file and takes
!! the name of the old file. Closing the file releases the unused space; a restart keeps the steps
!! up to its checkpoint.
module vtkhdf_file
  use base_error, only: error_t, fail, SYSTEM_ERROR, DECK_ERROR
  use base_file, only: replace_file, remove_file
  use base_kinds, only: wp, i8
  use base_text, only: to_text
  use fields, only: field_t, describe_field, known_fields
  use hdf5_file, only: hdf5_t, create_file, open_file, close_file, flush_file, has_object, put, &
                       get, put_attribute, get_attribute, set_length
  use view, only: view_t
  use vtkhdf_layout, only: run_info_t, write_layout
  implicit none
  private
  public :: vtkhdf_t, run_info_t, open_vtkhdf, append_vtkhdf, close_vtkhdf, read_steps

  integer, parameter :: FIRST_ROOM = 8 !! steps for which a new file has space

  type :: vtkhdf_t
    character(:), allocatable :: path
    type(run_info_t) :: info
    real(wp), allocatable :: xr(:, :)           !! (3, npoint) reference positions of the points [L]
    character(16), allocatable :: names(:)      !! fields; set by the first step or an old file
    integer :: nstep = 0, room = 0  !! steps in the file, and steps for which it has space
    integer, allocatable :: number(:)           !! (nstep) step numbers of the analysis
  end type vtkhdf_t

contains

  !> Begin a result. The file is created with the first step. An old file is removed, or its steps
  !! up to number `keep` are kept.
  subroutine open_vtkhdf(result, path, view, xr, info, error, keep, wanted)
    type(vtkhdf_t), intent(out) :: result
    character(*), intent(in) :: path
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :) !! (3, npoint)
    type(run_info_t), intent(in) :: info
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep
    character(*), intent(in), optional :: wanted(:) !! fields that the kept steps must have
    logical :: exists

    result%path = path
    result%info = info
    result%xr = xr
    allocate (result%number(0))
    inquire (file=path, exist=exists)
    if (.not. exists) return
    if (present(keep)) then
      call continue_file(result, view, keep, error, wanted)
    else
      call remove_file(path)
    end if
  end subroutine open_vtkhdf

  !> Continue an old file: find its fields and the steps to keep, and drop the others.
  subroutine continue_file(result, view, keep, error, wanted)
    type(vtkhdf_t), intent(inout) :: result
    type(view_t), intent(in) :: view
    integer, intent(in) :: keep
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in), optional :: wanted(:)
    type(error_t), allocatable :: second
    type(hdf5_t) :: file
    character(16) :: known(size(known_fields()))
    integer, allocatable :: number(:)
    integer :: i, n(1), npoint(1)
    logical :: stored(size(known))

    call open_file(file, result%path, .false., error)
    if (allocated(error)) return
    call get(file, 'VTKHDF/NumberOfPoints', npoint, error)
    call get_attribute(file, 'VTKHDF/Steps', 'NSteps', n, error)
    allocate (number(n(1)))
    call get(file, 'VTKHDF/Steps/StepNumber', number, error)
    known = known_fields()
    do i = 1, size(known)
      stored(i) = has_object(file, 'VTKHDF/PointData/'//trim(known(i)))
    end do
    call close_file(file, second)
    if (allocated(error)) return
    if (npoint(1) /= view%npoint) then
      call fail(error, SYSTEM_ERROR, ''''//result%path//''' belongs to another mesh', &
                hint='restart with another --name, or in another folder')
      return
    end if
    result%nstep = count(number <= keep)
    result%number = number(:result%nstep)
    if (result%nstep == 0) then
      call remove_file(result%path)
      return
    end if
    result%names = pack(known, stored)
    if (present(wanted)) then
      if (.not. same_names(wanted, result%names)) then
        call fail(error, DECK_ERROR, ''''//result%path//''' contains the fields'// &
                  listed(result%names)//' up to step '//to_text(result%number(result%nstep))// &
                  ', but OUTPut names'//listed(wanted), hint='name the same fields, or restart ' &
                  //'with another --name, because a result file has the same fields in all steps')
        return
      end if
    end if
    call rebuild(result, view, max(FIRST_ROOM, 2*result%nstep), error)
  end subroutine continue_file

  pure logical function same_names(one, other)
    character(*), intent(in) :: one(:), other(:)

    same_names = size(one) == size(other)
    if (same_names) same_names = all(one == other)
  end function same_names

  pure function listed(names) result(text)
    character(*), intent(in) :: names(:)
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(names)
      text = text//' '//trim(names(i))
    end do
  end function listed

  !> Read the numbers and times of the steps of an old file; there are none if it cannot be read.
  subroutine read_steps(path, number, time)
    character(*), intent(in) :: path
    integer, allocatable, intent(out) :: number(:)
    real(wp), allocatable, intent(out) :: time(:) !! [T]
    type(error_t), allocatable :: error, ignored
    type(hdf5_t) :: file
    integer :: n(1)
    logical :: exists

    n = 0
    inquire (file=path, exist=exists)
    if (exists) call open_file(file, path, .false., error)
    if (exists .and. .not. allocated(error)) then
      call get_attribute(file, 'VTKHDF/Steps', 'NSteps', n, error)
      if (allocated(error)) n = 0
      allocate (number(n(1)), time(n(1)))
      call get(file, 'VTKHDF/Steps/StepNumber', number, error)
      call get(file, 'VTKHDF/Steps/Values', time, error)
      call close_file(file, ignored)
      if (.not. allocated(error)) return
      deallocate (number, time)
    end if
    allocate (number(0), time(0))
  end subroutine read_steps

  !> Write a step. It replaces steps of the same or a higher number, which a repeated run wrote.
  subroutine append_vtkhdf(result, view, step, time, field, error)
    type(vtkhdf_t), intent(inout) :: result
    type(view_t), intent(in) :: view
    integer, intent(in) :: step
    real(wp), intent(in) :: time
    type(field_t), intent(in) :: field(:)
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(hdf5_t) :: file
    integer :: k

    if (.not. allocated(result%names)) result%names = field%name
    if (.not. same_names(field%name, result%names)) then
      call fail(error, DECK_ERROR, 'the fields of a result file cannot change after its first ' &
                //'step', hint='put OUTPut with all fields before the first PLOT; a restarted ' &
                //'run must write the fields of the old file')
      return
    end if
    k = count(result%number < step) + 1
    if (k > result%room) call rebuild(result, view, max(FIRST_ROOM, 2*result%room), error)
    if (.not. allocated(error)) call open_file(file, result%path, .true., error)
    if (allocated(error)) return
    call write_step(file, result%names, view%npoint, k, step, time, field, error)
    if (allocated(error)) then
      call close_file(file, second)
    else
      call close_file(file, error)
      result%nstep = k
      result%number = [result%number(:k - 1), step]
    end if
  end subroutine append_vtkhdf

  !> Release the space that was not used. If this fails, no step is lost.
  subroutine close_vtkhdf(result, view, error)
    type(vtkhdf_t), intent(inout) :: result
    type(view_t), intent(in) :: view
    type(error_t), allocatable, intent(out) :: error

    if (result%nstep > 0 .and. result%nstep < result%room) then
      call rebuild(result, view, result%nstep, error)
    end if
  end subroutine close_vtkhdf

  !> Write a new file with space for `room` steps and copy the steps of the old one.
  subroutine rebuild(result, view, room, error)
    type(vtkhdf_t), intent(inout) :: result
    type(view_t), intent(in) :: view
    integer, intent(in) :: room
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: second
    type(field_t), allocatable :: field(:)
    type(hdf5_t) :: old, new
    character(:), allocatable :: part, path
    integer(i8) :: first
    integer :: i, k, step(1)
    real(wp) :: time(1)

    part = result%path//'.part'
    call create_file(new, part, error)
    if (.not. allocated(error)) then
      call write_layout(new, view, result%xr, result%info, result%names, room, error)
    end if
    if (result%nstep > 0 .and. .not. allocated(error)) then
      allocate (field(size(result%names)))
      do i = 1, size(field)
        call describe_field(trim(result%names(i)), field(i))
        allocate (field(i)%values(field(i)%ncomp, view%npoint))
      end do
      call open_file(old, result%path, .false., error)
      do k = 1, result%nstep
        first = int(k - 1, i8)*view%npoint + 1
        do i = 1, size(field)
          path = 'VTKHDF/PointData/'//trim(field(i)%name)
          if (field(i)%ncomp == 1) then
            call get(old, path, field(i)%values(1, :), error, first)
          else
            call get(old, path, field(i)%values, error, first)
          end if
        end do
        call get(old, 'VTKHDF/Steps/Values', time, error, int(k, i8))
        call get(old, 'VTKHDF/Steps/StepNumber', step, error, int(k, i8))
        call write_step(new, result%names, view%npoint, k, step(1), time(1), field, error)
        if (allocated(error)) exit
      end do
      call close_file(old, second)
    end if
    if (allocated(error)) then
      call close_file(new, second)
    else
      call close_file(new, error)
    end if
    if (.not. allocated(error)) call replace_file(part, result%path, error)
    if (allocated(error)) call remove_file(part)
    if (.not. allocated(error)) result%room = room
  end subroutine rebuild

  !> Write the values of a step to their place in the file. A single write then adds the step to the
  !! count (see vtkhdf_layout).
  subroutine write_step(file, names, npoint, k, step, time, field, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: names(:)
    integer, intent(in) :: npoint
    integer, intent(in) :: k    !! position of the step, counted from 1
    integer, intent(in) :: step
    real(wp), intent(in) :: time
    type(field_t), intent(in) :: field(:)
    type(error_t), allocatable, intent(inout) :: error
    character(*), parameter :: GROUP = 'VTKHDF/Steps'
    character(:), allocatable :: path
    integer(i8) :: first
    integer :: i

    first = int(k - 1, i8)*npoint + 1
    do i = 1, size(names)
      path = 'VTKHDF/PointData/'//trim(names(i))
      if (field(i)%ncomp == 1) then
        call put(file, path, field(i)%values(1, :), error, first)
      else
        call put(file, path, field(i)%values, error, first)
      end if
    end do
    call put(file, GROUP//'/StepNumber', [step], error, int(k, i8))
    call flush_file(file, error)
    call put_attribute(file, GROUP, 'NSteps', [k], error)
    call set_length(file, GROUP//'/Values', int(k, i8), error)
    call put(file, GROUP//'/Values', [time], error, int(k, i8))
  end subroutine write_step

end module vtkhdf_file
