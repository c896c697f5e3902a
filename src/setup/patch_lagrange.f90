!> Bodies of Lagrange elements, with a layer of enriched ones at spline faces.
!!
!! A cell at one enriched face becomes one enriched hexahedron. A cell at two is cut along the
!! diagonal plane from their edge to the opposite one into two prisms, each a hexahedron whose
!! face zeta = +1 is collapsed to that opposite edge (paper, section 4.1).
module patch_lagrange
  use base_kinds, only: wp
  use base_error, only: error_t
  use patch_spec, only: patch_spec_t
  use patch_geometry, only: geometry_t, point
  use patch_draft, only: draft_t, add_node, add_face
  use patch_layer, only: layer_t, make_blocks, surfaces_at, is_at
  use patch_lattice, only: make_lattice, parameters_at, border_mask
  use patch_surface, only: make_surfaces, surface_functions, axis_of, local_side
  implicit none
  private
  public :: build_lagrange

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

end module patch_lagrange
