!> A solution command: its row in the table, its record in the deck, and the run on which it acts.
module command_type
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_text, only: key_of, quoted, to_text
  use base_timer, only: timers_t
  use byte_file, only: byte_file_t
  use curve_file, only: curve_file_t
  use deck_expression, only: params_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t
  use load_curve, only: load_table_t
  use model, only: model_t, state_t
  use named_values, only: named_values_t
  use result_file, only: result_file_t
  use step, only: step_t
  implicit none
  private
  public :: run_t, plan_t, program_t, files_t, loop_t, command_t, command_row_t, data_t, &
            assignment_t, new_row, has_number, whole_field, check_fields

  !> A record `name = value` of PARAmeter.
  type :: assignment_t
    character(:), allocatable :: name
    real(wp) :: value = 0.0_wp
  end type assignment_t

  !> Data records of a command, read before the run starts.
  type :: data_t
    type(load_table_t), allocatable :: table(:) !! PROP
    type(assignment_t), allocatable :: assignment(:) !! PARAmeter
  end type data_t

  !> One command of the deck. The fields after the word are an option, then numbers.
  type :: command_t
    integer :: row = 0                          !! row in the table of commands
    type(record_t) :: record
    logical :: begins_batch = .false.           !! first command of a further BATCh
    integer :: matching = 0                     !! LOOP: its NEXT; NEXT: its LOOP
    logical :: holds_time = .false.             !! LOOP: contains a TIME outside its inner loops
    logical :: spans_time = .false.             !! LOOP: contains a TIME, also in inner loops
    logical :: solves = .false.                 !! LOOP: a command that solves, outside inner loops
    integer :: passes = 0                       !! LOOP: number of passes at its last visit
    character(4) :: option = ''
    real(wp) :: x(4) = 0.0_wp                   !! numbers after the option, evaluated at each visit
    type(data_t), allocatable :: data(:)        !! one per visit; later visits use the last
    integer :: visit = 0
  end type command_t

  !> Row of the table of commands.
  type :: command_row_t
    character(4) :: key = ''
    character(12) :: word = ''
    integer :: nmax = 2                         !! largest number of fields after the word
    character(72) :: usage = ''                 !! shown in hints and by --list
    logical :: reads = .false.                  !! `run` itself reads the fields after the option
    logical :: closes = .false.                 !! a step that was solved is closed before it
    procedure(command_run_i), pointer, nopass :: run => null()
    procedure(command_data_i), pointer, nopass :: data => null() !! reads its records after END
  end type command_row_t

  !> A loop that is being executed.
  type :: loop_t
    integer :: at = 0                           !! position of its LOOP
    integer :: count = 0                        !! passes begun, including the current one
    integer :: limit = 0
  end type loop_t

  !> A position in the program, to which the run can return.
  type :: position_t
    integer :: counter = 0
    type(loop_t), allocatable :: loop(:)
    integer, allocatable :: visit(:)            !! visits of each command
    type(params_t) :: params
    logical :: prints = .true.                  !! see plan_t
  end type position_t

  !> The commands of the deck, and the current position in them (see program_position).
  type :: program_t
    type(command_row_t), allocatable :: row(:)
    type(command_t), allocatable :: command(:)
    integer :: counter = 1                      !! the command to be executed
    type(loop_t), allocatable :: loop(:)        !! loops being executed, the inner ones last
    type(position_t) :: step_start              !! position at which the current step began
    logical :: dry = .false.                    !! commands only check their fields
    integer :: ntable = 0                       !! highest number of a load table of the whole run
    integer, allocatable :: defined(:)          !! numbers of the load tables that PROPs define
    integer, allocatable :: prop_at(:)          !! (number) command that defines each table first
    !> What ended the load table that was read last, if no blank record follows its pairs.
    character(:), allocatable :: end_of_table
    logical, allocatable :: noted(:)            !! rows whose note or warning was issued
  end type program_t

  !> Which output is due.
  type :: plan_t
    logical :: plot = .false.                   !! PLOT: fields when the step closes
    logical :: save = .false.                   !! SAVE: a checkpoint when it closes
    integer :: every = 0                        !! OUTPut: fields every n steps; 0: only by PLOT
    integer :: tplot_every = 1                  !! steps between rows of TPLOt's table
    logical :: prints = .true.                  !! PRINt and NOPRint
    !> Warnings that were issued, see command_watch.
    logical :: turn_warned = .false., strain_warned = .false., inverted_warned = .false.
    real(wp), allocatable :: closed_at          !! end of the last step, or start of the first
    logical :: idle_warned = .false.            !! see write_unsolved of command_step
    logical :: unsolved_warned = .false.        !! see warn_unsolved of command_step
    integer :: restarted_at = -1                !! step of the checkpoint of RESTart; -1: none
    logical :: loads_changed = .false.          !! since the run that wrote this checkpoint
    logical :: corner_warned = .false.          !! see table_use, as for `acted` and `ended`
    logical, allocatable :: rubbed(:)           !! (ncontact) friction acted in some step
    !> (2, ntable) closed steps and iterations when PROP last defined the table; -1: it has not.
    integer, allocatable :: defined_at(:, :)
    logical, allocatable :: acted(:) !! (0:ntable) the factor was nonzero in at least one step
    logical, allocatable :: ended(:) !! (ntable) the warning about the end of the table was issued
  end type plan_t

  !> Values of one row of a curve.
  type :: row_t
    real(wp), allocatable :: value(:)           !! step, time, then the quantities
  end type row_t

  !> The files of a run.
  type :: files_t
    character(:), allocatable :: stem           !! folder and stem of all files
    character(:), allocatable :: deck_text
    type(result_file_t) :: result
    type(curve_file_t), allocatable :: curve(:)
    type(byte_file_t) :: out                    !! FEAP's tables
    !> Length of the file of FEAP's tables without those of the current step [byte]; ranks other
    !! than the first know only whether it is 0.
    integer(i8) :: printed = 0
    logical :: curves_open = .false., result_open = .false., out_open = .false.
    type(row_t), allocatable :: last_row(:)     !! last row of every curve, for the report
    type(row_t), allocatable :: recalled(:)     !! those in the checkpoint, if the columns agree
    character(:), allocatable :: ended          !! names of curves of the checkpoint that the deck
    !! does not have, each with a line end
    integer :: fields_step = -1                 !! the last step whose fields were written; -1: none
    real(wp) :: fields_time = 0.0_wp            !! its time [T]
    integer, allocatable :: kept  !! last step before the restart; not allocated: there is none
    character(:), allocatable :: checkpoint     !! its file
  end type files_t

  !> The last point from which a restart repeats this run to the last bit. With FULL factorisation,
  !! the end of any step is such a point. With kept factors, it is such a point only if the factors
  !! were discarded there.
  type :: restart_point_t
    logical :: set = .false.
    type(state_t) :: state
    type(named_values_t) :: values
  end type restart_point_t

  !> Everything to which a command has access.
  type :: run_t
    type(deck_t) :: deck
    type(model_t), allocatable :: model
    type(state_t) :: state
    type(step_t) :: step
    type(program_t) :: program
    type(plan_t) :: plan
    type(files_t) :: files
    type(restart_point_t) :: restart_point
    type(timers_t) :: timers
    real(wp) :: time_limit = 0.0_wp             !! [s]; 0: there is none
  end type run_t

  abstract interface
    subroutine command_run_i(run, command, error)
      import :: run_t, command_t, error_t
      implicit none
      type(run_t), intent(inout) :: run
      type(command_t), intent(in) :: command
      type(error_t), allocatable, intent(out) :: error
    end subroutine command_run_i

    subroutine command_data_i(run, command, data, error)
      import :: run_t, command_t, data_t, error_t
      implicit none
      type(run_t), intent(inout) :: run
      type(command_t), intent(in) :: command
      type(data_t), intent(out) :: data
      type(error_t), allocatable, intent(out) :: error
    end subroutine command_data_i
  end interface

