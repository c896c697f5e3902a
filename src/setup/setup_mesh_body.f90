!> MESH at the END of the mesh part: materials and node numbers of files become those of the model.
module setup_mesh_body
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_sort, only: find
  use base_text, only: to_text, quoted
  use constraint, only: add_constraint
  use mesh, only: mesh_t
  use mesh_body, only: build_mesh
  use setup_build, only: build_t
  use setup_material, only: material_index
  use setup_where, only: body_index
  implicit none
  private
  public :: make_mesh_body, find_label

contains

  !> Append the body of the i-th entry and its hanging nodes.
  subroutine make_mesh_body(build, i, mesh, error)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: i
    type(mesh_t), intent(inout) :: mesh
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: node(:)
    integer :: j, k

    associate (spec => build%patch(i)%mesh)
      do j = 1, size(spec%material)
        spec%material(j)%index = material_index(build, spec%material(j)%number)
      end do
      call build_mesh(spec, mesh, error)
      if (allocated(error)) return
      associate (list => spec%constraint)
        do j = 1, list%n
          node = [list%slave(j), list%master(list%first(j):list%first(j + 1) - 1)]
          do k = 1, size(node)
            call find_label(mesh, spec%spec%name, spec%constraint_place, node(k), error)
            if (allocated(error)) return
          end do
          call add_constraint(mesh%constraint, node(1), node(2:), &
                              list%c(list%first(j):list%first(j + 1) - 1), list%place(j))
        end do
      end associate
    end associate
  end subroutine make_mesh_body

  !> From a number in the file of a MESH to the node.
  subroutine find_label(mesh, name, place, node, error)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: name         !! of the mesh
    type(place_t), intent(in) :: place       !! of the table that refers to it
    integer, intent(inout) :: node
    type(error_t), allocatable, intent(out) :: error
    integer :: b, n

    b = body_index(mesh, name)
    n = 0
    if (b > 0) then
      if (allocated(mesh%body(b)%label)) n = find(mesh%body(b)%label, node)
    end if
    if (n == 0) then
      call fail(error, DECK_ERROR, 'node '//to_text(node)//' is not in mesh '//quoted(name), &
                place, 'tables name the nodes by their numbers in the file of the mesh')
    else
      node = mesh%body(b)%node(n)
    end if
  end subroutine find_label

end module setup_mesh_body
