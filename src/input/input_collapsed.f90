!> Finds elements with an edge of length zero whose nodes are not joined, as in a patch with such a
!! side, or in a BLOCk with two masters at the same point. The displacement then has several values
!! at the edge: a crack begins there, and a force at the edge acts on one of the coincident nodes.
module input_collapsed
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: boundary_t
  use element_type, only: cell_t
  use input_doubts, only: element_text, member_t, place_of
  use input_draft, only: draft_t
  use mesh, only: block_t, block_cell, is_rigid, mesh_t
  implicit none
  private
  public :: warn_collapsed

  !> Corners closer than this times the size of their element coincide, and functions that differ
  !! by less are equal.
  real(wp), parameter :: NEAR = 1.0e-9_wp

contains

  !> Warn of such elements, once all nodes are joined.
  subroutine warn_collapsed(draft, mesh, bc)
    type(draft_t), intent(in) :: draft
    type(mesh_t), intent(in) :: mesh
    type(boundary_t), intent(in) :: bc
    type(member_t) :: first
    character(:), allocatable :: text
    integer :: b, e, n
    logical :: torn

    n = 0
    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        associate (node => mesh%block(b)%conn(:, e))
          torn = is_torn(mesh%block(b), mesh%xr(:, node), all(bc%fixed(:, node) /= 0, 1), e)
        end associate
        if (.not. torn) cycle
        n = n + 1
        if (n == 1) first = member_t(b, e)
      end do
    end do
    if (n == 0) return
    text = element_text(mesh, first)//' has an edge of length zero whose nodes are not joined, ' &
           //'so that they can move apart'
    if (n > 1) text = text//' (the first of '//to_text(n)//' such elements)'
    call warn(text, place_of(draft, mesh, first), 'add TIE, which joins them')
  end subroutine warn_collapsed

  !> Are two corners, of one edge or not, at the same point without having the same displacement?
  !! Nodes that are held in all directions do not count.
  logical function is_torn(block, x, held, e)
    type(block_t), intent(in) :: block
    real(wp), intent(in) :: x(:, :)         !! (3, nen) reference positions [L]
    logical, intent(in) :: held(:)          !! (nen) the node cannot move freely in any direction
    integer, intent(in) :: e
    type(cell_t) :: cell
    real(wp) :: shp(block%nen, 8), dshp(3, block%nen), at(3, 8), size_of
    integer :: i, j

    is_torn = .false.
    size_of = maxval(maxval(x, 2) - minval(x, 2))
    call block_cell(block, e, cell)
    do i = 1, 8
      call block%row%functions(cell, real([merge(1, -1, btest(i - 1, 0)), &
                                           merge(1, -1, btest(i - 1, 1)), &
                                           merge(1, -1, btest(i - 1, 2))], wp), shp(:, i), dshp)
      at(:, i) = matmul(x - spread(x(:, 1), 2, block%nen), shp(:, i))
      do j = 1, i - 1
        if (norm2(at(:, i) - at(:, j)) > NEAR*size_of) cycle
        is_torn = differ(block%conn(:, e), held, shp(:, i) - shp(:, j))
        if (is_torn) return
      end do
    end do
  end function is_torn

  !> Does a sum over nodes depend on their values? A node may have several terms.
  pure logical function differ(node, held, term)
    integer, intent(in) :: node(:)
    logical, intent(in) :: held(:)          !! the value is given, so that it does not matter
    real(wp), intent(in) :: term(:)
    integer :: i

    differ = any([(abs(sum(term, mask=node == node(i))) > NEAR .and. .not. held(i), &
                   i=1, size(node))])
  end function differ

end module input_collapsed
