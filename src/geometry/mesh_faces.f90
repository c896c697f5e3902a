!> Faces of a mesh file: which element faces bound the body, and which ones surface elements name.
module mesh_faces
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use base_sort, only: sort, sort_index
  use base_text, only: to_text
  use element_type, only: element_t, cell_t, topology_t
  use mesh_file, only: mesh_file_t, SHAPE
  use format_text, only: text_t, fail_in_file
  implicit none
  private
  public :: faces_t, find_boundary, face_of

  integer, parameter :: MOST = 4 !! corners of a face

  !> Faces of the elements, in the order of their keys.
  type :: faces_t
    integer :: n = 0
    integer(i8), allocatable :: key(:)     !! (n) rising
    integer, allocatable :: corner(:, :)   !! (4, n) nodes, falling; triangles end with 0
    integer, allocatable :: elem(:)        !! (n) element of the file
    integer, allocatable :: side(:)        !! (n) of the parent cube
    logical, allocatable :: bounds(:)      !! (n) no other element is behind it
  end type faces_t

contains

  !> All faces of the solid elements, those of two elements marked.
  subroutine find_boundary(file, rows, text, faces, error)
    type(mesh_file_t), intent(in) :: file
    type(element_t), intent(in) :: rows(:)   !! of each entry of SHAPE
    type(text_t), intent(inout) :: text
    type(faces_t), intent(out) :: faces
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: order(:)
    integer :: f, last, newest, same

    call collect(file, rows, faces)
    allocate (order(faces%n))
    call sort_index(faces%key, order)
    faces%key = faces%key(order)
    faces%corner = faces%corner(:, order)
    faces%elem = faces%elem(order)
    faces%side = faces%side(order)
    allocate (faces%bounds(faces%n), source=.true.)
    do f = 1, faces%n
      same = 0
      last = f - 1
      newest = faces%elem(f)
      do while (last > 0)
        if (faces%key(last) /= faces%key(f)) exit
        if (all(faces%corner(:, last) == faces%corner(:, f))) then
          same = same + 1
          newest = max(newest, faces%elem(last))
          faces%bounds([last, f]) = .false.
        end if
        last = last - 1
      end do
      if (same < 2) cycle
      text%at = file%spot(newest)
      call fail_in_file(text, 'element '//to_text(file%label(newest)) &
                    //' is the third one at a face', error, &
                    'two elements meet at a face: elements stand twice, or overlap')
      return
    end do
  end subroutine find_boundary

  !> Corners of all faces; sides of the cube with less than three corners are none.
  subroutine collect(file, rows, faces)
    type(mesh_file_t), intent(in) :: file
    type(element_t), intent(in) :: rows(:)
    type(faces_t), intent(inout) :: faces
    type(topology_t) :: topology
    type(cell_t) :: cell
    integer, allocatable :: list(:)
    integer :: e, room, s, kind, corners

    room = 6*count(file%solid)
    allocate (faces%key(room), faces%corner(MOST, room), faces%elem(room), faces%side(room))
    do kind = 1, size(SHAPE)
      if (SHAPE(kind)%dim < 3 .or. .not. any(file%shape(:file%nelem) == kind)) cycle
      cell%degree = rows(kind)%degree
      call rows(kind)%topology(cell, topology)
      do e = 1, file%nelem
        if (file%shape(e) /= kind .or. .not. file%solid(e)) cycle
        do s = 1, 6
          list = topology%node(topology%first(s):topology%first(s + 1) - 1)
          list = pack(list, is_corner(kind, list))
          corners = size(list)
          if (corners < 3) cycle
          faces%n = faces%n + 1
          faces%elem(faces%n) = e
          faces%side(faces%n) = s
          faces%corner(:, faces%n) = key_nodes(file%node(file%first(e) - 1 + list))
          faces%key(faces%n) = hash(faces%corner(:, faces%n))
        end do
      end do
    end do
    faces%key = faces%key(:faces%n)
    faces%corner = faces%corner(:, :faces%n)
    faces%elem = faces%elem(:faces%n)
    faces%side = faces%side(:faces%n)
  end subroutine collect

  !> Is a local node a corner? Quadratic elements have others too.
  elemental logical function is_corner(kind, a)
    integer, intent(in) :: kind, a

    select case (SHAPE(kind)%nen)
    case (10)
      is_corner = a <= 4
    case (27)
      is_corner = any(a == [1, 3, 7, 9, 19, 21, 25, 27])
    case default
      is_corner = .true.
    end select
  end function is_corner

  !> Corners in falling order, 0 behind those of a triangle.
  pure function key_nodes(node) result(corner)
    integer, intent(in) :: node(:)
    integer :: corner(MOST)

    corner = 0
    corner(:size(node)) = -node
    call sort(corner(:size(node)))
    corner = -corner
  end function key_nodes

  pure integer(i8) function hash(corner)
    integer, intent(in) :: corner(MOST)
    integer(i8), parameter :: FACTOR = 1000003_i8, MODULUS = 2147483647_i8
    integer :: i

    hash = 0
    do i = 1, MOST
      hash = mod(hash*FACTOR + corner(i), MODULUS)
    end do
  end function hash

  !> The boundary face that has the nodes of a surface element; 0: there is none.
  pure integer function face_of(faces, file, e) result(f)
    type(faces_t), intent(in) :: faces
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: e
    integer :: corner(MOST), low, high, n
    integer(i8) :: key

    n = merge(3, 4, SHAPE(file%shape(e))%name == 'triangle')
    corner = key_nodes(file%node(file%first(e):file%first(e) + n - 1))
    key = hash(corner)
    low = 1
    high = faces%n + 1
    do while (low < high) ! the first one with this key
      f = low + (high - low)/2
      if (faces%key(f) < key) then
        low = f + 1
      else
        high = f
      end if
    end do
    do f = low, faces%n
      if (faces%key(f) /= key) exit
      if (all(faces%corner(:, f) == corner) .and. faces%bounds(f)) return
    end do
    f = 0
  end function face_of

end module mesh_faces
