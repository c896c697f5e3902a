!> The contents of a checkpoint: the state and the commands' bag, in a group of an HDF5 file.
module restart_state
  use base_kinds, only: wp
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use model, only: state_t
  use load_curve, only: load_table_t
  use bag, only: bag_t, item_t, ITEM_REAL, ITEM_INTEGER, ITEM_TEXT, put
  use hdf5_file, only: hdf5_t, make_group, put_attribute, get_attribute, AS_INT32, AS_UINT8
  use restart_arrays, only: write_reals, read_reals, write_integers, read_integers, write_matrix, &
                            read_matrix, name
  use restart_contact, only: write_contact, read_contact
  use restart_motion, only: write_motion, read_motion
  implicit none
  private
  public :: write_state, read_state, write_bag, read_bag

contains

  subroutine write_state(file, group, state, error)
    type(hdf5_t), intent(in) :: file
    character(*), intent(in) :: group
    type(state_t), intent(in) :: state
    type(error_t), allocatable, intent(out) :: error
    type(bag_t) :: tables
    integer :: b

    call make_group(file, group, error)
    if (.not. allocated(error)) call put_attribute(file, group, 'step', [state%step], error)
    if (.not. allocated(error)) then
      call write_reals(file, group//'/time', [state%time, state%dt, state%scale], error)
    end if
    if (.not. allocated(error)) call write_matrix(file, group//'/u', state%u, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/u_step', state%u_step, error)
    if (.not. allocated(error)) call write_matrix(file, group//'/way', state%way, error)
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
    type(bag_t) :: tables
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
    if (.not. allocated(error)) call read_matrix(file, group//'/way', state%way, error)
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
    type(bag_t), intent(in) :: bag
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
    type(bag_t), intent(out) :: bag
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
    type(bag_t), intent(inout) :: bag
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
    type(bag_t), intent(out) :: bag
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
    use bag, only: get
    type(bag_t), intent(in) :: bag
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

end module restart_state
