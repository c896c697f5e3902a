!> Adds the forces and derivatives of one surface element to the global system; contact_work holds
!! them.
module contact_scatter
  use base_kinds, only: wp
  use contact_active, only: pairs_t, find_pair
  use contact_pair, only: contact_t, contact_state_t
  use contact_work, only: work_t, loads_both
  use csr, only: block_matrix_t
  use csr_coupling, only: add_coupling, coupling_map
  use tensor, only: cross
  implicit none
  private
  public :: scatter_element

contains

  !> Add the contributions of element e of side k.
  subroutine scatter_element(contact, k, e, part, pairs, x, u, tangent, state, a, f, rounding, &
                             largest)
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k, e
    type(work_t), intent(in) :: part
    type(pairs_t), intent(in) :: pairs             !! pairs of side k
    real(wp), intent(in) :: x(:, :), u(:, :)       !! (3, nnode) positions, displacements [L]
    logical, intent(in) :: tangent                 !! false: only the forces are added
    type(contact_state_t), intent(inout) :: state  !! its forces and moments are updated
    type(block_matrix_t), intent(inout) :: a
    real(wp), intent(inout) :: f(:, :)             !! (3, nnode) internal forces [F]
    real(wp), intent(inout) :: rounding, largest   !! see sweep_t
    integer, allocatable :: at(:, :)
    integer :: b, i, j, n

    associate (own => contact%side(k), other => contact%side(3 - k))
      associate (mine => own%node(own%first(e):own%first(e + 1) - 1))
        do b = 1, part%nk
          n = mine(b)
          call put(n, k, part%r(:, b))
          rounding = rounding + sum(abs(part%r(:, b)*u(:, n)))
          largest = max(largest, maxval(abs(part%r(:, b))))
        end do
        if (tangent) call add_coupling(a, mine, mine, pairs%self(e)%at, part%kk)
        do b = 1, part%npartner
          n = part%partner(b)
          associate (map => pairs%map(find_pair(pairs, e, n)), &
                     theirs => other%node(other%first(n):other%first(n + 1) - 1))
            if (tangent) call add_coupling(a, mine, theirs, map%at, part%kl(:, :, b))
            if (.not. loads_both(contact)) cycle
            do j = 1, size(theirs) ! the points load their partner too
              call put(theirs(j), 3 - k, part%back(:, j, b))
            end do
            if (.not. tangent) cycle
            call add_coupling(a, theirs, mine, map%back, part%lk(:, :, b))
            call add_coupling(a, theirs, theirs, map%there, part%ll(:, :, b))
          end associate
        end do
      end associate
      if (.not. tangent) return
      do b = 1, part%ncross ! with friction, a force depends on two partners
        i = part%partner(part%pair(1, b))
        j = part%partner(part%pair(2, b))
        associate (rows => other%node(other%first(i):other%first(i + 1) - 1), &
                   cols => other%node(other%first(j):other%first(j + 1) - 1))
          allocate (at(size(rows), size(cols)))
          call coupling_map(a, rows, cols, at)
          call add_coupling(a, rows, cols, at, part%cross(:, :, b))
          deallocate (at)
        end associate
      end do
    end associate

  contains

    !> Add an internal force on a node of one side.
    subroutine put(node, side, r)
      integer, intent(in) :: node, side
      real(wp), intent(in) :: r(3)

      f(:, node) = f(:, node) + r
      state%force(:, side) = state%force(:, side) - r
      state%moment(:, side) = state%moment(:, side) - cross(x(:, node), r)
    end subroutine put
  end subroutine scatter_element

end module contact_scatter
