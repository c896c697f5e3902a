!> Surfaces of contact: made from element faces, tabulated at the integration points.
module contact_surface
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use base_sort, only: sort_index
  use surface_topology, only: connect_elements
  use surface_basis, only: find_basis, same_basis, is_mixed, surface_functions_at, make_rational
  use contact_pair, only: contact_t, surface_t, surface_basis_t
  use element_type, only: cell_t
  use mesh, only: mesh_t, block_cell
  use quadrature, only: gauss_quad
  implicit none
  private
  public :: build_surface, tabulate_contact, surface_functions_at, make_rational

  !> Element faces with the same functions.
  type :: class_t
    integer :: basis = 0
    integer, allocatable :: local(:) !! (nsf) nodes of the element that they belong to
  end type class_t

contains

  !> The surface that element faces make up.
  subroutine build_surface(mesh, block, elem, side, name, surface, error)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: block(:), elem(:), side(:) !! (nelem) local faces 1 to 6
    character(*), intent(in) :: name
    type(surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    integer(i8), allocatable :: key(:)
    type(class_t), allocatable :: class(:)
    integer, allocatable :: iclass(:)

    surface%name = name
    surface%nelem = size(elem)
    surface%block = block
    surface%elem = elem
    surface%face = side
    call find_keys(mesh, surface, key)
    call find_classes(mesh, key, surface, class, iclass)
    call gather_nodes(mesh, class, iclass, surface)
    call connect_elements(mesh%xr, surface, error)
  end subroutine build_surface

  !> Faces with equal keys have the same functions: block, face and extraction operators.
  subroutine find_keys(mesh, surface, key)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: surface
    integer(i8), allocatable, intent(out) :: key(:) !! (nelem); negative: a class of its own
    integer, parameter :: MOST_OPERATORS = 100000
    integer(i8) :: n
    type(cell_t) :: cell
    integer :: f, d

    allocate (key(surface%nelem))
    do f = 1, surface%nelem
      associate (ext => mesh%block(surface%block(f))%ext, e => surface%elem(f))
        key(f) = 6*int(surface%block(f), i8) + surface%face(f)
        n = 1
        if (allocated(ext%surface)) then
          key(f) = key(f)*(size(ext%surface) + 1) + ext%isurface(e)
        else if (allocated(ext%op)) then
          n = size(ext%op) + 1
          do d = 1, 3
            key(f) = key(f)*n + ext%iop(d, e)
          end do
        end if
        cell%degree = ext%degree
        if (allocated(ext%w)) cell%w = ext%w(:, e)
        if (n > MOST_OPERATORS .or. is_mixed(cell, mesh%block(surface%block(f))%nen, &
                                             surface%face(f))) key(f) = -f
        if (allocated(cell%w)) deallocate (cell%w)
      end associate
    end do
  end subroutine find_keys

  !> Kinds of functions, each once.
  subroutine find_classes(mesh, key, surface, class, iclass)
    type(mesh_t), intent(in) :: mesh
    integer(i8), intent(in) :: key(:)
    type(surface_t), intent(inout) :: surface
    type(class_t), allocatable, intent(out) :: class(:)
    integer, allocatable, intent(out) :: iclass(:) !! (nelem)
    type(surface_basis_t), allocatable :: basis(:)
    type(surface_basis_t) :: new
    type(cell_t) :: cell
    integer :: order(size(key)), i, f, n, nbasis
    integer(i8) :: last

    call sort_index(key, order)
    allocate (class(size(key)), iclass(size(key)), basis(size(key)))
    n = 0
    nbasis = 0
    last = 0
    do i = 1, size(key)
      f = order(i)
      if (i > 1 .and. key(f) == last) then
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
      class(n)%basis = position_of(new, basis(:nbasis))
      if (class(n)%basis <= nbasis) cycle
      nbasis = nbasis + 1
      basis(nbasis) = new
    end do
    surface%basis = basis(:nbasis)
    surface%ibasis = class(iclass)%basis
  end subroutine find_classes

  !> Where a basis stands in the list, or the place behind it.
  pure integer function position_of(new, basis) result(k)
    type(surface_basis_t), intent(in) :: new, basis(:)

    do k = 1, size(basis)
      if (same_basis(new, basis(k))) return
    end do
  end function position_of

  !> Nodes of the faces, and weights where an element has some.
  subroutine gather_nodes(mesh, class, iclass, surface)
    type(mesh_t), intent(in) :: mesh
    type(class_t), intent(in) :: class(:)
    integer, intent(in) :: iclass(:)
    type(surface_t), intent(inout) :: surface
    type(cell_t) :: cell
    logical :: rational
    integer :: f, i

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
      associate (block => mesh%block(surface%block(f)), local => class(iclass(f))%local, &
                 first => surface%first(f), last => surface%first(f + 1) - 1)
        surface%node(first:last) = block%conn(local, surface%elem(f))
        if (.not. allocated(block%ext%w)) cycle
        call block_cell(block, surface%elem(f), cell)
        if (is_mixed(cell, block%nen, surface%face(f))) cycle
        do i = first, last
          if (local(i - first + 1) <= size(cell%w)) surface%w(i) = cell%w(local(i - first + 1))
        end do
      end associate
    end do
  end subroutine gather_nodes

  !> Gauss points n1 x n2, first direction fastest, and the functions of both sides at them; behind
  !! them those of contact%ncell x ncell cells, where there is more than one.
  subroutine tabulate_contact(contact, n1, n2)
    type(contact_t), intent(inout) :: contact
    integer, intent(in) :: n1, n2
    integer :: s, k, q

    contact%nplain = n1*n2
    contact%nq = contact%nplain
    if (contact%ncell > 1) contact%nq = contact%nplain*(1 + contact%ncell**2)
    if (allocated(contact%xi)) deallocate (contact%xi, contact%wgt)
    allocate (contact%xi(2, contact%nq), contact%wgt(contact%nq))
    call gauss_quad(n1, n2, contact%xi(:, :n1*n2), contact%wgt(:n1*n2))
    if (contact%ncell > 1) call add_cells(contact)
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

  !> The plain rule in each of the cells.
  pure subroutine add_cells(contact)
    type(contact_t), intent(inout) :: contact
    integer :: i, j, n, q

    q = contact%nplain
    n = contact%nplain
    do j = 1, contact%ncell
      do i = 1, contact%ncell
        contact%xi(1, q + 1:q + n) = (contact%xi(1, :n) + 2*i - 1)/contact%ncell - 1.0_wp
        contact%xi(2, q + 1:q + n) = (contact%xi(2, :n) + 2*j - 1)/contact%ncell - 1.0_wp
        contact%wgt(q + 1:q + n) = contact%wgt(:n)/contact%ncell**2
        q = q + n
      end do
    end do
  end subroutine add_cells

end module contact_surface
