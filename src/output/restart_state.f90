!> The contents of a checkpoint: the state and the commands' bag, in a group of an HDF5 file.
!!
!! Rates and the book of energies in a checkpoint.
!!
!! The history of contacts in a checkpoint: one matrix a side, a column a point.
module restart_state
  use base_kinds, only: wp
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use model, only: state_t
  use load_curve, only: load_table_t
  use named_values, only: named_values_t, item_t, ITEM_REAL, ITEM_INTEGER, ITEM_TEXT, put
  use hdf5_file, only: hdf5_t, make_group, put_attribute, get_attribute, AS_INT32, AS_UINT8
  use restart_arrays, only: write_reals, read_reals, write_integers, read_integers, write_matrix, &
      read_matrix, name
  use dynamics_type, only: dynamics_t, new_dynamics
  use energy_type, only: energy_t, open_book
  use contact_pair, only: contact_state_t, contact_points_t
  use contact_type, only: MAX_PAST
  implicit none
  private
  public :: write_state, read_state, write_bag, read_bag, write_motion, read_motion, &
            write_contact, read_contact

  integer, parameter :: NROW = 31 + 2*MAX_PAST !! numbers of a point

contains

  subroutine write_state(file, group, state, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    type(named_values_t) :: tables
    integer :: b

    call make_group(file, group, error)
    if (.not. allocated(error)) call put_attribute(file, group, 'step', [state%step], error)
    if (.not. allocated(error)) then
      call write_reals(file, group//'/time', [state%time, state%dt, state%scale], error)
    end if
    if (.not. allocated(error)) call write_matrix(file, group//'/u', state%u, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/u_step', state%u_step, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/way', state%last_increment, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/u_base', state%u_base, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/reaction', state%reaction, error)
    if (.not. allocated(error)) call write_reals(file, group//'/factor', state%factor, error)
    if (allocated(error)) return
    call pack_tables(state%table, tables)
    call write_bag(file, group//'/table', tables, error)
    do b = 1, size(state%history)
      if (allocated(error)) return
      call write_matrix(file, group//name('/history_step', b), state%history(b)%step, error)
      if (allocated(error)) return
      call write_matrix(file, group//name('/history_iter', b), state%history(b)%iter, error)
    end do
    if (.not. allocated(error)) call write_contact(file, group, state%contact, error)
    if (.not. allocated(error)) call write_motion(file, group, state, error)
  end subroutine write_state

  !> The state must have the sizes of the model.
  subroutine read_state(file, group, state, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(state_t), intent(inout) :: state
    type(error_t), allocatable, intent(out) :: error
    type(named_values_t) :: tables
    real(wp), allocatable :: time(:)
    integer :: b, step(1)

    call get_attribute(file, group, 'step', step, error)
    if (allocated(error)) return
    state%step = step(1)
    call read_reals(file, group//'/time', time, error)
    if (.not. allocated(error)) then
      if (size(time) /= 3) call fail(error, SYSTEM_ERROR, 'damaged')
    end if
    if (allocated(error)) return
    state%time = time(1)
    state%dt = time(2)
    state%scale = time(3)
    call read_matrix(file, group//'/u', state%u, error)
    if (.not. allocated(error)) call read_matrix(file, group//'/u_step', state%u_step, error)
    if (.not. allocated(error)) call read_matrix(file, group//'/way', state%last_increment, error)
    if (.not. allocated(error)) call read_matrix(file, group//'/u_base', state%u_base, error)
    if (.not. allocated(error)) call read_matrix(file, group//'/reaction', state%reaction, error)
    if (.not. allocated(error)) call read_reals(file, group//'/factor', state%factor, error)
    if (.not. allocated(error)) call read_bag(file, group//'/table', tables, error)
    if (.not. allocated(error)) call unpack_tables(tables, state%table, error)
    do b = 1, size(state%history)
      if (allocated(error)) return
      call read_matrix(file, group//name('/history_step', b), state%history(b)%step, error)
      if (allocated(error)) return
      call read_matrix(file, group//name('/history_iter', b), state%history(b)%iter, error)
    end do
    if (.not. allocated(error)) call read_contact(file, group, state%contact, error)
    if (.not. allocated(error)) call read_motion(file, group, state, error)
  end subroutine read_state

  subroutine write_bag(file, group, bag, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(named_values_t), intent(in) :: bag
    type(error_t), allocatable, intent(out) :: error
    integer :: k

    call make_group(file, group, error)
    if (.not. allocated(error)) call put_attribute(file, group, 'items', [bag%n], error)
    do k = 1, bag%n
      if (allocated(error)) return
      call write_item(file, group//name('/item', k), bag%item(k), error)
    end do
  end subroutine write_bag

  subroutine write_item(file, path, item, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(item_t), intent(in) :: item
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    select case (item%kind)
    case (ITEM_REAL)
      call write_reals(file, path, item%reals, error)
    case (ITEM_INTEGER)
      call write_integers(file, path, item%integers, AS_INT32, error)
    case default
      call write_integers(file, path, [(iachar(item%text(i:i)), i=1, len(item%text))], AS_UINT8, &
                          error)
    end select
    if (.not. allocated(error)) call put_attribute(file, path, 'name', item%name, error)
    if (.not. allocated(error)) call put_attribute(file, path, 'kind', [item%kind], error)
  end subroutine write_item

  subroutine read_bag(file, group, bag, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(named_values_t), intent(out) :: bag
    type(error_t), allocatable, intent(out) :: error
    integer :: k, n(1)

    call get_attribute(file, group, 'items', n, error)
    do k = 1, n(1)
      if (allocated(error)) return
      call read_item(file, group//name('/item', k), bag, error)
    end do
  end subroutine read_bag

  subroutine read_item(file, path, bag, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: path
    type(named_values_t), intent(inout) :: bag
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: label
    real(wp), allocatable :: reals(:)
    integer, allocatable :: integers(:)
    integer :: i, kind(1)

    call get_attribute(file, path, 'name', label, error)
    if (.not. allocated(error)) call get_attribute(file, path, 'kind', kind, error)
    if (allocated(error)) return
    if (kind(1) == ITEM_REAL) then
      call read_reals(file, path, reals, error)
      if (.not. allocated(error)) call put(bag, label, reals)
    else
      call read_integers(file, path, integers, error)
      if (allocated(error)) return
      if (kind(1) == ITEM_TEXT) then
        block
          character(size(integers)) :: text
          do i = 1, size(integers)
            text(i:i) = achar(integers(i))
          end do
          call put(bag, label, text)
        end block
      else
        call put(bag, label, integers)
      end if
    end if
  end subroutine read_item

  !> Load tables as named lists.
  subroutine pack_tables(table, bag)
    type(load_table_t), intent(in) :: table(:)
    type(named_values_t), intent(out) :: bag
    integer :: i

    call put(bag, 'count', size(table))
    do i = 1, size(table)
      call put(bag, name('kind', i), [table(i)%kind, table(i)%power])
      call put(bag, name('formula', i), [table(i)%tmin, table(i)%tmax, table(i)%a])
      if (allocated(table(i)%t)) call put(bag, name('t', i), table(i)%t)
      if (allocated(table(i)%p)) call put(bag, name('p', i), table(i)%p)
    end do
  end subroutine pack_tables

  subroutine unpack_tables(bag, table, error)
    use named_values, only: get
    type(named_values_t), intent(in) :: bag
    type(load_table_t), allocatable, intent(inout) :: table(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: kind(:)
    real(wp), allocatable :: formula(:)
    integer :: i, n
    logical :: found(3), ignored

    n = 0
    call get(bag, 'count', n, found(1))
    if (allocated(table)) deallocate (table)
    allocate (table(n))
    do i = 1, n
      call get(bag, name('kind', i), kind, found(2))
      call get(bag, name('formula', i), formula, found(3))
      if (.not. all(found)) then
        call fail(error, SYSTEM_ERROR, 'damaged')
        return
      end if
      table(i)%kind = kind(1)
      table(i)%power = kind(2)
      table(i)%tmin = formula(1)
      table(i)%tmax = formula(2)
      table(i)%a = formula(3:7)
      call get(bag, name('t', i), table(i)%t, ignored)
      call get(bag, name('p', i), table(i)%p, ignored)
    end do
  end subroutine unpack_tables

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

end module restart_state
