!> Sparse matrices of 3x3 blocks with one block row for each node: pattern, values, products with
!! vectors, and the addition of element matrices.
!!
!! A symmetric matrix stores the blocks on and above the diagonal (row node <= column node). Its
!! diagonal blocks are stored in full, so that elements can be added without a special case. Every
!! node has a diagonal block. Columns ascend within a row.
module csr
  use base_kinds, only: wp, i8
  use base_comm, only: total_of => total
  use base_error, only: error_t, fail, BUG, SYSTEM_ERROR
  use base_text, only: to_text
  use element_type, only: NB
  implicit none
  private
  public :: block_matrix_t, clique_t, new_pattern, element_map, block_position, set_zero, &
            multiply, multiply_free, row_sums, add_element, add_batch, share_rows, sum_diagonal, &
            diagonal_block

  !> Positions of the 3x3 blocks of one element, conn(nen), or of all elements of an element block,
  !! conn(nen, nelem).
  interface element_map
    module procedure map_one
    module procedure map_all
  end interface element_map

  !> Groups of nodes, one in each column of conn; all nodes of a group are coupled with each other.
  !! A group consists of the nodes of an element, or of a pair in contact.
  type :: clique_t
    integer, allocatable :: conn(:, :) !! (nen, nelem) nodes; a node may occur twice
  end type clique_t

  type :: block_matrix_t
    integer :: nnode = 0
    logical :: symmetric = .true.          !! only the upper blocks are stored
    integer, allocatable :: row(:)         !! (nnode+1) index of the first block of each row
    integer, allocatable :: col(:)         !! (nblock) column node of each block
    real(wp), allocatable :: val(:, :, :)  !! (3, 3, nblock) row dof, column dof, block
    logical :: shared = .false.            !! the matrix is the sum of the parts of all ranks
    real(wp), allocatable, private :: diagonal(:, :, :) !! (3, 3, nnode) diagonal blocks of this sum
  end type block_matrix_t

  !> The cliques to which each node belongs.
  type :: incidence_t
    integer, allocatable :: first(:)  !! (nnode+1) index at which the cliques of a node begin
    integer, allocatable :: group(:)  !! index into the array of cliques
    integer, allocatable :: elem(:)   !! column of the array conn
  end type incidence_t

