!> Tetrahedra and triangles as collapsed cubes and squares. All elements then have the same parent
!! cell, whose faces are squares, so that rules, loads and contact treat them like hexahedra.
!!
!! With s = (1 + xi)/2, a point of the tetrahedron is t = (s1 (1-s2) (1-s3), s2 (1-s3), s3). Then
!! face xi- is t1 = 0, xi+ is t1 + t2 + t3 = 1, eta- is t2 = 0, and zeta- is t3 = 0; eta+ is an
!! edge, and zeta+ a point. Without the third direction, the map gives a triangle, whose side eta+
!! is a point.
!!
!! The default integration rules of tetrahedra are rules for the tetrahedron, because integrands are
!! smoother there than on the cube: the points are mapped to the cube, and the weights are divided
!! by the determinant of the map.
module collapsed_shape
  use base_kinds, only: wp
  use element_type, only: cell_t, rule_t
  use hexa_shape, only: tensor_rule
  implicit none
  private
  public :: fold_tetrahedron, fold_triangle, unfold_rule, collapsed_rule

contains

  !> Map a point of the cube to volume coordinates, 1 - t1 - t2 - t3 and t, with their derivatives.
  pure subroutine fold_tetrahedron(xi, v, dv)
    real(wp), intent(in) :: xi(3)      !! in [-1,1]^3
    real(wp), intent(out) :: v(4)
    real(wp), intent(out) :: dv(3, 4)  !! dv(i, j): derivative of v(j) with respect to xi(i)
    real(wp) :: s(3), r(3)

    s = 0.5_wp*(1.0_wp + xi)
    r = 0.5_wp*(1.0_wp - xi)
    v(2:) = [s(1)*r(2)*r(3), s(2)*r(3), s(3)]
    dv(:, 2) = 0.5_wp*[r(2)*r(3), -s(1)*r(3), -s(1)*r(2)]
    dv(:, 3) = 0.5_wp*[0.0_wp, r(3), -s(2)]
    dv(:, 4) = 0.5_wp*[0.0_wp, 0.0_wp, 1.0_wp]
    v(1) = 1.0_wp - sum(v(2:))
    dv(:, 1) = -sum(dv(:, 2:), 2)
  end subroutine fold_tetrahedron

  !> Map a point of the square to area coordinates, 1 - t1 - t2 and t, with their derivatives.
  pure subroutine fold_triangle(xi, v, dv)
    real(wp), intent(in) :: xi(2)      !! in [-1,1]^2
    real(wp), intent(out) :: v(3)
    real(wp), intent(out) :: dv(2, 3)  !! dv(i, j): derivative of v(j) with respect to xi(i)
    real(wp) :: s(2), r(2)

    s = 0.5_wp*(1.0_wp + xi)
    r = 0.5_wp*(1.0_wp - xi)
    v(2:) = [s(1)*r(2), s(2)]
    dv(:, 2) = 0.5_wp*[r(2), -s(1)]
    dv(:, 3) = 0.5_wp*[0.0_wp, 1.0_wp]
    v(1) = 1.0_wp - v(2) - v(3)
    dv(:, 1) = -dv(:, 2) - dv(:, 3)
  end subroutine fold_triangle

  !> Convert an integration rule of the tetrahedron to one of the cube.
  subroutine unfold_rule(t, w, rule)
    real(wp), intent(in) :: t(:, :)  !! (3, nq) inside the tetrahedron
    real(wp), intent(in) :: w(:)     !! (nq) weights, sum 1/6
    type(rule_t), intent(out) :: rule
    real(wp) :: s(3)
    integer :: q

    rule%nq = size(w)
    allocate (rule%xi(3, rule%nq), rule%wgt(rule%nq))
    do q = 1, rule%nq
      s(3) = t(3, q)
      s(2) = t(2, q)/(1.0_wp - s(3))
      s(1) = t(1, q)/((1.0_wp - s(2))*(1.0_wp - s(3)))
      rule%xi(:, q) = 2.0_wp*s - 1.0_wp
      rule%wgt(q) = 8.0_wp*w(q)/((1.0_wp - s(2))*(1.0_wp - s(3))**2)
    end do
  end subroutine unfold_rule

  !> Set the rule of a collapsed element: n x n x n points of the cube, where n is the larger one of
  !! the two numbers of QUADrature, but at least 2.
  subroutine collapsed_rule(cell, q, qz, rule)
    type(cell_t), intent(in) :: cell
    integer, intent(in) :: q, qz
    type(rule_t), intent(out) :: rule

    integer :: n

    associate (unused => cell); end associate
    n = max(q, qz, 2) ! in each direction, because the map raises the degree in all of them
    call tensor_rule([n, n, n], 0, 0, rule)
  end subroutine collapsed_rule

end module collapsed_shape
