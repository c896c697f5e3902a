!> A constitutive law as a row of the table of laws: its data and the interfaces of its procedures.
module material_type
  use base_kinds, only: wp
  implicit none
  private
  public :: material_t, constant_error_t, material_usage

  integer, parameter, public :: MAX_PROP = 16 !! largest number of properties of a law
  integer, parameter, public :: NB = 8 !! number of points or elements in a batch

  !> Why a law rejects its constants.
  type :: constant_error_t
    integer :: value = 0          !! index of the rejected number; 0: no number is rejected
    character(64) :: message = '' !! what was found
    character(64) :: hint = ''    !! what is allowed
  end type constant_error_t

  !> A law. Stresses are Kirchhoff stresses tau = J sigma if `finite`, otherwise the stress of the
  !! small strain sym H. The Voigt order is 11 22 33 12 23 31, with shear strains 2 eps_12 etc.
  !!
  !! Laws receive the displacement gradient H = F - 1 and not the deformation gradient F, in which
  !! strains below the rounding error of 1 are lost. They must not subtract 1 from 1 + H either.
  type :: material_t
    character(16) :: name = ''    !! deck word
    character(48) :: numbers = '' !! names of the numbers in the record ELAStic, for hints
    integer :: nvalue = 0         !! number of the constants in `numbers`
    character(80) :: source = ''  !! formula and reference, for the log
    logical :: finite = .true.    !! .false.: small strain
    logical :: volumetric = .false. !! the law has several volumetric functions (VOLUme k of FINIte)
    logical :: symmetric = .true. !! the tangent is symmetric
    integer :: nprop = 0          !! number of entries of prop(:) in use
    real(wp) :: example(MAX_PROP) = 0.0_wp !! (nvalue) constants of a valid material, for the tests
    procedure(material_set_i), pointer, nopass :: set => null()
    procedure(material_stiffness_i), pointer, nopass :: stiffness => null()
    procedure(material_stress_i), pointer, nopass :: stress => null()
    !> An optional, faster alternative to `stress` for laws whose spatial tangent is lam 1 x 1 + 2
    !! mus I, with two scalars lam and mus.
    procedure(material_moduli_i), pointer, nopass :: moduli => null()
    !> Optional, for laws with `moduli`: the same computation at NB points at a time.
    procedure(material_batch_i), pointer, nopass :: moduli_batch => null()
    procedure(material_energy_i), pointer, nopass :: energy => null()
  end type material_t

  abstract interface
    !> Set the properties from the numbers of the deck; `error` says which number is rejected.
    pure subroutine material_set_i(value, prop, error)
      import :: wp, constant_error_t
      implicit none
      !> The nvalue numbers after the name, followed by k of VOLUme k if the deck gives it.
      real(wp), intent(in) :: value(:)
      real(wp), intent(out) :: prop(:)  !! (nprop or more) zero if unused
      type(constant_error_t), intent(out) :: error
    end subroutine material_set_i

    !> Young's modulus at small strains [F/L^2], for penalties that scale with the stiffness.
    pure function material_stiffness_i(prop) result(young)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)   !! (nprop)
      real(wp) :: young
    end function material_stiffness_i

    !> Compute stress and tangent at a point.
    pure subroutine material_stress_i(prop, h, tau, c, ok)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)   !! (nprop)
      real(wp), intent(in) :: h(3, 3)   !! displacement gradient [-]
      real(wp), intent(out) :: tau(6)   !! stress [F/L^2]
      real(wp), intent(out) :: c(6, 6)  !! tangent [F/L^2]: Lie derivative of tau = c : rate of
      !! deformation; at small strains, c = d tau/d eps
      logical, intent(out) :: ok        !! .false.: there is no stress for this h (det F <= 0)
    end subroutine material_stress_i

    !> Compute the stress and the two scalar moduli at a point.
    pure subroutine material_moduli_i(prop, h, tau, lam, mus, ok)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: h(3, 3)
      real(wp), intent(out) :: tau(6)
      real(wp), intent(out) :: lam, mus !! c = lam 1 x 1 + 2 mus I [F/L^2]
      logical, intent(out) :: ok
    end subroutine material_moduli_i

    !> Compute the stress and the two scalar moduli at NB points; the first index is the point.
    pure subroutine material_batch_i(prop, h, tau, lam, mus, ok)
      import :: wp, NB
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: h(NB, 3, 3)
      real(wp), intent(out) :: tau(NB, 6)
      real(wp), intent(out) :: lam(NB), mus(NB)
      logical, intent(out) :: ok(NB)
    end subroutine material_batch_i

    !> Stored energy per reference volume [F/L^2]; huge if there is none (det F <= 0).
    pure function material_energy_i(prop, h) result(w)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: h(3, 3)
      real(wp) :: w
    end function material_energy_i
  end interface

contains

  !> The records of the deck that choose the law, for hints.
  pure function material_usage(law) result(text)
    type(material_t), intent(in) :: law
    character(:), allocatable :: text

    text = 'ELAStic '//trim(law%name)//' '//trim(law%numbers)//' with the record '
    if (.not. law%finite) then
      text = text//'SMALl'
    else if (law%volumetric) then
      text = text//'FINIte [VOLUme k]'
    else
      text = text//'FINIte'
    end if
  end function material_usage

end module material_type
