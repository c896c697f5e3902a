!> What the log reports about contacts before the first step: their bonds, and warnings about faces
!! that look wrong and about initial penetrations.
!!
!! All points are projected in the reference configuration. Points that are inside the other body at
!! the start indicate a press fit or a mistake. If the outward normals of the two surfaces point the
!! same way where the surfaces are nearest, the deck names the wrong faces.
module contact_start
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: to_text
  use contact_bond, only: find_bonds, find_opened_bonds
  use contact_history, only: new_contact_state
  use contact_pair, only: contact_t, contact_points_t, contact_state_t, MORTAR
  use mesh, only: mesh_t
  use model, only: model_t
  use projection, only: project
  use projection_search, only: grid_t, place_surfaces, update_grid
  use projection_type, only: foot_t, shape_t, touches
  use self_search, only: nearness_t, search_itself
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: start_t, look_at_start, warn_contacts, position_text

  !> A gap that is smaller than this fraction of the size of an element is due to rounding.
  real(wp), parameter :: INSIDE = 1.0e-6_wp
  !> Elements count as nearest if their gaps exceed the smallest one by at most this fraction of the
  !! width of the element with the smallest gap.
  real(wp), parameter :: NEAREST = 0.01_wp
  real(wp), parameter :: UNEQUAL = 0.1_wp     !! relative difference of areas above which to warn
  !> Normals point the same way if the cosine of their angle exceeds this value. The mean normal at
  !! the edge of a box is at 45 degrees to the faces that meet there, so more is required at ridges.
  real(wp), parameter :: SAME_WAY = 0.5_wp, SAME_AT_RIDGE = 0.9_wp

  !> Position of two surfaces relative to each other at the start.
  type :: start_t
    !> Number of points of both sides, or of a rigid side alone if no point of the other side faces
    !! it.
    integer :: npoint = 0
    integer :: ninside = 0               !! number of these that penetrate
    real(wp) :: deepest = 0.0_wp         !! largest penetration [L]
    real(wp) :: x(3) = 0.0_wp            !! point with the largest penetration [L]
    integer :: nnear = 0                 !! number of points about as near as the nearest
    integer :: naway(2) = 0              !! numbers of these where side 1 and side 2 face away
    real(wp) :: overlap = 0.0_wp         !! largest penetration between DEPTh and the thickness [L]
    real(wp) :: x_overlap(3) = 0.0_wp    !! point with this penetration [L]
    integer :: nbehind = 0               !! number of the near points behind the whole other body
    !> No integration point is opposite the other side, but points of the rigid side are.
    logical :: unseen = .false.
    real(wp) :: width(2) = 0.0_wp        !! mean width of the elements that are nearest [L]
    real(wp) :: gap = huge(1.0_wp)       !! smallest gap of a point outside the other body [L]
    real(wp) :: x_gap(3) = 0.0_wp        !! point with the smallest gap [L]
    !> Self-contact: number of points no farther than DEPTh from the far side of the body, and one
    !! of these points.
    integer :: nthrough = 0
    real(wp) :: x_through(3) = 0.0_wp
  end type start_t

