!> Entities of a Gmsh file of version 4.1: which physical groups points, curves, surfaces and
!! volumes belong to.
module mesh_gmsh_entity
  use base_kinds, only: wp
  use base_error, only: error_t
  use mesh_file, only: mesh_file_t, add_member
  use patch_text, only: text_t, next_integer, next_count, next_reals
  implicit none
  private
  public :: entities_t, read_entities, tag_entity

  !> Memberships: entity (dim, tag) belongs to a physical group.
  type :: entities_t
    integer :: n = 0
    integer, allocatable :: dim(:), tag(:), physical(:) !! (>= n)
  end type entities_t

contains

  !> $Entities.
  subroutine read_entities(text, entities, error)
    type(text_t), intent(inout) :: text
    type(entities_t), intent(out) :: entities
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i, count(0:3)

    allocate (entities%dim(16), entities%tag(16), entities%physical(16))
    do d = 0, 3
      call next_count(text, 'a number of entities', count(d), error)
      if (allocated(error)) return
    end do
    do d = 0, 3
      do i = 1, count(d)
        call read_entity(text, d, entities, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_entities

  !> Tag, position or box, physical groups, and (of more than points) the boundary.
  subroutine read_entity(text, d, entities, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: d
    type(entities_t), intent(inout) :: entities
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: box(6)
    integer :: i, n, part, tag, value

    call next_integer(text, 'the tag of an entity', tag, error)
    if (allocated(error)) return
    call next_reals(text, 'the box of an entity', box(:merge(3, 6, d == 0)), error)
    do part = 1, merge(1, 2, d == 0)
      if (.not. allocated(error)) call next_count(text, 'a number of tags', n, error)
      if (allocated(error)) return
      do i = 1, n
        call next_integer(text, 'a tag', value, error)
        if (allocated(error)) return
        if (part == 1) call append(entities, d, tag, value)
      end do
    end do
  end subroutine read_entity

  subroutine append(entities, d, tag, physical)
    type(entities_t), intent(inout) :: entities
    integer, intent(in) :: d, tag, physical

    if (entities%n == size(entities%dim)) then
      entities%dim = [entities%dim, entities%dim]
      entities%tag = [entities%tag, entities%tag]
      entities%physical = [entities%physical, entities%physical]
    end if
    entities%n = entities%n + 1
    entities%dim(entities%n) = d
    entities%tag(entities%n) = tag
    entities%physical(entities%n) = physical
  end subroutine append

  !> The last element of the file lies on an entity.
  subroutine tag_entity(entities, d, tag, file)
    type(entities_t), intent(in) :: entities
    integer, intent(in) :: d, tag
    type(mesh_file_t), intent(inout) :: file
    integer :: i

    do i = 1, entities%n
      if (entities%dim(i) /= d .or. entities%tag(i) /= tag) cycle
      call add_member(file, file%nelem, d, entities%physical(i))
    end do
  end subroutine tag_entity

end module mesh_gmsh_entity
