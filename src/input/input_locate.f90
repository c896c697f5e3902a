!> In which element a reference point lies, and its parent coordinates there.
module input_locate
  use base_kinds, only: wp
  use element_type, only: cell_t
  use mesh, only: mesh_t, block_t, block_cell, is_rigid
  use tensor, only: det3
  implicit none
  private
  public :: locate_point

  integer, parameter :: MAX_ITER = 50
  real(wp), parameter :: BORDER = 1.0e-6_wp !! a point this far off an element's border lies in it
  real(wp), parameter :: WIDER = 0.5_wp     !! curved elements leave the box of their nodes by less
  real(wp), parameter :: SINGULAR = 1.0e-10_wp !! share of the largest determinant a map may have

contains

  !> The first element, of no rigid body, that holds the point; block is 0 where there is none.
  subroutine locate_point(mesh, body, x, block, elem, xi)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: body     !! index of a body; 0: everywhere
    real(wp), intent(in) :: x(3)    !! [L]
    integer, intent(out) :: block, elem
    real(wp), intent(out) :: xi(3)
    real(wp), allocatable :: xe(:, :)
    logical :: holds
    integer :: b, e

    do b = 1, size(mesh%block)
      if (body > 0 .and. mesh%block(b)%body /= body) cycle
      if (is_rigid(mesh%block(b))) cycle
      do e = 1, mesh%block(b)%nelem
        xe = mesh%xr(:, mesh%block(b)%conn(:, e))
        if (.not. near(xe, x)) cycle
        call invert_map(mesh%block(b), e, xe, x, xi, holds)
        if (.not. holds) cycle
        block = b
        elem = e
        return
      end do
    end do
    block = 0
    elem = 0
    xi = 0.0_wp
  end subroutine locate_point

  !> Inside the box of the nodes, widened.
  pure logical function near(xe, x)
    real(wp), intent(in) :: xe(:, :), x(3)
    real(wp) :: low(3), high(3), margin

    low = minval(xe, 2)
    high = maxval(xe, 2)
    margin = WIDER*maxval(high - low)
    near = all(x >= low - margin .and. x <= high + margin)
  end function near

  !> Newton's method on x(xi) = x from the middle of the element.
  subroutine invert_map(block, e, xe, x, xi, holds)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e
    real(wp), intent(in) :: xe(:, :), x(3)
    real(wp), intent(out) :: xi(3)
    logical, intent(out) :: holds
    type(cell_t) :: cell
    real(wp) :: shp(block%nen), dshp(3, block%nen), jac(3, 3), step(3), det
    integer :: it

    call block_cell(block, e, cell)
    xi = 0.0_wp
    holds = .false.
    do it = 1, MAX_ITER
      call block%row%functions(cell, xi, shp, dshp)
      jac = matmul(xe, transpose(dshp))
      det = det3(jac)
      if (.not. abs(det) > SINGULAR*norm2(jac(:, 1))*norm2(jac(:, 2))*norm2(jac(:, 3))) return
      step = solved(jac, det, x - matmul(xe, shp))
      xi = xi + step
      if (maxval(abs(xi)) > 3.0_wp) return
      if (maxval(abs(step)) < 1.0e-12_wp) exit
    end do
    holds = maxval(abs(xi)) <= 1.0_wp + BORDER .and. it <= MAX_ITER
    xi = max(-1.0_wp, min(1.0_wp, xi))
  end subroutine invert_map

  !> Cramer's rule.
  pure function solved(a, det, r) result(x)
    real(wp), intent(in) :: a(3, 3), det, r(3)
    real(wp) :: x(3), c(3, 3)
    integer :: i

    do i = 1, 3
      c = a
      c(:, i) = r
      x(i) = det3(c)/det
    end do
  end function solved

end module input_locate
