!> Finds faces of elements that touch each other but are joined neither by common nodes nor by a
!! contact. The bodies do not act on each other there, or a body comes apart, and nothing else in
!! the results shows this. Faces of splines that have common nodes but different functions come
!! apart, too; input_mismatch finds such faces of other elements.
module input_touching
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use constraint, only: slave_marks
  use contact_pair, only: contact_t, surface_t
  use contact_surface, only: gather_faces
  use input_constraint, only: named
  use input_draft, only: draft_t
  use input_joined, only: is_joined, is_held, differ, find_rigid_nodes, meet
  use input_skin, only: body_name
  use mesh, only: mesh_t, is_rigid
  use mesh_boundary, only: find_outer_faces
  use projection_type, only: shape_t
  use surface_geometry, only: surface_point, update_shape
  use tensor, only: cross
  implicit none
  private
  public :: warn_touching

  !> Faces touch if their distance, relative to the smaller face, is less than this.
  real(wp), parameter :: TOUCHING = 1.0e-6_wp
  !> Where two curved surfaces that touch consist of flat elements, the elements overlap in some
  !! places and are apart in others. The distances are at most CURVED times the width of a face and
  !! at most SHALLOW times the depth of an element.
  real(wp), parameter :: CURVED = 0.05_wp, SHALLOW = 0.2_wp
  real(wp), parameter :: OPPOSITE = -0.7_wp !! largest cosine of the angle between outward normals
  integer, parameter :: NPOINT = 4          !! points of a face in each of its two directions
  integer, parameter :: MOST_STEPS = 20
  integer, parameter :: MOST_PAIRS = 5      !! largest number of pairs that are named
  real(wp), parameter :: BORDER = 1.0e-6_wp !! a point this far beyond the border counts as inside

  !> All outer faces, and buckets of faces that are near each other.
  type :: skin_t
    type(surface_t) :: surface
    type(shape_t) :: shape
    integer, allocatable :: body(:)    !! (nelem) body of each face; 0: the elements have none
    logical, allocatable :: rigid(:)   !! (nelem)
    logical, allocatable :: spline(:)  !! (nelem)
    integer, allocatable :: rigid_body(:) !! (nnode) the rigid body of each node; 0: none
    real(wp), allocatable :: width(:)  !! (nelem) largest extent of a face [L]
    real(wp), allocatable :: depth(:)  !! (nelem) depth of the element behind a face [L]
    integer, allocatable :: side(:, :) !! (nelem, ncontact) bit k-1: the face is on side k
    real(wp) :: low(3) = 0.0_wp, cell = 1.0_wp !! corner and width of the buckets [L]
    integer :: n(3) = 1                !! number of buckets
    integer, allocatable :: first(:)   !! first face of each bucket
    integer, allocatable :: face(:)
  end type skin_t

  !> Two bodies that touch, or a body that touches itself.
  type :: pair_t
    integer :: body(2) = 0
    integer :: face = 0                !! a face of the second body that touches the first
    real(wp) :: area(2) = 0.0_wp       !! area of each body that touches the other one [L^2]
    real(wp) :: near(2) = 0.0_wp       !! area if distances up to CURVED count as touching [L^2]
    logical :: overlaps = .false.      !! elements overlap at some points that touch
    real(wp) :: unlike(2) = 0.0_wp     !! area of each body with common nodes that join it to
    !! the other one only in part [L^2]
    integer :: unlike_face(2) = 0      !! two faces there; the second one may be rigid
    logical :: meets = .false.         !! single control points join the areas that touch
  end type pair_t

