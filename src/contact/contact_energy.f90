!> Energies that a contact stores and has dissipated, computed from its laws at the points where
!! they act.
!!
!! The pressure and the elastic part of friction have potentials. The energy that slip dissipates in
!! a step is the length of the slip times the mean of mu p at the start and at the end of the step
!! (slip_work). The cohesive laws sum up the energies of bonds (contact_secant). The work of the
!! nodal forces differs from the sum of these energies by the energy that a scheme without a
!! potential creates, and by the error of the trapezoidal rule.
module contact_energy
  use base_kinds, only: wp
  use contact_pair, only: contact_t, contact_points_t, contact_state_t
  use contact_type, only: WORK_DONE
  use contact_work, only: energy_share
  implicit none
  private
  public :: measure_energy, slip_work, bond_energy, bond_energy_at_start, contact_energies

contains

  !> When a step is accepted, find the energies of the integration points of side k, and add the
  !! work of slip. The mortar scheme does the same at the points of its cells (mortar_results).
  pure subroutine measure_energy(contact, k, state)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    type(contact_state_t), intent(inout) :: state

    associate (points => state%side(k), share => energy_share(contact))
      state%pressed(k) = share*sum(points%pressed)
      state%sheared(k) = 0.5_wp*share*sum(points%area*norm2(points%friction, 1) &
                                          *norm2(points%elastic, 1))
      state%dissipated = state%dissipated + share*slip_work(points%area, points%slip, &
                                                            points%limit_step, points%limit, &
                                                            state%limit_force(k))
      state%limit_force(k) = sum(points%area*points%limit)
    end associate
  end subroutine measure_energy

  !> Energy that the slip of a step dissipates at the points of one side: the sum over the points of
  !! the slip times the mean of the friction limits at the start and end of the step, each times the
  !! area. A point that has left the contact has no slip. The limits of all such points, which are
  !! the remainder of `before`, are multiplied by the mean slip of the points in contact. Otherwise
  !! half of the work of a point would be lost in the step in which the other body moves off it.
  pure real(wp) function slip_work(area, slip, limit_step, limit, before) result(work)
    real(wp), intent(in) :: area(:)        !! (n) [L^2]
    real(wp), intent(in) :: slip(:)        !! (n) length of the slip in the step [L]
    real(wp), intent(in) :: limit_step(:)  !! (n) friction limit at the start of the step [F/L^2]
    real(wp), intent(in) :: limit(:)       !! (n) friction limit at the end of the step [F/L^2]
    real(wp), intent(in) :: before         !! integral of the limit at the start of the step [F]
    real(wp) :: force, left

    work = 0.5_wp*sum(area*slip*(limit_step + limit))
    force = sum(area*limit)
    if (.not. force > 0.0_wp) return
    left = before - sum(area*limit_step, mask=limit > 0.0_wp)
    work = work + 0.5_wp*left*sum(area*slip*limit)/force
  end function slip_work

  !> Energy of all bonds of a contact: 1 stored, 2 dissipated by damage, 3 dissipated by viscosity.
  pure function bond_energy(contact, state) result(energy)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp) :: energy(3)

    energy = 0.0_wp
    if (.not. contact%cohesive%given) return
    energy = energy_share(contact)*(of_side(state%side(1)) + of_side(state%side(2)))

  contains

    pure function of_side(points) result(energy)
      type(contact_points_t), intent(in) :: points
      real(wp) :: energy(3)
      integer :: part

      do part = 1, 3
        energy(part) = sum(points%area0*points%energy(part, :), mask=points%bond > 0)
      end do
    end function of_side

  end function bond_energy

  !> Energy of all bonds of a contact at the start of the current step, stored and dissipated: the
  !! work done on them so far. Before a step is accepted, bond_energy is that of its last iteration.
  pure real(wp) function bond_energy_at_start(contact, state) result(energy)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    integer :: k

    energy = 0.0_wp
    if (.not. contact%cohesive%given) return
    do k = 1, 2
      associate (points => state%side(k))
        energy = energy + sum(points%area0*sum(points%past_step(WORK_DONE, :), 1), &
                              mask=points%bond > 0)
      end associate
    end do
    energy = energy_share(contact)*energy
  end function bond_energy_at_start

  !> Energies of a contact: of pressure, of friction (stored and dissipated), and of bonds.
  pure function contact_energies(contact, state) result(energy)
    type(contact_t), intent(in) :: contact
    type(contact_state_t), intent(in) :: state
    real(wp) :: energy(3)

    energy = [sum(state%pressed), sum(state%sheared) + state%dissipated, &
              sum(bond_energy(contact, state))]
  end function contact_energies

end module contact_energy
