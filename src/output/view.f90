!> The mesh that a viewer shows, with exact geometry. Elements with splines and 27-node hexahedra
!! become Bezier cells; other elements become the cells that their topologies name.
!!
!! Each point of the view is a linear combination of nodes and control points. One sparse matrix
!! maps positions, displacements and fields at nodes to the points at every step.
module view
  use base_kinds, only: wp
  use base_text, only: to_text
  use element_type, only: cell_t, topology_t
  use mesh, only: block_t, block_cell
  use model, only: model_t
  use view_bezier, only: bezier_cell
  use view_points, only: point_list_t, add_point, finish_points
  implicit none
  private
  public :: view_t, build_view, map_field, map_surface_field

  integer, parameter :: VTK_BEZIER = 79         !! VTK_BEZIER_HEXAHEDRON
  integer, parameter :: VTK_BEZIER_FACE = 77    !! VTK_BEZIER_QUADRILATERAL

  type :: view_t
    type(point_list_t) :: point             !! combinations of nodes, and rational weights
    integer :: npoint = 0, ncell = 0
    logical :: has_bezier = .false.         !! some cells have degrees and weights
    integer, allocatable :: first(:)        !! (ncell+1) position in `conn` of a cell's first point
    integer, allocatable :: conn(:)         !! points of the cells, numbered from 1
    integer, allocatable :: vtk(:)          !! (ncell) VTK cell type
    integer, allocatable :: degree(:, :)    !! (3, ncell)
    integer, allocatable :: material(:)     !! (ncell) number in the deck; 0: a rigid body
    integer, allocatable :: body(:)         !! (ncell) body, in the order of the deck; 0: FEAP mesh
    integer, allocatable :: block(:)  !! (ncell) block of the mesh, which gives the element type
    integer, allocatable :: element(:)      !! (ncell) element number
    character(:), allocatable :: type_names !! such as '1 Q1N2.1, 2 Q1'
  end type view_t

  !> The cell of the elements of one class, which have the same shape functions.
  type :: class_t
    logical :: done = .false.
    integer :: vtk = 0, degree(3) = 1
    real(wp), allocatable :: coef(:, :) !! (nen, npoint) coefficients of the nodes in each point [-]
    real(wp), allocatable :: weight(:)      !! (npoint) rational weights [-]
  end type class_t

contains

  subroutine build_view(model, view)
    type(model_t), intent(in) :: model
    type(view_t), intent(out) :: view
    type(class_t), allocatable :: class(:)
    integer, allocatable :: longer(:)
    integer :: b, c, e, i, first, n, ncell

    ncell = sum(model%mesh%block%nelem)
    allocate (view%first(ncell + 1), view%vtk(ncell), view%degree(3, ncell), view%material(ncell))
    allocate (view%body(ncell), view%block(ncell), view%element(ncell), view%conn(64*ncell))
    view%first(1) = 1
    view%type_names = ''
    do b = 1, size(model%mesh%block)
      if (b > 1) view%type_names = view%type_names//', '
      view%type_names = view%type_names//to_text(b)//' '//trim(model%mesh%block(b)%name)
      associate (block => model%mesh%block(b))
        allocate (class(maxval([0, block%ibasis])))
        do e = 1, block%nelem
          c = block%ibasis(e)
          if (.not. class(c)%done) call make_class(block, e, class(c))
          view%ncell = view%ncell + 1
          n = size(class(c)%weight)
          first = view%first(view%ncell)
          if (first + n > size(view%conn)) then
            allocate (longer(2*(first + n)))
            longer(:first - 1) = view%conn(:first - 1)
            call move_alloc(longer, view%conn)
          end if
          do i = 1, n
            call add_point(view%point, block%conn(:, e), class(c)%coef(:, i), class(c)%weight(i), &
                           view%conn(first + i - 1))
          end do
          view%first(view%ncell + 1) = first + n
          view%vtk(view%ncell) = class(c)%vtk
          view%degree(:, view%ncell) = class(c)%degree
          view%material(view%ncell) = 0
          if (block%material > 0) then
            view%material(view%ncell) = model%material(block%material)%number
          end if
          view%body(view%ncell) = block%body
          view%block(view%ncell) = b
          view%element(view%ncell) = block%number(e)
          if (allocated(block%ext%w)) then ! each element has its own weights
            deallocate (class(c)%coef, class(c)%weight)
            class(c)%done = .false.
          end if
        end do
        deallocate (class)
      end associate
    end do
    view%conn = view%conn(:view%first(ncell + 1) - 1)
    call finish_points(view%point)
    view%npoint = view%point%npoint
    view%has_bezier = any(view%vtk == VTK_BEZIER .or. view%vtk == VTK_BEZIER_FACE)
  end subroutine build_view

  !> Express the points of an element as combinations of its nodes.
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

  !> Map values at the nodes to the points of the view.
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

  !> Map values at the nodes of surfaces to the points on them. All other points are given zero,
  !! because a combination of nodes on and below a surface would have the wrong sign at Bezier
  !! points inside a quadratic element, where the coefficient of the surface is negative.
  pure subroutine map_surface_field(view, on_surface, nodal, values)
    type(view_t), intent(in) :: view
    logical, intent(in) :: on_surface(:)  !! (nnode)
    real(wp), intent(in) :: nodal(:, :)   !! (n, nnode)
    real(wp), intent(out) :: values(:, :) !! (n, npoint)
    integer :: i

    call map_field(view, nodal, values)
    do i = 1, view%npoint
      associate (node => view%point%node(view%point%first(i):view%point%first(i + 1) - 1))
        if (.not. all(on_surface(node))) values(:, i) = 0.0_wp
      end associate
    end do
  end subroutine map_surface_field

end module view
