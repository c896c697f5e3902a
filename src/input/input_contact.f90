!> Contacts: derives surfaces, integration points, penalties and depths from the records of the
!! deck.
!!
!! The penalty of AUTO follows from the stiffness and the element size,
!!
!!   eps = 125 min(E/h),
!!
!! where the minimum is taken over the bodies that are not rigid, E is the smallest Young's modulus
!! behind the surface of the body, and h^2 is the mean area of the elements of this surface. With
!! MORTar, the factor is 100 instead of 125, and the mean area is that of the elements that are
!! nearest to the other surface at the start. A factor given with AUTO multiplies eps.
!!
!! With the factor 125, a pressure p causes a penetration of (p/E) h/125. The value 125 is that of
!! Corbett and Sauer 2015, section 5.3: eps = 125 E/L, 250 E/L and 500 E/L on blocks with modulus E
!! and elements of length L, L/2 and L/4.
module input_contact
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index
  use base_log, only: warn
  use base_text, only: quoted, to_text, nearest, lower
  use contact_bond, only: find_strength
  use contact_nearness, only: start_t, look_at_start
  use contact_pair, only: contact_t, surface_t, BALANCED, MORTAR
  use contact_surface, only: build_surface, tabulate_contact
  use contact_type, only: PENALTY, SMOOTHING, TANGENTIAL_PENALTY
  use curve_type, only: Q_CONTACT_DEBONDED
  use input_draft, only: draft_t, contact_entry_t
  use input_rigid, only: is_rigid_patch
  use input_thickness, only: body_thickness
  use input_where, only: find_faces, where_t, body_index
  use mesh, only: mesh_t
  use model, only: model_t
  use patch_check, only: face_name
  use tensor, only: cross
  use word_contact, only: contact_named
  implicit none
  private
  public :: build_contacts, element_areas, check_contacts

  real(wp), parameter :: STIFF = 125.0_wp, STIFF_AT_CELLS = 100.0_wp !! times E/h
  real(wp), parameter :: CLOSING = 32.0_wp     !! opening at release, divided by d of SMOOth
  real(wp), parameter :: LOCKS = 4.0_wp        !! largest penalty at integration points of MORTar,
  !! relative to AUTO
  integer, parameter :: MOST_POINTS = 10000000 !! largest number of integration points of a surface
  real(wp), parameter :: ROUNDING = 1.0e-9_wp   !! relative rounding error of a penalty
  real(wp), parameter :: COLLAPSED = 1.0e-10_wp !! an element is collapsed if its area is less
  !! than this fraction of width^2

