!> Node numbers of the deck that name nodes of a MESH which have other numbers in its file.
module input_numbers
  use base_error, only: place_t
  use base_log, only: warn
  use base_sort, only: find
  use base_text, only: quoted, to_text
  use input_draft, only: draft_t
  use input_where, only: W_NODE, where_t
  use mesh, only: mesh_t
  implicit none
  private
  public :: warn_numbers, warn_number

contains

  !> Warn, once for each deck, if a record of the mesh part names a node of a MESH by its number in
  !! the model and its file has another number for it. Bodies must still have all their nodes, so
  !! this comes before TIE.
  subroutine warn_numbers(draft, mesh)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    logical :: told
    integer :: i, j

    told = .false.
    do i = 1, draft%named_nodes%place%n
      call warn_number(mesh, draft%named_nodes%node(i), draft%named_nodes%place%at(i), told)
    end do
    do i = 1, draft%nsupport
      call warn_where(draft%support(i)%at)
    end do
    do i = 1, draft%nmotion
      call warn_where(draft%motion(i)%at)
    end do
    do i = 1, draft%ncurve
      do j = 1, size(draft%curve(i)%column)
        call warn_where(draft%curve(i)%column(j)%at)
      end do
    end do

  contains

    subroutine warn_where(at)
      type(where_t), intent(in) :: at

      if (at%type == W_NODE) call warn_number(mesh, at%node, at%place, told)
    end subroutine warn_where

  end subroutine warn_numbers

  !> Warn if node n of the model has another number in its mesh file, and set `told`. Nothing is
  !! done if `told` is true, nor if TIE has joined nodes, because the numbers are then lost.
  subroutine warn_number(mesh, n, place, told)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: n
    type(place_t), intent(in) :: place
    logical, intent(inout) :: told
    character(:), allocatable :: text, hint
    integer :: b, i

    if (told) return
    do b = 1, size(mesh%body)
      associate (body => mesh%body(b))
        if (.not. allocated(body%label)) cycle
        i = n - body%node(1) + 1
        if (i < 1 .or. i > size(body%label)) cycle
        if (body%label(i) == n) return
        told = .true.
        text = 'node '//to_text(n)//' of the model is node '//to_text(body%label(i)) &
               //' of the file of '//quoted(body%name)
        i = find(body%label, n)
        if (i > 0) text = text//', and node '//to_text(n)//' of this file is node ' &
                          //to_text(body%node(1) + i - 1)//' of the model'
        if (body%node(1) > 1) then
          hint = 'nodes of COORdinates, of BLOCk and of earlier bodies come before those of the ' &
                 //'file: name nodes by position, as with POINt or CFORce'
        else
          hint = 'the model numbers nodes without gaps: name nodes by position, as with POINt ' &
                 //'or CFORce, or renumber the file (Gmsh: RenumberMeshNodes)'
        end if
        call warn(text//'; further such nodes are not reported', place, hint)
      end associate
      return
    end do
  end subroutine warn_number

end module input_numbers
