!> Compressible neo-Hookean law at finite strains.
!!
!!   W = mu/2 (tr b - 3) - mu ln J + U(J),   tau = mu (b - 1) + J U' 1
!!   U = Lam/4 (J^2 - 1 - 2 ln J)   VOLUme 1
!!       Lam/2 (J - 1)^2            VOLUme 2
!!       Lam/2 (ln J)^2             VOLUme 3, the default: eq. (32) of the source
!!
!! The spatial tangent is J (J U')' 1 x 1 + 2 (mu - J U') I.
!!
!! Deck:    SOLId / ELAStic NEOHook E nu / FINIte [VOLUme k]
!! History: none
!! Source:  Corbett and Sauer 2015, eqs (32) and (33), after Zienkiewicz and Taylor 2005
!! Limits:  det F > 0
module mate_neohooke
  use base_kinds, only: wp
  use base_text, only: to_text
  use elastic_constants, only: set_constants, young_modulus, VOLUME, MU, LAMBDA
  use material_type, only: material_t, constant_error_t, NB
  use tensor, only: det3, isotropic
  implicit none
  private
  public :: describe

contains

  !> Row of this law in the table of laws.
  function describe() result(row)
    type(material_t) :: row

    row%name = 'NEOHook'
    row%numbers = 'E nu'
    row%nvalue = 2
    row%volumetric = .true.
    row%source = 'compressible neo-Hooke; with VOLUme 3, Corbett and Sauer 2015, eq. (32)'
    row%finite = .true.
    row%nprop = LAMBDA
    row%example(:2) = [2.0_wp, 0.3_wp]
    row%set => set
    row%stiffness => young_modulus
    row%stress => stress
    row%moduli => moduli
    row%moduli_batch => moduli_batch
    row%energy => energy
  end function describe

  !> Set prop(:) from E, nu and, if given, the volumetric function.
  pure subroutine set(value, prop, error)
    real(wp), intent(in) :: value(:) !! E, nu [, k]
    real(wp), intent(out) :: prop(:)
    type(constant_error_t), intent(out) :: error

    call set_constants(value, prop, error)
    prop(VOLUME) = 3.0_wp
    if (size(value) < 3) return
    prop(VOLUME) = value(3)
    if (error%value == 0 .and. all(nint(value(3)) /= [1, 2, 3])) then
      error = constant_error_t(3, 'unknown volumetric function '//to_text(value(3)), &
                               'VOLUme must be 1, 2 or 3; the default is 3')
    end if
  end subroutine set

  !> Compute the Kirchhoff stress and the spatial tangent.
  pure subroutine stress(prop, dg, tau, c, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: dg(3, 3)
    real(wp), intent(out) :: tau(6), c(6, 6)
    logical, intent(out) :: ok

    real(wp) :: lam, mus

    call moduli(prop, dg, tau, lam, mus, ok)
    c = isotropic(lam, mus)
  end subroutine stress

  !> Compute the Kirchhoff stress and the two moduli.
  pure subroutine moduli(prop, dg, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: dg(3, 3)
    real(wp), intent(out) :: tau(6), lam, mus
    logical, intent(out) :: ok

    real(wp) :: jac, p

    tau = 0.0_wp
    lam = 0.0_wp
    mus = 0.0_wp
    jac = det3(dg)
    ok = jac > 0.0_wp .and. jac <= huge(jac)
    if (.not. ok) return
    select case (nint(prop(VOLUME)))
    case (1)
      p = 0.5_wp*prop(LAMBDA)*((jac - 1.0_wp)*(jac + 1.0_wp))
      lam = prop(LAMBDA)*(jac*jac)
    case (2)
      p = prop(LAMBDA)*(jac*(jac - 1.0_wp))
      lam = prop(LAMBDA)*(jac*(2.0_wp*jac - 1.0_wp))
    case default
      p = prop(LAMBDA)*log(jac)
      lam = prop(LAMBDA)
    end select
    mus = prop(MU) - p
    tau(1) = prop(MU)*(dot_product(dg(1, :), dg(1, :)) - 1.0_wp) + p
    tau(2) = prop(MU)*(dot_product(dg(2, :), dg(2, :)) - 1.0_wp) + p
    tau(3) = prop(MU)*(dot_product(dg(3, :), dg(3, :)) - 1.0_wp) + p
    tau(4) = prop(MU)*dot_product(dg(1, :), dg(2, :))
    tau(5) = prop(MU)*dot_product(dg(2, :), dg(3, :))
    tau(6) = prop(MU)*dot_product(dg(3, :), dg(1, :))
  end subroutine moduli

  !> Do the same as `moduli` at NB points.
  pure subroutine moduli_batch(prop, dg, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: dg(NB, 3, 3)
    real(wp), intent(out) :: tau(NB, 6), lam(NB), mus(NB)
    logical, intent(out) :: ok(NB)

    real(wp) :: jac(NB), p(NB), l, m
    integer :: n

    l = prop(LAMBDA)
    m = prop(MU)
    call find_volumes(dg, jac, ok)
    select case (nint(prop(VOLUME)))
    case (1)
      do n = 1, NB
        p(n) = 0.5_wp*l*((jac(n) - 1.0_wp)*(jac(n) + 1.0_wp))
        lam(n) = l*(jac(n)*jac(n))
      end do
    case (2)
      do n = 1, NB
        p(n) = l*(jac(n)*(jac(n) - 1.0_wp))
        lam(n) = l*(jac(n)*(2.0_wp*jac(n) - 1.0_wp))
      end do
    case default
      do n = 1, NB
        p(n) = l*log(jac(n))
        lam(n) = l
      end do
    end select
    !$omp simd
    do n = 1, NB
      mus(n) = m - p(n)
      tau(n, 1) = m*(dg(n, 1, 1)**2 + dg(n, 1, 2)**2 + dg(n, 1, 3)**2 - 1.0_wp) + p(n)
      tau(n, 2) = m*(dg(n, 2, 1)**2 + dg(n, 2, 2)**2 + dg(n, 2, 3)**2 - 1.0_wp) + p(n)
      tau(n, 3) = m*(dg(n, 3, 1)**2 + dg(n, 3, 2)**2 + dg(n, 3, 3)**2 - 1.0_wp) + p(n)
      tau(n, 4) = m*(dg(n, 1, 1)*dg(n, 2, 1) + dg(n, 1, 2)*dg(n, 2, 2) + dg(n, 1, 3)*dg(n, 2, 3))
      tau(n, 5) = m*(dg(n, 2, 1)*dg(n, 3, 1) + dg(n, 2, 2)*dg(n, 3, 2) + dg(n, 2, 3)*dg(n, 3, 3))
      tau(n, 6) = m*(dg(n, 3, 1)*dg(n, 1, 1) + dg(n, 3, 2)*dg(n, 1, 2) + dg(n, 3, 3)*dg(n, 1, 3))
    end do
  end subroutine moduli_batch

  !> Compute the determinants. If a determinant is not positive and finite, it is set to 1 and its
  !! `ok` is set to .false.
  pure subroutine find_volumes(dg, jac, ok)
    real(wp), intent(in) :: dg(NB, 3, 3)
    real(wp), intent(out) :: jac(NB)
    logical, intent(out) :: ok(NB)

    real(wp) :: bad
    integer :: n

    !$omp simd
    do n = 1, NB
      jac(n) = dg(n, 1, 1)*(dg(n, 2, 2)*dg(n, 3, 3) - dg(n, 2, 3)*dg(n, 3, 2)) &
               + dg(n, 1, 2)*(dg(n, 2, 3)*dg(n, 3, 1) - dg(n, 2, 1)*dg(n, 3, 3)) &
               + dg(n, 1, 3)*(dg(n, 2, 1)*dg(n, 3, 2) - dg(n, 2, 2)*dg(n, 3, 1))
    end do
    ok = .true.
    bad = 0.0_wp
    !$omp simd reduction(+:bad)
    do n = 1, NB
      bad = bad + merge(0.0_wp, 1.0_wp, jac(n) > 0.0_wp .and. jac(n) <= huge(bad))
    end do
    if (bad > 0.0_wp) then
      ok = jac > 0.0_wp .and. jac <= huge(bad)
      where (.not. ok) jac = 1.0_wp
    end if
  end subroutine find_volumes

  !> Stored energy; huge if det F <= 0.
  pure function energy(prop, dg) result(w)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: dg(3, 3)
    real(wp) :: w

    real(wp) :: jac, lnj

    jac = det3(dg)
    if (.not. (jac > 0.0_wp .and. jac <= huge(jac))) then
      w = huge(w)
      return
    end if
    lnj = log(jac)
    w = 0.5_wp*prop(MU)*(sum(dg*dg) - 3.0_wp) - prop(MU)*lnj
    select case (nint(prop(VOLUME)))
    case (1)
      w = w + 0.25_wp*prop(LAMBDA)*((jac - 1.0_wp)*(jac + 1.0_wp) - 2.0_wp*lnj)
    case (2)
      w = w + 0.5_wp*prop(LAMBDA)*(jac - 1.0_wp)**2
    case default
      w = w + 0.5_wp*prop(LAMBDA)*lnj**2
    end select
  end function energy

end module mate_neohooke
