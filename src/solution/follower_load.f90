!> Pressure that follows the surface: force and tangent of one element face.
module follower_load
  use base_kinds, only: wp
  use element_type, only: cell_t
  use mesh, only: block_t, block_cell
  use face_rule, only: face_points, face_normal, face_directions
  implicit none
  private
  public :: follower_face

contains

  !> f_a = -p int N_a n da over the current face, and -df/du for the tangent.
  !! With the tangents g1, g2 of the face, n da = g1 x g2, so d(n da) = dg1 x g2 - dg2 x g1.
  subroutine follower_face(block, e, side, p, x, f, k)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e, side
    real(wp), intent(in) :: p            !! pressure now; p > 0 presses on the body [F/L^2]
    real(wp), intent(in) :: x(:, :)      !! (3, nen) current positions [L]
    real(wp), intent(out) :: f(:, :)     !! (3, nen) external force [F]
    real(wp), intent(out) :: k(:, :)     !! (3*nen, 3*nen) -df/du [F/L]
    type(cell_t) :: cell
    real(wp), allocatable :: xi(:, :), w(:)
    real(wp) :: shp(block%nen), dshp(3, block%nen), area(3), ta(3), tb(3), s(3, 3)
    integer :: a, b, d, da, db, q
    real(wp) :: sign

    call block_cell(block, e, cell)
    call face_points(cell%degree, block%rule%xi, side, xi, w)
    call face_directions(side, d, da, db)
    sign = merge(-1.0_wp, 1.0_wp, mod(side, 2) == 1)
    f = 0.0_wp
    k = 0.0_wp
    do q = 1, size(w)
      call block%row%functions(cell, xi(:, q), shp, dshp)
      call face_normal(side, x, dshp, area, ta, tb)
      do b = 1, block%nen
        f(:, b) = f(:, b) - p*w(q)*shp(b)*area
        s = sign*p*w(q)*(dshp(db, b)*skew(ta) - dshp(da, b)*skew(tb))
        do a = 1, block%nen
          k(3*a - 2:3*a, 3*b - 2:3*b) = k(3*a - 2:3*a, 3*b - 2:3*b) + shp(a)*s
        end do
      end do
    end do
  end subroutine follower_face

  !> Matrix of the cross product: skew(a) b = a x b.
  pure function skew(a) result(s)
    real(wp), intent(in) :: a(3)
    real(wp) :: s(3, 3)

    s = reshape([0.0_wp, a(3), -a(2), -a(3), 0.0_wp, a(1), a(2), -a(1), 0.0_wp], [3, 3])
  end function skew

end module follower_load
