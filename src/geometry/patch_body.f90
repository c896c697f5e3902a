!> From one PATCh to nodes, elements and faces of the mesh.
!!
!! Bodies of tri-variate splines.
module patch_body
  use base_error, only: error_t
  use mesh, only: mesh_t
  use patch_spec, only: patch_spec_t, GEO_BOX
  use patch_check, only: check_patch, check_enrichment, hemisphere_degree
  use patch_nurbs, only: check_orientation
  use patch_geometry, only: geometry_t, new_geometry, greville_points
  use patch_draft, only: draft_t, append_draft, find_row, span_t, add_node, new_block, add_face, &
      add_operators
  use patch_lagrange, only: build_lagrange
  use base_kinds, only: wp
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  use nurbs, only: nurbs_t, elevate, insert_knots, is_rational
  implicit none
  private
  public :: build_body, build_iga

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

  !> Control points, one block and faces of a body of type IGA p: k-refinement of the geometry.
  subroutine build_iga(spec, geo, draft, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error
    type(nurbs_t) :: solid
    type(span_t) :: span(3)
    type(element_t) :: row
    type(cell_t) :: cell
    integer, allocatable :: node(:, :, :)
    integer :: d, i, j, k, ib

    call find_row(spec, 'IGA', row, error)
    if (allocated(error)) return
    solid = geo%coarse
    do d = 1, 3
      call elevate(solid, d, spec%degree - solid%dir(d)%degree)
      call insert_knots(solid, d, geo%insert(d)%u)
      call add_operators(draft, solid%dir(d), span(d))
    end do
    call add_control_points(geo, solid, draft, node)
    cell%degree = spec%degree
    call new_block(draft, spec, 'IGA'//to_text(spec%degree), row, cell%degree, &
                   (spec%degree + 1)**3, product(geo%n), ib)
    if (is_rational(solid)) allocate (draft%block(ib)%ext%w(draft%block(ib)%nen, product(geo%n)))
    call row%rule(cell, spec%q, spec%qz, draft%block(ib)%rule)
    do k = 1, geo%n(3)
      do j = 1, geo%n(2)
        do i = 1, geo%n(1)
          call add_element(geo, solid, span, node, [i, j, k], ib, draft)
        end do
      end do
    end do
  end subroutine build_iga

  subroutine add_control_points(geo, solid, draft, node)
    type(geometry_t), intent(in) :: geo
    type(nurbs_t), intent(in) :: solid
    type(draft_t), intent(inout) :: draft
    integer, allocatable, intent(out) :: node(:, :, :)
    real(wp), allocatable :: x(:, :)
    integer :: n(3), at(3), i, j, k, d, a, mask

    n = [(size(solid%cp, d), d=2, 4)]
    allocate (node(n(1), n(2), n(3)))
    call greville_points(geo, solid, [1, 2, 3], [0.0_wp, 0.0_wp, 0.0_wp], x)
    a = 0
    do k = 1, n(3)
      do j = 1, n(2)
        do i = 1, n(1)
          a = a + 1
          at = [i, j, k]
          mask = 0
          do d = 1, 3
            if (at(d) == 1) mask = ibset(mask, 2*d - 2)
            if (at(d) == n(d)) mask = ibset(mask, 2*d - 1)
          end do
          call add_node(draft, x(:, a), .true., mask, node(i, j, k))
        end do
      end do
    end do
  end subroutine add_control_points

  subroutine add_element(geo, solid, span, node, cell, ib, draft)
    type(geometry_t), intent(in) :: geo
    type(nurbs_t), intent(in) :: solid
    type(span_t), intent(in) :: span(3)
    integer, intent(in) :: node(:, :, :), cell(3), ib
    type(draft_t), intent(inout) :: draft
    integer :: at(3), d, e, i, j, k, a, p

    associate (b => draft%block(ib))
      e = b%nelem + 1
      b%nelem = e
      p = b%ext%degree(1)
      do d = 1, 3
        b%ext%iop(d, e) = span(d)%iop(cell(d))
        at(d) = span(d)%first(cell(d))
      end do
      a = 0
      do k = at(3), at(3) + p
        do j = at(2), at(2) + p
          do i = at(1), at(1) + p
            a = a + 1
            b%conn(a, e) = node(i, j, k)
            if (allocated(b%ext%w)) b%ext%w(a, e) = solid%cp(4, i, j, k)
          end do
        end do
      end do
    end associate
    do d = 1, 3
      if (cell(d) == 1) call add_face(draft, 2*d - 1, ib, e, 2*d - 1)
      if (cell(d) == geo%n(d)) call add_face(draft, 2*d, ib, e, 2*d)
    end do
  end subroutine add_element

end module patch_body
