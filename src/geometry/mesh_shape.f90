!> Shapes that elements of a mesh file can have: those in the table of elements, and others that
!! Gmsh knows.
module mesh_shape
  use base_sort, only: sort_index, unique
  use base_text, only: to_text
  use element_table, only: load_elements
  use element_type, only: element_t, cell_t, topology_t
  implicit none
  private
  public :: shape_t, load_shapes, gmsh_shape, solid_shape, choose_row, shape_hint, node_counts

  type :: shape_t
    character(12) :: name = ''       !! point, line, triangle, quadrangle or topology%shape
    integer :: gmsh = 0              !! element type in Gmsh; 0: there is none
    integer :: dim = 0               !! dimension; 3 for elements of a body
    integer :: nen = 0               !! number of nodes
    integer :: ncorner = 0           !! number of corners; a surface element lists them first
    !> Row of the table of elements; its name is empty if there is no row for this shape.
    type(element_t) :: row
    type(cell_t) :: cell             !! degrees of the elements
    type(topology_t) :: topology     !! faces and nodes of the elements
  end type shape_t

  !> Gmsh types without a row in the table of elements (Gmsh reference manual, section MSH file
  !! format). Points, curves and surfaces need no row. Two solids are listed so that an error
  !! message can name them as long as they have no row.
  character(10), parameter :: OTHER_NAME(10) = [ &
                              'point     ', 'line      ', 'triangle  ', 'quadrangle', &
                              'line      ', 'triangle  ', 'quadrangle', 'quadrangle', &
                              'wedge     ', 'hexahedron']
  !> Gmsh type, dimension, number of nodes and number of corners of each of these shapes.
  integer, parameter :: OTHER(4, 10) = reshape([15, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 2, 4, 4, &
                                                8, 1, 3, 2, 9, 2, 6, 3, 10, 2, 9, 4, 16, 2, 8, 4, &
                                                13, 3, 18, 6, 17, 3, 20, 8], [4, 10])

contains

  !> Load all shapes: rows in the order of their Gmsh types, then the others. If several rows have
  !! the same shape and number of nodes, only the first one in the table is used.
  subroutine load_shapes(shapes)
    type(shape_t), allocatable, intent(out) :: shapes(:)
    type(element_t), allocatable :: table(:)
    type(shape_t) :: new
    integer, allocatable :: order(:)
    integer :: i, n

    call load_elements(table)
    table = pack(table, table%deck_nodes > 0)
    allocate (shapes(size(table) + size(OTHER, 2)), order(size(table)))
    call sort_index([(gmsh_type(table(i)), i=1, size(table))], order)
    n = 0
    do i = 1, size(table)
      call describe_row(table(order(i)), new)
      if (any(shapes(:n)%name == new%name .and. shapes(:n)%nen == new%nen)) cycle
      n = n + 1
      shapes(n) = new
    end do
    do i = 1, size(OTHER, 2)
      if (any(shapes(:n)%gmsh == OTHER(1, i))) cycle
      n = n + 1
      shapes(n)%name = OTHER_NAME(i)
      shapes(n)%gmsh = OTHER(1, i)
      shapes(n)%dim = OTHER(2, i)
      shapes(n)%nen = OTHER(3, i)
      shapes(n)%ncorner = OTHER(4, i)
    end do
    shapes = shapes(:n)
  end subroutine load_shapes

  !> Gmsh type of a row, by which rows are sorted; rows without a Gmsh type come last.
  integer function gmsh_type(row)
    type(element_t), intent(in) :: row
    type(shape_t) :: new

    call describe_row(row, new)
    gmsh_type = merge(new%gmsh, huge(1), new%gmsh > 0)
  end function gmsh_type

  !> Describe the shape of the elements of a row.
  subroutine describe_row(row, new)
    type(element_t), intent(in) :: row
    type(shape_t), intent(out) :: new

    new%row = row
    new%cell%degree = row%degree
    call row%topology(new%cell, new%topology)
    new%name = new%topology%shape
    new%gmsh = new%topology%gmsh
    new%dim = 3
    new%nen = row%deck_nodes
    new%ncorner = size(new%topology%corner)
  end subroutine describe_row

  !> Index of the shape with a given Gmsh type; 0 if there is none.
  pure integer function gmsh_shape(shapes, gmsh) result(s)
    type(shape_t), intent(in) :: shapes(:)
    integer, intent(in) :: gmsh

    s = findloc(shapes%gmsh, gmsh, 1)
    if (gmsh < 1) s = 0
  end function gmsh_shape

  !> Index of the solid shape with `nen` nodes; 0 if there is none.
  pure integer function solid_shape(shapes, nen) result(s)
    type(shape_t), intent(in) :: shapes(:)
    integer, intent(in) :: nen

    s = findloc(shapes%dim == 3 .and. shapes%nen == nen, .true., 1)
  end function solid_shape

  !> Use the row `name`, which TYPE of a MESH selects, for all elements that have the shape and the
  !! number of nodes of this row.
  subroutine choose_row(shapes, name)
    type(shape_t), intent(inout) :: shapes(:)
    character(*), intent(in) :: name
    type(element_t), allocatable :: table(:)
    type(shape_t) :: new
    integer :: r, s

    call load_elements(table)
    do r = 1, size(table)
      if (table(r)%name /= name .or. table(r)%deck_nodes == 0) cycle
      call describe_row(table(r), new)
      do s = 1, size(shapes)
        if (shapes(s)%name == new%name .and. shapes(s)%nen == new%nen) shapes(s)%row = table(r)
      end do
    end do
  end subroutine choose_row

  !> A hint that lists the solid elements of the program.
  pure function shape_hint(shapes) result(hint)
    type(shape_t), intent(in) :: shapes(:)
    character(:), allocatable :: hint
    integer :: s

    hint = 'known solid elements:'
    do s = 1, size(shapes)
      if (shapes(s)%row%name == '') cycle
      if (index(hint, 'node') > 0) hint = hint//','
      hint = hint//' '//to_text(shapes(s)%nen)//'-node '//trim(shapes(s)%name)
    end do
  end function shape_hint

  !> Numbers of nodes as text for a hint, such as `4, 5 or 8`; zeros in the list are left out.
  pure function node_counts(list) result(text)
    integer, intent(in) :: list(:)
    character(:), allocatable :: text
    integer, allocatable :: n(:)
    integer :: i

    allocate (n, source=unique(pack(list, list > 0)))
    text = ''
    do i = 1, size(n)
      if (i > 1) text = text//trim(merge(' or', ',  ', i == size(n)))//' '
      text = text//to_text(n(i))
    end do
  end function node_counts

end module mesh_shape
