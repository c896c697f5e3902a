!> Bodies of Lagrange elements, with a layer of enriched elements at each spline face.
!!
!! ELEMents or KNOTs divide the patch into cells. The Lagrange nodes are the points of the geometry
!! at the nodes of a lattice over the cells. A cell at one enriched face becomes one enriched
!! hexahedron. A cell at two enriched faces is divided into two prisms by the diagonal plane through
!! the edge that these faces share and the opposite edge. Each prism is a hexahedron whose face
!! zeta+ is collapsed to that opposite edge (Corbett and Sauer 2015, section 4.1).
module patch_lagrange
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  use few_points, only: warn_few_points, splines_lack_points
  use patch_draft, only: draft_t, add_node, add_face, new_block, find_row
  use patch_geometry, only: geometry_t, point
  use patch_spec, only: patch_spec_t, GEO_BOX
  use patch_surface, only: surface_t, make_surfaces, surface_functions, axis_of, side_of, local_side
  use tensor, only: cross
  implicit none
  private
  public :: build_lagrange

  !> The lattice of nodes. Along each direction, element c extends from lattice line m (c-1) to m c.
  type :: lattice_t
    integer :: m = 1                        !! intervals per element in each direction: its degree
    integer :: n(3) = 0                     !! number of intervals in each direction
    integer, allocatable :: node(:, :, :)   !! (0:n1, 0:n2, 0:n3); 0 on enriched faces
  end type lattice_t

  !> The data from which the elements are made.
  type :: layer_t
    type(lattice_t) :: lattice
    type(surface_t), allocatable :: surface(:)
    integer :: bulk = 0                  !! block of the elements that touch no enriched face
    integer, allocatable :: hexa(:)      !! (nsurface) block of the enriched hexahedra
    integer, allocatable :: prism(:)     !! (nsurface) block of the prisms
    integer, allocatable :: middle(:, :, :) !! (0:n, nsurface, nsurface) nodes inside Q2 prisms
  end type layer_t

