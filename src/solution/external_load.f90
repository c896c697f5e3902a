!> External forces: dead loads at the current load factors, and pressures that follow the surface.
module external_load
  use base_kinds, only: wp
  use boundary, only: boundary_t
  use constraint, only: fold_force
  use csr, only: block_matrix_t, add_element
  use element_type, only: cell_t
  use face_rule, only: face_points, face_normal, face_directions
  use load_curve, only: load_factor
  use mesh, only: block_t, block_cell
  use model, only: model_t, state_t
  implicit none
  private
  public :: map_t, external_force, load_rates, scatter_force, follower_face

  !> Positions in the global matrix of the (3, 3) blocks of the element matrices, for one block of
  !! elements.
  type :: map_t
    integer, allocatable :: at(:, :, :) !! (nen, nen, nelem)
  end type map_t

contains

  !> Compute the dead loads at the current load factors and the follower pressures.
  subroutine external_force(model, state, map, k, f)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(map_t), intent(in) :: map(:)        !! maps, one for each block
    type(block_matrix_t), intent(inout) :: k !! follower pressures add their tangent
    real(wp), intent(out) :: f(:, :)         !! (3, nnode) [F]
    integer :: j

    call dead_forces(model%bc, state%factor, f)
    do j = 1, size(model%bc%pressure)
      if (.not. model%bc%pressure(j)%follower) cycle
      call follower_pressure(model, state, j, state%factor, f, map, k)
    end do
  end subroutine external_force

  !> Compute the derivative of the external forces with respect to time at fixed displacements.
  subroutine load_rates(model, state, slope, f)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: slope(:)         !! (ntable) derivatives of the factors
    real(wp), intent(out) :: f(:, :)         !! (3, nnode)
    integer :: j

    f = 0.0_wp
    if (.not. any(abs(slope) > 0.0_wp)) return
    call dead_forces(model%bc, slope, f)
    do j = 1, size(model%bc%pressure)
      if (model%bc%pressure(j)%follower) call follower_pressure(model, state, j, slope, f)
    end do
    call fold_force(model%mesh%constraint, f)
  end subroutine load_rates

  !> Add the forces of one follower pressure, and their tangent if k is present.
  subroutine follower_pressure(model, state, j, factor, f, map, k)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: j
    real(wp), intent(in) :: factor(:)        !! (ntable) load factors or their derivatives
    real(wp), intent(inout) :: f(:, :)       !! (3, nnode)
    type(map_t), intent(in), optional :: map(:)
    type(block_matrix_t), intent(inout), optional :: k
    real(wp), allocatable :: fe(:, :), ke(:, :)
    real(wp) :: p
    integer :: b, e, i, nen

    p = model%bc%pressure(j)%value*load_factor(factor, model%bc%pressure(j)%table)
    do i = 1, size(model%bc%pressure(j)%elem)
      b = model%bc%pressure(j)%block(i)
      e = model%bc%pressure(j)%elem(i)
      associate (block => model%mesh%block(b))
        nen = block%nen
        allocate (fe(3, nen), ke(3*nen, 3*nen))
        call follower_face(block, e, model%bc%pressure(j)%side(i), p, &
                           model%mesh%xr(:, block%conn(:, e)) + state%u(:, block%conn(:, e)), &
                           fe, ke)
        call scatter_force(block%conn(:, e), fe, f)
        if (present(k)) then
          if (k%symmetric) ke = 0.5_wp*(ke + transpose(ke))
          call add_element(k, map(b)%at(:, :, e), ke)
        end if
        deallocate (fe, ke)
      end associate
    end do
  end subroutine follower_pressure

  pure subroutine scatter_force(conn, r, f)
    integer, intent(in) :: conn(:)
    real(wp), intent(in) :: r(:, :)
    real(wp), intent(inout) :: f(:, :)
    integer :: i

    do i = 1, size(conn)
      f(:, conn(i)) = f(:, conn(i)) + r(:, i)
    end do
  end subroutine scatter_force

  !> Compute nodal forces (FORC, EFOR, CFOR, CSUR), body forces and pressures that do not follow the
  !! surface.
  subroutine dead_forces(bc, factor, f)
    type(boundary_t), intent(in) :: bc
    real(wp), intent(in) :: factor(:)  !! (ntable)
    real(wp), intent(out) :: f(:, :)   !! (3, nnode) [F]
    integer :: i, j, n

    f = 0.0_wp
    do n = 1, size(f, 2)
      do i = 1, 3
        if (abs(bc%force(i, n)) > 0.0_wp) then
          f(i, n) = f(i, n) + bc%force(i, n)*load_factor(factor, bc%table(i, n))
        end if
      end do
    end do
    do j = 1, size(bc%dead)
      associate (load => bc%dead(j))
        do n = 1, size(load%node)
          f(:, load%node(n)) = f(:, load%node(n)) + load_factor(factor, load%table)*load%f(:, n)
        end do
      end associate
    end do
  end subroutine dead_forces

  !> Compute f_a = -p int N_a n da over the current face, and -df/du for the tangent.
  !! With the tangents g1, g2 of the face, n da = g1 x g2, so d(n da) = dg1 x g2 - dg2 x g1.
  subroutine follower_face(block, e, side, p, x, f, k)
    type(block_t), intent(in) :: block
    integer, intent(in) :: e, side
    real(wp), intent(in) :: p            !! current pressure; p > 0 acts on the body [F/L^2]
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

end module external_load
