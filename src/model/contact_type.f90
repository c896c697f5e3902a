!> One row of the table of contact laws: the interface between a law and the rest of the program.
!!
!! A law knows a gap and a history, but no surfaces. The tractions of all laws of a contact are
!! added up.
module contact_type
  use base_kinds, only: wp
  implicit none
  private
  public :: contact_law_t, cohesion_t

  integer, parameter, public :: MAX_LAW_PROP = 16 !! length of a row of properties
  integer, parameter, public :: MAX_PAST = 7      !! history variables of a bonded point
  !> Positions, among the history variables, of the largest openings, on which the traction depends:
  !! those of both modes, or that of the whole vector and a zero.
  integer, parameter, public :: LARGEST_OPENINGS(2) = [1, 2]
  integer, parameter, public :: LAST_OPENINGS(2) = [3, 4] !! those of the last evaluation
  !> Positions of the work done on the bond so far: without VISCous, and that of VISCous.
  integer, parameter, public :: WORK_DONE(2) = [5, 6]

  !> Role of a law, named after the record of the deck to which it belongs.
  integer, parameter, public :: NORMAL = 1, FRICTION = 2, COHESIVE = 3

  !> Columns of `prop` that every law of a role has. Cohesive laws define their own.
  integer, parameter, public :: PENALTY = 1    !! NORMAL: eps [F/L^3]
  integer, parameter, public :: SMOOTHING = 2  !! NORMAL: penetration of SMOOth [L]; 0: no SMOOth
  integer, parameter, public :: MU = 1         !! FRICTION: coefficient of friction [-]
  integer, parameter, public :: TANGENTIAL_PENALTY = 2 !! FRICTION: eps_t [F/L^3]

  !> State of a point; TOUCH means in contact without friction.
  integer, parameter, public :: OPEN = 0, STICK = 1, SLIP = 2, TOUCH = 3

  type :: contact_law_t
    character(16) :: name = ''    !! second word of its record: PENAlty, COULomb, EXPOnential
    character(16) :: option = ''  !! option of the record that selects this row: IRREversible
    integer :: role = 0           !! NORMAL, FRICTION or COHESIVE
    character(80) :: usage = ''   !! the record without options, for hints and --list
    character(80) :: source = ''  !! formula and reference, for the log
    integer :: nprop = 0
    procedure(normal_law_i), pointer, nopass :: normal => null()
    procedure(friction_law_i), pointer, nopass :: friction => null()
    procedure(cohesive_law_i), pointer, nopass :: cohesive => null()
    !> For cohesive laws.
    logical :: oriented = .false. !! the law depends on the normal at the partner
    logical :: heals = .false.    !! reversible: a bond that closes is whole again
    procedure(released_i), pointer, nopass :: released => null()
    procedure(prepare_i), pointer, nopass :: prepare => null() !! unset: nothing to derive or check
  end type contact_law_t

  !> Result of a cohesive law at a point, on the reference area.
  type :: cohesion_t
    real(wp) :: t(3) = 0.0_wp          !! traction [F/L^2]
    real(wp) :: dtdg(3, 3) = 0.0_wp    !! derivative of t with respect to the gap [F/L^3]
    real(wp) :: dtdn(3, 3) = 0.0_wp !! derivative of t with respect to the partner's normal [F/L^2]
    real(wp) :: stored = 0.0_wp        !! energy that unloading returns [F/L]
    real(wp) :: spent = 0.0_wp         !! energy dissipated by damage so far [F/L]
    real(wp) :: viscous = 0.0_wp       !! energy dissipated by VISCous so far [F/L]
  end type cohesion_t

  abstract interface
    !> Pressure at a normal gap; it is positive in compression.
    pure subroutine normal_law_i(prop, gap, multiplier, p, dp, energy)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)     !! (nprop)
      real(wp), intent(in) :: gap         !! [L] negative: penetration
      real(wp), intent(in) :: multiplier  !! multiplier of the augmentation [F/L^2]; 0: none
      real(wp), intent(out) :: p          !! [F/L^2]
      real(wp), intent(out) :: dp         !! dp/dgap [F/L^3]
      real(wp), intent(out) :: energy  !! [F/L] integral of p from the gap at which p becomes zero
    end subroutine normal_law_i

    !> Tangential traction, found by predictor and corrector.
    pure subroutine friction_law_i(prop, d, p, ahead, t, dtdd, dtdp, elastic, state)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: d(3)        !! vector from the sliding point, in the tangent plane [L]
      real(wp), intent(in) :: p           !! [F/L^2] pressure, > 0
      !> [L] At a point that slipped in the previous step, in the first iteration of a step: the
      !! slip that is expected in the step. The point then slips unless d is zero. Otherwise a
      !! negative number; d then decides between stick and slip.
      real(wp), intent(in) :: ahead
      real(wp), intent(out) :: t(3)       !! [F/L^2]
      real(wp), intent(out) :: dtdd(3, 3) !! [F/L^3]
      real(wp), intent(out) :: dtdp(3)    !! [-]
      real(wp), intent(out) :: elastic(3) !! [L] part of d that is not slip; it stays in the history
      integer, intent(out) :: state       !! STICK or SLIP
    end subroutine friction_law_i

    !> Traction on the reference area as a function of the gap to the stored partner.
    pure subroutine cohesive_law_i(prop, lag, g, n, past, now, c)
      import :: wp, cohesion_t
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: lag         !! [-] time of VISCous divided by the time step; 0
      !! without VISCous
      real(wp), intent(in) :: g(3)        !! [L] vector from the partner to the point
      real(wp), intent(in) :: n(3)        !! [-] normal at the partner; unused unless `oriented`
      real(wp), intent(in) :: past(:)     !! (MAX_PAST) history variables at the start of the step
      real(wp), intent(out) :: now(:)     !! (MAX_PAST) history variables at the end of the step
      type(cohesion_t), intent(out) :: c
    end subroutine cohesive_law_i

    !> Derive further numbers from those of the deck.
    pure subroutine prepare_i(prop, wrong, hint)
      import :: wp
      implicit none
      real(wp), intent(inout) :: prop(:)
      integer, intent(out) :: wrong       !! position of a number that is out of range; 0: none
      character(:), allocatable, intent(out) :: hint
    end subroutine prepare_i

    !> Normal and shear opening [L] at which a bond counts as released, because hardly any traction
    !! is left. They are equal if the law depends on the whole opening.
    pure subroutine released_i(prop, opening)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(out) :: opening(2)
    end subroutine released_i
  end interface

end module contact_type
