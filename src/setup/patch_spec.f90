!> What a PATCh block says, before it is meshed.
module patch_spec
  use base_kinds, only: wp
  use base_error, only: place_t
  use nurbs, only: nurbs_t
  use spline_spec, only: spline_spec_t
  implicit none
  private
  public :: patch_spec_t, enrich_t, placement_t

  integer, parameter, public :: GEO_NONE = 0, GEO_BOX = 1, GEO_HEMISPHERE = 2, GEO_NURBS = 3, &
                                GEO_SPLINE = 4, GEO_MESH = 5

  !> ENRIch face p [RAISe t] [EAS [TAPEred]].
  type :: enrich_t
    integer :: face = 0          !! 1 to 6: 1- 1+ 2- 2+ 3- 3+
    integer :: degree = 0
    integer :: raise = 0
    logical :: eas = .false., tapered = .false.
    type(place_t) :: place
  end type enrich_t

  !> ROTAte or TRANslate, applied in order.
  type :: placement_t
    logical :: rotates = .false.
    real(wp) :: point(3) = 0.0_wp  !! on the axis; or the translation
    real(wp) :: axis(3) = 0.0_wp   !! unit
    real(wp) :: angle = 0.0_wp     !! [rad]
    real(wp) :: scale = 0.0_wp     !! SCALe of a MESH; 0: none
  end type placement_t

  !> Interior knots of one direction, as KNOTs gives them.
  type, public :: knot_list_t
    real(wp), allocatable :: u(:)
  end type knot_list_t

  type :: patch_spec_t
    character(:), allocatable :: name
    type(place_t) :: place
    integer :: geometry = GEO_NONE
    real(wp) :: origin(3) = 0.0_wp, length(3) = 0.0_wp !! BOX
    real(wp) :: radius = 0.0_wp, thickness = 0.0_wp    !! HEMIsphere, centre in `origin`
    type(nurbs_t) :: nurbs                             !! NPATch or FILE
    type(placement_t), allocatable :: placement(:)
    integer :: nelem(3) = 0                            !! ELEMents
    type(knot_list_t) :: knots(3)                      !! KNOTs,dir (then nelem(dir) is size + 1)
    type(spline_spec_t) :: spline                      !! SPLIne
    character(8) :: type = ''                          !! Q1 Q1E9 Q2 IGA RIGID, LAYER of a SPLIne
    integer :: degree = 1                              !! of IGA
    type(enrich_t), allocatable :: enrich(:)
    integer :: q = 0, qz = 0                           !! QUADrature; 0: default of each element
    integer :: material = 0                            !! index into the model's materials
  end type patch_spec_t

end module patch_spec
