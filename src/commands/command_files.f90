!> The files of curves, fields and printed tables. Each is opened when its first row, fields or
!! table is written (after a restart: at the start), so that a run that fails in its first step
!! leaves none. The first rank writes them, and all ranks are told whether this succeeded.
module command_files
  use base_agreement, only: agree
  use base_comm, only: is_root, largest
  use base_error, only: error_t, DECK_ERROR, SYSTEM_ERROR
  use base_file, only: cut_file, file_t, file_size, inspect, remove_file, replace_file, FILE_ABSENT
  use base_kinds, only: wp, i8
  use base_log, only: log_line, warn
  use base_text, only: quoted, to_text
  use byte_file, only: open_bytes, close_bytes
  use command_type, only: run_t
  use curve_file, only: open_curve, write_row, close_curve, find_row, first_step, &
                        cut_curve
  use curve_values, only: quantity_value
  use result_file, only: open_result, write_result, close_result, remove_result, find_steps
  implicit none
  private
  public :: remove_results, open_files, write_rows, write_fields, close_files
  public :: open_tables, keep_tables, cut_tables, continue_tables, row_label

  integer, parameter :: LONG = 64 !! longest name of a column
  real(wp), parameter :: ROUNDING = 1e-6_wp !! relative difference of values of equal rows

