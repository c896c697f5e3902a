!> Sums over the integration points of one side: resultants, area, points in contact.
module contact_resultant
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t
  use contact_slide, only: side_positions
  use contact_type, only: OPEN, STICK, SLIP
  use tensor, only: cross
  implicit none
  private
  public :: resultant_t, find_resultant

  type :: resultant_t
    real(wp) :: force(3) = 0.0_wp        !! int t da on this side [F]
    real(wp) :: moment(3) = 0.0_wp       !! int (x - about) x t da, current positions [F L]
    real(wp) :: force_size = 0.0_wp      !! int |t| da [F]
    real(wp) :: moment_size = 0.0_wp     !! int |(x - about) x t| da [F L]
    real(wp) :: area = 0.0_wp            !! in contact, current [L^2]
    real(wp) :: penetration = 0.0_wp     !! largest -gap of the points in contact [L]
    integer :: npoint = 0, nclosed = 0   !! points, and those in contact
    integer :: nstick = 0, nslip = 0
  end type resultant_t

contains

  !> A rigid side has no points: zero.
  subroutine find_resultant(contact, k, points, x, about, total)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k                       !! side
    type(contact_points_t), intent(in) :: points   !! of that side
    real(wp), intent(in) :: x(:, :)                !! (3, nnode) current positions [L]
    real(wp), intent(in) :: about(3)               !! point of the moments [L]
    type(resultant_t), intent(out) :: total
    real(wp) :: xp(3, contact%nq), df(3), dm(3)
    integer :: e, i, q

    total%npoint = count(points%area > 0.0_wp)
    total%nclosed = count(points%state /= OPEN .and. points%area > 0.0_wp)
    total%nstick = count(points%state == STICK .and. points%area > 0.0_wp)
    total%nslip = count(points%state == SLIP .and. points%area > 0.0_wp)
    if (contact%side(k)%rigid) return
    do e = 1, contact%side(k)%nelem
      i = (e - 1)*contact%nq
      if (all(points%state(i + 1:i + contact%nq) == OPEN .and. &
              points%bond(i + 1:i + contact%nq) == 0)) cycle
      call side_positions(contact%side(k), e, x, xp)
      do q = 1, contact%nq
        i = (e - 1)*contact%nq + q
        if (points%state(i) == OPEN .and. points%bond(i) == 0) cycle
        df = points%traction(:, i)*points%area(i)
        dm = cross(xp(:, q) - about, df)
        total%force = total%force + df
        total%moment = total%moment + dm
        total%force_size = total%force_size + norm2(df)
        total%moment_size = total%moment_size + norm2(dm)
        if (points%state(i) == OPEN .or. .not. points%area(i) > 0.0_wp) cycle
        total%area = total%area + points%area(i)
        total%penetration = max(total%penetration, -points%gap(i))
      end do
    end do
  end subroutine find_resultant

end module contact_resultant
