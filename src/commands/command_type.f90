!> A solution command: its row in the table, its record in the deck, and the run it acts on.
module command_type
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: key_of
  use base_timer, only: timers_t
  use deck_record, only: record_t
  use deck_stream, only: deck_t
  use deck_expression, only: params_t
  use load_curve, only: load_table_t
  use model, only: model_t, state_t
  use newton, only: newton_t, pass_t
  use path_type, only: path_t
  use step_control, only: step_control_t
  use result_file, only: result_file_t
  use named_values, only: named_values_t
  use byte_file, only: byte_file_t
  use curve_file, only: curve_file_t
  implicit none
  private
  public :: run_t, command_t, command_row_t, loop_t, data_t, command_run_i, command_data_i, &
            plan_t, row_t, restart_point_t, new_row

  !> Data records a command owns, read before the run starts.
  type :: data_t
    type(load_table_t), allocatable :: table(:)  !! PROP
    character(:), allocatable :: name(:)         !! PARAmeter
    real(wp), allocatable :: value(:)
  end type data_t

  !> One command of the deck. Fields after the word: an option, then numbers.
  type :: command_t
    integer :: row = 0
    type(record_t) :: record
    integer :: matching = 0            !! LOOP: its NEXT; NEXT: its LOOP
    logical :: holds_time = .false. !! LOOP: a TIME stands in it, not deeper
    logical :: solves = .false.     !! LOOP: a solving command stands in it, not deeper
    character(4) :: option = ''
    real(wp) :: x(4) = 0.0_wp      !! numbers of the fields after the option, as they are now
    type(data_t), allocatable :: data(:) !! one a visit, in the order of the visits
    integer :: visit = 0
  end type command_t

  !> A loop under way.
  type :: loop_t
    integer :: at = 0     !! its LOOP
    integer :: count = 0  !! passes begun, this one included
    integer :: limit = 0
  end type loop_t

  !> Row of the table of commands.
  type :: command_row_t
    character(4) :: key = ''
    character(12) :: word = ''
    integer :: nmax = 2             !! most fields after the word
    character(60) :: usage = ''     !! shown in hints and by --list
    logical :: reads = .false. !! it reads the fields behind the option itself: words among them
    procedure(command_run_i), pointer, nopass :: run => null()
    procedure(command_data_i), pointer, nopass :: data => null() !! reads the command's records
    !! after END
  end type command_row_t

  !> What is written when, and the step under way as the user sees it.
  type :: plan_t
    logical :: open = .false.         !! a step is under way
    logical :: timed = .false.        !! it was opened by a TIME
    logical :: retry = .false.        !! it is a smaller try of a step that was cut
    logical :: solved = .false.       !! at least one solve was made in it
    logical :: plot = .false.         !! PLOT was met in it
    logical :: save = .false.         !! SAVE was met in it
    integer :: every = 0              !! OUTPut: fields every n steps; 0: only where PLOT says
    integer :: cutbacks = 0           !! of the step under way
    integer :: at = 0                 !! its TIME
    integer :: step = 0               !! number and time before it
    real(wp) :: time = 0.0_wp
    type(loop_t), allocatable :: loop(:) !! loops at its TIME
    integer, allocatable :: visit(:)  !! data used by then
    type(params_t) :: params          !! parameters then
  end type plan_t

  !> Values of one row of a curve.
  type :: row_t
    real(wp), allocatable :: value(:)  !! step, time, then the quantities
  end type row_t

  !> The last moment a restart can begin at and still repeat this run to the last bit. With FULL
  !! factorisation that is the end of any step; where factors are kept it must be one at which they
  !! were forgotten.
  type :: restart_point_t
    logical :: set = .false.
    type(state_t) :: state
    type(named_values_t) :: bag
  end type restart_point_t

  !> Everything a command can reach.
  type :: run_t
    type(deck_t) :: deck
    type(model_t) :: model
    type(state_t) :: state
    type(newton_t) :: newton
    type(pass_t) :: pass               !! the last Newton pass
    type(step_control_t) :: control
    type(path_t) :: path
    type(plan_t) :: plan
    type(command_row_t), allocatable :: row(:)
    type(command_t), allocatable :: command(:)
    integer :: pc = 1                  !! the command to be executed
    type(loop_t), allocatable :: loop(:)
    type(result_file_t) :: result
    type(curve_file_t), allocatable :: curve(:)
    character(:), allocatable :: stem  !! folder and stem of all files
    character(:), allocatable :: deck_text
    real(wp) :: time_limit = 0.0_wp    !! [s] 0: none
    logical :: dry = .false.           !! commands only check their fields
    type(timers_t) :: timers
    logical :: failed_step = .false.   !! some step was closed unconverged
    logical :: unstable = .false.      !! the user was warned of an unstable state
    integer :: iterations = 0, cutbacks = 0, negative_pivots = 0
    integer :: nfactor = 0             !! load tables of the whole run
    logical :: files_open = .false., result_open = .false.
    type(byte_file_t) :: out           !! FEAP's tables
    logical :: out_open = .false., prints = .true.
    integer :: tplot_every = 1         !! rows of TPLOt's table
    logical :: restarted = .false.
    integer :: kept = 0                !! last step of the run before the restart
    type(restart_point_t) :: restart_point
    type(row_t), allocatable :: last_row(:) !! of every curve, for the report
    logical, allocatable :: noted(:)   !! rows whose one note has been given
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

  !> A row of the table: `nmax` fields at most stand behind the word.
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

end module command_type
