!> Energies of the bonds of one side of a contact.
module contact_energy
  use base_kinds, only: wp
  use contact_pair, only: contact_points_t
  implicit none
  private
  public :: bond_energies

contains

  !> Stored, spent by damage, spent by viscosity, over the reference area [F L]. Each side of a
  !! contact sums its own points: one of them, or the mean, is the energy of the interface.
  pure function bond_energies(points) result(energy)
    type(contact_points_t), intent(in) :: points
    real(wp) :: energy(3)
    integer :: i

    energy = 0.0_wp
    do i = 1, size(points%bond)
      if (points%bond(i) > 0) energy = energy + points%area0(i)*points%energy(:, i)
    end do
  end function bond_energies

end module contact_energy
