!> Meshes of Gmsh: MSH 2.2 and 4.1 in ASCII.
!!
!! Physical groups become named groups; an element of several groups stands several times in a file
!! of version 2.2. Sections that hold no mesh are passed over.
!! Source: Geuzaine and Remacle 2009; Gmsh reference manual, section MSH file format
!!
!! Entities of a Gmsh file of version 4.1: which physical groups points, curves, surfaces and
!! volumes belong to.
!!
!! Nodes of a Gmsh file.
module format_gmsh
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use mesh_file, only: mesh_file_t, SHAPE, find_shape, add_element, add_member, sort_nodes
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_integers, next_count, &
      next_reals
  use base_kinds, only: wp
  implicit none
  private
  public :: read_gmsh, entities_t, read_entities, tag_entity, read_nodes

  !> Memberships: entity (dim, tag) belongs to a physical group.
  type :: entities_t
    integer :: n = 0
    integer, allocatable :: dim(:), tag(:), physical(:) !! (>= n)
  end type entities_t

  !> Own order of the middles of a quadratic tetrahedron, and of a hexahedron of 27 nodes.
  integer, parameter :: TET10(10) = [1, 2, 3, 4, 5, 6, 7, 8, 10, 9]
  integer, parameter :: HEX27(27) = [1, 9, 2, 10, 21, 12, 4, 14, 3, 11, 22, 13, 23, 27, 24, 16, &
                                     25, 15, 5, 17, 6, 18, 26, 19, 8, 20, 7]