contains

  !> Make the contacts of the model. The functions of the mesh must have been tabulated, and its
  !! nodes tied. Errors go to `draft%errors`.
  subroutine build_contacts(draft, model)
    type(draft_t), intent(inout) :: draft
    type(model_t), intent(inout) :: model
    type(error_t), allocatable :: error
    integer :: i

    deallocate (model%contact)
    allocate (model%contact(size(draft%contact)))
    do i = 1, size(draft%contact)
      model%contact(i) = draft%contact(i)%contact
      call resolve_contact(draft, draft%contact(i)%at, model, model%contact(i), error)
      if (.not. allocated(error)) call check_counted_once(model%contact(:i), error)
      if (allocated(error)) call draft%errors%add(error)
    end do
  end subroutine build_contacts

  !> Check that no two element faces that may touch in the last contact may also touch in an earlier
  !! contact.
  subroutine check_counted_once(contact, error)
    type(contact_t), intent(in) :: contact(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: j, k

    associate (new => contact(size(contact)))
      do j = 1, size(contact) - 1
        if (.not. allocated(contact(j)%side(2)%elem)) cycle ! the contact has an error
        do k = 1, 2
          if (common_faces(contact(j)%side(1), new%side(k)) == 0) cycle
          if (common_faces(contact(j)%side(2), new%side(3 - k)) == 0) cycle
          call fail(error, DECK_ERROR, 'contact '//quoted(new%name)//' shares faces with both ' &
                    //'sides of contact '//quoted(contact(j)%name), new%place, 'pressures and ' &
                    //'bonds there would count twice: leave these faces out of one of the contacts')
          return
        end do
      end do
    end associate
  end subroutine check_counted_once

  !> Find the data that the records do not give: surfaces, integration points, the default depth and
  !! penalties.
  subroutine resolve_contact(draft, at, model, contact, error)
    type(draft_t), intent(in) :: draft
    type(where_t), intent(in) :: at(2)
    type(model_t), intent(in) :: model
    type(contact_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    type(start_t) :: start
    logical :: smooths

    call make_sides(draft, at, model, contact, error)
    if (allocated(error)) return
    smooths = .false.
    if (contact%scheme == 0) then ! bonds, BORDer and REFIne are not available with MORTar
      contact%scheme = MORTAR
      if (contact%cohesive%given .or. contact%taper > 0.0_wp .or. contact%ncell > 1) then
        contact%scheme = BALANCED
        smooths = contact%cohesive%given .and. .not. contact%normal%prop(SMOOTHING) > 0.0_wp
      end if
    end if
    contact%default_depth = .not. contact%depth > 0.0_wp
    associate (t => contact%side%thickness)
      if (contact%default_depth) contact%depth = 0.5_wp*minval(t, t > 0.0_wp)
      if (contact%default_depth .and. .not. any(t > 0.0_wp)) then
        call fail(error, DECK_ERROR, 'the bodies of contact '//quoted(contact%name) &
                  //' have no thickness behind the contact faces', contact%place, &
                  'give DEPTh d, the largest penetration that counts as contact')
        return
      end if
    end associate
    call look_at_start(contact, model%mesh%xr, start)
    call set_penalties(model, start, contact)
    ! If a side is rigid, only the points of the other side act, so BALAnced makes no difference.
    contact%balanced = contact%scheme == BALANCED .and. .not. any(contact%side%rigid)
    if (contact%cohesive%given) then
      call contact%cohesive%law%released(contact%cohesive%prop, contact%released)
      call find_strength(contact)
    end if
    ! When damaged bonds close again, all gaps are about zero. The penalty law has a kink there,
    ! which SMOOth rounds off.
    if (smooths) contact%normal%prop(SMOOTHING) = maxval(contact%released)/CLOSING
    if (.not. start%overlap > 0.0_wp) return
    call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//': the bodies overlap by ' &
              //to_text(start%overlap, 6)//' at the start, at ('//to_text(start%x_overlap(1), 4) &
              //', '//to_text(start%x_overlap(2), 4)//', '//to_text(start%x_overlap(3), 4) &
              //'), more than DEPTh '//to_text(contact%depth, 6), contact%place, 'move one of ' &
              //'them, or give a larger DEPTh d, the largest penetration that counts as contact')
  end subroutine resolve_contact

  !> Make both surfaces with their integration points and the widths of their elements. Fail if they
  !! have a common face, too many integration points or no area.
  subroutine make_sides(draft, at, model, contact, error)
    type(draft_t), intent(in) :: draft
    type(where_t), intent(in) :: at(2)
    type(model_t), intent(in) :: model
    type(contact_t), intent(inout) :: contact
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: area(:), width(:)
    real(wp) :: n
    integer :: k

    contact%self = same_place(at(1), at(2))
    do k = 1, 2
      call make_side(draft, at(k), model%mesh, contact%side(k), error)
      if (allocated(error)) return
    end do
    if (.not. contact%self .and. common_faces(contact%side(1), contact%side(2)) > 0) then
      call fail(error, DECK_ERROR, quoted(contact%side(1)%name)//' and ' &
                //quoted(contact%side(2)%name)//' of contact '//quoted(contact%name)//' have ' &
                //'element faces in common (number: ' &
                //to_text(common_faces(contact%side(1), contact%side(2)))//')', &
                at(2)%face_place, 'give two surfaces without a common face; for ' &
                //'self-contact give the same surface twice')
      return
    end if
    if (.not. contact%given_points) then ! the default suffices for any degree
      contact%ngauss = max(contact%ngauss, highest_degree(contact)/2 + 1)
    end if
    n = real(product(contact%ngauss), wp)*maxval(contact%side%nelem)
    if (contact%ncell > 1) n = n*(1 + contact%ncell**2)
    if (n > MOST_POINTS) then
      call fail(error, DECK_ERROR, 'contact '//quoted(contact%name)//' has '//to_text(n) &
                //' integration points on a side, more than '//to_text(MOST_POINTS), &
                contact%place, 'use fewer points in QUADrature, a smaller number in REFIne, or a ' &
                //'coarser surface')
      return
    end if
    call tabulate_contact(contact, contact%ngauss(1), contact%ngauss(2))
    call warn_few_points(contact)
    do k = 1, 2
      call element_areas(model%mesh, contact, k, area, width)
      contact%side(k)%width = sqrt(area)
      if (all(area > COLLAPSED*width**2)) cycle
      call fail(error, DECK_ERROR, quoted(contact%side(k)%name) &
                //' is collapsed to an edge or a point', at(k)%face_place, &
                'a contact acts between faces that have an area')
      return
    end do
  end subroutine make_sides

  !> Warn if a surface has too few integration points for the degree of its functions: smoothed
  !! tractions are ratios of sums over these points, and with one point per element the functions of
  !! degree 2 and 3 are not integrated even roughly.
  subroutine warn_few_points(contact)
    type(contact_t), intent(in) :: contact
    integer :: degree

    degree = highest_degree(contact)
    if (2*minval(contact%ngauss) > degree) return
    call warn('QUADrature '//to_text(contact%ngauss(1))//' '//to_text(contact%ngauss(2)) &
              //' of contact '//quoted(contact%name)//' has too few points for functions of ' &
              //'degree '//to_text(degree)//': PRESsure and TANGential of a CURVe and the fields ' &
              //'of contact are wrong', contact%place, &
              'leave out QUADrature, or use at least '//to_text(degree + 1)//' points')
  end subroutine warn_few_points

  !> Highest degree of the functions of both surfaces.
  pure integer function highest_degree(contact) result(degree)
    type(contact_t), intent(in) :: contact
    integer :: i, k

    degree = 0
    do k = 1, 2
      associate (basis => contact%side(k)%basis)
        degree = max(degree, maxval([(maxval(basis(i)%degree), i=1, size(basis))]))
      end associate
    end do
  end function highest_degree

  !> Set the penalties that the deck leaves to AUTO. With MORTar, the part of the penalty that
  !! exceeds LOCKS times that of AUTO acts at control points, because it would cause locking at
  !! integration points.
  subroutine set_penalties(model, start, contact)
    type(model_t), intent(in) :: model
    type(start_t), intent(in) :: start
    type(contact_t), intent(inout) :: contact
    real(wp), allocatable :: area(:), width(:)
    real(wp) :: stiffness, h, times, usual
    integer :: k

    times = merge(STIFF_AT_CELLS, STIFF, contact%scheme == MORTAR)
    usual = huge(usual)
    do k = 1, 2
      associate (s => contact%side(k))
        if (s%rigid) cycle
        call element_areas(model%mesh, contact, k, area, width)
        h = sqrt(sum(area)/s%nelem)
        if (contact%scheme == MORTAR) h = start%width(k)
        stiffness = softest(model, s)
        if (.not. times*stiffness/h < usual) cycle
        usual = times*stiffness/h
        if (.not. contact%normal%auto) cycle
        contact%normal%account = 'AUTO: '//to_text(contact%normal%factor*times)//' E/h of ' &
                                 //s%name//', E = '//to_text(stiffness)//', h = '//to_text(h)
      end associate
    end do
    if (contact%normal%auto) then
      contact%normal%prop(PENALTY) = contact%normal%factor*usual
    else
      contact%normal%factor = contact%normal%prop(PENALTY)/usual
    end if
    if (contact%scheme == MORTAR) then
      contact%control_penalty = max(0.0_wp, contact%normal%prop(PENALTY) - LOCKS*usual)
      if (contact%control_penalty < ROUNDING*usual) contact%control_penalty = 0.0_wp
      contact%point_penalty = contact%normal%prop(PENALTY) - contact%control_penalty
    end if
    if (contact%friction%auto) contact%friction%prop(TANGENTIAL_PENALTY) &
      = contact%normal%prop(PENALTY)
  end subroutine set_penalties

  !> Number of element faces that belong to both surfaces.
  integer function common_faces(a, b) result(n)
    type(surface_t), intent(in) :: a, b
    integer(i8) :: key(a%nelem + b%nelem)
    integer :: i, order(size(key))

    key(:a%nelem) = face_keys(a)
    key(a%nelem + 1:) = face_keys(b)
    call sort_index(key, order)
    n = count([(key(order(i)) == key(order(i + 1)), i=1, size(key) - 1)])
  end function common_faces

  !> A distinct number for each element face of a surface.
  pure function face_keys(surface) result(key)
    type(surface_t), intent(in) :: surface
    integer(i8) :: key(surface%nelem)

    key = 6*(int(surface%block, i8)*huge(1) + surface%elem) + surface%face
  end function face_keys

  !> Make the surface that a WHERE names.
  subroutine make_side(draft, at, mesh, s, error)
    type(draft_t), intent(in) :: draft
    type(where_t), intent(in) :: at
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(inout) :: s
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: block(:), elem(:), side(:)
    character(:), allocatable :: face

    select case (at%mask)
    case (0)
      face = at%face
    case (15)
      face = 'SIDEs'
    case (63)
      face = 'ALL'
    case default
      face = face_name(trailz(at%mask) + 1)
    end select
    call find_faces(mesh, at, block, elem, side, error)
    if (allocated(error)) return
    call build_surface(mesh, block, elem, side, at%body//' '//face, s, error)
    if (allocated(error)) then
      if (.not. allocated(error%place%file)) error%place = at%face_place
      return
    end if
    s%rigid = is_rigid_patch(draft, at%body)
    if (s%rigid) return
    s%thickness = mesh%body(body_index(mesh, at%body))%thickness
    if (.not. s%thickness > 0.0_wp) s%thickness = body_thickness(draft, at%body, at%mask)
  end subroutine make_side

  !> Reference areas of the elements of a side, and the diagonals of the boxes around their nodes.
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

  !> Area per unit area of the parameters at point q of element e, for functions R = w N / W, where
  !! W is the sum of w N.
  pure real(wp) function stretch(mesh, s, e, q)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, q
    real(wp) :: w, total(3), sum_x(3, 3), t(3, 2)
    integer :: a, i, j

    total = 0.0_wp ! sums of w N and of its derivatives
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
    stretch = norm2(cross(t(:, 1), t(:, 2)))
  end function stretch

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

  !> Check the surfaces of contacts and the contacts of curves before the bodies are meshed. Errors
  !! go to `draft%errors`. The names of patches have been checked already.
  subroutine check_contacts(draft)
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable :: error
    character(32), allocatable :: names(:)
    character(:), allocatable :: hint
    integer :: c, i, j

    do i = 1, size(draft%contact)
      if (draft%contact(i)%at(2)%type == 0) cycle ! the error in its record is in the list already
      associate (a => draft%contact(i)%at(1), b => draft%contact(i)%at(2), &
                 name => draft%contact(i)%contact%name)
        if (same_place(a, b)) then
          call check_self(draft, draft%contact(i), error)
          if (.not. allocated(error)) cycle
        else if (lower(a%body) == lower(b%body) .and. &
                 (iand(a%mask, b%mask) /= 0 .or. lower(a%face) == lower(b%face))) then
          call fail(error, DECK_ERROR, 'a face of patch '//quoted(b%body) &
                    //' is on both sides of contact '//quoted(name), b%face_place, &
                    'give two surfaces without a common face; for self-contact give ' &
                    //'the same surface twice')
        else if (is_rigid_patch(draft, a%body) .and. is_rigid_patch(draft, b%body)) then
          call fail(error, DECK_ERROR, 'both bodies of contact '//quoted(name)//' are rigid', &
                    b%place, 'give one of them a TYPE of solid elements')
        else
          cycle
        end if
      end associate
      call draft%errors%add(error)
    end do
    do i = 2, size(draft%contact)
      do j = 1, i - 1
        if (.not. same_faces(draft%contact(i)%at, draft%contact(j)%at)) cycle
        call fail(error, DECK_ERROR, 'contact '//quoted(draft%contact(i)%contact%name) &
                  //' acts between the same two faces as contact ' &
                  //quoted(draft%contact(j)%contact%name), draft%contact(i)%at(1)%place, &
                  'pressures and bonds there would count twice: remove one of the contacts')
        call draft%errors%add(error)
        exit
      end do
    end do
    allocate (names(size(draft%contact)))
    do i = 1, size(names)
      names(i) = draft%contact(i)%contact%name
    end do
    do i = 1, draft%ncurve
      do j = 1, size(draft%curve(i)%column)
        associate (column => draft%curve(i)%column(j))
          if (.not. allocated(column%contact)) cycle
          c = contact_named(draft, column%contact)
          if (c == 0) then
            hint = 'the deck has no CONTact'
            if (size(names) > 0) hint = 'nearest known: '//trim(nearest(column%contact, names))
            call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' is not defined', &
                      column%contact_place, hint)
          else if (draft%contact(c)%at(2)%type == 0) then
            cycle ! the error in its record is in the list already
          else if (column%quantity%id == Q_CONTACT_DEBONDED .and. &
                   .not. draft%contact(c)%contact%cohesive%given) then
            call fail(error, DECK_ERROR, 'contact '//quoted(column%contact)//' has no COHEsive', &
                      column%contact_place, 'DEBOnded is the released fraction of bonds: name a ' &
                      //'contact with COHEsive')
          else
            cycle
          end if
        end associate
        call draft%errors%add(error)
      end do
    end do
  end subroutine check_contacts

  !> Do two contacts act between the same faces, in either order?
  pure logical function same_faces(a, b)
    type(where_t), intent(in) :: a(2), b(2)

    same_faces = .false.
    if (any(a%type == 0) .or. any(b%type == 0)) return
    same_faces = (same_place(a(1), b(1)) .and. same_place(a(2), b(2))) &
                 .or. (same_place(a(1), b(2)) .and. same_place(a(2), b(1)))
  end function same_faces

  !> Do two places name the same faces of the same body?
  pure logical function same_place(p, q) result(same)
    type(where_t), intent(in) :: p, q

    same = lower(p%body) == lower(q%body) .and. p%mask == q%mask
    if (same .and. p%mask == 0) same = lower(p%face) == lower(q%face)
  end function same_place

  !> Check the records of self-contact.
  subroutine check_self(draft, entry, error)
    type(draft_t), intent(in) :: draft
    type(contact_entry_t), intent(in) :: entry
    type(error_t), allocatable, intent(out) :: error

    associate (contact => entry%contact, at => entry%at(2))
      if (is_rigid_patch(draft, at%body)) then
        call fail(error, DECK_ERROR, 'the body of self-contact '//quoted(contact%name) &
                  //' is rigid', at%place, 'a rigid body cannot touch itself')
      else if ((contact%scheme /= 0 .and. contact%scheme /= MORTAR) .or. contact%cohesive%given &
               .or. contact%taper > 0.0_wp .or. contact%ncell > 1) then
        call fail(error, DECK_ERROR, 'self-contact '//quoted(contact%name)//' works only with ' &
                  //'SCHEme MORTar and without COHEsive, BORDer and REFIne', at%face_place, &
                  'COHEsive, BORDer, REFIne and the other schemes need two different surfaces')
      end if
    end associate
  end subroutine check_self

end module input_contact
