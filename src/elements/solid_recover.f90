!> Results of a solid element at points: positions, deformation, stress, energy.
module solid_recover
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use material_type, only: material_t
  use solid_point, only: deform, centre_map
  use tensor, only: det3
  implicit none
  private
  public :: recovered_t, recover, von_mises

  !> Results at one point of an element.
  type :: recovered_t
    real(wp) :: xr(3) = 0.0_wp    !! reference position [L]
    real(wp) :: xc(3) = 0.0_wp    !! current position [L]
    real(wp) :: dg(3, 3) = 0.0_wp !! deformation gradient including enhanced modes [-]
    real(wp) :: sig(6) = 0.0_wp   !! Cauchy stress, Voigt order 11 22 33 12 23 31 [F/L^2]
    real(wp) :: mises = 0.0_wp    !! von Mises stress [F/L^2]
    real(wp) :: energy = 0.0_wp   !! stored energy per reference volume [F/L^2]
    real(wp) :: volume = 0.0_wp   !! weight times det J: reference volume of the point [L^3]
  end type recovered_t

contains

  !> Compute the state at the points of `basis`: the integration points, or any other points. The
  !! energy of an element is sum(point%energy*point%volume) over its integration points.
  pure subroutine recover(basis, material, prop, xr, u, param, point, ok)
    type(basis_t), intent(in) :: basis
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: xr(:, :)  !! (3, nen)
    real(wp), intent(in) :: u(:, :)   !! (3, nen)
    real(wp), intent(in) :: param(:)  !! (3*nmode or more) history, which begins with the parameters
    type(recovered_t), intent(out) :: point(:) !! (nq)
    logical, intent(out) :: ok        !! .false.: the map is inverted at a point; its stress is 0

    real(wp) :: a(3, basis%nmode), m(3, basis%nmode), centre(3, 3), inverse(3, 3), jac0, jac
    real(wp) :: xu(6, basis%nen), h(3, 3)
    integer :: i, q
    logical :: fine

    a = reshape(param(:3*basis%nmode), [3, basis%nmode])
    xu(:3, :) = xr
    xu(4:, :) = u
    ok = .true.
    centre = 0.0_wp
    jac0 = 0.0_wp
    if (basis%nmode > 0) call centre_map(basis%nen, basis%dshp0, xr, centre, jac0, ok)
    do q = 1, basis%nq
      point(q)%xr = matmul(xr, basis%shp(:, q))
      point(q)%xc = point(q)%xr + matmul(u, basis%shp(:, q))
      call deform(basis%nen, basis%nmode, basis%dshp(:, :, q), basis%mode(:, :, q), xu, a, &
                  centre, jac0, h, inverse, jac, m, fine)
      point(q)%dg = h
      do i = 1, 3
        point(q)%dg(i, i) = h(i, i) + 1.0_wp
      end do
      if (fine) then
        point(q)%volume = basis%wgt(q)*jac
        call add_stress(material, prop, h, point(q), fine)
      end if
      ok = ok .and. fine
    end do
  end subroutine recover

  !> Add stress and energy to a point whose deformation gradient is known.
  pure subroutine add_stress(material, prop, h, point, ok)
    type(material_t), intent(in) :: material
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)   !! displacement gradient
    type(recovered_t), intent(inout) :: point
    logical, intent(out) :: ok

    real(wp) :: tau(6), c(6, 6)

    call material%stress(prop, h, tau, c, ok)
    if (.not. ok) return
    if (material%finite) tau = tau/det3(point%dg)
    point%sig = tau
    point%mises = von_mises(tau)
    point%energy = material%energy(prop, h)
  end subroutine add_stress

  !> Von Mises stress.
  pure function von_mises(sig) result(mises)
    real(wp), intent(in) :: sig(6)
    real(wp) :: mises

    mises = sqrt(0.5_wp*((sig(1) - sig(2))**2 + (sig(2) - sig(3))**2 + (sig(3) - sig(1))**2) &
                 + 3.0_wp*(sig(4)**2 + sig(5)**2 + sig(6)**2))
  end function von_mises

end module solid_recover
