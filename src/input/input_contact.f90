!> Contacts: from names of faces to surfaces, laws with all their numbers, and integration points.
!!
!! What a contact is not told: the penalty of AUTO, from stiffness and element size.
!!
!!   eps = 125 min over the bodies of E/h,   h^2 the mean area of the surface's elements
!!
!! E is Young's modulus of the body; rigid bodies do not count. With a pressure p the penetration is
!! (p/E) h/125. The constant is that of Corbett and Sauer 2015, section 5.3: eps = 125 E/L, 250 E/L
!! and 500 E/L on blocks with E and elements of length L, L/2 and L/4.
!!
!! What a CONTact, and the curves of it, refer to, before anything is meshed.
module input_contact
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: quoted, to_text, nearest, lower
  use contact_pair, only: contact_t, surface_t
  use contact_spec, only: contact_spec_t
  use contact_surface, only: build_surface, tabulate_contact
  use model, only: model_t
  use patch_check, only: face_name
  use input_draft, only: build_t, column_t
  use input_where, only: find_faces, where_t, body_index
  use input_rigid, only: is_rigid_patch
  use input_thickness, only: body_thickness
  use mesh, only: mesh_t
  use curve_type, only: Q_CONTACT_DEBONDED
  use word_contact, only: contact_named
  implicit none
  private
  public :: build_contacts, element_areas, auto_penalty, check_contacts

  real(wp), parameter :: STIFF = 125.0_wp

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

  !> Reference areas of the elements of a side, and the widths of their nodes' boxes.
  subroutine element_areas(mesh, contact, k, area, width)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), allocatable, intent(out) :: area(:), width(:) !! (nelem) [L^2], [L]
    real(wp) :: low(3), high(3)
    integer :: a, e, q

    associate (s => contact%side(k))
      allocate (area(s%nelem), width(s%nelem), source=0.0_wp)
      do e = 1, s%nelem
        low = huge(low)
        high = -huge(high)
        do a = s%first(e), s%first(e + 1) - 1
          low = min(low, mesh%xr(:, s%node(a)))
          high = max(high, mesh%xr(:, s%node(a)))
        end do
        width(e) = norm2(high - low)
        do q = 1, contact%nplain
          area(e) = area(e) + contact%wgt(q)*stretch(mesh, s, e, q)
        end do
      end do
    end associate
  end subroutine element_areas

  !> Area per parent area at point q of element e: R = w N / W, W = sum of w N.
  pure real(wp) function stretch(mesh, s, e, q)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, q
    real(wp) :: w, total(3), sum_x(3, 3), t(3, 2)
    integer :: a, i, j

    total = 0.0_wp ! N and its derivatives
    sum_x = 0.0_wp
    associate (basis => s%basis(s%ibasis(e)))
      do i = 1, basis%nsf
        a = s%first(e) + i - 1
        w = 1.0_wp
        if (allocated(s%w)) w = s%w(a)
        total = total + w*[basis%shp(i, q), basis%dshp(1, i, q), basis%dshp(2, i, q)]
        sum_x(:, 1) = sum_x(:, 1) + w*basis%shp(i, q)*mesh%xr(:, s%node(a))
        do j = 1, 2
          sum_x(:, j + 1) = sum_x(:, j + 1) + w*basis%dshp(j, i, q)*mesh%xr(:, s%node(a))
        end do
      end do
    end associate
    do j = 1, 2
      t(:, j) = (sum_x(:, j + 1) - sum_x(:, 1)*(total(j + 1)/total(1)))/total(1)
    end do
    stretch = norm2([t(2, 1)*t(3, 2) - t(3, 1)*t(2, 2), t(3, 1)*t(1, 2) - t(1, 1)*t(3, 2), &
                     t(1, 1)*t(2, 2) - t(2, 1)*t(1, 2)])
  end function stretch

  !> The penalty [F/L^3] and how it was found.
  subroutine auto_penalty(model, contact, factor, eps, account)
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: factor
    real(wp), intent(out) :: eps
    character(:), allocatable, intent(out) :: account
    real(wp), allocatable :: area(:), width(:)
    real(wp) :: stiffness, h
    integer :: k

    eps = huge(eps)
    do k = 1, 2
      associate (s => contact%side(k))
        if (s%rigid) cycle
        call element_areas(model%mesh, contact, k, area, width)
        h = sqrt(sum(area)/s%nelem)
        stiffness = softest(model, s)
        if (.not. factor*STIFF*stiffness/h < eps) cycle
        eps = factor*STIFF*stiffness/h
        account = 'AUTO: '//to_text(factor*STIFF)//' E/h of '//s%name//', E = ' &
                  //to_text(stiffness)//', h = '//to_text(h)
      end associate
    end do
  end subroutine auto_penalty

  !> The smallest Young's modulus of the elements behind a surface [F/L^2].
  pure real(wp) function softest(model, s)
    type(model_t), intent(in) :: model
    type(surface_t), intent(in) :: s
    integer :: e

    softest = huge(softest)
    do e = 1, s%nelem
      associate (material => model%material(model%mesh%block(s%block(e))%material))
        softest = min(softest, material%row%stiffness(material%prop))
      end associate
    end do
  end function softest

  !> Errors go to the list. That the patches exist has been seen to.
  subroutine check_contacts(build)
    type(build_t), intent(inout) :: build
    type(error_t), allocatable :: error
    integer :: i, j

    do i = 1, size(build%contact)
      if (build%contact(i)%at(2)%kind == 0) cycle ! its own error is in the list
      call check_surfaces(build, build%contact(i), error)
      if (allocated(error)) call build%errors%add(error)
    end do
    do i = 1, build%ncurve
      do j = 1, size(build%curve(i)%column)
        if (.not. allocated(build%curve(i)%column(j)%contact)) cycle
        call check_column(build, build%curve(i)%column(j), error)
        if (allocated(error)) call build%errors%add(error)
      end do
    end do
  end subroutine check_contacts

  !> Two surfaces without a common face, at least one of which can be deformed.
  subroutine check_surfaces(build, contact, error)
    type(build_t), intent(in) :: build
    type(contact_spec_t), intent(in) :: contact
    type(error_t), allocatable, intent(out) :: error

    associate (a => contact%at(1), b => contact%at(2))
      if (lower(a%body) == lower(b%body) .and. &
          (iand(a%mask, b%mask) /= 0 .or. lower(a%face) == lower(b%face))) then
        call fail(error, DECK_ERROR, 'a face of patch '//quoted(b%body) &
                  //' is on both sides of contact '//quoted(contact%name), b%face_place, &
                  'the two surfaces have no face in common')
      else if (is_rigid_patch(build, a%body) .and. is_rigid_patch(build, b%body)) then
        call fail(error, DECK_ERROR, 'both bodies of contact '//quoted(contact%name) &
                  //' are rigid', b%place, 'give one of them a TYPE of solid elements')
      end if
    end associate
  end subroutine check_surfaces

  !> A contact of that name, with what the quantity needs.
  subroutine check_column(build, column, error)
    type(build_t), intent(in) :: build
    type(column_t), intent(in) :: column
    type(error_t), allocatable, intent(out) :: error
    integer :: c

    c = contact_named(build, column%contact)
    if (c == 0) then
      call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' is not defined', &
                column%contact_place, known_contacts(build, column%contact))
      return
    end if
    if (build%contact(c)%at(2)%kind == 0) return ! its own error is in the list
    if (column%quantity%id == Q_CONTACT_DEBONDED .and. .not. build%contact(c)%cohesive%given) then
      call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' has no COHEsive', &
                column%contact_place, 'DEBOnded is a share of what COHEsive holds together')
    end if
  end subroutine check_column

  function known_contacts(build, name) result(hint)
    type(build_t), intent(in) :: build
    character(*), intent(in) :: name
    character(:), allocatable :: hint
    character(32), allocatable :: names(:)
    integer :: i

    hint = 'the deck has no CONTact'
    if (size(build%contact) == 0) return
    allocate (names(size(build%contact)))
    do i = 1, size(names)
      names(i) = build%contact(i)%name
    end do
    hint = 'nearest known: '//trim(nearest(name, names))
  end function known_contacts

end module input_contact
