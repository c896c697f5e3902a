!> External forces: dead loads at the factors of now, and the pressures that follow the surface.
module external_load
  use base_kinds, only: wp
  use constraint, only: fold_force
  use csr, only: block_matrix_t, add_element
  use dead_load, only: dead_forces
  use follower_load, only: follower_face
  use load_curve, only: load_factor
  use model, only: model_t, state_t
  implicit none
  private
  public :: map_t, external_force, load_rates, scatter_force

  !> Where the blocks of an element matrix go, for one block of elements.
  type :: map_t
    integer, allocatable :: at(:, :, :) !! (nen, nen, nelem)
  end type map_t

contains

  !> Dead loads at the factors of now, and the pressures that follow the surface.
  subroutine external_force(model, state, map, k, f)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(map_t), intent(in) :: map(:)        !! of the blocks
    type(block_matrix_t), intent(inout) :: k !! follower pressures have a share
    real(wp), intent(out) :: f(:, :)         !! (3, nnode) [F]
    integer :: j

    call dead_forces(model%bc, state%factor, f)
    do j = 1, size(model%bc%pressure)
      if (.not. model%bc%pressure(j)%follower) cycle
      call follower_pressure(model, state, j, state%factor, f, map, k)
    end do
  end subroutine external_force

  !> Derivative of the external forces by time at fixed displacements.
  subroutine load_rates(model, state, slope, f)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: slope(:)         !! (ntable) derivatives of the factors by time
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

  !> One follower pressure: its forces, and their share of the tangent where k is there.
  subroutine follower_pressure(model, state, j, factor, f, map, k)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: j
    real(wp), intent(in) :: factor(:)        !! (ntable) of the load curves, or their derivatives
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

end module external_load
