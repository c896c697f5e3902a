!> Nodes of a Gmsh file.
module mesh_gmsh_node
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text
  use mesh_file, only: mesh_file_t
  use patch_text, only: text_t, complain, next_integer, next_integers, next_count, next_reals
  implicit none
  private
  public :: read_nodes

contains

  !> Numbers and coordinates. Version 4.1 has blocks of an entity's numbers, then of its positions.
  subroutine read_nodes(text, is_new, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: b, n, nblock, skip(2), done

    nblock = 1
    if (is_new) call next_count(text, 'the number of blocks of nodes', nblock, error)
    if (allocated(error)) return
    call next_count(text, 'the number of nodes', n, error)
    if (allocated(error)) return
    if (allocated(file%number)) call complain(text, 'the file has two sections of nodes', error)
    if (allocated(error)) return
    file%nnode = n
    allocate (file%number(n), file%x(3, n), file%node_spot(n))
    if (is_new) call next_integers(text, 'the range of node numbers', skip, error)
    done = 0
    do b = 1, nblock
      if (.not. allocated(error)) call read_node_block(text, is_new, done, file, error)
      if (allocated(error)) return
    end do
    if (done /= file%nnode) then
      call complain(text, 'the blocks have '//to_text(done)//' of the '//to_text(file%nnode) &
                    //' nodes announced', error)
    end if
  end subroutine read_nodes

  !> One block; in version 4.1 it says how many nodes it has, and nodes of a kind have parameters of
  !! their entity behind their coordinates.
  subroutine read_node_block(text, is_new, done, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    integer, intent(inout) :: done   !! nodes read so far
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: skip(3)
    integer :: entity(3), i, n

    n = file%nnode
    entity = 0
    if (is_new) then
      call next_integers(text, 'dimension, tag and kind of an entity', entity, error)
      if (.not. allocated(error)) call next_count(text, 'the number of its nodes', n, error)
      if (allocated(error)) return
      if (n > file%nnode - done) then
        call complain(text, 'the blocks have more nodes than the '//to_text(file%nnode) &
                      //' announced', error)
        return
      end if
      do i = done + 1, done + n
        call read_number(text, i, file, error)
        if (allocated(error)) return
      end do
    end if
    if (entity(3) /= 1) entity(1) = 0
    do i = done + 1, done + n
      if (.not. is_new) call read_number(text, i, file, error)
      if (.not. allocated(error)) call next_reals(text, 'a coordinate', file%x(:, i), error)
      if (allocated(error)) return
      call next_reals(text, 'a parameter', skip(:max(0, min(3, entity(1)))), error)
      if (allocated(error)) return
    end do
    done = done + n
  end subroutine read_node_block

  !> The number of node i.
  subroutine read_number(text, i, file, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: i
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error

    call next_integer(text, 'a node number', file%number(i), error)
    if (allocated(error)) return
    file%node_spot(i) = text%at
    if (file%number(i) < 1) then
      call complain(text, 'node number '//to_text(file%number(i)), error, &
                    'node numbers are positive')
    end if
  end subroutine read_number

end module mesh_gmsh_node
