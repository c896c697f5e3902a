!> The state of the analysis in a checkpoint.
!!
!! The procedures write the state into a group of the file or read it from there (see
!! `restart_archive`). Before it is read, `state` must have the sizes of the model.
module restart_state
  use base_error, only: error_t
  use contact_pair, only: contact_points_t, contact_state_t, control_points_t, friction_points_t
  use dynamics_type, only: dynamics_t, new_dynamics
  use energy_type, only: energy_t
  use load_curve, only: load_table_t
  use model, only: state_t
  use restart_archive, only: archive_t, exchange, exchange_list, enter_group, numbered
  implicit none
  private
  public :: exchange_state

contains

  subroutine exchange_state(archive, group, state, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: path
    integer :: b, c

    call enter_group(archive, group, error)
    call exchange(archive, group//'/step', state%step, error)
    call exchange(archive, group//'/time', state%time, error)
    call exchange(archive, group//'/dt', state%dt, error)
    call exchange(archive, group//'/u', state%u, error)
    call exchange(archive, group//'/u_step', state%u_step, error)
    call exchange(archive, group//'/last_increment', state%last_increment, error)
    call exchange(archive, group//'/last_dt', state%last_dt, error)
    call exchange(archive, group//'/u_base', state%u_base, error)
    call exchange(archive, group//'/scale', state%scale, error)
    call exchange(archive, group//'/reaction', state%reaction, error)
    if (.not. archive%writes) state%reaction_step = state%reaction
    call exchange_list(archive, group//'/factor', state%factor, error)
    call exchange_list(archive, group//'/factor_step', state%factor_step, error)
    call exchange_tables(archive, group//'/table', state%table, error)
    do b = 1, size(state%history)
      path = group//numbered('/history', b)
      call enter_group(archive, path, error)
      call exchange(archive, path//'/step', state%history(b)%step, error)
      call exchange(archive, path//'/iter', state%history(b)%iter, error)
    end do
    do c = 1, size(state%contact)
      call exchange_contact(archive, group//numbered('/contact', c), state%contact(c), error)
    end do
    call exchange_dynamics(archive, group//'/dynamics', state%dynamics, size(state%u, 2), error)
    call exchange_energy(archive, group//'/energy', state%energy, error)
  end subroutine exchange_state

  !> Exchange the history of one contact, and the data from which its results in the last step
  !! follow.
  subroutine exchange_contact(archive, group, contact, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(contact_state_t), intent(inout) :: contact
    type(error_t), allocatable, intent(inout) :: error
    integer :: k

    call enter_group(archive, group, error)
    do k = 1, 2
      call exchange_points(archive, group//numbered('/side', k), contact%side(k), error)
      call exchange_control(archive, group//numbered('/control', k), contact%control(k), error)
      call exchange_rubbed(archive, group//numbered('/friction', k), contact%rubbed(k), error)
    end do
    call exchange_list(archive, group//'/last_cut', contact%last_cut, error)
    call exchange(archive, group//'/balance', contact%balance, error)
    call exchange(archive, group//'/deepest', contact%deepest, error)
    call exchange(archive, group//'/largest_force', contact%largest_force, error)
    call exchange(archive, group//'/touched', contact%touched, error)
    call exchange(archive, group//'/nearest', contact%nearest, error)
    call exchange(archive, group//'/x_nearest', contact%x_nearest, error)
    call exchange(archive, group//'/nearest_step', contact%nearest_step, error)
    call exchange(archive, group//'/dissipated', contact%dissipated, error)
    call exchange(archive, group//'/limit_force', contact%limit_force, error)
    call exchange(archive, group//'/area', contact%area, error)
    call exchange(archive, group//'/sticks', contact%sticks, error)
    call exchange(archive, group//'/slips', contact%slips, error)
    call exchange(archive, group//'/penetration', contact%penetration, error)
    call exchange(archive, group//'/pressed', contact%pressed, error)
    call exchange(archive, group//'/sheared', contact%sheared, error)
    call exchange(archive, group//'/force', contact%force, error)
    call exchange(archive, group//'/moment', contact%moment, error)
    call exchange(archive, group//'/depth_warned', contact%depth_warned, error)
    call exchange(archive, group//'/balance_warned', contact%balance_warned, error)
    call exchange(archive, group//'/penetration_warned', contact%penetration_warned, error)
    call exchange(archive, group//'/friction_warned', contact%friction_warned, error)
    call exchange(archive, group//'/break_warned', contact%break_warned, error)
    call exchange(archive, group//'/oblique', contact%oblique, error)
    call exchange(archive, group//'/oblique_warned', contact%oblique_warned, error)
    call exchange(archive, group//'/patch', contact%patch, error)
    if (archive%writes) return
    contact%force_step = contact%force
    contact%moment_step = contact%moment
  end subroutine exchange_contact

  !> Exchange the type of mass, and velocities, accelerations and the method of integration in time
  !! if there are any.
  subroutine exchange_dynamics(archive, group, dynamics, nnode, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(dynamics_t), intent(inout) :: dynamics
    integer, intent(in) :: nnode
    type(error_t), allocatable, intent(inout) :: error
    logical :: stored

    stored = allocated(dynamics%v) ! only if the analysis has rates
    call enter_group(archive, group, error)
    call exchange(archive, group//'/stored', stored, error)
    call exchange(archive, group//'/lumped', dynamics%lumped, error)
    if (stored) then
      if (.not. archive%writes) call new_dynamics(dynamics, nnode)
      call exchange(archive, group//'/on', dynamics%on, error)
      call exchange(archive, group//'/method', dynamics%method, error)
      call exchange(archive, group//'/continues', dynamics%continues, error)
      call exchange(archive, group//'/beta', dynamics%beta, error)
      call exchange(archive, group//'/gamma', dynamics%gamma, error)
      call exchange(archive, group//'/alpha', dynamics%alpha, error)
      call exchange(archive, group//'/density', dynamics%density, error)
      call exchange(archive, group//'/v', dynamics%v, error)
      call exchange(archive, group//'/a', dynamics%a, error)
      call exchange(archive, group//'/static', dynamics%static, error)
    end if
  end subroutine exchange_dynamics

  !> Exchange the energy balance.
  subroutine exchange_energy(archive, group, energy, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(energy_t), intent(inout) :: energy
    type(error_t), allocatable, intent(inout) :: error

    call enter_group(archive, group, error)
    call exchange(archive, group//'/outer', energy%outer, error)
    call exchange(archive, group//'/error', energy%error, error)
    call exchange(archive, group//'/inertia', energy%inertia, error)
    call exchange(archive, group//'/kinetic', energy%kinetic, error)
    call exchange(archive, group//'/contact', energy%contact, error)
    call exchange(archive, group//'/penetration', energy%penetration, error)
    call exchange(archive, group//'/penetration_share', energy%penetration_share, error)
    call exchange(archive, group//'/moving', energy%moving, error)
    call exchange(archive, group//'/excess_before', energy%excess_before, error)
    call exchange(archive, group//'/excess_without', energy%excess_without, error)
    call exchange(archive, group//'/largest', energy%largest, error)
    call exchange(archive, group//'/growth', energy%growth, error)
    call exchange(archive, group//'/growth_time', energy%growth_time, error)
    call exchange(archive, group//'/f_outer', energy%f_outer, error)
    call exchange(archive, group//'/f_inert', energy%f_inert, error)
    call exchange(archive, group//'/f_contact', energy%f_contact, error)
    call exchange(archive, group//'/rise', energy%rise, error)
  end subroutine exchange_energy

  !> Exchange the load tables. When they are read, their number comes from the file.
  subroutine exchange_tables(archive, group, table, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(load_table_t), allocatable, intent(inout) :: table(:)
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: path
    integer :: i, n

    n = 0
    if (archive%writes) n = size(table)
    call enter_group(archive, group, error)
    call exchange(archive, group//'/count', n, error)
    if (allocated(error)) return
    if (.not. archive%writes) then
      if (allocated(table)) deallocate (table)
      allocate (table(n))
    end if
    do i = 1, n
      path = group//numbered('/table', i)
      call enter_group(archive, path, error)
      call exchange(archive, path//'/kind', table(i)%kind, error)
      call exchange(archive, path//'/power', table(i)%power, error)
      call exchange(archive, path//'/tmin', table(i)%tmin, error)
      call exchange(archive, path//'/tmax', table(i)%tmax, error)
      call exchange(archive, path//'/a', table(i)%a, error)
      call exchange_list(archive, path//'/t', table(i)%t, error)
      call exchange_list(archive, path//'/p', table(i)%p, error)
    end do
  end subroutine exchange_tables

  !> Exchange the data that are needed for the next step, for cutting it back, and for the results
  !! of the last step.
  subroutine exchange_points(archive, group, points, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(contact_points_t), intent(inout) :: points
    type(error_t), allocatable, intent(inout) :: error

    call enter_group(archive, group, error)
    call exchange(archive, group//'/closest', points%closest, error)
    call exchange(archive, group//'/closest_xi', points%closest_xi, error)
    call exchange(archive, group//'/closest_step', points%closest_step, error)
    call exchange(archive, group//'/closest_xi_step', points%closest_xi_step, error)
    call exchange(archive, group//'/slide', points%slide, error)
    call exchange(archive, group//'/slide_xi', points%slide_xi, error)
    call exchange(archive, group//'/multiplier', points%multiplier, error)
    call exchange(archive, group//'/multiplier_step', points%multiplier_step, error)
    call exchange(archive, group//'/state', points%state, error)
    call exchange(archive, group//'/state_step', points%state_step, error)
    call exchange(archive, group//'/gap', points%gap, error)
    call exchange(archive, group//'/pressure', points%pressure, error)
    if (allocated(points%spread)) call exchange(archive, group//'/spread', points%spread, error)
    call exchange(archive, group//'/traction', points%traction, error)
    call exchange(archive, group//'/friction', points%friction, error)
    call exchange(archive, group//'/normal', points%normal, error)
    call exchange(archive, group//'/elastic', points%elastic, error)
    call exchange(archive, group//'/area', points%area, error)
    call exchange(archive, group//'/opening', points%opening, error)
    call exchange(archive, group//'/energy', points%energy, error)
    call exchange(archive, group//'/bond_traction', points%bond_traction, error)
    call exchange(archive, group//'/slip_rate', points%slip_rate, error)
    call exchange(archive, group//'/limit_step', points%limit_step, error)
    call exchange(archive, group//'/beside', points%beside, error)
    call exchange(archive, group//'/past', points%past, error)
    call exchange(archive, group//'/past_step', points%past_step, error)
    if (archive%writes) return
    points%opening_step = points%opening
    points%new_step = .true.
  end subroutine exchange_points

  !> Exchange those data of the control points of a side that are not computed anew when forces are
  !! formed.
  subroutine exchange_control(archive, group, control, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(control_points_t), intent(inout) :: control
    type(error_t), allocatable, intent(inout) :: error

    if (.not. allocated(control%gap)) return
    call enter_group(archive, group, error)
    call exchange(archive, group//'/multiplier', control%multiplier, error)
    call exchange(archive, group//'/multiplier_step', control%multiplier_step, error)
    call exchange(archive, group//'/pressure', control%pressure, error)
    call exchange(archive, group//'/gap', control%gap, error)
  end subroutine exchange_control

  !> Exchange the points where friction acted in the previous step. When they are read, their
  !! number comes from the file.
  subroutine exchange_rubbed(archive, group, rubbed, error)
    type(archive_t), intent(in) :: archive
    character(*), intent(in) :: group
    type(friction_points_t), intent(inout) :: rubbed
    type(error_t), allocatable, intent(inout) :: error
    integer :: n

    n = 0
    if (allocated(rubbed%elem)) n = size(rubbed%elem)
    call enter_group(archive, group, error)
    call exchange(archive, group//'/count', n, error)
    if (allocated(error) .or. (archive%writes .and. n == 0)) return
    if (.not. archive%writes) then
      if (allocated(rubbed%elem)) deallocate (rubbed%elem, rubbed%xi, rubbed%elastic, &
                                              rubbed%slip_rate, rubbed%limit)
      allocate (rubbed%elem(n), rubbed%xi(2, n), rubbed%elastic(3, n), rubbed%slip_rate(n), &
                rubbed%limit(n))
    end if
    call exchange(archive, group//'/elem', rubbed%elem, error)
    call exchange(archive, group//'/xi', rubbed%xi, error)
    call exchange(archive, group//'/elastic', rubbed%elastic, error)
    call exchange(archive, group//'/slip_rate', rubbed%slip_rate, error)
    call exchange(archive, group//'/limit', rubbed%limit, error)
  end subroutine exchange_rubbed

end module restart_state
