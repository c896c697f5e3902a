!> The log of a run, warnings, and the progress line.
!!
!! Lines are kept in memory until the log is opened, because a run of a deck with errors must not
!! touch any file.
module base_log
  use base_error, only: error_t, place_t, render_note
  use base_system, only: stderr_is_terminal
  use byte_file, only: byte_file_t, open_bytes, write_text, flush_bytes, close_bytes
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private
  public :: open_log, close_log, log_line, note, warn, warning_count, message_count, &
            get_warning, recall_warning, progress, summary, set_quiet, mute_log, print_lines

  !> The message of a warning.
  type :: message_t
    character(:), allocatable :: text
  end type message_t

  type(byte_file_t) :: file
  logical :: opened = .false.
  character(:), allocatable :: kept       !! lines written before the log is open
  type(error_t), allocatable :: trouble   !! why the first of the lost lines could not be written
  integer :: nkept = 0
  integer :: nwarning = 0
  type(message_t), allocatable :: message_of(:) !! the distinct warnings of the run
  integer :: nmessage = 0                  !! number of messages in use; the array may be longer
  integer :: shown = 0                     !! characters of the progress line on the screen
  logical :: quiet = .false., asked = .false., terminal = .false.
  logical :: muted = .false.               !! this is not the first rank, so nothing is written
  logical :: prints = .false.              !! lines go to standard output instead of a log

contains

  !> If `yes`, show no warnings, notes, progress or summary on the screen; warnings and notes still
  !! go to the log.
  subroutine set_quiet(yes)
    logical, intent(in) :: yes

    quiet = yes .or. muted
  end subroutine set_quiet

  !> Write nothing on this rank, and only count warnings and store their messages; the first rank
  !! writes them.
  subroutine mute_log()
    muted = .true.
    quiet = .true.
  end subroutine mute_log

  !> From now on, print the lines of the log instead of keeping them (--check).
  subroutine print_lines()
    prints = .true.
  end subroutine print_lines

  !> Open the log and write the lines kept so far.
  subroutine open_log(path, error)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    call open_bytes(file, path, .false., error)
    opened = .not. allocated(error)
    if (.not. opened) return
    if (nkept > 0) call put(kept(:nkept - 1))
    nkept = 0
    if (allocated(kept)) deallocate (kept)
  end subroutine open_log

  !> Close the log, and return an error if any of its lines could not be written, for example
  !! because the disk is full.
  subroutine close_log(error)
    type(error_t), allocatable, intent(out) :: error

    call clear_progress()
    if (.not. opened) return
    opened = .false.
    call close_bytes(file, error)
    if (allocated(trouble)) call move_alloc(trouble, error)
  end subroutine close_log

  !> Write one line, or several lines separated by line ends.
  subroutine log_line(text)
    character(*), intent(in) :: text
    character(:), allocatable :: longer

    if (muted) return
    if (opened) then
      call put(text)
      return
    else if (prints) then
      print '(a)', text
      return
    end if
    if (.not. allocated(kept)) allocate (character(4096) :: kept)
    if (nkept + len(text) + 1 > len(kept)) then
      allocate (character(2*len(kept) + len(text) + 1) :: longer)
      longer(:nkept) = kept(:nkept)
      call move_alloc(longer, kept)
    end if
    kept(nkept + 1:nkept + len(text) + 1) = text//new_line('a')
    nkept = nkept + len(text) + 1
  end subroutine log_line

  !> Write a text and flush it, so that the log is complete even if the process is killed.
  subroutine put(text)
    character(*), intent(in) :: text
    type(error_t), allocatable :: error

    call write_text(file, text//new_line('a'), error)
    if (.not. allocated(error)) call flush_bytes(file, error)
    if (allocated(error) .and. .not. allocated(trouble)) call move_alloc(error, trouble)
  end subroutine put

  !> Count a warning, and write it to the log and the screen.
  subroutine warn(message, place, hint)
    character(*), intent(in) :: message
    type(place_t), intent(in), optional :: place
    character(*), intent(in), optional :: hint
    character(:), allocatable :: text

    nwarning = nwarning + 1
    call keep(message)
    text = render_note('warning', message, place, hint)
    if (.not. prints) call log_line(text)
    call show_above(text)
  end subroutine warn

  !> Write a note, which does not report a problem, to the log and the screen.
  subroutine note(message)
    character(*), intent(in) :: message
    character(:), allocatable :: text

    text = render_note('note', message)
    call log_line(text)
    call show_above(text)
  end subroutine note

  !> Show a text on the screen, above the progress line.
  subroutine show_above(text)
    character(*), intent(in) :: text

    if (quiet) return
    call clear_progress()
    call show(text//new_line('a'))
  end subroutine show_above

  !> Keep a message for the report, unless it has been kept already.
  subroutine keep(message)
    character(*), intent(in) :: message
    type(message_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(message_of)) allocate (message_of(8))
    do i = 1, nmessage
      if (message_of(i)%text == message) return
    end do
    if (nmessage == size(message_of)) then
      allocate (more(2*nmessage))
      do i = 1, nmessage
        call move_alloc(message_of(i)%text, more(i)%text)
      end do
      call move_alloc(more, message_of)
    end if
    nmessage = nmessage + 1
    message_of(nmessage)%text = message
  end subroutine keep

  !> Number of distinct warnings of the run.
  integer function message_count() result(n)

    n = nmessage
  end function message_count

  !> Get the i-th of the distinct warnings of the run.
  subroutine get_warning(i, text)
    integer, intent(in) :: i              !! 1 to message_count()
    character(:), allocatable, intent(out) :: text

    text = message_of(i)%text
  end subroutine get_warning

  !> Enter a warning that was issued before a restart into the log and the report of this run.
  subroutine recall_warning(message)
    character(*), intent(in) :: message
    integer :: i

    do i = 1, nmessage
      if (message_of(i)%text == message) return
    end do
    nwarning = nwarning + 1
    call keep(message)
    call log_line('warning from before the restart: '//message)
  end subroutine recall_warning

  function warning_count() result(n)
    integer :: n

    n = nwarning
  end function warning_count

  !> Show a line at the end of a run, whether or not standard error is a terminal.
  subroutine summary(text)
    character(*), intent(in) :: text

    if (quiet) return
    call clear_progress()
    call show(text//new_line('a'))
  end subroutine summary

  !> Show a line that the next one overwrites, but only if standard error is a terminal.
  subroutine progress(text)
    character(*), intent(in) :: text
    integer, parameter :: WIDTH = 79
    integer :: n

    if (.not. asked) terminal = stderr_is_terminal()
    asked = .true.
    if (quiet .or. .not. terminal) return
    n = min(len_trim(text), WIDTH)
    call show(achar(13)//text(:n)//repeat(' ', max(shown - n, 0)))
    shown = n
  end subroutine progress

  !> Remove the progress line from the screen.
  subroutine clear_progress()
    if (shown == 0) return
    call show(achar(13)//repeat(' ', shown)//achar(13))
    shown = 0
  end subroutine clear_progress

  !> Write to standard error. A failure is ignored, because everything is in the log.
  subroutine show(text)
    character(*), intent(in) :: text
    integer :: io

    write (error_unit, '(a)', advance='no', iostat=io) text
    if (io == 0) flush (error_unit)
  end subroutine show

end module base_log
