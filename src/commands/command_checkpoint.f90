!> What a checkpoint keeps beside the state: the command counter, loops, step control, policies.
module command_checkpoint
  use base_kinds, only: wp
  use named_values, only: named_values_t, put, get
  use command_type, only: run_t
  use deck_params, only: parameter_names, find_parameter, set_parameter
  use path_type, only: path_t
  implicit none
  private
  public :: pack_run, unpack_run

contains

  !> The run at a moment between two steps: the command at `pc` is the next one.
  subroutine pack_run(run, bag)
    type(run_t), intent(in) :: run
    type(named_values_t), intent(out) :: bag

    call put(bag, 'pc', run%pc)
    call put(bag, 'loop_at', run%loop(:)%at)
    call put(bag, 'loop_count', run%loop(:)%count)
    call put(bag, 'loop_limit', run%loop(:)%limit)
    call put(bag, 'visit', run%command(:)%visit)
    associate (c => run%control)
      call put(bag, 'control_reals', [c%dt, c%anchor, c%size, c%dtmin, c%dtmax, c%from, c%to])
      call put(bag, 'control_integers', [c%target, c%passed, c%quiet, c%cuts])
      call put(bag, 'control_automatic', c%automatic)
    end associate
    call put(bag, 'newton_reals', [run%newton%tolerance, run%newton%eps])
    call put(bag, 'newton_integers', [run%newton%mode, merge(1, 0, run%newton%symmetric)])
    call put(bag, 'plan', &
             [run%plan%every, run%iterations, run%cutbacks, run%negative_pivots, &
              merge(1, 0, run%failed_step), run%plan%cutbacks, merge(1, 0, run%plan%retry)])
    associate (p => run%path)
      call put(bag, 'path', [p%method, p%wait, p%steps, merge(1, 0, p%given), p%way, &
                             merge(1, 0, p%trial), p%opening, p%patience, p%rest])
      call put(bag, 'path_density', [p%density, p%largest, p%piece, p%length, p%shortest, &
                                     p%longest, p%gained, p%multiple])
    end associate
    call put(bag, 'parameters', parameter_values(run))
  end subroutine pack_run

  !> The run goes on where the checkpoint was made.
  subroutine unpack_run(bag, run, found)
    type(named_values_t), intent(in) :: bag
    type(run_t), intent(inout) :: run
    logical, intent(out) :: found !! .false.: something is missing, or of another size
    real(wp), allocatable :: x(:)
    integer, allocatable :: at(:), count(:), limit(:), n(:)
    logical :: there(9)

    call get(bag, 'pc', run%pc, there(1))
    call get(bag, 'loop_at', at, there(2))
    call get(bag, 'loop_count', count, there(3))
    call get(bag, 'loop_limit', limit, there(4))
    found = all(there(:4))
    if (.not. found) return
    if (allocated(run%loop)) deallocate (run%loop)
    allocate (run%loop(size(at)))
    run%loop(:)%at = at
    run%loop(:)%count = count
    run%loop(:)%limit = limit
    call get(bag, 'visit', n, there(5))
    found = there(5)
    if (found) found = size(n) == size(run%command)
    if (.not. found) return
    run%command(:)%visit = n
    call get(bag, 'control_reals', x, there(6))
    call get(bag, 'control_integers', n, there(7))
    call get(bag, 'control_automatic', run%control%automatic, there(8))
    found = all(there(6:8))
    if (.not. found) return
    associate (c => run%control)
      c%dt = x(1); c%anchor = x(2); c%size = x(3)
      c%dtmin = x(4); c%dtmax = x(5); c%from = x(6); c%to = x(7)
      c%target = n(1); c%passed = n(2); c%quiet = n(3); c%cuts = n(4)
    end associate
    call unpack_policies(bag, run, found)
  end subroutine unpack_run

  subroutine unpack_policies(bag, run, found)
    type(named_values_t), intent(in) :: bag
    type(run_t), intent(inout) :: run
    logical, intent(out) :: found
    real(wp), allocatable :: x(:)
    integer, allocatable :: n(:)
    logical :: there(5)

    call get(bag, 'newton_reals', x, there(1))
    call get(bag, 'newton_integers', n, there(2))
    if (all(there(:2))) then
      run%newton%tolerance = x(1)
      run%newton%eps = x(2)
      run%newton%mode = n(1)
      run%newton%symmetric = n(2) == 1
    end if
    call get(bag, 'plan', n, there(3))
    if (there(3)) then
      run%plan%every = n(1)
      run%iterations = n(2)
      run%cutbacks = n(3)
      run%negative_pivots = n(4)
      run%failed_step = n(5) == 1
      run%plan%cutbacks = n(6)
      run%plan%retry = n(7) == 1
    end if
    call unpack_path(bag, run%path, there(5))
    call get(bag, 'parameters', x, there(4))
    found = all(there)
    if (found) found = size(x) == size(parameter_names(run%deck%params))
    if (found) call set_parameters(run, x)
  end subroutine unpack_policies

  subroutine unpack_path(bag, path, found)
    type(named_values_t), intent(in) :: bag
    type(path_t), intent(inout) :: path
    logical, intent(out) :: found
    real(wp), allocatable :: x(:)
    integer, allocatable :: n(:)
    logical :: there(2)

    call get(bag, 'path', n, there(1))
    call get(bag, 'path_density', x, there(2))
    found = all(there)
    if (.not. found) return
    associate (p => path)
      p%method = n(1)
      p%wait = n(2)
      p%steps = n(3)
      p%given = n(4) == 1
      p%way = n(5)
      p%trial = n(6) == 1
      p%opening = n(7)
      p%patience = n(8)
      p%rest = n(9)
      p%density = x(1)
      p%largest = x(2)
      p%piece = x(3)
      p%length = x(4)
      p%shortest = x(5)
      p%longest = x(6)
      p%gained = x(7)
      p%multiple = x(8)
    end associate
  end subroutine unpack_path

  !> Values of all parameters, in the order of their names.
  function parameter_values(run) result(value)
    type(run_t), intent(in) :: run
    real(wp), allocatable :: value(:)
    character(64), allocatable :: name(:)
    logical :: known
    integer :: i

    allocate (name, source=parameter_names(run%deck%params))
    allocate (value(size(name)))
    do i = 1, size(name)
      call find_parameter(run%deck%params, trim(name(i)), value(i), known)
    end do
  end function parameter_values

  subroutine set_parameters(run, value)
    type(run_t), intent(inout) :: run
    real(wp), intent(in) :: value(:)
    character(64), allocatable :: name(:)
    integer :: i

    allocate (name, source=parameter_names(run%deck%params))
    do i = 1, size(name)
      call set_parameter(run%deck%params, trim(name(i)), value(i))
    end do
  end subroutine set_parameters

end module command_checkpoint
