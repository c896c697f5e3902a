!> PLOT, OUTPut, SAVE: which output is written, and when.
module command_output
  use base_error, only: error_t, fail, DECK_ERROR
  use base_log, only: warn
  use base_text, only: to_text, quoted
  use command_checkpoint, only: write_checkpoint
  use command_files, only: open_files, write_fields
  use command_type, only: run_t, command_t, command_row_t, new_row, check_fields
  use deck_record, only: record_t
  use deck_stream, only: get_integer
  use fields, only: known_fields, named_fields
  use result_file, only: choose_fields
  implicit none
  private
  public :: output_rows

contains

  function output_rows() result(row)
    type(command_row_t) :: row(3)

    row(1) = new_row('PLOT', 'PLOT', 9, run_plot_or_save)
    row(1)%reads = .true. ! FEAP's options need not be numbers
    row(2) = new_row('OUTPut', 'OUTPut,,every n [fields]', 3 + size(known_fields()), run_output)
    row(2)%reads = .true.
    row(3) = new_row('SAVE', 'SAVE', 2, run_plot_or_save)
  end function output_rows

  !> Request fields or a checkpoint: they are written when the current step closes, or at once
  !! between two steps.
  subroutine run_plot_or_save(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    logical :: saves

    saves = command%record%key(1) == 'save'
    if (saves) call check_fields(command, 0, 'SAVE', error)
    if (allocated(error)) return
    if (run%program%dry) then
      if (saves .and. command%visit == 1) call warn_name(run, command)
      return
    end if
    if (run%step%open) then
      run%plan%save = run%plan%save .or. saves
      run%plan%plot = run%plan%plot .or. .not. saves
    else if (saves) then
      run%program%counter = run%program%counter + 1 ! a restart begins after this SAVE
      call write_checkpoint(run, error)
      run%program%counter = run%program%counter - 1
    else
      if (size(run%model%contact) > 0 .and. run%state%step == 0) call warn_gap(command)
      call open_files(run, error)
      if (.not. allocated(error)) call write_fields(run, error)
    end if
  end subroutine run_plot_or_save

  !> Warn if a PLOT writes contact fields before contact has been evaluated for the first time.
  subroutine warn_gap(command)
    type(command_t), intent(in) :: command

    if (command%visit > 1) return
    call warn('PLOT comes before the first solve: the contact fields that it writes, also the ' &
              //'gaps, are 0', command%record%place(1), 'write PLOT after the first TIME and the ' &
              //'solve')
  end subroutine warn_gap

  !> Warn if a SAVE names a file, as in FEAP.
  subroutine warn_name(run, command)
    type(run_t), intent(in) :: run
    type(command_t), intent(in) :: command

    if (command%record%is_empty(2)) return
    call warn('SAVE does not use the name '//quoted(command%record%text(2))//': all checkpoints ' &
              //'go to one file, which contains only the last two', command%record%place(2), &
              'the file is '//quoted(run%files%stem//'.restart.h5')//'; let one deck end at each ' &
              //'state that is needed later')
  end subroutine warn_name

  !> Read OUTPut,,every n [fields]: every n-th step is written, with the fields that are named, or
  !! else the default ones. A result file has a single set of fields, so every OUTPut of a deck must
  !! name the same ones.
  subroutine run_output(run, command, error)
    type(run_t), intent(inout) :: run
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n

    n = 0
    call check_fields(command, size(command%x), 'OUTPut,,every n [fields]', error, option=.false.)
    if (allocated(error)) return
    associate (record => command%record)
      if (record%key(3) == 'ever') call get_integer(run%deck, record, 4, n, error)
      if (allocated(error)) return
      if (n < 1) then
        call fail(error, DECK_ERROR, 'OUTPut needs to know after how many steps fields are ' &
                  //'written', record%place(1), 'write OUTPut,,every n, where n is at least 1')
        return
      end if
      do i = 5, record%n
        if (.not. any(named_fields(record%text(i)))) then
          call fail(error, DECK_ERROR, 'unknown field '//quoted(record%text(i)), record%place(i), &
                    'known fields: displacement, stress, mises, pressure, reaction, contact')
        else if (record%key(i) == 'cont' .and. size(run%model%contact) == 0) then
          call fail(error, DECK_ERROR, 'field '//quoted(record%text(i)) &
                    //' needs a CONTact, but the deck has none', record%place(i), &
                    'define a CONTact, or remove this field')
        end if
        if (allocated(error)) return
      end do
      call choose_fields(run%files%result, wanted_fields(record) .and. record%n > 4)
      if (.not. run%program%dry) run%plan%every = n
      do i = 1, merge(run%program%counter - 1, 0, run%program%dry)
        associate (other => run%program%command(i)%record)
          if (other%key(1) /= 'outp') cycle
          if (all(wanted_fields(other) .eqv. wanted_fields(record))) cycle
          call fail(error, DECK_ERROR, 'OUTPut does not name the same fields as the OUTPut in ' &
                    //'line '//to_text(other%line), record%place(1), 'name the same fields in ' &
                    //'both, because a result file has the same fields in all steps')
        end associate
        return
      end do
    end associate
  end subroutine run_output

  !> Find the known fields that an OUTPut names. If it names none, all are marked, so that two such
  !! records compare equal.
  pure function wanted_fields(record) result(wanted)
    type(record_t), intent(in) :: record
    logical :: wanted(size(known_fields()))
    integer :: i

    wanted = record%n < 5
    do i = 5, record%n
      wanted = wanted .or. named_fields(record%text(i))
    end do
  end function wanted_fields

end module command_output
