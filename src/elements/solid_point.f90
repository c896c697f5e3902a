!> Kinematics at a point of a solid: the map, the displacement gradient and the enhancement.
module solid_point
  use base_kinds, only: wp
  use tensor, only: inv3
  implicit none
  private
  public :: deform, centre_map, invert_map

contains

  !> Compute the displacement gradient at a point of the parent cell.
  !!
  !! H = F - 1 = sum_a u_a x G_a + sum_i a_i x M_i,  G_a = J^-T dN_a,  M_i = (j0/j) J0^-T m_i
  !! (Simo and Armero 1992). Their factor F0, the deformation gradient at the centre, is left out:
  !! multiplying the modes by it from the left does not change the space that they span.
  pure subroutine deform(nen, nmode, dshp, mode, xu, a, centre, jac0, h, inverse, jac, m, ok)
    integer, intent(in) :: nen, nmode
    real(wp), intent(in) :: dshp(3, nen)   !! parent derivatives of the functions
    real(wp), intent(in) :: mode(3, nmode) !! parent covectors of the modes
    real(wp), intent(in) :: xu(6, nen)     !! reference positions, followed by displacements [L]
    real(wp), intent(in) :: a(3, nmode)    !! enhanced parameters [L]
    real(wp), intent(in) :: centre(3, 3)   !! J0^-1 [1/L]
    real(wp), intent(in) :: jac0           !! j0 [L^3]
    real(wp), intent(out) :: h(3, 3)       !! displacement gradient [-]
    real(wp), intent(out) :: inverse(3, 3) !! J^-1 = d xi / d X [1/L]
    real(wp), intent(out) :: jac           !! j = det J [L^3]
    real(wp), intent(out) :: m(3, nmode)   !! material covectors of the modes [1/L]
    logical, intent(out) :: ok             !! .false.: the reference map is inverted here

    real(wp) :: map(6, 3)
    integer :: i, j, n

    map = 0.0_wp
    do n = 1, nen
      do j = 1, 3
        !$omp simd
        do i = 1, 6
          map(i, j) = map(i, j) + xu(i, n)*dshp(j, n)
        end do
      end do
    end do
    h = 0.0_wp
    m = 0.0_wp
    call invert_map(map(:3, :), inverse, jac, ok)
    if (.not. ok) return
    do j = 1, 3
      h(:, j) = map(4:, 1)*inverse(1, j) + map(4:, 2)*inverse(2, j) + map(4:, 3)*inverse(3, j)
    end do
    do n = 1, nmode
      do j = 1, 3
        m(j, n) = (jac0/jac)*(centre(1, j)*mode(1, n) + centre(2, j)*mode(2, n) &
                              + centre(3, j)*mode(3, n))
        h(:, j) = h(:, j) + a(:, n)*m(j, n)
      end do
    end do
  end subroutine deform

  !> Compute the inverse and the determinant of J0, the derivative of the reference position with
  !! respect to the parent coordinates at the centre.
  pure subroutine centre_map(nen, dshp0, xr, inverse, jac, ok)
    integer, intent(in) :: nen
    real(wp), intent(in) :: dshp0(3, nen)  !! parent derivatives at the centre
    real(wp), intent(in) :: xr(3, nen)
    real(wp), intent(out) :: inverse(3, 3) !! J0^-1 [1/L]
    real(wp), intent(out) :: jac           !! j0 [L^3]
    logical, intent(out) :: ok

    call invert_map(matmul(xr, transpose(dshp0)), inverse, jac, ok)
  end subroutine centre_map

  !> Invert a map; ok only if its determinant is positive and finite.
  pure subroutine invert_map(a, inverse, det, ok)
    real(wp), intent(in) :: a(3, 3)
    real(wp), intent(out) :: inverse(3, 3), det
    logical, intent(out) :: ok

    call inv3(a, inverse, det)
    ok = det > 0.0_wp .and. det <= huge(det)
  end subroutine invert_map

end module solid_point
