!> Subcell quadrature (REFIne of QUADrature): finer integration of elements that are partly in
!! contact.
!!
!! The points of an element are those of the plain rule, which is QUADrature without REFIne,
!! followed by the points of m x m cells, with the plain rule in each cell. One of the two sets is
!! active. The cells are active if some points of the plain rule are in contact and others are not,
!! at the start of the step or at a later iteration. An element is refined at most once in a step,
!! and coarsened only between steps, so that Newton's iteration cannot switch back and forth. Both
!! sets have histories; when a step is accepted, those of the inactive points are updated too.
module subcell_quadrature
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t
  use contact_type, only: OPEN
  use projection_type, only: foot_t, touches
  implicit none
  private
  public :: acting, begin_refinement, is_refined, silence

contains

  !> First and last active point of element e.
  pure function acting(contact, points, e) result(q)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(in) :: points
    integer, intent(in) :: e
    integer :: q(2)

    q = [1, contact%nplain]
    if (points%refined(e)) q = [contact%nplain + 1, contact%nq]
  end function acting

  !> At the start of a step, decide which elements are refined, from the states of the points at the
  !! end of the previous step.
  pure subroutine begin_refinement(contact, points)
    type(contact_t), intent(in) :: contact
    type(contact_points_t), intent(inout) :: points
    integer :: e, i

    if (contact%nplain == contact%nq) return
    do e = 1, size(points%refined)
      i = (e - 1)*contact%nq
      associate (state => points%state_step(i + 1:i + contact%nplain))
        points%refined(e) = any(state == OPEN) .and. any(state /= OPEN)
      end associate
    end do
  end subroutine begin_refinement

  !> Does the edge of the contact area run through the element? The answer follows from the
  !! projections of the points of the plain rule.
  pure logical function is_refined(contact, feet)
    type(contact_t), intent(in) :: contact
    type(foot_t), intent(in) :: feet(:)    !! (nplain or more)
    integer :: n, q

    is_refined = .false.
    if (contact%nplain == contact%nq) return
    n = 0
    do q = 1, contact%nplain
      if (touches(feet(q), contact%depth) .and. feet(q)%gap < 0.0_wp) n = n + 1
    end do
    is_refined = n > 0 .and. n < contact%nplain
  end function is_refined

  !> Set traction, area and energy of points i to j to zero; their states and elastic displacements
  !! are not changed.
  pure subroutine silence(points, i, j)
    type(contact_points_t), intent(inout) :: points
    integer, intent(in) :: i, j

    points%area(i:j) = 0.0_wp
    points%traction(:, i:j) = 0.0_wp
    points%friction(:, i:j) = 0.0_wp
    points%normal(:, i:j) = 0.0_wp
    points%pressed(i:j) = 0.0_wp
  end subroutine silence

end module subcell_quadrature
