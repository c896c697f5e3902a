!> Compressible neo-Hookean law at finite strains.
!!
!!   W = mu/2 (tr b - 3) - mu ln J + U(J),   tau = mu (b - 1) + J U' 1
!!   U = Lam/4 (J^2 - 1 - 2 ln J)   VOLUme 1
!!       Lam/2 (J - 1)^2            VOLUme 2
!!       Lam/2 (ln J)^2             VOLUme 3, the default: eq. (32) of the source
!!
!! The spatial tangent is J (J U')' 1 x 1 + 2 (mu - J U') I.
!!
!! The terms are formed from the displacement gradient H = F - 1, so that small strains keep all
!! their digits: b - 1 = H + H^T + H H^T, and J - 1 is the sum of the invariants of H.
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
  use tensor, only: det3, isotropic, second_invariant, trace
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
  pure subroutine stress(prop, h, tau, c, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp), intent(out) :: tau(6), c(6, 6)
    logical, intent(out) :: ok

    real(wp) :: lam, mus

    call moduli(prop, h, tau, lam, mus, ok)
    c = isotropic(lam, mus)
  end subroutine stress

  !> Compute the Kirchhoff stress and the two moduli.
  pure subroutine moduli(prop, h, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp), intent(out) :: tau(6), lam, mus
    logical, intent(out) :: ok

    real(wp) :: growth, jac, p

    tau = 0.0_wp
    lam = 0.0_wp
    mus = 0.0_wp
    growth = volume_growth(h)
    jac = 1.0_wp + growth
    ok = jac > 0.0_wp .and. jac <= huge(jac)
    if (.not. ok) return
    select case (nint(prop(VOLUME)))
    case (1)
      p = 0.5_wp*prop(LAMBDA)*(growth*(growth + 2.0_wp))
      lam = prop(LAMBDA)*(jac*jac)
    case (2)
      p = prop(LAMBDA)*(jac*growth)
      lam = prop(LAMBDA)*(jac*(2.0_wp*jac - 1.0_wp))
    case default
      p = prop(LAMBDA)*log_of_sum(growth, jac)
      lam = prop(LAMBDA)
    end select
    mus = prop(MU) - p
    tau(1) = prop(MU)*(2.0_wp*h(1, 1) + dot_product(h(1, :), h(1, :))) + p
    tau(2) = prop(MU)*(2.0_wp*h(2, 2) + dot_product(h(2, :), h(2, :))) + p
    tau(3) = prop(MU)*(2.0_wp*h(3, 3) + dot_product(h(3, :), h(3, :))) + p
    tau(4) = prop(MU)*(h(1, 2) + h(2, 1) + dot_product(h(1, :), h(2, :)))
    tau(5) = prop(MU)*(h(2, 3) + h(3, 2) + dot_product(h(2, :), h(3, :)))
    tau(6) = prop(MU)*(h(3, 1) + h(1, 3) + dot_product(h(3, :), h(1, :)))
  end subroutine moduli

  !> Do the same as `moduli` at NB points.
  pure subroutine moduli_batch(prop, h, tau, lam, mus, ok)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(NB, 3, 3)
    real(wp), intent(out) :: tau(NB, 6), lam(NB), mus(NB)
    logical, intent(out) :: ok(NB)

    real(wp) :: growth(NB), jac(NB), p(NB), l, m
    integer :: n

    l = prop(LAMBDA)
    m = prop(MU)
    call find_volumes(h, growth, jac, ok)
    select case (nint(prop(VOLUME)))
    case (1)
      do n = 1, NB
        p(n) = 0.5_wp*l*(growth(n)*(growth(n) + 2.0_wp))
        lam(n) = l*(jac(n)*jac(n))
      end do
    case (2)
      do n = 1, NB
        p(n) = l*(jac(n)*growth(n))
        lam(n) = l*(jac(n)*(2.0_wp*jac(n) - 1.0_wp))
      end do
    case default
      do n = 1, NB
        p(n) = l*log_of_sum(growth(n), jac(n))
        lam(n) = l
      end do
    end select
    !$omp simd
    do n = 1, NB
      mus(n) = m - p(n)
      tau(n, 1) = m*(2.0_wp*h(n, 1, 1) + (h(n, 1, 1)**2 + h(n, 1, 2)**2 + h(n, 1, 3)**2)) + p(n)
      tau(n, 2) = m*(2.0_wp*h(n, 2, 2) + (h(n, 2, 1)**2 + h(n, 2, 2)**2 + h(n, 2, 3)**2)) + p(n)
      tau(n, 3) = m*(2.0_wp*h(n, 3, 3) + (h(n, 3, 1)**2 + h(n, 3, 2)**2 + h(n, 3, 3)**2)) + p(n)
      tau(n, 4) = m*(h(n, 1, 2) + h(n, 2, 1) &
                     + (h(n, 1, 1)*h(n, 2, 1) + h(n, 1, 2)*h(n, 2, 2) + h(n, 1, 3)*h(n, 2, 3)))
      tau(n, 5) = m*(h(n, 2, 3) + h(n, 3, 2) &
                     + (h(n, 2, 1)*h(n, 3, 1) + h(n, 2, 2)*h(n, 3, 2) + h(n, 2, 3)*h(n, 3, 3)))
      tau(n, 6) = m*(h(n, 3, 1) + h(n, 1, 3) &
                     + (h(n, 3, 1)*h(n, 1, 1) + h(n, 3, 2)*h(n, 1, 2) + h(n, 3, 3)*h(n, 1, 3)))
    end do
  end subroutine moduli_batch

  !> Compute J - 1 and J. If a determinant is not positive and finite, it is set to 1 and its `ok`
  !! is set to .false.
  pure subroutine find_volumes(h, growth, jac, ok)
    real(wp), intent(in) :: h(NB, 3, 3)
    real(wp), intent(out) :: growth(NB), jac(NB) !! J - 1, J
    logical, intent(out) :: ok(NB)

    real(wp) :: bad
    integer :: n

    !$omp simd
    do n = 1, NB
      growth(n) = h(n, 1, 1) + h(n, 2, 2) + h(n, 3, 3) &
                  + ((h(n, 1, 1)*h(n, 2, 2) - h(n, 1, 2)*h(n, 2, 1)) &
                     + (h(n, 1, 1)*h(n, 3, 3) - h(n, 1, 3)*h(n, 3, 1)) &
                     + (1.0_wp + h(n, 1, 1))*(h(n, 2, 2)*h(n, 3, 3) - h(n, 2, 3)*h(n, 3, 2)) &
                     + h(n, 1, 2)*(h(n, 2, 3)*h(n, 3, 1) - h(n, 2, 1)*h(n, 3, 3)) &
                     + h(n, 1, 3)*(h(n, 2, 1)*h(n, 3, 2) - h(n, 2, 2)*h(n, 3, 1)))
      jac(n) = 1.0_wp + growth(n)
    end do
    ok = .true.
    bad = 0.0_wp
    !$omp simd reduction(+:bad)
    do n = 1, NB
      bad = bad + merge(0.0_wp, 1.0_wp, jac(n) > 0.0_wp .and. jac(n) <= huge(bad))
    end do
    if (bad > 0.0_wp) then
      ok = jac > 0.0_wp .and. jac <= huge(bad)
      where (.not. ok)
        growth = 0.0_wp
        jac = 1.0_wp
      end where
    end if
  end subroutine find_volumes

  !> J - 1, the sum of the three invariants of H.
  pure real(wp) function volume_growth(h) result(growth)
    real(wp), intent(in) :: h(3, 3)

    growth = trace(h) + (second_invariant(h) + det3(h))
  end function volume_growth

  !> ln(1 + x) for a given sum = 1 + x, which is rounded; the second term corrects the rounding.
  elemental real(wp) function log_of_sum(x, sum) result(y)
    real(wp), intent(in) :: x, sum

    y = log(sum) + (x - (sum - 1.0_wp))/sum
  end function log_of_sum

  !> Stored energy; huge if det F <= 0.
  !!
  !! With A = F^T F - 1 and s = J^2 - 1, which is the sum of the invariants of A, the terms linear
  !! in the strain cancel in
  !!
  !!   mu/2 (tr b - 3) - mu ln J = mu/2 (s - ln(1 + s) - I2(A) - det A).
  !!
  !! They are therefore not formed unless the strain is large.
  pure function energy(prop, h) result(w)
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: h(3, 3)
    real(wp) :: w

    real(wp), parameter :: LARGE = 0.5_wp
    real(wp) :: a(3, 3), growth, jac, s, lnj, rest

    growth = volume_growth(h)
    jac = 1.0_wp + growth
    if (.not. (jac > 0.0_wp .and. jac <= huge(jac))) then
      w = huge(w)
      return
    end if
    a = h + transpose(h) + matmul(transpose(h), h)
    if (maxval(abs(a)) > LARGE) then
      lnj = log_of_sum(growth, jac)
      rest = growth*(growth + 2.0_wp) - 2.0_wp*lnj
      w = 0.5_wp*prop(MU)*(trace(a) - 2.0_wp*lnj)
    else
      s = trace(a) + (second_invariant(a) + det3(a))
      growth = s/(1.0_wp + sqrt(1.0_wp + s))
      lnj = 0.5_wp*log_of_sum(s, 1.0_wp + s)
      rest = excess_of_log(s)
      w = 0.5_wp*prop(MU)*(rest - second_invariant(a) - det3(a))
    end if
    select case (nint(prop(VOLUME)))
    case (1)
      w = w + 0.25_wp*prop(LAMBDA)*rest
    case (2)
      w = w + 0.5_wp*prop(LAMBDA)*growth**2
    case default
      w = w + 0.5_wp*prop(LAMBDA)*lnj**2
    end select
  end function energy

  !> s - ln(1 + s), without cancellation: ln(1 + s) = 2 artanh r with r = s/(2 + s).
  pure real(wp) function excess_of_log(s) result(excess)
    real(wp), intent(in) :: s

    real(wp), parameter :: SMALL = 0.1_wp
    real(wp) :: r, sum
    integer :: k

    if (abs(s) > SMALL) then
      excess = s - log(1.0_wp + s)
    else
      r = s/(2.0_wp + s)
      sum = 0.0_wp
      do k = 15, 3, -2
        sum = r*r*(1.0_wp/k + sum)
      end do
      excess = r*(s - 2.0_wp*sum)
    end if
  end function excess_of_log

end module mate_neohooke
