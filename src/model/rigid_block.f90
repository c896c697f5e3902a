!> Blocks of rigid bodies: they have faces and a picture, but no stiffness, and no material.
module rigid_block
  use mesh, only: mesh_t, block_t
  implicit none
  private
  public :: is_rigid, solid_nodes

contains

  !> The elements of the block are not solved for.
  elemental logical function is_rigid(block)
    type(block_t), intent(in) :: block

    is_rigid = .not. (associated(block%row%form) .or. associated(block%row%form_batch))
  end function is_rigid

  !> Nodes of elements that are solved for.
  pure subroutine solid_nodes(mesh, solid)
    type(mesh_t), intent(in) :: mesh
    logical, allocatable, intent(out) :: solid(:) !! (nnode)
    integer :: b, e

    allocate (solid(mesh%nnode), source=.false.)
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        solid(mesh%block(b)%conn(:, e)) = .true.
      end do
    end do
  end subroutine solid_nodes

end module rigid_block
