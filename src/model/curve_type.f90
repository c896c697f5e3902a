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
  !> Quantities of one side of a contact. STICK, SLIP and DEBONDED are fractions from 0 to 1: of the
  !! area or, for STICK and SLIP without MORTar, of the number of points in contact.
  integer, parameter, public :: Q_CONTACT_FORCE = 9, Q_CONTACT_TORQUE = 10, &
                                Q_CONTACT_PRESSURE = 11, Q_CONTACT_TANGENTIAL = 12, &
                                Q_CONTACT_STICK = 13, Q_CONTACT_SLIP = 14, Q_CONTACT_AREA = 15, &
                                Q_CONTACT_PENETRATION = 16, Q_CONTACT_DEBONDED = 17
  integer, parameter, public :: Q_BOOK = 18 !! a term of the energy balance, given by `component`:
  integer, parameter, public :: B_WORK = 1      !! work done on the bodies by loads and supports
  integer, parameter, public :: B_STORED = 2    !! strain energy
  integer, parameter, public :: B_KINETIC = 3   !! kinetic energy
  integer, parameter, public :: B_NORMAL = 4    !! energy of contact pressure
  integer, parameter, public :: B_FRICTION = 5  !! energy of friction
  integer, parameter, public :: B_COHESIVE = 6  !! energy of bonds
  integer, parameter, public :: B_INERTIA = 7   !! energy dissipated by the time integration
  integer, parameter, public :: B_IMBALANCE = 8 !! imbalance
  integer, parameter, public :: B_BONDS = 9     !! energy stored in bonds
  integer, parameter, public :: B_DAMAGE = 10   !! energy that bonds dissipate by damage
  integer, parameter, public :: B_VISCOUS = 11  !! energy that bonds dissipate by VISCous
  integer, parameter, public :: B_CREATED = 12  !! energy created by contact forces
  integer, parameter, public :: B_ERROR = 13    !! bound on the error of the work

  !> The quantity of one column.
  type :: quantity_t
    integer :: id = 0
    character(:), allocatable :: column  !! name of the column in the table
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
