!> Faces in a mesh file: finds the faces that bound the body, and those to which surface elements
!! refer.
module mesh_faces
  use base_kinds, only: wp, i8
  use base_error, only: error_t
  use base_sort, only: sort, sort_index
  use base_text, only: to_text
  use face_rule, only: face_points, face_normal
  use format_text, only: text_t, fail_in_file
  use mesh_file, only: mesh_file_t
  implicit none
  private
  public :: faces_t, find_boundary, face_of, measure_face

  integer, parameter :: MOST = 4 !! largest number of corners of a face

  !> Faces of the elements, sorted by key.
  type :: faces_t
    integer :: n = 0
    integer(i8), allocatable :: key(:)     !! (n) in ascending order
    integer, allocatable :: corner(:, :)   !! (4, n) nodes in descending order; triangles end with 0
    integer, allocatable :: elem(:)        !! (n) index of the element in the file
    integer, allocatable :: side(:)        !! (n) local face of the element
    logical, allocatable :: bounds(:)      !! (n) the face belongs to only one element
  end type faces_t

contains

  !> Find all faces of the solid elements; a face that belongs to only one element bounds the body.
  subroutine find_boundary(file, text, faces, error)
    type(mesh_file_t), intent(in) :: file
    type(text_t), intent(inout) :: text
    type(faces_t), intent(out) :: faces
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: list(:), order(:), side(:)
    integer :: e, f, i, last, newest, room, s, same

    room = 0
    do e = 1, file%nelem
      if (file%solid(e)) room = room + file%shapes(file%shape(e))%topology%nface
    end do
    allocate (faces%key(room), faces%corner(MOST, room), faces%elem(room), faces%side(room))
    do s = 1, size(file%shapes)
      if (file%shapes(s)%dim < 3 .or. .not. any(file%shape(:file%nelem) == s)) cycle
      associate (topology => file%shapes(s)%topology)
        do e = 1, file%nelem
          if (file%shape(e) /= s .or. .not. file%solid(e)) cycle
          do f = 1, topology%nface ! a face with fewer than three corners is collapsed
            side = topology%node(topology%first(f):topology%first(f + 1) - 1)
            list = pack(side, [(any(topology%corner == side(i)), i=1, size(side))])
            if (size(list) < 3) cycle
            faces%n = faces%n + 1
            faces%elem(faces%n) = e
            faces%side(faces%n) = f
            call make_key(file%node(file%first(e) - 1 + list), faces%corner(:, faces%n), &
                          faces%key(faces%n))
          end do
        end do
      end associate
    end do
    allocate (order(faces%n))
    call sort_index(faces%key(:faces%n), order)
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
      call fail_in_file(text, 'element '//to_text(file%label(newest))//' is the third element ' &
                        //'with the same face', error, 'a face can belong to two elements at ' &
                        //'most: remove repeated or overlapping elements')
      return
    end do
  end subroutine find_boundary

  !> Compute a key of a face that does not depend on the order of its corners.
  pure subroutine make_key(node, corner, key)
    integer, intent(in) :: node(:)         !! corners of the face
    integer, intent(out) :: corner(MOST)   !! corners in descending order; a triangle ends with 0
    integer(i8), intent(out) :: key
    integer(i8), parameter :: FACTOR = 1000003_i8, MODULUS = 2147483647_i8
    integer :: i

    corner = 0
    corner(:size(node)) = -node
    call sort(corner(:size(node)))
    corner = -corner
    key = 0
    do i = 1, MOST
      key = mod(key*FACTOR + corner(i), MODULUS)
    end do
  end subroutine make_key

  !> The boundary face that has the corners of surface element e; 0 if there is none.
  pure integer function face_of(faces, file, e) result(f)
    type(faces_t), intent(in) :: faces
    type(mesh_file_t), intent(in) :: file
    integer, intent(in) :: e
    integer :: corner(MOST), low, high, n
    integer(i8) :: key

    n = file%shapes(file%shape(e))%ncorner
    call make_key(file%node(file%first(e):file%first(e) + n - 1), corner, key)
    low = 1
    high = faces%n + 1
    do while (low < high) ! find the first face with this key
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

  !> Area of a face, and the integral of its outward normal.
  subroutine measure_face(file, faces, f, area, normal)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: f
    real(wp), intent(out) :: area      !! [L^2]
    real(wp), intent(out) :: normal(3) !! [L^2]
    real(wp), parameter :: NONE(3, 1) = 0.0_wp
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :)
    real(wp) :: part(3), ta(3), tb(3)
    integer :: q

    area = 0.0_wp
    normal = 0.0_wp
    associate (e => faces%elem(f), side => faces%side(f))
      associate (shape => file%shapes(file%shape(e)), &
                 node => file%node(file%first(e):file%first(e + 1) - 1))
        allocate (shp(shape%nen), dshp(3, shape%nen), source=0.0_wp)
        call face_points(shape%cell%degree, NONE, side, xi, w)
        do q = 1, size(w)
          call shape%row%functions(shape%cell, xi(:, q), shp, dshp)
          call face_normal(side, file%x(:, node), dshp, part, ta, tb)
          area = area + w(q)*norm2(part)
          normal = normal + w(q)*part
        end do
      end associate
    end associate
  end subroutine measure_face

end module mesh_faces
