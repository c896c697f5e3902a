!> A mesh as given in its file: numbered nodes, elements of several shapes, named groups.
module mesh_file
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp, i8
  use base_sort, only: sort, sort_index, find
  use base_text, only: to_text
  use format_text, only: text_t, fail_in_file
  use mesh_shape, only: shape_t, load_shapes
  implicit none
  private
  public :: mesh_file_t, start_mesh, add_element, add_member, sort_nodes, mark_solids

  !> A physical group; without a name, its number is used as the name. Numbers are given separately
  !! in each dimension, so unnamed groups with the same number are different groups.
  type, public :: file_group_t
    integer :: dim = 0
    integer :: tag = 0
    logical :: named = .false.
    character(:), allocatable :: name
  end type file_group_t

  !> The mesh of a file. The nodes of element e are node(first(e):first(e+1)-1). They are the node
  !! numbers of the file until sort_nodes replaces them by indices into x.
  type :: mesh_file_t
    integer :: nnode = 0, nelem = 0
    integer, allocatable :: number(:)    !! (nnode) node numbers of the file; ascending once sorted
    real(wp), allocatable :: x(:, :)     !! (3, nnode) [L]
    integer, allocatable :: node_spot(:) !! (nnode) position in the text
    type(shape_t), allocatable :: shapes(:) !! all known shapes
    integer, allocatable :: shape(:)     !! (>= nelem) index into `shapes`
    integer, allocatable :: first(:)     !! (>= nelem+1)
    integer, allocatable :: node(:)
    integer, allocatable :: label(:)     !! (>= nelem) number of the element in the file
    integer, allocatable :: spot(:)      !! (>= nelem) position in the text
    logical, allocatable :: solid(:)     !! (nelem) a solid element that repeats no earlier one
    type(file_group_t), allocatable :: group(:)
    integer :: nmember = 0
    integer, allocatable :: member(:, :) !! (2, >= nmember) element and group
    logical :: repeats = .false.         !! an element is listed once for each of its groups
  end type mesh_file_t

contains

  !> Make an empty mesh.
  subroutine start_mesh(file)
    type(mesh_file_t), intent(out) :: file

    call load_shapes(file%shapes)
    allocate (file%member(2, 0))
    file%first = [1]
  end subroutine start_mesh

  !> Append an element.
  subroutine add_element(file, shape, label, node, spot)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: shape   !! index into file%shapes
    integer, intent(in) :: label   !! number of the element in the file
    integer, intent(in) :: node(:) !! numbers of its nodes in the file
    integer, intent(in) :: spot    !! position in the text
    integer :: e, last

    e = file%nelem + 1
    last = file%first(e) + size(node) - 1
    call grow(file%shape, e)
    call grow(file%label, e)
    call grow(file%spot, e)
    call grow(file%first, e + 1)
    call grow(file%node, last)
    file%nelem = e
    file%shape(e) = shape
    file%label(e) = label
    file%spot(e) = spot
    file%node(file%first(e):last) = node
    file%first(e + 1) = last + 1
  end subroutine add_element

  !> Put the last element into the physical group (dim, |tag|), and create this group if it is new.
  !! Gmsh gives a negative tag to an entity with reversed orientation. Tag 0 means no group.
  subroutine add_member(file, dim, tag)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: dim, tag
    type(file_group_t), allocatable :: longer(:)
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
    n = file%nmember + 1
    file%nmember = n
    call grow(file%member, 2, n)
    file%member(:, n) = [file%nelem, g]
  end subroutine add_member

  !> Sort the nodes by their numbers, and replace the node numbers of the elements by indices. Node
  !! numbers must be unique, and the nodes of elements must exist.
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
                        'give each node its own number')
      return
    end do
    do e = 1, file%nelem
      do i = file%first(e), file%first(e + 1) - 1
        n = find(file%number, file%node(i))
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

  !> Mark the elements of the body. Gmsh 2.2 repeats an element for each of its groups; only the
  !! first one is marked, and it becomes a member of all these groups. In other formats, two
  !! elements must not have the same nodes.
  subroutine mark_solids(file, text, error)
    type(mesh_file_t), intent(inout) :: file
    type(text_t), intent(inout) :: text
    type(error_t), allocatable, intent(out) :: error
    integer(i8), allocatable :: key(:)
    integer, allocatable :: order(:), first(:)
    integer :: e, i, j

    call check_numbers(file, text, error)
    if (allocated(error)) return
    file%solid = [(file%shapes(file%shape(e))%dim == 3, e=1, file%nelem)]
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
        if (file%shape(order(j)) == file%shape(e) .and. file%solid(order(j))) then
          if (all(sorted_nodes(file, order(j)) == sorted_nodes(file, e))) then
            if (.not. file%repeats) then
              text%at = maxval(file%spot([order(j), e]))
              call fail_in_file(text, 'element '//to_text(file%label(max(order(j), e))) &
                                //' has the same nodes as element ' &
                                //to_text(file%label(min(order(j), e))), error, &
                                'remove one of them: two elements of a body must not overlap')
              return
            end if
            first(e) = first(order(j))
            file%solid(e) = .false.
          end if
        end if
        j = j - 1
      end do
    end do
    file%member(1, :file%nmember) = first(file%member(1, :file%nmember))
  end subroutine mark_solids

  !> Fail if two elements have the same number, unless the second one repeats the first one.
  subroutine check_numbers(file, text, error)
    type(mesh_file_t), intent(in) :: file
    type(text_t), intent(inout) :: text
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: order(:)
    integer :: a, b, i

    allocate (order(file%nelem))
    call sort_index(file%label(:file%nelem), order)
    do i = 2, file%nelem
      a = order(i - 1)
      b = order(i)
      if (file%label(a) /= file%label(b)) cycle
      if (file%repeats .and. file%shape(a) == file%shape(b)) then
        if (all(sorted_nodes(file, a) == sorted_nodes(file, b))) cycle
      end if
      text%at = maxval(file%spot([a, b]))
      call fail_in_file(text, 'element '//to_text(file%label(a))//' is defined twice', error, &
                        'give each element its own number')
      return
    end do
  end subroutine check_numbers

  !> Nodes of an element, in ascending order.
  pure function sorted_nodes(file, e) result(node)
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: e
    integer :: node(file%first(e + 1) - file%first(e))

    node = file%node(file%first(e):file%first(e + 1) - 1)
    call sort(node)
  end function sorted_nodes

end module mesh_file
