!> Stresses from integration points to nodes and control points.
!!
!!   T_A = int N_A sigma dv / int N_A dv
!!
!! over the current volume (the volume form of the smoothing of Sauer 2013): a mean with positive
!! weights where N_A >= 0. Elements with functions of no or negative volume (quadratic tetrahedra)
!! take N_A^2 for N_A. A constant stress is kept exactly.
module stress_projection
  use base_kinds, only: wp
  use basis_type, only: basis_t
  use mesh, only: block_t, is_rigid
  use model, only: model_t, state_t
  use solid_recover, only: recovered_t, recover
  use tensor, only: det3
  implicit none
  private
  public :: project_stress

  integer, parameter :: NVALUE = 7 !! six components and von Mises' stress

contains

  !> Smooth fields; zero at nodes that belong to no element.
  subroutine project_stress(model, state, stress, mises)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: stress(:, :) !! (6, nnode) Cauchy, 11 22 33 12 23 31 [F/L^2]
    real(wp), intent(out) :: mises(:, :)  !! (1, nnode) [F/L^2]
    real(wp), allocatable :: total(:, :)  !! (NVALUE+1, nnode) values and volume
    integer :: a, b

    allocate (total(NVALUE + 1, model%mesh%nnode), source=0.0_wp)
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      call add_block(model, state, b, total)
    end do
    stress = 0.0_wp
    mises = 0.0_wp
    do a = 1, model%mesh%nnode
      if (total(NVALUE + 1, a) <= 0.0_wp) cycle
      stress(:, a) = total(:6, a)/total(NVALUE + 1, a)
      mises(1, a) = total(7, a)/total(NVALUE + 1, a)
    end do
  end subroutine project_stress

  subroutine add_block(model, state, b, total)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b
    real(wp), intent(inout) :: total(:, :)
    type(recovered_t), allocatable :: point(:)
    real(wp), allocatable :: share(:, :) !! (nen, nq) N_A or its square
    integer :: c, e
    logical :: ok

    associate (block => model%mesh%block(b))
      do c = 1, size(block%basis)
        allocate (point(block%basis(c)%nq))
        do e = 1, block%nelem
          if (block%ibasis(e) /= c) cycle
          associate (node => block%conn(:, e), set => model%material(block%material))
            call recover(block%basis(c), set%row, set%prop, model%mesh%xr(:, node), &
                         state%u(:, node), state%history(b)%iter(:, e), point, ok)
            if (.not. allocated(share)) call set_share(block%basis(c), point%volume, share)
            call add_element(point, set%row%finite, share, node, total)
          end associate
        end do
        deallocate (point)
        if (allocated(share)) deallocate (share)
      end do
    end associate
  end subroutine add_block

  subroutine add_element(point, finite, share, node, total)
    type(recovered_t), intent(in) :: point(:)
    logical, intent(in) :: finite          !! the current volume counts
    real(wp), intent(in) :: share(:, :)
    integer, intent(in) :: node(:)
    real(wp), intent(inout) :: total(:, :)
    real(wp) :: dv, value(NVALUE + 1)
    integer :: a, q

    do q = 1, size(point)
      dv = point(q)%volume
      if (finite) dv = dv*det3(point(q)%dg)
      if (dv <= 0.0_wp) cycle
      value = dv*[point(q)%sig, point(q)%mises, 1.0_wp]
      do a = 1, size(node)
        total(:, node(a)) = total(:, node(a)) + share(a, q)*value
      end do
    end do
  end subroutine add_element

  !> Weights of the mean at the points; one element tells for its class.
  subroutine set_share(basis, dv, share)
    type(basis_t), intent(in) :: basis
    real(wp), intent(in) :: dv(:)        !! (nq) reference volumes of an element's points [L^3]
    real(wp), allocatable, intent(out) :: share(:, :)
    real(wp) :: volume(basis%nen)
    real(wp), parameter :: NONE = 1.0e-10_wp !! of the largest [-]

    share = basis%shp
    volume = matmul(basis%shp, dv)
    if (any(volume <= NONE*maxval(volume))) share = basis%shp**2
  end subroutine set_share

end module stress_projection
