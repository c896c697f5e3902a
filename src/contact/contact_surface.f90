!> Surfaces of contact, assembled from element faces and tabulated at the integration points.
!!
!! Surfaces have the type surface_t of contact_pair. See also surface_basis (shape functions on a
!! face), surface_topology and surface_t_junctions (neighbours, vertices), surface_geometry (current
!! position, tangents), surface_traversal (motion along a surface) and projection.
module contact_surface
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index
  use contact_pair, only: contact_t, surface_t, surface_basis_t
  use element_type, only: cell_t
  use mesh, only: mesh_t, block_cell
  use quadrature, only: gauss_quad
  use surface_basis, only: find_basis, same_basis, is_mixed, surface_functions_at
  use surface_topology, only: connect_elements
  implicit none
  private
  public :: build_surface, gather_faces, tabulate_contact

  !> A class of element faces with the same functions.
  type :: class_t
    integer :: basis = 0
    integer, allocatable :: local(:) !! (nsf) element nodes of the functions
  end type class_t

contains

  !> Assemble a surface from element faces.
  subroutine build_surface(mesh, block, elem, side, name, surface, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: block(:), elem(:), side(:) !! (nelem) `side`: local face, 1 to 6
    character(*), intent(in) :: name
    type(surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error

    call gather_faces(mesh, block, elem, side, name, surface)
    call connect_elements(mesh%xr, mesh%constraint, surface, error)
    if (allocated(error)) return
    call number_controls(surface)
  end subroutine build_surface

  !> Gather element faces with their nodes and functions. The faces may belong to several bodies, so
  !! no element is given a neighbour.
  subroutine gather_faces(mesh, block, elem, side, name, surface)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: block(:), elem(:), side(:) !! (nelem) `side`: local face, 1 to 6
    character(*), intent(in) :: name
    type(surface_t), intent(out) :: surface
    type(class_t), allocatable :: class(:)
    type(cell_t) :: cell
    integer :: iclass(size(elem)), f, i
    logical :: rational

    surface%name = name
    surface%nelem = size(elem)
    surface%block = block
    surface%elem = elem
    surface%face = side
    call find_classes(mesh, surface, class, iclass)
    allocate (surface%first(surface%nelem + 1))
    surface%first(1) = 1
    rational = .false.
    do f = 1, surface%nelem
      surface%first(f + 1) = surface%first(f) + size(class(iclass(f))%local)
      rational = rational .or. allocated(mesh%block(surface%block(f))%ext%w)
    end do
    allocate (surface%node(surface%first(surface%nelem + 1) - 1))
    if (rational) allocate (surface%w(size(surface%node)), source=1.0_wp)
    do f = 1, surface%nelem
      associate (elements => mesh%block(surface%block(f)), local => class(iclass(f))%local, &
                 first => surface%first(f), last => surface%first(f + 1) - 1)
        surface%node(first:last) = elements%conn(local, surface%elem(f))
        if (.not. allocated(elements%ext%w)) cycle
        call block_cell(elements, surface%elem(f), cell)
        if (is_mixed(cell, elements%nen, surface%face(f))) cycle
        do i = first, last
          if (local(i - first + 1) <= size(cell%w)) surface%w(i) = cell%w(local(i - first + 1))
        end do
      end associate
    end do
  end subroutine gather_faces

  !> Number the control points of a surface: its nodes, or the vertices if some function of the
  !! surface is negative somewhere (Lagrange functions of higher degree).
  subroutine number_controls(surface)
    type(surface_t), intent(inout) :: surface
    integer, allocatable :: number(:)
    integer :: e, i

    surface%hats = .false.
    do i = 1, size(surface%basis)
      surface%hats = surface%hats .or. any(surface%basis(i)%c < 0.0_wp)
    end do
    if (surface%hats) then
      surface%control_first = [(4*e - 3, e=1, surface%nelem + 1)]
      surface%control = reshape(surface%vertex, [4*surface%nelem])
      surface%ncontrol = maxval([0, surface%control])
      return
    end if
    surface%control_first = surface%first
    allocate (surface%control(size(surface%node)))
    allocate (number(maxval([0, surface%node])), source=0)
    do i = 1, size(surface%node)
      if (number(surface%node(i)) == 0) then
        surface%ncontrol = surface%ncontrol + 1
        number(surface%node(i)) = surface%ncontrol
      end if
      surface%control(i) = number(surface%node(i))
    end do
  end subroutine number_controls

  !> Find the classes of faces with the same functions: set surface%basis and ibasis, and the nodes
  !! of the element to which the functions belong.
  subroutine find_classes(mesh, surface, class, iclass)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(inout) :: surface
    type(class_t), allocatable, intent(out) :: class(:)
    integer, intent(out) :: iclass(:) !! (nelem)
    type(surface_basis_t), allocatable :: basis(:)
    type(surface_basis_t) :: new
    type(cell_t) :: cell
    integer(i8) :: key(surface%nelem), last, radix
    integer :: order(surface%nelem), i, k, f, n, nbasis

    radix = operator_radix(mesh, surface)
    key = [(face_key(mesh, surface, f, radix), f=1, surface%nelem)]
    call sort_index(key, order)
    allocate (class(size(key)), basis(size(key)))
    n = 0
    nbasis = 0
    last = 0
    do i = 1, size(key)
      f = order(i)
      if (n > 0 .and. key(f) == last) then
        iclass(f) = n
        cycle
      end if
      last = key(f)
      n = n + 1
      iclass(f) = n
      associate (block => mesh%block(surface%block(f)))
        call block_cell(block, surface%elem(f), cell)
        call find_basis(block%row, cell, block%nen, surface%face(f), new, class(n)%local)
      end associate
      do k = 1, nbasis
        if (same_basis(new, basis(k))) exit
      end do
      class(n)%basis = k
      if (k <= nbasis) cycle
      nbasis = k
      basis(k) = new
    end do
    surface%basis = basis(:nbasis)
    surface%ibasis = class(iclass)%basis
  end subroutine find_classes

  !> Key of the functions of a face. Faces with equal keys have the same functions, because their
  !! block, local face and extraction operators are the same. A negative key belongs to one face
  !! only. The keys of all blocks have the same radix; otherwise keys of two blocks could be equal.
  integer(i8) function face_key(mesh, surface, f, radix) result(key)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: surface
    integer, intent(in) :: f
    integer(i8), intent(in) :: radix !! result of operator_radix
    type(cell_t) :: cell
    integer :: op(3)

    associate (block => mesh%block(surface%block(f)), ext => mesh%block(surface%block(f))%ext, &
               e => surface%elem(f))
      op = 0
      if (allocated(ext%surface)) then
        op(1) = ext%isurface(e)
      else if (allocated(ext%op)) then
        op = ext%iop(:, e)
      end if
      key = 6*int(surface%block(f), i8) + surface%face(f)
      cell%degree = ext%degree
      if (allocated(ext%w)) cell%w = ext%w(:, e)
      if (key >= huge(key)/radix/radix/radix .or. is_mixed(cell, block%nen, surface%face(f))) then
        key = -f
      else
        key = ((key*radix + op(1))*radix + op(2))*radix + op(3)
      end if
    end associate
  end function face_key

  !> Radix of the keys: one more than the largest number of operators of a block.
  pure integer(i8) function operator_radix(mesh, surface) result(radix)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: surface
    integer :: b

    radix = 1
    do b = 1, size(mesh%block)
      if (all(surface%block /= b)) cycle
      associate (ext => mesh%block(b)%ext)
        if (allocated(ext%surface)) radix = max(radix, size(ext%surface, kind=i8) + 1)
        if (allocated(ext%op)) radix = max(radix, size(ext%op, kind=i8) + 1)
      end associate
    end do
  end function operator_radix

  !> Set the n1 x n2 Gauss points of a contact, with the first direction varying fastest, and
  !! evaluate the functions of both sides at them. If contact%ncell > 1, the points of ncell x ncell
  !! cells follow (subcell_quadrature).
  subroutine tabulate_contact(contact, n1, n2)
    type(contact_t), intent(inout) :: contact
    integer, intent(in) :: n1, n2
    integer :: s, k, i, j, n, q

    n = n1*n2
    contact%nplain = n
    contact%nq = n
    if (contact%ncell > 1) contact%nq = n*(1 + contact%ncell**2)
    if (allocated(contact%xi)) deallocate (contact%xi, contact%wgt)
    allocate (contact%xi(2, contact%nq), contact%wgt(contact%nq))
    call gauss_quad(n1, n2, contact%xi(:, :n), contact%wgt(:n))
    if (contact%ncell > 1) then
      q = n
      do j = 1, contact%ncell
        do i = 1, contact%ncell
          contact%xi(1, q + 1:q + n) = (contact%xi(1, :n) + 2*i - 1)/contact%ncell - 1.0_wp
          contact%xi(2, q + 1:q + n) = (contact%xi(2, :n) + 2*j - 1)/contact%ncell - 1.0_wp
          contact%wgt(q + 1:q + n) = contact%wgt(:n)/contact%ncell**2
          q = q + n
        end do
      end do
    end if
    do s = 1, 2
      do k = 1, size(contact%side(s)%basis)
        associate (basis => contact%side(s)%basis(k))
          if (allocated(basis%shp)) deallocate (basis%shp, basis%dshp)
          allocate (basis%shp(basis%nsf, contact%nq), basis%dshp(2, basis%nsf, contact%nq))
          do q = 1, contact%nq
            call surface_functions_at(basis, contact%xi(:, q), basis%shp(:, q), basis%dshp(:, :, q))
          end do
        end associate
      end do
    end do
  end subroutine tabulate_contact

end module contact_surface
