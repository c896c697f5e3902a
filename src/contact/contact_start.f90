!> What the log reports about contacts before the first step: their bonds, and warnings about faces
!! that look wrong and about initial penetrations.
!!
!! All points are projected in the reference configuration (contact_nearness). Points that are
!! inside the other body at the start indicate a press fit or a mistake. If the outward normals of
!! the two surfaces point the same way where the surfaces are nearest, the deck names the wrong
!! faces.
module contact_start
  use base_kinds, only: wp
  use base_log, only: log_line, warn
  use base_text, only: position_text, to_text
  use contact_bond, only: CLOSE_BY, find_bonds, find_opened_bonds, find_unbonded, NEXT_TO
  use contact_corners, only: corner_overlap
  use contact_history, only: new_contact_state
  use contact_nearness, only: start_t, look_at_start, look_farther
  use contact_pair, only: contact_t, contact_points_t, contact_state_t, surface_t, &
                          MORTAR, MAX_POINT
  use mesh, only: mesh_t
  use model, only: model_t
  implicit none
  private
  public :: warn_contacts

  real(wp), parameter :: UNEQUAL = 0.1_wp     !! relative difference of areas above which to warn
  real(wp), parameter :: MISSED = 0.1_wp      !! part of an area without bonds above which to warn
  real(wp), parameter :: CRUDE = 0.03_wp      !! deviation over penetration above which to warn

