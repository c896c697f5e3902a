!> How the path of equilibria is followed, and when the way is changed.
!!
!! Load control goes as far as it can. Where a small step fails, the release of the bonds is
!! controlled instead of the load, where that fails the length of the step (LENGth: from the start),
!! or inertia carries the model over the snap. Load control is tried again when loads have risen for
!! whole steps of the deck, or when the motion has died down; each time after twice as many steps as
!! the last time it failed.
module path_type
  use base_kinds, only: wp
  implicit none
  private
  public :: path_t, may_leave, leave_statics, is_quiet, is_forward, begin_trial, end_trial, &
            fail_trial, controls_release, adapt_piece, cut_piece, follows_arc, begin_way_along, &
            adapt_length, note_gain, cut_length, runs_back, opens_again

  !> What follows where load control ends; PATH_LOCAL: where it can, else PATH_LENGTH, and where
  !! that cannot, inertia.
  integer, parameter, public :: PATH_OFF = 0, PATH_DYNAMIC = 1, PATH_LOCAL = 2, PATH_LENGTH = 3
  !> How the path is followed now.
  integer, parameter, public :: BY_LOAD = 0, BY_INERTIA = 1, BY_RELEASE = 2, BY_ARC = 3

  real(wp), parameter :: SMALL = 0.6_wp          !! a step of load control, relative to dt
  integer, parameter :: FIRST_WAIT = 4           !! steps with inertia before load control is tried
  integer, parameter :: FIRST_FORWARD = 2        !! whole steps of the deck before it is
  integer, parameter :: LONGEST_WAIT = 64
  real(wp), parameter :: QUIET = 1.0e-3_wp       !! inertia, relative to the largest nodal force
  real(wp), parameter :: LARGEST_PIECE = 0.01_wp !! of the bond that a step releases
  real(wp), parameter :: SMALLEST_PIECE = 1.0e-5_wp
  real(wp), parameter :: SMALLEST_ARC = 1.0e-3_wp !! relative to the first
  real(wp), parameter :: MULTIPLE = 4.0_wp       !! and the longest
  integer, parameter :: FEW = 5, MANY = 9 !! iterations after which a piece grows, or shrinks

  type :: path_t
    integer :: method = PATH_OFF       !! what follows where load control ends
    logical :: given = .false.         !! the deck chose it
    logical :: told = .false.          !! the user was warned that load control was left
    logical :: told_energy = .false.   !! the user was warned of energy from nowhere
    real(wp) :: density = -1.0_wp      !! the deck's [M/L^3]; negative: from the work done
    integer :: way = BY_LOAD           !! as it is now; BY_LOAD: load control was not left
    logical :: trial = .false.         !! the step under way tries load control again
    integer :: wait = FIRST_WAIT       !! steps before the next trial
    integer :: rest = FIRST_WAIT       !! steps before the first trial of the next motion
    integer :: steps = 0               !! since load control was left, or last tried
    real(wp) :: largest = LARGEST_PIECE !! share of the bond that a step may release
    real(wp) :: piece = 0.0_wp         !! share that the next step is to release
    real(wp) :: multiple = MULTIPLE    !! of the first length that a later one may have
    real(wp) :: length = 0.0_wp        !! [L] of the next step along the last one
    real(wp) :: shortest = 0.0_wp, longest = 0.0_wp !! [L] of such steps
    real(wp) :: gained = 0.0_wp        !! share of the bonds that they have released
    integer :: opening = 0             !! such steps in a row that have released bonds
    integer :: patience = FIRST_WAIT   !! of them before the release is controlled again
  end type path_t

