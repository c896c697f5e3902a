!> Which points are bonded, and to what: the reference projection of a cohesive contact, eq. (30).
module contact_bond
  use base_kinds, only: wp
  use contact_work, only: work_t, new_work, measure
  use contact_foot, only: foot_t, shape_t
  use contact_pair, only: contact_t, contact_state_t, contact_points_t, bond_t
  use contact_project, only: project
  use contact_search, only: grid_t, update_grid
  use contact_shape, only: update_shape
  implicit none
  private
  public :: find_bonds

  real(wp), parameter :: CLOSE_BY = 1.0e-3_wp !! of an element: the default of GAP

contains

  !> Partner and reference area of every bonded point of both sides.
  subroutine find_bonds(contact, xr, state)
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: xr(:, :)       !! (3, nnode) reference positions [L]
    type(contact_state_t), intent(inout) :: state
    type(shape_t) :: shape(2)
    type(grid_t) :: grid(2)
    integer :: k

    if (.not. contact%has_cohesive) return
    do k = 1, 2
      call update_shape(contact%side(k), xr, shape(k))
      call update_grid(contact%side(k), shape(k), grid(k))
    end do
    do k = 1, 2
      if (contact%side(k)%rigid) cycle
      call bond_side(contact, k, xr, shape(3 - k), grid(3 - k), state%side(k))
    end do
  end subroutine find_bonds

  subroutine bond_side(contact, k, xr, shape, grid, points)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), intent(in) :: xr(:, :)
    type(shape_t), intent(in) :: shape     !! of the other side
    type(grid_t), intent(in) :: grid
    type(contact_points_t), intent(inout) :: points
    type(work_t) :: work
    type(foot_t) :: foot
    real(wp) :: x(3, contact%nq), up(3, 2), near
    integer :: e, i, q

    call new_work(contact, k, work)
    do e = 1, contact%side(k)%nelem
      i = (e - 1)*contact%nq
      do q = 1, contact%nq
        call measure(contact%side(k), e, q, xr, work, x(:, q), up, points%area0(i + q))
        points%area0(i + q) = points%area0(i + q)*contact%wgt(q)
      end do
      near = contact%bond_gap
      if (near < 0.0_wp) near = CLOSE_BY*sqrt(sum(points%area0(i + 1:i + contact%nq)))
      do q = 1, contact%nq
        if (.not. is_inside(contact%bond, x(:, q))) cycle
        foot%elem = 0
        call project(contact%side(3 - k), shape, grid, x(:, q), foot, near)
        if (foot%elem == 0 .or. abs(foot%gap) > near) cycle
        points%bond(i + q) = foot%elem
        points%bond_xi(:, i + q) = foot%xi
      end do
    end do
  end subroutine bond_side

  !> A reference point lies in all regions, and in none of the excepted ones.
  pure logical function is_inside(bond, x)
    type(bond_t), intent(in) :: bond(:)
    real(wp), intent(in) :: x(3)
    integer :: i
    logical :: in

    is_inside = .true.
    do i = 1, size(bond)
      if (bond(i)%is_box) then
        in = all(x >= bond(i)%a .and. x <= bond(i)%b)
      else
        in = dot_product(x - bond(i)%a, bond(i)%b) >= 0.0_wp
      end if
      is_inside = is_inside .and. (in .neqv. bond(i)%is_except)
    end do
  end function is_inside

end module contact_bond
