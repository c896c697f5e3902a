!> Gmsh meshes: MSH 2.2 and 4.1 in ASCII.
!!
!! The sections $MeshFormat, $PhysicalNames, $Entities, $Nodes and $Elements are read; others are
!! skipped, except that $PartitionedEntities is an error. Physical groups become named groups;
!! version 2.2 repeats an element for each of its groups. The topology of a solid shape
!! (mesh_shape) contains its Gmsh type and the order in which Gmsh numbers its nodes.
!! Source: Geuzaine and Remacle 2009; Gmsh reference manual, section MSH file format
module format_gmsh
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp
  use base_text, only: to_text, quoted
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_integers, next_count, &
                         next_reals
  use mesh_file, only: mesh_file_t, start_mesh, add_element, add_member, sort_nodes
  use mesh_shape, only: gmsh_shape, shape_hint
  implicit none
  private
  public :: read_gmsh

contains

  !> Read the whole file; the current position must be its beginning.
  subroutine read_gmsh(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    type(mesh_file_t) :: names
    integer, allocatable :: entity(:, :)
    character(:), allocatable :: section, word
    integer :: g, i
    logical :: is_new

    call start_mesh(file)
    allocate (names%group(0), entity(3, 0))
    is_new = .false.
    do
      call next_word(text, section)
      if (len(section) == 0) exit
      select case (section)
      case ('$MeshFormat')
        call read_format(text, is_new, error)
        file%repeats = .not. is_new
      case ('$PhysicalNames')
        call read_names(text, names, error)
      case ('$Entities')
        call read_entities(text, entity, error)
      case ('$Nodes')
        call read_nodes(text, is_new, file, error)
      case ('$Elements')
        call read_elements(text, is_new, entity, file, error)
      case default
        ! a section without mesh data
        i = index(text%all(text%at:), '$End'//section(2:))
        if (section(1:1) /= '$') then
          call fail_in_file(text, 'expected a section, found '//quoted(section), error, &
                            'sections of a Gmsh file begin with $')
        else if (section == '$PartitionedEntities') then
          call fail_in_file(text, 'the mesh is partitioned', error, &
                            'save it from Gmsh without partitions')
        else if (i == 0) then
          call fail_in_file(text, 'section '//section//' has no $End'//section(2:), error)
        else
          text%at = text%at + i - 1
        end if
      end select
      if (allocated(error)) return
      call next_word(text, word)
      if (word == '$End'//section(2:)) cycle
      if (len(word) == 0) then
        call fail_in_file(text, 'expected $End'//section(2:)//', found the end of the file', error)
      else
        call fail_in_file(text, 'expected $End'//section(2:)//', found '//quoted(word), error, &
                          'check the counts of the section against its contents')
      end if
      return
    end do
    if (.not. allocated(file%number)) then
      call fail_in_file(text, 'the file has no section $Nodes', error)
    else if (file%nelem == 0) then
      call fail_in_file(text, 'the file has no elements', error)
    else
      call sort_nodes(file, text, error)
    end if
    if (allocated(error) .or. .not. allocated(file%group)) return
    do i = 1, size(names%group)
      do g = 1, size(file%group)
        if (file%group(g)%dim /= names%group(i)%dim) cycle
        if (file%group(g)%tag /= names%group(i)%tag) cycle
        file%group(g)%name = names%group(i)%name
        file%group(g)%named = .true.
      end do
    end do
  end subroutine read_gmsh

  !> Read the format, which must be version 2.2 or 4.1 in ASCII.
  subroutine read_format(text, is_new, error)
    type(text_t), intent(inout) :: text
    logical, intent(out) :: is_new
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: version
    integer :: binary, size_of

    is_new = .false.
    call next_word(text, version)
    if (all(version /= ['2.2', '4.1'])) then
      call fail_in_file(text, 'version '//quoted(version)//' of Gmsh files is not supported', &
                        error, 'write version 2.2 or 4.1: gmsh -save -format msh41 ...')
      return
    end if
    is_new = version == '4.1'
    call next_integer(text, 'the type of the file', binary, error)
    if (allocated(error)) return
    if (binary /= 0) then
      call fail_in_file(text, 'the file is binary', error, 'write it in ASCII: Mesh.Binary = 0')
      return
    end if
    call next_integer(text, 'the size of reals', size_of, error)
  end subroutine read_format

  !> Read the dimension, tag and quoted name of each physical group. They are stored in `names`,
  !! separately from the groups to which elements of the file belong.
  subroutine read_names(text, names, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(out) :: names
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n, first, last

    call next_count(text, 'the number of physical groups', n, error)
    if (allocated(error)) return
    allocate (names%group(n))
    do i = 1, n
      call next_integer(text, 'the dimension of a physical group', names%group(i)%dim, error)
      if (allocated(error)) return
      call next_integer(text, 'the tag of a physical group', names%group(i)%tag, error)
      if (allocated(error)) return
      first = index(text%all(text%at:), '"') + text%at
      last = 0
      if (first > text%at) last = index(text%all(first:), '"') + first - 2
      if (last < first) then
        call fail_in_file(text, 'expected the name of a physical group in quotes', error)
        return
      end if
      names%group(i)%name = trim(adjustl(text%all(first:last)))
      text%at = last + 2
    end do
  end subroutine read_names

  !> Read the points, curves, surfaces and volumes of version 4.1. Each has a tag, a position or
  !! bounding box, physical groups and (except for points) a boundary.
  subroutine read_entities(text, entity, error)
    type(text_t), intent(inout) :: text
    integer, allocatable, intent(out) :: entity(:, :) !! (3, n) dimension, tag, physical group
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: box(6)
    integer :: count(0:3), d, e, i, m, n, part, tag, value

    allocate (entity(3, 16))
    m = 0
    do d = 0, 3
      call next_count(text, 'the number of entities', count(d), error)
      if (allocated(error)) return
    end do
    do d = 0, 3
      do e = 1, count(d)
        call next_integer(text, 'the tag of an entity', tag, error)
        if (allocated(error)) return
        call next_reals(text, 'the bounding box of an entity', box(:merge(3, 6, d == 0)), error)
        do part = 1, merge(1, 2, d == 0)
          if (.not. allocated(error)) call next_count(text, 'the number of tags', n, error)
          if (allocated(error)) return
          do i = 1, n
            call next_integer(text, 'a tag', value, error)
            if (allocated(error)) return
            if (part == 2) cycle
            m = m + 1
            call grow(entity, 3, m)
            entity(:, m) = [d, tag, value]
          end do
        end do
      end do
    end do
    entity = entity(:, :m)
  end subroutine read_entities

  !> Read the elements of all shapes. In version 2.2, each record has a number, a type, tags (the
  !! first is the physical group) and nodes; version 4.1 has blocks, each with the elements of one
  !! type on one entity.
  subroutine read_elements(text, is_new, entity, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    integer, intent(in) :: entity(:, :) !! (3, n) dimension, tag, physical group
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: b, i, j, n, nblock, total, head(3), skip(2), before, label, ntag, tag, group

    nblock = 1
    if (is_new) call next_count(text, 'the number of blocks of elements', nblock, error)
    if (.not. allocated(error)) call next_count(text, 'the number of elements', total, error)
    if (is_new .and. .not. allocated(error)) then
      call next_integers(text, 'the range of element numbers', skip, error)
    end if
    before = file%nelem
    do b = 1, nblock
      if (allocated(error)) return
      n = total
      if (is_new) then
        call next_integers(text, 'the dimension, tag or type of a block of elements', head, error)
        if (.not. allocated(error)) call check_type(text, head(3), file, error)
        if (.not. allocated(error)) call next_count(text, 'the number of elements', n, error)
      end if
      do i = 1, n
        if (allocated(error)) return
        call next_integer(text, 'an element number', label, error)
        if (is_new) then
          if (.not. allocated(error)) call read_element(text, head(3), label, file, error)
          if (allocated(error)) return
          do j = 1, size(entity, 2)
            if (all(entity(:2, j) == head(:2))) call add_member(file, head(1), entity(3, j))
          end do
        else
          group = 0
          if (.not. allocated(error)) call next_integer(text, 'an element type', head(3), error)
          if (.not. allocated(error)) call check_type(text, head(3), file, error)
          if (.not. allocated(error)) call next_count(text, 'the number of tags', ntag, error)
          do j = 1, ntag
            if (allocated(error)) return
            call next_integer(text, 'a tag', tag, error)
            if (j == 1) group = tag
          end do
          if (.not. allocated(error)) call read_element(text, head(3), label, file, error)
          if (allocated(error)) return
          call add_member(file, file%shapes(file%shape(file%nelem))%dim, group)
        end if
      end do
    end do
    if (allocated(error)) return
    n = file%nelem - before
    if (n /= total) call fail_in_file(text, 'expected '//to_text(total)//' elements in the ' &
                                      //'blocks, found '//to_text(n), error)
  end subroutine read_elements

  !> Fail if the Gmsh type of an element belongs to none of the known shapes.
  subroutine check_type(text, gmsh, file, error)
    type(text_t), intent(in) :: text
    integer, intent(in) :: gmsh
    type(mesh_file_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error

    if (gmsh_shape(file%shapes, gmsh) > 0) return
    call fail_in_file(text, 'unknown Gmsh element type '//to_text(gmsh), error, &
                      shape_hint(file%shapes))
  end subroutine check_type

  !> Read the nodes of an element, and put them into the order of its row in the table of elements.
  subroutine read_element(text, gmsh, label, file, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: gmsh   !! type of the element
    integer, intent(in) :: label  !! number of the element
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:), own(:)
    integer :: s, spot

    s = gmsh_shape(file%shapes, gmsh)
    spot = text%at
    allocate (node(file%shapes(s)%nen))
    call next_integers(text, 'a node of element '//to_text(label), node, error)
    if (allocated(error)) return
    own = node
    associate (topology => file%shapes(s)%topology)
      if (allocated(topology%gmsh_node)) own(topology%gmsh_node) = node
    end associate
    call add_element(file, s, label, own, spot)
  end subroutine read_element

  !> Read node numbers and coordinates. Version 4.1 has blocks. Each of them gives its entity and
  !! number of nodes, then the node numbers, and then the coordinates, which may be followed by
  !! parameters on the entity.
  subroutine read_nodes(text, is_new, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: parameters(3)
    integer :: b, i, n, nblock, skip(2), done, entity(3)

    nblock = 1
    if (is_new) call next_count(text, 'the number of blocks of nodes', nblock, error)
    if (allocated(error)) return
    call next_count(text, 'the number of nodes', n, error)
    if (allocated(error)) return
    if (allocated(file%number)) call fail_in_file(text, 'duplicate section $Nodes', error)
    if (allocated(error)) return
    file%nnode = n
    allocate (file%number(n), file%x(3, n), file%node_spot(n))
    if (is_new) call next_integers(text, 'the range of node numbers', skip, error)
    if (allocated(error)) return
    done = 0
    entity = 0
    do b = 1, nblock
      if (is_new) then
        call next_integers(text, 'the dimension, tag or parametric flag of an entity', entity, &
                           error)
        if (.not. allocated(error)) call next_count(text, 'the number of nodes', n, error)
        if (allocated(error)) return
        if (n > file%nnode - done) then
          call fail_in_file(text, 'expected '//to_text(file%nnode) &
                            //' nodes in the blocks, found more', error)
          return
        end if
        do i = done + 1, done + n
          call read_number(text, i, file, error)
          if (allocated(error)) return
        end do
      end if
      if (entity(3) /= 1) entity(1) = 0
      do i = done + 1, done + n
        if (.not. is_new) call read_number(text, i, file, error)
        if (.not. allocated(error)) call next_reals(text, 'a coordinate', file%x(:, i), error)
        if (allocated(error)) return
        call next_reals(text, 'a parameter', parameters(:max(0, min(3, entity(1)))), error)
        if (allocated(error)) return
      end do
      done = done + n
    end do
    if (done /= file%nnode) then
      call fail_in_file(text, 'expected '//to_text(file%nnode)//' nodes in the blocks, found ' &
                        //to_text(done), error)
    end if
  end subroutine read_nodes

  !> Read the number of the i-th node.
  subroutine read_number(text, i, file, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: i
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error

    call next_integer(text, 'a node number', file%number(i), error)
    if (allocated(error)) return
    file%node_spot(i) = text%at
    if (file%number(i) < 1) then
      call fail_in_file(text, 'node number '//to_text(file%number(i))//' is not positive', error, &
                        'node numbers begin at 1')
    end if
  end subroutine read_number

end module format_gmsh
