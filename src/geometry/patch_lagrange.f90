!> Bodies of Lagrange elements, with a layer of enriched ones at spline faces.
!!
!! A cell at one enriched face becomes one enriched hexahedron. A cell at two is cut along the
!! diagonal plane from their edge to the opposite one into two prisms, each a hexahedron whose
!! face zeta = +1 is collapsed to that opposite edge (paper, section 4.1).
!!
!! The Lagrange nodes of a body: points of its geometry on a lattice over the elements.
!!
!! The element blocks of a body of Lagrange elements and of its enriched layers.
module patch_lagrange
  use base_kinds, only: wp
  use base_error, only: error_t
  use patch_spec, only: patch_spec_t, enrich_t
  use patch_geometry, only: geometry_t, point
  use patch_draft, only: draft_t, add_node, add_face, new_block, find_row
  use patch_surface, only: make_surfaces, surface_functions, axis_of, local_side, surface_t, &
      side_of
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  implicit none
  private
  public :: build_lagrange, lattice_t, make_lattice, parameters_at, border_mask, layer_t, &
            make_blocks, surfaces_at, is_at

  !> Element c of direction d spans lattice lines m (c-1) to m c.
  type :: lattice_t
    integer :: m = 1                        !! lattice intervals an element has: its degree
    integer :: n(3) = 0                     !! intervals in all
    integer, allocatable :: node(:, :, :)   !! (0:n1, 0:n2, 0:n3); 0 on enriched faces
  end type lattice_t

  !> What the cells are made from.
  type :: layer_t
    type(lattice_t) :: lattice
    type(surface_t), allocatable :: surface(:)
    integer :: bulk = 0                  !! block of the elements off all enriched faces
    integer, allocatable :: hexa(:)      !! (nsurface) block of the enriched hexahedra
    integer, allocatable :: prism(:)     !! (nsurface) block of the prisms
    integer, allocatable :: middle(:, :, :) !! (0:n, nsurface, nsurface) nodes inside Q2 prisms
  end type layer_t

