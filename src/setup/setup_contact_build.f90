!> Contacts: from names of faces to surfaces, laws with all their numbers, and integration points.
module setup_contact_build
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, to_text
  use contact_pair, only: contact_t
  use contact_spec, only: contact_spec_t
  use contact_surface, only: build_surface, tabulate_contact
  use model, only: model_t
  use patch_check, only: face_name
  use setup_build, only: build_t
  use setup_contact_auto, only: element_areas, auto_penalty
  use setup_faces, only: find_faces
  use setup_rigid, only: is_rigid_patch
  use setup_thickness, only: body_thickness
  use setup_where, only: where_t, body_index
  implicit none
  private
  public :: build_contacts

  integer, parameter :: MOST_POINTS = 10000000 !! of a surface
  real(wp), parameter :: COLLAPSED = 1.0e-10_wp !! area over width^2 of an element that has none [-]

contains

  !> After TIE, on a tabulated mesh. Errors go to the list.
  subroutine build_contacts(build, model)
    type(build_t), intent(inout) :: build
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer :: i

    deallocate (model%contact)
    allocate (model%contact(size(build%contact)))
    do i = 1, size(build%contact)
      call make_contact(build, build%contact(i), model, model%contact(i), error)
      if (allocated(error)) call build%errors%add(error)
    end do
  end subroutine build_contacts

  subroutine make_contact(build, spec, model, contact, error)
    type(build_t), intent(in) :: build
    type(contact_spec_t), intent(in) :: spec
    type(model_t), intent(in) :: model
    type(contact_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer :: k

    contact%name = spec%name
    contact%place = spec%place
    do k = 1, 2
      call make_side(build, spec, k, model, contact, error)
      if (allocated(error)) return
    end do
    call count_points(spec, contact, error)
    if (allocated(error)) return
    contact%ncell = spec%ncell
    call tabulate_contact(contact, spec%n(1), spec%n(2))
    do k = 1, 2
      call check_side(spec, k, model, contact, error)
      if (allocated(error)) return
    end do
    call set_depth(spec, contact, error)
    if (.not. allocated(error)) call set_laws(spec, model, contact)
  end subroutine make_contact

  !> Not more points than the program counts.
  subroutine count_points(spec, contact, error)
    type(contact_spec_t), intent(in) :: spec
    type(contact_t), intent(in) :: contact
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: n

    n = real(product(spec%n), wp)*maxval(contact%side%nelem)
    if (spec%ncell > 1) n = n*(1 + spec%ncell**2)
    if (n <= MOST_POINTS) return
    call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//' has '//to_text(n) &
              //' points on a side', contact%place, 'a surface has at most '//to_text(MOST_POINTS) &
              //' points: give fewer by QUADrature')
  end subroutine count_points

  !> Surface k.
  subroutine make_side(build, spec, k, model, contact, error)
    type(build_t), intent(in) :: build
    type(contact_spec_t), intent(in) :: spec
    integer, intent(in) :: k
    type(model_t), intent(in) :: model
    type(contact_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: block(:), elem(:), side(:)
    integer :: b

    associate (at => spec%at(k), s => contact%side(k))
      call find_faces(model%mesh, at, block, elem, side, error)
      if (allocated(error)) return
      call build_surface(model%mesh, block, elem, side, surface_name(at), s, error)
      if (allocated(error)) then
        if (.not. allocated(error%place%file)) error%place = at%face_place
        return
      end if
      s%rigid = is_rigid_patch(build, at%body)
      if (s%rigid) return
      b = body_index(model%mesh, at%body)
      s%thickness = model%mesh%body(b)%thickness
      if (.not. s%thickness > 0.0_wp) s%thickness = body_thickness(build, at%body, at%mask)
    end associate
  end subroutine make_side

  !> As in the deck: hemi 3-.
  function surface_name(at) result(name)
    type(where_t), intent(in) :: at
    character(:), allocatable :: name

    select case (at%mask)
    case (0)
      name = at%body//' '//at%face
    case (15)
      name = at%body//' SIDEs'
    case (63)
      name = at%body//' ALL'
    case default
      name = at%body//' '//face_name(trailz(at%mask) + 1)
    end select
  end function surface_name

  !> A surface has an area everywhere; edges of its elements may be points.
  subroutine check_side(spec, k, model, contact, error)
    type(contact_spec_t), intent(in) :: spec
    integer, intent(in) :: k
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: area(:), width(:)

    call element_areas(model%mesh, contact, k, area, width)
    if (all(area > COLLAPSED*width**2)) return
    call fail(error, DECK_ERROR, quoted(contact%side(k)%name) &
              //' is collapsed to an edge or a point', spec%at(k)%face_place, &
              'a contact acts between faces that have an area')
  end subroutine check_side

  !> DEPTh, or half of the thinner body.
  subroutine set_depth(spec, contact, error)
    type(contact_spec_t), intent(in) :: spec
    type(contact_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error

    contact%depth = spec%depth
    contact%default_depth = .not. spec%depth > 0.0_wp
    if (.not. contact%default_depth) return
    associate (t => contact%side%thickness)
      contact%depth = 0.5_wp*minval(t, t > 0.0_wp)
      if (any(t > 0.0_wp)) return
    end associate
    call fail(error, DECK_ERROR, 'the bodies of contact '//quoted(contact%name) &
              //' have no thickness behind these faces', spec%place, &
              'give DEPTh d: a penetration deeper than d is no contact')
  end subroutine set_depth

  !> Laws and their numbers.
  subroutine set_laws(spec, model, contact)
    type(contact_spec_t), intent(in) :: spec
    type(model_t), intent(in) :: model
    type(contact_t), intent(inout) :: contact

    contact%normal = spec%normal%row
    contact%normal_prop = spec%normal%prop
    if (spec%normal%auto) call auto_penalty(model, contact, spec%normal%factor, &
                                            contact%normal_prop(1), contact%auto)
    contact%has_friction = spec%friction%given
    if (contact%has_friction) then
      contact%friction = spec%friction%row
      contact%friction_prop = spec%friction%prop
      if (spec%friction%auto) contact%friction_prop(2) = contact%normal_prop(1)
      contact%has_after = spec%has_after
      contact%after = spec%after
    end if
    contact%border = spec%border
    contact%balanced = spec%balanced .and. .not. any(contact%side%rigid) ! a tool bears all anyway
    contact%has_cohesive = spec%cohesive%given
    if (.not. contact%has_cohesive) return
    contact%cohesive = spec%cohesive%row
    contact%cohesive_prop = spec%cohesive%prop
    contact%released = contact%cohesive%released(contact%cohesive_prop)
    contact%tau = spec%cohesive%tau
    contact%on_pair = spec%on_pair
    contact%bond = spec%bond
    contact%bond_gap = spec%bond_gap
  end subroutine set_laws

end module setup_contact_build
