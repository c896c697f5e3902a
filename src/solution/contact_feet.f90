!> Feet of a side's points on the other one, of those that act and, when a step ends, of the others.
module contact_feet
  use base_kinds, only: wp
  use contact_cut, only: acting, begin_cuts, is_cut, silence
  use contact_element, only: form_element
  use contact_foot, only: foot_t, shape_t
  use contact_pair, only: contact_t, contact_points_t
  use contact_project, only: project
  use contact_search, only: grid_t
  use contact_slide, only: side_positions
  use contact_work, only: work_t
  implicit none
  private
  public :: find_feet, follow_silent

contains

  !> Project the points of side k that act; elements that have come to be cut are told by the way.
  subroutine find_feet(contact, k, shape, grid, x, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape             !! of the other side
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)         !! (np)
    type(contact_points_t), intent(inout) :: points
    integer :: act(2), e, i

    if (points%fresh) call begin_cuts(contact, points)
    do e = 1, contact%side(k)%nelem
      act = acting(contact, points, e)
      call project_points(contact, k, shape, grid, x, e, act, feet, points)
      if (contact%nq == contact%nplain) cycle
      i = (e - 1)*contact%nq
      if (.not. points%cut(e)) then
        points%cut(e) = is_cut(contact, feet(i + 1:i + contact%nplain))
        act = acting(contact, points, e)
        if (points%cut(e)) call project_points(contact, k, shape, grid, x, e, act, feet, points)
      end if
      act = silent(contact, points, e)
      call silence(points, i + act(1), i + act(2))
    end do
  end subroutine find_feet

  !> First and last of the points of element e that do not act.
  pure function silent(contact, points, e) result(q)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: e
    integer :: q(2)

    q = [contact%nplain + 1, contact%nq]
    if (points%cut(e)) q = [1, contact%nplain]
  end function silent

  !> Points act(1) to act(2) of element e.
  subroutine project_points(contact, k, shape, grid, x, e, act, feet, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e, act(2)
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    real(wp) :: xp(3, act(2) - act(1) + 1)
    integer :: i, q

    call side_positions(contact%side(k), e, x, xp, from=act(1) - 1)
    do q = act(1), act(2)
      i = (e - 1)*contact%nq + q
      associate (foot => feet(i))
        foot%elem = points%foot(i)
        foot%xi = points%foot_xi(:, i)
        call project(contact%side(3 - k), shape, grid, xp(:, q - act(1) + 1), foot, contact%depth)
        points%foot(i) = foot%elem
        points%foot_xi(:, i) = foot%xi
      end associate
    end do
  end subroutine project_points

  !> A step ends: the points that did not act get the feet and states they would have, so that they
  !! know where they stand when they do.
  subroutine follow_silent(contact, k, shape, grid, x, slides, feet, points, part)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(shape_t), intent(in) :: shape
    type(grid_t), intent(in) :: grid
    real(wp), intent(in) :: x(:, :)
    logical, intent(in) :: slides                  !! friction acts
    type(foot_t), intent(inout) :: feet(:)
    type(contact_points_t), intent(inout) :: points
    type(work_t), intent(inout) :: part
    integer :: act(2), e, i

    if (contact%nq == contact%nplain) return
    do e = 1, contact%side(k)%nelem
      points%cut(e) = .not. points%cut(e)
      act = acting(contact, points, e)
      i = (e - 1)*contact%nq
      call project_points(contact, k, shape, grid, x, e, act, feet, points)
      call form_element(contact, k, e, x, feet(i + 1:i + contact%nq), slides, points, part)
      call silence(points, i + act(1), i + act(2))
      points%cut(e) = .not. points%cut(e)
    end do
  end subroutine follow_silent

end module contact_feet
