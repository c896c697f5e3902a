!> What a constitutive law shows to the rest of the program: one row of the table of laws.
module material_type
  use base_kinds, only: wp
  implicit none
  private
  public :: material_t, material_stress_i, material_moduli_i, material_energy_i
  public :: material_set_i, material_batch_i

  integer, parameter, public :: MAX_PROP = 16 !! length of a row of properties
  integer, parameter, public :: NB = 8 !! points or elements side by side in the vector registers

  !> Columns of prop(:). The deck gives the first three, `set` derives the others.
  integer, parameter, public :: E_MOD = 1  !! Young's modulus [F/L^2]
  integer, parameter, public :: NU = 2     !! Poisson's ratio [-]
  integer, parameter, public :: VOLUME = 3 !! volumetric function of FINIte VOLUme k: 1, 2 or 3 [-]
  integer, parameter, public :: MU = 4     !! shear modulus [F/L^2]
  integer, parameter, public :: LAMBDA = 5 !! first Lame parameter [F/L^2]

  !> A law. Stresses are Kirchhoff stresses tau = J sigma where `finite`, else the stress of the
  !! small strain sym(F - I). Voigt order 11 22 33 12 23 31; shear moduli belong to 2 eps_12.
  type :: material_t
    character(16) :: name = ''    !! deck word
    character(64) :: usage = ''   !! the deck's records, for hints and --list
    character(80) :: source = ''  !! formula and reference, for the log
    logical :: finite = .true.    !! .false.: small strain
    logical :: symmetric = .true. !! the tangent is
    integer :: nprop = 0
    procedure(material_set_i), pointer, nopass :: set => null()
    procedure(material_stress_i), pointer, nopass :: stress => null()
    !> Optional fast way of laws whose spatial tangent is lam 1 x 1 + 2 mus I: both are scalars.
    procedure(material_moduli_i), pointer, nopass :: moduli => null()
    !> The same for NB points; goes with `moduli`.
    procedure(material_batch_i), pointer, nopass :: moduli_batch => null()
    procedure(material_energy_i), pointer, nopass :: energy => null()
  end type material_t

  abstract interface
    !> Properties from the deck's numbers, derived columns too.
    pure subroutine material_set_i(value, prop)
      import :: wp
      implicit none
      real(wp), intent(in) :: value(:)  !! numbers of the law's records, in the order of `usage`
      real(wp), intent(out) :: prop(:)  !! (nprop or more) columns above, zero where unused
    end subroutine material_set_i

    !> Stress and tangent at a point.
    pure subroutine material_stress_i(prop, dg, tau, c, ok)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)   !! (nprop)
      real(wp), intent(in) :: dg(3, 3)  !! deformation gradient [-]
      real(wp), intent(out) :: tau(6)   !! stress [F/L^2]
      real(wp), intent(out) :: c(6, 6)  !! Lie derivative of tau against d; small: d tau/d eps
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

    !> Stress and the two scalar moduli at NB points; the first index is the point.
    pure subroutine material_batch_i(prop, dg, tau, lam, mus, ok)
      import :: wp, NB
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: dg(NB, 3, 3)
      real(wp), intent(out) :: tau(NB, 6)
      real(wp), intent(out) :: lam(NB), mus(NB)
      logical, intent(out) :: ok(NB)
    end subroutine material_batch_i

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
