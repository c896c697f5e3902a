!> What a MESH block says, before its body is made.
module mesh_spec
  use base_error, only: place_t
  use constraint, only: constraint_t
  use mesh_file, only: mesh_file_t
  use patch_spec, only: patch_spec_t
  use patch_text, only: text_t
  implicit none
  private
  public :: mesh_spec_t, mesh_material_t

  !> MATErial m [group].
  type :: mesh_material_t
    integer :: number = 0                  !! the user's number
    integer :: index = 0                   !! in the model's materials
    character(:), allocatable :: group     !! not allocated: all elements
    type(place_t) :: place, group_place
  end type mesh_material_t

  type :: mesh_spec_t
    type(patch_spec_t) :: spec             !! name, place, placement and type of the hexahedra
    type(mesh_file_t) :: file
    type(text_t) :: text                   !! of the file, for what is wrong with it
    type(mesh_material_t), allocatable :: material(:)
    type(constraint_t) :: constraint       !! hanging nodes, by their numbers in the file
    type(place_t) :: constraint_place
  end type mesh_spec_t

end module mesh_spec
