!> The outer faces of one body as a surface on which points can be projected.
module input_skin
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_text, only: quoted
  use contact_pair, only: surface_t
  use contact_surface, only: build_surface
  use mesh, only: mesh_t, body_boundary, is_rigid
  use mesh_boundary, only: find_outer_faces
  use projection_search, only: grid_t, update_grid
  use projection_type, only: shape_t
  use surface_geometry, only: update_shape
  implicit none
  private
  public :: skin_t, make_skin, face_width, body_name

  type :: skin_t
    type(surface_t) :: surface
    type(shape_t) :: shape
    type(grid_t) :: grid
    logical :: exists = .false.
  end type skin_t

contains

  !> Make the skin of a body. There is none if the body has no faces, or if its faces do not form a
  !! surface.
  subroutine make_skin(mesh, body, skin)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body       !! 0: the elements that belong to no body
    type(skin_t), intent(out) :: skin
    type(error_t), allocatable :: error
    integer, allocatable :: block(:), elem(:), side(:)
    logical, allocatable :: own(:)

    if (body == 0) then
      call find_outer_faces(mesh, block, elem, side)
      own = mesh%block(block)%body == 0 .and. .not. is_rigid(mesh%block(block))
      block = pack(block, own)
      elem = pack(elem, own)
      side = pack(side, own)
    else
      call body_boundary(mesh, body, block, elem, side)
    end if
    if (size(elem) == 0) return
    call build_surface(mesh, block, elem, side, body_name(mesh, body), skin%surface, error)
    if (allocated(error)) return
    call update_shape(skin%surface, mesh%xr, skin%shape)
    call update_grid(skin%surface, skin%shape, skin%grid)
    skin%exists = .true.
  end subroutine make_skin

  !> Largest extent of a face [L].
  pure real(wp) function face_width(skin, e) result(width)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e

    width = maxval(skin%shape%high(:, e) - skin%shape%low(:, e))
  end function face_width

  !> Name of a body in a message.
  function body_name(mesh, body) result(text)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body       !! 0: the elements that belong to no body
    character(:), allocatable :: text

    text = 'the mesh'
    if (body > 0) text = quoted(mesh%body(body)%name)
  end function body_name

end module input_skin
