!> The history of contacts in a checkpoint: one matrix a side, a column a point.
module restart_contact
  use base_kinds, only: wp
  use base_error, only: error_t
  use contact_pair, only: contact_state_t, contact_points_t
  use contact_type, only: MAX_PAST
  use hdf5_file, only: hdf5_t, make_group
  use restart_arrays, only: write_matrix, read_matrix, name
  implicit none
  private
  public :: write_contact, read_contact

  integer, parameter :: NROW = 31 + 2*MAX_PAST !! numbers of a point

contains

  !> Everything that the next step, a cut of it, and the results of this one need.
  subroutine write_contact(file, group, contact, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(contact_state_t), intent(in) :: contact(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: values(:, :)
    character(:), allocatable :: path
    integer :: c, k

    do c = 1, size(contact)
      path = group//name('/contact', c)
      call make_group(file, path, error)
      do k = 1, 2
        if (allocated(error)) return
        call pack_points(contact(c)%side(k), values)
        call write_matrix(file, path//name('/side', k), values, error)
      end do
      if (allocated(error)) return
    end do
  end subroutine write_contact

  !> The state must have the sizes of the model.
  subroutine read_contact(file, group, contact, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(contact_state_t), intent(inout) :: contact(:)
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: values(:, :)
    integer :: c, k

    do c = 1, size(contact)
      do k = 1, 2
        allocate (values(NROW, size(contact(c)%side(k)%state)))
        call read_matrix(file, group//name('/contact', c)//name('/side', k), values, error)
        if (allocated(error)) return
        call unpack_points(values, contact(c)%side(k))
        deallocate (values)
      end do
    end do
  end subroutine read_contact

  !> Integers are kept as reals, which hold them exactly.
  subroutine pack_points(points, values)
    type(contact_points_t), intent(in) :: points
    real(wp), allocatable, intent(out) :: values(:, :) !! (NROW, np)

    allocate (values(NROW, size(points%state)))
    values(1, :) = points%foot
    values(2:3, :) = points%foot_xi
    values(4, :) = points%foot_step
    values(5:6, :) = points%foot_xi_step
    values(7, :) = points%slide
    values(8:9, :) = points%slide_xi
    values(10, :) = points%multiplier
    values(11, :) = points%multiplier_step
    values(12, :) = points%state
    values(13, :) = points%gap
    values(14, :) = points%pressure
    values(15:17, :) = points%traction
    values(18:20, :) = points%elastic
    values(21, :) = points%area
    values(22, :) = points%opening
    values(23, :) = points%state_step
    values(24:26, :) = points%energy
    values(27:29, :) = points%pull
    values(30, :) = points%slip_rate
    values(31, :) = merge(1.0_wp, 0.0_wp, points%aside)
    values(32:31 + MAX_PAST, :) = points%past
    values(32 + MAX_PAST:, :) = points%past_step
  end subroutine pack_points

  subroutine unpack_points(values, points)
    real(wp), intent(in) :: values(:, :) !! (NROW, np)
    type(contact_points_t), intent(inout) :: points

    points%foot = nint(values(1, :))
    points%foot_xi = values(2:3, :)
    points%foot_step = nint(values(4, :))
    points%foot_xi_step = values(5:6, :)
    points%slide = nint(values(7, :))
    points%slide_xi = values(8:9, :)
    points%multiplier = values(10, :)
    points%multiplier_step = values(11, :)
    points%state = nint(values(12, :))
    points%gap = values(13, :)
    points%pressure = values(14, :)
    points%traction = values(15:17, :)
    points%elastic = values(18:20, :)
    points%area = values(21, :)
    points%opening = values(22, :)
    points%opening_step = points%opening
    points%state_step = nint(values(23, :))
    points%energy = values(24:26, :)
    points%pull = values(27:29, :)
    points%slip_rate = values(30, :)
    points%aside = values(31, :) > 0.5_wp
    points%past = values(32:31 + MAX_PAST, :)
    points%past_step = values(32 + MAX_PAST:, :)
    points%fresh = .true.
  end subroutine unpack_points

end module restart_contact
