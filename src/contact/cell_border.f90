!> Borders of cells: moves the corners of a cell, a polygon with straight edges, to their exact
!! positions, and bends its edges where the elements are curved.
!!
!! Cells are cut from facets, the nearly flat parts of elements (contact_facets). An edge of a cell
!! either lies on an edge of the facet from which the cell was cut, and is then straight in the
!! chart of the element (surface_chart), or comes from an edge of a facet of the other side. In the
!! second case, this module finds the points of this side that face that edge exactly: the line from
!! such a point to the edge is normal to the other surface. At these points, projections change from
!! one element to the next. Two cells that share an edge find the same points on it.
module cell_border
  use base_kinds, only: wp
  use contact_pair, only: surface_t
  use polygon, only: MOST_CORNERS
  use projection_type, only: shape_t
  use surface_chart, only: collapsed_side, to_chart, from_chart, chart_point
  use surface_geometry, only: surface_point
  implicit none
  private
  public :: part_t, find_border, bend_functions, NBEND

  integer, parameter :: NBEND = 8 !! points between the ends of an edge at which its shape is found
  !> Largest correction of a point of an edge or of a corner, relative to the size of the facet.
  real(wp), parameter :: MOST_BEND = 0.25_wp
  real(wp), parameter :: STRAIGHT = 1.0e-13_wp !! a smaller deviation is due to rounding
  real(wp), parameter :: CONVERGED = 1.0e-13_wp, STALLED = 1.0e-9_wp
  !> Edges count as parallel if the sine of the angle between them is smaller than this.
  real(wp), parameter :: PARALLEL = 1.0e-3_wp
  integer, parameter :: MOST_STEPS = 12      !! largest number of Newton steps
  !> Index of the parameter that is constant on each of the edges 1 to 4 of a facet, which are
  !! numbered counter-clockwise.
  integer, parameter :: FIXED(4) = [2, 1, 2, 1]

  !> A part of an element, given by ranges of its parameters.
  type :: part_t
    integer :: elem = 0
    real(wp) :: from(2) = 0.0_wp, to(2) = 0.0_wp
  end type part_t

