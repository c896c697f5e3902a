!> Where a body is put: the ROTAte, TRANslate and SCALe records of a patch or mesh as one map.
module patch_placement
  use base_kinds, only: wp
  use patch_spec, only: placement_t
  implicit none
  private
  public :: compose, rotation

contains

  !> All placements, in order: x -> turn x + shift.
  subroutine compose(placement, turn, shift)
    type(placement_t), intent(in) :: placement(:)
    real(wp), intent(out) :: turn(3, 3), shift(3) !! [-], [L]
    real(wp) :: r(3, 3)
    integer :: i

    turn = 0.0_wp
    shift = 0.0_wp
    do i = 1, 3
      turn(i, i) = 1.0_wp
    end do
    do i = 1, size(placement)
      associate (p => placement(i))
        if (p%rotates) then
          r = rotation(p%axis, p%angle)
          turn = matmul(r, turn)
          shift = matmul(r, shift - p%point) + p%point
        else if (p%scale > 0.0_wp) then
          turn = p%scale*turn
          shift = p%scale*shift
        else
          shift = shift + p%point
        end if
      end associate
    end do
  end subroutine compose

  !> Rotation about a unit axis (Rodrigues); right angles are exact.
  pure function rotation(axis, angle) result(r)
    real(wp), intent(in) :: axis(3), angle
    real(wp) :: r(3, 3), c, s
    integer :: i, j

    c = clean(cos(angle))
    s = clean(sin(angle))
    do j = 1, 3
      do i = 1, 3
        r(i, j) = (1.0_wp - c)*axis(i)*axis(j)
      end do
      r(j, j) = r(j, j) + c
    end do
    r(2, 1) = r(2, 1) + s*axis(3)
    r(1, 2) = r(1, 2) - s*axis(3)
    r(3, 2) = r(3, 2) + s*axis(1)
    r(2, 3) = r(2, 3) - s*axis(1)
    r(1, 3) = r(1, 3) + s*axis(2)
    r(3, 1) = r(3, 1) - s*axis(2)
  end function rotation

  pure elemental real(wp) function clean(c)
    real(wp), intent(in) :: c

    clean = c
    if (abs(c) < 8*epsilon(c)) clean = 0.0_wp
    if (1.0_wp - abs(c) < 4*epsilon(c)) clean = sign(1.0_wp, c)
  end function clean

end module patch_placement
