!> BALAnced: the force of a point on the other surface, and its derivatives.
!!
!! The partner's nodes c feel M_c(xi) t da, M its functions. What varies is t, da, and at a foot xi:
!! dxi_a = h_a.(dx - dx_p) + sum_b c_ab g.da_b. A bond's xi is fixed.
module contact_balance
  use base_kinds, only: wp
  use contact_foot, only: foot_t
  use contact_pair, only: surface_t
  use contact_point, only: foot_way, outer
  use contact_work, only: work_t, spread_rows
  implicit none
  private
  public :: add_back, add_cross

contains

  !> After add_own and add_partner were asked for the same traction at element e of the other side:
  !! their columns are used.
  pure subroutine add_back(other, e, t, da, work, foot, x)
    type(surface_t), intent(in) :: other
    integer, intent(in) :: e
    real(wp), intent(in) :: t(3)                 !! traction on the own side [F/L^2]
    real(wp), intent(in) :: da                   !! as of add_own
    type(work_t), intent(inout) :: work
    type(foot_t), intent(in), optional :: foot   !! where the force acts, if it moves on the surface
    real(wp), intent(in), optional :: x(3)       !! the point [L]
    integer :: b, n

    n = other%kind(other%ikind(e))%nsf
    associate (slot => work%slot)
      do b = 1, n
        work%back(:, b, slot) = work%back(:, b, slot) + work%shp(b)*da*t
      end do
      call spread_rows(n, work%nk, work%shp, work%own_q, -da, size(work%lk, 1), &
                       work%lk(:, :, slot))
      call spread_rows(n, n, work%shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
      work%foot = slot
      work%foot_shp(:n) = work%shp(:n)
    end associate
    if (present(foot)) call move_foot(n, t, da, foot, x, work)
  end subroutine add_back

  !> The force that add_back put on the foot's element varies with the sliding point, for which
  !! add_partner was asked since.
  pure subroutine add_cross(other, da, work)
    type(surface_t), intent(in) :: other
    real(wp), intent(in) :: da
    type(work_t), intent(inout) :: work
    integer :: i

    associate (slot => work%foot, n => other%kind(other%ikind(work%partner(work%foot)))%nsf, &
               m => other%kind(other%ikind(work%partner(work%slot)))%nsf)
      if (work%slot == slot) then
        call spread_rows(n, m, work%foot_shp, work%q, -da, size(work%ll, 1), work%ll(:, :, slot))
        return
      end if
      do i = 1, work%ncross
        if (all(work%pair(:, i) == [slot, work%slot])) exit
      end do
      if (i > work%ncross) then
        work%ncross = i
        work%pair(:, i) = [slot, work%slot]
        work%cross(:, :, i) = 0.0_wp
      end if
      call spread_rows(n, m, work%foot_shp, work%q, -da, size(work%cross, 1), work%cross(:, :, i))
    end associate
  end subroutine add_cross

  !> The force moves with the foot: sum_a M_c,a t dxi_a da.
  pure subroutine move_foot(n, t, da, foot, x, work)
    integer, intent(in) :: n
    real(wp), intent(in) :: t(3), da, x(3)
    type(foot_t), intent(in) :: foot
    type(work_t), intent(inout) :: work
    real(wp) :: h(3, 2), c(2, 2), g(3), q(3, 3, size(work%shp)), slope(n)
    integer :: a, b

    call foot_way(foot, x, h, c, g)
    do a = 1, 2
      slope = work%dshp(a, :n)
      do b = 1, work%nk
        q(:, :, b) = outer(t, work%own(b)*h(:, a))
      end do
      call spread_rows(n, work%nk, slope, q, -da, size(work%lk, 1), work%lk(:, :, work%slot))
      do b = 1, n
        q(:, :, b) = outer(t, (c(a, 1)*work%dshp(1, b) + c(a, 2)*work%dshp(2, b))*g &
                           - work%shp(b)*h(:, a))
      end do
      call spread_rows(n, n, slope, q, -da, size(work%ll, 1), work%ll(:, :, work%slot))
    end do
  end subroutine move_foot

end module contact_balance
