!> Linear constraints in a block matrix: K becomes T^T K T, where T expresses the displacements of
!! slaves by those of their masters.
!!
!! The matrix is assembled as if slaves were free. Then each block of a slave is added to the blocks
!! of its masters, and the row and the column of the slave become zero.
module csr_fold
  use base_kinds, only: wp
  use base_error, only: error_t, fail, BUG
  use constraint, only: constraint_t, slave_marks
  use csr, only: block_matrix_t, clique_t, block_position
  implicit none
  private
  public :: fold_t, tied_cliques, new_fold, fold_matrix

  !> Moves of blocks: block `from`, multiplied by c, is added to block `to`, either as it is
  !! (PLAIN), or transposed (TRANSPOSED), or once in each form (BOTH).
  type :: fold_t
    integer :: n = 0
    integer, allocatable :: from(:), to(:), how(:) !! (>= n); how: PLAIN, TRANSPOSED, BOTH
    real(wp), allocatable :: c(:)                  !! (>= n)
    integer, allocatable :: cleared(:)             !! blocks of slaves, which become zero
  end type fold_t

  integer, parameter :: PLAIN = 1, TRANSPOSED = 2, BOTH = 3

contains

  !> Find the cliques that constraints add: for each clique with slaves, its nodes and their
  !! masters.
  subroutine tied_cliques(list, nnode, cliques, extra)
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: nnode
    type(clique_t), intent(in) :: cliques(:)
    type(clique_t), intent(out) :: extra
    integer :: mark(nnode)
    integer :: a, e, g, i, m, n, pass, width

    mark = slave_marks(list, nnode)
    width = 0
    do pass = 1, 2 ! count, then store
      n = 0
      do g = 1, size(cliques)
        do e = 1, size(cliques(g)%conn, 2)
          associate (node => cliques(g)%conn(:, e))
            if (all(mark(node) == 0)) cycle
            n = n + 1
            m = size(node)
            if (pass == 2) then
              extra%conn(:, n) = node(1)
              extra%conn(:m, n) = node
            end if
            do a = 1, size(node)
              if (mark(node(a)) == 0) cycle
              do i = list%first(mark(node(a))), list%first(mark(node(a)) + 1) - 1
                m = m + 1
                if (pass == 2) extra%conn(m, n) = list%master(i)
              end do
            end do
            width = max(width, m)
          end associate
        end do
      end do
      if (pass == 1) allocate (extra%conn(width, n))
    end do
  end subroutine tied_cliques

  !> Plan the moves for a pattern that includes the cliques found by tied_cliques.
  subroutine new_fold(list, a, fold, error)
    type(constraint_t), intent(in) :: list
    type(block_matrix_t), intent(in) :: a
    type(fold_t), intent(out) :: fold
    type(error_t), allocatable, intent(out) :: error
    integer :: mark(a%nnode)
    integer :: i, j, p, pass, ncleared
    logical :: complete

    mark = slave_marks(list, a%nnode)
    complete = .true.
    do pass = 1, 2
      fold%n = 0
      ncleared = 0
      do i = 1, a%nnode
        do p = a%row(i), a%row(i + 1) - 1
          j = a%col(p)
          if (mark(i) == 0 .and. mark(j) == 0) cycle
          ncleared = ncleared + 1
          if (pass == 2) fold%cleared(ncleared) = p
          call plan_block(list, a, mark, i, j, p, pass == 2, fold, complete)
        end do
      end do
      if (pass == 1) allocate (fold%from(fold%n), fold%to(fold%n), fold%how(fold%n), &
                               fold%c(fold%n), fold%cleared(ncleared))
    end do
    if (.not. complete) call fail(error, BUG, 'a constraint is missing from the pattern of the ' &
                                  //'tangent matrix')
  end subroutine new_fold

  !> Plan the moves of one block.
  subroutine plan_block(list, a, mark, i, j, p, writes, fold, complete)
    type(constraint_t), intent(in) :: list
    type(block_matrix_t), intent(in) :: a
    integer, intent(in) :: mark(:), i, j, p
    logical, intent(in) :: writes
    type(fold_t), intent(inout) :: fold
    logical, intent(inout) :: complete
    integer, allocatable :: row(:), col(:)
    real(wp), allocatable :: cr(:), cc(:)
    integer :: k, l, how, to

    call split(list, mark(i), i, row, cr)
    call split(list, mark(j), j, col, cc)
    do l = 1, size(col)
      do k = 1, size(row)
        how = PLAIN
        if (a%symmetric) then ! an off-diagonal block also stands for its transpose
          if (i == j .and. row(k) > col(l)) cycle
          if (row(k) > col(l)) how = TRANSPOSED
          if (i /= j .and. row(k) == col(l)) how = BOTH
        end if
        fold%n = fold%n + 1
        if (.not. writes) cycle
        to = block_position(a, row(k), col(l))
        if (how == TRANSPOSED) to = block_position(a, col(l), row(k))
        if (to == 0) complete = .false.
        fold%from(fold%n) = p
        fold%to(fold%n) = to
        fold%how(fold%n) = how
        fold%c(fold%n) = cr(k)*cc(l)
      end do
    end do
  end subroutine plan_block

  !> Find the masters of a node and their coefficients, or the node itself if it is not a slave.
  subroutine split(list, i, node, master, c)
    type(constraint_t), intent(in) :: list
    integer, intent(in) :: i           !! index of the constraint of the node; 0: none
    integer, intent(in) :: node
    integer, allocatable, intent(out) :: master(:)
    real(wp), allocatable, intent(out) :: c(:)

    if (i == 0) then
      master = [node]
      c = [1.0_wp]
    else
      master = list%master(list%first(i):list%first(i + 1) - 1)
      c = list%c(list%first(i):list%first(i + 1) - 1)
    end if
  end subroutine split

  !> Move the blocks and set those of the slaves to zero.
  pure subroutine fold_matrix(fold, a)
    type(fold_t), intent(in) :: fold
    type(block_matrix_t), intent(inout) :: a
    real(wp) :: block(3, 3)
    integer :: m

    do m = 1, fold%n
      block = a%val(:, :, fold%from(m))
      if (fold%how(m) == TRANSPOSED) block = transpose(block)
      if (fold%how(m) == BOTH) block = block + transpose(block)
      a%val(:, :, fold%to(m)) = a%val(:, :, fold%to(m)) + fold%c(m)*block
    end do
    if (.not. allocated(fold%cleared)) return
    do m = 1, size(fold%cleared)
      a%val(:, :, fold%cleared(m)) = 0.0_wp
    end do
  end subroutine fold_matrix

end module csr_fold
