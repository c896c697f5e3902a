!> Warnings about planes that select other nodes than those that are probably meant.
module input_plane
  use base_error, only: place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use input_joined, only: find_rigid_nodes
  use mesh, only: mesh_t, is_rigid
  use rigid_modes, only: find_bodies
  implicit none
  private
  public :: plane_t, warn_plane, warn_inside

  !> A plane, and the distance from it within which nodes are found.
  type :: plane_t
    integer :: direction = 0             !! its normal
    real(wp) :: gap = 0.0_wp             !! [L]
    logical :: gap_is_given = .false.    !! by the deck
    type(place_t) :: place               !! in the deck
    character(:), allocatable :: hint    !! how to select fewer nodes
  end type plane_t

  real(wp), parameter :: BEHIND = 0.7_wp !! a node lies behind another one if the cosine of the
  !! angle between the line through both and the normal of the plane exceeds this
  real(wp), parameter :: APART = 1.0e-5_wp !! gap between two bodies, relative to the extent of the
  !! mesh, above which they are at different places
  real(wp), parameter :: ROUNDED = 0.05_wp !! smallest such gap relative to that of the plane: the
  !! deck may give the same place with different numbers of digits

contains

  !> Warn if a plane selects two layers of nodes of an element, or nodes of two bodies on its two
  !! sides, with or without a gap between them.
  subroutine warn_plane(mesh, plane, on, new)
    type(mesh_t), intent(in) :: mesh
    type(plane_t), intent(in) :: plane
    logical, intent(in) :: on(:)            !! (nnode) the selected nodes
    integer, intent(in), optional :: new(:) !! (nnode) the node that replaces each node after TIE

    call warn_layers(mesh, plane, on)
    call warn_gap(mesh, plane, on, new)
    call warn_both_sides(mesh, plane, on, new)
  end subroutine warn_plane

  !> Warn about an element with two layers of nodes near a plane, one behind the other along the
  !! normal of the plane.
  subroutine warn_layers(mesh, plane, on)
    type(mesh_t), intent(in) :: mesh
    type(plane_t), intent(in) :: plane
    logical, intent(in) :: on(:) !! (nnode)
    integer, allocatable :: node(:)
    real(wp) :: x(3)
    integer :: b, e, i, j

    do b = 1, size(mesh%block)
      do e = 1, mesh%block(b)%nelem
        if (count(on(mesh%block(b)%conn(:, e))) < 2) cycle
        node = pack(mesh%block(b)%conn(:, e), on(mesh%block(b)%conn(:, e)))
        do i = 2, size(node)
          do j = 1, i - 1
            x = abs(mesh%xr(:, node(i)) - mesh%xr(:, node(j)))
            if (x(plane%direction) <= norm2(x)*BEHIND) cycle
            call warn('the plane selects all nodes up to '//to_text(plane%gap, 3)//' away, among ' &
                      //'them nodes '//to_text(node(j))//' and '//to_text(node(i))//' of the ' &
                      //'same element, one of which lies '//to_text(x(plane%direction), 3) &
                      //' behind the other', plane%place, plane%hint)
            return
          end do
        end do
      end do
    end do
  end subroutine warn_layers

  !> Warn if the default gap makes the plane select the faces of two bodies that lie opposite each
  !! other across a gap.
  subroutine warn_gap(mesh, plane, on, new)
    type(mesh_t), intent(in) :: mesh
    type(plane_t), intent(in) :: plane
    logical, intent(in) :: on(:)            !! (nnode)
    integer, intent(in), optional :: new(:) !! (nnode)
    integer, allocatable :: piece(:)
    real(wp), allocatable :: first(:), last(:), low(:), high(:) ! (npiece) extents of the selected
    ! nodes of each piece and of all its nodes
    real(wp) :: least
    integer :: i, j, n

    if (plane%gap_is_given .or. .not. any(on)) return
    associate (x => mesh%xr(plane%direction, :))
      least = max(APART*(maxval(x) - minval(x)), ROUNDED*plane%gap)
      if (maxval(x, on) - minval(x, on) <= least) return
      call find_separate(mesh, piece, new)
      allocate (first(maxval(piece)), last(maxval(piece)), low(maxval(piece)), high(maxval(piece)))
      first = huge(first)
      low = huge(low)
      last = -huge(last)
      high = -huge(high)
      do n = 1, mesh%nnode
        i = piece(n)
        if (i == 0) cycle
        low(i) = min(low(i), x(n))
        high(i) = max(high(i), x(n))
        if (.not. on(n)) cycle
        first(i) = min(first(i), x(n))
        last(i) = max(last(i), x(n))
      end do
    end associate
    do i = 1, size(low)
      if (first(i) > last(i) .or. low(i) + high(i) > 2*last(i)) cycle ! body i is below the plane
      do j = 1, size(low)
        if (j == i .or. first(j) > last(j) .or. low(j) + high(j) < 2*first(j)) cycle
        if (first(j) - last(i) <= least .and. first(i) - last(j) <= least) cycle
        call warn('the plane selects all nodes up to '//to_text(plane%gap, 3)//' away, among ' &
                  //'them those of two bodies on its two sides, at '//to_text(last(i))//' and ' &
                  //to_text(first(j)), plane%place, plane%hint)
        return
      end do
    end do
  end subroutine warn_gap

  !> Warn if bodies on the two sides of the plane touch there, and nothing joins them: the plane
  !! selects the nodes of both. Rigid bodies do not count, since planes have no effect on them.
  subroutine warn_both_sides(mesh, plane, on, new)
    type(mesh_t), intent(in) :: mesh
    type(plane_t), intent(in) :: plane
    logical, intent(in) :: on(:)            !! (nnode)
    integer, intent(in), optional :: new(:) !! (nnode)
    integer, allocatable :: piece(:), rigid(:)
    real(wp), allocatable :: first(:), last(:) ! (npiece) extents of each piece along the normal
    real(wp), allocatable :: low(:, :), high(:, :) ! (3, npiece) extents of its selected nodes
    real(wp) :: least
    integer :: i, j, n

    if (.not. any(on)) return
    associate (x => mesh%xr, d => plane%direction)
      least = APART*(maxval(x(d, :)) - minval(x(d, :)))
      if (maxval(x(d, :), on) - minval(x(d, :), on) > least) return ! see warn_gap
      if (maxval(x(d, :), mesh%used) <= maxval(x(d, :), on) + least) return ! an end of the mesh
      if (minval(x(d, :), mesh%used) >= minval(x(d, :), on) - least) return
      call find_separate(mesh, piece, new)
      if (maxval(piece) < 2) return
      call find_rigid_nodes(mesh, rigid)
      allocate (first(maxval(piece)), low(3, maxval(piece)), source=huge(least))
      allocate (last(maxval(piece)), high(3, maxval(piece)), source=-huge(least))
      do n = 1, mesh%nnode
        i = piece(n)
        if (i == 0) cycle
        first(i) = min(first(i), x(d, n))
        last(i) = max(last(i), x(d, n))
        if (.not. on(n) .or. rigid(n) > 0) cycle
        low(:, i) = min(low(:, i), x(:, n))
        high(:, i) = max(high(:, i), x(:, n))
      end do
      do i = 1, size(first)
        if (last(i) - high(d, i) > least .or. low(d, i) - first(i) <= least) cycle ! not below
        do j = 1, size(first)
          if (low(d, j) - first(j) > least .or. last(j) - high(d, j) <= least) cycle ! not above
          if (count(min(high(:, i), high(:, j)) - max(low(:, i), low(:, j)) > least) < 2) cycle
          call warn('the plane selects the nodes of two bodies, one on each side of it, which ' &
                    //'touch there and are not joined', plane%place, 'if only one of them is ' &
                    //'meant, name its face, as FIX, MOVE, PRESsure and CURVe can')
          return
        end do
      end do
    end associate
  end subroutine warn_both_sides

  !> Number the bodies that share no nodes after TIE; nodes of no element have the number 0.
  subroutine find_separate(mesh, piece, new)
    type(mesh_t), intent(in) :: mesh
    integer, allocatable, intent(out) :: piece(:)
    integer, intent(in), optional :: new(:) !! (nnode)
    integer :: i, j, n

    call find_bodies(mesh, piece)
    if (.not. present(new)) return
    do n = 1, mesh%nnode
      i = piece(n)
      j = piece(new(n))
      if (i /= j .and. min(i, j) > 0) where (piece == j) piece = i
    end do
  end subroutine find_separate

  !> Warn if a plane restrains control points of an element that extends to both sides of it, while
  !! other control points of this element are free. The plane is then not held, because its
  !! displacement depends on all of them.
  subroutine warn_inside(mesh, direction, on, free, place)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: direction       !! normal of the plane
    logical, intent(in) :: on(:)           !! (nnode) the selected nodes
    logical, intent(in) :: free(:)         !! (nnode) free in a direction that the plane restrains
    type(place_t), intent(in) :: place     !! of the plane in the deck
    real(wp) :: low, high
    integer :: b, e, n

    if (.not. any(on)) return
    associate (x => mesh%xr(direction, :))
      low = minval(x, on) - APART*(maxval(x) - minval(x))
      high = maxval(x, on) + APART*(maxval(x) - minval(x))
    end associate
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b)) .or. .not. mesh%block(b)%row%spline) cycle
      do e = 1, mesh%block(b)%nelem
        associate (node => mesh%block(b)%conn(:, e))
          n = findloc(on(node) .and. mesh%is_control(node), .true., 1)
          if (n == 0 .or. .not. any(free(node))) cycle
          if (minval(mesh%xr(direction, node)) > low) cycle
          if (maxval(mesh%xr(direction, node)) < high) cycle
          call warn('the plane restrains only control points inside a body of splines, such as ' &
                    //to_text(node(n))//', and does not hold the plane', place, 'restrain ' &
                    //'faces of patches: divide the body into two patches at the plane, and ' &
                    //'join them with TIE')
          return
        end associate
      end do
    end do
  end subroutine warn_inside

end module input_plane