contains

  !> The whole file; the text stands at its beginning.
  subroutine read_gmsh(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    type(mesh_file_t) :: names
    type(entities_t) :: entities
    character(:), allocatable :: word
    logical :: is_new

    do
      call next_word(text, word)
      if (len(word) == 0) exit
      select case (word)
      case ('$MeshFormat')
        call read_format(text, is_new, error)
      case ('$PhysicalNames')
        call read_names(text, names, error)
      case ('$Entities')
        call read_entities(text, entities, error)
      case ('$Nodes')
        call read_nodes(text, is_new, file, error)
      case ('$Elements')
        call read_elements(text, is_new, entities, file, error)
      case default
        call pass_section(text, word, error)
        if (allocated(error)) return
        cycle
      end select
      if (.not. allocated(error)) call close_section(text, word, error)
      if (allocated(error)) return
    end do
    call check_complete(text, file, error)
    if (.not. allocated(error)) call sort_nodes(file, text, error)
    if (.not. allocated(error)) call name_groups(names, file)
  end subroutine read_gmsh

  !> Version 2.2 or 4.1, ASCII.
  subroutine read_format(text, is_new, error)
    type(text_t), intent(inout) :: text
    logical, intent(out) :: is_new
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: version
    integer :: binary, size_of

    is_new = .false.
    call next_word(text, version)
    if (all(version /= ['2.2', '4.1'])) then
      call fail_in_file(text, 'version '//quoted(version)//' of a Gmsh file', error, &
                    'versions 2.2 and 4.1 are read: gmsh -save -format msh41 ...')
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

  !> Names: dimension, tag, "name". Kept as groups of a file of their own.
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
        call fail_in_file(text, 'the name of a physical group should stand here, in quotes', error)
        return
      end if
      names%group(i)%name = trim(adjustl(text%all(first:last)))
      text%at = last + 2
    end do
  end subroutine read_names

  !> Elements of all shapes.
  subroutine read_elements(text, is_new, entities, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    type(entities_t), intent(in) :: entities
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: b, i, n, nblock, total, head(3), kind, skip(2), before

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
        call next_integers(text, 'dimension, tag and type of elements', head, error)
        if (.not. allocated(error)) call next_count(text, 'the number of elements', n, error)
        if (.not. allocated(error)) call look_up(text, head(3), kind, error)
      end if
      do i = 1, n
        if (allocated(error)) return
        if (is_new) then
          call read_nodes_of(text, kind, file, error)
          if (.not. allocated(error)) call tag_entity(entities, head(1), head(2), file)
        else
          call read_old_element(text, file, error)
        end if
      end do
    end do
    if (allocated(error)) return
    if (file%nelem - before /= total) then
      call fail_in_file(text, 'the blocks have '//to_text(file%nelem - before)//' elements, ' &
                    //to_text(total)//' are announced', error)
    end if
  end subroutine read_elements

  !> Version 2.2: number, type, tags (the first is the physical group), nodes.
  subroutine read_old_element(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: label, gmsh, ntag, kind, i, tag, group

    group = 0
    call next_integer(text, 'an element number', label, error)
    if (.not. allocated(error)) call next_integer(text, 'an element type', gmsh, error)
    if (.not. allocated(error)) call look_up(text, gmsh, kind, error)
    if (.not. allocated(error)) call next_count(text, 'a number of tags', ntag, error)
    do i = 1, ntag
      if (allocated(error)) return
      call next_integer(text, 'a tag', tag, error)
      if (i == 1) group = tag
    end do
    if (allocated(error)) return
    call read_nodes_of(text, kind, file, error, label)
    if (.not. allocated(error)) call add_member(file, file%nelem, SHAPE(kind)%dim, group)
  end subroutine read_old_element

  subroutine look_up(text, gmsh, kind, error)
    type(text_t), intent(in) :: text
    integer, intent(in) :: gmsh
    integer, intent(out) :: kind
    type(error_t), allocatable, intent(out) :: error

    kind = find_shape(gmsh)
    if (kind > 0) return
    call fail_in_file(text, 'elements of type '//to_text(gmsh)//' of Gmsh are not known', error, &
                  'tetrahedra, pyramids, wedges and hexahedra of order 1, tetrahedra and ' &
                  //'hexahedra (27 nodes) of order 2')
  end subroutine look_up

  !> Number, where it is not known yet, and nodes, in our order.
  subroutine read_nodes_of(text, kind, file, error, label)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: kind
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: label
    integer :: node(27), n, number, spot

    if (present(label)) then
      number = label
    else
      call next_integer(text, 'an element number', number, error)
      if (allocated(error)) return
    end if
    spot = text%at
    n = SHAPE(kind)%nen
    call next_integers(text, 'a node of element '//to_text(number), node(:n), error)
    if (allocated(error)) return
    if (SHAPE(kind)%row == 'TET10') node(:10) = node(TET10)
    if (SHAPE(kind)%row == 'Q2') node = node(HEX27)
    call add_element(file, kind, number, node(:n), spot)
  end subroutine read_nodes_of

  !> Behind $Nodes comes $EndNodes.
  subroutine close_section(text, name, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word

    call next_word(text, word)
    if (word == '$End'//name(2:)) return
    if (len(word) == 0) then
      call fail_in_file(text, 'the file ends where $End'//name(2:)//' should stand', error)
    else
      call fail_in_file(text, quoted(word)//' where $End'//name(2:)//' should stand', error, &
                    'the counts of the section and what stands in it disagree')
    end if
  end subroutine close_section

  !> A section that holds no mesh.
  subroutine pass_section(text, name, error)
    type(text_t), intent(inout) :: text
    character(*), intent(in) :: name
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (name(1:1) /= '$') then
      call fail_in_file(text, quoted(name)//' stands between sections', error, &
                    'sections of a Gmsh file begin with $')
    else if (name == '$PartitionedEntities') then
      call fail_in_file(text, 'the mesh is partitioned', error, 'write it in one part')
    else
      i = index(text%all(text%at:), '$End'//name(2:))
      if (i == 0) then
        call fail_in_file(text, 'section '//name//' has no end', error)
      else
        text%at = text%at + i - 1 + len('$End'//name(2:))
      end if
    end if
  end subroutine pass_section

  subroutine check_complete(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(in) :: file
    type(error_t), allocatable, intent(out) :: error

    if (.not. allocated(file%number)) then
      call fail_in_file(text, 'the file has no section $Nodes', error)
    else if (.not. allocated(file%shape)) then
      call fail_in_file(text, 'the file has no elements', error)
    end if
  end subroutine check_complete

  !> Names of the groups that elements belong to.
  pure subroutine name_groups(names, file)
    type(mesh_file_t), intent(in) :: names
    type(mesh_file_t), intent(inout) :: file
    integer :: g, i

    if (.not. (allocated(names%group) .and. allocated(file%group))) return
    do i = 1, size(names%group)
      do g = 1, size(file%group)
        if (file%group(g)%dim /= names%group(i)%dim) cycle
        if (file%group(g)%tag == names%group(i)%tag) file%group(g)%name = names%group(i)%name
      end do
    end do
  end subroutine name_groups

  !> $Entities.
  subroutine read_entities(text, entities, error)
    type(text_t), intent(inout) :: text
    type(entities_t), intent(out) :: entities
    type(error_t), allocatable, intent(out) :: error
    integer :: d, i, count(0:3)

    allocate (entities%dim(16), entities%tag(16), entities%physical(16))
    do d = 0, 3
      call next_count(text, 'a number of entities', count(d), error)
      if (allocated(error)) return
    end do
    do d = 0, 3
      do i = 1, count(d)
        call read_entity(text, d, entities, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_entities

  !> Tag, position or box, physical groups, and (of more than points) the boundary.
  subroutine read_entity(text, d, entities, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: d
    type(entities_t), intent(inout) :: entities
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: box(6)
    integer :: i, n, part, tag, value

    call next_integer(text, 'the tag of an entity', tag, error)
    if (allocated(error)) return
    call next_reals(text, 'the box of an entity', box(:merge(3, 6, d == 0)), error)
    do part = 1, merge(1, 2, d == 0)
      if (.not. allocated(error)) call next_count(text, 'a number of tags', n, error)
      if (allocated(error)) return
      do i = 1, n
        call next_integer(text, 'a tag', value, error)
        if (allocated(error)) return
        if (part == 1) call append(entities, d, tag, value)
      end do
    end do
  end subroutine read_entity

  subroutine append(entities, d, tag, physical)
    type(entities_t), intent(inout) :: entities
    integer, intent(in) :: d, tag, physical

    if (entities%n == size(entities%dim)) then
      entities%dim = [entities%dim, entities%dim]
      entities%tag = [entities%tag, entities%tag]
      entities%physical = [entities%physical, entities%physical]
    end if
    entities%n = entities%n + 1
    entities%dim(entities%n) = d
    entities%tag(entities%n) = tag
    entities%physical(entities%n) = physical
  end subroutine append

  !> The last element of the file lies on an entity.
  subroutine tag_entity(entities, d, tag, file)
    type(entities_t), intent(in) :: entities
    integer, intent(in) :: d, tag
    type(mesh_file_t), intent(inout) :: file
    integer :: i

    do i = 1, entities%n
      if (entities%dim(i) /= d .or. entities%tag(i) /= tag) cycle
      call add_member(file, file%nelem, d, entities%physical(i))
    end do
  end subroutine tag_entity

  !> Numbers and coordinates. Version 4.1 has blocks of an entity's numbers, then of its positions.
  subroutine read_nodes(text, is_new, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: b, n, nblock, skip(2), done

    nblock = 1
    if (is_new) call next_count(text, 'the number of blocks of nodes', nblock, error)
    if (allocated(error)) return
    call next_count(text, 'the number of nodes', n, error)
    if (allocated(error)) return
    if (allocated(file%number)) call fail_in_file(text, 'the file has two sections of nodes', error)
    if (allocated(error)) return
    file%nnode = n
    allocate (file%number(n), file%x(3, n), file%node_spot(n))
    if (is_new) call next_integers(text, 'the range of node numbers', skip, error)
    done = 0
    do b = 1, nblock
      if (.not. allocated(error)) call read_node_block(text, is_new, done, file, error)
      if (allocated(error)) return
    end do
    if (done /= file%nnode) then
      call fail_in_file(text, 'the blocks have '//to_text(done)//' of the '//to_text(file%nnode) &
                    //' nodes announced', error)
    end if
  end subroutine read_nodes

  !> One block; in version 4.1 it says how many nodes it has, and nodes of a kind have parameters of
  !! their entity behind their coordinates.
  subroutine read_node_block(text, is_new, done, file, error)
    type(text_t), intent(inout) :: text
    logical, intent(in) :: is_new
    integer, intent(inout) :: done   !! nodes read so far
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: skip(3)
    integer :: entity(3), i, n

    n = file%nnode
    entity = 0
    if (is_new) then
      call next_integers(text, 'dimension, tag and kind of an entity', entity, error)
      if (.not. allocated(error)) call next_count(text, 'the number of its nodes', n, error)
      if (allocated(error)) return
      if (n > file%nnode - done) then
        call fail_in_file(text, 'the blocks have more nodes than the '//to_text(file%nnode) &
                      //' announced', error)
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
      call next_reals(text, 'a parameter', skip(:max(0, min(3, entity(1)))), error)
      if (allocated(error)) return
    end do
    done = done + n
  end subroutine read_node_block

  !> The number of node i.
  subroutine read_number(text, i, file, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: i
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error

    call next_integer(text, 'a node number', file%number(i), error)
    if (allocated(error)) return
    file%node_spot(i) = text%at
    if (file%number(i) < 1) then
      call fail_in_file(text, 'node number '//to_text(file%number(i)), error, &
                    'node numbers are positive')
    end if
  end subroutine read_number

end module format_gmsh
