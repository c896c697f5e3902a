!> A mesh as a file has it: nodes with their numbers, elements of several shapes, named groups.
module mesh_file
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use base_sort, only: sort, sort_index, find
  use base_text, only: to_text
  use format_text, only: text_t, fail_in_file
  implicit none
  private
  public :: mesh_file_t, shape_t, SHAPE, find_shape, reserve, add_element, add_member, sort_nodes, &
            mark_solids

  !> What an element of a file is: its name, its number of nodes and the name of our element.
  type :: shape_t
    character(12) :: name
    integer :: gmsh                  !! type of Gmsh
    integer :: dim, nen
    character(8) :: row              !! of the table of elements; blank: none, or not of a volume
  end type shape_t

  type(shape_t), parameter :: SHAPE(16) = [ &
                              shape_t('point', 15, 0, 1, ''), shape_t('line', 1, 1, 2, ''), &
                              shape_t('triangle', 2, 2, 3, ''), &
                              shape_t('quadrangle', 3, 2, 4, ''), &
                              shape_t('tetrahedron', 4, 3, 4, 'TET4'), &
                              shape_t('hexahedron', 5, 3, 8, 'Q1'), &
                              shape_t('wedge', 6, 3, 6, 'WEDGE6'), &
                              shape_t('pyramid', 7, 3, 5, 'PYRAMID5'), &
                              shape_t('line', 8, 1, 3, ''), shape_t('triangle', 9, 2, 6, ''), &
                              shape_t('quadrangle', 10, 2, 9, ''), &
                              shape_t('tetrahedron', 11, 3, 10, 'TET10'), &
                              shape_t('hexahedron', 12, 3, 27, 'Q2'), &
                              shape_t('quadrangle', 16, 2, 8, ''), &
                              shape_t('hexahedron', 17, 3, 20, ''), &
                              shape_t('wedge', 13, 3, 18, '')]

  !> A physical group. Unnamed ones are called by their number.
  type, public :: file_group_t
    integer :: dim = 0
    integer :: tag = 0
    character(:), allocatable :: name
  end type file_group_t

  !> What was read. Nodes of element e stand in node(first(e):first(e+1)-1), as numbers of the file
  !! until sort_nodes makes them positions in x.
  type :: mesh_file_t
    integer :: nnode = 0, nelem = 0
    integer, allocatable :: number(:)    !! (nnode) of the nodes in the file; rising once sorted
    real(wp), allocatable :: x(:, :)     !! (3, nnode) [L]
    integer, allocatable :: node_spot(:) !! (nnode) place in the text
    integer, allocatable :: shape(:)     !! (>= nelem) position in SHAPE
    integer, allocatable :: first(:)     !! (>= nelem+1)
    integer, allocatable :: node(:)
    integer, allocatable :: label(:)     !! (>= nelem) number of the element in the file
    integer, allocatable :: spot(:)      !! (>= nelem) place in the text
    logical, allocatable :: solid(:)     !! (nelem) of the volume, not said before
    type(file_group_t), allocatable :: group(:)
    integer :: nmember = 0
    integer, allocatable :: member(:, :) !! (2, >= nmember) element and group
  end type mesh_file_t

