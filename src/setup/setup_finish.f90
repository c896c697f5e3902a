!> At the END of the mesh: from what was read to a model that can be solved.
module setup_finish
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use mesh, only: mesh_t
  use model, only: model_t
  use model_basis, only: tabulate_basis
  use rigid_block, only: is_rigid
  use patch_body, only: build_body
  use patch_spec, only: GEO_SPLINE, GEO_MESH
  use setup_aside, only: find_unread
  use setup_apply, only: apply_conditions, note_loose
  use setup_build, only: build_t
  use setup_check, only: check_references
  use setup_constraint, only: close_constraints, release_slaves
  use setup_contact_build, only: build_contacts
  use setup_lists, only: MAX_NUMBER
  use setup_jacobian, only: check_jacobians
  use setup_loads, only: integrate_loads
  use setup_material, only: material_index
  use setup_mesh, only: make_mesh, count_mesh
  use setup_mesh_body, only: make_mesh_body
  use setup_rigid, only: hold_rigid
  use setup_resolve, only: resolve_supports, resolve_loads, resolve_curves
  use setup_solid, only: npatch_geometry, append_npatch
  use setup_spline_body, only: make_spline
  use setup_tie, only: tie_nodes
  implicit none
  private
  public :: finish

contains

  !> Each stage needs the one before: errors of a stage are collected, then it ends.
  subroutine finish(build)
    type(build_t), intent(inout) :: build

    call check_references(build)
    if (.not. build%incomplete) call count_mesh(build)
    if (build%errors%count() > 0) return
    associate (model => build%model)
      call make_mesh(build, model%mesh)
      if (build%errors%count() == 0) call make_bodies(build, model%mesh)
      if (build%errors%count() > 0) return
      call mark_used(model%mesh)
      call check_size(build, model%mesh)
      if (build%errors%count() > 0) return
      call tabulate_basis(model%mesh) ! surface loads ask for its rules
      call apply_conditions(build, model%mesh, model%bc)
      call tie_nodes(build, model%mesh, model%bc)
      call close_constraints(build, model%mesh)
      if (build%errors%count() > 0) return
      call resolve_supports(build, model)
      call hold_rigid(build, model)
      call release_slaves(build, model%mesh, model%bc)
      call resolve_loads(build, model)
      call note_loose(build, model%mesh, model%bc)
      call find_unread(build%aside, model%unread)
      call resolve_curves(build, model)
      if (build%errors%count() > 0) return
      call check_jacobians(build, model%mesh)
      if (build%errors%count() > 0) return
      call build_contacts(build, model)
      if (build%errors%count() > 0) return
      call integrate_loads(model)
    end associate
  end subroutine finish

  !> NPATch bodies on the given control points, then the patches in deck order.
  subroutine make_bodies(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable :: error
    integer :: i

    do i = 1, size(build%npatch)
      if (build%npatch(i)%is_geometry) cycle
      call append_npatch(build, i, mesh, error)
      if (allocated(error)) call build%errors%add(error)
    end do
    do i = 1, size(build%patch)
      associate (p => build%patch(i))
        p%spec%material = material_index(build, p%material)
        if (p%spec%geometry == GEO_SPLINE) then
          call make_spline(build, p%spec, mesh, error)
        else if (p%spec%geometry == GEO_MESH) then
          call make_mesh_body(build, i, mesh, error)
        else
          if (p%npatch > 0) call npatch_geometry(build, p%npatch, p%spec%nurbs, error)
          if (.not. allocated(error)) call build_body(p%spec, mesh, error)
        end if
      end associate
      if (allocated(error)) call build%errors%add(error)
    end do
  end subroutine make_bodies

  !> Nodes that elements use.
  subroutine mark_used(mesh)
    type(mesh_t), intent(inout) :: mesh
    integer :: b, e

    mesh%used = .false.
    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        mesh%used(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
  end subroutine mark_used

  !> Neither nothing nor too much.
  subroutine check_size(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error

    if (any(mesh%used) .and. all(is_rigid(mesh%block))) then
      call fail(error, DECK_ERROR, 'all bodies are rigid', build%control%place, &
                'give a body that can be deformed')
    else if (.not. any(mesh%used)) then
      call fail(error, DECK_ERROR, 'the mesh has no elements', build%control%place, &
                'give ELEMents, BLOCk, NPATch, PATCh or MESH')
    else if (mesh%nnode > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'the mesh has '//to_text(mesh%nnode)//' nodes', &
                build%control%place, &
                'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
    end if
    if (allocated(error)) call build%errors%add(error)
  end subroutine check_size

end module setup_finish
