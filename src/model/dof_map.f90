!> Equation numbers of the free degrees of freedom.
module dof_map
  use base_text, only: to_text
  use boundary, only: boundary_t, moved_dofs
  use mesh, only: mesh_t, solid_nodes
  implicit none
  private
  public :: number_equations, dof_name

contains

  !> Number the free dofs of the nodes in use, node by node; slaves of constraints have no number.
  subroutine number_equations(mesh, bc, eq, neq, ndof)
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(in) :: bc
    integer, allocatable, intent(out) :: eq(:, :) !! (3, nnode) equation number, or 0
    integer, intent(out) :: neq                   !! number of free dofs
    integer, intent(out) :: ndof                  !! dofs of nodes in use, without rigid bodies
    logical, allocatable :: free(:, :), solid(:)
    integer :: i, j, n

    allocate (eq(3, mesh%nnode), free(3, mesh%nnode))
    free = bc%fixed == 0 .and. .not. moved_dofs(bc, mesh%nnode)
    do j = 1, mesh%constraint%n
      free(:, mesh%constraint%slave(j)) = .false.
    end do
    eq = 0
    neq = 0
    do n = 1, mesh%nnode
      if (.not. mesh%used(n)) cycle
      do i = 1, 3
        if (.not. free(i, n)) cycle
        neq = neq + 1
        eq(i, n) = neq
      end do
    end do
    call solid_nodes(mesh, solid)
    ndof = 3*count(mesh%used .and. solid)
  end subroutine number_equations

  !> Name of the dof with a given equation number, such as `dof uy of node 3`.
  function dof_name(eq, equation) result(name)
    integer, intent(in) :: eq(:, :) !! (3, nnode)
    integer, intent(in) :: equation
    character(:), allocatable :: name
    integer :: i, n

    do n = 1, size(eq, 2)
      if (any(eq(:, n) == equation)) exit
    end do
    n = merge(n, 0, n <= size(eq, 2))
    i = 1
    if (n > 0) i = maxloc(merge(1, 0, eq(:, n) == equation), 1)
    name = 'dof u'//'xyz' (i:i)//' of node '//to_text(n)
  end function dof_name

end module dof_map
