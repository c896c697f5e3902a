!> The quantities of a CURVe; each of them is one column of its table.
module curve_type
  use base_error, only: place_t
  use base_kinds, only: wp
  implicit none
  private
  public :: curve_t, quantity_t

  integer, parameter, public :: Q_FORCE = 1, Q_TORQUE = 2, Q_DISP = 3, Q_STRESS = 4, &
                                Q_ENERGY = 5, Q_MAX_DISP = 6, Q_MAX_MISES = 7
  integer, parameter, public :: Q_NODAL = 8 !! FEAP's reactions
  !> Quantities of one side of a contact. STICK, SLIP and DEBONDED are area fractions, 0 to 1.
  integer, parameter, public :: Q_CONTACT_FORCE = 9, Q_CONTACT_TORQUE = 10, &
                                Q_CONTACT_PRESSURE = 11, Q_CONTACT_TANGENTIAL = 12, &
                                Q_CONTACT_STICK = 13, Q_CONTACT_SLIP = 14, Q_CONTACT_AREA = 15, &
                                Q_CONTACT_PENETRATION = 16, Q_CONTACT_DEBONDED = 17
  !> A term of the energy balance; `component` says which one. In the order of B_WORK to B_ERROR:
  !! work done on the bodies; strain energy; kinetic energy; energies of contact pressure, of
  !! friction and of bonds; energy dissipated by the time integration; imbalance; energy stored in
  !! bonds; energy that bonds dissipate by damage and by VISCous; energy created by contact forces;
  !! bound on the error of the work.
  integer, parameter, public :: Q_BOOK = 18
  integer, parameter, public :: B_WORK = 1, B_STORED = 2, B_KINETIC = 3, B_NORMAL = 4, &
                                B_FRICTION = 5, B_COHESIVE = 6, B_INERTIA = 7, B_IMBALANCE = 8, &
                                B_BONDS = 9, B_DAMAGE = 10, B_VISCOUS = 11, B_CREATED = 12, &
                                B_ERROR = 13

  !> The quantity of one column.
  type :: quantity_t
    integer :: id = 0
    character(:), allocatable :: column  !! its name in the table
    integer, allocatable :: node(:)      !! nodes over which to sum or average
    !> Direction 1 to 3; for stress, Voigt index 1 to 6 (11 22 33 12 23 31); for tractions of a
    !! contact, 0 means the magnitude; for the energy balance, the term.
    integer :: component = 0
    real(wp) :: point(3) = 0.0_wp        !! point on the axis of a torque, or point of a stress
    real(wp) :: axis(3) = 0.0_wp
    integer :: body = 0                  !! body of ENERgy or MAXImum; 0: all bodies
    integer :: block = 0, elem = 0       !! STREss: element that contains the reference point
    real(wp) :: xi(3) = 0.0_wp           !! parent coordinates of this point
    integer :: contact = 0, side = 0     !! for a contact: its index in the model, side 1 or 2
    type(place_t) :: place
  end type quantity_t

  type :: curve_t
    character(:), allocatable :: name
    type(quantity_t), allocatable :: quantity(:)
    type(place_t) :: place
  end type curve_t

end module curve_type
