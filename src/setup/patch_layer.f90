!> The element blocks of a body of Lagrange elements and of its enriched layers.
module patch_layer
  use base_error, only: error_t
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  use patch_draft, only: draft_t, new_block
  use patch_geometry, only: geometry_t
  use patch_lattice, only: lattice_t
  use patch_rows, only: find_row
  use patch_spec, only: patch_spec_t, enrich_t
  use patch_surface, only: surface_t, axis_of, side_of
  implicit none
  private
  public :: layer_t, make_blocks, surfaces_at, is_at

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

end module patch_layer
