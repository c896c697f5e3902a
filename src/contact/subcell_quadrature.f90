!> Finer integration of elements that are cut by the border of the contact (QUADrature, REFIne).
!!
!! The points of an element are those of the plain rule and, behind them, those of m x m cells with
!! the plain rule each. One of both acts: the cells where a step begins, or comes to, an element
!! with plain points in and out of contact. An element comes to its cells once a step at most and
!! goes back between steps only, so that Newton's iteration cannot switch to and fro. Both have
!! histories: when a step is accepted the points that did not act follow.
module subcell_quadrature
  use base_kinds, only: wp
  use projection_type, only: foot_t, touches
  use contact_pair, only: contact_t, contact_points_t
  use contact_type, only: OPEN
  implicit none
  private
  public :: acting, begin_cuts, is_cut, silence

contains

  !> First and last of the points of element e that act.
  pure function acting(contact, points, e) result(q)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: e
    integer :: q(2)

    q = [1, contact%nplain]
    if (points%cut(e)) q = [contact%nplain + 1, contact%nq]
  end function acting

  !> A step begins: which elements are cut, by the states at the end of the last one.
  pure subroutine begin_cuts(contact, points)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(inout) :: points
    integer :: e, i

    if (contact%nplain == contact%nq) return
    do e = 1, size(points%cut)
      i = (e - 1)*contact%nq
      associate (state => points%state_step(i + 1:i + contact%nplain))
        points%cut(e) = any(state == OPEN) .and. any(state /= OPEN)
      end associate
    end do
  end subroutine begin_cuts

  !> The feet of the plain points say that the border of the contact runs through the element.
  pure logical function is_cut(contact, feet)
    type(contact_t), intent(in) :: contact
    type(foot_t), intent(in) :: feet(:)    !! (nplain or more)
    integer :: n, q

    is_cut = .false.
    if (contact%nplain == contact%nq) return
    n = 0
    do q = 1, contact%nplain
      if (touches(feet(q), contact%depth) .and. feet(q)%gap < 0.0_wp) n = n + 1
    end do
    is_cut = n > 0 .and. n < contact%nplain
  end function is_cut

  !> Points i to j bear nothing and stand for no area; their states and ways stay.
  pure subroutine silence(points, i, j)
    type(contact_points_t), intent(inout) :: points
    integer, intent(in) :: i, j

    points%area(i:j) = 0.0_wp
    points%traction(:, i:j) = 0.0_wp
    points%friction(:, i:j) = 0.0_wp
    points%cohesion(:, i:j) = 0.0_wp
  end subroutine silence

end module subcell_quadrature
