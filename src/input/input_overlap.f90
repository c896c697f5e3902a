!> Finds bodies that overlap, at the start or at the end of a run, although neither nodes nor a
!! contact join them. Such bodies pass through each other, and nothing else in the results shows
!! this.
!!
!! Points of the outer elements of one body are projected onto the outer faces of the other one.
!! Flat elements of curved surfaces that just touch overlap a little, so small overlaps are ignored.
!! At the start, overlaps between two groups that each consist of several joined bodies are ignored
!! too, because a deck may contain several independent models. At the end, bodies must not overlap
!! even if a contact acts between some of their faces; only bonds and common nodes join them. Rigid
!! bodies that overlap each other are ignored.
module input_overlap
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: position_text, to_text
  use contact_pair, only: contact_t
  use element_type, only: cell_t
  use input_locate, only: locate_point
  use input_skin, only: skin_t, make_skin, face_width, body_name
  use mesh, only: mesh_t, block_cell, is_rigid
  use projection, only: project
  use projection_type, only: foot_t
  use surface_geometry, only: surface_point
  use tensor, only: cross
  implicit none
  private
  public :: warn_overlaps, warn_crossed, find_centre

  !> A point is inside another body if its depth exceeds this fraction of the sizes of both faces:
  !! that of the point, and the nearest one of the other body. The size is the width of the face or
  !! the thickness of its element, whichever is smaller; in a plate of wide elements, no point is
  !! deeper than half of its thickness. If a contact between the bodies has closed, it is the width,
  !! because the faces of curved thin bodies that touch overlap a little. The faces of rigid bodies
  !! have the exact shape, so their sizes do not matter, but they may be as large as the body.
  real(wp), parameter :: DEEP = 0.3_wp
  !> Flat faces of a curved surface overlap the surface by about an eighth of their width times the
  !! angle between them, more at their corners; smaller depths than this fraction do not count.
  real(wp), parameter :: BULGE = 0.25_wp
  real(wp), parameter :: SMOOTH = 0.5_wp !! cosine of a larger angle: the edge of a body
  integer, parameter :: INTERVALS = 2       !! number of intervals of an edge of a face
  integer, parameter :: RIGID_INTERVALS = 8 !! the same for a rigid body
  integer, parameter :: MOST_PAIRS = 5  !! largest number of pairs that are named

