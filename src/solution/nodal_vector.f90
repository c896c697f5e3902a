!> Nodal vectors and the vectors of the free dofs.
module nodal_vector
  use base_kinds, only: wp
  implicit none
  private
  public :: free_part, full_vector

contains

  !> The free components of a nodal vector, in the order of the equations.
  pure subroutine free_part(eq, f, x)
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: f(:, :)
    real(wp), intent(out) :: x(:)
    integer :: i, n

    do n = 1, size(eq, 2)
      do i = 1, 3
        if (eq(i, n) > 0) x(eq(i, n)) = f(i, n)
      end do
    end do
  end subroutine free_part

  !> A nodal vector from its free components; zero elsewhere.
  pure subroutine full_vector(eq, x, f)
    integer, intent(in) :: eq(:, :)
    real(wp), intent(in) :: x(:)
    real(wp), intent(out) :: f(:, :)
    integer :: i, n

    f = 0.0_wp
    do n = 1, size(eq, 2)
      do i = 1, 3
        if (eq(i, n) > 0) f(i, n) = x(eq(i, n))
      end do
    end do
  end subroutine full_vector

end module nodal_vector
