!> Properties of the laws that have Young's modulus and Poisson's ratio.
module elastic_constants
  use base_kinds, only: wp
  use base_text, only: to_text
  use material_type, only: constant_error_t
  implicit none
  private
  public :: set_constants, young_modulus

  !> Indices in prop(:).
  integer, parameter, public :: E_MOD = 1  !! Young's modulus [F/L^2]
  integer, parameter, public :: NU = 2     !! Poisson's ratio [-]
  integer, parameter, public :: VOLUME = 3 !! volumetric function of FINIte VOLUme k: 1, 2 or 3 [-]
  integer, parameter, public :: MU = 4     !! shear modulus [F/L^2]
  integer, parameter, public :: LAMBDA = 5 !! first Lame parameter [F/L^2]

contains

  !> Check E and nu, and derive the Lame parameters by eq. (33) of Corbett and Sauer 2015.
  pure subroutine set_constants(value, prop, error)
    real(wp), intent(in) :: value(:) !! E, nu
    real(wp), intent(out) :: prop(:)
    type(constant_error_t), intent(out) :: error

    prop = 0.0_wp
    if (.not. value(1) > 0.0_wp) then
      error = constant_error_t(1, "Young's modulus is "//to_text(value(1)), 'E must be positive')
    else if (.not. (value(2) > -1.0_wp .and. value(2) < 0.5_wp)) then
      error = constant_error_t(2, "Poisson's ratio is "//to_text(value(2)), &
                               'nu must lie between -1 and 0.5, both excluded')
    end if
    if (error%value > 0) return
    prop(E_MOD) = value(1)
    prop(NU) = value(2)
    prop(MU) = prop(E_MOD)/(2.0_wp*(1.0_wp + prop(NU)))
    prop(LAMBDA) = 2.0_wp*prop(MU)*prop(NU)/(1.0_wp - 2.0_wp*prop(NU))
  end subroutine set_constants

  !> Young's modulus; the interface is material_stiffness_i.
  pure function young_modulus(prop) result(young)
    real(wp), intent(in) :: prop(:)
    real(wp) :: young

    young = prop(E_MOD)
  end function young_modulus

end module elastic_constants