contains

  !> A row of the table for a word that takes at most `nmax` fields.
  function new_row(word, usage, nmax, run, data) result(row)
    character(*), intent(in) :: word, usage
    integer, intent(in) :: nmax
    procedure(command_run_i) :: run
    procedure(command_data_i), optional :: data
    type(command_row_t) :: row

    row%key = key_of(word)
    row%word = word
    row%usage = usage
    row%nmax = nmax
    row%run => run
    if (present(data)) row%data => data
  end function new_row

  !> Fail if a command has more than the n numbers that it reads. If `option` is .false., fail also
  !! if the command has a field where other commands have an option. Empty fields and numbers 0
  !! are always accepted.
  subroutine check_fields(command, n, usage, error, option)
    type(command_t), intent(in) :: command
    integer, intent(in) :: n
    character(*), intent(in) :: usage
    type(error_t), allocatable, intent(inout) :: error !! keep an earlier error
    logical, intent(in), optional :: option !! default: .true.
    integer :: i

    if (allocated(error)) return
    if (present(option)) then
      if (.not. (option .or. command%record%is_empty(2))) then
        call fail(error, DECK_ERROR, 'unexpected '//quoted(command%record%text(2)), &
                  command%record%place(2), 'write '//usage)
        return
      end if
    end if
    do i = n + 1, size(command%x)
      if (.not. abs(command%x(i)) > 0.0_wp) cycle
      call check_count(command%record, 1, n + 2, usage, error)
      return
    end do
  end subroutine check_fields

  !> Is the i-th number of a command in the deck? It is 0 if its field is empty, but an explicit 0
  !! may be meant.
  pure logical function has_number(command, i)
    type(command_t), intent(in) :: command
    integer, intent(in) :: i

    has_number = .not. command%record%is_empty(i + 2)
  end function has_number

  !> Get the i-th number of a command, which must be a whole number.
  subroutine whole_field(command, i, n, error)
    type(command_t), intent(in) :: command
    integer, intent(in) :: i
    integer, intent(out) :: n
    type(error_t), allocatable, intent(inout) :: error !! keep an earlier error

    n = 0
    if (allocated(error)) return
    if (abs(command%x(i)) > huge(n) .or. abs(command%x(i) - anint(command%x(i))) > 0) then
      call fail(error, DECK_ERROR, 'expected a whole number of at most '//to_text(huge(n)) &
                //', found '//quoted(command%record%text(i + 2)), command%record%place(i + 2))
    else
      n = nint(command%x(i))
    end if
  end subroutine whole_field

end module command_type
