!> The body of a PATCh: chooses the builder of its element type, and builds trivariate splines.
module patch_body
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  use few_points, only: warn_few_points, splines_lack_points
  use mesh, only: mesh_t, body_face_t
  use nurbs, only: nurbs_t, elevate, insert_knots, is_rational
  use patch_check, only: check_patch, check_enrichment, hemisphere_degree
  use patch_draft, only: draft_t, span_t, append_draft, find_row, add_node, new_block, add_face, &
                         add_operators
  use patch_geometry, only: geometry_t, new_geometry, sphere_deviation, greville_points
  use patch_lagrange, only: build_lagrange
  use patch_nurbs, only: check_orientation, turn_right_handed, mirrored
  use patch_spec, only: patch_spec_t, GEO_BOX, GEO_HEMISPHERE, GEO_NURBS
  implicit none
  private
  public :: build_body

  !> Largest deviation of a hemisphere's spline from the sphere, relative to the radius, that causes
  !! no warning.
  real(wp), parameter :: ROUND = 0.02_wp

contains

  !> Append the body of a patch to the mesh, which is not changed if there is an error.
  subroutine build_body(spec, mesh, error)
    type(patch_spec_t), intent(in) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(patch_spec_t) :: s
    type(geometry_t) :: geo
    type(draft_t) :: draft
    logical :: turned
    integer :: b, degree, d

    s = spec
    if (.not. allocated(s%enrich)) allocate (s%enrich(0))
    do d = 1, 3
      if (allocated(s%knots(d)%u)) s%nelem(d) = size(s%knots(d)%u) + 1
    end do
    call check_patch(s, error)
    if (allocated(error)) return
    turned = .false.
    if (s%geometry == GEO_NURBS) call turn_right_handed(s%nurbs, turned)
    if (turned) call turn_records(s)
    call hemisphere_degree(s, degree, error)
    if (allocated(error)) return
    call new_geometry(s, degree, geo, error)
    if (allocated(error)) return
    call check_enrichment(s, geo, turned, error)
    if (allocated(error)) return
    if (s%geometry /= GEO_BOX) call check_orientation(geo%coarse, s%name, s%place, error)
    if (allocated(error)) return
    if (s%geometry == GEO_HEMISPHERE .and. degree > 1) call warn_not_round(s, geo, degree)
    if (s%type == 'IGA') then
      call build_iga(s, geo, draft, error)
    else if (s%type == 'RIGID') then
      s%degree = maxval(geo%coarse%dir%degree)
      s%q = 1 ! nothing is integrated over it
      call build_iga(s, geo, draft, error)
      if (allocated(error)) return
      do b = 1, size(draft%block)
        draft%block(b)%name = 'RIGId'
        draft%block(b)%row%source = 'rigid surface with prescribed motion'
        nullify (draft%block(b)%row%form, draft%block(b)%row%form_batch)
      end do
    else
      call build_lagrange(s, geo, draft, error)
    end if
    if (allocated(error)) return
    if (turned) call turn_faces(draft)
    call append_draft(draft, s, mesh)
  end subroutine build_body

  !> Warn if a hemisphere has so few elements that its spline is far from the sphere.
  subroutine warn_not_round(spec, geo, degree)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: degree !! of the spline
    real(wp) :: deviation

    if (geo%sampled) return ! its nodes lie on the sphere
    deviation = sphere_deviation(geo)
    if (deviation <= ROUND) return
    call warn("the surface of hemisphere '"//spec%name//"' deviates from the sphere by up to " &
              //to_text(100*deviation, 2)//' % of the radius, because its splines of degree ' &
              //to_text(degree)//' have only '//to_text(geo%n(1))//' x '//to_text(geo%n(2)) &
              //' elements', spec%place, 'use more elements: the page of PATCh lists the ' &
              //'deviation for each number of them')
  end subroutine warn_not_round

  !> Change the records that name faces or knots of direction 3, so that they refer to the reversed
  !! direction.
  subroutine turn_records(spec)
    type(patch_spec_t), intent(inout) :: spec
    integer :: i

    call log_line("patch     '"//spec%name//"' is left-handed: its direction 3 is reversed " &
                  //'internally, but faces keep their names')
    do i = 1, size(spec%enrich)
      if (spec%enrich(i)%face > 4) spec%enrich(i)%face = 11 - spec%enrich(i)%face
    end do
    if (allocated(spec%knots(3)%u)) then
      spec%knots(3)%u = mirrored(spec%knots(3)%u, spec%nurbs%dir(3)%knots)
    end if
  end subroutine turn_records

  !> Give the faces of direction 3 the names that they had before this direction was reversed.
  pure subroutine turn_faces(draft)
    type(draft_t), intent(inout) :: draft
    type(body_face_t) :: face
    integer :: i

    face = draft%face(5)
    draft%face(5) = draft%face(6)
    draft%face(6) = face
    draft%nface(5:6) = draft%nface([6, 5])
    do i = 1, draft%nnode
      if (btest(draft%mask(i), 4) .neqv. btest(draft%mask(i), 5)) then
        draft%mask(i) = ieor(draft%mask(i), 48) ! bits 4 and 5
      end if
    end do
  end subroutine turn_faces

  !> Make the control points, the block and the faces of a body of type IGA or RIGID by k-refinement
  !! (degree elevation, then knot insertion) of the geometry.
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
    real(wp), allocatable :: x(:, :)
    integer :: a, at(3), d, e, i, j, k, ib, mask, n(3), p

    call find_row(spec, 'IGA', row, error)
    if (allocated(error)) return
    p = spec%degree
    solid = geo%coarse
    do d = 1, 3
      call elevate(solid, d, p - solid%dir(d)%degree)
      call insert_knots(solid, d, geo%insert(d)%u)
      call add_operators(draft, solid%dir(d), span(d))
    end do
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
    cell%degree = p
    call new_block(draft, spec, 'IGA'//to_text(p), row, cell%degree, (p + 1)**3, product(geo%n), ib)
    call row%rule(cell, spec%q, spec%qz, draft%block(ib)%rule)
    if (spec%type == 'IGA' .and. spec%q > 0) then
      if (splines_lack_points([spec%q, spec%q, merge(spec%qz, spec%q, spec%qz > 0)], n, geo%n)) then
        call warn_few_points(spec, 'IGA'//to_text(p), 'QUADrature '//to_text(p + 1))
      end if
    end if
    associate (b => draft%block(ib))
      if (is_rational(solid)) allocate (b%ext%w(b%nen, product(geo%n)))
      do k = 1, geo%n(3)
        do j = 1, geo%n(2)
          do i = 1, geo%n(1)
            e = b%nelem + 1
            b%nelem = e
            b%ext%iop(:, e) = [span(1)%iop(i), span(2)%iop(j), span(3)%iop(k)]
            at = [span(1)%first(i), span(2)%first(j), span(3)%first(k)]
            b%conn(:, e) = reshape(node(at(1):at(1) + p, at(2):at(2) + p, at(3):at(3) + p), &
                                   [b%nen])
            if (allocated(b%ext%w)) then
              b%ext%w(:, e) = reshape(solid%cp(4, at(1):at(1) + p, at(2):at(2) + p, &
                                               at(3):at(3) + p), [b%nen])
            end if
            at = [i, j, k]
            do d = 1, 3
              if (at(d) == 1) call add_face(draft, 2*d - 1, ib, e, 2*d - 1)
              if (at(d) == geo%n(d)) call add_face(draft, 2*d, ib, e, 2*d)
            end do
          end do
        end do
      end do
    end associate
  end subroutine build_iga

end module patch_body
