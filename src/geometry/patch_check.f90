!> Checks of a patch before it is meshed.
module patch_check
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use patch_geometry, only: geometry_t
  use patch_nurbs, only: check_nurbs, MAX_DEGREE
  use patch_spec, only: patch_spec_t, enrich_t, GEO_BOX, GEO_HEMISPHERE, GEO_NURBS
  implicit none
  private
  public :: check_patch, check_enrichment, hemisphere_degree, face_name

  integer(i8), parameter :: MAX_NODE = 200000000_i8 !! per body; 3*MAX_NODE fits into an integer
  character(2), parameter :: FACE(6) = ['1-', '1+', '2-', '2+', '3-', '3+']

contains

  !> Name of a face, as in the deck.
  pure function face_name(f) result(name)
    integer, intent(in) :: f
    character(2) :: name

    name = FACE(f)
  end function face_name

  !> Check the geometry, the element type and the numbers of elements, before anything is allocated.
  subroutine check_patch(spec, error)
    type(patch_spec_t), intent(in) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer(i8) :: n, along !! number of nodes; intervals between nodes along an edge of an element
    integer :: d

    select case (spec%geometry)
    case (GEO_BOX)
      d = minloc(spec%length, 1)
      if (.not. spec%length(d) > 0.0_wp) then
        call fail_patch(spec, 'has a box of length '//to_text(spec%length(d))//' in direction ' &
                        //to_text(d), 'lengths must be positive', error)
      end if
    case (GEO_HEMISPHERE)
      if (.not. (spec%thickness > 0.0_wp .and. spec%radius > spec%thickness)) then
        call fail_patch(spec, 'has a hemisphere of radius '//to_text(spec%radius) &
                        //' and thickness '//to_text(spec%thickness), &
                        'the thickness must be between 0 and the radius', error)
      end if
    case (GEO_NURBS)
      call check_nurbs(spec%nurbs, 3, "patch '"//spec%name//"'", spec%place, error)
    case default
      call fail_patch(spec, 'has no geometry', 'give BOX, HEMIsphere, NPATch or FILE', error)
    end select
    if (allocated(error)) return
    d = minloc(spec%nelem, 1)
    if (spec%nelem(d) < 1) then
      call fail_patch(spec, 'has '//to_text(spec%nelem(d))//' elements in direction '//to_text(d), &
                      'ELEMents n1 n2 n3 needs positive numbers', error)
      return
    end if
    select case (spec%type)
    case ('Q1', 'Q1E9', 'Q2', 'RIGID')
    case ('IGA')
      if (spec%degree < 1 .or. spec%degree > MAX_DEGREE) then
        call fail_patch(spec, 'has TYPE IGA of degree '//to_text(spec%degree), &
                        'degrees must be from 1 to '//to_text(MAX_DEGREE), error)
      end if
    case default
      call fail_patch(spec, "has the unknown type '"//trim(spec%type)//"'", &
                      'known types of solids: Q1 Q1E9 Q2 IGA', error)
    end select
    if (allocated(error)) return
    along = merge(2, 1, spec%type == 'Q2')
    n = 1
    do d = 1, 3
      n = n*(along*spec%nelem(d) + MAX_DEGREE)
      if (n <= MAX_NODE) cycle
      call fail_patch(spec, 'has '//to_text(spec%nelem(1))//' x '//to_text(spec%nelem(2)) &
                      //' x '//to_text(spec%nelem(3))//' elements, which is too many', &
                      'a body may have at most '//to_text(int(MAX_NODE))//' nodes', error)
      return
    end do
  end subroutine check_patch

  !> Report an error of the patch as a whole.
  subroutine fail_patch(spec, what, hint, error)
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: what, hint
    type(error_t), allocatable, intent(out) :: error

    call fail(error, DECK_ERROR, "patch '"//spec%name//"' "//what, spec%place, hint)
  end subroutine fail_patch

  !> Check the orders that ENRIch gives to faces, and find the degree of the surface of a
  !! hemisphere.
  subroutine hemisphere_degree(spec, degree, error)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(out) :: degree
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(spec%enrich)
      associate (e => spec%enrich(i))
        if (e%degree >= 1 .and. e%degree <= MAX_DEGREE .and. e%raise >= 0 &
            .and. e%raise <= MAX_DEGREE - e%degree) cycle
        call fail(error, DECK_ERROR, 'the face has order '//to_text(e%degree)//' with RAISe ' &
                  //to_text(e%raise), e%place, 'orders must be from 1 to '//to_text(MAX_DEGREE) &
                  //', before and after RAISe')
      end associate
      return
    end do
    degree = 1
    if (spec%type == 'IGA') degree = spec%degree
    if (spec%type == 'Q2' .or. spec%type == 'RIGID') degree = 2
    if (size(spec%enrich) > 0) degree = spec%enrich(1)%degree
    if (spec%geometry /= GEO_HEMISPHERE) return
    do i = 2, size(spec%enrich)
      if (spec%enrich(i)%degree == degree) cycle
      call fail(error, DECK_ERROR, "the faces of hemisphere '"//spec%name//"' have orders " &
                //to_text(degree)//' and '//to_text(spec%enrich(i)%degree), spec%enrich(i)%place, &
                'the faces of a hemisphere belong to one spline: give them the same order')
      return
    end do
  end subroutine hemisphere_degree

  !> Check the ENRIch records against the elements, the geometry and each other.
  subroutine check_enrichment(spec, geo, turned, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    logical, intent(in) :: turned        !! direction 3 has been reversed; messages name old faces
    type(error_t), allocatable, intent(out) :: error
    logical :: along(3)
    integer :: i, j, d

    along = .false.
    do i = 1, size(spec%enrich)
      call check_record(spec, geo, spec%enrich(i), turned, error)
      if (allocated(error)) return
      do j = 1, i - 1
        call check_pair(spec, spec%enrich(j), spec%enrich(i), turned, error)
        if (allocated(error)) return
      end do
      along((spec%enrich(i)%face + 1)/2) = .true.
      if (.not. all(along)) cycle
      call fail(error, DECK_ERROR, "three enriched faces of patch '"//spec%name &
                //"' meet in a corner", spec%enrich(i)%place, &
                'only two of the directions 1, 2, 3 can have enriched faces in one patch')
      return
    end do
    if (spec%type /= 'IGA') return
    do d = 1, 3
      if (geo%coarse%dir(d)%degree <= spec%degree) cycle
      call fail_patch(spec, 'has degree '//to_text(geo%coarse%dir(d)%degree)//' in direction ' &
                      //to_text(d)//', more than the degree '//to_text(spec%degree) &
                      //' of its elements', 'use TYPE IGA '//to_text(geo%coarse%dir(d)%degree), &
                      error)
      return
    end do
  end subroutine check_enrichment

  !> Name of a face, as in the deck, before direction 3 was reversed.
  pure function deck_name(f, turned) result(name)
    integer, intent(in) :: f
    logical, intent(in) :: turned
    character(2) :: name

    name = FACE(merge(11 - f, f, turned .and. f > 4))
  end function deck_name

  !> Check one ENRIch record.
  subroutine check_record(spec, geo, e, turned, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(enrich_t), intent(in) :: e
    logical, intent(in) :: turned
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: what
    integer :: axis, d

    axis = (e%face + 1)/2
    what = 'face '//deck_name(e%face, turned)//" of patch '"//spec%name//"' has "
    if (spec%type == 'IGA') then
      call fail(error, DECK_ERROR, 'elements of type IGA cannot have ENRIch', e%place, &
                'their faces are splines already: remove ENRIch, or use TYPE Q1, Q1E9 or Q2')
    else if (e%eas .and. spec%type == 'Q2') then
      call fail(error, DECK_ERROR, 'elements of type Q2 cannot have ENRIch EAS', e%place, &
                'enhanced modes belong to TYPE Q1 and Q1E9; Q2 does not need them')
    else if (product(pack(int(geo%n, i8)*(e%raise + 1) + e%degree, [1, 2, 3] /= axis)) &
             > MAX_NODE) then
      call fail(error, DECK_ERROR, what//'too many control points', e%place, &
                'a body may have at most '//to_text(int(MAX_NODE))//' nodes')
    end if
    if (allocated(error)) return
    do d = 1, 3
      if (d == axis .or. geo%coarse%dir(d)%degree <= e%degree) cycle
      call fail(error, DECK_ERROR, what//'degree '//to_text(geo%coarse%dir(d)%degree) &
                //' in direction '//to_text(d)//', more than its order '//to_text(e%degree), &
                e%place, 'use ENRIch '//deck_name(e%face, turned)//' ' &
                //to_text(geo%coarse%dir(d)%degree))
      return
    end do
  end subroutine check_record

  !> Check that two ENRIch records agree; an error is reported at b, the later one.
  subroutine check_pair(spec, a, b, turned, error)
    type(patch_spec_t), intent(in) :: spec
    type(enrich_t), intent(in) :: a, b
    logical, intent(in) :: turned
    type(error_t), allocatable, intent(out) :: error
    integer :: axis

    axis = (b%face + 1)/2
    if (a%face == b%face) then
      call fail(error, DECK_ERROR, 'duplicate ENRIch of face '//deck_name(b%face, turned) &
                //" of patch '"//spec%name//"'", b%place)
    else if ((a%face + 1)/2 == axis) then
      if (spec%nelem(axis) > 1) return
      call fail(error, DECK_ERROR, 'faces '//deck_name(a%face, turned)//' and ' &
                //deck_name(b%face, turned) &
                //' are both enriched but share their only layer of elements', b%place, &
                'give at least 2 elements in direction '//to_text(axis))
    else if (a%degree /= b%degree .or. a%raise /= b%raise) then
      call fail(error, DECK_ERROR, 'faces '//deck_name(a%face, turned)//' and ' &
                //deck_name(b%face, turned)//' share an edge but have orders ' &
                //to_text(a%degree)//' (RAISe '//to_text(a%raise) &
                //') and '//to_text(b%degree)//' (RAISe '//to_text(b%raise)//')', b%place, &
                'their common edge is one curve: give both faces the same order and RAISe')
    end if
  end subroutine check_pair

end module patch_check
