!> Rates and the book of energies in a checkpoint.
module restart_motion
  use base_kinds, only: wp
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use dynamics_type, only: dynamics_t, new_dynamics
  use energy_type, only: energy_t, open_book
  use hdf5_file, only: hdf5_t, make_group, put_attribute, get_attribute
  use model, only: state_t
  use restart_arrays, only: write_reals, read_reals, write_matrix, read_matrix, name
  implicit none
  private
  public :: write_motion, read_motion

contains

  !> Nothing of what the run does not keep.
  subroutine write_motion(file, group, state, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: path
    logical :: rates

    path = group//'/motion'
    call make_group(file, path, error)
    if (allocated(error)) return
    rates = allocated(state%dynamics%v)
    call put_attribute(file, path, 'keeps', merge(1, 0, [rates, state%energy%on]), error)
    if (allocated(error)) return
    if (rates) call write_rates(file, path, state%dynamics, error)
    if (allocated(error)) return
    if (state%energy%on) call write_book(file, path, state%energy, error)
  end subroutine write_motion

  subroutine write_rates(file, path, dynamics, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(dynamics_t), intent(in) :: dynamics
    type(error_t), allocatable, intent(out) :: error

    call put_attribute(file, path, 'scheme', [merge(1, 0, dynamics%on), dynamics%method, &
                                              merge(1, 0, dynamics%lumped)], error)
    if (.not. allocated(error)) then
      call write_reals(file, path//'/numbers', [dynamics%beta, dynamics%gamma, dynamics%alpha, &
                                                dynamics%density], error)
    end if
    if (.not. allocated(error)) call write_matrix(file, path//'/v', dynamics%v, error)
    if (.not. allocated(error)) call write_matrix(file, path//'/a', dynamics%a, error)
    if (.not. allocated(error)) call write_matrix(file, path//'/held', dynamics%held, error)
  end subroutine write_rates

  subroutine write_book(file, path, energy, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(energy_t), intent(in) :: energy
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    call write_reals(file, path//'/works', [energy%outer, energy%inertia, energy%kinetic, &
                                            energy%contact], error)
    if (.not. allocated(error)) call write_matrix(file, path//'/f_outer', energy%f_outer, error)
    if (.not. allocated(error)) call write_matrix(file, path//'/f_inert', energy%f_inert, error)
    do i = 1, 3
      if (allocated(error)) return
      call write_matrix(file, path//name('/f_contact', i), energy%f_contact(:, :, i), error)
    end do
  end subroutine write_book

  !> The state has the sizes of the model; what it lacks of this is made.
  subroutine read_motion(file, group, state, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: path
    integer :: keeps(2)

    path = group//'/motion'
    call get_attribute(file, path, 'keeps', keeps, error)
    if (allocated(error)) return
    if (keeps(1) == 1) call read_rates(file, path, size(state%u, 2), state%dynamics, error)
    if (keeps(2) == 1 .and. .not. allocated(error)) then
      call read_book(file, path, size(state%u, 2), state%energy, error)
    end if
  end subroutine read_motion

  subroutine read_rates(file, path, nnode, dynamics, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in) :: nnode
    type(dynamics_t), intent(inout) :: dynamics
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: x(:)
    integer :: scheme(3)

    call new_dynamics(dynamics, nnode)
    call get_attribute(file, path, 'scheme', scheme, error)
    if (.not. allocated(error)) call read_reals(file, path//'/numbers', x, error)
    if (.not. allocated(error)) call read_matrix(file, path//'/v', dynamics%v, error)
    if (.not. allocated(error)) call read_matrix(file, path//'/a', dynamics%a, error)
    if (.not. allocated(error)) call read_matrix(file, path//'/held', dynamics%held, error)
    if (allocated(error)) return
    if (size(x) /= 4) then
      call fail(error, SYSTEM_ERROR, 'damaged')
      return
    end if
    dynamics%on = scheme(1) == 1
    dynamics%method = scheme(2)
    dynamics%lumped = scheme(3) == 1
    dynamics%beta = x(1)
    dynamics%gamma = x(2)
    dynamics%alpha = x(3)
    dynamics%density = x(4)
  end subroutine read_rates

  subroutine read_book(file, path, nnode, energy, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    integer, intent(in) :: nnode
    type(energy_t), intent(inout) :: energy
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: x(:)
    integer :: i

    call open_book(energy, nnode)
    call read_reals(file, path//'/works', x, error)
    if (.not. allocated(error)) call read_matrix(file, path//'/f_outer', energy%f_outer, error)
    if (.not. allocated(error)) call read_matrix(file, path//'/f_inert', energy%f_inert, error)
    do i = 1, 3
      if (allocated(error)) return
      call read_matrix(file, path//name('/f_contact', i), energy%f_contact(:, :, i), error)
    end do
    if (allocated(error)) return
    if (size(x) /= 6) then
      call fail(error, SYSTEM_ERROR, 'damaged')
      return
    end if
    energy%outer = x(1)
    energy%inertia = x(2)
    energy%kinetic = x(3)
    energy%contact = x(4:6)
  end subroutine read_book

end module restart_motion