contains

  !> Position in SHAPE of a type of Gmsh; 0: unknown.
  pure integer function find_shape(gmsh) result(s)
    integer, intent(in) :: gmsh

    do s = size(SHAPE), 1, -1
      if (SHAPE(s)%gmsh == gmsh) return
    end do
  end function find_shape

  !> Room for some elements.
  subroutine reserve(file, nelem)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: nelem

    allocate (file%shape(max(nelem, 8)), file%label(max(nelem, 8)), file%spot(max(nelem, 8)))
    allocate (file%first(max(nelem, 8) + 1), file%node(4*max(nelem, 8)))
    allocate (file%member(2, max(nelem, 8)))
    file%first(1) = 1
  end subroutine reserve

  !> One more element; its nodes by their numbers.
  subroutine add_element(file, kind, label, node, spot)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: kind, label, node(:), spot
    integer :: e, last

    if (.not. allocated(file%shape)) call reserve(file, 0)
    if (file%nelem == size(file%shape)) then
      file%shape = [file%shape, file%shape]
      file%label = [file%label, file%label]
      file%spot = [file%spot, file%spot]
      file%first = [file%first, file%first]
    end if
    e = file%nelem + 1
    last = file%first(e) + size(node) - 1
    do while (last > size(file%node))
      file%node = [file%node, file%node]
    end do
    file%nelem = e
    file%shape(e) = kind
    file%label(e) = label
    file%spot(e) = spot
    file%node(file%first(e):last) = node
    file%first(e + 1) = last + 1
  end subroutine add_element

  !> Element e belongs to the physical group (dim, tag), which is made where it is new.
  subroutine add_member(file, e, dim, tag)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: e, dim, tag
    type(file_group_t), allocatable :: longer(:)
    integer, allocatable :: members(:, :)
    integer :: g, n

    if (tag == 0) return
    n = 0
    if (allocated(file%group)) n = size(file%group)
    do g = 1, n
      if (file%group(g)%dim == dim .and. file%group(g)%tag == abs(tag)) exit
    end do
    if (g > n) then
      allocate (longer(n + 1))
      if (n > 0) longer(:n) = file%group
      longer(g)%dim = dim
      longer(g)%tag = abs(tag)
      longer(g)%name = to_text(abs(tag))
      call move_alloc(longer, file%group)
    end if
    if (file%nmember == size(file%member, 2)) then
      allocate (members(2, 2*file%nmember))
      members(:, :file%nmember) = file%member
      call move_alloc(members, file%member)
    end if
    file%nmember = file%nmember + 1
    file%member(:, file%nmember) = [e, g]
  end subroutine add_member

  !> Nodes in the order of their numbers; elements then name positions. Node numbers are unique and
  !! elements have nodes that exist.
  subroutine sort_nodes(file, text, error)
    type(mesh_file_t), intent(inout) :: file
    type(text_t), intent(inout) :: text
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: order(:)
    integer :: e, i, n

    allocate (order(file%nnode))
    call sort_index(file%number, order)
    file%number = file%number(order)
    file%x = file%x(:, order)
    file%node_spot = file%node_spot(order)
    do n = 2, file%nnode
      if (file%number(n) > file%number(n - 1)) cycle
      text%at = maxval(file%node_spot(n - 1:n))
      call fail_in_file(text, 'node '//to_text(file%number(n))//' is defined twice', error, &
                    'every node has a number of its own')
      return
    end do
    do e = 1, file%nelem
      do i = file%first(e), file%first(e + 1) - 1
        n = node_at(file, file%node(i))
        if (n == 0) then
          text%at = file%spot(e)
          call fail_in_file(text, 'element '//to_text(file%label(e))//' refers to node ' &
                        //to_text(file%node(i))//', which the file does not define', error)
          return
        end if
        file%node(i) = n
      end do
    end do
  end subroutine sort_nodes

  !> Which elements are the body. In Gmsh 2.2 an element of several groups stands once for each: the
  !! first one counts and belongs to all.
  subroutine mark_solids(file)
    type(mesh_file_t), intent(inout) :: file
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), first(:)
    integer :: e, i, j

    file%solid = [(SHAPE(file%shape(e))%dim == 3, e=1, file%nelem)]
    allocate (key(file%nelem), order(file%nelem))
    do e = 1, file%nelem
      key(e) = sum(int(file%node(file%first(e):file%first(e + 1) - 1), i8)**2)
    end do
    call sort_index(key, order)
    first = [(e, e=1, file%nelem)]
    do i = 2, file%nelem
      e = order(i)
      j = i - 1
      do while (j > 0 .and. file%solid(e))
        if (key(order(j)) /= key(e)) exit
        if (same_nodes(file, order(j), e)) then
          first(e) = first(order(j))
          file%solid(e) = .false.
        end if
        j = j - 1
      end do
    end do
    file%member(1, :file%nmember) = first(file%member(1, :file%nmember))
  end subroutine mark_solids

  pure logical function same_nodes(file, a, b)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: a, b
    integer :: na(27), nb(27), n

    same_nodes = file%shape(a) == file%shape(b) .and. file%solid(a)
    if (.not. same_nodes) return
    n = SHAPE(file%shape(a))%nen
    na(:n) = file%node(file%first(a):file%first(a + 1) - 1)
    nb(:n) = file%node(file%first(b):file%first(b + 1) - 1)
    call sort(na(:n))
    call sort(nb(:n))
    same_nodes = all(na(:n) == nb(:n))
  end function same_nodes

  !> Position of a node by its number; 0: there is none.
  pure integer function node_at(file, number) result(n)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: number

    n = find(file%number, number)
  end function node_at

end module mesh_file
