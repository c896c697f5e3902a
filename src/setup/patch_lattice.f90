!> The Lagrange nodes of a body: points of its geometry on a lattice over the elements.
module patch_lattice
  use base_kinds, only: wp
  use patch_geometry, only: geometry_t, point
  use patch_draft, only: draft_t, add_node
  implicit none
  private
  public :: lattice_t, make_lattice, parameters_at, border_mask

  !> Element c of direction d spans lattice lines m (c-1) to m c.
  type :: lattice_t
    integer :: m = 1                        !! lattice intervals an element has: its degree
    integer :: n(3) = 0                     !! intervals in all
    integer, allocatable :: node(:, :, :)   !! (0:n1, 0:n2, 0:n3); 0 on enriched faces
  end type lattice_t

contains

  !> Nodes everywhere but on enriched faces, whose control points take their place.
  subroutine make_lattice(geo, m, enriched, draft, lattice)
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: m
    logical, intent(in) :: enriched(6)
    type(draft_t), intent(inout) :: draft
    type(lattice_t), intent(out) :: lattice
    integer :: i, j, k, f, mask

    lattice%m = m
    lattice%n = m*geo%n
    associate (n => lattice%n)
      allocate (lattice%node(0:n(1), 0:n(2), 0:n(3)), source=0)
      do k = 0, n(3)
        do j = 0, n(2)
          do i = 0, n(1)
            mask = border_mask(lattice, [i, j, k])
            if (any([(enriched(f) .and. btest(mask, f - 1), f=1, 6)])) cycle
            call add_node(draft, point(geo, parameters_at(geo, m, [i, j, k])), .false., mask, &
                          lattice%node(i, j, k))
          end do
        end do
      end do
    end associate
  end subroutine make_lattice

  !> Faces on which a lattice point lies.
  pure integer function border_mask(lattice, at) result(mask)
    type(lattice_t), intent(in) :: lattice
    integer, intent(in) :: at(3)
    integer :: d

    mask = 0
    do d = 1, 3
      if (at(d) == 0) mask = ibset(mask, 2*d - 2)
      if (at(d) == lattice%n(d)) mask = ibset(mask, 2*d - 1)
    end do
  end function border_mask

  !> Parameters of a lattice point.
  pure function parameters_at(geo, m, at) result(u)
    type(geometry_t), intent(in) :: geo
    integer, intent(in) :: m, at(3)
    real(wp) :: u(3)
    integer :: d, c, r

    do d = 1, 3
      c = at(d)/m + 1
      r = mod(at(d), m)
      associate (breaks => geo%breaks(d)%u)
        u(d) = breaks(c)
        if (r > 0) u(d) = breaks(c) + (breaks(c + 1) - breaks(c))*r/m
      end associate
    end do
  end function parameters_at

end module patch_lattice
