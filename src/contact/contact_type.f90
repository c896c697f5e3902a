!> What a contact law shows to the rest of the program: one row of the table of contact laws.
!!
!! A law knows a gap and a history, not surfaces. The tractions of the laws of a contact add up.
module contact_type
  use base_kinds, only: wp
  implicit none
  private
  public :: contact_law_t, cohesion_t, normal_law_i, friction_law_i, cohesive_law_i

  integer, parameter, public :: MAX_LAW_PROP = 16 !! length of a row of properties
  integer, parameter, public :: MAX_PAST = 7      !! numbers that a bonded point remembers

  !> Records of the deck that laws belong to.
  integer, parameter, public :: NORMAL = 1, FRICTION = 2, COHESIVE = 3

  !> State of a point.
  integer, parameter, public :: OPEN = 0, STICK = 1, SLIP = 2, TOUCH = 3 !! TOUCH: no friction acts

  type :: contact_law_t
    character(16) :: name = ''    !! second word of its record: PENAlty, COULomb, EXPOnential
    character(16) :: option = ''  !! a word behind the numbers that chooses this row: IRREversible
    integer :: role = 0           !! NORMAL, FRICTION or COHESIVE: its record
    character(80) :: usage = ''   !! the record, for hints and --list
    character(80) :: source = ''  !! formula and reference, for the log
    integer :: nprop = 0
    procedure(normal_law_i), pointer, nopass :: normal => null()
    procedure(friction_law_i), pointer, nopass :: friction => null()
    procedure(cohesive_law_i), pointer, nopass :: cohesive => null()
    !> Of a cohesive law.
    logical :: oriented = .false. !! it asks for the partner's normal
    procedure(released_i), pointer, nopass :: released => null()
    procedure(prepare_i), pointer, nopass :: prepare => null() !! null: its numbers are enough
  end type contact_law_t

  !> What a cohesive law finds at a point, on the reference area.
  type :: cohesion_t
    real(wp) :: t(3) = 0.0_wp          !! traction [F/L^2]
    real(wp) :: dtdg(3, 3) = 0.0_wp    !! against the gap [F/L^3]
    real(wp) :: dtdn(3, 3) = 0.0_wp    !! against the partner's normal [F/L^2]
    real(wp) :: stored = 0.0_wp        !! energy that unloading gives back [F/L]
    real(wp) :: spent = 0.0_wp         !! energy that damage has taken so far [F/L]
    real(wp) :: viscous = 0.0_wp       !! energy that VISCous has taken so far [F/L]
  end type cohesion_t

  abstract interface
    !> Pressure at a normal gap; positive presses.
    pure subroutine normal_law_i(prop, gap, multiplier, p, dp, energy)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)     !! (nprop)
      real(wp), intent(in) :: gap         !! [L] negative: penetration
      real(wp), intent(in) :: multiplier  !! [F/L^2] of the augmentation; 0 without
      real(wp), intent(out) :: p          !! [F/L^2]
      real(wp), intent(out) :: dp         !! dp/dgap [F/L^3]
      real(wp), intent(out) :: energy     !! [F/L] integral of p from where it begins
    end subroutine normal_law_i

    !> Tangential traction: predictor and corrector.
    pure subroutine friction_law_i(prop, d, p, ahead, t, dtdd, dtdp, elastic, state)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: d(3)        !! [L] from the stored sliding point, in the tangent plane
      real(wp), intent(in) :: p           !! [F/L^2] pressure, > 0
      !> [L] First tangent of a step: it slips, whatever d says, and will slip so far; d alone tells
      !! where this is negative.
      real(wp), intent(in) :: ahead
      real(wp), intent(out) :: t(3)       !! [F/L^2]
      real(wp), intent(out) :: dtdd(3, 3) !! [F/L^3]
      real(wp), intent(out) :: dtdp(3)    !! [-]
      real(wp), intent(out) :: elastic(3) !! [L] part of d that is not slip: left when the step is
      !! accepted
      integer, intent(out) :: state       !! STICK or SLIP
    end subroutine friction_law_i

    !> Traction on the reference area, of the gap to the stored partner.
    pure subroutine cohesive_law_i(prop, lag, g, n, past, now, c)
      import :: wp, cohesion_t
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: lag         !! [-] time of VISCous over that of the step; 0 without
      real(wp), intent(in) :: g(3)        !! [L] from the partner to the point
      real(wp), intent(in) :: n(3)        !! [-] of the partner's side; any, if it is not asked for
      real(wp), intent(in) :: past(:)     !! (MAX_PAST) what the law remembered before the step
      real(wp), intent(out) :: now(:)     !! (MAX_PAST) and after it
      type(cohesion_t), intent(out) :: c
    end subroutine cohesive_law_i

    !> Numbers that follow from those of the deck.
    pure subroutine prepare_i(prop, wrong, hint)
      import :: wp
      implicit none
      real(wp), intent(inout) :: prop(:)
      integer, intent(out) :: wrong       !! the number that cannot be; 0: none
      character(:), allocatable, intent(out) :: hint
    end subroutine prepare_i

    !> Opening from which a bond counts as released: hardly any traction is left [L].
    pure function released_i(prop) result(opening)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp) :: opening
    end function released_i
  end interface

end module contact_type
