!> Equation numbers of the free degrees of freedom.
module dof_map
  use mesh, only: mesh_t, solid_nodes
  use boundary, only: boundary_t
  implicit none
  private
  public :: number_equations, dof_name

contains

  !> Number the free dofs of the nodes in use, node by node; slaves of constraints have none.
  subroutine number_equations(mesh, bc, eq, neq, ndof)
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(in) :: bc
    integer, allocatable, intent(out) :: eq(:, :) !! (3, nnode) equation number, or 0
    integer, intent(out) :: neq                   !! free dofs
    integer, intent(out) :: ndof                  !! dofs of nodes in use, not of rigid bodies
    logical, allocatable :: free(:, :), solid(:)
    integer :: i, j, m, n

    allocate (eq(3, mesh%nnode), free(3, mesh%nnode))
    free = bc%fixed == 0
    do m = 1, size(bc%motion)
      do j = 1, size(bc%motion(m)%node)
        where (bc%motion(m)%acts) free(:, bc%motion(m)%node(j)) = .false.
      end do
    end do
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

  !> `dof uy of node 3` for an equation number.
  function dof_name(eq, equation) result(name)
    integer, intent(in) :: eq(:, :) !! (3, nnode)
    integer, intent(in) :: equation
    character(:), allocatable :: name
    character(12) :: digits
    integer :: at(2)

    at = findloc2(eq, equation)
    write (digits, '(i0)') at(2)
    name = 'dof u'//'xyz' (max(at(1), 1):max(at(1), 1))//' of node '//trim(digits)
  end function dof_name

  !> Place of a value in a table; zero where it is not there.
  pure function findloc2(table, value) result(at)
    integer, intent(in) :: table(:, :), value
    integer :: at(2)
    integer :: j

    at = 0
    do j = 1, size(table, 2)
      if (any(table(:, j) == value)) then
        at = [maxloc(merge(1, 0, table(:, j) == value), 1), j]
        return
      end if
    end do
  end function findloc2

end module dof_map
