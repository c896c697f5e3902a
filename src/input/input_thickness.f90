!> Thickness of a body behind its faces.
module input_thickness
  use base_error, only: error_t
  use base_kinds, only: wp
  use input_draft, only: draft_t
  use input_npatch, only: npatch_geometry, npatch_named
  use nurbs, only: nurbs_t, evaluate
  use patch_check, only: hemisphere_degree
  use patch_geometry, only: geometry_t, new_geometry
  use patch_spec, only: GEO_SPLINE
  use spline_check, only: spline_thickness
  use word_patch, only: patch_named
  implicit none
  private
  public :: body_thickness

  integer, parameter :: NSAMPLE = 17         !! sampling points in each direction of a face
  real(wp), parameter :: NOTHING = 1.0e-6_wp !! faces meet where their distance is below this
  !! fraction of the largest one

contains

  !> Smallest distance [L] between corresponding points of the named faces and of the opposite
  !! faces, or the thickness of the layer of a SPLIne. It is 0 if two such faces meet, if the
  !! SPLIne has no layer, or if the geometry has an error. Faces at the seam of a closed patch,
  !! which coincide, do not count beside others. The patch is measured before it is
  !! refined and placed; placement does not change distances.
  function body_thickness(draft, name, mask) result(thickness)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: name  !! name of a PATCh, NPATch or SPLIne
    integer, intent(in) :: mask       !! bit f-1 for each face f
    real(wp) :: thickness
    type(nurbs_t) :: patch
    type(geometry_t) :: geo
    type(error_t), allocatable :: error
    real(wp) :: low(3), high(3), u(3), from(3), to(3), least(3), width(3)
    logical :: counts(3)
    integer :: a, b, d, degree, i, j, k, p

    thickness = 0.0_wp
    p = patch_named(draft, name)
    if (p > 0) then
      associate (spec => draft%patch(p)%spec)
        if (spec%geometry == GEO_SPLINE) then ! a layer under a surface has its own thickness
          if (spec%spline%has_layer) then
            thickness = spline_thickness(spec%spline%surface, -1.0_wp) ! a_1 x a_2 points inwards
          end if
          return
        end if
        call hemisphere_degree(spec, degree, error)
        if (.not. allocated(error)) call new_geometry(spec, degree, geo, error)
        if (.not. allocated(error)) patch = geo%coarse
      end associate
    else
      k = npatch_named(draft, name)
      if (k > 0) call npatch_geometry(draft, k, patch, error)
    end if
    if (allocated(error)) return
    least = huge(least)
    width = 0.0_wp
    do d = 1, 3
      if (iand(mask, 3*4**(d - 1)) == 0) cycle
      a = mod(d, 3) + 1
      b = mod(d + 1, 3) + 1
      do i = 1, 3
        associate (knots => patch%dir(i)%knots)
          low(i) = knots(1)
          high(i) = knots(size(knots))
        end associate
      end do
      do j = 0, NSAMPLE - 1
        do i = 0, NSAMPLE - 1
          u(a) = low(a) + (high(a) - low(a))*i/(NSAMPLE - 1)
          u(b) = low(b) + (high(b) - low(b))*j/(NSAMPLE - 1)
          u(d) = low(d)
          call evaluate(patch, u, from)
          u(d) = high(d)
          call evaluate(patch, u, to)
          least(d) = min(least(d), norm2(to - from))
          width(d) = max(width(d), norm2(to - from))
        end do
      end do
    end do
    counts = width > NOTHING*maxval(width)
    if (.not. any(counts)) return
    if (minval(least, counts) > NOTHING*maxval(width)) thickness = minval(least, counts)
  end function body_thickness

end module input_thickness
