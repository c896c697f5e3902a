!> Supports, prescribed motion and loads, as the deck gives them.
!! A load number 0 means: the sum of all load tables (FEAP); k > 0: table k.
module boundary
  use base_kinds, only: wp
  use base_error, only: place_t
  implicit none
  private
  public :: boundary_t, motion_t, pressure_t, dead_load_t

  !> Rigid motion of a set of nodes: MOVE. Acts on reference positions; all moves of one node add up
  !! in deck order (rotations about their axes first applied to the reference position, then the
  !! translations).
  type :: motion_t
    integer, allocatable :: node(:)
    logical :: rotates = .false.
    logical :: acts(3) = .true.      !! directions prescribed (`*` leaves one free)
    real(wp) :: vector(3) = 0.0_wp   !! translation [L], or a point on the axis
    real(wp) :: axis(3) = 0.0_wp     !! unit axis of rotation
    real(wp) :: angle = 0.0_wp       !! [rad] at factor 1
    integer :: table = 0
    type(place_t) :: place
  end type motion_t

  !> Normal pressure on element faces; p > 0 presses on the body.
  type :: pressure_t
    integer, allocatable :: block(:), elem(:), side(:)
    real(wp) :: value = 0.0_wp       !! [F/L^2]
    integer :: table = 0
    logical :: follower = .false.    !! on the current area along the current normal; else reference
    type(place_t) :: place
  end type pressure_t

  !> Forces that do not depend on the motion.
  type :: dead_load_t
    integer :: table = 0
    integer, allocatable :: node(:)
    real(wp), allocatable :: f(:, :) !! (3, size(node)) [F] at factor 1
  end type dead_load_t

  type :: boundary_t
    integer, allocatable :: fixed(:, :)       !! (3, nnode) restraint code; not 0: prescribed
    real(wp), allocatable :: value(:, :) !! (3, nnode) prescribed displacement at factor 1 [L]
    !! (DISP, EDIS, CDIS)
    real(wp), allocatable :: force(:, :) !! (3, nnode) nodal force at factor 1 [F] (FORC, EFOR,
    !! CFOR)
    integer, allocatable :: table(:, :) !! (3, nnode) load number of the two above (FPRO, EPRO)
    type(motion_t), allocatable :: motion(:)
    type(pressure_t), allocatable :: pressure(:)
    type(dead_load_t), allocatable :: dead(:) !! body forces, CSURf and dead pressures, once
    !! integrated
  end type boundary_t

end module boundary
