!> What a contact law shows to the rest of the program: one row of the table of contact laws.
!!
!! A law knows a gap and a history, not surfaces. The tractions of the laws of a contact add up.
module contact_type
  use base_kinds, only: wp
  implicit none
  private
  public :: contact_law_t, normal_law_i, friction_law_i, cohesive_law_i

  integer, parameter, public :: MAX_LAW_PROP = 8 !! length of a row of properties

  !> Records of the deck that laws belong to.
  integer, parameter, public :: NORMAL = 1, FRICTION = 2, COHESIVE = 3

  !> State of a point.
  integer, parameter, public :: OPEN = 0, STICK = 1, SLIP = 2, TOUCH = 3 !! TOUCH: no friction acts

  type :: contact_law_t
    character(16) :: name = ''    !! second word of its record: PENAlty, COULomb, EXPOnential
    integer :: role = 0           !! NORMAL, FRICTION or COHESIVE: its record
    character(64) :: usage = ''   !! the record, for hints and --list
    character(80) :: source = ''  !! formula and reference, for the log
    integer :: nprop = 0
    procedure(normal_law_i), pointer, nopass :: normal => null()
    procedure(friction_law_i), pointer, nopass :: friction => null()
    procedure(cohesive_law_i), pointer, nopass :: cohesive => null()
    procedure(released_i), pointer, nopass :: released => null() !! of a cohesive law
  end type contact_law_t

  abstract interface
    !> Pressure at a normal gap; positive presses.
    pure subroutine normal_law_i(prop, gap, multiplier, p, dp)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)     !! (nprop)
      real(wp), intent(in) :: gap         !! [L] negative: penetration
      real(wp), intent(in) :: multiplier  !! [F/L^2] of the augmentation; 0 without
      real(wp), intent(out) :: p          !! [F/L^2]
      real(wp), intent(out) :: dp         !! dp/dgap [F/L^3]
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
    pure subroutine cohesive_law_i(prop, g, worst, t, dtdg)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: g(3)        !! [L] from the partner to the point
      real(wp), intent(inout) :: worst    !! [L] largest |g| so far (laws with damage)
      real(wp), intent(out) :: t(3)       !! [F/L^2]
      real(wp), intent(out) :: dtdg(3, 3) !! [F/L^3]
    end subroutine cohesive_law_i

    !> Opening from which a bond counts as released: hardly any traction is left [L].
    pure function released_i(prop) result(opening)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp) :: opening
    end function released_i
  end interface

end module contact_type
