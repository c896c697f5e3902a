!> Elements that deformation has turned inside out at corners.
!!
!! Only integration points contribute to the forces of an element. Its Jacobian may therefore become
!! negative elsewhere, in particular at its corners, while the equations remain solvable; the body
!! then overlaps itself there. In hexahedra under nodal or contact forces this happens at corners
!! first.
module inverted_corners
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use mesh, only: is_rigid
  use model, only: model_t
  use model_basis, only: tabulate_points
  use tensor, only: det3
  implicit none
  private
  public :: inverted_t, find_inverted_corners

  !> Parent coordinate of the points at which the Jacobian is examined. It is less than 1, because
  !! the map of a collapsed element (a tetrahedron, a prism) is singular at some of its corners.
  real(wp), parameter :: NEAR_CORNER = 0.999_wp
  !> A corner is left out if its edges span a smaller part of the volume of a cuboid, because its
  !! Jacobian is then arbitrary. Examples are the corners of the square that is mapped to a
  !! hemisphere.
  real(wp), parameter :: FLAT = 0.1_wp
  real(wp), parameter :: ROUNDING = 1.0e-6_wp !! relative to the size of an element

  !> The worst corner of a model.
  type :: inverted_t
    integer :: nelem = 0              !! elements that are inside out at one or more corners
    integer :: block = 0, elem = 0    !! the worst element
    real(wp) :: x(3) = 0.0_wp         !! reference position of its worst corner [L]
    real(wp) :: j = 0.0_wp            !! determinant of the deformation gradient there [-]
  end type inverted_t

contains

  !> Find the elements whose deformation gradient has a negative determinant at a corner. Elements
  !! with laws for small strains are left out, because their equations hold in the reference
  !! configuration.
  subroutine find_inverted_corners(model, u, found)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: u(:, :)          !! (3, nnode) displacements [L]
    type(inverted_t), intent(out) :: found
    type(basis_t) :: corner
    real(wp), allocatable :: xr(:, :), xc(:, :)
    real(wp) :: xi(3, 8), map(3, 3), j, least, reference
    integer :: b, class, e, q, worst

    do q = 1, 8
      xi(:, q) = NEAR_CORNER*merge(1.0_wp, -1.0_wp, btest(q - 1, [0, 1, 2]))
    end do
    do b = 1, size(model%mesh%block)
      associate (block => model%mesh%block(b))
        if (is_rigid(block)) cycle
        if (.not. model%material(block%material)%row%finite) cycle
        class = 0
        do e = 1, block%nelem
          if (block%ibasis(e) /= class) then
            class = block%ibasis(e)
            call tabulate_points(block, e, xi, [(1.0_wp, q=1, 8)], corner)
          end if
          xr = model%mesh%xr(:, block%conn(:, e))
          xc = xr + u(:, block%conn(:, e))
          least = 0.0_wp
          worst = 0
          do q = 1, 8
            j = det3(matmul(xc, transpose(corner%dshp(:, :, q))))
            if (.not. j < 0.0_wp) cycle
            map = matmul(xr, transpose(corner%dshp(:, :, q)))
            reference = det3(map)
            if (.not. reference > FLAT*product(norm2(map, 1))) cycle
            j = j/reference
            if (j >= least) cycle
            least = j
            worst = q
          end do
          if (worst == 0) cycle
          found%nelem = found%nelem + 1
          if (least >= found%j) cycle
          found%j = least
          found%block = b
          found%elem = e
          found%x = corner_position(xr, corner, worst, xi(:, worst))
        end do
      end associate
    end do
  end subroutine find_inverted_corners

  !> Extend the map of an element from a point near a corner to the corner itself. Rounding errors
  !! near zero are removed, because users read this position.
  pure function corner_position(xr, basis, q, xi) result(x)
    real(wp), intent(in) :: xr(:, :)      !! (3, nen) reference positions [L]
    type(basis_t), intent(in) :: basis
    integer, intent(in) :: q              !! number of the point
    real(wp), intent(in) :: xi(3)         !! its parent coordinates
    real(wp) :: x(3)

    x = matmul(xr, basis%shp(:, q) + matmul(xi/NEAR_CORNER - xi, basis%dshp(:, :, q)))
    where (abs(x) < ROUNDING*maxval(maxval(xr, 2) - minval(xr, 2))) x = 0.0_wp
  end function corner_position

end module inverted_corners