contains

  !> Warn about each pair of bodies that overlap at the start, unless a contact or common nodes join
  !! them.
  subroutine warn_overlaps(mesh, contact, told)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: told(:, :)  !! (nbody, nbody) pairs that a warning has named already
    logical, allocatable :: overlap(:, :)
    real(wp), allocatable :: x(:, :, :)
    integer :: i

    call find_overlaps(mesh, contact, [(.true., i=1, size(contact))], &
                       [(.false., i=1, size(contact))], .false., told, overlap, x)
    call warn_pairs(mesh, overlap, x, 'at the start', 'and nothing joins them, so they do not ' &
                    //'act on each other', 'check their positions and sizes; bodies that touch ' &
                    //'act on each other only through CONTact or TIE')
  end subroutine warn_overlaps

  !> At the end of a run, warn about each pair of bodies that have moved into each other although
  !! they did not overlap at the start, unless bonds or common nodes join them. A contact may name
  !! other faces than those that meet.
  subroutine warn_crossed(mesh, contact, acted, x)
    type(mesh_t), intent(inout) :: mesh    !! unchanged on return
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acted(:)        !! (size(contact)) the contact has closed in some step
    real(wp), intent(in) :: x(:, :)        !! (3, nnode) current positions [L]
    logical, allocatable :: overlap(:, :), before(:, :)
    logical :: none(size(mesh%body), size(mesh%body)), bonded(size(contact))
    real(wp), allocatable :: at(:, :, :), unused(:, :, :), xr(:, :)

    if (.not. allocated(mesh%xr) .or. size(mesh%body) == 0) return
    none = .false.
    bonded = contact%cohesive%given
    xr = mesh%xr
    mesh%xr = x
    call find_overlaps(mesh, contact, bonded, acted, .true., none, overlap, at)
    mesh%xr = xr
    if (.not. any(overlap)) return
    call find_overlaps(mesh, contact, bonded, acted, .true., none, before, unused)
    call warn_pairs(mesh, overlap .and. .not. before, at, 'at the end', 'where nothing makes ' &
                    //'them act on each other', 'bodies act on each other only through ' &
                    //'CONTact or TIE: name all faces that meet in a CONTact')
  end subroutine warn_crossed

  !> Find the pairs of bodies that overlap and that nothing joins.
  subroutine find_overlaps(mesh, contact, joins, acted, groups, told, overlap, x)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: joins(:)        !! (size(contact)) contacts that join bodies
    logical, intent(in) :: acted(:)        !! (size(contact)) contacts that have closed
    logical, intent(in) :: groups          !! examine groups of joined bodies, too
    logical, intent(in) :: told(:, :)      !! (nbody, nbody) pairs that are not examined
    logical, allocatable, intent(out) :: overlap(:, :) !! (0:nbody, 0:nbody) pairs a < b
    real(wp), allocatable, intent(out) :: x(:, :, :)   !! (3, 0:nbody, 0:nbody) a common point [L]
    type(skin_t), allocatable :: skin(:)
    logical :: thin
    integer :: a, b, nbody

    nbody = size(mesh%body)
    call find_candidates(mesh, contact, joins, groups, told, overlap)
    allocate (x(3, 0:nbody, 0:nbody), source=0.0_wp)
    if (.not. any(overlap)) return
    allocate (skin(0:nbody))
    do a = 0, nbody
      if (any(overlap(a, :) .or. overlap(:, a))) call make_skin(mesh, a, skin(a))
    end do
    do a = 0, nbody
      do b = a + 1, nbody
        if (.not. overlap(a, b)) cycle
        overlap(a, b) = skin(a)%exists .and. skin(b)%exists
        if (.not. overlap(a, b)) cycle
        thin = .not. in_contact(mesh, contact, acted, a, b)
        call find_deep_point(mesh, skin(a), skin(b), b, thin, x(:, a, b), overlap(a, b))
        if (.not. overlap(a, b)) then
          call find_deep_point(mesh, skin(b), skin(a), a, thin, x(:, a, b), overlap(a, b))
        end if
      end do
    end do
  end subroutine find_overlaps

  !> Does a contact that has closed name faces of both bodies?
  pure logical function in_contact(mesh, contact, acted, a, b) result(yes)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: acted(:)
    integer, intent(in) :: a, b
    integer :: c, k

    yes = .false.
    do c = 1, size(contact)
      if (.not. acted(c)) cycle
      do k = 1, 2
        yes = yes .or. (any(mesh%block(contact(c)%side(k)%block)%body == a) .and. &
                        any(mesh%block(contact(c)%side(3 - k)%block)%body == b))
      end do
    end do
  end function in_contact

  !> Name the first pairs of bodies that overlap, and the number of the others.
  subroutine warn_pairs(mesh, overlap, x, when, why, hint)
    type(mesh_t), intent(in) :: mesh
    logical, intent(in) :: overlap(0:, 0:)
    real(wp), intent(in) :: x(:, 0:, 0:)   !! (3, 0:nbody, 0:nbody) a common point [L]
    character(*), intent(in) :: when, why, hint
    integer :: a, b, n

    n = 0
    do a = 0, size(mesh%body)
      do b = a + 1, size(mesh%body)
        if (.not. overlap(a, b)) cycle
        n = n + 1
        if (n > MOST_PAIRS) cycle
        call warn(body_name(mesh, a)//' and '//body_name(mesh, b)//' overlap '//when//', for ' &
                  //'example at '//position_text(x(:, a, b))//', '//why, mesh%body(b)%place, hint)
      end do
    end do
    if (n > MOST_PAIRS) call warn(to_text(n - MOST_PAIRS)//' more pairs of bodies overlap '//when)
  end subroutine warn_pairs

  !> Mark the pairs of bodies whose boxes overlap, of which at least one deforms, and that nothing
  !! joins.
  subroutine find_candidates(mesh, contact, joins, groups, told, may)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact(:)
    logical, intent(in) :: joins(:)
    logical, intent(in) :: groups
    logical, intent(in) :: told(:, :)
    logical, allocatable, intent(out) :: may(:, :) !! (0:nbody, 0:nbody) pairs a < b
    integer, allocatable :: owner(:) ! (nnode) first body of a node; -1: none
    logical, allocatable :: on(:, :) ! (0:nbody, 2) bodies on the sides of a contact
    real(wp) :: low(3, 0:size(mesh%body)), high(3, 0:size(mesh%body))
    integer :: group(0:size(mesh%body)) ! number of the group of joined bodies
    logical :: deforms(0:size(mesh%body))
    integer :: a, b, c, e, i, k, s

    group = [(a, a=0, size(mesh%body))]
    allocate (may(0:size(mesh%body), 0:size(mesh%body)), source=.false.)
    low = huge(low)
    high = -huge(high)
    deforms = .false.
    do b = 1, size(mesh%block)
      associate (set => mesh%block(b), a => mesh%block(b)%body)
        if (set%nelem > 0 .and. .not. is_rigid(set)) deforms(a) = .true.
        do e = 1, set%nelem
          low(:, a) = min(low(:, a), minval(mesh%xr(:, set%conn(:, e)), 2))
          high(:, a) = max(high(:, a), maxval(mesh%xr(:, set%conn(:, e)), 2))
        end do
      end associate
    end do
    do a = 0, size(mesh%body)
      do b = a + 1, size(mesh%body)
        may(a, b) = (deforms(a) .or. deforms(b)) .and. &
                    all(min(high(:, a), high(:, b)) > max(low(:, a), low(:, b)))
      end do
    end do
    may(1:, 1:) = may(1:, 1:) .and. .not. told
    if (.not. any(may)) return
    allocate (owner(mesh%nnode), source=-1)
    do b = 1, size(mesh%block)
      associate (set => mesh%block(b), a => mesh%block(b)%body)
        do e = 1, set%nelem
          do i = 1, size(set%conn, 1)
            if (owner(set%conn(i, e)) < 0) owner(set%conn(i, e)) = a
            call join(owner(set%conn(i, e)), a)
          end do
        end do
      end associate
    end do
    associate (list => mesh%constraint)
      do s = 1, list%n
        do i = list%first(s), list%first(s + 1) - 1
          if (owner(list%slave(s)) >= 0 .and. owner(list%master(i)) >= 0) then
            call join(owner(list%slave(s)), owner(list%master(i)))
          end if
        end do
      end do
    end associate
    do c = 1, size(contact)
      if (.not. joins(c)) cycle
      allocate (on(0:size(mesh%body), 2), source=.false.)
      do k = 1, 2
        on(mesh%block(contact(c)%side(k)%block)%body, k) = .true.
      end do
      do a = 0, size(mesh%body)
        do b = 0, size(mesh%body)
          if (on(a, 1) .and. on(b, 2)) call join(a, b)
        end do
      end do
      deallocate (on)
    end do
    if (groups) return
    do a = 0, size(mesh%body)
      do b = a + 1, size(mesh%body)
        if (group(a) == group(b)) cycle
        if (count(group == group(a) .and. deforms) > 1 .and. &
            count(group == group(b) .and. deforms) > 1) may(a, b) = .false.
      end do
    end do

  contains

    subroutine join(a, b)
      integer, intent(in) :: a, b

      may(min(a, b), max(a, b)) = .false.
      where (group == group(b)) group = group(a)
    end subroutine join

  end subroutine find_candidates

  !> Find a point of one body that lies deep inside another one.
  subroutine find_deep_point(mesh, own, other, body, thin, x, found)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: own, other
    integer, intent(in) :: body            !! the other body
    logical, intent(in) :: thin            !! the thickness of elements counts
    real(wp), intent(out) :: x(3)          !! [L]
    logical, intent(out) :: found
    type(foot_t) :: foot
    real(wp) :: a(3, 2), b(3, 3), width, xi(3)
    integer :: e, i, m, block, elem

    found = .true.
    associate (s => own%surface)
      do e = 1, s%nelem
        width = least_depth(mesh, own, e, thin)
        m = merge(RIGID_INTERVALS, INTERVALS, is_rigid(mesh%block(s%block(e))))
        do i = 0, (m + 1)**2
          if (i < (m + 1)**2) then
            call surface_point(s, own%shape, e, &
                               2*[real(wp) :: mod(i, m + 1), i/(m + 1)]/m - 1.0_wp, x, a, b)
          else
            call find_centre(mesh, s%block(e), s%elem(e), x)
          end if
          if (any(x < other%grid%low + width) .or. any(x > other%grid%high - width)) cycle
          foot%elem = 0
          call project(other%surface, other%shape, other%grid, x, foot)
          if (foot%elem == 0) cycle
          if (foot%gap > -width) cycle
          if (foot%gap > -least_depth(mesh, other, foot%elem, thin)) cycle
          call locate_point(mesh, body, x, block, elem, xi)
          if (block > 0) return
        end do
      end do
    end associate
    found = .false.
  end subroutine find_deep_point

  !> Depth from which on a point counts as inside, as far as it depends on face e of one body [L].
  real(wp) function least_depth(mesh, skin, e, thin) result(depth)
    type(mesh_t), intent(in) :: mesh
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e
    logical, intent(in) :: thin
    real(wp) :: centre(3), x(3), n(3)

    depth = 0.0_wp
    associate (s => skin%surface)
      if (is_rigid(mesh%block(s%block(e)))) return
      depth = DEEP*face_width(skin, e)
      if (.not. thin) return
      call middle_of(skin, e, x, n)
      call find_centre(mesh, s%block(e), s%elem(e), centre)
      depth = min(depth, max(DEEP*2*norm2(centre - x), BULGE*face_width(skin, e)*bend(skin, e)))
    end associate
  end function least_depth

  !> Largest angle between a face and its neighbours, apart from those beyond an edge of the body
  !! [rad].
  pure real(wp) function bend(skin, e) result(angle)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e
    real(wp) :: x(3), n(3), m(3), cosine
    integer :: k

    angle = 0.0_wp
    call middle_of(skin, e, x, n)
    do k = 1, 4
      if (skin%surface%neighbour(k, e) == 0) cycle
      call middle_of(skin, skin%surface%neighbour(k, e), x, m)
      cosine = dot_product(n, m)
      if (cosine > SMOOTH) angle = max(angle, acos(min(1.0_wp, cosine)))
    end do
  end function bend

  !> Middle of a face and the unit normal there.
  pure subroutine middle_of(skin, e, x, n)
    type(skin_t), intent(in) :: skin
    integer, intent(in) :: e
    real(wp), intent(out) :: x(3), n(3)
    real(wp) :: a(3, 2), b(3, 3)

    call surface_point(skin%surface, skin%shape, e, [0.0_wp, 0.0_wp], x, a, b)
    n = cross(a(:, 1), a(:, 2))
    n = n/max(norm2(n), tiny(1.0_wp))
  end subroutine middle_of

  !> Find the point of an element at which the parent coordinates are 0.
  subroutine find_centre(mesh, b, e, x)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b, e        !! block and element
    real(wp), intent(out) :: x(3)      !! [L]
    type(cell_t) :: cell
    real(wp), allocatable :: shp(:), dshp(:, :)

    associate (block => mesh%block(b))
      allocate (shp(block%nen), dshp(3, block%nen))
      call block_cell(block, e, cell)
      call block%row%functions(cell, [0.0_wp, 0.0_wp, 0.0_wp], shp, dshp)
      x = matmul(mesh%xr(:, block%conn(:, e)), shp)
    end associate
  end subroutine find_centre

end module input_overlap
