!> The arguments of the program.
module command_line
  use base_error, only: error_t, fail, DECK_ERROR
  use base_file, only: base_name
  use base_kinds, only: wp
  use base_text, only: nearest, quoted
  use deck_expression, only: compute, params_t, trouble_t
  implicit none
  private
  public :: options_t, read_command_line, parse_arguments, print_help

  !> The options that the arguments set.
  type :: options_t
    character(:), allocatable :: deck         !! path of the deck
    character(:), allocatable :: outdir       !! folder of all output files
    character(:), allocatable :: stem         !! name of the files without extension
    character(:), allocatable :: settings(:)  !! name=value of each --set
    character(:), allocatable :: restart !! path of a checkpoint; not allocated: start from the deck
    character(:), allocatable :: list         !! one of LISTS, or '' for all; not allocated: no list
    integer :: threads = 0                    !! 0: not given; one is used
    real(wp) :: time_limit = 0.0_wp           !! [s]; 0: there is none
    logical :: check = .false., quiet = .false., version = .false., help = .false.
  end type options_t

  !> One option: its name, its value, and its line of the help.
  type :: option_t
    character(14) :: name
    character(12) :: value
    character(72) :: help
  end type option_t

  type(option_t), parameter :: &
    TABLE(11) = [ &
    option_t('-o', 'DIR', &
             'folder for the results, created if missing (default: the working folder)'), &
    option_t('--name', 'STEM', &
             'stem of the result file names (default: deck name without extension)'), &
    option_t('--set', 'name=value', 'set a parameter of the deck; may be repeated'), &
    option_t('--check', '', &
             'read the deck and report sizes, memory and problems, without solving'), &
    option_t('--restart', 'FILE', 'continue from a checkpoint'), &
    option_t('--threads', 'N', 'number of threads of each process (default: 1)'), &
    option_t('--time-limit', 'SECONDS', 'stop with a checkpoint after this wall time'), &
    option_t('--quiet', '', 'do not print progress, warnings or a summary on the screen'), &
    option_t('--list', '[WHAT]', 'list elements, materials, contacts or commands'), &
    option_t('--version', '', 'print the version'), &
    option_t('--help', '', 'print this help')]
  character(9), parameter :: LISTS(4) = &
                             ['elements ', 'materials', 'contacts ', 'commands ']
  character(*), parameter :: USAGE = 'usage: bezel [options] deck', &
                             MORE = 'bezel --help lists the options'

