!> SPLIne at the END of the mesh: numbers of its tables become nodes of the mesh.
module setup_spline_body
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use constraint, only: add_constraint
  use mesh, only: mesh_t
  use patch_spec, only: patch_spec_t
  use setup_build, only: build_t
  use setup_mesh_body, only: find_label
  use setup_where, only: body_index
  use spline_body, only: build_spline
  implicit none
  private
  public :: make_spline

contains

  !> Append the body of a SPLIne and its hanging nodes.
  subroutine make_spline(build, spec, mesh, error)
    type(build_t), intent(in) :: build
    type(patch_spec_t), intent(inout) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: inner(:, :)
    integer :: c, e

    allocate (inner(4, 0))
    if (spec%spline%has_layer) then
      inner = spec%spline%inner
      do e = 1, size(inner, 2)
        do c = 1, 4
          call resolve_node(build, mesh, spec, spec%spline%layer_place, inner(c, e), error)
          if (allocated(error)) return
        end do
      end do
    end if
    call build_spline(spec, inner, mesh, error)
    if (.not. allocated(error)) call add_constraints(build, spec, mesh, error)
  end subroutine make_spline

  !> The hanging nodes of its mesh, and those that control points are.
  subroutine add_constraints(build, spec, mesh, error)
    type(build_t), intent(in) :: build
    type(patch_spec_t), intent(in) :: spec
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:)
    integer :: i, j

    associate (list => spec%spline%constraint)
      do i = 1, list%n
        node = [list%slave(i), list%master(list%first(i):list%first(i + 1) - 1)]
        do j = 1, size(node)
          if (node(j) < 0) then
            call resolve_control(mesh, spec, node(j), error)
          else
            call resolve_node(build, mesh, spec, spec%spline%constraint_place, node(j), error)
          end if
          if (allocated(error)) return
        end do
        call add_constraint(mesh%constraint, node(1), node(2:), &
                            list%c(list%first(i):list%first(i + 1) - 1), list%place(i))
      end do
    end associate
  end subroutine add_constraints

  !> From -k to the node that is control point k of the surface, whose body is the last.
  subroutine resolve_control(mesh, spec, node, error)
    type(mesh_t), intent(in) :: mesh
    type(patch_spec_t), intent(in) :: spec
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error
    logical, allocatable :: has(:)

    associate (s => spec%spline%surface)
      allocate (has(max(s%nnode, -node)), source=.false.)
      has(s%node(:s%first(s%nelem + 1) - 1)) = .true.
      if (has(-node)) then
        node = mesh%body(size(mesh%body))%node(count(has(:-node)))
        return
      end if
    end associate
    call fail(error, DECK_ERROR, 'control point '//to_text(-node)//' of spline ' &
              //quoted(spec%name)//' has no function', spec%spline%constraint_place, &
              'a master -k is control point k of the surface, which has 1 to ' &
              //to_text(spec%spline%surface%nnode))
  end subroutine resolve_control

  !> From the number in a table to the node.
  subroutine resolve_node(build, mesh, spec, place, node, error)
    type(build_t), intent(in) :: build
    type(mesh_t), intent(in) :: mesh
    type(patch_spec_t), intent(in) :: spec
    type(place_t), intent(in) :: place
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error

    if (allocated(spec%spline%mesh)) then
      if (body_index(mesh, spec%spline%mesh) == 0) then
        call fail(error, DECK_ERROR, 'mesh '//quoted(spec%spline%mesh)//' is not defined', &
                  spec%spline%mesh_place, 'its MESH stands before this SPLIne; leave the name ' &
                  //'out where the nodes are those of the deck')
      else
        call find_label(mesh, spec%spline%mesh, place, node, error)
      end if
      return
    end if
    if (node <= build%nodes%top) then
      if (build%nodes%given(node)) return
    end if
    call fail(error, DECK_ERROR, 'a table of spline '//quoted(spec%name)//' refers to node ' &
              //to_text(node)//', which is not defined', place, &
              'the deck has nodes 1 to '//to_text(build%nodes%top))
  end subroutine resolve_node

end module setup_spline_body