contains

  !> Log the bonds of all contacts, and warn about faces that look wrong and about initial
  !! penetrations.
  subroutine warn_contacts(model)
    type(model_t), intent(in) :: model
    type(contact_state_t) :: state
    type(start_t) :: start
    integer :: c, k, n(2)
    logical :: apart                     ! no point of either side is opposite the other side
    character(:), allocatable :: name

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        name = "contact '"//contact%name//"': "
        if (contact%cohesive%given) then
          call new_contact_state(contact, state)
          call find_bonds(contact, model%mesh%xr, state)
          n = [(count(state%side(k)%bond > 0), k=1, 2)]
          call log_line('contact '//contact%name//': bonded are '//bonded_text(state%side(1)) &
                        //' of side 1 and '//bonded_text(state%side(2))//' of side 2')
          if (sum(n) == 0) call warn(name//'no point is bonded', contact%place, 'if the surfaces ' &
                                     //'are apart, bond points up to a distance d with BONDed ' &
                                     //'GAP d; otherwise enlarge the region of BONDed')
          call warn_unequal_bonds(contact, state)
          call warn_opened(contact, model%mesh, state)
        end if
        if (.not. contact%self) call warn_tied(contact)
        call look_at_start(contact, model%mesh%xr, start)
        apart = .false.
        if (start%nnear == 0 .and. .not. contact%self) then
          call look_farther(contact, model%mesh%xr, start)
          apart = .not. start%gap < huge(start%gap)
        end if
        if (start%nthrough > 0) then
          call warn(name//to_text(start%nthrough)//' of '//to_text(start%npoint)//' points, such ' &
                    //'as '//position_text(start%x_through)//', lie less than DEPTh ' &
                    //to_text(contact%depth, 3)//' behind the opposite face, which is taken for ' &
                    //'the far side of the body: no contact acts there', contact%place, &
                    'give a DEPTh less than the thickness there; if the faces overlap, move them ' &
                    //'apart')
        else if (2*sum(start%naway) > start%nnear) then
          k = merge(1, 2, start%naway(1) >= start%naway(2))
          call warn(name//contact%side(k)%name//' faces away from '//contact%side(3 - k)%name &
                    //': at '//to_text(sum(start%naway))//' of the '//to_text(start%nnear) &
                    //' nearest points both outward normals point the same way', contact%place, &
                    facing_hint(model%mesh, contact))
        else if (start%nnear > 0 .and. 2*start%nbehind > start%nnear) then
          call warn(name//'the faces '//contact%side(1)%name//' and '//contact%side(2)%name &
                    //' face away from each other: a whole body lies between them', &
                    contact%place, facing_hint(model%mesh, contact))
        else if (apart) then
          call warn(name//'the faces '//contact%side(1)%name//' and '//contact%side(2)%name &
                    //' are not opposite each other at the start', contact%place, &
                    'they touch only if a motion brings them together')
        else if (start%unseen .and. contact%scheme /= MORTAR) then
          k = merge(1, 2, contact%side(2)%rigid)
          call warn(name//contact%side(3 - k)%name//' lies between the integration points of ' &
                    //contact%side(k)%name//' at the start, so contact does not act there', &
                    contact%place, scheme_hint(contact)//'use smaller elements or '//more_points( &
                    contact))
        else if (start%ninside > 0) then
          call warn(name//to_text(start%ninside)//' of '//to_text(start%npoint)//' points ' &
                    //'penetrate the other side at the start, by up to ' &
                    //to_text(start%deepest, 3)//' at '//position_text(start%x), contact%place, &
                    'the first step pushes them out; if no press fit is intended, move one of ' &
                    //'the bodies')
        else if (start%gap < huge(start%gap)) then
          call log_line('contact '//contact%name//': smallest gap at the start ' &
                        //to_text(start%gap, 3)//' at '//position_text(start%x_gap))
        end if
      end associate
    end do
  end subroutine warn_contacts

  !> A position as text.
  pure function position_text(x) result(text)
    real(wp), intent(in) :: x(3)
    character(:), allocatable :: text

    text = '('//to_text(x(1), 4)//', '//to_text(x(2), 4)//', '//to_text(x(3), 4)//')'
  end function position_text

  !> The numbers of points and the areas of one side, bonded and in all.
  function bonded_text(points) result(text)
    type(contact_points_t), intent(in) :: points
    character(:), allocatable :: text

    text = to_text(count(points%bond > 0))//' of '//to_text(size(points%bond))//' points (area ' &
           //to_text(sum(points%area0, mask=points%bond > 0))//' of '//to_text(sum(points%area0)) &
           //')'
  end function bonded_text

  !> Warn if the bonded areas of the two sides differ. The area of a point is bonded either as a
  !! whole or not at all, so a few points cannot represent the edge of a bond well.
  subroutine warn_unequal_bonds(contact, state)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp) :: area(2)
    integer :: k

    if (any(contact%side%rigid)) return
    area = [(sum(state%side(k)%area0, mask=state%side(k)%bond > 0), k=1, 2)]
    if (.not. maxval(area) - minval(area) > UNEQUAL*maxval(area)) return
    call warn("contact '"//contact%name//"': the bonded areas of its two sides differ (" &
              //to_text(area(1), 3)//' and '//to_text(area(2), 3)//')', contact%place, 'use ' &
              //more_points(contact)//', or elements whose borders follow the edge of the bonded ' &
              //'area')
  end subroutine warn_unequal_bonds

  !> Warn about bonds that soften from the start, because the initial gap between two surfaces
  !! already opens their bonds.
  subroutine warn_opened(contact, mesh, state)
    type(contact_t), intent(in) :: contact
    type(mesh_t), intent(in) :: mesh
    type(contact_state_t), intent(in) :: state
    real(wp) :: widest, strongest
    integer :: n

    call find_opened_bonds(contact, mesh%xr, state, n, widest, strongest)
    if (n == 0) return
    call warn("contact '"//contact%name//"': at "//to_text(n)//' bonded points the gap at the ' &
              //'start, up to '//to_text(widest, 3)//', exceeds the opening at which bonds begin ' &
              //'to soften, '//to_text(strongest, 3), contact%place, 'a gap opens the bond from ' &
              //'the start: bring the surfaces together, bond fewer points with a smaller GAP, ' &
              //'or give a larger opening in COHEsive')
  end subroutine warn_opened

  !> Part of a hint: at least twice as many integration points as the deck has.
  function more_points(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text
    character(:), allocatable :: n

    n = to_text(max(10, 2*maxval(contact%ngauss)))
    text = "more points, such as 'QUADrature "//n//' '//n//"'"
  end function more_points

  !> Part of a hint: use MORTar, the default without bonds, BORDer and REFIne.
  function scheme_hint(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text

    text = ''
    if (contact%cohesive%given .or. contact%taper > 0.0_wp .or. contact%ncell > 1) return
    text = 'remove SCHEme to use the default scheme, or '
  end function scheme_hint

  !> Hint: what to do if the faces of a contact point the wrong way.
  function facing_hint(mesh, contact) result(hint)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: hint
    integer :: k

    hint = 'check the faces; 3- and 3+, for example, are on opposite sides of a patch'
    do k = 1, 2
      associate (side => contact%side(k))
        if (mesh%block(side%block(1))%row%name /= 'SURFACE') cycle ! not a rigid spline
        hint = 'REVErse in SPLIne,'//side%name(:index(side%name, ' ') - 1)//' reverses its ' &
               //'normal; if the normal is right, '//hint
        return
      end associate
    end do
  end function facing_hint

  !> Warn about elements of side 1 all of whose nodes belong to side 2: contact cannot open there.
  subroutine warn_tied(contact)
    type(contact_t), intent(in) :: contact
    logical :: shared(max(maxval(contact%side(1)%node), maxval(contact%side(2)%node)))
    integer :: e, n

    shared = .false.
    shared(contact%side(2)%node) = .true.
    n = 0
    associate (own => contact%side(1))
      do e = 1, own%nelem
        if (all(shared(own%node(own%first(e):own%first(e + 1) - 1)))) n = n + 1
      end do
      if (n == 0) return
      call warn("contact '"//contact%name//"': the two sides share all nodes of "//to_text(n) &
                //' of the '//to_text(own%nelem)//' elements of '//own%name//', and cannot ' &
                //'separate or slide there', contact%place, &
                'TIE joins nodes of bodies that touch: use TIE,NODE or TIE,MATErial, or no TIE')
    end associate
  end subroutine warn_tied

  !> Project all points of a contact at the positions x, over a distance of at most the thickness of
  !! the thicker body plus the width of an element.
  subroutine look_at_start(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    real(wp), allocatable :: gap(:)      ! gaps of points with a projection [L]
    integer, allocatable :: away(:)      ! side that faces away at a point; 0: none
    real(wp), allocatable :: reach_of(:, :) ! distance of an element to the other surface [L]
    logical, allocatable :: behind(:)    ! the point is behind the other body
    real(wp) :: thin                     ! thickness of the thinner body [L]; huge: unknown
    real(wp) :: h, reach, near
    integer :: k, n

    if (contact%self) then
      call look_at_itself(contact, x, start)
      return
    end if
    h = huge(1.0_wp)
    call place_surfaces(contact, x, shape, grid)
    do k = 1, 2
      h = min(h, sum(maxval(shape(k)%high - shape(k)%low, dim=1))/max(1, contact%side(k)%nelem))
      if (contact%side(k)%rigid) cycle
      start%npoint = start%npoint + contact%side(k)%nelem*contact%nplain
    end do
    allocate (reach_of(maxval(contact%side%nelem), 2), source=huge(h))
    thin = huge(thin)
    if (any(contact%side%thickness > 0.0_wp)) thin = minval(contact%side%thickness, &
                                                            contact%side%thickness > 0.0_wp)
    reach = h + maxval(contact%side%thickness)
    n = contact%nplain*maxval(contact%side%nelem)*2
    allocate (gap(n), away(n), behind(n))
    n = 0
    do k = 1, 2
      if (.not. contact%side(k)%rigid) call look_from(k)
    end do
    do k = 1, 2 ! a rigid side may lie between the points of the other side
      if (n > 0 .or. .not. contact%side(k)%rigid) cycle
      call update_grid(contact%side(3 - k), shape(3 - k), grid(3 - k))
      call look_from(k)
      start%unseen = n > 0
      if (start%unseen) start%npoint = contact%side(k)%nelem*contact%nplain
    end do
    where (abs(start%x) < INSIDE*h) start%x = 0.0_wp ! only rounding error
    ! surfaces must face each other only where they are nearest; the far side of a ball faces away
    near = minval(abs(gap(:n))) + h
    do k = 1, 2
      if (allocated(contact%side(k)%width)) then
        start%width(k) = nearest_width(contact%side(k)%width, reach_of(:, k))
      end if
    end do
    start%nnear = count(abs(gap(:n)) <= near)
    start%nbehind = count(abs(gap(:n)) <= near .and. behind(:n))
    start%naway = [(count(abs(gap(:n)) <= near .and. away(:n) == k), k=1, 2)]

  contains

    !> Project the points of side k onto the other side.
    subroutine look_from(k)
      integer, intent(in) :: k
      type(foot_t) :: foot
      real(wp) :: xp(3), a(3, 2), b(3, 3), normal(3), same
      integer :: e, q

      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot, reach)
          if (foot%elem == 0) cycle
          if (abs(foot%gap) <= reach) then
            n = n + 1
            gap(n) = foot%gap
            reach_of(e, k) = min(reach_of(e, k), abs(foot%gap))
            away(n) = 0
            behind(n) = foot%gap < -thin*(1.0_wp - INSIDE)
            normal = cross(a(:, 1), a(:, 2))
            same = merge(SAME_WAY, SAME_AT_RIDGE, all(foot%free))
            if (dot_product(normal, foot%n) > same*norm2(normal)) then
              ! outside the other body side k faces away, inside it the other side does
              away(n) = merge(3 - k, k, foot%gap < 0.0_wp)
            end if
          end if
          if (foot%gap >= 0.0_wp .and. foot%gap < start%gap) then
            start%gap = foot%gap
            start%x_gap = xp
          end if
          if (foot%gap < -contact%depth .and. foot%gap > -thin*(1.0_wp - INSIDE) .and. &
              -foot%gap > start%overlap) then
            if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) < 0.0_wp) then
              start%overlap = -foot%gap
              start%x_overlap = xp
            end if
          end if
          if (.not. (foot%gap < -INSIDE*h .and. touches(foot, contact%depth))) cycle
          start%ninside = start%ninside + 1
          if (-foot%gap <= start%deepest) cycle
          start%deepest = -foot%gap
          start%x = xp
        end do
      end do
    end subroutine look_from

  end subroutine look_at_start

  !> Find the smallest gap between two surfaces that face each other but are farther apart than the
  !! distance within which look_at_start searches.
  subroutine look_farther(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(inout) :: start
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    type(foot_t) :: foot
    real(wp) :: xp(3), a(3, 2), b(3, 3)
    integer :: e, k, q

    do k = 1, 2
      call update_shape(contact%side(k), x, shape(k))
      call update_grid(contact%side(k), shape(k), grid(k))
    end do
    do k = 1, 2
      do e = 1, contact%side(k)%nelem
        do q = 1, contact%nplain
          call surface_point(contact%side(k), shape(k), e, contact%xi(:, q), xp, a, b)
          foot%elem = 0
          call project(contact%side(3 - k), shape(3 - k), grid(3 - k), xp, foot)
          if (foot%elem == 0) cycle
          if (.not. (foot%gap >= 0.0_wp .and. foot%gap < start%gap)) cycle
          if (dot_product(cross(a(:, 1), a(:, 2)), foot%n) > 0.0_wp) cycle
          start%gap = foot%gap
          start%x_gap = xp
        end do
      end do
    end do
    where (abs(start%x_gap) < INSIDE*start%gap) start%x_gap = 0.0_wp ! rounding
  end subroutine look_farther

  !> Do the same as look_at_start for self-contact.
  subroutine look_at_itself(contact, x, start)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: x(:, :)      !! (3, nnode) [L]
    type(start_t), intent(out) :: start
    type(nearness_t) :: near

    associate (surface => contact%side(1))
      call search_itself(contact, x, x, surface%thickness + maxval(surface%width), near)
      start%npoint = near%npoint
      start%ninside = near%ninside
      start%deepest = near%deepest
      start%x = near%x
      start%gap = near%gap
      start%x_gap = near%x_gap
      start%nthrough = near%nthrough
      start%x_through = near%x_through
      start%width = nearest_width(surface%width, near%reach_of)
    end associate
  end subroutine look_at_itself

  !> Mean width of those elements of a surface that are about as near to the other surface as the
  !! nearest element. On graded meshes, large elements far from the contact must not be included.
  pure real(wp) function nearest_width(width, reach) result(mean)
    real(wp), intent(in) :: width(:)     !! (nelem) [L]
    real(wp), intent(in) :: reach(:)     !! distance to the other surface [L]; huge: not near
    real(wp) :: band
    integer :: e

    associate (near => reach(:size(width)))
      band = huge(band)
      if (any(near < huge(near))) then
        e = minloc(near, dim=1)
        band = near(e) + NEAREST*width(e)
      end if
      mean = sqrt(sum(width**2, mask=near <= band)/max(1, count(near <= band)))
    end associate
  end function nearest_width

end module contact_start