contains

  !> Name and columns of curve i.
  function row_label(run, i) result(label)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(:), allocatable :: label
    integer :: j

    label = run%model%curve(i)%name
    do j = 1, size(run%model%curve(i)%quantity)
      label = label//' '//trim(run%model%curve(i)%quantity(j)%column)
    end do
  end function row_label

  !> Remove the curves, fields and tables that an earlier run left under the names of this run: a
  !! run that closes no step, or writes no fields or tables, must not be thought to have written the
  !! old ones.
  subroutine remove_results(run)
    type(run_t), intent(in) :: run
    integer :: i

    if (.not. is_root()) return
    do i = 1, size(run%model%curve)
      call remove_file(curve_path(run, i))
    end do
    call remove_file(tables_path(run))
    call remove_result(run%files%stem)
  end subroutine remove_results

  pure function curve_path(run, i) result(path)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(:), allocatable :: path

    path = path_of(run, run%model%curve(i)%name)
  end function curve_path

  !> The file of the curve with a name.
  pure function path_of(run, name) result(path)
    type(run_t), intent(in) :: run
    character(*), intent(in) :: name
    character(:), allocatable :: path

    path = run%files%stem//'_'//name//'.dat'
  end function path_of

  !> Open the curves; the result file is opened when fields are written for the first time. After a
  !! restart, both, and the printed tables, are cut back at once to the step of the checkpoint, even
  !! if nothing more is written, or set aside if they belong to another run.
  subroutine open_files(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: keep
    logical :: moved
    integer :: i

    associate (files => run%files)
      if (files%curves_open) return
      if (allocated(files%kept)) then
        if (is_own(run)) then
          keep = files%kept
        else
          call set_aside(run, error)
          if (allocated(error)) return
          files%fields_step = -1
          if (.not. files%out_open) files%printed = 0
        end if
        call open_fields(run, keep, error) ! first, because it may fail
        if (allocated(error)) return
      end if
      allocate (files%curve(size(run%model%curve)), files%last_row(size(run%model%curve)))
      do i = 1, size(files%curve)
        moved = .false.
        if (is_root()) call open_curve(files%curve(i), curve_path(run, i), column_names(run, i), &
                                       run%program%ntable, error, keep, is_continued(run, i), moved)
        call agree(error)
        if (allocated(error)) return
        moved = largest(merge(1, 0, moved)) == 1
        if (moved) call warn_moved(run, i)
        if (.not. allocated(files%kept)) cycle
        if (allocated(keep) .and. allocated(files%recalled(i)%value) .and. .not. moved) then
          files%last_row(i) = files%recalled(i) ! its last row, until there is another one
        else if (files%kept > 0 .and. run%model%curve(i)%name /= 'tplot') then
          call note_row(run, i)
        end if
      end do
      files%curves_open = .true.
      if (.not. allocated(files%kept)) return
      if (allocated(keep) .and. is_root()) call cut_ended(run, error)
      call agree(error)
      if (allocated(error)) return
      call cut_tables(run, error)
      call agree(error)
    end associate
  end subroutine open_files

  !> Remove the rows after the checkpoint from the tables of curves that this deck does not have.
  subroutine cut_ended(run, error)
    type(run_t), intent(in) :: run
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: path
    integer :: first, last
    logical :: cut

    if (.not. allocated(run%files%ended)) return
    first = 1
    do while (first <= len(run%files%ended))
      last = first + index(run%files%ended(first:), new_line('a')) - 2
      path = path_of(run, run%files%ended(first:last))
      call cut_curve(path, run%files%kept, cut, error)
      if (allocated(error)) return
      if (cut) call log_line('rows after step '//to_text(run%files%kept)//' were removed from ' &
                             //quoted(path)//', which this deck does not continue')
      first = last + 2
    end do
  end subroutine cut_ended

  pure function column_names(run, i) result(column)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    character(LONG), allocatable :: column(:)
    integer :: j

    associate (quantity => run%model%curve(i)%quantity)
      allocate (column(size(quantity)))
      do j = 1, size(column)
        column(j) = quantity(j)%column
      end do
    end associate
  end function column_names

  !> Do the files under the name of this run belong to the run that wrote the checkpoint? They do if
  !! they contain the last rows that this run had written. Without such rows, the fields must have
  !! the last step that it had written; if the checkpoint has this name, too, there may be none.
  logical function is_own(run)
    type(run_t), intent(in) :: run
    type(file_t) :: own, read
    integer, allocatable :: number(:)
    real(wp), allocatable :: time(:)
    integer :: differs
    logical :: found

    differs = -1 ! not known
    if (is_root()) then
      call compare_rows(run, differs)
      if (differs < 0) then
        call find_steps(run%files%stem, number, time)
        found = any(number == run%files%fields_step .and. is_near(time, run%files%fields_time))
        call inspect(run%files%checkpoint, read)
        call inspect(run%files%stem//'.restart.h5', own)
        if (all(own%identity == read%identity)) found = found .or. run%files%fields_step < 0 &
                                                        .or. all(number > run%files%kept)
        differs = merge(0, 1, found)
      end if
    end if
    is_own = largest(differs) == 0
  end function is_own

  !> Compare the last rows in the checkpoint with those in the old curves. Values are compared with
  !! the largest one of the row, because others may be zero but for rounding.
  subroutine compare_rows(run, differs)
    type(run_t), intent(in) :: run
    integer, intent(inout) :: differs !! 0: they are equal; 1: one differs or is missing
    real(wp), allocatable :: old(:)
    integer :: i
    logical :: found, missing

    do i = 1, size(run%model%curve)
      if (.not. allocated(run%files%recalled(i)%value)) cycle
      associate (new => run%files%recalled(i)%value)
        allocate (old(size(new) - 1))
        call find_row(curve_path(run, i), column_names(run, i), nint(new(1)), old, found, missing)
        if (found) missing = .not. (is_near(old(1), new(2)) .and. &
                                    all(abs(old(2:) - new(3:)) <= ROUNDING*maxval(abs(new(3:)))))
        if (found .or. missing) differs = max(differs, merge(1, 0, missing))
        deallocate (old)
      end associate
    end do
  end subroutine compare_rows

  !> Is a time in an old file that in the checkpoint, up to rounding?
  elemental logical function is_near(old, new)
    real(wp), intent(in) :: old, new

    is_near = abs(old - new) <= ROUNDING*abs(new)
  end function is_near

  !> Rename the curves, fields and tables of another run, with a warning, if they have steps up to
  !! that of the checkpoint, or if there are only tables, whose steps are not known. Files with only
  !! later steps are those of an earlier try of this run, which the new ones replace. The .vtu files
  !! keep their names; the new .pvd does not list them.
  subroutine set_aside(run, error)
    type(run_t), intent(in) :: run
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: number(:)
    real(wp), allocatable :: time(:)
    integer :: first, i
    logical :: moves

    moves = .false.
    if (is_root()) then
      call find_steps(run%files%stem, number, time)
      first = minval(number) ! the largest integer if there is none
      do i = 1, size(run%model%curve)
        first = min(first, first_step(curve_path(run, i)))
      end do
      moves = first <= run%files%kept
      if (first == huge(1)) moves = file_size(tables_path(run)) > 0 .and. .not. run%files%out_open
    end if
    moves = largest(merge(1, 0, moves)) == 1
    if (.not. moves) then
      call log_line('no curves, fields and tables of this name belong to the run of the ' &
                    //'checkpoint, so they begin after it')
      return
    end if
    if (is_root()) then
      do i = 1, size(run%model%curve)
        if (.not. allocated(error)) call rename_old(curve_path(run, i), error)
      end do
      if (.not. allocated(error)) call rename_old(run%files%stem//'.vtkhdf', error)
      if (.not. allocated(error)) call rename_old(run%files%stem//'.pvd', error)
      if (.not. (allocated(error) .or. run%files%out_open)) then
        call rename_old(tables_path(run), error)
      end if
    end if
    call agree(error)
    if (allocated(error)) return
    call warn('the curves, fields and tables of the name '//quoted(run%files%stem)//' are not ' &
              //'those of the run that wrote the checkpoint, so new ones begin after step ' &
              //to_text(run%files%kept), hint='the old files have the ending .old now')
  end subroutine set_aside

  !> Give a file, if it exists, the ending .old.
  subroutine rename_old(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(file_t) :: file

    call inspect(path, file)
    if (file%kind /= FILE_ABSENT) call replace_file(path, path//'.old', error)
  end subroutine rename_old

  !> Does the checkpoint contain a row of curve i with these columns, so that an old table is its
  !! own?
  pure logical function is_continued(run, i)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i

    is_continued = .true.
    if (allocated(run%files%recalled)) is_continued = allocated(run%files%recalled(i)%value)
  end function is_continued

  !> Warn that the table of curve i begins anew, because the old one has other quantities or belongs
  !! to another run.
  subroutine warn_moved(run, i)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i

    call warn('the curve '//quoted(run%model%curve(i)%name)//' has other columns than its table ' &
              //'before the restart, or the run of the checkpoint did not write this table, so ' &
              //'it begins after step '//to_text(run%files%kept), run%model%curve(i)%place, &
              'the old table is '//quoted(curve_path(run, i)//'.old'))
  end subroutine warn_moved

  !> Write a row of every curve.
  subroutine write_rows(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: factor(:)
    integer :: i

    do i = 1, size(run%files%curve)
      if (.not. has_row(run, i)) cycle
      call note_row(run, i)
      allocate (factor(max(run%program%ntable, run%files%curve(i)%nfactor)), source=0.0_wp)
      factor(:size(run%state%factor)) = run%state%factor
      if (size(run%state%factor) == 0) factor = 1.0_wp
      if (is_root()) call write_row(run%files%curve(i), run%state%step, run%state%time, factor, &
                                    run%step%newton%iterations, run%step%cutbacks, &
                                    run%step%newton%converged, run%files%last_row(i)%value(3:), &
                                    error)
      call agree(error)
      if (allocated(error)) return
      deallocate (factor)
    end do
  end subroutine write_rows

  !> Does a curve get a row in this step? The table of TPLOt may leave out steps.
  pure logical function has_row(run, i)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i

    has_row = run%model%curve(i)%name /= 'tplot'
    if (.not. has_row) has_row = mod(run%state%step, run%plan%tplot_every) == 0
  end function has_row

  !> Keep the row of curve i for the report: step, time and current values.
  subroutine note_row(run, i)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: i

    run%files%last_row(i)%value = [real(run%state%step, wp), run%state%time, values_of(run, i)]
  end subroutine note_row

  !> Current values of the quantities of curve i.
  function values_of(run, i) result(value)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i
    real(wp), allocatable :: value(:)
    integer :: j

    associate (quantity => run%model%curve(i)%quantity)
      allocate (value(size(quantity)))
      do j = 1, size(value)
        value(j) = quantity_value(run%model, run%state, quantity(j))
      end do
    end associate
  end function values_of

  !> Write the current fields.
  subroutine write_fields(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    if (.not. run%files%result_open) call open_fields(run, error=error)
    if (allocated(error)) return
    if (is_root()) call write_result(run%files%result, run%model, run%state, error)
    call agree(error)
    run%files%fields_step = run%state%step
    run%files%fields_time = run%state%time
  end subroutine write_fields

  subroutine open_fields(run, keep, error)
    type(run_t), intent(inout) :: run
    integer, intent(in), optional :: keep !! last step whose fields are kept
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (is_root()) call open_result(run%files%result, run%files%stem, run%model, &
                                    run%files%deck_text, error, keep)
    if (allocated(error)) then
      do i = 1, size(run%program%command)
        associate (record => run%program%command(i)%record)
          if (error%code == DECK_ERROR .and. record%key(1) == 'outp') error%place = record%place(1)
        end associate
      end do
      if (error%code == DECK_ERROR) error%code = SYSTEM_ERROR ! because the log has been written
    end if
    call agree(error)
    run%files%result_open = .not. allocated(error)
  end subroutine open_fields

  !> Open the file of FEAP's tables for the first table, without those of earlier runs that are not
  !! kept. Tables are always appended, because cut_tables may shorten the file at any time.
  subroutine open_tables(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    associate (files => run%files)
      if (files%out_open) return
      if (is_root()) then
        if (files%printed == 0) call remove_file(tables_path(run))
        call cut_file(tables_path(run), files%printed, error)
        if (.not. allocated(error)) call open_bytes(files%out, tables_path(run), .true., error)
      end if
      call agree(error)
      files%out_open = .not. allocated(error)
    end associate
  end subroutine open_tables

  !> Keep the tables that have been printed: the step to which they belong has been accepted, or
  !! they were printed between two steps.
  subroutine keep_tables(run)
    type(run_t), intent(inout) :: run

    if (.not. run%files%out_open) return
    run%files%printed = 1
    if (is_root()) run%files%printed = file_size(tables_path(run))
  end subroutine keep_tables

  !> Remove the tables of a step that is not accepted or, after a restart, all that were printed
  !! after the checkpoint. The caller lets the ranks agree about an error.
  subroutine cut_tables(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: ignored

    associate (files => run%files)
      if (.not. (files%out_open .or. allocated(files%kept))) return
      if (files%printed > 0) then
        if (is_root()) call cut_file(tables_path(run), files%printed, error)
        return
      end if
      if (is_root()) call close_bytes(files%out, ignored)
      if (is_root()) call remove_file(tables_path(run))
      files%out_open = .false.
    end associate
  end subroutine cut_tables

  !> Continue the file of FEAP's tables after RESTart: keep its first `length` bytes, or all of it
  !! if no length is given. Tables that this run has already printed remain in any case.
  subroutine continue_tables(run, length)
    type(run_t), intent(inout) :: run
    real(wp), intent(in), optional :: length !! a whole number [byte]

    associate (files => run%files)
      if (files%out_open) return
      files%printed = 0
      if (is_root()) then
        files%printed = file_size(tables_path(run))
        if (present(length)) then
          if (length < real(files%printed, wp)) files%printed = int(max(length, 0.0_wp), i8)
        end if
      end if
      if (largest(merge(1, 0, files%printed > 0)) == 1 .and. .not. is_root()) files%printed = 1
    end associate
  end subroutine continue_tables

  pure function tables_path(run) result(path)
    type(run_t), intent(in) :: run
    character(:), allocatable :: path

    path = run%files%stem//'.out'
  end function tables_path

  subroutine close_files(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    associate (files => run%files)
      if (files%curves_open) then
        do i = 1, size(files%curve)
          if (is_root()) call close_curve(files%curve(i), error)
          call agree(error)
          if (allocated(error)) return
        end do
      end if
      if (files%result_open .and. is_root()) call close_result(files%result, error)
      call agree(error)
      if (allocated(error)) return
      if (files%out_open .and. is_root()) call close_bytes(files%out, error)
      call agree(error)
      files%out_open = .false.
      files%curves_open = .false.
      files%result_open = .false.
    end associate
  end subroutine close_files

end module command_files
