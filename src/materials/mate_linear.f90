!> Linear isotropic elasticity at small strains.
!!
!!   sigma = Lam tr(eps) 1 + 2 mu eps,   eps = sym H,   H = F - 1
!!
!! Deck:    SOLId / ELAStic ISOTropic E nu / SMALl
!! History: none
!! Source:  Hooke's law
!! Limits:  small strains and rotations
module mate_linear
  use base_kinds, only: wp
  use elastic_constants, only: set_constants, young_modulus, MU, LAMBDA
  use material_type, only: material_t, NB
  use tensor, only: isotropic
  implicit none
  private
  public :: describe

contains

  !> Row of this law in the table of laws.
  function describe() result(row)
    type(material_t) :: row

    row%name = 'ISOTropic'
    row%numbers = 'E nu'
    row%nvalue = 2
    row%source = 'linear isotropic, small strain: sigma = Lam tr(eps) 1 + 2 mu eps'
    row%finite = .false.
    row%nprop = LAMBDA
    row%example(:2) = [2.0_wp, 0.3_wp]
    row%set => set_constants
    row%stiffness => young_modulus
    row%stress => stress
    row%moduli => moduli
    row%moduli_batch => moduli_batch
    row%energy => energy
  end function describe

  !> Compute the stress and the constant tangent.
  pure subroutine stress(prop, h, tau, c, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp), intent(out) :: tau(6), c(6, 6)
    logical, intent(out) :: ok

    real(wp) :: lam, mus

    call moduli(prop, h, tau, lam, mus, ok)
    c = isotropic(lam, mus)
  end subroutine stress

  !> Compute the stress and the Lame parameters.
  pure subroutine moduli(prop, h, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp), intent(out) :: tau(6), lam, mus
    logical, intent(out) :: ok

    real(wp) :: trace

    lam = prop(LAMBDA)
    mus = prop(MU)
    trace = h(1, 1) + h(2, 2) + h(3, 3)
    tau(1) = lam*trace + 2.0_wp*mus*h(1, 1)
    tau(2) = lam*trace + 2.0_wp*mus*h(2, 2)
    tau(3) = lam*trace + 2.0_wp*mus*h(3, 3)
    tau(4) = mus*(h(1, 2) + h(2, 1))
    tau(5) = mus*(h(2, 3) + h(3, 2))
    tau(6) = mus*(h(3, 1) + h(1, 3))
    ok = .true.
  end subroutine moduli

  !> Do the same as `moduli` at NB points.
  pure subroutine moduli_batch(prop, h, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(NB, 3, 3)
    real(wp), intent(out) :: tau(NB, 6), lam(NB), mus(NB)
    logical, intent(out) :: ok(NB)

    real(wp) :: l, m, trace
    integer :: n

    l = prop(LAMBDA)
    m = prop(MU)
    !$omp simd private(trace)
    do n = 1, NB
      trace = h(n, 1, 1) + h(n, 2, 2) + h(n, 3, 3)
      tau(n, 1) = l*trace + 2.0_wp*m*h(n, 1, 1)
      tau(n, 2) = l*trace + 2.0_wp*m*h(n, 2, 2)
      tau(n, 3) = l*trace + 2.0_wp*m*h(n, 3, 3)
      tau(n, 4) = m*(h(n, 1, 2) + h(n, 2, 1))
      tau(n, 5) = m*(h(n, 2, 3) + h(n, 3, 2))
      tau(n, 6) = m*(h(n, 3, 1) + h(n, 1, 3))
      lam(n) = l
      mus(n) = m
    end do
    ok = .true.
  end subroutine moduli_batch

  !> Stored energy: half of stress times strain.
  pure function energy(prop, h) result(w)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp) :: w

    real(wp) :: tau(6), lam, mus
    logical :: ok

    call moduli(prop, h, tau, lam, mus, ok)
    w = 0.5_wp*(tau(1)*h(1, 1) + tau(2)*h(2, 2) &
                + tau(3)*h(3, 3) + tau(4)*(h(1, 2) + h(2, 1)) &
                + tau(5)*(h(2, 3) + h(3, 2)) + tau(6)*(h(3, 1) + h(1, 3)))
  end function energy

end module mate_linear