contains

  !> The point on [-1,1] at which the function f_k of a bent edge is one; these points are symmetric
  !! about zero.
  pure real(wp) function bend_at(k) result(t)
    integer, intent(in) :: k

    t = -cos(acos(-1.0_wp)*k/(NBEND + 1))
  end function bend_at

  !> Polynomials f_k(t) and their derivatives. f_k is one at the point bend_at(k), and vanishes at
  !! the other points and at the ends.
  pure subroutine bend_functions(t, f, df)
    real(wp), intent(in) :: t
    real(wp), intent(out) :: f(NBEND), df(NBEND)
    real(wp) :: at(0:NBEND + 1), term
    integer :: i, j, k

    at = [-1.0_wp, (bend_at(k), k=1, NBEND), 1.0_wp]
    do k = 1, NBEND
      f(k) = 1.0_wp
      df(k) = 0.0_wp
      do i = 0, NBEND + 1
        if (i == k) cycle
        f(k) = f(k)*(t - at(i))/(at(k) - at(i))
        term = 1.0_wp/(at(k) - at(i))
        do j = 0, NBEND + 1
          if (j == k .or. j == i) cycle
          term = term*(t - at(j))/(at(k) - at(j))
        end do
        df(k) = df(k) + term
      end do
    end do
  end subroutine bend_functions

  !> Correct the corners of a cell, and find how far its edges deviate from straight lines. `tag`
  !! says where the edge after a corner comes from: -k means edge k of this side's part, and k means
  !! edge k of the other side's part.
  pure subroutine find_border(own, shape, mine, other, opposite, theirs, m, tag, xi, zeta, bend)
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape, opposite
    type(part_t), intent(in) :: mine, theirs
    integer, intent(in) :: m                    !! number of corners
    integer, intent(in) :: tag(:)               !! (m)
    real(wp), intent(inout) :: xi(:, :) !! (2, m) corners, as parameters of this side's part
    !> (2, m) the same corners as parameters of the other side's part, used where the edge before or
    !! after the corner comes from that part.
    real(wp), intent(inout) :: zeta(:, :)
    !> Deviations of the edges in the chart of the element, in the form that integrate_polygon
    !! expects.
    real(wp), intent(out) :: bend(2, NBEND, MOST_CORNERS)
    integer :: before, c, i

    bend = 0.0_wp
    do c = 1, m
      before = tag(mod(c + m - 2, m) + 1)
      if (before < 0 .and. tag(c) < 0) cycle
      if (before > 0 .and. tag(c) > 0) then
        call find_facing(own, shape, mine, other, opposite, theirs%elem, zeta(:, c), xi(:, c))
      else
        i = max(before, tag(c))
        call find_crossing(own, shape, mine, -min(before, tag(c)), other, opposite, theirs, i, &
                           xi(:, c), zeta(:, c))
      end if
    end do
    do c = 1, m
      if (tag(c) < 0) cycle
      i = mod(c, m) + 1
      call find_bend(own, shape, mine, other, opposite, theirs%elem, xi(:, c), xi(:, i), &
                     zeta(:, c), zeta(:, i), bend(:, :, c))
    end do
  end subroutine find_border

  !> Find the point of this side's part that faces a point of the other surface. If there is no such
  !! point near xi, xi is not changed.
  pure subroutine find_facing(own, shape, mine, other, opposite, elem, zeta, xi, found)
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape, opposite
    type(part_t), intent(in) :: mine
    integer, intent(in) :: elem
    real(wp), intent(in) :: zeta(2)
    real(wp), intent(inout) :: xi(2)
    logical, intent(out), optional :: found
    real(wp) :: from(2), at(2), x(3), a(3, 2), y(3), p(3, 2), j(2, 2), r(2), d(2), det
    integer :: side, step

    if (present(found)) found = .false.
    call chart_point(other, opposite, elem, collapsed_side(other, elem), &
                     to_chart(collapsed_side(other, elem), zeta), y, p)
    side = collapsed_side(own, mine%elem)
    from = to_chart(side, xi)
    at = from
    do step = 1, MOST_STEPS
      call chart_point(own, shape, mine%elem, side, at, x, a)
      r = matmul(y - x, p)
      j = matmul(transpose(p), a)
      det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      if (.not. abs(det) > 0.0_wp) return
      d = [j(2, 2)*r(1) - j(1, 2)*r(2), j(1, 1)*r(2) - j(2, 1)*r(1)]/det
      at = at + d
      if (.not. maxval(abs(at - from)) <= MOST_BEND*maxval(mine%to - mine%from)) return
      if (maxval(abs(d)) < CONVERGED) exit
    end do
    if (maxval(abs(d)) > STALLED) return
    xi = max(mine%from, min(mine%to, from_chart(side, at)))
    if (present(found)) found = .true.
  end subroutine find_facing

  !> Find the point where edge k of this side's part crosses edge i of the other side's part. If the
  !! edges do not cross near xi and zeta, these are not changed.
  pure subroutine find_crossing(own, shape, mine, k, other, opposite, theirs, i, xi, zeta)
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape, opposite
    type(part_t), intent(in) :: mine, theirs
    integer, intent(in) :: k, i
    real(wp), intent(inout) :: xi(2), zeta(2)
    real(wp) :: at(2), to(2), x(3), a(3, 2), b(3, 3), y(3), p(3, 2), j(2, 2), r(2), d(2), det
    integer :: f, g, step

    f = 3 - FIXED(k)
    g = 3 - FIXED(i)
    at = xi
    to = zeta
    ! at a vertex, zeta may lie on another edge
    to(FIXED(i)) = merge(theirs%from(FIXED(i)), theirs%to(FIXED(i)), i == 1 .or. i == 4)
    do step = 1, MOST_STEPS
      call surface_point(own, shape, mine%elem, at, x, a, b)
      call surface_point(other, opposite, theirs%elem, to, y, p, b)
      r = matmul(y - x, p)
      j(:, 1) = matmul(a(:, f), p)
      j(:, 2) = -matmul(p(:, g), p)
      det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      if (.not. abs(det) > PARALLEL*norm2(j(:, 1))*norm2(j(:, 2))) return
      d = [j(2, 2)*r(1) - j(1, 2)*r(2), j(1, 1)*r(2) - j(2, 1)*r(1)]/det
      at(f) = at(f) + d(1)
      to(g) = to(g) + d(2)
      if (.not. abs(at(f) - xi(f)) <= MOST_BEND*(mine%to(f) - mine%from(f))) return
      if (.not. abs(to(g) - zeta(g)) <= MOST_BEND*(theirs%to(g) - theirs%from(g))) return
      if (maxval(abs(d)) < CONVERGED) exit
    end do
    if (maxval(abs(d)) > STALLED) return
    xi = max(mine%from, min(mine%to, at))
    zeta = max(theirs%from, min(theirs%to, to))
  end subroutine find_crossing

  !> Find the image on this side of an edge of the other side, which is straight in the chart of its
  !! element. `bend` is the deviation of the image, in the chart of this side's element, from the
  !! straight line between its ends; it is zero if a point of the image is not found.
  pure subroutine find_bend(own, shape, mine, other, opposite, elem, xi, xi_to, zeta, zeta_to, bend)
    type(surface_t), intent(in) :: own, other
    type(shape_t), intent(in) :: shape, opposite
    type(part_t), intent(in) :: mine
    integer, intent(in) :: elem
    real(wp), intent(in) :: xi(2), xi_to(2), zeta(2), zeta_to(2)
    real(wp), intent(out) :: bend(2, NBEND)
    real(wp) :: off(2), off_to(2), s, line(2), at(2), edge(2), edge_to(2)
    integer :: k, side, opposite_side
    logical :: found

    bend = 0.0_wp
    side = collapsed_side(own, mine%elem)
    opposite_side = collapsed_side(other, elem)
    off = xi                                 ! corners may lie slightly off the edge
    call find_facing(own, shape, mine, other, opposite, elem, zeta, off)
    off_to = xi_to
    call find_facing(own, shape, mine, other, opposite, elem, zeta_to, off_to)
    off = to_chart(side, off)
    off_to = to_chart(side, off_to)
    edge = to_chart(opposite_side, zeta)
    edge_to = to_chart(opposite_side, zeta_to)
    do k = 1, NBEND
      s = 0.5_wp*(1.0_wp + bend_at(k))
      line = off + s*(off_to - off)
      at = from_chart(side, line)
      call find_facing(own, shape, mine, other, opposite, elem, &
                       from_chart(opposite_side, edge + s*(edge_to - edge)), at, found)
      if (.not. found) then
        bend = 0.0_wp
        return
      end if
      bend(:, k) = to_chart(side, at) - line
      if (k == 2 .and. maxval(abs(bend(:, :2))) < STRAIGHT) exit ! the map is affine
    end do
  end subroutine find_bend

end module cell_border