contains

  !> Read the arguments of the process.
  subroutine read_command_line(options, error)
    type(options_t), intent(out) :: options
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n, longest

    longest = 1
    do i = 1, command_argument_count()
      call get_command_argument(i, length=n)
      longest = max(longest, n)
    end do
    block
      character(longest) :: arguments(command_argument_count())

      do i = 1, size(arguments)
        call get_command_argument(i, arguments(i))
      end do
      call parse_arguments(arguments, options, error)
    end block
  end subroutine read_command_line

  !> Turn arguments into options.
  subroutine parse_arguments(arguments, options, error)
    character(*), intent(in) :: arguments(:)
    type(options_t), intent(out) :: options
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: name, value
    logical :: only_files, seen(size(TABLE))
    integer :: dot, i, row

    options%outdir = '.'
    allocate (character(len(arguments)) :: options%settings(0))
    seen = .false.
    only_files = .false.
    i = 0
    do while (i < size(arguments))
      i = i + 1
      if (arguments(i) == '--' .and. .not. only_files) then
        only_files = .true.
      else if (only_files .or. index(arguments(i), '-') /= 1) then
        if (allocated(options%deck)) then
          call fail_usage(error, 'expected one deck, found a second one, ' &
                          //quoted(trim(arguments(i))), USAGE)
        else if (arguments(i) == '') then
          call fail_usage(error, 'the name of the deck is empty', USAGE)
        else
          options%deck = trim(arguments(i))
        end if
      else
        call take_option(arguments, i, name, row, value, error)
        if (allocated(error)) return
        if (seen(row) .and. name /= '--set') then
          call fail_usage(error, 'duplicate option '//quoted(name), MORE)
        end if
        seen(row) = .true.
        if (.not. allocated(error)) call store(options, name, value, error)
        if (options%help .or. options%version) return
      end if
      if (allocated(error)) return
    end do
    if (allocated(options%list)) return
    if (.not. allocated(options%deck)) then
      call fail_usage(error, 'no deck is given', USAGE//'; '//MORE)
    else if (.not. allocated(options%stem)) then
      options%stem = base_name(options%deck)
      dot = index(options%stem, '.', back=.true.)
      if (dot > 1) options%stem = options%stem(:dot - 1)
    end if
  end subroutine parse_arguments

  !> Find name and value of the option at argument i. If the value is the next argument, i is
  !! advanced to that argument.
  subroutine take_option(arguments, i, name, row, value, error)
    character(*), intent(in) :: arguments(:)
    integer, intent(inout) :: i
    character(:), allocatable, intent(out) :: name, value
    integer, intent(out) :: row
    type(error_t), allocatable, intent(out) :: error
    integer :: equal

    name = trim(arguments(i))
    equal = index(name, '=')
    if (index(name, '--') /= 1) equal = 0
    if (equal > 0) then
      value = name(equal + 1:)
      name = name(:equal - 1)
    end if
    do row = size(TABLE), 1, -1
      if (TABLE(row)%name == name) exit
    end do
    if (row == 0 .and. index(name, '--o') == 1) then
      call fail_usage(error, 'unknown option '//quoted(name), &
                      '-o DIR names the folder of the results; '//MORE)
    else if (row == 0) then
      call fail_usage(error, 'unknown option '//quoted(name), &
                      'nearest known: '//nearest(name, TABLE%name)//'; '//MORE)
    else if (TABLE(row)%value == '') then
      if (allocated(value)) call fail_usage(error, quoted(name)//' takes no value', MORE)
    else if (name == '--list') then
      if (.not. allocated(value) .and. i < size(arguments)) then
        if (index(arguments(i + 1), '-') /= 1) call take_value()
      end if
      if (.not. allocated(value)) value = ''
    else if (.not. allocated(value)) then
      if (i < size(arguments)) call take_value()
    end if
    if (allocated(error)) return
    if (.not. allocated(value)) value = ''
    if (TABLE(row)%value /= '' .and. name /= '--list' .and. value == '') then
      call fail_usage(error, quoted(name)//' needs a value', &
                      trim(name)//' '//trim(TABLE(row)%value))
    end if

  contains

    subroutine take_value()
      i = i + 1
      value = trim(arguments(i))
    end subroutine take_value

  end subroutine take_option

  subroutine store(options, name, value, error)
    type(options_t), intent(inout) :: options
    character(*), intent(in) :: name, value
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x

    select case (name)
    case ('-o')
      options%outdir = value
    case ('--name')
      if (index(value, '/') > 0) then
        call fail_usage(error, 'expected a name without a folder, found '//quoted(value), &
                        'choose the folder with -o')
      end if
      if (verify(value, '.') == 0) then
        call fail_usage(error, 'expected a file name, found '//quoted(value), &
                        'choose the folder with -o')
      end if
      options%stem = value
    case ('--set')
      options%settings = [character(len(options%settings)) :: options%settings, value]
    case ('--restart')
      options%restart = value
    case ('--threads')
      call number_of(name, value, x, error)
      if (allocated(error)) return
      if (x < 1.0_wp .or. x > 1024.0_wp .or. abs(x - anint(x)) > 0.0_wp) then
        call fail_usage(error, quoted(name//' '//value)//' is not a valid number of threads', &
                        'use a whole number from 1 to 1024')
      end if
      if (.not. allocated(error)) options%threads = nint(x)
    case ('--time-limit')
      call number_of(name, value, options%time_limit, error)
      if (allocated(error)) return
      if (.not. options%time_limit > 0.0_wp) then
        call fail_usage(error, quoted(name//' '//value)//' is not a valid time', &
                        'use a number of seconds greater than 0')
      end if
    case ('--list')
      options%list = value
      if (value /= '' .and. all(LISTS /= value)) then
        call fail_usage(error, 'unknown list '//quoted(value), &
                        'nearest known: '//nearest(value, LISTS))
      end if
    case ('--check'); options%check = .true.
    case ('--quiet'); options%quiet = .true.
    case ('--version'); options%version = .true.
    case default; options%help = .true.
    end select
  end subroutine store

  subroutine number_of(name, value, x, error)
    character(*), intent(in) :: name, value
    real(wp), intent(out) :: x
    type(error_t), allocatable, intent(out) :: error
    type(params_t) :: none
    type(trouble_t), allocatable :: trouble

    call compute(none, value, x, trouble)
    if (allocated(trouble)) call fail_usage(error, 'in '//quoted(name//' '//value)//': ' &
                                            //trouble%message, 'use a number')
  end subroutine number_of

  subroutine fail_usage(error, message, hint)
    type(error_t), allocatable, intent(out) :: error
    character(*), intent(in) :: message, hint

    call fail(error, DECK_ERROR, message, hint=hint)
  end subroutine fail_usage

  subroutine print_help()
    integer :: i

    print '(a)', &
      'bezel: finite-element analysis with enriched surfaces, for decks in the language of FEAP', &
      '', USAGE, ''
    do i = 1, size(TABLE)
      print '(2x, a24, 2x, a)', trim(TABLE(i)%name)//' '//TABLE(i)%value//repeat(' ', 24), &
        trim(TABLE(i)%help)
    end do
    print '(a)', '', &
      'exit codes: 0 done, 1 error in the deck or the options, 2 no solution found, 3 error of', &
      'a library, of memory or of the disk, or another run is writing the same files, 4 stopped', &
      'with a checkpoint, 70 error in the program'
  end subroutine print_help

end module command_line
