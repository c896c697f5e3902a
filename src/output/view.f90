!> The picture mesh: what a viewer is shown. Its geometry is exact for every element: spline and
!! quadratic elements become Bezier cells, the others the cell their topology names.
!!
!! Each point of the picture is a combination of nodes and control points, so that positions,
!! displacements and fields at nodes map by the same sparse matrix at every step.
module view
  use base_kinds, only: wp
  use model, only: model_t
  use mesh, only: block_t, block_cell
  use element_type, only: cell_t, topology_t
  use view_bezier, only: bezier_cell
  use view_points, only: point_list_t, add_point, finish_points
  implicit none
  private
  public :: view_t, build_view, map_field

  integer, parameter, public :: VTK_BEZIER = 79 !! VTK_BEZIER_HEXAHEDRON
  integer, parameter :: VTK_BEZIER_FACE = 77    !! VTK_BEZIER_QUADRILATERAL

  type :: view_t
    type(point_list_t) :: point             !! combinations of nodes, and rational weights
    integer :: npoint = 0, ncell = 0
    logical :: has_bezier = .false.         !! degrees and weights mean something
    integer, allocatable :: first(:)        !! (ncell+1) where a cell's points begin in `conn`
    integer, allocatable :: conn(:)         !! points of the cells, from 1
    integer, allocatable :: vtk(:)          !! (ncell) VTK cell type
    integer, allocatable :: degree(:, :)    !! (3, ncell)
    integer, allocatable :: material(:)     !! (ncell) the user's number; 0: a rigid body
    integer, allocatable :: body(:)         !! (ncell) PATCh, in deck order; 0: FEAP mesh
    integer, allocatable :: block(:)        !! (ncell) block of the mesh: tells the element type
    integer, allocatable :: element(:)      !! (ncell) element number
    character(:), allocatable :: type_names !! '1 Q1N2.1, 2 Q1'
  end type view_t

  !> Picture of one class of elements.
  type :: class_t
    logical :: done = .false.
    integer :: vtk = 0, degree(3) = 1
    real(wp), allocatable :: coef(:, :)     !! (nen, npoint)
    real(wp), allocatable :: weight(:)      !! (npoint)
  end type class_t

contains

  subroutine build_view(model, view)
    type(model_t), intent(in) :: model
    type(view_t), intent(out) :: view
    integer :: b, ncell
    character(12) :: digits

    ncell = 0
    view%type_names = ''
    do b = 1, size(model%mesh%block)
      ncell = ncell + model%mesh%block(b)%nelem
      write (digits, '(i0)') b
      if (b > 1) view%type_names = view%type_names//', '
      view%type_names = view%type_names//trim(digits)//' '//trim(model%mesh%block(b)%name)
    end do
    allocate (view%first(ncell + 1), view%vtk(ncell), view%degree(3, ncell), view%material(ncell))
    allocate (view%body(ncell), view%block(ncell), view%element(ncell), view%conn(64*ncell))
    view%first(1) = 1
    do b = 1, size(model%mesh%block)
      call add_block(model, b, view)
    end do
    view%conn = view%conn(:view%first(ncell + 1) - 1)
    call finish_points(view%point)
    view%npoint = view%point%npoint
    view%has_bezier = any(view%vtk == VTK_BEZIER .or. view%vtk == VTK_BEZIER_FACE)
  end subroutine build_view

  !> Cells of one block.
  subroutine add_block(model, b, view)
    type(model_t), intent(in) :: model
    integer, intent(in) :: b
    type(view_t), intent(inout) :: view
    type(class_t), allocatable :: class(:)
    integer :: e, c

    associate (block => model%mesh%block(b))
      allocate (class(maxval([0, block%ibasis])))
      do e = 1, block%nelem
        c = block%ibasis(e)
        if (.not. class(c)%done) call make_class(block, e, class(c))
        view%ncell = view%ncell + 1
        call add_cell(block%conn(:, e), class(c), view)
        view%material(view%ncell) = 0 ! of rigid bodies
        if (block%material > 0) view%material(view%ncell) = model%material(block%material)%number
        view%body(view%ncell) = block%body
        view%block(view%ncell) = b
        view%element(view%ncell) = block%number(e)
        if (allocated(block%ext%w)) then ! a class of its own: forget it
          deallocate (class(c)%coef, class(c)%weight)
          class(c)%done = .false.
        end if
      end do
    end associate
  end subroutine add_block

  !> Points of an element as combinations of its nodes.
  subroutine make_class(block, e, class)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    type(class_t), intent(inout) :: class
    type(cell_t) :: cell
    type(topology_t) :: topology
    integer :: i

    call block_cell(block, e, cell)
    call block%row%topology(cell, topology)
    class%vtk = topology%vtk
    class%degree = cell%degree
    class%done = .true.
    if (topology%vtk == VTK_BEZIER .or. topology%vtk == VTK_BEZIER_FACE) then
      call bezier_cell(block%row, cell, block%nen, class%degree, class%coef, class%weight)
    else
      allocate (class%coef(block%nen, size(topology%vtk_node)), source=0.0_wp)
      allocate (class%weight(size(topology%vtk_node)), source=1.0_wp)
      do i = 1, size(topology%vtk_node)
        class%coef(topology%vtk_node(i), i) = 1.0_wp
      end do
    end if
  end subroutine make_class

  subroutine add_cell(node, class, view)
    integer, intent(in) :: node(:)      !! (nen)
    type(class_t), intent(in) :: class
    type(view_t), intent(inout) :: view
    integer, allocatable :: bigger(:)
    integer :: i, first, n

    n = size(class%weight)
    first = view%first(view%ncell)
    if (first + n > size(view%conn)) then
      allocate (bigger(2*(first + n)))
      bigger(:first - 1) = view%conn(:first - 1)
      call move_alloc(bigger, view%conn)
    end if
    do i = 1, n
      call add_point(view%point, node, class%coef(:, i), class%weight(i), view%conn(first + i - 1))
    end do
    view%first(view%ncell + 1) = first + n
    view%vtk(view%ncell) = class%vtk
    view%degree(:, view%ncell) = class%degree
  end subroutine add_cell

  !> Values at nodes to values at the points of the picture.
  pure subroutine map_field(view, nodal, values)
    type(view_t), intent(in) :: view
    real(wp), intent(in) :: nodal(:, :)   !! (n, nnode)
    real(wp), intent(out) :: values(:, :) !! (n, npoint)
    integer :: i, k

    do i = 1, view%npoint
      values(:, i) = 0.0_wp
      do k = view%point%first(i), view%point%first(i + 1) - 1
        values(:, i) = values(:, i) + view%point%coef(k)*nodal(:, view%point%node(k))
      end do
    end do
  end subroutine map_field

end module view
