!> Stress and energy of elements and reactions of nodes, for curves and printed tables.
!!
!! Reactions are defined as in FEAPpv: they are the internal forces at the nodes minus the
!! forces of body forces and pressures. Nodal forces (FORC, EFOR, CFOR, CSUR) are not subtracted: a
!! free node with an applied force shows that force, and the sum over all nodes is zero in
!! equilibrium without body forces and pressures.
module point_values
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use load_curve, only: load_factor
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  use model_basis, only: tabulate_points
  use solid_recover, only: recovered_t, recover
  implicit none
  private
  public :: stress_at, reactions_at, body_energy, largest_mises

contains

  !> Find stress and energy of one element at the points of a basis.
  subroutine recover_at(model, state, b, e, basis, point, ok)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b, e                   !! block and element
    type(basis_t), intent(in) :: basis
    type(recovered_t), intent(out) :: point(:)    !! (nq)
    logical, intent(out) :: ok

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material))
      call recover(basis, mat%row, mat%prop, model%mesh%xr(:, block%conn(:, e)), &
                   state%u(:, block%conn(:, e)), state%history(b)%iter(:, e), point, ok)
    end associate
  end subroutine recover_at

  !> Cauchy stress at a point of an element; the point is given by its parent coordinates.
  function stress_at(model, state, b, e, xi) result(sig)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b, e
    real(wp), intent(in) :: xi(3)
    real(wp) :: sig(6)
    type(basis_t) :: basis
    type(recovered_t) :: point(1)
    logical :: ok

    call tabulate_points(model%mesh%block(b), e, reshape(xi, [3, 1]), [1.0_wp], basis)
    call recover_at(model, state, b, e, basis, point, ok)
    sig = point(1)%sig
  end function stress_at

  !> Nodal internal forces minus the forces of body forces and pressures.
  pure function reactions_at(model, state, factor, node) result(r)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(in) :: factor(:)             !! with which state%reaction was formed
    integer, intent(in) :: node(:)
    real(wp) :: r(3, size(node))                  !! [F]
    integer :: i, d

    do i = 1, size(node)
      associate (n => node(i))
        r(:, i) = state%reaction(:, n)
        if (.not. allocated(model%bc%force)) cycle
        do d = 1, 3
          r(d, i) = r(d, i) + model%bc%force(d, n)*load_factor(factor, model%bc%table(d, n))
        end do
      end associate
    end do
  end function reactions_at

  !> Stored energy of a body; body 0 means the whole model.
  function body_energy(model, state, body) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: body
    real(wp) :: energy, unused

    call sweep(model, state, body, energy, unused)
  end function body_energy

  !> Largest von Mises stress at the integration points of a body; body 0 means the whole model.
  function largest_mises(model, state, body) result(mises)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: body
    real(wp) :: mises, unused

    call sweep(model, state, body, unused, mises)
  end function largest_mises

  subroutine sweep(model, state, body, energy, mises)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: body
    real(wp), intent(out) :: energy, mises
    type(recovered_t), allocatable :: point(:)
    logical :: ok
    integer :: b, e

    energy = 0.0_wp
    mises = 0.0_wp
    do b = 1, size(model%mesh%block)
      if (body > 0 .and. model%mesh%block(b)%body /= body) cycle
      if (is_rigid(model%mesh%block(b))) cycle
      allocate (point(model%mesh%block(b)%rule%nq))
      do e = 1, model%mesh%block(b)%nelem
        associate (block => model%mesh%block(b))
          call recover_at(model, state, b, e, block%basis(block%ibasis(e)), point, ok)
        end associate
        energy = energy + sum(point%energy*point%volume)
        mises = max(mises, maxval(point%mises))
      end do
      deallocate (point)
    end do
  end subroutine sweep

end module point_values
