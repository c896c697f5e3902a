!> Sparse matrices of 3x3 blocks, one block row a node: pattern, values and element maps.
!!
!! A symmetric matrix stores the blocks on and above the diagonal (row node <= column node); its
!! diagonal blocks are kept full, so that elements may add to them without looking.
!! Every node has a diagonal block. Columns ascend within a row.
module csr_pattern
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, BUG, SYSTEM_ERROR
  use base_text, only: to_text
  implicit none
  private
  public :: block_matrix_t, clique_t, new_pattern, element_map, block_position, set_zero

  !> Block positions of one element, conn(nen), or of all elements of a block, conn(nen, nelem).
  interface element_map
    module procedure map_one
    module procedure map_all
  end interface element_map

  !> Nodes that are all coupled with each other, one column a clique: the elements of a block, or
  !! pairs in contact.
  type :: clique_t
    integer, allocatable :: conn(:, :) !! (nen, nelem) nodes; a node may stand twice
  end type clique_t

  !> The matrix.
  type :: block_matrix_t
    integer :: nnode = 0
    logical :: symmetric = .true.          !! upper blocks only
    integer, allocatable :: row(:)         !! (nnode+1) first block of each row
    integer, allocatable :: col(:)         !! (nblock) column node of each block
    real(wp), allocatable :: val(:, :, :)  !! (3, 3, nblock) row dof, column dof, block
  end type block_matrix_t

  !> Which cliques a node belongs to.
  type :: incidence_t
    integer, allocatable :: first(:)  !! (nnode+1)
    integer, allocatable :: group(:)  !! index into the array of cliques
    integer, allocatable :: elem(:)   !! column of its conn
  end type incidence_t

