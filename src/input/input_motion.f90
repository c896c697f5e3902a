!> Nodes that several MOVEs name, such as those on the common edge of two faces.
!!
!! The MOVEs of one place (WHERE) add up: a face may be pressed by one record and dragged by
!! another. If several places share a node, such as a node of a tied edge, and give it the same
!! motion, this motion is applied there only once. If they give the node different motions in one
!! direction, these add up, and a warning is issued. If two places have the same nodes, such as two
!! faces of a rigid body, a displacement of 0 in a direction is no different motion.
!!
!! MOVE takes precedence over FIX where both act on a node in the same direction. This is noted if
!! both records name the same nodes, and there is a warning if they share only some nodes.
module input_motion
  use base_kinds, only: wp
  use base_log, only: note, warn
  use base_text, only: lower, to_text
  use boundary, only: boundary_t, motion_t
  use input_draft, only: draft_t
  use input_where, only: where_t, W_GROUP
  use tensor, only: cross
  implicit none
  private
  public :: count_motions_once, report_moved_supports

  !> If a component of a unit axis is this near to 1, the other components are rounding errors.
  real(wp), parameter :: ALONG = 1.0e-12_wp

  !> The data used to compare MOVEs.
  type :: identity_t
    integer :: place = 0  !! the first MOVE of the same place
    integer :: motion = 0 !! the first MOVE with the same motion
    integer :: turn = 0   !! number of MOVEs, up to this one, with the same place and motion
  end type identity_t

