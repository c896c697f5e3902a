!> Nodal forces that do not depend on the motion, at the factors of now.
module dead_load
  use base_kinds, only: wp
  use boundary, only: boundary_t
  use load_curve, only: load_factor
  implicit none
  private
  public :: dead_forces

contains

  !> Forces of FORC and its kin, and what was integrated once: body forces, dead pressures.
  subroutine dead_forces(bc, factor, f)
    type(boundary_t), intent(in) :: bc
    real(wp), intent(in) :: factor(:)  !! (ntable)
    real(wp), intent(out) :: f(:, :)   !! (3, nnode) [F]
    integer :: i, j, n

    f = 0.0_wp
    do n = 1, size(f, 2)
      do i = 1, 3
        if (abs(bc%force(i, n)) > 0.0_wp) then
          f(i, n) = f(i, n) + bc%force(i, n)*load_factor(factor, bc%table(i, n))
        end if
      end do
    end do
    do j = 1, size(bc%dead)
      associate (load => bc%dead(j))
        do n = 1, size(load%node)
          f(:, load%node(n)) = f(:, load%node(n)) + load_factor(factor, load%table)*load%f(:, n)
        end do
      end associate
    end do
  end subroutine dead_forces

end module dead_load
