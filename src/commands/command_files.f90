!> The files of a run: opened when the first step is written, so that a deck that fails leaves none.
module command_files
  use base_kinds, only: wp
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_log, only: log_line
  use base_text, only: to_text
  use named_values, only: named_values_t
  use byte_file, only: close_bytes
  use command_checkpoint, only: pack_run, unpack_run
  use command_type, only: run_t
  use curve_file, only: open_curve, write_row, close_curve, curve_names
  use curve_values, only: quantity_value
  use linear_system, only: FULL
  use program_version, only: VERSION
  use result_file, only: open_result, write_result, close_result
  use restart_file, only: fingerprint_t, make_fingerprint, store => write_checkpoint, &
                          read_checkpoint
  implicit none
  private
  public :: open_files, write_rows, write_fields, write_checkpoint, write_restart_point, set_restart_point, &
            close_files, restore_run

  integer, parameter :: LONG = 64 !! longest name of a column

contains

  !> Curves; the result file opens with its first fields. Where a run goes on both are cut back to
  !! the step it goes on from, whether it has more to write or not.
  subroutine open_files(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    character(LONG), allocatable :: column(:)
    integer :: i, j

    if (run%files_open) return
    allocate (run%curve(size(run%model%curve)), run%last_row(size(run%model%curve)))
    do i = 1, size(run%curve)
      associate (curve => run%model%curve(i))
        allocate (column(size(curve%quantity)))
        do j = 1, size(column)
          column(j) = curve%quantity(j)%column
        end do
        if (run%restarted) then
          call open_curve(run%curve(i), run%stem//'_'//curve%name//'.dat', column, run%nfactor, &
                          error, run%kept)
        else
          call open_curve(run%curve(i), run%stem//'_'//curve%name//'.dat', column, run%nfactor, &
                          error)
        end if
        if (allocated(error)) return
        deallocate (column)
        if (run%restarted .and. has_row(run, i)) call note_row(run, i) ! it may be the last one
      end associate
    end do
    run%files_open = .true.
    if (run%restarted) call open_fields(run, error)
  end subroutine open_files

  !> A row of every curve.
  subroutine write_rows(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: factor(:)
    integer :: i

    allocate (factor(run%nfactor), source=0.0_wp)
    factor(:size(run%state%factor)) = run%state%factor
    if (size(run%state%factor) == 0) factor = 1.0_wp
    do i = 1, size(run%curve)
      if (.not. has_row(run, i)) cycle
      call note_row(run, i)
      call write_row(run%curve(i), run%state%step, run%state%time, factor, run%newton%iterations, &
                     run%plan%cutbacks, run%newton%converged, run%last_row(i)%value(3:), error)
      if (allocated(error)) return
    end do
  end subroutine write_rows

  !> TPLOt may leave steps out.
  pure logical function has_row(run, i)
    type(run_t), intent(in) :: run
    integer, intent(in) :: i

    has_row = run%model%curve(i)%name /= 'tplot'
    if (.not. has_row) has_row = mod(run%state%step - 1, run%tplot_every) == 0
  end function has_row

  !> Row of curve i: step, time, values of now.
  subroutine note_row(run, i)
    type(run_t), intent(inout) :: run
    integer, intent(in) :: i
    real(wp), allocatable :: value(:)
    integer :: j

    associate (quantity => run%model%curve(i)%quantity)
      allocate (value(size(quantity)))
      do j = 1, size(value)
        value(j) = quantity_value(run%model, run%state, quantity(j))
      end do
    end associate
    run%last_row(i)%value = [real(run%state%step, wp), run%state%time, value]
  end subroutine note_row

  !> The fields of now.
  subroutine write_fields(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    if (.not. run%result_open) call open_fields(run, error)
    if (allocated(error)) return
    call write_result(run%result, run%model, run%state, error)
  end subroutine write_fields

  subroutine open_fields(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error

    if (run%restarted) then
      call open_result(run%result, run%stem, run%model, run%deck_text, error, run%kept)
    else
      call open_result(run%result, run%stem, run%model, run%deck_text, error)
    end if
    run%result_open = .not. allocated(error)
  end subroutine open_fields

  !> A checkpoint between two steps; from here on this run and a restarted one do the same.
  subroutine write_checkpoint(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print

    call set_restart_point(run)
    call make_fingerprint(VERSION, run%deck_text, run%model, print)
    call store(run%stem//'.restart.h5', print, run%restart_point%state, run%restart_point%bag, error)
    if (allocated(error)) return
    call log_line('checkpoint after step '//to_text(run%restart_point%state%step)//' in '//run%stem &
                  //'.restart.h5')
  end subroutine write_checkpoint

  !> The same of the last anchor, for a stop that was not foreseen.
  subroutine write_restart_point(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print

    if (run%newton%mode == FULL .or. .not. run%restart_point%set) then
      call write_checkpoint(run, error)
      return
    end if
    call make_fingerprint(VERSION, run%deck_text, run%model, print)
    call store(run%stem//'.restart.h5', print, run%restart_point%state, run%restart_point%bag, error)
  end subroutine write_restart_point

  !> From here on this run and one that is restarted here do the same: kept factors are forgotten.
  subroutine set_restart_point(run)
    type(run_t), intent(inout) :: run

    if (run%newton%ready) call run%newton%system%force_refactor()
    call pack_run(run, run%restart_point%bag)
    run%restart_point%state = run%state
    run%restart_point%set = .true.
  end subroutine set_restart_point

  !> Go on from a checkpoint; no file is touched yet.
  subroutine restore_run(run, path, error)
    type(run_t), intent(inout) :: run
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(fingerprint_t) :: print
    type(named_values_t) :: bag
    logical :: found

    call make_fingerprint(VERSION, run%deck_text, run%model, print)
    call read_checkpoint(path, print, run%state, bag, error)
    if (allocated(error)) return
    call unpack_run(bag, run, found)
    if (.not. found) then
      call fail(error, SYSTEM_ERROR, "'"//path//"' does not hold a whole checkpoint", &
                hint='start again from the deck')
      return
    end if
    run%restarted = .true.
    run%kept = run%state%step
    run%plan%open = .false.
    call log_line('restarted after step '//to_text(run%state%step)//' from '//path)
  end subroutine restore_run

  subroutine close_files(run, error)
    type(run_t), intent(inout) :: run
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (run%files_open) then
      do i = 1, size(run%curve)
        call close_curve(run%curve(i), error)
        if (allocated(error)) return
      end do
    end if
    if (run%result_open) call close_result(run%result, error)
    if (allocated(error)) return
    if (run%out_open) call close_bytes(run%out, error)
    run%out_open = .false.
    run%files_open = .false.
    run%result_open = .false.
  end subroutine close_files

end module command_files