contains

  !> Remove from each motion the nodes to which another place has given the same motion.
  subroutine count_motions_once(draft, nnode, bc)
    type(draft_t), intent(in) :: draft
    integer, intent(in) :: nnode
    type(boundary_t), intent(inout) :: bc
    type(identity_t), allocatable :: id(:)
    logical, allocatable :: on(:), left(:)
    integer :: i, j

    if (size(bc%motion) < 2) return
    call identify(draft, bc, id)
    call warn_repeated(id, bc%motion)
    call warn_different(id, nnode, bc)
    allocate (on(nnode), source=.false.)
    do i = size(id), 2, -1 ! earlier motions still have all of their nodes
      do j = 1, i - 1
        if (id(i)%place == id(j)%place .or. id(i)%motion /= id(j)%motion) cycle
        if (id(i)%turn /= id(j)%turn) cycle
        on(bc%motion(j)%node) = .true.
        left = .not. on(bc%motion(i)%node)
        on(bc%motion(j)%node) = .false.
        bc%motion(i)%node = pack(bc%motion(i)%node, left)
      end do
    end do
  end subroutine count_motions_once

  !> Warn about each MOVE that is equal to an earlier one, unless it moves nothing.
  subroutine warn_repeated(id, motion)
    type(identity_t), intent(in) :: id(:)
    type(motion_t), intent(in) :: motion(:)
    integer :: i, j

    do i = 2, size(id)
      if (id(i)%turn < 2) cycle
      if (motion(i)%rotates .and. .not. abs(motion(i)%angle) > 0.0_wp) cycle
      if (.not. (motion(i)%rotates .or. any(abs(motion(i)%vector) > 0.0_wp))) cycle
      j = findloc(id%place == id(i)%place .and. id%motion == id(i)%motion, .true., 1)
      call warn('the same MOVE is already given in line '//to_text(motion(j)%place%line) &
                //', and both motions add up', motion(i)%place, 'remove one of them, or give the ' &
                //'sum in one record')
    end do
  end subroutine warn_repeated

  subroutine identify(draft, bc, id)
    type(draft_t), intent(in) :: draft
    type(boundary_t), intent(in) :: bc
    type(identity_t), allocatable, intent(out) :: id(:)
    integer :: i, j

    allocate (id(size(bc%motion)))
    do i = 1, size(id)
      do j = 1, i
        if (same_place(draft%motion(i)%at, draft%motion(j)%at)) exit
      end do
      id(i)%place = j
      do j = 1, i
        if (same_motion(bc%motion(i), bc%motion(j))) exit
      end do
      id(i)%motion = j
      id(i)%turn = count(id(:i)%place == id(i)%place .and. id(:i)%motion == id(i)%motion)
    end do
  end subroutine identify

  !> Warn about nodes that belong to two places with different motions in a common direction. If
  !! both places have the same nodes, a direction in which a motion only holds them does not count.
  subroutine warn_different(id, nnode, bc)
    type(identity_t), intent(in) :: id(:)
    integer, intent(in) :: nnode
    type(boundary_t), intent(in) :: bc
    logical, allocatable :: on(:)
    character(:), allocatable :: hint
    logical :: same
    integer :: i, j, n

    allocate (on(nnode), source=.false.)
    do i = 2, size(id)
      if (id(i)%place /= i) cycle ! this place has been compared already
      on(bc%motion(i)%node) = .true.
      do j = 1, i - 1
        if (id(j)%place /= j) cycle
        n = count(on(bc%motion(j)%node))
        if (n == 0) cycle
        same = n == max(size(bc%motion(i)%node), size(bc%motion(j)%node))
        if (.not. (lacks(id, bc%motion, same, i, j) .or. lacks(id, bc%motion, same, j, i))) cycle
        hint = 'leave directions free with *, or move the common nodes with one MOVE only'
        if (same) hint = 'remove one of them, or name the same place in both if the sum is meant'
        call warn('this MOVE and the one in line '//to_text(bc%motion(j)%place%line)//' give ' &
                  //'different motions to their common nodes (number: '//to_text(n) &
                  //'); the motions add up there', bc%motion(i)%place, hint)
      end do
      on(bc%motion(i)%node) = .false.
    end do
  end subroutine warn_different

  !> Does place i have a motion that place j lacks, in a direction in which place j moves too?
  pure logical function lacks(id, motion, moving, i, j)
    type(identity_t), intent(in) :: id(:)
    type(motion_t), intent(in) :: motion(:)
    logical, intent(in) :: moving !! skip directions with a displacement of 0
    integer, intent(in) :: i, j
    logical :: acts(3)
    integer :: m

    acts = .false.
    do m = 1, size(id)
      if (id(m)%place == j) acts = acts .or. directions(motion(m), moving)
    end do
    lacks = .false.
    do m = 1, size(id)
      if (id(m)%place /= i) cycle
      if (.not. any(acts .and. directions(motion(m), moving))) cycle
      if (any(id%place == j .and. id%motion == id(m)%motion .and. id%turn == id(m)%turn)) cycle
      lacks = .true.
    end do
  end function lacks

  !> Warn about each FIX whose restraints have no effect at some nodes, because MOVE moves them. If
  !! a MOVE and a FIX name exactly the same nodes, a note replaces the warning. Also warn about each
  !! MOVE that moves nodes of which BOUN, EBOU and CBOU restrain only some.
  subroutine report_moved_supports(draft, xr, restrained, bc)
    type(draft_t), intent(in) :: draft
    real(wp), intent(in) :: xr(:, :) !! (3, nnode) [L]
    logical, intent(in) :: restrained(:, :) !! (3, nnode) by BOUN, EBOU and CBOU
    type(boundary_t), intent(in) :: bc
    logical, allocatable :: on(:)
    character(:), allocatable :: hint, text
    integer :: d, i, j, m, n

    if (size(bc%motion) == 0) return
    allocate (on(size(xr, 2)), source=.false.)
    do i = 1, draft%nsupport
      associate (support => draft%support(i))
        on(support%node) = .true.
        search: do m = 1, size(bc%motion)
          associate (motion => bc%motion(m))
            do d = 1, 3
              if (support%code(d) == 0) cycle
              n = count([(on(motion%node(j)) .and. moves(motion, xr(:, motion%node(j)), d), &
                          j=1, size(motion%node))])
              if (n == 0) cycle
              text = 'MOVE in line '//to_text(motion%place%line)//' prescribes displacements ' &
                     //'in direction '//to_text(d)//' at '
              if (size(motion%node) == size(support%node) .and. all(on(motion%node))) then
                call note(text//'all nodes that FIX in line '//to_text(support%at%place%line) &
                          //' restrains: MOVE takes precedence')
                cycle
              end if
              hint = 'leave the direction free, in FIX with 0 or in MOVE with *'
              if (motion%rotates) hint = 'leave the direction free in FIX with 0'
              call warn(text//'nodes that this FIX restrains (number: '//to_text(n) &
                        //'): MOVE takes precedence there', support%at%place, hint)
              exit search
            end do
          end associate
        end do search
        on(support%node) = .false.
      end associate
    end do
    do m = 1, size(bc%motion)
      call warn_restrained(bc%motion(m), xr, restrained)
    end do
  end subroutine report_moved_supports

  !> Warn if BOUN, EBOU and CBOU restrain some of the nodes that a motion moves in one direction. If
  !! they restrain all of them, MOVE gives these supports their motion.
  subroutine warn_restrained(motion, xr, restrained)
    type(motion_t), intent(in) :: motion
    real(wp), intent(in) :: xr(:, :) !! (3, nnode) [L]
    logical, intent(in) :: restrained(:, :) !! (3, nnode)
    logical, allocatable :: moved(:)
    integer :: d, j, n

    do d = 1, 3
      moved = [(moves(motion, xr(:, motion%node(j)), d), j=1, size(motion%node))]
      n = count(moved .and. restrained(d, motion%node))
      if (n == 0 .or. n == count(moved)) cycle
      call warn('this MOVE prescribes displacements in direction '//to_text(d)//' at nodes that ' &
                //'BOUNdary, EBOUndary or CBOUndary restrains (number: '//to_text(n)//' of ' &
                //to_text(count(moved))//'): MOVE takes precedence there', motion%place, &
                'leave the direction free, in MOVE with * or in the other record with 0')
      return
    end do
  end subroutine warn_restrained

  !> Does a motion move a node in direction d?
  pure logical function moves(motion, x, d)
    type(motion_t), intent(in) :: motion
    real(wp), intent(in) :: x(3)     !! position of the node [L]
    integer, intent(in) :: d
    real(wp) :: across(3), back(3)

    if (motion%rotates) then
      across = cross(motion%axis, x - motion%vector)
      back = cross(motion%axis, across)
      moves = max(abs(across(d)), abs(back(d))) > ALONG*norm2(x - motion%vector) &
              .and. abs(motion%angle) > 0.0_wp
    else
      moves = motion%acts(d) .and. abs(motion%vector(d)) > 0.0_wp
    end if
  end function moves

  !> Directions in which a motion moves points: a rotation moves no point along its axis.
  pure function directions(motion, moving) result(acts)
    type(motion_t), intent(in) :: motion
    logical, intent(in) :: moving !! without those in which it only holds the points
    logical :: acts(3)

    acts = motion%acts
    if (motion%rotates) then
      acts = abs(motion%axis) < 1.0_wp - ALONG
      if (moving) acts = acts .and. abs(motion%angle) > 0.0_wp
    else if (moving) then
      acts = acts .and. abs(motion%vector) > 0.0_wp
    end if
  end function directions

  !> Do two MOVEs name the same place?
  pure logical function same_place(a, b) result(same)
    type(where_t), intent(in) :: a, b

    same = a%type == b%type .and. a%mask == b%mask .and. a%node == b%node .and. &
           a%direction == b%direction .and. all(abs(a%x - b%x) <= 0.0_wp) .and. &
           lower(a%body) == lower(b%body)
    if (same .and. a%type == W_GROUP) same = lower(a%face) == lower(b%face)
  end function same_place

  pure logical function same_motion(a, b) result(same)
    type(motion_t), intent(in) :: a, b

    same = (a%rotates .eqv. b%rotates) .and. all(a%acts .eqv. b%acts) .and. a%table == b%table &
           .and. all(abs(a%vector - b%vector) <= 0.0_wp) &
           .and. all(abs(a%axis - b%axis) <= 0.0_wp) .and. abs(a%angle - b%angle) <= 0.0_wp
  end function same_motion

end module input_motion
