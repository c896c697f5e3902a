!> Structure of a `.vtkhdf` file: VTKHDF 2.6, UnstructuredGrid with steps.
!!
!! The geometry is stored once. The fields have space for a number of steps, which is allocated when
!! the file is created. The attribute NSteps counts the complete steps: when a step is written, it
!! is changed last, together with the list of times.
module vtkhdf_layout
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use fields, only: field_t, describe_field
  use hdf5_file, only: hdf5_t, make_group, reserve, put, put_attribute, AS_REAL, AS_INT64, AS_UINT8
  use view, only: view_t
  implicit none
  private
  public :: run_info_t, write_layout

  !> What a result file records about the analysis that wrote it.
  type :: run_info_t
    character(:), allocatable :: version
    character(:), allocatable :: deck  !! text of the deck
    character(:), allocatable :: title
  end type run_info_t

contains

  !> Write everything except the values of the steps.
  subroutine write_layout(file, view, xr, info, names, room, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: xr(:, :)        !! (3, npoint) reference positions of the points [L]
    type(run_info_t), intent(in) :: info
    character(*), intent(in) :: names(:)    !! names of the fields
    integer, intent(in) :: room             !! number of steps
    type(error_t), allocatable, intent(out) :: error
    integer, parameter :: LONGEST = 60000 !! length of an attribute's text; HDF5 allows less than 64
    !! kB
    character(*), parameter :: CELLS = 'VTKHDF/CellData', DEGREES = CELLS//'/HigherOrderDegrees'
    character(*), parameter :: FIELDS = 'VTKHDF/PointData', WEIGHTS = FIELDS//'/RationalWeights'
    type(field_t) :: field
    character(:), allocatable :: path
    integer :: i

    call put_attribute(file, '/', 'program', 'bezel', error)
    call put_attribute(file, '/', 'version', info%version, error)
    call put_attribute(file, '/', 'title', info%title, error)
    call put_attribute(file, '/', 'units', 'user', error)
    if (len(info%deck) <= LONGEST) then
      call put_attribute(file, '/', 'deck', info%deck, error)
    else
      call put_attribute(file, '/', 'deck', 'see dataset deck_text (bytes)', error)
      call reserve(file, 'deck_text', AS_UINT8, 0, len(info%deck, i8), error)
      call put(file, 'deck_text', [(iachar(info%deck(i:i)), i=1, len(info%deck))], error)
    end if
    call make_group(file, 'VTKHDF', error)
    call put_attribute(file, 'VTKHDF', 'Version', [2, 6], error)
    call put_attribute(file, 'VTKHDF', 'Type', 'UnstructuredGrid', error)
    call write_list(file, 'VTKHDF/NumberOfPoints', [view%npoint], AS_INT64, 'points', error)
    call write_list(file, 'VTKHDF/NumberOfCells', [view%ncell], AS_INT64, 'cells', error)
    call write_list(file, 'VTKHDF/NumberOfConnectivityIds', [size(view%conn)], AS_INT64, &
                    'length of the connectivity', error)
    call write_list(file, 'VTKHDF/Connectivity', view%conn - 1, AS_INT64, 'points of the cells', &
                    error)
    call write_list(file, 'VTKHDF/Offsets', view%first - 1, AS_INT64, &
                    'where the points of a cell begin', error)
    call write_list(file, 'VTKHDF/Types', view%vtk, AS_UINT8, 'VTK cell type', error)
    call reserve(file, 'VTKHDF/Points', AS_REAL, 3, int(view%npoint, i8), error)
    call put(file, 'VTKHDF/Points', xr, error)
    call describe(file, 'VTKHDF/Points', 'reference position; of a Bezier cell: control point', &
                  'L', 'point', error)
    call make_group(file, CELLS, error)
    call write_list(file, CELLS//'/material', view%material, AS_INT64, 'MATErial', error)
    call write_list(file, CELLS//'/body', view%body, AS_INT64, &
                    'number of the body, in the order of the deck; 0: FEAP mesh', error)
    call write_list(file, CELLS//'/type', view%block, AS_INT64, 'element type: '//view%type_names, &
                    error)
    call write_list(file, CELLS//'/element', view%element, AS_INT64, 'element number', error)
    if (view%has_bezier) then
      call reserve(file, DEGREES, AS_REAL, 3, int(view%ncell, i8), error)
      call put(file, DEGREES, real(view%degree, wp), error)
      call describe(file, DEGREES, 'degrees of the cell', '-', 'cell', error)
      call put_attribute(file, DEGREES, 'Attribute', 'HigherOrderDegrees', error)
    end if
    call make_group(file, FIELDS, error)
    if (view%has_bezier) then
      call reserve(file, WEIGHTS, AS_REAL, 0, int(view%npoint, i8), error)
      call put(file, WEIGHTS, view%point%weight, error)
      call describe(file, WEIGHTS, 'weight of the control point', '-', 'point', error)
      call put_attribute(file, WEIGHTS, 'Attribute', 'RationalWeights', error)
    end if
    do i = 1, size(names)
      call describe_field(trim(names(i)), field)
      path = FIELDS//'/'//trim(names(i))
      call reserve(file, path, AS_REAL, merge(field%ncomp, 0, field%ncomp > 1), &
                   int(room, i8)*view%npoint, error)
      call describe(file, path, trim(field%description), trim(field%dimension), 'point', error)
    end do
    call write_offsets(file, view, names, room, error)
  end subroutine write_layout

  !> Write where the data of each step begin: geometry and cell data at 0, fields one step after
  !! another.
  !!
  !! The readers of VTK require as many times (dataset Values) as steps (attribute NSteps). Values
  !! is created right after NSteps and has no attributes. Both then lie side by side in the file,
  !! and the library changes them in one write. With two writes, a program that is killed between
  !! them would have changed only one of the two.
  subroutine write_offsets(file, view, names, room, error)
    type(hdf5_t), intent(in) :: file
    type(view_t), intent(in) :: view
    character(*), intent(in) :: names(:)
    integer, intent(in) :: room
    type(error_t), allocatable, intent(inout) :: error
    character(*), parameter :: GROUP = 'VTKHDF/Steps'
    character(*), parameter :: CELLS(5) = &
                               ['material          ', 'body              ', &
                                'type              ', 'element           ', 'HigherOrderDegrees']
    real(wp) :: zero(room)
    integer :: i, k

    zero = 0.0_wp
    call make_group(file, GROUP, error)
    call put_attribute(file, GROUP, 'NSteps', [0], error)
    call reserve(file, GROUP//'/Values', AS_REAL, 0, 1_i8, error, most=int(room, i8))
    call make_group(file, GROUP//'/PointDataOffsets', error)
    call make_group(file, GROUP//'/CellDataOffsets', error)
    call write_list(file, GROUP//'/StepNumber', spread(0, 1, room), AS_INT64, &
                    'number of the step in the analysis', error)
    call write_starts(file, GROUP//'/PartOffsets', zero, error)
    call write_starts(file, GROUP//'/PointOffsets', zero, error)
    call write_starts(file, GROUP//'/CellOffsets', zero, error, column=.true.)
    call write_starts(file, GROUP//'/ConnectivityIdOffsets', zero, error, column=.true.)
    call write_starts(file, GROUP//'/NumberOfParts', zero + 1.0_wp, error)
    do i = 1, merge(5, 4, view%has_bezier)
      call write_starts(file, GROUP//'/CellDataOffsets/'//trim(CELLS(i)), zero, error)
    end do
    if (view%has_bezier) then
      call write_starts(file, GROUP//'/PointDataOffsets/RationalWeights', zero, error)
    end if
    do i = 1, size(names)
      call write_starts(file, GROUP//'/PointDataOffsets/'//trim(names(i)), &
                        [(real(k, wp)*view%npoint, k=0, room - 1)], error)
    end do
  end subroutine write_offsets

  !> Write offsets, which are 64-bit integers. They are passed as reals, which hold them exactly up
  !! to 2**53.
  subroutine write_starts(file, path, values, error, column)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    real(wp), intent(in), contiguous :: values(:)
    type(error_t), allocatable, intent(inout) :: error
    logical, intent(in), optional :: column !! store a two-dimensional dataset of one column

    if (present(column)) then
      call reserve(file, path, AS_INT64, 1, size(values, kind=i8), error)
      call put(file, path, reshape(values, [1, size(values)]), error)
    else
      call reserve(file, path, AS_INT64, 0, size(values, kind=i8), error)
      call put(file, path, values, error)
    end if
    call describe(file, path, 'where a step begins; NumberOfParts: how many parts it has', '-', &
                  'step', error)
  end subroutine write_starts

  subroutine write_list(file, path, values, type, description, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in), contiguous :: values(:)
    integer, intent(in) :: type !! on disk
    character(*), intent(in) :: description
    type(error_t), allocatable, intent(inout) :: error

    call reserve(file, path, type, 0, size(values, kind=i8), error)
    call put(file, path, values, error)
    call describe(file, path, description, '-', 'cell', error)
  end subroutine write_list

  subroutine describe(file, path, description, dimension, location, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path, description, dimension, location
    type(error_t), allocatable, intent(inout) :: error

    call put_attribute(file, path, 'description', description, error)
    call put_attribute(file, path, 'dimension', dimension, error)
    call put_attribute(file, path, 'location', location, error)
  end subroutine describe

end module vtkhdf_layout
