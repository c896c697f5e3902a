!> Writes one `.vtu` file for each step whose fields are written, and a `.pvd` file that lists these
!! files. VTK shows them exactly from version 9.3 on.
!!
!! The files are XML with the numbers appended in binary. Each is written under another name and
!! renamed when it is complete.
module vtu_file
  use, intrinsic :: iso_c_binding, only: c_loc, c_size_t, c_int8_t, c_ptr
  use base_error, only: error_t
  use base_file, only: replace_file, remove_file
  use base_kinds, only: wp, i8
  use base_text, only: to_text
  use byte_file, only: byte_file_t, open_bytes, write_text, write_bytes, close_bytes, write_whole
  use fields, only: field_t
  use view, only: view_t
  implicit none
  private
  public :: vtu_series_t, open_series, append_series

  type :: vtu_series_t
    character(:), allocatable :: stem     !! folder and name of the files
    integer, allocatable :: step(:)       !! steps written
    real(wp), allocatable :: time(:)      !! times of these steps [T]
  end type vtu_series_t

  character(*), parameter :: LF = new_line('a')

contains

  !> Begin a series of files. An old series is removed, or its steps up to number `keep` are kept,
  !! and the list is shortened at once.
  subroutine open_series(series, stem, error, keep)
    type(vtu_series_t), intent(out) :: series
    character(*), intent(in) :: stem
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep
    character(1024) :: line
    integer :: unit, status, step, last
    real(wp) :: time
    logical :: shortened

    series%stem = stem
    shortened = .false.
    allocate (series%step(0), series%time(0))
    last = -1
    if (present(keep)) last = keep
    open (newunit=unit, file=stem//'.pvd', action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      call read_entry(line, step, time, status)
      if (status /= 0) cycle
      if (step <= last) then
        series%step = [series%step, step]
        series%time = [series%time, time]
      else
        call remove_file(file_name(stem, step))
        shortened = .true.
      end if
    end do
    close (unit)
    if (size(series%step) == 0) then
      call remove_file(stem//'.pvd')
    else if (shortened) then
      call write_list(series, error)
    end if
  end subroutine open_series

  !> Read the step and the time in a line of a `.pvd` file that this module wrote.
  subroutine read_entry(line, step, time, status)
    character(*), intent(in) :: line
    integer, intent(out) :: step
    real(wp), intent(out) :: time
    integer, intent(out) :: status !! 0: the line names a step
    integer :: i, j

    status = 1
    step = 0
    time = 0.0_wp
    i = index(line, 'timestep="')
    j = index(line, '.vtu"')
    if (i == 0 .or. j == 0) return
    read (line(i + 10:i + 9 + index(line(i + 10:), '"') - 1), *, iostat=status) time
    if (status /= 0) return
    i = index(line(:j), '_', back=.true.)
    ! allow(C181): the caller looks at the status
    read (line(i + 1:j - 1), *, iostat=status) step
  end subroutine read_entry

  !> Write a step and add it to the list. It replaces steps of the same or a higher number.
  subroutine append_series(series, view, xr, step, time, field, error)
    type(vtu_series_t), intent(inout) :: series
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :)     !! (3, npoint) reference positions of the points [L]
    integer, intent(in) :: step
    real(wp), intent(in) :: time
    type(field_t), intent(in) :: field(:)
    type(error_t), allocatable, intent(out) :: error
    type(byte_file_t) :: file
    character(:), allocatable :: path
    integer :: i

    path = file_name(series%stem, step)
    call open_bytes(file, path//'.part', .false., error)
    if (allocated(error)) return
    call write_text(file, header(view, field), error)
    if (.not. allocated(error)) call write_numbers(file, view, xr, field, error)
    if (.not. allocated(error)) then
      call write_text(file, LF//'</AppendedData>'//LF//'</VTKFile>'//LF, error)
    end if
    if (.not. allocated(error)) call close_bytes(file, error)
    if (.not. allocated(error)) call replace_file(path//'.part', path, error)
    if (allocated(error)) then
      call remove_file(path//'.part')
      return
    end if
    do i = 1, size(series%step)
      if (series%step(i) > step) call remove_file(file_name(series%stem, series%step(i)))
    end do
    series%time = [pack(series%time, series%step < step), time]
    series%step = [pack(series%step, series%step < step), step]
    call write_list(series, error)
  end subroutine append_series

  !> Write the list of the files. It names them without their folder, so that results can be moved.
  subroutine write_list(series, error)
    type(vtu_series_t), intent(in) :: series
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: path, text
    character(32) :: number
    integer :: i

    text = '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">'//LF// &
           '<Collection>'//LF
    do i = 1, size(series%step)
      path = file_name(series%stem, series%step(i))
      write (number, '(es23.16)') series%time(i)
      text = text//'<DataSet timestep="'//trim(adjustl(number))//'" part="0" file="'// &
             escaped(path(index(path, '/', back=.true.) + 1:))//'"/>'//LF
    end do
    text = text//'</Collection>'//LF//'</VTKFile>'//LF
    call write_whole(series%stem//'.pvd', text, error)
  end subroutine write_list

  !> The XML part of a file. The arrays have the order of write_numbers.
  function header(view, field) result(text)
    type(view_t), intent(in) :: view
    type(field_t), intent(in) :: field(:)
    character(:), allocatable :: text
    integer(i8) :: place
    integer :: i

    place = 0
    text = '<VTKFile type="UnstructuredGrid" version="'// & ! Bezier cells need 2.2
           merge('2.2', '1.0', view%has_bezier)//'" byte_order="LittleEndian" '// &
           'header_type="UInt64">'//LF//'<UnstructuredGrid>'//LF//'<Piece NumberOfPoints="'// &
           to_text(view%npoint)//'" NumberOfCells="'// &
           to_text(view%ncell)//'">'//LF//'<Points>'//LF// &
           array('Float64', 'Points', 3, 24_i8*view%npoint, place)// &
           '</Points>'//LF//'<Cells>'//LF
    text = text//array('Int32', 'connectivity', 1, 4_i8*size(view%conn), place)
    text = text//array('Int32', 'offsets', 1, 4_i8*view%ncell, place)
    text = text//array('UInt8', 'types', 1, int(view%ncell, i8), place)//'</Cells>'//LF
    text = text//'<PointData'//active('RationalWeights', view%has_bezier)//'>'//LF
    if (view%has_bezier) then
      text = text//array('Float64', 'RationalWeights', 1, 8_i8*view%npoint, place)
    end if
    do i = 1, size(field)
      text = text//array('Float64', trim(field(i)%name), field(i)%ncomp, &
                         8_i8*field(i)%ncomp*view%npoint, place)
    end do
    text = text//'</PointData>'//LF//'<CellData'// &
           active('HigherOrderDegrees', view%has_bezier)//'>'//LF
    if (view%has_bezier) then
      text = text//array('Float64', 'HigherOrderDegrees', 3, 24_i8*view%ncell, place)
    end if
    text = text//array('Int32', 'material', 1, 4_i8*view%ncell, place)
    text = text//array('Int32', 'body', 1, 4_i8*view%ncell, place)
    text = text//array('Int32', 'type', 1, 4_i8*view%ncell, place)
    text = text//array('Int32', 'element', 1, 4_i8*view%ncell, place)
    text = text//'</CellData>'//LF//'</Piece>'//LF//'</UnstructuredGrid>'//LF// &
           '<AppendedData encoding="raw">'//LF//'_'
  end function header

  !> Description of one array of the header. `place` advances by the bytes of the array and the
  !! eight bytes of its length.
  function array(type, name, ncomp, bytes, place) result(text)
    character(*), intent(in) :: type, name
    integer, intent(in) :: ncomp
    integer(i8), intent(in) :: bytes
    integer(i8), intent(inout) :: place
    character(:), allocatable :: text

    text = '<DataArray type="'//type//'" Name="'//name//'" NumberOfComponents="'// &
           to_text(ncomp)//'" format="appended" offset="'//to_text(place)// &
           '"/>'//LF
    place = place + bytes + 8
  end function array

  !> Write the binary part of a file.
  subroutine write_numbers(file, view, xr, field, error)
    type(byte_file_t), intent(in) :: file
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :)
    type(field_t), intent(in) :: field(:)
    type(error_t), allocatable, intent(out) :: error
    integer(c_int8_t), allocatable, target :: types(:)
    integer :: i

    allocate (types(view%ncell))
    types(:) = int(view%vtk, c_int8_t)
    call write_reals(file, reshape(xr, [size(xr)]), error)
    if (.not. allocated(error)) call write_integers(file, view%conn - 1, error)
    if (.not. allocated(error)) call write_integers(file, view%first(2:) - 1, error)
    if (.not. allocated(error)) call write_block(file, c_loc(types), size(types, kind=i8), error)
    if (view%has_bezier .and. .not. allocated(error)) then
      call write_reals(file, view%point%weight, error)
    end if
    do i = 1, size(field)
      if (allocated(error)) return
      call write_reals(file, reshape(field(i)%values, [size(field(i)%values)]), error)
    end do
    if (view%has_bezier .and. .not. allocated(error)) then
      call write_reals(file, reshape(real(view%degree, wp), [3*view%ncell]), error)
    end if
    if (.not. allocated(error)) call write_integers(file, view%material, error)
    if (.not. allocated(error)) call write_integers(file, view%body, error)
    if (.not. allocated(error)) call write_integers(file, view%block, error)
    if (.not. allocated(error)) call write_integers(file, view%element, error)
  end subroutine write_numbers

  !> Write the length of an array in bytes, and the array.
  subroutine write_block(file, buffer, bytes, error)
    type(byte_file_t), intent(in) :: file
    type(c_ptr), intent(in) :: buffer
    integer(i8), intent(in) :: bytes
    type(error_t), allocatable, intent(out) :: error
    integer(i8), target :: length

    length = bytes
    call write_bytes(file, c_loc(length), 8_c_size_t, error)
    if (.not. allocated(error)) call write_bytes(file, buffer, int(bytes, c_size_t), error)
  end subroutine write_block

  subroutine write_reals(file, values, error)
    type(byte_file_t), intent(in) :: file
    real(wp), intent(in), target, contiguous :: values(:)
    type(error_t), allocatable, intent(out) :: error

    call write_block(file, c_loc(values), 8_i8*size(values), error)
  end subroutine write_reals

  subroutine write_integers(file, values, error)
    type(byte_file_t), intent(in) :: file
    integer, intent(in), target, contiguous :: values(:)
    type(error_t), allocatable, intent(out) :: error

    call write_block(file, c_loc(values), 4_i8*size(values), error)
  end subroutine write_integers

  function file_name(stem, step) result(name)
    character(*), intent(in) :: stem
    integer, intent(in) :: step
    character(:), allocatable :: name
    character(12) :: number

    write (number, '(i0.4)') step
    name = stem//'_'//trim(number)//'.vtu'
  end function file_name

  !> Attribute that marks an array as the active one; empty if it is not.
  pure function active(name, is_active) result(text)
    character(*), intent(in) :: name
    logical, intent(in) :: is_active
    character(:), allocatable :: text

    text = ''
    if (is_active) text = ' '//name//'="'//name//'"'
  end function active

  !> Text in which the characters that XML reserves are replaced.
  pure function escaped(text) result(xml)
    character(*), intent(in) :: text
    character(:), allocatable :: xml
    integer :: i

    xml = ''
    do i = 1, len(text)
      select case (text(i:i))
      case ('&')
        xml = xml//'&amp;'
      case ('<')
        xml = xml//'&lt;'
      case ('"')
        xml = xml//'&quot;'
      case default
        xml = xml//text(i:i)
      end select
    end do
  end function escaped

end module vtu_file
