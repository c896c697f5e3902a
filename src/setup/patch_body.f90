!> From one PATCh to nodes, elements and faces of the mesh.
module patch_body
  use base_error, only: error_t
  use mesh, only: mesh_t
  use patch_spec, only: patch_spec_t, GEO_BOX
  use patch_check, only: check_patch, check_enrichment, hemisphere_degree
  use patch_nurbs, only: check_orientation
  use patch_geometry, only: geometry_t, new_geometry
  use patch_draft, only: draft_t, append_draft
  use patch_lagrange, only: build_lagrange
  use patch_iga, only: build_iga
  implicit none
  private
  public :: build_body

contains

  !> Append the body of a patch to the mesh; on an error the mesh is as it was.
  subroutine build_body(spec, mesh, error)
    type(patch_spec_t), intent(in) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(patch_spec_t) :: s
    type(geometry_t) :: geo
    type(draft_t) :: draft
    integer :: degree, d

    s = spec
    if (.not. allocated(s%enrich)) allocate (s%enrich(0))
    do d = 1, 3
      if (allocated(s%knots(d)%u)) s%nelem(d) = size(s%knots(d)%u) + 1
    end do
    call check_patch(s, error)
    if (allocated(error)) return
    call hemisphere_degree(s, degree, error)
    if (allocated(error)) return
    call new_geometry(s, degree, geo, error)
    if (allocated(error)) return
    call check_enrichment(s, geo, error)
    if (allocated(error)) return
    if (s%geometry /= GEO_BOX) call check_orientation(geo%coarse, s%name, s%place, error)
    if (allocated(error)) return
    if (s%type == 'IGA') then
      call build_iga(s, geo, draft, error)
    else if (s%type == 'RIGID') then
      s%degree = maxval(geo%coarse%dir%degree)
      s%q = 1 ! its points serve no integral
      call build_iga(s, geo, draft, error)
      if (.not. allocated(error)) call make_rigid(draft)
    else
      call build_lagrange(s, geo, draft, error)
    end if
    if (allocated(error)) return
    call append_draft(draft, s, mesh)
  end subroutine build_body

  !> Splines that are not solved for.
  subroutine make_rigid(draft)
    type(draft_t), intent(inout) :: draft
    integer :: b

    do b = 1, size(draft%block)
      draft%block(b)%name = 'RIGId'
      draft%block(b)%row%source = 'rigid surface, prescribed motion'
      nullify (draft%block(b)%row%form, draft%block(b)%row%form_batch)
    end do
  end subroutine make_rigid

end module patch_body