contains

  !> Pattern of a matrix that couples the nodes of each clique; values zero.
  subroutine new_pattern(a, nnode, cliques, symmetric, error)
    type(block_matrix_t), intent(out) :: a
    integer, intent(in) :: nnode
    type(clique_t), intent(in) :: cliques(:)
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error

    type(incidence_t) :: inc
    integer, allocatable :: count(:)
    integer :: stat

    a%nnode = nnode
    a%symmetric = symmetric
    call find_incidence(nnode, cliques, inc, error)
    if (allocated(error)) return
    allocate (count(nnode))
    call walk_columns(a, cliques, inc, count, counting=.true.)
    call check_size(sum(int(count, i8)), error)
    if (allocated(error)) return
    call set_row_starts(a%row, count)
    allocate (a%col(a%row(nnode + 1) - 1), stat=stat)
    if (stat == 0) allocate (a%val(3, 3, size(a%col)), stat=stat)
    if (stat /= 0) then
      call fail(error, SYSTEM_ERROR, 'no memory for the tangent matrix')
      return
    end if
    call walk_columns(a, cliques, inc, count, counting=.false.)
    call set_zero(a)
  end subroutine new_pattern

  !> Positions of scalar entries are default integers: 9 a block must fit.
  subroutine check_size(nblock, error)
    integer(i8), intent(in) :: nblock
    type(error_t), allocatable, intent(out) :: error

    if (9*nblock <= int(huge(1), i8)) return
    call fail(error, SYSTEM_ERROR, 'the tangent matrix would have '//to_text(9*nblock) &
              //' entries, more than '//to_text(huge(1)), hint='use a coarser mesh')
  end subroutine check_size

  !> Cliques of every node, by counting.
  subroutine find_incidence(nnode, cliques, inc, error)
    integer, intent(in) :: nnode
    type(clique_t), intent(in) :: cliques(:)
    type(incidence_t), intent(out) :: inc
    type(error_t), allocatable, intent(out) :: error

    integer, allocatable :: count(:)
    integer :: g, e, a, i

    allocate (count(nnode))
    count = 0
    do g = 1, size(cliques)
      if (size(cliques(g)%conn) == 0) cycle
      if (minval(cliques(g)%conn) < 1 .or. maxval(cliques(g)%conn) > nnode) then
        call fail(error, BUG, 'an element of the pattern refers to a node that does not exist')
        return
      end if
      do e = 1, size(cliques(g)%conn, 2)
        do a = 1, size(cliques(g)%conn, 1)
          count(cliques(g)%conn(a, e)) = count(cliques(g)%conn(a, e)) + 1
        end do
      end do
    end do
    call check_size(sum(int(count, i8)), error)
    if (allocated(error)) return
    call set_row_starts(inc%first, count)
    allocate (inc%group(inc%first(nnode + 1) - 1), inc%elem(inc%first(nnode + 1) - 1))
    count = inc%first(1:nnode)
    do g = 1, size(cliques)
      do e = 1, size(cliques(g)%conn, 2)
        do a = 1, size(cliques(g)%conn, 1)
          i = cliques(g)%conn(a, e)
          inc%group(count(i)) = g
          inc%elem(count(i)) = e
          count(i) = count(i) + 1
        end do
      end do
    end do
  end subroutine find_incidence

  !> Column after column, so that every row comes out sorted without sorting.
  subroutine walk_columns(a, cliques, inc, count, counting)
    type(block_matrix_t), intent(inout) :: a
    type(clique_t), intent(in) :: cliques(:)
    type(incidence_t), intent(in) :: inc
    integer, intent(inout) :: count(:) !! (nnode) blocks found so far in each row
    logical, intent(in) :: counting    !! .true.: first pass, no column is stored

    integer, allocatable :: mark(:)
    integer :: i, j, k, b

    allocate (mark(a%nnode))
    mark = 0
    count = 0
    do j = 1, a%nnode
      ! The diagonal block leads its row, and is there even where no element touches the node.
      if (a%symmetric .or. inc%first(j) == inc%first(j + 1)) call put(j)
      do k = inc%first(j), inc%first(j + 1) - 1
        associate (conn => cliques(inc%group(k))%conn)
          do b = 1, size(conn, 1)
            i = conn(b, inc%elem(k))
            if (a%symmetric .and. i > j) cycle
            if (mark(i) /= j) call put(i)
          end do
        end associate
      end do
    end do

  contains

    subroutine put(i)
      integer, intent(in) :: i

      mark(i) = j
      count(i) = count(i) + 1
      if (.not. counting) a%col(a%row(i) + count(i) - 1) = j
    end subroutine put

  end subroutine walk_columns

  !> Running sum of counts.
  subroutine set_row_starts(row, count)
    integer, allocatable, intent(out) :: row(:)
    integer, intent(in) :: count(:)

    integer :: i

    allocate (row(size(count) + 1))
    row(1) = 1
    do i = 1, size(count)
      row(i + 1) = row(i) + count(i)
    end do
  end subroutine set_row_starts

  !> Block positions of the node pairs of every element of a block.
  subroutine map_all(a, conn, map, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: conn(:, :)     !! (nen, nelem)
    integer, intent(out) :: map(:, :, :)  !! (nen, nen, nelem)
    type(error_t), allocatable, intent(out), optional :: error !! a pair is not in the pattern

    integer :: e

    do e = 1, size(conn, 2)
      call map_one(a, conn(:, e), map(:, :, e), error)
      if (.not. present(error)) cycle
      if (allocated(error)) return
    end do
  end subroutine map_all

  !> Block positions of the node pairs of one element.
  !!
  !! map(b1, b2) is the block of row node conn(b1) and column node conn(b2); 0 where a symmetric
  !! matrix stores the transpose instead. Where b1 /= b2 are the same node, both pairs lead to its
  !! diagonal block.
  subroutine map_one(a, conn, map, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: conn(:)    !! (nen)
    integer, intent(out) :: map(:, :) !! (nen, nen)
    type(error_t), allocatable, intent(out), optional :: error

    integer :: b1, b2
    logical :: complete

    complete = .true.
    do b2 = 1, size(conn)
      do b1 = 1, size(conn)
        map(b1, b2) = 0
        if (a%symmetric .and. conn(b1) > conn(b2)) cycle
        map(b1, b2) = block_position(a, conn(b1), conn(b2))
        if (map(b1, b2) == 0) complete = .false.
      end do
    end do
    if (complete .or. .not. present(error)) return
    call fail(error, BUG, 'an element is not in the pattern of the tangent matrix')
  end subroutine map_one

  !> Position of the block (i, j); 0 where it is not stored.
  pure integer function block_position(a, i, j) result(p)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: i !! row node
    integer, intent(in) :: j !! column node

    integer :: low, high

    low = a%row(i)
    high = a%row(i + 1) - 1
    do while (low <= high)
      p = low + (high - low)/2
      if (a%col(p) == j) return
      if (a%col(p) < j) then
        low = p + 1
      else
        high = p - 1
      end if
    end do
    p = 0
  end function block_position

  !> Make all values zero, keep the pattern.
  pure subroutine set_zero(a)
    type(block_matrix_t), intent(inout) :: a

    a%val = 0.0_wp
  end subroutine set_zero

end module csr_pattern