contains

  !> A step of load control has failed: is it time for another way?
  pure logical function may_leave(path, size)
    type(path_t), intent(in) :: path
    real(wp), intent(in) :: size       !! of the step, relative to dt

    may_leave = path%method /= PATH_OFF .and. path%way == BY_LOAD .and. size <= SMALL
  end function may_leave

  pure subroutine leave_statics(path, way)
    type(path_t), intent(inout) :: path
    integer, intent(in) :: way         !! BY_INERTIA, BY_RELEASE, BY_ARC

    path%way = way
    path%steps = 0
    path%wait = FIRST_FORWARD
    if (way == BY_INERTIA) then
      path%wait = path%rest
      path%rest = min(2*path%rest, LONGEST_WAIT)
    end if
    path%piece = 0.5_wp*path%largest
  end subroutine leave_statics

  !> The step under way is controlled by the release of the bonds.
  pure logical function controls_release(path)
    type(path_t), intent(in) :: path

    controls_release = path%way == BY_RELEASE .and. .not. path%trial
  end function controls_release

  !> A step with inertia is done: has the motion died down, and is a trial due?
  logical function is_quiet(path, inertia, largest)
    type(path_t), intent(inout) :: path
    real(wp), intent(in) :: inertia    !! largest force of inertia at a node [F]
    real(wp), intent(in) :: largest    !! largest nodal force [F]

    path%steps = path%steps + 1
    is_quiet = path%steps >= path%wait .and. inertia <= QUIET*largest
  end function is_quiet

  !> A step of given release is done: have loads risen for long enough?
  logical function is_forward(path, whole)
    type(path_t), intent(inout) :: path
    logical, intent(in) :: whole       !! it was a whole step of the deck

    path%steps = merge(path%steps + 1, 0, whole)
    is_forward = path%steps >= path%wait
  end function is_forward

  !> What the next step is to release, after one that took so many iterations.
  pure subroutine adapt_piece(path, iterations)
    type(path_t), intent(inout) :: path
    integer, intent(in) :: iterations

    if (iterations <= FEW) path%piece = min(1.5_wp*path%piece, path%largest)
    if (iterations >= MANY) path%piece = max(0.7_wp*path%piece, SMALLEST_PIECE)
  end subroutine adapt_piece

  !> The step has failed: half of its release. .false.: that is too little.
  logical function cut_piece(path) result(possible)
    type(path_t), intent(inout) :: path

    path%piece = 0.5_wp*path%piece
    possible = path%piece >= SMALLEST_PIECE
  end function cut_piece

  !> Arc length follows from a step whose way was so long.
  pure subroutine begin_way_along(path, length)
    type(path_t), intent(inout) :: path
    real(wp), intent(in) :: length     !! [L]

    call leave_statics(path, BY_ARC)
    path%length = length
    path%shortest = SMALLEST_ARC*length
    path%longest = path%multiple*length
    path%gained = 0.0_wp
    path%opening = 0
  end subroutine begin_way_along

  !> The step under way is controlled by its length.
  pure logical function follows_arc(path)
    type(path_t), intent(in) :: path

    follows_arc = path%way == BY_ARC .and. .not. path%trial
  end function follows_arc

  !> How long the next step is to be, after one that took so many iterations and released such a
  !! share of the bonds.
  pure subroutine adapt_length(path, iterations, share)
    type(path_t), intent(inout) :: path
    integer, intent(in) :: iterations
    real(wp), intent(in) :: share

    if (iterations <= FEW) path%length = min(1.5_wp*path%length, path%longest)
    if (iterations >= MANY) path%length = 0.7_wp*path%length
    if (abs(share) > path%largest) path%length = path%length*path%largest/abs(share)
    path%length = max(path%length, path%shortest)
  end subroutine adapt_length

  !> A step along the last one has released such a share of the bonds.
  pure subroutine note_gain(path, share)
    type(path_t), intent(inout) :: path
    real(wp), intent(in) :: share

    path%opening = merge(path%opening + 1, 0, share > SMALLEST_PIECE)
    path%gained = path%gained + share
  end subroutine note_gain

  !> Bonds close by more than one step may open: the path is followed back to where it came from.
  pure logical function runs_back(path)
    type(path_t), intent(in) :: path

    runs_back = path%gained < -path%largest
  end function runs_back

  !> Bonds open along the path again: their release can be controlled.
  logical function opens_again(path, share)
    type(path_t), intent(inout) :: path
    real(wp), intent(in) :: share      !! that the last step released

    opens_again = path%opening >= path%patience
    if (.not. opens_again) return
    path%patience = min(2*path%patience, LONGEST_WAIT)
    call leave_statics(path, BY_RELEASE)
    path%piece = min(share, path%largest)
  end function opens_again

  !> The step along the last one has failed: half of it. .false.: that is too little.
  logical function cut_length(path) result(possible)
    type(path_t), intent(inout) :: path

    path%length = 0.5_wp*path%length
    possible = path%length >= path%shortest
  end function cut_length

  pure subroutine begin_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .true.
  end subroutine begin_trial

  !> It has converged: load control goes on.
  pure subroutine end_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .false.
    path%way = BY_LOAD
  end subroutine end_trial

  !> It has failed: on as before.
  pure subroutine fail_trial(path)
    type(path_t), intent(inout) :: path

    path%trial = .false.
    path%steps = 0
    path%wait = min(2*path%wait, LONGEST_WAIT)
  end subroutine fail_trial

end module path_type