contains

  !> Warn about each pair of bodies whose faces touch and are not joined, and about each body with
  !! faces that touch each other and are not joined.
  subroutine warn_touching(draft, mesh, contact, told)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: told(:, :) !! (nbody, nbody) pairs that a warning has already named
    type(skin_t) :: skin
    type(pair_t), allocatable :: pair(:)
    logical, allocatable :: double(:) ! (nnode) another node, not joined, lies at the same position
    logical, allocatable :: loose(:)  ! (nnode) a hanging node without a constraint
    integer :: m, n, p, npair

    call make_skin(mesh, contact, skin)
    if (skin%surface%nelem < 2) return
    call find_pairs(mesh, skin, pair, npair, double, loose)
    m = 0
    n = 0
    do p = 1, npair
      associate (a => pair(p)%body(1), b => pair(p)%body(2))
        if (a > 0) then
          if (told(a, b)) cycle
        end if
        if (any(pair(p)%unlike > 0.0_wp)) then
          m = m + 1
          if (m <= MOST_PAIRS) call warn_unlike(draft, mesh, skin, pair(p))
        end if
        if (.not. any(pair(p)%area > 0.0_wp) .and. .not. pair(p)%overlaps) cycle
        n = n + 1
        if (n > MOST_PAIRS) then
          cycle
        else if (a == b) then
          call warn_seam(draft, mesh, skin, pair(p), double, loose)
        else
          call warn(body_name(mesh, a)//' and '//body_name(mesh, b)//' touch over an area of ' &
                    //'about '//to_text(maxval(area_of(pair(p))), 2)//', but nothing joins them, ' &
                    //'so they do not act on each other there', &
                    place_of(draft, mesh, skin, pair(p)), 'TIE joins coinciding nodes; CONTact ' &
                    //'between these faces transmits pressure, and bonds them if it has COHEsive')
        end if
      end associate
    end do
    if (m > MOST_PAIRS) call warn('more pairs of bodies share nodes that join them only in part ' &
                                  //'(number: '//to_text(m - MOST_PAIRS)//')')
    if (n > MOST_PAIRS) call warn('more pairs of bodies touch where nothing joins them (number: ' &
                                  //to_text(n - MOST_PAIRS)//')')
  end subroutine warn_touching

  !> Warn about faces that share nodes and come apart between these nodes.
  subroutine warn_unlike(draft, mesh, skin, pair)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    type(pair_t), intent(in) :: pair
    character(:), allocatable :: area

    area = ' over an area of about '//to_text(maxval(pair%unlike), 2)
    associate (e => pair%unlike_face(1), f => pair%unlike_face(2), s => skin%surface)
      if (skin%rigid(f)) then
        call warn('the rigid body '//body_name(mesh, skin%body(f))//' holds only some of the ' &
                  //'nodes of '//trim(mesh%block(s%block(e))%name)//' elements of ' &
                  //body_name(mesh, skin%body(e))//area, place_of(draft, mesh, skin, pair), &
                  'the bodies come apart there: move the face of the deformable body with MOVE ' &
                  //'and without TIE, or use a rigid body with a node at each node of this face')
      else
        call warn(body_name(mesh, skin%body(e))//' and '//body_name(mesh, skin%body(f)) &
                  //' share nodes'//area//' where the functions of their elements, ' &
                  //trim(mesh%block(s%block(e))%name)//' and ' &
                  //trim(mesh%block(s%block(f))%name)//', differ', &
                  place_of(draft, mesh, skin, pair), 'the bodies come apart between these nodes, ' &
                  //'and the results are wrong: use elements of one type on meshes that ' &
                  //'match, or CONTact with COHEsive instead of TIE')
      end if
    end associate
  end subroutine warn_unlike

  !> The area of each body that touches the other body [L^2]. If elements overlap in some places,
  !! the surfaces are curved.
  pure function area_of(pair) result(area)
    type(pair_t), intent(in) :: pair
    real(wp) :: area(2)

    area = pair%area
    if (pair%overlaps) area = pair%near
  end function area_of

  !> Warn about a body that comes apart, or about elements of BLOCk and ELEMents, which belong to no
  !! body, if they come apart.
  subroutine warn_seam(draft, mesh, skin, pair, double, loose)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    type(pair_t), intent(in) :: pair
    logical, intent(in) :: double(:), loose(:) !! (nnode)
    logical :: seen(size(double))
    character(:), allocatable :: text, hint
    integer :: e, m, n

    seen = .false.
    do e = 1, skin%surface%nelem
      if (skin%body(e) /= pair%body(1)) cycle
      seen(skin%surface%node(skin%surface%first(e):skin%surface%first(e + 1) - 1)) = .true.
    end do
    n = count(seen .and. double)
    m = count(seen .and. loose)
    text = 'element faces of '//body_name(mesh, pair%body(1))//' touch each other over an area ' &
           //'of about '//to_text(sum(pair%area)/2, 2)//' and are not joined'
    if (n > 0) then
      text = text//', although some of their nodes coincide with other nodes (number: ' &
             //to_text(n)//')'
      hint = 'join these nodes with TIE; otherwise the body comes apart there'
    else if (m > 0) then
      text = text//': nodes of the one lie between nodes of the other and have no constraint ' &
             //'(number: '//to_text(m)//'), such as '//named(mesh, findloc(seen .and. loose, &
                                                                           .true., 1))
      hint = 'the body comes apart there: the file of CONStraint must contain all hanging nodes'
    else
      hint = 'the body comes apart there: use meshes that match, and join them with TIE'
    end if
    call warn(text, place_of(draft, mesh, skin, pair), hint)
  end subroutine warn_seam

  !> The place in the deck of the second body of a pair, or of one of its elements.
  function place_of(draft, mesh, skin, pair) result(place)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    type(pair_t), intent(in) :: pair
    type(place_t) :: place

    if (pair%body(2) > 0) then
      place = mesh%body(pair%body(2))%place
    else
      associate (block => mesh%block(skin%surface%block(pair%face)))
        place = draft%places%at(draft%elements%place(block%number(skin%surface%elem(pair%face))))
      end associate
    end if
  end function place_of

  !> Gather the outer faces of all elements, and sort them into buckets.
  subroutine make_skin(mesh, contact, skin)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    type(skin_t), intent(out) :: skin
    integer, allocatable :: block(:), elem(:), side(:)

    call find_outer_faces(mesh, block, elem, side)
    call gather_faces(mesh, block, elem, side, 'all faces', skin%surface)
    if (size(block) == 0) return
    call update_shape(skin%surface, mesh%xr, skin%shape)
    skin%body = mesh%block(block)%body
    skin%rigid = is_rigid(mesh%block(block))
    skin%spline = mesh%block(block)%row%spline
    call find_rigid_nodes(mesh, skin%rigid_body)
    skin%width = maxval(skin%shape%high - skin%shape%low, dim=1)
    call find_depths(mesh, skin)
    call mark_sides(mesh, contact, skin)
    call fill_buckets(skin)
  end subroutine make_skin

  !> Estimate the depth of the element behind each face as twice the distance between the face and
  !! the mean of the element's nodes.
  subroutine find_depths(mesh, skin)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(inout) :: skin
    real(wp) :: x(3), a(3, 2), b(3, 3), n(3)
    integer :: e

    associate (s => skin%surface)
      allocate (skin%depth(s%nelem))
      do e = 1, s%nelem
        call surface_point(s, skin%shape, e, [0.0_wp, 0.0_wp], x, a, b)
        n = cross(a(:, 1), a(:, 2))
        associate (node => mesh%block(s%block(e))%conn(:, s%elem(e)))
          skin%depth(e) = 2*abs(dot_product(sum(mesh%xr(:, node), 2)/size(node) - x, n)) &
                          /max(norm2(n), tiny(n))
        end associate
        if (skin%rigid(e)) skin%depth(e) = huge(n) ! a rigid body may be only a surface
      end do
    end associate
  end subroutine find_depths

  !> Mark the faces on the two sides of each contact.
  subroutine mark_sides(mesh, contact, skin)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    type(skin_t), intent(inout) :: skin
    integer, allocatable :: at(:, :)  ! (6, elements of all blocks) number of each face; 0: inner
    integer :: before(size(mesh%block)) ! elements of the previous blocks
    integer :: b, c, e, f, k, n

    n = 0
    do b = 1, size(mesh%block)
      before(b) = n
      n = n + mesh%block(b)%nelem
    end do
    associate (s => skin%surface)
      allocate (skin%side(s%nelem, size(contact)), source=0)
      if (size(contact) == 0) return
      allocate (at(6, n), source=0)
      do e = 1, s%nelem
        at(s%face(e), before(s%block(e)) + s%elem(e)) = e
      end do
    end associate
    do c = 1, size(contact)
      do k = 1, 2
        associate (side => contact(c)%side(k))
          do f = 1, side%nelem
            e = at(side%face(f), before(side%block(f)) + side%elem(f))
            if (e > 0) skin%side(e, c) = ibset(skin%side(e, c), k - 1)
          end do
        end associate
      end do
    end do
  end subroutine mark_sides

  !> Sort the faces into buckets that are about as wide as a face; a face is in every bucket that
  !! its box overlaps.
  subroutine fill_buckets(skin)
    type(skin_t), intent(inout) :: skin
    integer :: e, i, j, k, m, pass, from(3), to(3)
    real(wp) :: high(3)

    skin%low = minval(skin%shape%low, 2)
    high = maxval(skin%shape%high, 2)
    skin%cell = max(sum(skin%width)/size(skin%width), maxval(high - skin%low)*1.0e-6_wp, &
                    tiny(1.0_wp)*1.0e3_wp)
    do
      skin%n = int(min((high - skin%low)/skin%cell, 1.0e6_wp)) + 1
      if (product(real(skin%n, wp)) <= 4.0_wp*size(skin%width) + 8.0_wp) exit
      skin%cell = 1.3_wp*skin%cell
    end do
    allocate (skin%first(product(skin%n) + 2), source=0)
    do pass = 1, 2 ! count, then fill
      do e = 1, skin%surface%nelem
        from = bucket(skin, skin%shape%low(:, e) - CURVED*skin%width(e))
        to = bucket(skin, skin%shape%high(:, e) + CURVED*skin%width(e))
        do k = from(3), to(3)
          do j = from(2), to(2)
            do i = from(1), to(1)
              m = number_of(skin, [i, j, k])
              if (pass == 1) then
                skin%first(m + 2) = skin%first(m + 2) + 1
              else
                skin%face(skin%first(m + 1)) = e
                skin%first(m + 1) = skin%first(m + 1) + 1
              end if
            end do
          end do
        end do
      end do
      if (pass == 2) exit
      skin%first(1:2) = 1
      do m = 3, size(skin%first)
        skin%first(m) = skin%first(m) + skin%first(m - 1)
      end do
      allocate (skin%face(skin%first(size(skin%first)) - 1))
    end do
  end subroutine fill_buckets

  pure function bucket(skin, x) result(at)
    type(skin_t), intent(in) :: skin
    real(wp), intent(in) :: x(3)
    integer :: at(3)

    at = int(max(0.0_wp, min((x - skin%low)/skin%cell, skin%n - 1.0_wp))) + 1
  end function bucket

  pure integer function number_of(skin, at)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: at(3)

    number_of = at(1) + skin%n(1)*(at(2) - 1 + skin%n(2)*(at(3) - 1))
  end function number_of

  !> Find the pairs of bodies whose faces touch and are not joined, and those nodes of such faces
  !! that lie at the position of another node. If the mesh has constraints, also find the hanging
  !! nodes without a constraint.
  subroutine find_pairs(mesh, skin, pair, npair, double, loose)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    type(pair_t), allocatable, intent(out) :: pair(:)
    integer, intent(out) :: npair
    logical, allocatable, intent(out) :: double(:), loose(:)
    logical, allocatable :: hangs(:)
    real(wp) :: xi(2), x(3), a(3, 2), b(3, 3), area(3), gap
    logical :: unlike, free
    integer :: e, f, i, k, p

    allocate (pair(8))
    allocate (double(mesh%nnode), loose(mesh%nnode), source=.false.)
    npair = 0
    hangs = [(.false., i=1, mesh%nnode)]
    if (mesh%constraint%n > 0) hangs = slave_marks(mesh%constraint, mesh%nnode) > 0
    associate (s => skin%surface)
      do e = 1, s%nelem
        do k = 0, NPOINT**2 - 1
          xi = (2*[mod(k, NPOINT), k/NPOINT] + 1)/real(NPOINT, wp) - 1.0_wp
          call surface_point(s, skin%shape, e, xi, x, a, b)
          area = cross(a(:, 1), a(:, 2))*(2.0_wp/NPOINT)**2
          call find_face(skin, e, xi, x, area, f, gap, unlike)
          if (f == 0) cycle
          free = .false.
          if (mesh%constraint%n > 0 .and. skin%body(e) == skin%body(f)) then
            call mark_loose(mesh, skin, hangs, e, f, loose, free)
          end if
          if (.not. free) then ! masters join hanging nodes
            if (any(hangs(s%node(s%first(e):s%first(e + 1) - 1)))) cycle
            if (any(hangs(s%node(s%first(f):s%first(f + 1) - 1)))) cycle
          end if
          call find_pair(skin%body(e), skin%body(f), f, pair, npair, p)
          if (unlike) then
            call count_unlike(merge(1, 2, skin%body(e) == pair(p)%body(1)), pair(p))
            cycle
          end if
          call count_point(merge(1, 2, skin%body(e) == pair(p)%body(1)), pair(p))
          if (skin%body(e) == skin%body(f)) call mark_double(mesh, skin, e, f, double)
        end do
      end do
    end associate
    do p = 1, npair
      if (pair(p)%meets) call count_met(pair(p))
    end do

  contains

    !> Count a point of side k.
    subroutine count_point(k, pair)
      integer, intent(in) :: k
      type(pair_t), intent(inout) :: pair
      real(wp) :: equal

      equal = TOUCHING*min(skin%width(e), skin%width(f))
      pair%near(k) = pair%near(k) + norm2(area)
      pair%overlaps = pair%overlaps .or. gap < -equal
      if (abs(gap) <= equal) pair%area(k) = pair%area(k) + norm2(area)
      if (skin%body(e) == skin%body(f) .or. .not. (skin%spline(e) .or. skin%spline(f))) return
      if (.not. meet(skin%surface, e, f)) return
      pair%meets = .true.
      call note_faces(k, pair)
    end subroutine count_point

    !> Count a point of side k between common nodes.
    subroutine count_unlike(k, pair)
      integer, intent(in) :: k
      type(pair_t), intent(inout) :: pair

      pair%unlike(k) = pair%unlike(k) + norm2(area)
      call note_faces(k, pair)
    end subroutine count_unlike

    !> Keep the first faces with common nodes that join them only in part.
    subroutine note_faces(k, pair)
      integer, intent(in) :: k
      type(pair_t), intent(inout) :: pair

      if (pair%unlike_face(1) > 0) return
      pair%unlike_face = merge([e, f], [f, e], skin%rigid(f) .or. k == 1 .and. .not. skin%rigid(e))
    end subroutine note_faces

    !> Count the areas that touch among those that common nodes join in part.
    subroutine count_met(pair)
      type(pair_t), intent(inout) :: pair

      pair%unlike = pair%unlike + area_of(pair)
      pair%area = 0.0_wp
      pair%overlaps = .false.
    end subroutine count_met

  end subroutine find_pairs

  !> Find the face that touches a point of face e. There is none (f = 0) if one of the faces that
  !! touch the point is joined to face e there or is the other side of a contact with face e.
  subroutine find_face(skin, e, xi, x, area, f, gap, unlike)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(2)         !! parameters of the point in face e
    real(wp), intent(in) :: x(3), area(3) !! the point, and the outward normal there
    integer, intent(out) :: f
    real(wp), intent(out) :: gap          !! [L] negative: the point is behind the face
    logical, intent(out) :: unlike        !! faces e and f have common nodes, but come apart here
    real(wp) :: reach, g, eta(2)
    logical :: joined, apart
    integer :: i, m, other

    f = 0
    gap = huge(gap)
    unlike = .false.
    m = number_of(skin, bucket(skin, x))
    do i = skin%first(m), skin%first(m + 1) - 1
      other = skin%face(i)
      if (other == e .or. (skin%rigid(e) .and. skin%rigid(other))) cycle
      reach = min(skin%width(e), skin%width(other))
      if (skin%body(e) == skin%body(other)) then
        reach = TOUCHING*reach
      else
        reach = min(CURVED*reach, SHALLOW*min(skin%depth(e), skin%depth(other)))
      end if
      if (any(x < skin%shape%low(:, other) - reach)) cycle
      if (any(x > skin%shape%high(:, other) + reach)) cycle
      call measure(skin, other, x, area, g, eta)
      if (abs(g) > reach) cycle
      call compare(skin, e, xi, other, eta, joined, apart)
      if (joined .or. in_contact(skin, e, other)) then
        f = 0
        unlike = .false.
        return
      end if
      if (unlike .and. .not. apart) cycle
      if ((unlike .eqv. apart) .and. abs(g) >= abs(gap)) cycle
      gap = g
      f = other
      unlike = apart
    end do
  end subroutine find_face

  !> Do common nodes join two faces at a point of both, or do the faces have common nodes and come
  !! apart at this point? The functions of a face do not matter if all its nodes are those of a
  !! rigid body.
  subroutine compare(skin, e, xi, f, eta, joined, apart)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e, f
    real(wp), intent(in) :: xi(2), eta(2) !! parameters of the point in the two faces
    logical, intent(out) :: joined, apart

    associate (s => skin%surface)
      apart = is_joined(s, e, f)
      if (skin%rigid(f)) then
        joined = is_held(s, e, skin%rigid_body, skin%body(f))
      else if (skin%rigid(e)) then
        joined = is_held(s, f, skin%rigid_body, skin%body(e))
      else
        joined = apart
        if (joined .and. (skin%spline(e) .or. skin%spline(f))) then
          joined = .not. differ(s, e, xi, f, eta)
        end if
      end if
      apart = apart .and. .not. joined
    end associate
  end subroutine compare

  !> Find the gap between a point and a face, by the Gauss-Newton method within the face. The gap is
  !! huge if no point of the face lies opposite this point, or if the face does not point towards
  !! the face of the point.
  subroutine measure(skin, f, x, area, gap, xi)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: f
    real(wp), intent(in) :: x(3), area(3)
    real(wp), intent(out) :: gap
    real(wp), intent(out) :: xi(2)        !! parameters of the closest point
    real(wp) :: y(3), a(3, 2), b(3, 3), m(2, 2), r(2), step(2), det, n(3)
    integer :: it

    gap = huge(gap)
    xi = 0.0_wp
    do it = 1, MOST_STEPS
      call surface_point(skin%surface, skin%shape, f, xi, y, a, b)
      m = matmul(transpose(a), a)
      r = matmul(x - y, a)
      det = m(1, 1)*m(2, 2) - m(1, 2)**2
      if (.not. det > epsilon(det)*m(1, 1)*m(2, 2)) return
      step = [m(2, 2)*r(1) - m(1, 2)*r(2), m(1, 1)*r(2) - m(1, 2)*r(1)]/det
      xi = max(-1.0_wp - 2*BORDER, min(1.0_wp + 2*BORDER, xi + step))
      if (maxval(abs(step)) < BORDER) exit
    end do
    if (maxval(abs(xi)) > 1.0_wp + BORDER) return
    n = cross(a(:, 1), a(:, 2))
    if (dot_product(n, area) > OPPOSITE*norm2(n)*norm2(area)) return
    gap = dot_product(x - y, n)/norm2(n)
    if (norm2(x - y) > 2*abs(gap) + TOUCHING*skin%width(f)) gap = huge(gap)
  end subroutine measure

  !> Are two faces on the two sides of a contact?
  pure logical function in_contact(skin, e, f)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e, f

    in_contact = any((btest(skin%side(e, :), 0) .and. btest(skin%side(f, :), 1)) &
                     .or. (btest(skin%side(e, :), 1) .and. btest(skin%side(f, :), 0)))
  end function in_contact

  !> Find the pair of two bodies in a list, or append it.
  subroutine find_pair(a, b, face, pair, npair, p)
    integer, intent(in) :: a, b, face !! two bodies; a face of the second one
    type(pair_t), allocatable, intent(inout) :: pair(:)
    integer, intent(inout) :: npair
    integer, intent(out) :: p
    type(pair_t), allocatable :: longer(:)

    do p = 1, npair
      if (pair(p)%body(1) == min(a, b) .and. pair(p)%body(2) == max(a, b)) return
    end do
    if (npair == size(pair)) then
      allocate (longer(2*npair))
      longer(:npair) = pair
      call move_alloc(longer, pair)
    end if
    npair = p
    pair(p)%body = [min(a, b), max(a, b)]
    pair(p)%face = face
  end subroutine find_pair

  !> Mark the nodes of two faces that lie at one position.
  subroutine mark_double(mesh, skin, e, f, double)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e, f
    logical, intent(inout) :: double(:)
    real(wp) :: near
    integer :: i, j

    near = TOUCHING*min(skin%width(e), skin%width(f))
    associate (s => skin%surface)
      do i = s%first(e), s%first(e + 1) - 1
        do j = s%first(f), s%first(f + 1) - 1
          if (s%node(i) == s%node(j)) cycle
          if (any(abs(mesh%xr(:, s%node(i)) - mesh%xr(:, s%node(j))) > near)) cycle
          double(s%node([i, j])) = .true.
        end do
      end do
    end associate
  end subroutine mark_double

  !> Mark the nodes of each of two faces that lie on the other one and are joined to it neither by a
  !! node at the same position nor by a constraint. Control points of splines do not count, as they
  !! need not lie on their faces.
  subroutine mark_loose(mesh, skin, hangs, e, f, loose, free)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    logical, intent(in) :: hangs(:)       !! (nnode) the node has a constraint
    integer, intent(in) :: e, f
    logical, intent(inout) :: loose(:)    !! (nnode)
    logical, intent(out) :: free          !! there are such nodes, or nodes at the same position
    !! that are not joined
    real(wp) :: near, gap, x(3), xi(2), a(3, 2), b(3, 3)
    integer :: face(2), i, j, k

    free = .false.
    face = [e, f]
    near = TOUCHING*min(skin%width(e), skin%width(f))
    associate (s => skin%surface)
      do k = 1, 2
        if (skin%spline(face(k))) cycle
        call surface_point(s, skin%shape, face(k), [0.0_wp, 0.0_wp], x, a, b)
        associate (other => s%node(s%first(face(3 - k)):s%first(face(3 - k) + 1) - 1))
          do i = s%first(face(k)), s%first(face(k) + 1) - 1
            if (hangs(s%node(i)) .or. any(other == s%node(i))) cycle
            x = mesh%xr(:, s%node(i))
            call measure(skin, face(3 - k), x, cross(a(:, 1), a(:, 2)), gap, xi)
            if (abs(gap) > near) cycle
            free = .true.
            if (any([(all(abs(mesh%xr(:, other(j)) - x) <= near), j=1, size(other))])) cycle
            loose(s%node(i)) = .true.
          end do
        end associate
      end do
    end associate
  end subroutine mark_loose

end module input_touching