contains

  !> Log the bonds of all contacts, and warn about faces that look wrong and about initial
  !! penetrations.
  subroutine warn_contacts(model)
    type(model_t), intent(in) :: model
    type(contact_state_t) :: state
    type(start_t) :: start
    real(wp) :: corner                   ! largest penetration of a corner [L]
    integer :: c, k, n(2)
    logical :: apart                     ! no point of either side is opposite the other side
    character(:), allocatable :: name

    do c = 1, size(model%contact)
      associate (contact => model%contact(c))
        name = "contact '"//contact%name//"': "
        call new_contact_state(contact, state)
        if (contact%cohesive%given) then
          call find_bonds(contact, model%mesh%xr, state)
          n = [(count(state%side(k)%bond > 0), k=1, 2)]
          call log_line('contact '//contact%name//': bonded are '//bonded_text(state%side(1)) &
                        //' of side 1 and '//bonded_text(state%side(2))//' of side 2')
          if (sum(n) == 0) call warn(name//'no point is bonded', contact%place, 'if the surfaces ' &
                                     //'are apart, bond points up to a distance d with BONDed ' &
                                     //'GAP d; otherwise enlarge the region of BONDed')
          call warn_unequal_bonds(contact, state)
          if (sum(n) > 0) call warn_unbonded(contact, model%mesh, state)
          call warn_opened(contact, model%mesh, state)
        end if
        if (.not. contact%self) call warn_tied(contact)
        call look_at_start(contact, model%mesh%xr, start)
        corner = 0.0_wp
        if (.not. contact%self) corner = corner_overlap(contact, model%mesh%xr, state)
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
                    contact%place, scheme_hint(contact)//'use '//more_points(contact) &
                    //'smaller elements')
        else if (start%ninside > 0) then
          call warn_inside(model%mesh, contact, start, corner)
        else if (corner > 0.0_wp) then
          call warn(name//'corners of elements penetrate the other side at the start, by up to ' &
                    //to_text(corner, 3)//', although no integration point does', &
                    contact%place, 'the first step pushes them out; curved faces of linear ' &
                    //'elements that fit each other need equal meshes, smaller elements, or ' &
                    //'layers with ENRIch')
        else if (start%gap < huge(start%gap)) then
          call log_line('contact '//contact%name//': smallest gap at the start ' &
                        //to_text(start%gap, 3)//' at '//position_text(start%x_gap))
        end if
      end associate
    end do
  end subroutine warn_contacts

  !> Largest distance of the elements of a surface from the geometry of their patches [L].
  pure real(wp) function deviation(mesh, side) result(d)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: side
    integer :: b, f

    d = 0.0_wp
    do b = 1, size(mesh%body)
      do f = 1, 6
        associate (face => mesh%body(b)%face(f))
          if (.not. face%deviation > d) cycle
          if (any(side%block == face%block(1) .and. side%elem == face%elem(1) &
                  .and. side%face == face%side(1))) d = face%deviation
        end associate
      end do
    end do
  end function deviation

  !> Warn that integration points penetrate at the start. If the elements are a crude approximation
  !! of curved faces, the penetrations consist largely of the deviations of the elements.
  subroutine warn_inside(mesh, contact, start, corner)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact
    type(start_t), intent(in) :: start
    real(wp), intent(in) :: corner       !! largest penetration of a corner [L]
    character(:), allocatable :: text, hint
    real(wp) :: off                      ! deviation of both sides from their geometry [L]

    text = "contact '"//contact%name//"': "//to_text(start%ninside)//' of ' &
           //to_text(start%npoint)//' points penetrate the other side at the start, by up to ' &
           //to_text(start%deepest, 3)//' at '//position_text(start%x) &
           //corner_text(corner, start%deepest)
    hint = 'the first step pushes them out; if no press fit is intended, move one of the bodies'
    off = deviation(mesh, contact%side(1)) + deviation(mesh, contact%side(2))
    if (off > CRUDE*start%deepest) then
      text = text//'; the elements deviate from the exact faces by up to '//to_text(off, 3)
      hint = hint//'; if one is, its pressure may be wrong by the ratio of this deviation to the ' &
             //'interference: use smaller elements, ENRIch or IGA'
    end if
    call warn(text, contact%place, hint)
  end subroutine warn_inside

  !> Part of a warning: how deep corners of elements penetrate, if they are deeper than points.
  function corner_text(corner, deepest) result(text)
    real(wp), intent(in) :: corner, deepest !! [L]
    character(:), allocatable :: text

    text = ''
    if (corner > deepest) text = ', and corners of elements by up to '//to_text(corner, 3)
  end function corner_text

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
              //more_points(contact)//'elements whose borders follow the edge of the bonded area')
  end subroutine warn_unequal_bonds

  !> Warn if a part of two surfaces that touch is not bonded because its gap exceeds the default of
  !! GAP. A GAP of the deck states which points are meant.
  subroutine warn_unbonded(contact, mesh, state)
    type(contact_t), intent(in) :: contact
    type(mesh_t), intent(in) :: mesh
    type(contact_state_t), intent(in) :: state
    real(wp) :: part, widest

    if (contact%bond_gap >= 0.0_wp) return
    call find_unbonded(contact, mesh%xr, state, part, widest)
    if (.not. part > MISSED) return
    call warn("contact '"//contact%name//"': "//to_text(100*part, 3)//' % of the area that lies ' &
              //'next to the other side, within '//to_text(100*NEXT_TO, 3)//' % of the width of ' &
              //'an element, is not bonded, because its distance, up to '//to_text(widest, 3) &
              //', exceeds GAP, by default '//to_text(100*CLOSE_BY, 3)//' % of this width', &
              contact%place, 'give the largest distance of bonded points with BONDed GAP d')
  end subroutine warn_unbonded

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

  !> Part of a hint: twice as many integration points as the deck has, but at least 10 and at most
  !! MAX_POINT; empty if the deck has MAX_POINT already.
  function more_points(contact) result(text)
    type(contact_t), intent(in) :: contact
    character(:), allocatable :: text
    character(:), allocatable :: n

    text = ''
    if (minval(contact%ngauss) >= MAX_POINT) return
    n = to_text(min(MAX_POINT, max(10, 2*maxval(contact%ngauss))))
    text = "more points, such as 'QUADrature "//n//' '//n//"', or "
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

end module contact_start
