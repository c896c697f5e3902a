!> What a SPLIne block says beside what it has in common with a PATCh.
module spline_spec
  use base_error, only: place_t
  use constraint, only: constraint_t
  use spline_surface, only: spline_surface_t
  implicit none
  private
  public :: spline_spec_t

  type :: spline_spec_t
    type(spline_surface_t) :: surface
    logical :: reverse = .false.          !! REVErse: the outside is the other side
    type(place_t) :: reverse_place
    logical :: has_layer = .false.
    integer, allocatable :: inner(:, :)   !! (4, nelem) inner nodes, numbers of the mesh
    character(:), allocatable :: mesh     !! MESH that they belong to; not allocated: the deck
    type(place_t) :: layer_place, mesh_place
    type(constraint_t) :: constraint      !! CONStraint, numbers of the mesh
    type(place_t) :: constraint_place
    logical :: eas = .false., tapered = .false.
  end type spline_spec_t

end module spline_spec
