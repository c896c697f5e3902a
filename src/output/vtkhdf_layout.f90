!> Groups, attributes and geometry of a `.vtkhdf` file: VTKHDF 2.6, UnstructuredGrid with steps.
!!
!! The geometry is stored once; the fields have room for a number of steps, taken when the file is
!! made. The attribute NSteps says how many are there: it is the last thing a step writes.
module vtkhdf_layout
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use hdf5_file, only: hdf5_t, make_group, reserve, put, put_attribute, AS_REAL, AS_INT64, AS_UINT8
  use view, only: view_t
  use fields, only: field_t, describe_field
  implicit none
  private
  public :: run_info_t, write_layout

  integer, parameter :: LONGEST = 60000 !! text of an attribute; HDF5 holds less than 64 kB there

  !> What a result file says about its run.
  type :: run_info_t
    character(:), allocatable :: version
    character(:), allocatable :: deck  !! text of the deck
    character(:), allocatable :: title
  end type run_info_t

contains

  !> Everything but the values of the steps.
  subroutine write_layout(file, view, xr, info, names, room, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :)        !! (3, npoint) reference points of the picture
    type(run_info_t), intent(in) :: info
    character(*), intent(in) :: names(:)    !! fields
    integer, intent(in) :: room             !! steps
    type(error_t), allocatable, intent(out) :: error

    call write_root(file, info, error)
    if (.not. allocated(error)) call write_geometry(file, view, xr, error)
    if (.not. allocated(error)) call write_cell_data(file, view, error)
    if (.not. allocated(error)) call make_point_data(file, view, names, room, error)
    if (.not. allocated(error)) call write_offsets(file, view, names, room, error)
  end subroutine write_layout

  subroutine write_root(file, info, error)
    type(hdf5_t), intent(in) :: file
    type(run_info_t), intent(in) :: info
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    call put_attribute(file, '/', 'program', 'bezel', error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'version', info%version, error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'title', info%title, error)
    if (.not. allocated(error)) call put_attribute(file, '/', 'units', 'user', error)
    if (allocated(error)) return
    if (len(info%deck) <= LONGEST) then
      call put_attribute(file, '/', 'deck', info%deck, error)
    else
      call put_attribute(file, '/', 'deck', 'see dataset deck_text (bytes)', error)
      if (.not. allocated(error)) then
        call reserve(file, 'deck_text', AS_UINT8, 0, len(info%deck, i8), error)
      end if
      if (.not. allocated(error)) then
        call put(file, 'deck_text', [(iachar(info%deck(i:i)), i=1, len(info%deck))], error)
      end if
    end if
    if (.not. allocated(error)) call make_group(file, 'VTKHDF', error)
    if (.not. allocated(error)) call put_attribute(file, 'VTKHDF', 'Version', [2, 6], error)
    if (allocated(error)) return
    call put_attribute(file, 'VTKHDF', 'Type', 'UnstructuredGrid', error)
  end subroutine write_root

  subroutine write_geometry(file, view, xr, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :)
    type(error_t), allocatable, intent(out) :: error

    call write_list(file, 'VTKHDF/NumberOfPoints', [view%npoint], AS_INT64, 'points', error)
    if (allocated(error)) return
    call write_list(file, 'VTKHDF/NumberOfCells', [view%ncell], AS_INT64, 'cells', error)
    if (allocated(error)) return
    call write_list(file, 'VTKHDF/NumberOfConnectivityIds', [size(view%conn)], AS_INT64, &
                    'length of the connectivity', error)
    if (allocated(error)) return
    call write_list(file, 'VTKHDF/Connectivity', view%conn - 1, AS_INT64, 'points of the cells', &
                    error)
    if (allocated(error)) return
    call write_list(file, 'VTKHDF/Offsets', view%first - 1, AS_INT64, &
                    'where the points of a cell begin', error)
    if (allocated(error)) return
    call write_list(file, 'VTKHDF/Types', view%vtk, AS_UINT8, 'VTK cell type', error)
    if (allocated(error)) return
    call reserve(file, 'VTKHDF/Points', AS_REAL, 3, int(view%npoint, i8), error)
    if (.not. allocated(error)) call put(file, 'VTKHDF/Points', xr, error)
    if (.not. allocated(error)) then
      call describe(file, 'VTKHDF/Points', 'reference position; of a Bezier cell: control point', &
                    'L', 'point', error)
    end if
  end subroutine write_geometry

  subroutine write_cell_data(file, view, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: GROUP = 'VTKHDF/CellData'

    call make_group(file, GROUP, error)
    if (.not. allocated(error)) then
      call write_list(file, GROUP//'/material', view%material, AS_INT64, 'MATErial', error)
    end if
    if (.not. allocated(error)) then
      call write_list(file, GROUP//'/body', view%body, AS_INT64, &
                      'PATCh in the order of the deck; 0: FEAP mesh', error)
    end if
    if (.not. allocated(error)) then
      call write_list(file, GROUP//'/type', view%block, AS_INT64, &
                      'element type: '//view%type_names, error)
    end if
    if (.not. allocated(error)) then
      call write_list(file, GROUP//'/element', view%element, AS_INT64, 'element number', error)
    end if
    if (allocated(error) .or. .not. view%has_bezier) return
    call reserve(file, GROUP//'/HigherOrderDegrees', AS_REAL, 3, int(view%ncell, i8), error)
    if (.not. allocated(error)) then
      call put(file, GROUP//'/HigherOrderDegrees', real(view%degree, wp), error)
    end if
    if (.not. allocated(error)) then
      call describe(file, GROUP//'/HigherOrderDegrees', 'degrees of the cell', '-', 'cell', error)
    end if
    if (.not. allocated(error)) then
      call put_attribute(file, GROUP//'/HigherOrderDegrees', 'Attribute', 'HigherOrderDegrees', &
                         error)
    end if
  end subroutine write_cell_data

  !> Room for the fields.
  subroutine make_point_data(file, view, names, room, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    character(*), intent(in) :: names(:)
    integer, intent(in) :: room
    type(error_t), allocatable, intent(out) :: error
    type(field_t) :: field
    character(:), allocatable :: path
    integer :: i

    call make_group(file, 'VTKHDF/PointData', error)
    if (.not. allocated(error) .and. view%has_bezier) then
      path = 'VTKHDF/PointData/RationalWeights'
      call reserve(file, path, AS_REAL, 0, int(view%npoint, i8), error)
      if (.not. allocated(error)) call put(file, path, view%point%weight, error)
      if (.not. allocated(error)) then
        call describe(file, path, 'weight of the control point', '-', 'point', error)
      end if
      if (allocated(error)) return
      call put_attribute(file, path, 'Attribute', 'RationalWeights', error)
    end if
    do i = 1, size(names)
      if (allocated(error)) return
      call describe_field(trim(names(i)), field)
      path = 'VTKHDF/PointData/'//trim(names(i))
      call reserve(file, path, AS_REAL, merge(field%ncomp, 0, field%ncomp > 1), &
                   int(room, i8)*view%npoint, error)
      if (.not. allocated(error)) then
        call describe(file, path, trim(field%description), trim(field%dimension), 'point', error)
      end if
    end do
  end subroutine make_point_data

  !> Where the data of each step begin: geometry and cell data at 0, fields one after the other.
  !!
  !! The readers of VTK want as many times (Values) as steps (NSteps). Values is made right after
  !! the attribute and has none of its own: so both lie side by side in the file, and the library
  !! changes them in one write. A kill between two writes would leave one without the other.
  subroutine write_offsets(file, view, names, room, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    character(*), intent(in) :: names(:)
    integer, intent(in) :: room
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: GROUP = 'VTKHDF/Steps'
    character(*), parameter :: CELLS(5) = &
                               ['material          ', 'body              ', &
                                'type              ', 'element           ', 'HigherOrderDegrees']
    character(*), parameter :: ALWAYS(5) = &
                               ['PartOffsets          ', 'PointOffsets         ', &
                                'CellOffsets          ', 'ConnectivityIdOffsets', &
                                'NumberOfParts        ']
    integer :: i, k

    call make_group(file, GROUP, error)
    if (.not. allocated(error)) call put_attribute(file, GROUP, 'NSteps', [0], error)
    if (.not. allocated(error)) then
      call reserve(file, GROUP//'/Values', AS_REAL, 0, 1_i8, error, most=int(room, i8))
    end if
    if (.not. allocated(error)) call make_group(file, GROUP//'/PointDataOffsets', error)
    if (.not. allocated(error)) call make_group(file, GROUP//'/CellDataOffsets', error)
    if (.not. allocated(error)) then
      call write_list(file, GROUP//'/StepNumber', spread(0, 1, room), AS_INT64, &
                      'number of the step in the analysis', error)
    end if
    if (allocated(error)) return
    do i = 1, 5
      if (allocated(error)) return
      call write_starts(file, GROUP//'/'//trim(ALWAYS(i)), &
                        spread(merge(1.0_wp, 0.0_wp, i == 5), 1, room), error, table=i == 3 &
                        .or. i == 4)
    end do
    do i = 1, merge(5, 4, view%has_bezier)
      if (allocated(error)) return
      call write_starts(file, GROUP//'/CellDataOffsets/'//trim(CELLS(i)), &
                        spread(0.0_wp, 1, room), error)
    end do
    if (view%has_bezier .and. .not. allocated(error)) then
      call write_starts(file, GROUP//'/PointDataOffsets/RationalWeights', &
                        spread(0.0_wp, 1, room), error)
    end if
    do i = 1, size(names)
      if (allocated(error)) return
      call write_starts(file, GROUP//'/PointDataOffsets/'//trim(names(i)), &
                        [(real(k, wp)*view%npoint, k=0, room - 1)], error)
    end do
  end subroutine write_offsets

  !> Offsets: 64-bit integers, handed over as reals, which hold them exactly up to 2**53.
  subroutine write_starts(file, path, values, error, table)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), intent(in), contiguous :: values(:)
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: table !! a table of one column
    integer :: ncol

    ncol = 0
    if (present(table)) ncol = merge(1, 0, table)
    call reserve(file, path, AS_INT64, ncol, size(values, kind=i8), error)
    if (allocated(error)) return
    if (ncol == 1) then
      call put(file, path, reshape(values, [1, size(values)]), error)
    else
      call put(file, path, values, error)
    end if
    if (.not. allocated(error)) call describe(file, path, 'first row of a step', '-', 'step', error)
  end subroutine write_starts

  subroutine write_list(file, path, values, kind, description, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in), contiguous :: values(:)
    integer, intent(in) :: kind
    character(*), intent(in) :: description
    type(error_t), allocatable, intent(out) :: error

    call reserve(file, path, kind, 0, size(values, kind=i8), error)
    if (.not. allocated(error)) call put(file, path, values, error)
    if (.not. allocated(error)) call describe(file, path, description, '-', 'cell', error)
  end subroutine write_list

  subroutine describe(file, path, description, dimension, location, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path, description, dimension, location
    type(error_t), allocatable, intent(out) :: error

    call put_attribute(file, path, 'description', description, error)
    if (.not. allocated(error)) call put_attribute(file, path, 'dimension', dimension, error)
    if (.not. allocated(error)) call put_attribute(file, path, 'location', location, error)
  end subroutine describe

end module vtkhdf_layout
