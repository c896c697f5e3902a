!> What the words of the mesh part said, before their names and numbers are resolved.
module setup_entry
  use base_kinds, only: wp
  use base_error, only: place_t
  use boundary, only: motion_t, pressure_t
  use curve_type, only: quantity_t
  use mesh_spec, only: mesh_spec_t
  use patch_spec, only: patch_spec_t
  use setup_where, only: where_t
  implicit none
  private
  public :: patch_entry_t, npatch_t, knot_vector_t, support_t, move_t, press_t, column_t, &
            curve_entry_t, request_t, tie_t, control_t

  !> FEAP's control record; zeros are counted.
  type :: control_t
    integer :: numnp = 0, numel = 0, nummat = 0, nen = 0
    type(place_t) :: place
  end type control_t

  !> A PATCh, MESH or SPLIne before its names and numbers are resolved.
  type :: patch_entry_t
    type(patch_spec_t) :: spec
    integer :: material = 0            !! the user's number
    integer :: npatch = 0              !! its geometry is this NPATch
    type(mesh_spec_t) :: mesh          !! MESH
    type(place_t) :: material_place, npatch_place
  end type patch_entry_t

  !> NPATch solid: a tri-variate patch by the numbers of its knot vectors and control points.
  type :: npatch_t
    integer :: material = 0
    integer :: n(3) = 0                !! control points
    integer :: knot(3) = 0             !! numbers of the knot vectors
    integer, allocatable :: node(:, :, :) !! (n1, n2, n3)
    logical :: is_geometry = .false.   !! a PATCh uses it
    type(place_t) :: place
  end type npatch_t

  !> KNOTs.
  type :: knot_vector_t
    integer :: number = 0
    real(wp), allocatable :: u(:)
    type(place_t) :: place
  end type knot_vector_t

  !> FIX.
  type :: support_t
    type(where_t) :: at
    integer :: code(3) = 0
  end type support_t

  !> MOVE.
  type :: move_t
    type(where_t) :: at
    type(motion_t) :: motion
  end type move_t

  !> PRESsure.
  type :: press_t
    type(where_t) :: at
    type(pressure_t) :: pressure
  end type press_t

  !> One record of a CURVe.
  type :: column_t
    type(where_t) :: at                !! kind 0: none is needed
    type(quantity_t) :: quantity
    character(:), allocatable :: body  !! name of a patch; not allocated: none
    type(place_t) :: body_place
    character(:), allocatable :: contact !! name of a contact; not allocated: none
    type(place_t) :: contact_place
  end type column_t

  type :: curve_entry_t
    character(:), allocatable :: name
    type(place_t) :: place
    type(column_t), allocatable :: column(:)
  end type curve_entry_t

  !> A record of EBOU EDIS EFOR EPRO CBOU CDIS CFOR CSUR, applied at the END of the mesh.
  type :: request_t
    integer :: kind = 0
    logical :: adds = .false.
    integer :: direction = 0           !! of a plane; 0: a point or a surface
    real(wp) :: at(3) = 0.0_wp         !! point; at(1) is a plane's coordinate [L]
    real(wp) :: gap = -1.0_wp          !! GAP; negative: FEAP's default
    real(wp) :: value(3) = 0.0_wp
    real(wp), allocatable :: surface(:, :) !! (4, 9) points of a surface [L] and pressures [F/L^2]
    type(place_t) :: place
  end type request_t

  !> TIE.
  type :: tie_t
    integer :: from = 1, to = huge(1)  !! nodes
    integer :: material(2) = 0         !! the user's numbers; 0: all
    integer :: direction = 0           !! of a plane; 0: everywhere
    real(wp) :: coordinate = 0.0_wp    !! [L]
    real(wp) :: tolerance = 0.0_wp     !! share of the mesh's extent; 0: FEAP's default
    type(place_t) :: place
  end type tie_t

end module setup_entry
