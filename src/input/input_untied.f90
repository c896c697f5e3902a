!> Finds, after TIE, the nodes that lie on a face of another body and are not tied to it. If the
!! meshes of two bodies do not match, TIE joins none or only some of their nodes, and the bodies
!! come apart there.
module input_untied
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text, quoted, lower
  use contact_pair, only: contact_t
  use input_doubts, only: shortest
  use input_draft, only: draft_t
  use input_skin, only: skin_t, make_skin, face_width
  use mesh, only: mesh_t
  use projection, only: project
  use projection_search, only: is_near
  use projection_type, only: foot_t
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: warn_untied, warn_hanging

  !> A node lies on a face if its distance is at most ON_FACE times the extent of the mesh or at
  !! most CURVED times the width of the face.
  real(wp), parameter :: ON_FACE = 1.0e-6_wp
  !> Faces lie on each other if their distance is less than CURVED times their width (flat elements
  !! of one curved surface may be that far apart), and if the cosine of the angle between their
  !! outward normals is less than OPPOSITE.
  real(wp), parameter :: CURVED = 0.05_wp, OPPOSITE = -0.7_wp

contains

  !> Warn about contacts whose sides TIE has joined along a line or at single points, where the
  !! bodies cannot separate. If TIE has joined whole elements of a side, contact_start warns.
  subroutine warn_hanging(mesh, contact, tied)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    integer, intent(in) :: tied(:)        !! (nnode) the node that replaces each node after TIE
    logical :: meets(mesh%nnode), joined(mesh%nnode), on(mesh%nnode, 2)
    integer :: c, e, k, n

    meets = .false.
    do n = 1, mesh%nnode
      if (tied(n) /= n) meets(tied(n)) = .true.
    end do
    if (.not. any(meets)) return
    do c = 1, size(contact)
      if (contact(c)%self) cycle
      on = .false.
      do k = 1, 2
        on(contact(c)%side(k)%node, k) = .true.
      end do
      joined = meets .and. on(:, 1) .and. on(:, 2)
      n = count(joined)
      associate (side => contact(c)%side(1))
        do e = 1, side%nelem
          if (all(joined(side%node(side%first(e):side%first(e + 1) - 1)))) n = 0
        end do
      end associate
      if (n > 0) then
        call warn("contact '"//contact(c)%name//"': TIE joins nodes of its two sides (number: " &
                  //to_text(n)//'), which cannot separate or slide there', contact(c)%place, &
                  'TIE alone or with a plane joins nodes of all bodies: use TIE,NODE or ' &
                  //'TIE,MATErial')
      end if
    end do
  end subroutine warn_hanging

  !> Warn about pairs of bodies that touch and are tied only partly or not at all. Bodies between
  !! which a contact acts are skipped.
  subroutine warn_untied(draft, mesh, told)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: told(:, :) !! (nbody, nbody) pairs of bodies a < b
    type(skin_t), allocatable :: skin(:)
    logical, allocatable :: on(:, :) ! (nnode, 2) untied nodes of one body and of the other
    logical, allocatable :: held(:)  ! (nnode) something else holds the node
    real(wp) :: near, away(2)
    integer :: a, b, n, tied

    allocate (told(size(mesh%body), size(mesh%body)), source=.false.)
    if (size(mesh%body) < 2 .or. size(draft%tie) == 0 .or. mesh%nnode == 0) return
    near = ON_FACE*maxval(maxval(mesh%xr, 2) - minval(mesh%xr, 2))
    allocate (skin(size(mesh%body)), on(mesh%nnode, 2))
    call find_held(mesh, draft%model%contact, held)
    do a = 1, size(skin)
      call make_skin(mesh, a, skin(a))
    end do
    do a = 1, size(skin)
      do b = a + 1, size(skin)
        if (.not. (skin(a)%exists .and. skin(b)%exists)) cycle
        if (in_contact(draft, mesh%body(a)%name, mesh%body(b)%name)) cycle
        away = [huge(away), 0.0_wp]
        call find_loose(mesh, a, b, skin, near, held, on(:, 1), away)
        call find_loose(mesh, b, a, skin, near, held, on(:, 2), away)
        n = count(on)
        if (n == 0) cycle
        if (.not. (shares_face(skin(a), skin(b), on(:, 1)) .or. &
                   shares_face(skin(b), skin(a), on(:, 2)))) cycle ! they share an edge or a corner
        told(a, b) = .true.
        tied = shared(mesh%body(a)%node, mesh%body(b)%node)
        if (tied == 0 .and. away(1) > near) then
          call warn('TIE joins no nodes of '//quoted(mesh%body(a)%name)//' and ' &
                    //quoted(mesh%body(b)%name)//', which are up to '//to_text(away(2), 3) &
                    //' apart on their common face', mesh%body(b)%place, 'the bodies do not act ' &
                    //'on each other: move one of them to close the gap, if its position is ' &
                    //'rounded, or use CONTact')
          cycle
        end if
        call warn('TIE joins '//to_text(tied)//' nodes of '//quoted(mesh%body(a)%name)//' and ' &
                  //quoted(mesh%body(b)%name)//'; '//to_text(n)//' nodes on their common face ' &
                  //'stay untied', mesh%body(b)%place, 'the meshes do not match there, and the ' &
                  //'bodies come apart: use meshes that match, or CONTact with COHEsive')
      end do
    end do
  end subroutine warn_untied

  !> Does a contact of the deck act between two bodies?
  pure logical function in_contact(draft, a, b)
    type(draft_t), intent(in) :: draft
    character(*), intent(in) :: a, b
    integer :: c

    in_contact = .false.
    do c = 1, size(draft%contact)
      associate (at => draft%contact(c)%at)
        if (.not. (allocated(at(1)%body) .and. allocated(at(2)%body))) cycle
        in_contact = in_contact &
                     .or. (lower(at(1)%body) == lower(a) .and. lower(at(2)%body) == lower(b)) &
                     .or. (lower(at(1)%body) == lower(b) .and. lower(at(2)%body) == lower(a))
      end associate
    end do
  end function in_contact

  !> Mark the nodes of body a that lie on a face of body b and do not belong to b. Control points
  !! are not marked, because they need not lie on the surface. In front of the whole body b, a node
  !! lies on a face if the distance is small compared with the elements of both bodies, and if
  !! nothing else, such as a thin layer between the bodies, holds it.
  subroutine find_loose(mesh, a, b, skin, near, held, on, away)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: a, b
    type(skin_t), intent(in) :: skin(:)
    real(wp), intent(in) :: near       !! [L]
    logical, intent(in) :: held(:)     !! (nnode) from find_held
    logical, intent(out) :: on(:)      !! (nnode)
    real(wp), intent(inout) :: away(2) !! least and largest distance of such nodes [L]
    type(foot_t) :: foot
    logical :: theirs(mesh%nnode), seen(mesh%nnode)
    real(wp) :: reach
    integer :: e, i

    on = .false.
    theirs = .false.
    theirs(mesh%body(b)%node) = .true.
    seen = .false.
    do e = 1, skin(a)%surface%nelem
      reach = max(near, CURVED*edge_behind(mesh, skin(a), e))
      do i = skin(a)%surface%first(e), skin(a)%surface%first(e + 1) - 1
        associate (node => skin(a)%surface%node(i), other => skin(b))
          if (theirs(node) .or. seen(node) .or. mesh%is_control(node)) cycle
          seen(node) = .true.
          foot%elem = 0
          call project(other%surface, other%shape, other%grid, mesh%xr(:, node), foot, reach)
          if (foot%elem == 0) cycle
          on(node) = abs(foot%gap) <= max(near, CURVED*face_width(other, foot%elem))
          if (.not. is_near(other%grid, mesh%xr(:, node), near)) then
            on(node) = on(node) .and. .not. held(node) .and. &
                       abs(foot%gap) <= min(reach, CURVED*edge_behind(mesh, other, foot%elem))
          end if
          if (on(node)) away = [min(away(1), abs(foot%gap)), max(away(2), abs(foot%gap))]
        end associate
      end do
    end do
  end subroutine find_loose

  !> Shortest distance between nodes of the element behind face e [L].
  pure real(wp) function edge_behind(mesh, skin, e) result(edge)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e

    associate (s => skin%surface)
      edge = shortest(mesh%xr(:, mesh%block(s%block(e))%conn(:, s%elem(e))))
    end associate
  end function edge_behind

  !> Mark the nodes that belong to several bodies or to a side of a contact.
  pure subroutine find_held(mesh, contact, held)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, allocatable, intent(out) :: held(:) !! (nnode)
    integer :: nbody(mesh%nnode) ! number of bodies with this node
    integer :: b, c, k

    nbody = 0
    do b = 1, size(mesh%body)
      nbody(mesh%body(b)%node) = nbody(mesh%body(b)%node) + 1
    end do
    held = nbody > 1
    do c = 1, size(contact)
      do k = 1, 2
        held(contact(c)%side(k)%node) = .true.
      end do
    end do
  end subroutine find_held

  !> Does a face with one of the given nodes lie on a face of the other body somewhere? Bodies that
  !! share only an edge or a corner also have nodes on faces of each other.
  pure logical function shares_face(own, other, on) result(shares)
    type(skin_t), intent(in) :: own, other
    logical, intent(in) :: on(:)       !! (nnode)
    real(wp), parameter :: AT(5) = [-0.999_wp, -0.5_wp, 0.0_wp, 0.5_wp, 0.999_wp] !! points of faces
    type(foot_t) :: foot
    real(wp) :: x(3), a(3, 2), b(3, 3), n(3), reach
    integer :: e, i, j

    shares = .true.
    associate (s => own%surface)
      do e = 1, s%nelem
        if (.not. any(on(s%node(s%first(e):s%first(e + 1) - 1)))) cycle
        reach = CURVED*face_width(own, e)
        do i = 1, size(AT)
          do j = 1, size(AT)
            call surface_point(s, own%shape, e, AT([i, j]), x, a, b)
            n = cross(a(:, 1), a(:, 2))
            foot%elem = 0
            call project(other%surface, other%shape, other%grid, x, foot, reach)
            if (foot%elem == 0) cycle
            if (abs(foot%gap) > reach) cycle
            if (all(foot%free) .and. dot_product(foot%n, n) < OPPOSITE*norm2(n)) return
          end do
        end do
      end do
    end associate
    shares = .false.
  end function shares_face

  !> Number of nodes that two lists share.
  pure integer function shared(a, b) result(n)
    integer, intent(in) :: a(:), b(:)
    logical, allocatable :: on(:)
    integer :: i

    allocate (on(max(maxval([0, a]), maxval([0, b]))), source=.false.)
    on(a) = .true.
    n = 0
    do i = 1, size(b)
      if (on(b(i))) n = n + 1
    end do
  end function shared

end module input_untied