contains

  !> Make a matrix of zeros whose pattern couples the nodes of each clique.
  subroutine new_pattern(a, nnode, cliques, symmetric, error)
    type(block_matrix_t), intent(out) :: a
    integer, intent(in) :: nnode
    type(clique_t), intent(in) :: cliques(:)
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error
    type(incidence_t) :: inc
    integer, allocatable :: count(:)
    integer :: e, g, i, n, stat

    a%nnode = nnode
    a%symmetric = symmetric
    allocate (count(nnode)) ! at first, the number of cliques of each node
    count = 0
    do g = 1, size(cliques)
      if (size(cliques(g)%conn) == 0) cycle
      if (minval(cliques(g)%conn) < 1 .or. maxval(cliques(g)%conn) > nnode) then
        call fail(error, BUG, 'an element refers to a node outside the range 1 to ' &
                  //to_text(nnode))
        return
      end if
      do e = 1, size(cliques(g)%conn, 2)
        do n = 1, size(cliques(g)%conn, 1)
          count(cliques(g)%conn(n, e)) = count(cliques(g)%conn(n, e)) + 1
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
        do n = 1, size(cliques(g)%conn, 1)
          i = cliques(g)%conn(n, e)
          inc%group(count(i)) = g
          inc%elem(count(i)) = e
          count(i) = count(i) + 1
        end do
      end do
    end do
    call walk_columns(a, cliques, inc, count, counting=.true.)
    call check_size(sum(int(count, i8)), error)
    if (allocated(error)) return
    call set_row_starts(a%row, count)
    allocate (a%col(a%row(nnode + 1) - 1), stat=stat)
    if (stat == 0) allocate (a%val(3, 3, size(a%col)), stat=stat)
    if (stat /= 0) then
      call fail(error, SYSTEM_ERROR, 'not enough memory for the tangent matrix')
      return
    end if
    call walk_columns(a, cliques, inc, count, counting=.false.)
    call set_zero(a)
  end subroutine new_pattern

  !> Check that the positions of scalar entries, 9 for each block, fit into default integers. Before
  !! the blocks are counted, this is checked for the number of nodes in all cliques.
  subroutine check_size(nblock, error)
    integer(i8), intent(in) :: nblock
    type(error_t), allocatable, intent(out) :: error

    if (9*nblock <= int(huge(1), i8)) return
    call fail(error, SYSTEM_ERROR, 'the tangent matrix would have '//to_text(9*nblock) &
              //' entries, more than the limit of '//to_text(huge(1)), hint='use a coarser mesh')
  end subroutine check_size

  !> Visit the blocks column by column, so that the columns of every row ascend without sorting.
  subroutine walk_columns(a, cliques, inc, count, counting)
    type(block_matrix_t), intent(inout) :: a
    type(clique_t), intent(in) :: cliques(:)
    type(incidence_t), intent(in) :: inc
    integer, intent(inout) :: count(:) !! (nnode) blocks found so far in each row
    logical, intent(in) :: counting    !! .true.: only count the blocks, and store no columns
    integer, allocatable :: mark(:)
    integer :: i, j, k, b

    allocate (mark(a%nnode))
    mark = 0
    count = 0
    do j = 1, a%nnode
      ! The diagonal block exists even if no element has the node. It is the first one of its row if
      ! the matrix is symmetric.
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

  !> Set the first position of each row from the number of entries in the rows.
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

  !> Do the same as map_one for all elements of an element block.
  subroutine map_all(a, conn, map, error)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: conn(:, :)     !! (nen, nelem)
    integer, intent(out) :: map(:, :, :)  !! (nen, nen, nelem)
    type(error_t), allocatable, intent(out), optional :: error !! set if a pair is not stored
    integer :: e

    do e = 1, size(conn, 2)
      call map_one(a, conn(:, e), map(:, :, e), error)
      if (.not. present(error)) cycle
      if (allocated(error)) return
    end do
  end subroutine map_all

  !> Find the positions, in the matrix, of the 3x3 blocks of all pairs of nodes of one element.
  !!
  !! map(b1, b2) is the block of row node conn(b1) and column node conn(b2), or 0 if a symmetric
  !! matrix stores the transpose instead or the pattern does not contain the pair. If b1 and b2
  !! differ but conn(b1) = conn(b2), both pairs map to the diagonal block of this node.
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
    call fail(error, BUG, 'an element is missing from the pattern of the tangent matrix')
  end subroutine map_one

  !> Position of the block (i, j); 0: it is not stored.
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

  !> Set all values to zero.
  pure subroutine set_zero(a)
    type(block_matrix_t), intent(inout) :: a

    a%val = 0.0_wp
  end subroutine set_zero

  !> For a matrix that ranks share, add up the diagonal blocks of all ranks; diagonal_block then
  !! returns the sums.
  subroutine sum_diagonal(a)
    type(block_matrix_t), intent(inout) :: a
    real(wp), allocatable :: list(:, :)
    integer :: n

    if (allocated(a%diagonal)) deallocate (a%diagonal)
    if (.not. a%shared) return
    allocate (list(9, a%nnode))
    do n = 1, a%nnode
      list(:, n) = reshape(diagonal_block(a, n), [9])
    end do
    call total_of(list)
    a%diagonal = reshape(list, [3, 3, a%nnode])
  end subroutine sum_diagonal

  !> The diagonal block of a node. Of a matrix that ranks share, it is the part of this rank until
  !! sum_diagonal has been called.
  pure function diagonal_block(a, n) result(block)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: n
    real(wp) :: block(3, 3)
    integer :: p

    if (allocated(a%diagonal)) then
      block = a%diagonal(:, :, n)
      return
    end if
    p = block_position(a, n, n)
    block = 0.0_wp
    if (p > 0) block = a%val(:, :, p)
  end function diagonal_block

  !> Compute y = A x over all nodes, including prescribed dofs. All ranks get the same y.
  !!
  !! If x is zero at the free dofs, then y at these dofs contains the forces that the prescribed
  !! displacements in x cause; the tangent predictor uses this.
  subroutine multiply(a, x, y)
    type(block_matrix_t), intent(in) :: a
    real(wp), intent(in) :: x(:, :)   !! (3, nnode)
    real(wp), intent(out), contiguous :: y(:, :)  !! (3, nnode)

    if (a%symmetric) then
      call multiply_symmetric(a%nnode, a%row, a%col, a%val, x, y)
    else
      call multiply_full(a%nnode, a%row, a%col, a%val, x, y)
    end if
    if (a%shared) call total_of(y)
  end subroutine multiply

  !> Multiply by a symmetric matrix whose upper half is stored.
  pure subroutine multiply_symmetric(nnode, row, col, val, x, y)
    integer, intent(in) :: nnode
    integer, intent(in) :: row(:), col(:)
    real(wp), intent(in) :: val(:, :, :), x(:, :)
    real(wp), intent(out) :: y(:, :)
    real(wp) :: s1, s2, s3, x1, x2, x3
    integer :: i, j, p

    y = 0.0_wp
    do i = 1, nnode
      p = row(i) ! the diagonal block is the first of its row; its upper triangle is used
      x1 = x(1, i); x2 = x(2, i); x3 = x(3, i)
      s1 = val(1, 1, p)*x1 + val(1, 2, p)*x2 + val(1, 3, p)*x3
      s2 = val(1, 2, p)*x1 + val(2, 2, p)*x2 + val(2, 3, p)*x3
      s3 = val(1, 3, p)*x1 + val(2, 3, p)*x2 + val(3, 3, p)*x3
      do p = row(i) + 1, row(i + 1) - 1
        j = col(p)
        s1 = s1 + val(1, 1, p)*x(1, j) + val(1, 2, p)*x(2, j) + val(1, 3, p)*x(3, j)
        s2 = s2 + val(2, 1, p)*x(1, j) + val(2, 2, p)*x(2, j) + val(2, 3, p)*x(3, j)
        s3 = s3 + val(3, 1, p)*x(1, j) + val(3, 2, p)*x(2, j) + val(3, 3, p)*x(3, j)
        y(1, j) = y(1, j) + val(1, 1, p)*x1 + val(2, 1, p)*x2 + val(3, 1, p)*x3
        y(2, j) = y(2, j) + val(1, 2, p)*x1 + val(2, 2, p)*x2 + val(3, 2, p)*x3
        y(3, j) = y(3, j) + val(1, 3, p)*x1 + val(2, 3, p)*x2 + val(3, 3, p)*x3
      end do
      y(1, i) = y(1, i) + s1
      y(2, i) = y(2, i) + s2
      y(3, i) = y(3, i) + s3
    end do
  end subroutine multiply_symmetric

  !> Multiply by a matrix that is stored in full.
  pure subroutine multiply_full(nnode, row, col, val, x, y)
    integer, intent(in) :: nnode
    integer, intent(in) :: row(:), col(:)
    real(wp), intent(in) :: val(:, :, :), x(:, :)
    real(wp), intent(out) :: y(:, :)
    real(wp) :: s1, s2, s3
    integer :: i, j, p

    do i = 1, nnode
      s1 = 0.0_wp; s2 = 0.0_wp; s3 = 0.0_wp
      do p = row(i), row(i + 1) - 1
        j = col(p)
        s1 = s1 + val(1, 1, p)*x(1, j) + val(1, 2, p)*x(2, j) + val(1, 3, p)*x(3, j)
        s2 = s2 + val(2, 1, p)*x(1, j) + val(2, 2, p)*x(2, j) + val(2, 3, p)*x(3, j)
        s3 = s3 + val(3, 1, p)*x(1, j) + val(3, 2, p)*x(2, j) + val(3, 3, p)*x(3, j)
      end do
      y(1, i) = s1; y(2, i) = s2; y(3, i) = s3
    end do
  end subroutine multiply_full

  !> Compute y = A x over the free dofs.
  subroutine multiply_free(a, eq, x, y, xn, yn)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)      !! (3, nnode) equation numbers, 0: prescribed
    real(wp), intent(in) :: x(:)         !! (neq)
    real(wp), intent(inout) :: y(:)      !! (neq)
    real(wp), intent(inout) :: xn(:, :)  !! (3, nnode) work space
    real(wp), intent(inout), contiguous :: yn(:, :) !! (3, nnode) work space
    integer :: i, n

    do n = 1, a%nnode
      do i = 1, 3
        xn(i, n) = 0.0_wp
        if (eq(i, n) > 0) xn(i, n) = x(eq(i, n))
      end do
    end do
    call multiply(a, xn, yn)
    do n = 1, a%nnode
      do i = 1, 3
        if (eq(i, n) > 0) y(eq(i, n)) = yn(i, n)
      end do
    end do
  end subroutine multiply_free

  !> Sum the absolute values of each free row over the free columns. If several ranks have parts of
  !! an entry, the absolute values of these parts are added.
  subroutine row_sums(a, eq, total)
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: eq(:, :)       !! (3, nnode)
    real(wp), intent(out) :: total(:)     !! (neq)
    real(wp), allocatable :: list(:, :)
    integer :: i, j, n, m, p

    total = 0.0_wp
    do n = 1, a%nnode
      do p = a%row(n), a%row(n + 1) - 1
        m = a%col(p)
        do j = 1, 3
          do i = 1, 3
            if (eq(i, n) == 0 .or. eq(j, m) == 0) cycle
            total(eq(i, n)) = total(eq(i, n)) + abs(a%val(i, j, p))
            if (.not. a%symmetric .or. n == m) cycle
            total(eq(j, m)) = total(eq(j, m)) + abs(a%val(i, j, p))
          end do
        end do
      end do
    end do
    if (.not. a%shared) return
    list = reshape(total, [1, size(total)])
    call total_of(list)
    total = list(1, :)
  end subroutine row_sums

  !> Add one element matrix. If the matrix is symmetric, only the blocks on and above its diagonal
  !! are added, and k must be symmetric.
  pure subroutine add_element(a, map, k, row)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: map(:, :)  !! (nen, nen) block positions, 0: not stored (element_map)
    real(wp), intent(in) :: k(:, :)   !! (3*nen, 3*nen)
    !> Nodes of the element whose block rows are added, ascending; without it, all are. Threads that
    !! add the rows of different nodes do not disturb each other.
    integer, intent(in), optional :: row(:)
    integer :: b1, b2, i, j, n, p

    n = size(map, 1)
    if (present(row)) n = size(row)
    do b2 = 1, size(map, 2)
      do i = 1, n
        b1 = i
        if (present(row)) b1 = row(i)
        p = map(b1, b2)
        if (p == 0) cycle
        do j = 1, 3
          a%val(1, j, p) = a%val(1, j, p) + k(3*b1 - 2, 3*b2 - 3 + j)
          a%val(2, j, p) = a%val(2, j, p) + k(3*b1 - 1, 3*b2 - 3 + j)
          a%val(3, j, p) = a%val(3, j, p) + k(3*b1, 3*b2 - 3 + j)
        end do
      end do
    end do
  end subroutine add_element

  !> Add a batch of elements, whose matrices are symmetric; the last batch of a block may not be
  !! full. Only the block rows of the nodes of one share are added, see share_rows.
  pure subroutine add_batch(a, conn, map, k, share, shares)
    type(block_matrix_t), intent(inout) :: a
    integer, intent(in) :: conn(:, :)        !! (nen, n) nodes
    integer, intent(in) :: map(:, :, :)      !! (nen, nen, n) positions, n <= NB elements in use
    real(wp), intent(in) :: k(:, :, :, :, :) !! (NB, 3, 3, nen, nen), see element_batch_i
    integer, intent(in) :: share, shares

    call add_batch_to(size(map, 1), size(map, 3), size(a%val, 3), conn, map, k, share, shares, &
                      a%val)
  end subroutine add_batch

  !> Do the work of add_batch with arrays of explicit shape, for which the compiler produces faster
  !! code.
  pure subroutine add_batch_to(nen, n, nblock, conn, map, k, share, shares, val)
    integer, intent(in) :: nen, n, nblock
    integer, intent(in) :: conn(nen, n), map(nen, nen, n)
    real(wp), intent(in) :: k(NB, 3, 3, nen, nen)
    integer, intent(in) :: share, shares
    real(wp), intent(inout) :: val(3, 3, nblock)
    logical :: mine(NB, nen)
    integer :: b1, b2, e, j, nrow, p, row(nen)

    mine = .false.
    do e = 1, n
      call share_rows(conn(:, e), share, shares, row, nrow)
      mine(e, row(:nrow)) = .true.
    end do
    do b2 = 1, nen
      do b1 = 1, b2
        do e = 1, n
          p = map(b1, b2, e)
          if (p > 0 .and. mine(e, b1)) then
            do j = 1, 3
              val(1, j, p) = val(1, j, p) + k(e, 1, j, b1, b2)
              val(2, j, p) = val(2, j, p) + k(e, 2, j, b1, b2)
              val(3, j, p) = val(3, j, p) + k(e, 3, j, b1, b2)
            end do
          end if
          p = map(b2, b1, e)
          if (b1 == b2 .or. p == 0 .or. .not. mine(e, b2)) cycle
          do j = 1, 3
            val(1, j, p) = val(1, j, p) + k(e, j, 1, b1, b2)
            val(2, j, p) = val(2, j, p) + k(e, j, 2, b1, b2)
            val(3, j, p) = val(3, j, p) + k(e, j, 3, b1, b2)
          end do
        end do
      end do
    end do
  end subroutine add_batch_to

  !> Find the nodes of an element that belong to one share of all nodes. The nodes are dealt to the
  !! shares in turn, because neighbouring elements, which are added together, have neighbouring
  !! nodes.
  pure subroutine share_rows(conn, share, shares, row, n)
    integer, intent(in) :: conn(:)
    integer, intent(in) :: share, shares !! from 1; number of shares
    integer, intent(out) :: row(:)       !! (nen) the first n are their local numbers, ascending
    integer, intent(out) :: n
    integer :: i

    n = 0
    do i = 1, size(conn)
      if (shares > 1) then
        if (mod(conn(i), shares) /= share - 1) cycle
      end if
      n = n + 1
      row(n) = i
    end do
  end subroutine share_rows

end module csr
