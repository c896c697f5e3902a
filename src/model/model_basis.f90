!> Shape functions of every block at its integration points, computed once for each distinct class.
module model_basis
  use base_kinds, only: wp
  use base_sort, only: sort_index
  use basis_type, only: basis_t
  use element_type, only: cell_t
  use mesh, only: mesh_t, block_t, block_cell
  implicit none
  private
  public :: tabulate_basis, tabulate_block, tabulate_points

  !> Largest number of operators for which classes are sought; its cube must not overflow an
  !! integer. If there are more operators, every element is a class of its own.
  integer, parameter :: MOST_OPERATORS = 1290

contains

  !> Set rule, basis and ibasis of all blocks that have none yet.
  subroutine tabulate_basis(mesh)
    type(mesh_t), intent(inout) :: mesh
    integer :: b

    do b = 1, size(mesh%block)
      if (.not. allocated(mesh%block(b)%ibasis)) call tabulate_block(mesh%block(b))
    end do
  end subroutine tabulate_basis

  !> Find and tabulate the classes of one block. Elements share a class if their extraction
  !! operators are the same and they have no weights; a rational element is a class of its own.
  subroutine tabulate_block(block)
    type(block_t), intent(inout) :: block
    type(cell_t) :: cell
    integer :: class
    integer, allocatable :: first(:)

    allocate (block%ibasis(block%nelem))
    call find_classes(block, block%ibasis, first)
    if (block%rule%nq == 0) then
      call block_cell(block, 1, cell)
      call block%row%rule(cell, 0, 0, block%rule)
    end if
    allocate (block%basis(size(first)))
    do class = 1, size(first)
      call tabulate_points(block, first(class), block%rule%xi, block%rule%wgt, block%basis(class))
    end do
  end subroutine tabulate_block

  !> Find the class of each element and the first element of each class.
  subroutine find_classes(block, class, first)
    type(block_t), intent(in) :: block
    integer, intent(out) :: class(:)             !! (nelem)
    integer, allocatable, intent(out) :: first(:) !! (nclass)
    integer, allocatable :: key(:), order(:)
    integer :: e, n, nop

    nop = 0
    if (allocated(block%ext%op)) nop = size(block%ext%op) + 1
    if (allocated(block%ext%w) .or. nop > MOST_OPERATORS) then
      class = [(e, e=1, block%nelem)]
      first = class
      return
    end if
    if (.not. (allocated(block%ext%op) .or. allocated(block%ext%surface))) then
      class = 1
      first = [1]
      return
    end if
    allocate (key(block%nelem), order(block%nelem), first(block%nelem))
    if (allocated(block%ext%surface)) then
      key = block%ext%isurface
    else
      key = block%ext%iop(1, :) + nop*(block%ext%iop(2, :) + nop*block%ext%iop(3, :))
    end if
    call sort_index(key, order)
    n = 0
    do e = 1, block%nelem
      if (e == 1) then
        n = 1
        first(n) = order(e)
      else if (key(order(e)) /= key(order(e - 1))) then
        n = n + 1
        first(n) = order(e)
      end if
      class(order(e)) = n
    end do
    first = first(:n)
  end subroutine find_classes

  !> Tabulate functions and modes of one element at arbitrary points.
  subroutine tabulate_points(block, e, xi, wgt, basis)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    real(wp), intent(in) :: xi(:, :)  !! (3, nq)
    real(wp), intent(in) :: wgt(:)    !! (nq)
    type(basis_t), intent(out) :: basis
    type(cell_t) :: cell
    real(wp), allocatable :: shp(:)
    integer :: q

    call block_cell(block, e, cell)
    basis%nen = block%nen
    basis%nq = size(wgt)
    basis%nmode = block%row%nmode
    allocate (basis%shp(basis%nen, basis%nq), basis%dshp(3, basis%nen, basis%nq))
    allocate (basis%mode(3, basis%nmode, basis%nq))
    basis%wgt = wgt
    do q = 1, basis%nq
      call block%row%functions(cell, xi(:, q), basis%shp(:, q), basis%dshp(:, :, q))
      if (basis%nmode > 0) call block%row%modes(xi(:, q), basis%mode(:, :, q))
    end do
    allocate (basis%dshp0(3, basis%nen), shp(basis%nen))
    call block%row%functions(cell, [0.0_wp, 0.0_wp, 0.0_wp], shp, basis%dshp0)
  end subroutine tabulate_points

end module model_basis
