!> Stress and energy of the elements, for curves and printed tables.
module point_values
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use mesh, only: block_t, is_rigid
  use model, only: model_t, state_t
  use model_basis, only: tabulate_points
  use solid_recover, only: recovered_t, recover
  implicit none
  private
  public :: stress_at, body_energy, largest_mises

contains

  !> State of one element at its integration points.
  subroutine element_points(model, state, b, e, point, ok)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b, e                   !! block and element
    type(recovered_t), intent(out) :: point(:)    !! (nq)
    logical, intent(out) :: ok

    associate (block => model%mesh%block(b))
      call recover_at(model, state, b, e, block%basis(block%ibasis(e)), point, ok)
    end associate
  end subroutine element_points

  subroutine recover_at(model, state, b, e, basis, point, ok)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b, e
    type(basis_t), intent(in) :: basis
    type(recovered_t), intent(out) :: point(:)
    logical, intent(out) :: ok

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material))
      call recover(basis, mat%row, mat%prop, model%mesh%xr(:, block%conn(:, e)), &
                   state%u(:, block%conn(:, e)), state%history(b)%iter(:, e), point, ok)
    end associate
  end subroutine recover_at

  !> Cauchy stress at a parent point of an element.
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

  !> Stored energy of a body; 0: of all.
  function body_energy(model, state, body) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: body
    real(wp) :: energy, unused

    call sweep(model, state, body, energy, unused)
  end function body_energy

  !> Largest von Mises stress at the integration points of a body; 0: of all.
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
        call element_points(model, state, b, e, point, ok)
        energy = energy + sum(point%energy*point%volume)
        mises = max(mises, maxval(point%mises))
      end do
      deallocate (point)
    end do
  end subroutine sweep

end module point_values
