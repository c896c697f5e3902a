!> Fields of selected steps: `<stem>.vtkhdf`, and `<stem>.pvd` with its `.vtu` files.
module result_file
  use base_error, only: error_t
  use base_file, only: remove_file
  use base_kinds, only: wp
  use fields, only: field_t, known_fields, default_fields, collect_fields
  use model, only: model_t, state_t
  use program_version, only: VERSION
  use view, only: view_t, build_view, map_field
  use vtkhdf_file, only: vtkhdf_t, run_info_t, open_vtkhdf, append_vtkhdf, close_vtkhdf, read_steps
  use vtu_file, only: vtu_series_t, open_series, append_series
  implicit none
  private
  public :: result_file_t, open_result, choose_fields, write_result, close_result, remove_result, &
            find_steps

  type :: result_file_t
    type(view_t) :: view
    type(vtkhdf_t) :: hdf
    type(vtu_series_t) :: series
    character(16), allocatable :: names(:) !! fields, in the order of known_fields
  end type result_file_t

contains

  !> Build the view. The files are created with the first step. Old files of that name are removed;
  !! a restarted run keeps their steps up to number `keep`.
  subroutine open_result(result, stem, model, deck_text, error, keep)
    type(result_file_t), intent(inout) :: result !! its fields may have been chosen before
    character(*), intent(in) :: stem             !! folder and name
    type(model_t), intent(in) :: model
    character(*), intent(in) :: deck_text
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: keep        !! last step that is kept
    type(run_info_t) :: info
    real(wp), allocatable :: xr(:, :)

    info%version = VERSION
    info%deck = deck_text
    info%title = ''
    if (allocated(model%title)) info%title = model%title
    call build_view(model, result%view)
    allocate (xr(3, result%view%npoint))
    call map_field(result%view, model%mesh%xr, xr)
    call open_vtkhdf(result%hdf, stem//'.vtkhdf', result%view, xr, info, error, keep, result%names)
    if (allocated(error)) return
    call open_series(result%series, stem, error, keep)
    if (allocated(error)) return
    if (allocated(result%hdf%names)) result%names = result%hdf%names
  end subroutine open_result

  !> Remove the fields that an earlier run left under a name.
  subroutine remove_result(stem)
    character(*), intent(in) :: stem !! folder and name
    type(vtu_series_t) :: series
    type(error_t), allocatable :: ignored ! nothing is written

    call open_series(series, stem, ignored)
    call remove_file(stem//'.vtkhdf')
  end subroutine remove_result

  !> Find the steps whose fields an earlier run left under a name, in either kind of file.
  subroutine find_steps(stem, number, time)
    character(*), intent(in) :: stem !! folder and name
    integer, allocatable, intent(out) :: number(:)
    real(wp), allocatable, intent(out) :: time(:) !! [T]
    type(vtu_series_t) :: series
    type(error_t), allocatable :: ignored ! nothing is written

    call read_steps(stem//'.vtkhdf', number, time)
    call open_series(series, stem, ignored, huge(1)) ! keeps all steps
    number = [number, series%step]
    time = [time, series%time]
  end subroutine find_steps

  !> Choose the fields that OUTPut names, or the default fields of the model if it names none. This
  !! must precede the first call of write_result.
  subroutine choose_fields(result, chosen)
    type(result_file_t), intent(inout) :: result
    logical, intent(in) :: chosen(:) !! which of known_fields are chosen

    if (allocated(result%names)) deallocate (result%names)
    if (any(chosen)) result%names = pack(known_fields(), chosen)
  end subroutine choose_fields

  !> Write a step to both kinds of file. It replaces steps of the same or a higher number.
  subroutine write_result(result, model, state, error)
    type(result_file_t), intent(inout) :: result
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    type(field_t), allocatable :: field(:)

    if (.not. allocated(result%names)) then ! there is no OUTPut, or one without fields
      if (allocated(result%hdf%names)) then
        result%names = result%hdf%names
      else
        result%names = default_fields(model)
      end if
    end if
    call collect_fields(model, state, result%view, result%names, field)
    call append_vtkhdf(result%hdf, result%view, state%step, state%time, field, error)
    if (allocated(error)) return
    call append_series(result%series, result%view, result%hdf%xr, state%step, state%time, field, &
                       error)
  end subroutine write_result

  !> Finish the files. It is called once at the end of a run, however the run ends.
  subroutine close_result(result, error)
    type(result_file_t), intent(inout) :: result
    type(error_t), allocatable, intent(out) :: error

    call close_vtkhdf(result%hdf, result%view, error)
  end subroutine close_result

end module result_file
