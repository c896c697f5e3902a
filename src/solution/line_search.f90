!> Line search along a Newton increment.
module line_search
  use assembly, only: assembler_t, sweep_t, form, free_part
  use base_error, only: error_t
  use base_kinds, only: wp
  use contact_pair, only: MORTAR
  use model, only: model_t, state_t
  implicit none
  private
  public :: search_line, step_by, retreat

  !> A line search ends when the slope, relative to that at its start, is below this (FEAP).
  real(wp), parameter :: LINE_TOLERANCE = 0.8_wp
  integer, parameter :: LINE_TRIALS = 10
  integer, parameter :: CLOSE_TRIALS = 40 !! largest number of trials of a search
  integer, parameter :: FIRST_TRIALS = 3  !! trials by regula falsi before an interval is halved
  real(wp), parameter :: CLOSE = 1.0e-3_wp !! a search ends in an interval of this relative width
  !> Slopes at the ends of an interval are comparable if their ratio is below this.
  real(wp), parameter :: COMPARABLE = 10.0_wp
  !> Unless all contacts use the mortar scheme, an increment overshoots if the residual grows, and
  !! the slope at its end has the sign opposite to that at its start and is more than this many
  !! times as large.
  real(wp), parameter :: OVERSHOT = 4.0_wp

contains

  !> Set the displacements to those of the previous iteration plus s du.
  pure subroutine step_by(state, du, s)
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: du(:, :), s

    state%u = state%u_base + s*du
    state%scale = s
  end subroutine step_by

  !> FEAP's line search: find a fraction s of the increment with |du.r(s)| <= 0.8 |du.r(0)|. First,
  !! the fraction is halved as long as an element is inverted.
  subroutine search_line(asm, model, state, dx, du, g0, s, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: dx(:)      !! (neq) the increment
    real(wp), intent(in) :: du(:, :)   !! (3, nnode) the same
    real(wp), intent(in) :: g0         !! du.r(0)
    real(wp), intent(out) :: s         !! fraction of the increment that is taken
    type(error_t), allocatable, intent(out) :: error
    type(sweep_t) :: sweep
    real(wp) :: g
    integer :: i

    s = 1.0_wp
    do i = 1, LINE_TRIALS
      call slope(asm, model, state, dx, du, s, g, sweep, error)
      if (allocated(error)) return
      if (sweep%ok) exit
      s = 0.5_wp*s
    end do
    call close_in(asm, model, state, dx, du, g0, g, s, sweep, error)
    if (allocated(error)) return
    call step_by(state, du, s)
  end subroutine search_line

  !> Shorten the last increment if necessary. It has already been added to the displacements, and
  !! the forces at its end are known. An increment is halved as long as it inverts an element. For
  !! example, an increment overshoots if a surface penetrates the other one in a single increment
  !! and the whole penalty pushes it back; a line search then finds the fraction of the increment to
  !! keep. In all other cases there is nothing to compute.
  !!
  !! With the mortar scheme, the cells may have been cut at the end of the increment, and the forces
  !! at its start depend on the cells. The slope at the start is therefore found again with these
  !! cells before an increment is shortened.
  subroutine retreat(asm, model, state, dx, rhs, sweep, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: dx(:)      !! (neq) the whole increment
    real(wp), intent(in) :: rhs(:)     !! (neq) residual before the increment
    type(sweep_t), intent(inout) :: sweep
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: du(:, :), r(:)
    real(wp) :: g, g0, s
    integer :: i

    do i = 1, LINE_TRIALS
      if (sweep%ok) exit
      state%u = state%u_base + 0.5_wp*(state%u - state%u_base)
      state%scale = 0.5_wp*state%scale
      call form(asm, model, state, sweep, error)
      if (allocated(error)) return
    end do
    if (.not. sweep%ok .or. size(model%contact) == 0) return
    allocate (r(size(dx)))
    call free_part(model%eq, asm%f_ext - asm%f_int, r)
    g0 = dot_product(dx, rhs)
    g = dot_product(dx, r)
    if (.not. overshoots(model, g0, g, norm2(r) > norm2(rhs))) return
    s = state%scale
    du = (state%u - state%u_base)/s
    if (any(model%contact%scheme == MORTAR)) then
      call slope(asm, model, state, dx, du, 0.0_wp, g0, sweep, error)
      if (allocated(error)) return
    end if
    if (sweep%ok .and. overshoots(model, g0, g, .true.)) then
      call close_in(asm, model, state, dx, du, g0, g, s, sweep, error)
      if (allocated(error)) return
    else
      call step_by(state, du, s)
    end if
    call form(asm, model, state, sweep, error) ! the next solve uses this tangent
  end subroutine retreat

  !> Is an increment too long? If so, a line search follows. With the mortar scheme, it prevents
  !! points with friction from alternating between stick and slip at small pressures. No cut-back
  !! would help there, because the friction cone is the same in a smaller step. The schemes of
  !! integration points have a wider limit, because their points open and close one at a time.
  pure logical function overshoots(model, g0, g, grows) result(yes)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: g0, g      !! du.r at the start and at the end of the increment
    logical, intent(in) :: grows       !! the residual is larger at the end

    if (all(model%contact%scheme == MORTAR)) then
      yes = g0 > 0.0_wp .and. g < -LINE_TOLERANCE*g0
    else
      yes = g0 > 0.0_wp .and. g < -OVERSHOT*g0 .and. grows
    end if
  end function overshoots

  !> Search for a small slope by regula falsi with the Illinois modification. The search begins with
  !! the slope g at the fraction s; `sweep` is the result of the sweep at s. If a stiff contact
  !! closes along the increment, the slope at the far end may be millions of times as large as that
  !! at the start, and regula falsi hardly leaves the start. With the mortar scheme, the interval is
  !! therefore halved after a few trials until the slopes at its ends are comparable.
  subroutine close_in(asm, model, state, dx, du, g0, g, s, sweep, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: dx(:), du(:, :), g0
    real(wp), intent(inout) :: g, s
    type(sweep_t), intent(inout) :: sweep
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: ga, gb, sa, sb, far
    logical :: halves
    integer :: i

    sa = 0.0_wp
    ga = g0
    sb = s
    gb = g
    far = g
    halves = size(model%contact) > 0 .and. all(model%contact%scheme == MORTAR)
    do i = 1, merge(CLOSE_TRIALS, LINE_TRIALS, halves)
      if (.not. sweep%ok .or. abs(g) <= LINE_TOLERANCE*abs(g0) .or. ga*gb > 0.0_wp) exit
      if (halves .and. sb - sa <= CLOSE*sb) exit
      if (halves .and. i > FIRST_TRIALS .and. abs(far) > COMPARABLE*abs(g0)) then
        s = 0.5_wp*(sa + sb)
      else
        s = sb - gb*(sb - sa)/(gb - ga)
      end if
      call slope(asm, model, state, dx, du, s, g, sweep, error)
      if (allocated(error)) return
      if (g*ga > 0.0_wp) then
        sa = s
        ga = g
        gb = 0.5_wp*gb
      else
        sb = s
        gb = g
        far = g
        ga = 0.5_wp*ga
      end if
    end do
  end subroutine close_in

  !> du.r at a fraction of the increment.
  subroutine slope(asm, model, state, dx, du, s, g, sweep, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    real(wp), intent(in) :: dx(:), du(:, :), s
    real(wp), intent(out) :: g
    type(sweep_t), intent(out) :: sweep
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: r(:)

    call step_by(state, du, s)
    g = 0.0_wp
    call form(asm, model, state, sweep, error, only_forces=.true.)
    if (allocated(error) .or. .not. sweep%ok) return
    allocate (r(size(dx)))
    call free_part(model%eq, asm%f_ext - asm%f_int, r)
    g = dot_product(dx, r)
  end subroutine slope

end module line_search
