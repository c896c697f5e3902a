!> The data of a PATCh, MESH or SPLIne block before it becomes part of the mesh, and the map that
!! its ROTAte, TRANslate and SCALe records define.
module patch_spec
  use base_kinds, only: wp
  use base_error, only: place_t
  use nurbs, only: nurbs_t
  use constraint, only: constraint_t
  use spline_surface, only: spline_surface_t
  implicit none
  private
  public :: patch_spec_t, enrich_t, placement_t, compose, rotation

  !> The data that a SPLIne block has but a PATCh block does not.
  type :: spline_spec_t
    type(spline_surface_t) :: surface
    logical :: reverse = .false.          !! REVErse: the normal is reversed
    type(place_t) :: reverse_place
    logical :: has_layer = .false.
    integer, allocatable :: inner(:, :)   !! (4, nelem) inner nodes, as numbered in LAYEr's file
    !> MESH that contains the inner nodes; not allocated if they are nodes of the deck.
    character(:), allocatable :: mesh
    type(place_t) :: layer_place, mesh_place
    type(constraint_t) :: constraint      !! CONStraint, with the node numbers of its file
    type(place_t) :: constraint_place
    logical :: eas = .false., tapered = .false.
  end type spline_spec_t

  integer, parameter, public :: GEO_NONE = 0, GEO_BOX = 1, GEO_HEMISPHERE = 2, GEO_NURBS = 3, &
                                GEO_SPLINE = 4, GEO_MESH = 5

  !> A record `ENRIch face p [RAISe t] [EAS [TAPEred]]`.
  type :: enrich_t
    integer :: face = 0          !! 1 to 6: 1- 1+ 2- 2+ 3- 3+
    integer :: degree = 0
    integer :: raise = 0
    logical :: eas = .false., tapered = .false.
    type(place_t) :: place
  end type enrich_t

  !> A ROTAte, TRANslate or SCALe record. These records are applied in order.
  type :: placement_t
    logical :: rotates = .false.
    real(wp) :: point(3) = 0.0_wp  !! point on the axis, or the translation [L]
    real(wp) :: axis(3) = 0.0_wp   !! unit vector along the axis
    real(wp) :: angle = 0.0_wp     !! [rad]
    real(wp) :: scale = 0.0_wp     !! factor of SCALe; 0: not a SCALe record
  end type placement_t

  !> A list of knots of one direction, such as the interior knots that KNOTs gives.
  type, public :: knot_list_t
    real(wp), allocatable :: u(:)
  end type knot_list_t

  !> The data of a PATCh block; MESH and SPLIne use some of them.
  type :: patch_spec_t
    character(:), allocatable :: name
    type(place_t) :: place
    integer :: geometry = GEO_NONE
    real(wp) :: origin(3) = 0.0_wp, length(3) = 0.0_wp !! BOX
    real(wp) :: radius = 0.0_wp, thickness = 0.0_wp    !! HEMIsphere, with its centre in `origin`
    type(nurbs_t) :: nurbs                             !! NPATch or FILE
    type(placement_t), allocatable :: placement(:)
    integer :: nelem(3) = 0                            !! ELEMents
    type(knot_list_t) :: knots(3)                      !! KNOTs,dir; n knots make n + 1 elements
    type(spline_spec_t) :: spline                      !! SPLIne
    character(8) :: type = ''                          !! Q1 Q1E9 Q2 IGA RIGID; SPLIne: LAYER, RIGID
    integer :: degree = 1                              !! degree of IGA
    type(enrich_t), allocatable :: enrich(:)
    integer :: q = 0, qz = 0                           !! QUADrature; 0: the default of each element
    integer :: material = 0                            !! index into the materials of the model
  end type patch_spec_t

contains

  !> Combine all placements, in the order of their records, into x -> turn x + shift.
  subroutine compose(placement, turn, shift)
    type(placement_t), intent(in) :: placement(:)
    real(wp), intent(out) :: turn(3, 3), shift(3) !! [-], [L]
    real(wp) :: r(3, 3)
    integer :: i

    turn = 0.0_wp
    shift = 0.0_wp
    do i = 1, 3
      turn(i, i) = 1.0_wp
    end do
    do i = 1, size(placement)
      associate (p => placement(i))
        if (p%rotates) then
          r = rotation(p%axis, p%angle)
          turn = matmul(r, turn)
          shift = matmul(r, shift - p%point) + p%point
        else if (p%scale > 0.0_wp) then
          turn = p%scale*turn
          shift = p%scale*shift
        else
          shift = shift + p%point
        end if
      end associate
    end do
  end subroutine compose

  !> Matrix of the rotation about a unit axis (Rodrigues' formula); it is exact for right angles
  !! about a coordinate axis.
  pure function rotation(axis, angle) result(r)
    real(wp), intent(in) :: axis(3), angle
    real(wp) :: r(3, 3), c, s
    integer :: i, j

    c = clean(cos(angle))
    s = clean(sin(angle))
    do j = 1, 3
      do i = 1, 3
        r(i, j) = (1.0_wp - c)*axis(i)*axis(j)
      end do
      r(j, j) = r(j, j) + c
    end do
    r(2, 1) = r(2, 1) + s*axis(3)
    r(1, 2) = r(1, 2) - s*axis(3)
    r(3, 2) = r(3, 2) + s*axis(1)
    r(2, 3) = r(2, 3) - s*axis(1)
    r(1, 3) = r(1, 3) + s*axis(2)
    r(3, 1) = r(3, 1) - s*axis(2)
  end function rotation

  !> Correct the rounding error of a cosine or sine that should be 0, 1 or -1.
  pure elemental real(wp) function clean(c)
    real(wp), intent(in) :: c

    clean = c
    if (abs(c) < 8*epsilon(c)) clean = 0.0_wp
    if (1.0_wp - abs(c) < 4*epsilon(c)) clean = sign(1.0_wp, c)
  end function clean

end module patch_spec
