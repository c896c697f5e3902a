!> The report of a run.
module run_report
  use base_error, only: error_t, NO_SOLUTION, STOPPED
  use base_file, only: remove_file
  use base_kinds, only: wp, i8
  use base_log, only: get_warning, message_count, warning_count
  use base_system, only: peak_memory_mb, wall_seconds
  use base_text, only: to_text
  use byte_file, only: take_room
  use command_type, only: run_t
  use contact_pair, only: is_integrated
  use contact_resultant, only: resultant_t, side_resultant
  use curve_file, only: curve_names
  use program_version, only: VERSION
  use report_file, only: report_t, write_report, add_count, add_real, add_curve
  implicit none
  private
  public :: reserve_report, drop_reserve, report_run, run_summary

  integer(i8), parameter :: RESERVE = 16384 !! bytes; a short report takes about a thousand

contains

  !> Claim space on the disk for the report, so that a run that fills the disk can still write it.
  !! The report of an earlier run is removed, because it would describe results that are about to
  !! change. If the disk is full already, no error is raised here; writing the next file fails.
  subroutine reserve_report(job)
    type(run_t), intent(in) :: job
    type(error_t), allocatable :: ignored

    call remove_file(job%files%stem//'.report.json')
    call drop_reserve(job)
    call take_room(reserve_path(job), RESERVE, ignored)
  end subroutine reserve_report

  !> Release the space for the report.
  subroutine drop_reserve(job)
    type(run_t), intent(in) :: job

    call remove_file(reserve_path(job))
  end subroutine drop_reserve

  function reserve_path(job) result(path)
    type(run_t), intent(in) :: job
    character(:), allocatable :: path

    path = job%files%stem//'.report.json.part'
  end function reserve_path

  !> Write <stem>.report.json.
  subroutine report_run(job, deck, code, error)
    type(run_t), intent(in) :: job
    character(*), intent(in) :: deck    !! path of the deck, as the user gave it
    integer, intent(in) :: code         !! exit code
    type(error_t), allocatable, intent(out) :: error
    type(report_t) :: report
    type(resultant_t) :: side
    character(24), allocatable :: part(:)
    integer :: c, i, k

    report%version = VERSION
    report%deck = deck
    report%exit_code = code
    report%status = status_of(code)
    report%steps = job%state%step
    report%iterations = job%step%total%iterations
    report%cutbacks = job%step%total%cutbacks
    report%dofs = job%model%ndof
    report%equations = job%model%neq
    report%negative_pivots = job%step%total%negative_pivots
    report%peak_memory_mb = peak_memory_mb()
    do i = 1, size(job%model%mesh%block)
      call add_count(report%element, trim(job%model%mesh%block(i)%name), &
                     job%model%mesh%block(i)%nelem)
    end do
    allocate (part, source=[character(24) :: job%timers%names(), 'total'])
    do i = 1, size(part)
      call add_real(report%seconds, trim(part(i)), job%timers%seconds(part(i)))
      call add_real(report%cpu_seconds, trim(part(i)), job%timers%cpu(part(i)))
    end do
    call add_last_rows(job, report)
    report%equilibrium = .not. (job%step%total%unconverged .or. job%step%total%inertia)
    allocate (report%warning(message_count()))
    do i = 1, size(report%warning)
      call get_warning(i, report%warning(i)%text)
    end do
    if (size(job%model%contact) > 0) allocate (report%contact(size(job%model%contact)))
    do c = 1, size(job%model%contact)
      associate (row => report%contact(c))
        row%name = job%model%contact(c)%name
        do k = 1, 2
          if (.not. is_integrated(job%model%contact(c), k)) cycle
          call side_resultant(job%model, job%state, c, k, [0.0_wp, 0.0_wp, 0.0_wp], side)
          row%points = row%points + side%npoint
          row%closed = row%closed + side%nclosed
        end do
        row%balance = job%state%contact(c)%balance
        row%largest_penetration = job%state%contact(c)%deepest
      end associate
    end do
    call write_report(job%files%stem//'.report.json', report, error)
  end subroutine report_run

  !> How a run ended, as a word of the report.
  pure function status_of(code) result(status)
    integer, intent(in) :: code !! exit code
    character(:), allocatable :: status

    select case (code)
    case (0)
      status = 'done'
    case (NO_SOLUTION)
      status = 'no_solution'
    case (STOPPED)
      status = 'stopped'
    case default
      status = 'failed'
    end select
  end function status_of

  !> How a run ended, as one line for the screen.
  function run_summary(job, code) result(line)
    type(run_t), intent(in) :: job
    integer, intent(in) :: code !! exit code
    character(:), allocatable :: line, status
    integer :: i

    status = status_of(code)
    i = index(status, '_')
    if (i > 0) status(i:i) = ' '
    line = 'bezel: '//status//', '//number_of(job%state%step, 'step')//', ' &
           //number_of(job%step%total%iterations, 'iteration')//', ' &
           //number_of(job%step%total%cutbacks, 'cut-back')//', ' &
           //number_of(warning_count(), 'warning')//', '//to_text(wall_seconds(), 3)//' s; see ' &
           //job%files%stem//'.log'
  end function run_summary

  !> A number and the noun that it counts, in the plural unless the number is 1.
  pure function number_of(n, what) result(text)
    integer, intent(in) :: n
    character(*), intent(in) :: what
    character(:), allocatable :: text

    text = to_text(n)//' '//what
    if (n /= 1) text = text//'s'
  end function number_of

  !> Add the last row of every curve.
  subroutine add_last_rows(job, report)
    type(run_t), intent(in) :: job
    type(report_t), intent(inout) :: report
    character(64), allocatable :: column(:), name(:)
    integer :: i, j

    if (.not. allocated(job%files%last_row)) return
    do i = 1, size(job%files%last_row)
      if (.not. allocated(job%files%last_row(i)%value)) cycle
      associate (curve => job%model%curve(i))
        allocate (column(size(curve%quantity)), name(size(curve%quantity)))
        do j = 1, size(column)
          column(j) = curve%quantity(j)%column
        end do
        call curve_names(column, name)
        call add_curve(report%final, curve%name, [character(len(name)) :: 'step', 'time', name], &
                       job%files%last_row(i)%value)
        deallocate (column, name)
      end associate
    end do
  end subroutine add_last_rows

end module run_report
