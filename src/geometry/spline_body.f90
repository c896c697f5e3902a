!> Elements of a spline surface: either a layer of enriched hexahedra between the surface and inner
!! nodes of a mesh, or a rigid surface alone.
module spline_body
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text
  use element_type, only: element_t, cell_t
  use elmt_surface, only: describe_surface => describe
  use few_points, only: warn_few_points
  use mesh, only: mesh_t
  use patch_draft, only: draft_t, add_node, new_block, add_face, append_draft, find_row
  use patch_spec, only: compose, patch_spec_t
  use spline_check, only: check_layer, orient_layer, orient_tool
  use spline_set, only: put_sets
  use spline_surface, only: spline_surface_t
  implicit none
  private
  public :: build_spline

  integer, parameter :: OUTER = 5 !! the surface is face 3- of the body
  integer, parameter :: LAYER_SIDE = 5, TOOL_SIDE = 6 !! the surface is this face of an element

  !> Elements with the same degrees and number of functions.
  type :: group_t
    integer :: degree(2) = 0, nf = 0, nelem = 0, block = 0
  end type group_t

contains

  !> Append the body to the mesh, which is not changed if there is an error.
  subroutine build_spline(spec, inner, mesh, error)
    type(patch_spec_t), intent(inout) :: spec
    integer, intent(inout) :: inner(:, :)     !! (4, nelem) nodes of the mesh; (4, 0): no layer
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    type(draft_t) :: draft
    type(element_t) :: row
    type(group_t), allocatable :: group(:)
    integer :: igroup(spec%spline%surface%nelem)
    integer, allocatable :: new(:) !! (nnode of the file) number in the body; 0: none
    logical :: used(spec%spline%surface%nnode)
    character(:), allocatable :: name
    real(wp) :: turn(3, 3), shift(3)
    integer :: a, e, first, g, number

    associate (s => spec%spline%surface)
      call compose(spec%placement, turn, shift)
      do a = 1, s%nnode
        s%x(:, a) = matmul(turn, s%x(:, a)) + shift
      end do
      if (size(inner) > 0) then
        name = 'Q1N'
        if (spec%spline%eas) name = 'Q1E9N'
        if (spec%spline%tapered) name = 'Q1E9NT'
        call find_row(spec, name, row, error)
        if (.not. allocated(error)) call orient_layer(spec, mesh%xr, inner, error)
        if (.not. allocated(error)) call check_layer(spec, mesh%xr, inner, error)
        if (allocated(error)) return
      else
        row = describe_surface()
        call orient_tool(s, spec%spline%reverse)
      end if
      used = .false. ! control points that belong to no element are left out
      used(s%node(:s%first(s%nelem + 1) - 1)) = .true.
      allocate (new(s%nnode), source=0)
      do a = 1, s%nnode
        if (used(a)) call add_node(draft, s%x(:, a), .true., ibset(0, OUTER - 1), new(a))
      end do
      call make_blocks(spec, row, size(inner) > 0, group, igroup, draft)
      if (size(inner) > 0) call check_points(spec, count(used), draft)
      call add_elements(s, inner - mesh%nnode, new, group, igroup, draft)
    end associate
    call append_draft(draft, spec, mesh)
    call put_sets(spec%spline%surface, new, igroup, OUTER, mesh)
    ! Elements are numbered for the user in the order of the file, after the elements of other
    ! bodies.
    first = size(mesh%block) - size(group)
    number = minval(mesh%block(first + 1)%number) - 1
    do g = 1, size(group)
      mesh%block(first + g)%number = pack([(number + e, e=1, size(igroup))], igroup == g)
    end do
  end subroutine build_spline

  !> Group the elements, and make a block for each group. The name of a block in reports is, for
  !! example, Q1N3, Q1E9N3, Q1E9N3T or RIGId.
  subroutine make_blocks(spec, row, is_layer, group, igroup, draft)
    type(patch_spec_t), intent(in) :: spec
    type(element_t), intent(in) :: row
    logical, intent(in) :: is_layer
    type(group_t), allocatable, intent(out) :: group(:)
    integer, intent(out) :: igroup(:) !! (nelem) group of each element
    type(draft_t), intent(inout) :: draft
    character(:), allocatable :: name
    type(cell_t) :: cell
    type(group_t) :: new
    integer :: e, g, nen

    associate (s => spec%spline%surface)
      allocate (group(0))
      do e = 1, s%nelem
        new%degree = s%degree(:, e)
        new%nf = s%first(e + 1) - s%first(e)
        do g = size(group), 1, -1
          if (group(g)%nf == new%nf .and. all(group(g)%degree == new%degree)) exit
        end do
        if (g == 0) then
          group = [group, new]
          g = size(group)
        end if
        group(g)%nelem = group(g)%nelem + 1
        igroup(e) = g
      end do
    end associate
    do g = 1, size(group)
      cell%degree = [group(g)%degree, merge(1, 0, is_layer)]
      nen = group(g)%nf + merge(4, 0, is_layer)
      name = 'RIGId'
      if (is_layer) then
        name = 'Q1N'//to_text(maxval(group(g)%degree))
        if (spec%spline%eas) name = 'Q1E9N'//to_text(maxval(group(g)%degree))
        if (spec%spline%tapered) name = name//'T'
      end if
      call new_block(draft, spec, name, row, cell%degree, nen, group(g)%nelem, group(g)%block)
      associate (b => draft%block(group(g)%block))
        deallocate (b%ext%iop) ! an element has one operator, not one for each direction
        allocate (b%ext%isurface(group(g)%nelem), source=0)
        if (spec%spline%surface%rational) allocate (b%ext%w(group(g)%nf, group(g)%nelem))
        call row%rule(cell, spec%q, spec%qz, b%rule)
      end associate
    end do
  end subroutine make_blocks

  !> Warn if the elements of a layer have too few integration points: fewer than two across the
  !! layer, or, on the whole surface, fewer than there are control points.
  subroutine check_points(spec, ncp, draft)
    type(patch_spec_t), intent(in) :: spec
    integer, intent(in) :: ncp !! number of control points
    type(draft_t), intent(in) :: draft

    if (spec%q == 0) return
    associate (s => spec%spline%surface)
      if (spec%q > 1 .and. spec%qz /= 1 .and. s%nelem*spec%q**2 >= ncp) return
      call warn_few_points(spec, draft%block(1)%name, 'at least '//to_text(maxval(s%degree) + 1) &
                           //' points in the directions of the surface and 2 across the layer')
    end associate
  end subroutine check_points

  !> Set nodes, weights, operators and faces of all elements.
  subroutine add_elements(s, inner, new, group, igroup, draft)
    type(spline_surface_t), intent(in) :: s
    integer, intent(in) :: inner(:, :)  !! (4, nelem) nodes minus mesh%nnode (append_draft adds it)
    integer, intent(in) :: new(:), igroup(:)
    type(group_t), intent(in) :: group(:)
    type(draft_t), intent(inout) :: draft
    integer :: e, g, n, own(s%nop)

    do g = 1, size(group)
      own = 0
      associate (b => draft%block(group(g)%block))
        do e = 1, s%nelem
          if (igroup(e) /= g) cycle
          b%nelem = b%nelem + 1
          associate (node => s%node(s%first(e):s%first(e + 1) - 1))
            b%conn(:group(g)%nf, b%nelem) = new(node)
            if (allocated(b%ext%w)) b%ext%w(:, b%nelem) = s%w(node)
          end associate
          if (size(inner) > 0) b%conn(group(g)%nf + 1:, b%nelem) = inner(:, e)
          if (own(s%iop(e)) == 0) own(s%iop(e)) = maxval(own) + 1
          b%ext%isurface(b%nelem) = own(s%iop(e))
          call add_face(draft, OUTER, group(g)%block, b%nelem, &
                        merge(LAYER_SIDE, TOOL_SIDE, size(inner) > 0))
        end do
        allocate (b%ext%surface(maxval(own)))
        do n = 1, s%nop
          if (own(n) > 0) b%ext%surface(own(n))%c = s%op(n)%c
        end do
      end associate
    end do
  end subroutine add_elements

end module spline_body
