!> Element faces that a WHERE means: of a patch, or of a named set of a mesh.
module setup_faces
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use mesh, only: mesh_t, group_t
  use setup_where, only: where_t, body_index, group_index, FACE_HINT, W_FACES, W_GROUP
  implicit none
  private
  public :: find_faces

contains

  !> Element faces of the named faces of a body.
  subroutine find_faces(mesh, place, block, elem, side, error)
    type(mesh_t), intent(in) :: mesh
    type(where_t), intent(in) :: place
    integer, allocatable, intent(out) :: block(:), elem(:), side(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: b, f, g

    allocate (block(0), elem(0), side(0))
    if (place%kind /= W_FACES .and. place%kind /= W_GROUP) then
      call fail(error, DECK_ERROR, 'a face of a patch is needed here', place%place, FACE_HINT)
      return
    end if
    b = body_index(mesh, place%body)
    g = group_index(mesh%body(b), place%face)
    if (g > 0) then
      associate (group => mesh%body(b)%group(g))
        block = group%face%block
        elem = group%face%elem
        side = group%face%side
        if (group%inner > 0) then
          call fail_group(group, place, error)
        else if (size(elem) == 0) then
          call fail(error, DECK_ERROR, 'group '//quoted(group%name)//' of '//quoted(place%body) &
                    //' has no surface elements', place%face_place, 'name a physical surface')
        end if
      end associate
      return
    end if
    do f = 1, 6
      if (.not. btest(place%mask, f - 1)) cycle
      associate (face => mesh%body(b)%face(f))
        block = [block, face%block]
        elem = [elem, face%elem]
        side = [side, face%side]
      end associate
    end do
    if (size(elem) == 0) call fail(error, DECK_ERROR, quoted(place%body)//' has no such face', &
                                   place%face_place, 'a spline surface is its face 3-, or ALL')
  end subroutine find_faces

  !> Surface elements that are no faces of the body's boundary.
  subroutine fail_group(group, place, error)
    type(group_t), intent(in) :: group
    type(where_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error

    call fail(error, DECK_ERROR, to_text(group%inner)//' of the surface elements of group ' &
              //quoted(group%name)//' are no faces of the boundary of '//quoted(place%body), &
              place%face_place, 'they lie inside, or on no element: loads and contact act ' &
              //'on the boundary')
  end subroutine fail_group

end module setup_faces
