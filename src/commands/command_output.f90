!> PLOT, OUTPut, SAVE: what is written when.
module command_output
  use base_error, only: error_t, fail, DECK_ERROR
  use command_files, only: open_files, write_fields, write_checkpoint
  use base_text, only: to_text, quoted
  use command_type, only: run_t, command_t, command_row_t, new_row
  use deck_record, only: record_t
  use deck_stream, only: get_integer
  use fields, only: known_fields, named_fields
  use result_file, only: choose_fields
  implicit none
  private
  public :: describe_plot, describe_output, describe_save

contains

  function describe_plot() result(row)
    type(command_row_t) :: row

    row = new_row('PLOT', 'PLOT', 9, run_plot)
  end function describe_plot

  function describe_output() result(row)
    type(command_row_t) :: row

    row = new_row('OUTPut', 'OUTPut,,every n [fields]', 8, run_output)
    row%reads = .true.
  end function describe_output

  function describe_save() result(row)
    type(command_row_t) :: row

    row = new_row('SAVE', 'SAVE', 2, run_save)
  end function describe_save

  !> The step under way is written when it closes; between steps the state of now at once.
  subroutine run_plot(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (run%dry .or. command%row == 0) return
    if (run%plan%open) then
      run%plan%plot = .true.
    else
      call open_files(run, error)
      if (.not. allocated(error)) call write_fields(run, error)
    end if
  end subroutine run_plot

  !> OUTPut,,every n [fields]: every n-th step is written, all fields or these.
  subroutine run_output(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n

    n = 0
    if (command%record%key(3) == 'ever') call get_integer(run%deck, command%record, 4, n, error)
    if (allocated(error)) return
    if (n < 1) then
      call fail(error, DECK_ERROR, 'OUTPut says how often fields are written', &
                command%record%place(1), 'write OUTPut,,every n with n of at least 1')
      return
    end if
    do i = 5, command%record%n
      call check_field(run, command%record, i, error)
      if (allocated(error)) return
    end do
    call choose_fields(run%result, asks_for(command%record) .and. command%record%n > 4)
    if (run%dry) then
      call compare_fields(run, command, error)
      return
    end if
    run%plan%every = n
  end subroutine run_output

  !> A field that there is.
  subroutine check_field(run, record, i, error)
    type(run_t), intent(in) :: run
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    type(error_t), allocatable, intent(out) :: error

    if (.not. any(named_fields(record%text(i)))) then
      call fail(error, DECK_ERROR, 'unknown field '//quoted(record%text(i)), record%place(i), &
                'known fields: displacement stress mises pressure reaction contact')
    else if (record%key(i) == 'cont' .and. size(run%model%contact) == 0) then
      call fail(error, DECK_ERROR, 'field '//quoted(record%text(i))//' of a deck without contact', &
                record%place(i), 'a block CONTact,name defines a contact')
    end if
  end subroutine check_field

  !> One result file has one set of fields: every OUTPut of a deck must ask for the same ones.
  subroutine compare_fields(run, command, error)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, run%pc - 1
      if (run%command(i)%record%key(1) /= 'outp') cycle
      if (all(asks_for(run%command(i)%record) .eqv. asks_for(command%record))) cycle
      call fail(error, DECK_ERROR, 'OUTPut asks for other fields than the one in line ' &
                //to_text(run%command(i)%record%line), command%record%place(1), &
                'a result file has the same fields in all steps: name all of them in both')
      return
    end do
  end subroutine compare_fields

  !> Which of the known fields an OUTPut names; none: all.
  pure function asks_for(record) result(wanted)
    type(record_t), intent(in) :: record
    logical :: wanted(size(known_fields()))
    integer :: i

    wanted = record%n < 5
    do i = 5, record%n
      wanted = wanted .or. named_fields(record%text(i))
    end do
  end function asks_for

  subroutine run_save(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error

    if (run%dry .or. command%row == 0) return
    if (run%plan%open) then
      run%plan%save = .true.
    else
      run%pc = run%pc + 1              ! a restart begins behind this SAVE
      call write_checkpoint(run, error)
      run%pc = run%pc - 1
    end if
  end subroutine run_save

end module command_output