contains

  !> Make the nodes, blocks and faces of a body of type Q1, Q1E9 or Q2.
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
    enriched(spec%enrich%face) = .true.
    call make_lattice(geo, m, enriched, draft, layer%lattice)
    call make_surfaces(spec, geo, draft, layer%surface)
    call make_blocks(spec, geo, layer, draft, error)
    if (allocated(error)) return
    call check_points(spec, geo, layer, draft)
    allocate (layer%middle(0:m*maxval(geo%n), size(spec%enrich), size(spec%enrich)), source=0)
    do k = 1, geo%n(3)
      do j = 1, geo%n(2)
        do i = 1, geo%n(1)
          at = surfaces_at(layer%surface, geo%n, [i, j, k])
          if (at(1) == 0) then
            call add_bulk(geo, layer, [i, j, k], draft)
          else if (at(2) == 0) then
            call add_enriched(geo, layer, [i, j, k], at(1), 0, draft)
          else
            call add_enriched(geo, layer, [i, j, k], at(1), at(2), draft)
            call add_enriched(geo, layer, [i, j, k], at(2), at(1), draft)
          end if
        end do
      end do
    end do
    if (spec%geometry == GEO_BOX) return
    do i = 1, 6
      if (.not. enriched(i)) draft%face(i)%deviation = deviation(geo, m, i)
    end do
  end subroutine build_lagrange

  !> Largest distance of the elements of a face from its geometry, which they interpolate at their
  !! nodes, normal to the face. It is found at the points halfway between the nodes and at the nodes
  !! inside the elements, of at most MOST x MOST elements.
  real(wp) function deviation(geo, m, face) result(d)
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: m                  !! degree of the elements, 1 or 2
    integer, intent(in) :: face
    integer, parameter :: MOST = 16
    real(wp) :: x(3, 0:2*m, 0:2*m), h(3), n(3), w(0:m, 0:2*m)
    integer :: along(2), a, b, i, j, p, q, at(3)

    d = 0.0_wp
    w = reshape([1.0_wp, 0.0_wp, 0.5_wp, 0.5_wp, 0.0_wp, 1.0_wp], [2, 3])
    if (m == 2) w = reshape([8, 0, 0, 3, 6, -1, 0, 8, 0, -1, 6, 3, 0, 0, 8]/8.0_wp, [3, 5])
    along = pack([1, 2, 3], [1, 2, 3] /= axis_of(face))
    at = side_of(face)*2*m*geo%n
    do j = 0, geo%n(along(2)) - 1, 1 + (geo%n(along(2)) - 1)/MOST
      do i = 0, geo%n(along(1)) - 1, 1 + (geo%n(along(1)) - 1)/MOST
        do b = 0, 2*m
          do a = 0, 2*m
            at(along) = 2*m*[i, j] + [a, b]
            x(:, a, b) = point(geo, parameters_at(geo, 2*m, at))
          end do
        end do
        do b = 1, 2*m - 1
          do a = 1, 2*m - 1
            h = 0.0_wp
            do q = 0, m
              do p = 0, m
                h = h + w(p, a)*w(q, b)*x(:, 2*p, 2*q)
              end do
            end do
            n = cross(x(:, a + 1, b) - x(:, a - 1, b), x(:, a, b + 1) - x(:, a, b - 1))
            if (norm2(n) > 0.0_wp) d = max(d, abs(dot_product(h - x(:, a, b), n))/norm2(n))
          end do
        end do
      end do
    end do
  end function deviation

  !> Make the nodes of all lattice points except on enriched faces, which have control points
  !! instead.
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

  !> Mark the faces on which a lattice point lies: bit f-1 of the mask is set for face f.
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

  !> Make a block for each type of element that occurs, with room for the elements of this type.
  subroutine make_blocks(spec, geo, layer, draft, error)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    type(draft_t), intent(inout) :: draft
    type(error_t), allocatable, intent(out) :: error
    type(element_t) :: row
    type(cell_t) :: cell
    character(:), allocatable :: name
    integer :: nhexa(size(layer%surface)), nprism(size(layer%surface))
    integer :: at(2), i, j, k, s, m, nbulk

    m = layer%lattice%m
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
    allocate (layer%hexa(size(nhexa)), layer%prism(size(nhexa)), source=0)
    if (nbulk > 0) then
      call find_row(spec, spec%type, row, error)
      if (allocated(error)) return
      call new_block(draft, spec, trim(spec%type), row, [m, m, m], (m + 1)**3, nbulk, layer%bulk)
      call row%rule(cell, spec%q, spec%qz, draft%block(layer%bulk)%rule)
    end if
    do s = 1, size(nhexa)
      associate (e => spec%enrich(s), surface => layer%surface(s))
        name = 'Q1N'
        if (e%eas) name = 'Q1E9N'
        if (e%tapered) name = 'Q1E9NT'
        if (spec%type == 'Q2') name = 'Q2N'
        call find_row(spec, name, row, error)
        if (allocated(error)) return
        name = 'Q1N' ! name in reports: Q1N2, Q1N2.1, Q1E9N2, Q1E9N2T or Q2N2
        if (e%eas) name = 'Q1E9N'
        if (spec%type == 'Q2') name = 'Q2N'
        name = name//to_text(e%degree)
        if (e%raise > 0) name = name//'.'//to_text(e%raise)
        if (e%tapered) name = name//'T'
        if (row%nmode == 0) then ! hexahedra and prisms have the same rule and share a block
          call layer_block(spec, surface, name, row, m, nhexa(s) + nprism(s), 0, draft, &
                           layer%hexa(s))
          layer%prism(s) = layer%hexa(s)
        else
          call layer_block(spec, surface, name, row, m, nhexa(s), 0, draft, layer%hexa(s))
          call layer_block(spec, surface, name, row, m, nprism(s), 3, draft, layer%prism(s))
        end if
      end associate
    end do
  end subroutine make_blocks

  !> Warn once if elements have too few integration points. The functions of an enriched element on
  !! the face opposite to its isogeometric one are those of the other elements of the body.
  subroutine check_points(spec, geo, layer, draft)
    type(patch_spec_t), intent(in) :: spec
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(in) :: layer
    type(draft_t), intent(in) :: draft
    integer :: least, l

    if (spec%q == 0) return
    least = layer%lattice%m + 1
    if (spec%q < least .or. (spec%qz > 0 .and. spec%qz < least)) then
      call warn_few_points(spec, draft%block(1)%name, 'at least '//to_text(least) &
                           //' points in each direction')
      return
    end if
    do l = 1, size(layer%surface)
      associate (s => layer%surface(l))
        if (.not. splines_lack_points([spec%q, spec%q], shape(s%node), geo%n(s%dir))) cycle
        call warn_few_points(spec, draft%block(max(layer%hexa(l), layer%prism(l)))%name, &
                             'QUADrature '//to_text(max(least, maxval(s%degree) + 1)))
        return
      end associate
    end do
  end subroutine check_points

  !> Make one block of an enriched layer. If there are no elements, `ib` is 0.
  subroutine layer_block(spec, s, name, row, m, nelem, least, draft, ib)
    type(patch_spec_t), intent(in) :: spec
    type(surface_t), intent(in) :: s
    character(*), intent(in) :: name
    type(element_t), intent(in) :: row
    integer, intent(in) :: m, nelem
    integer, intent(in) :: least !! smallest number of integration points across the layer
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: ib
    type(cell_t) :: cell
    integer :: ncp

    ib = 0
    if (nelem == 0) return
    cell%degree = [s%degree(s%xi), s%degree(s%eta), m]
    ncp = (cell%degree(1) + 1)*(cell%degree(2) + 1)
    call new_block(draft, spec, name, row, cell%degree, ncp + m*(m + 1)**2, nelem, ib)
    if (s%rational) allocate (draft%block(ib)%ext%w(ncp, nelem))
    call row%rule(cell, spec%q, max(spec%qz, least), draft%block(ib)%rule)
  end subroutine layer_block

  !> Add a Lagrange element that touches no enriched face.
  subroutine add_bulk(geo, layer, cell, draft)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(in) :: layer
    integer, intent(in) :: cell(3)
    type(draft_t), intent(inout) :: draft
    !> Corners in the order of FEAP and VTK.
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

  !> Add an enriched hexahedron (it = 0), or the prism of surface `is` in a cell at the edge that
  !! the surfaces `is` and `it` share.
  subroutine add_enriched(geo, layer, cell, is, it, draft)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3), is, it
    type(draft_t), intent(inout) :: draft
    integer, allocatable :: node(:)
    real(wp), allocatable :: w(:)
    integer :: m, i, j, l, a, e, f, ib, ncp

    ib = layer%hexa(is)
    if (it > 0) ib = layer%prism(is)
    m = layer%lattice%m
    associate (s => layer%surface(is))
      ncp = (s%degree(s%xi) + 1)*(s%degree(s%eta) + 1)
      allocate (node(ncp + m*(m + 1)**2), w(ncp))
      call surface_functions(s, cell, node(:ncp), w)
      a = ncp
      do l = 1, m
        do j = 0, m
          do i = 0, m
            a = a + 1
            call find_node(geo, layer, cell, is, it, [i, j, l], draft, node(a))
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
      do f = 1, 6
        if (.not. is_at(geo%n, cell, f)) cycle
        if (it > 0) then
          if (f == layer%surface(it)%face) cycle            ! this side is the diagonal plane
          if (axis_of(f) == s%axis .and. f /= s%face) cycle ! this side is collapsed
        end if
        call add_face(draft, f, ib, e, local_side(s, f))
      end do
    end associate
  end subroutine add_enriched

  !> Find the Lagrange node (i,j,l) of an enriched element: i is its index along xi, j along eta,
  !! and l across the layer, from the surface. In a prism, all lines that start at the surface end
  !! at the opposite edge.
  subroutine find_node(geo, layer, cell, is, it, ijl, draft, node)
    type(geometry_t), intent(in) :: geo
    type(layer_t), intent(inout) :: layer
    integer, intent(in) :: cell(3), is, it, ijl(3)
    type(draft_t), intent(inout) :: draft
    integer, intent(out) :: node
    integer :: m, i(3), on_surface(3), on_edge(3), depth, third, mask

    m = layer%lattice%m
    associate (s => layer%surface(is))
      i(s%xi) = ijl(1)
      i(s%eta) = ijl(2)
      i(s%axis) = merge(ijl(3), m - ijl(3), s%side == 0)
      i = i + m*(cell - 1)
      if (it > 0) then
        associate (t => layer%surface(it))
          depth = i(t%axis) - m*(cell(t%axis) - 1)
          if (t%side /= 0) depth = m - depth ! depth below the other surface
          if (m == 2 .and. ijl(3) == 1 .and. depth == 1) then
            ! inside a Q2 prism, half way between the surface and the opposite edge
            third = 6 - s%axis - t%axis
            node = layer%middle(i(third), is, it)
            if (node > 0) return
            on_surface = i
            on_surface(s%axis) = i(s%axis) + merge(-1, 1, s%side == 0)
            on_edge = i
            on_edge(s%axis) = i(s%axis) + merge(1, -1, s%side == 0)
            on_edge(t%axis) = i(t%axis) + merge(1, -1, t%side == 0)
            mask = iand(border_mask(layer%lattice, i), shiftl(3, 2*third - 2))
            call add_node(draft, 0.5_wp*(point(geo, parameters_at(geo, 2, on_surface)) &
                                         + point(geo, parameters_at(geo, 2, on_edge))), .false., &
                          mask, node)
            layer%middle(i(third), is, it) = node
            return
          end if
          ! the point at level l on the line from the surface point at this depth to the opposite
          ! edge
          depth = depth + (m - depth)*ijl(3)/m
          i(t%axis) = m*(cell(t%axis) - 1) + merge(depth, m - depth, t%side == 0)
        end associate
      end if
    end associate
    node = layer%lattice%node(i(1), i(2), i(3))
  end subroutine find_node

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

  !> Does a cell touch a face of the patch?
  pure logical function is_at(n, cell, face)
    integer, intent(in) :: n(3), cell(3), face

    is_at = cell(axis_of(face)) == merge(1, n(axis_of(face)), side_of(face) == 0)
  end function is_at

end module patch_lagrange