contains

  !> Nodes, blocks and faces of a body of type Q1, Q1E9 or Q2.
  subroutine build_lagrange(spec, geo, draft, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error
    type(layer_t) :: layer
    logical :: enriched(6)
    integer :: i, j, k, m, at(2)

    m = 1
    if (spec%type == 'Q2') m = 2
    enriched = .false.
    do i = 1, size(spec%enrich)
      enriched(spec%enrich(i)%face) = .true.
    end do
    call make_lattice(geo, m, enriched, draft, layer%lattice)
    call make_surfaces(spec, geo, draft, layer%surface)
    call make_blocks(spec, geo, layer, draft, error)
    if (allocated(error)) return
    allocate (layer%middle(0:m*maxval(geo%n), size(spec%enrich), size(spec%enrich)), source=0)
    do k = 1, geo%n(3)
      do j = 1, geo%n(2)
        do i = 1, geo%n(1)
          at = surfaces_at(layer%surface, geo%n, [i, j, k])
          if (at(1) == 0) then
            call add_bulk(geo, layer, [i, j, k], draft)
          else if (at(2) == 0) then
            call add_hexahedron(geo, layer, [i, j, k], at(1), draft)
          else
            call add_prism(geo, layer, [i, j, k], at(1), at(2), draft)
            call add_prism(geo, layer, [i, j, k], at(2), at(1), draft)
          end if
        end do
      end do
    end do
  end subroutine build_lagrange

  subroutine add_bulk(geo, layer, cell, draft)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(in) :: layer
    integer, intent(in) :: cell(3)
    type(draft_t), intent(inout) :: draft
    !> Corners in FEAP's and VTK's order.
    integer, parameter :: CORNER(3, 8) = reshape([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, &
                                                  0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1], [3, 8])
    integer :: i(3), a, f, m

    m = layer%lattice%m
    associate (b => draft%block(layer%bulk), node => layer%lattice%node)
      b%nelem = b%nelem + 1
      do a = 1, b%nen
        if (m == 1) then
          i = CORNER(:, a)
        else
          i = [mod(a - 1, 3), mod((a - 1)/3, 3), (a - 1)/9]
        end if
        i = i + m*(cell - 1)
        b%conn(a, b%nelem) = node(i(1), i(2), i(3))
      end do
      do f = 1, 6
        if (is_at(geo%n, cell, f)) call add_face(draft, f, layer%bulk, b%nelem, f)
      end do
    end associate
  end subroutine add_bulk

  subroutine add_hexahedron(geo, layer, cell, is, draft)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3)
    integer, intent(in) :: is !! surface
    type(draft_t), intent(inout) :: draft
    integer :: f, e

    call add_enriched(geo, layer, cell, is, 0, draft, e)
    do f = 1, 6
      if (is_at(geo%n, cell, f)) then
        call add_face(draft, f, layer%hexa(is), e, local_side(layer%surface(is), f))
      end if
    end do
  end subroutine add_hexahedron

  !> The half of an edge cell that belongs to surface `is`; the other half belongs to `it`.
  subroutine add_prism(geo, layer, cell, is, it, draft)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3), is, it
    type(draft_t), intent(inout) :: draft
    integer :: f, e

    call add_enriched(geo, layer, cell, is, it, draft, e)
    associate (s => layer%surface(is), t => layer%surface(it))
      do f = 1, 6
        if (.not. is_at(geo%n, cell, f)) cycle
        if (f == t%face) cycle                                ! the diagonal plane is there
        if (axis_of(f) == s%axis .and. f /= s%face) cycle     ! collapsed
        call add_face(draft, f, layer%prism(is), e, local_side(s, f))
      end do
    end associate
  end subroutine add_prism

  !> Nodes of an enriched hexahedron (it = 0) or prism.
  subroutine add_enriched(geo, layer, cell, is, it, draft, e)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3), is, it
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: e !! its number in the block
    integer :: m, i, j, l, a, ib, ncp

    ib = layer%hexa(is)
    if (it > 0) ib = layer%prism(is)
    m = layer%lattice%m
    associate (s => layer%surface(is))
      ncp = (s%degree(s%xi) + 1)*(s%degree(s%eta) + 1)
      block
        integer :: node(ncp + m*(m + 1)**2)
        real(wp) :: w(ncp)

        call surface_functions(s, cell, node(:ncp), w)
        a = ncp
        do l = 1, m
          do j = 0, m
            do i = 0, m
              a = a + 1
              call upper_node(geo, layer, cell, is, it, [i, j, l], draft, node(a))
            end do
          end do
        end do
        if (m == 1) node(ncp + 3:ncp + 4) = node([ncp + 4, ncp + 3]) ! counter-clockwise
        e = draft%block(ib)%nelem + 1
        draft%block(ib)%nelem = e
        draft%block(ib)%conn(:, e) = node
        draft%block(ib)%ext%iop(1, e) = s%span(s%xi)%iop(cell(s%xi))
        draft%block(ib)%ext%iop(2, e) = s%span(s%eta)%iop(cell(s%eta))
        if (s%rational) draft%block(ib)%ext%w(:, e) = w
      end block
    end associate
  end subroutine add_enriched

  !> Lagrange node (i,j,l) of an enriched element: i along xi, j along eta, l from the surface.
  subroutine upper_node(geo, layer, cell, is, it, ijl, draft, node)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3), is, it, ijl(3)
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: node
    integer :: m, i(3), depth

    m = layer%lattice%m
    associate (s => layer%surface(is))
      i(s%xi) = ijl(1)
      i(s%eta) = ijl(2)
      i(s%axis) = merge(ijl(3), m - ijl(3), s%side == 0)
      if (it > 0) then
        associate (t => layer%surface(it))
          ! Lines of constant xi (or eta) all run to the opposite edge.
          depth = merge(i(t%axis), m - i(t%axis), t%side == 0) ! from the other surface
          if (m == 2 .and. ijl(3) == 1 .and. depth == 1) then
            i = i + m*(cell - 1)
            call middle_node(geo, layer, i, is, it, draft, node)
            return
          end if
          ! Level l of the line from a point at depth d of the surface to the opposite edge.
          depth = depth + (m - depth)*ijl(3)/m
          i(t%axis) = merge(depth, m - depth, t%side == 0)
        end associate
      end if
    end associate
    i = i + m*(cell - 1)
    node = layer%lattice%node(i(1), i(2), i(3))
  end subroutine upper_node

  !> Node inside a Q2 prism: half way between the surface and the opposite edge.
  subroutine middle_node(geo, layer, at, is, it, draft, node)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: at(3), is, it !! the lattice point in the middle of the cell
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: node
    integer :: foot(3), edge(3), third, mask

    associate (s => layer%surface(is), t => layer%surface(it))
      third = 6 - s%axis - t%axis
      node = layer%middle(at(third), is, it)
      if (node > 0) return
      foot = at
      foot(s%axis) = at(s%axis) + merge(-1, 1, s%side == 0)
      edge = at
      edge(s%axis) = at(s%axis) + merge(1, -1, s%side == 0)
      edge(t%axis) = at(t%axis) + merge(1, -1, t%side == 0)
      mask = iand(border_mask(layer%lattice, at), shiftl(3, 2*third - 2))
      call add_node(draft, 0.5_wp*(point(geo, parameters_at(geo, 2, foot)) &
                                   + point(geo, parameters_at(geo, 2, edge))), .false., mask, node)
      layer%middle(at(third), is, it) = node
    end associate
  end subroutine middle_node

  !> Nodes everywhere but on enriched faces, whose control points take their place.
  subroutine make_lattice(geo, m, enriched, draft, lattice)
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: m
    logical, intent(in) :: enriched(6)
    type(draft_t), intent(inout) :: draft
    type(lattice_t), intent(out) :: lattice
    integer :: i, j, k, f, mask

    lattice%m = m
    lattice%n = m*geo%n
    associate (n => lattice%n)
      allocate (lattice%node(0:n(1), 0:n(2), 0:n(3)), source=0)
      do k = 0, n(3)
        do j = 0, n(2)
          do i = 0, n(1)
            mask = border_mask(lattice, [i, j, k])
            if (any([(enriched(f) .and. btest(mask, f - 1), f=1, 6)])) cycle
            call add_node(draft, point(geo, parameters_at(geo, m, [i, j, k])), .false., mask, &
                          lattice%node(i, j, k))
          end do
        end do
      end do
    end associate
  end subroutine make_lattice

  !> Faces on which a lattice point lies.
  pure integer function border_mask(lattice, at) result(mask)
    type(lattice_t), intent(in) :: lattice
    integer, intent(in) :: at(3)
    integer :: d

    mask = 0
    do d = 1, 3
      if (at(d) == 0) mask = ibset(mask, 2*d - 2)
      if (at(d) == lattice%n(d)) mask = ibset(mask, 2*d - 1)
    end do
  end function border_mask

  !> Parameters of a lattice point.
  pure function parameters_at(geo, m, at) result(u)
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: m, at(3)
    real(wp) :: u(3)
    integer :: d, c, r

    do d = 1, 3
      c = at(d)/m + 1
      r = mod(at(d), m)
      associate (breaks => geo%breaks(d)%u)
        u(d) = breaks(c)
        if (r > 0) u(d) = breaks(c) + (breaks(c + 1) - breaks(c))*r/m
      end associate
    end do
  end function parameters_at

  !> Blocks for all kinds of cells that occur, each with room for its elements.
  subroutine make_blocks(spec, geo, layer, draft, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error
    type(element_t) :: row
    type(cell_t) :: cell
    integer :: nhexa(size(layer%surface)), nprism(size(layer%surface))
    integer :: s, m, nbulk

    m = layer%lattice%m
    call count_cells(geo, layer, nbulk, nhexa, nprism)
    allocate (layer%hexa(size(nhexa)), layer%prism(size(nhexa)), source=0)
    if (nbulk > 0) then
      call find_row(spec, spec%type, row, error)
      if (allocated(error)) return
      call new_block(draft, spec, trim(spec%type), row, [m, m, m], (m + 1)**3, nbulk, layer%bulk)
      call row%rule(cell, spec%q, spec%qz, draft%block(layer%bulk)%rule)
    end if
    do s = 1, size(nhexa)
      associate (e => spec%enrich(s))
        call find_row(spec, family(spec, e), row, error)
        if (allocated(error)) return
        if (row%nmode == 0) then ! one rule for both: one block
          call layer_block(spec, layer%surface(s), e, row, m, nhexa(s) + nprism(s), 0, draft, &
                           layer%hexa(s))
          layer%prism(s) = layer%hexa(s)
        else
          call layer_block(spec, layer%surface(s), e, row, m, nhexa(s), 0, draft, layer%hexa(s))
          call layer_block(spec, layer%surface(s), e, row, m, nprism(s), 3, draft, layer%prism(s))
        end if
      end associate
    end do
  end subroutine make_blocks

  !> One block of an enriched layer, with at least `least` points across.
  subroutine layer_block(spec, s, e, row, m, nelem, least, draft, ib)
    type(patch_spec_t), intent(in) :: spec
    type(surface_t), intent(in) :: s
    type(enrich_t), intent(in) :: e
    type(element_t), intent(in) :: row
    integer, intent(in) :: m, nelem, least
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: ib
    type(cell_t) :: cell
    integer :: ncp

    ib = 0
    if (nelem == 0) return
    cell%degree = [s%degree(s%xi), s%degree(s%eta), m]
    ncp = (cell%degree(1) + 1)*(cell%degree(2) + 1)
    call new_block(draft, spec, block_name(spec, e), row, cell%degree, ncp + m*(m + 1)**2, nelem, &
                   ib)
    if (s%rational) allocate (draft%block(ib)%ext%w(ncp, nelem))
    call row%rule(cell, spec%q, max(spec%qz, least), draft%block(ib)%rule)
  end subroutine layer_block

  !> How many cells become what.
  pure subroutine count_cells(geo, layer, nbulk, nhexa, nprism)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(in) :: layer
    integer, intent(out) :: nbulk, nhexa(:), nprism(:)
    integer :: i, j, k, at(2)

    nbulk = 0
    nhexa = 0
    nprism = 0
    do k = 1, geo%n(3)
      do j = 1, geo%n(2)
        do i = 1, geo%n(1)
          at = surfaces_at(layer%surface, geo%n, [i, j, k])
          if (at(1) == 0) then
            nbulk = nbulk + 1
          else if (at(2) == 0) then
            nhexa(at(1)) = nhexa(at(1)) + 1
          else
            nprism(at) = nprism(at) + 1
          end if
        end do
      end do
    end do
  end subroutine count_cells

  !> The enriched faces that a cell touches: none, one or two.
  pure function surfaces_at(surface, n, cell) result(at)
    type(surface_t), intent(in) :: surface(:)
    integer, intent(in) :: n(3), cell(3)
    integer :: at(2), s

    at = 0
    do s = 1, size(surface)
      if (.not. is_at(n, cell, surface(s)%face)) cycle
      if (at(1) == 0) then
        at(1) = s
      else
        at(2) = s
      end if
    end do
  end function surfaces_at

  pure logical function is_at(n, cell, face)
    integer, intent(in) :: n(3), cell(3), face

    is_at = cell(axis_of(face)) == merge(1, n(axis_of(face)), side_of(face) == 0)
  end function is_at

  !> Row of the table of elements that an enriched layer uses.
  function family(spec, e) result(name)
    type(patch_spec_t), intent(in) :: spec
    type(enrich_t), intent(in) :: e
    character(:), allocatable :: name

    name = 'Q1N'
    if (e%eas) name = 'Q1E9N'
    if (e%tapered) name = 'Q1E9NT'
    if (spec%type == 'Q2') name = 'Q2N'
  end function family

  !> Name as reported: Q1N2, Q1N2.1, Q1E9N2, Q1E9N2T, Q2N2.
  function block_name(spec, e) result(name)
    type(patch_spec_t), intent(in) :: spec
    type(enrich_t), intent(in) :: e
    character(:), allocatable :: name

    name = 'Q1N'
    if (e%eas) name = 'Q1E9N'
    if (spec%type == 'Q2') name = 'Q2N'
    name = name//to_text(e%degree)
    if (e%raise > 0) name = name//'.'//to_text(e%raise)
    if (e%tapered) name = name//'T'
  end function block_name

end module patch_lagrange
