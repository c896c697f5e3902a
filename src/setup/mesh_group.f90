!> Named sets and the boundary of a body from a mesh file.
module mesh_group
  use base_kinds, only: wp
  use base_text, only: to_text, lower, nearest
  use element_type, only: element_t, cell_t, topology_t
  use face_rule, only: face_points, face_normal
  use mesh, only: body_t, body_face_t, group_t
  use mesh_faces, only: faces_t, face_of
  use mesh_file, only: mesh_file_t, SHAPE
  implicit none
  private
  public :: find_groups, group_named, group_hint, put_boundary

contains

  !> Marks of the groups of a file that have a name.
  pure function group_named(file, name) result(yes)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    logical, allocatable :: yes(:)
    integer :: g

    allocate (yes(0))
    if (.not. allocated(file%group)) return
    yes = [(lower(file%group(g)%name) == lower(name), g=1, size(file%group))]
  end function group_named

  !> What a group that is not there could be.
  function group_hint(file, name) result(hint)
    type(mesh_file_t), intent(in) :: file
    character(*), intent(in) :: name
    character(:), allocatable :: hint
    character(64), allocatable :: names(:)
    integer :: g

    hint = 'its file has no physical groups; ALL is the whole boundary'
    if (.not. allocated(file%group)) return
    allocate (names(size(file%group)))
    do g = 1, size(names)
      names(g) = file%group(g)%name
    end do
    hint = 'nearest known: '//trim(nearest(name, names))
  end function group_hint

  !> Groups of one name are one.
  subroutine find_groups(file, faces, place, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :)   !! (2, nelem) block of the mesh and element there
    integer, intent(in) :: nnode         !! nodes of the mesh before this body
    type(body_t), intent(inout) :: body
    type(group_t), allocatable :: group(:)
    logical, allocatable :: chosen(:)
    integer :: g, n

    n = 0
    if (allocated(file%group)) n = size(file%group)
    allocate (group(n))
    n = 0
    do g = 1, size(group)
      chosen = group_named(file, file%group(g)%name)
      if (any(chosen(:g - 1))) cycle
      n = n + 1
      group(n)%name = file%group(g)%name
      call fill_group(file, faces, place, nnode, chosen, group(n))
    end do
    body%group = group(:n)
  end subroutine find_groups

  !> Nodes of all elements, faces of the surface elements.
  subroutine fill_group(file, faces, place, nnode, chosen, group)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), nnode
    logical, intent(in) :: chosen(:)
    type(group_t), intent(inout) :: group
    logical, allocatable :: on(:), seen(:)
    integer, allocatable :: list(:)
    integer :: e, f, i, m, n

    allocate (on(file%nnode), seen(faces%n), source=.false.)
    allocate (list(count(chosen(file%member(2, :file%nmember)))))
    n = 0
    do m = 1, file%nmember
      if (.not. chosen(file%member(2, m))) cycle
      e = file%member(1, m)
      on(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
      if (SHAPE(file%shape(e))%dim /= 2) cycle
      f = face_of(faces, file, e)
      if (f == 0) then
        group%inner = group%inner + 1
        cycle
      end if
      if (seen(f)) cycle
      seen(f) = .true.
      n = n + 1
      list(n) = f
    end do
    group%node = nnode + pack([(i, i=1, file%nnode)], on)
    call take_faces(faces, place, list(:n), group%face)
  end subroutine fill_group

  pure subroutine take_faces(faces, place, list, face)
    type(faces_t), intent(in) :: faces
    integer, intent(in) :: place(:, :), list(:)
    type(body_face_t), intent(out) :: face

    face%block = place(1, faces%elem(list))
    face%elem = place(2, faces%elem(list))
    face%side = faces%side(list)
  end subroutine take_faces

  !> Nodes, the whole boundary as face 1, and how thick the body is.
  subroutine put_boundary(file, faces, rows, place, volume, nnode, body)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    type(element_t), intent(in) :: rows(:)  !! of each entry of SHAPE
    integer, intent(in) :: place(:, :), nnode
    real(wp), intent(in) :: volume          !! [L^3]
    type(body_t), intent(inout) :: body
    logical, allocatable :: used(:)
    integer :: e, f, i
    real(wp) :: area

    body%node = [(nnode + i, i=1, file%nnode)]
    body%label = file%number
    allocate (body%mask(file%nnode), source=0)
    call take_faces(faces, place, pack([(f, f=1, faces%n)], faces%bounds), body%face(1))
    do f = 2, 6
      allocate (body%face(f)%block(0), body%face(f)%elem(0), body%face(f)%side(0))
    end do
    area = 0.0_wp
    do f = 1, faces%n
      if (faces%bounds(f)) call add_face(file, faces, rows, f, body%mask, area)
    end do
    body%thickness = 2.0_wp*volume/area
    allocate (used(file%nnode), source=.false.)
    do e = 1, file%nelem
      if (file%solid(e)) used(file%node(file%first(e):file%first(e + 1) - 1)) = .true.
    end do
    body%note = to_text(count(file%solid))//' elements, '//to_text(count(used))//' nodes, ' &
                //to_text(count(faces%bounds))//' faces on the boundary'
    if (.not. all(used)) body%note = body%note//'; '//to_text(count(.not. used)) &
                                     //' nodes of the file belong to no element of it'
  end subroutine put_boundary

  !> Nodes of a boundary face, and its area.
  subroutine add_face(file, faces, rows, f, mask, area)
    type(mesh_file_t), intent(in) :: file
    type(faces_t), intent(in) :: faces
    type(element_t), intent(in) :: rows(:)
    integer, intent(in) :: f
    integer, intent(inout) :: mask(:)
    real(wp), intent(inout) :: area
    type(topology_t) :: topology
    type(cell_t) :: cell
    real(wp), allocatable :: xi(:, :), w(:), shp(:), dshp(:, :)
    real(wp) :: normal(3), ta(3), tb(3)
    real(wp), parameter :: NONE(3, 1) = 0.0_wp
    integer :: q, kind

    kind = file%shape(faces%elem(f))
    cell%degree = rows(kind)%degree
    call rows(kind)%topology(cell, topology)
    allocate (shp(topology%nen), dshp(3, topology%nen))
    associate (s => faces%side(f), first => file%first(faces%elem(f)))
      associate (node => file%node(first:first + topology%nen - 1))
        mask(node(topology%node(topology%first(s):topology%first(s + 1) - 1))) = 1
        call face_points(cell%degree, NONE, s, xi, w)
        do q = 1, size(w)
          call rows(kind)%functions(cell, xi(:, q), shp, dshp)
          call face_normal(s, file%x(:, node), dshp, normal, ta, tb)
          area = area + w(q)*norm2(normal)
        end do
      end associate
    end associate
  end subroutine add_face

end module mesh_group
