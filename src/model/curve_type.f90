!> What a CURVe asks for: one quantity a column.
module curve_type
  use base_kinds, only: wp
  use base_error, only: place_t
  implicit none
  private
  public :: curve_t, quantity_t

  integer, parameter, public :: Q_FORCE = 1, Q_TORQUE = 2, Q_DISP = 3, Q_STRESS = 4, Q_ENERGY = 5, Q_MAX_DISP = 6, &
    Q_MAX_MISES = 7, Q_NODAL = 8 !! Q_NODAL: FEAP's reactions

  !> One column.
  type :: quantity_t
    integer :: kind = 0
    character(:), allocatable :: column  !! its name in the table
    integer, allocatable :: node(:)      !! nodes summed or averaged over
    integer :: component = 0             !! 1 to 3; stress: Voigt 1 to 6 (11 22 33 12 23 31)
    real(wp) :: point(3) = 0.0_wp        !! on the axis of a torque; of a stress
    real(wp) :: axis(3) = 0.0_wp
    integer :: body = 0                  !! ENERgy, MAXImum: 0 for all
    integer :: block = 0, elem = 0       !! STREss: where the reference point was found
    real(wp) :: xi(3) = 0.0_wp           !! and its parent coordinates there
    type(place_t) :: place
  end type quantity_t

  type :: curve_t
    character(:), allocatable :: name
    type(quantity_t), allocatable :: quantity(:)
    type(place_t) :: place
  end type curve_t

end module curve_type
