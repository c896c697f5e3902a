!> What a constitutive law shows to the rest of the program: one row of the table of laws.
module material_type
  use base_kinds, only: wp
  implicit none
  private
  public :: material_t, material_stress_i, material_moduli_i, material_energy_i

  integer, parameter, public :: MAX_PROP = 16 !! length of a row of properties

  !> A law. Stresses are Kirchhoff stresses tau = J sigma where `finite`, else the stress of the
  !! small strain sym(F - I). Voigt order 11 22 33 12 23 31; shear moduli belong to 2 eps_12.
  type :: material_t
    character(16) :: name = ''    !! deck word
    character(80) :: source = ''  !! formula and reference, for the log
    logical :: finite = .true.    !! .false.: small strain
    logical :: symmetric = .true. !! the tangent is
    integer :: nprop = 0
    procedure(material_stress_i), pointer, nopass :: stress => null()
    !> Optional fast way of laws whose spatial tangent is lam 1 x 1 + 2 mus I: both are scalars.
    procedure(material_moduli_i), pointer, nopass :: moduli => null()
    procedure(material_energy_i), pointer, nopass :: energy => null()
  end type material_t

  abstract interface
    !> Stress and tangent at a point.
    pure subroutine material_stress_i(prop, dg, tau, c, ok)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)   !! (nprop)
      real(wp), intent(in) :: dg(3, 3)  !! deformation gradient [-]
      real(wp), intent(out) :: tau(6)   !! stress [F/L^2]
      real(wp), intent(out) :: c(6, 6)  !! spatial tangent: Lie derivative of tau against d; small: d tau / d eps
      logical, intent(out) :: ok        !! .false.: no stress for this dg (det <= 0)
    end subroutine material_stress_i

    !> Stress and the two scalar moduli at a point.
    pure subroutine material_moduli_i(prop, dg, tau, lam, mus, ok)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: dg(3, 3)
      real(wp), intent(out) :: tau(6)
      real(wp), intent(out) :: lam, mus !! c = lam 1 x 1 + 2 mus I [F/L^2]
      logical, intent(out) :: ok
    end subroutine material_moduli_i

    !> Stored energy per reference volume [F/L^2].
    pure function material_energy_i(prop, dg) result(w)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: dg(3, 3)
      real(wp) :: w
    end function material_energy_i
  end interface

end module material_type
