!> Projection of stresses from integration points to nodes and control points.
!!
!!   T_A = int N_A sigma dv / int N_A dv
!!
!! The integrals are taken over the current volume (the volume form of the smoothing of Sauer 2013),
!! for small strains (SMALl) over the reference volume.
!! The result is a mean with positive weights if N_A >= 0. N_A^2 replaces N_A in elements in which
!! the integral of a function is zero or negative (quadratic tetrahedra, collapsed sides of Q2). A
!! constant stress is reproduced exactly. The von Mises stress is that of the smoothed components:
!! smoothed by itself, it would be too large where they change sign, and negative where N_A is.
module stress_projection
  use base_kinds, only: wp
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  use solid_recover, only: recovered_t, recover, von_mises
  use tensor, only: det3
  implicit none
  private
  public :: project_stress

  integer, parameter :: NVALUE = 6 !! components of the stress

contains

  !> Compute stress and von Mises stress at the nodes; they are zero at nodes that belong to no
  !! deformable element.
  subroutine project_stress(model, state, stress, mises)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), intent(out) :: stress(:, :) !! (6, nnode) Cauchy, 11 22 33 12 23 31 [F/L^2]
    real(wp), intent(out) :: mises(:, :)  !! (1, nnode) [F/L^2]
    real(wp), parameter :: NONE = 1.0e-10_wp !! an integral is zero below this, relative to the
    !! largest [-]
    type(recovered_t), allocatable :: point(:)
    real(wp), allocatable :: total(:, :)  !! (NVALUE+1, nnode) values and volume
    real(wp), allocatable :: weight(:, :) !! (nen, nq) N_A or its square
    real(wp), allocatable :: volume(:)    !! (nen) integrals of N_A [L^3]
    integer :: a, b, c, e
    logical :: ok

    allocate (total(NVALUE + 1, model%mesh%nnode), source=0.0_wp)
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      associate (block => model%mesh%block(b), set => model%material(model%mesh%block(b)%material))
        do c = 1, size(block%basis)
          allocate (point(block%basis(c)%nq))
          do e = 1, block%nelem
            if (block%ibasis(e) /= c) cycle
            associate (node => block%conn(:, e))
              call recover(block%basis(c), set%row, set%prop, model%mesh%xr(:, node), &
                           state%u(:, node), state%history(b)%iter(:, e), point, ok)
              weight = block%basis(c)%shp
              volume = matmul(weight, point%volume)
              if (any(volume <= NONE*maxval(volume))) weight = weight**2
              call add_element(point, set%row%finite, weight, node, total)
            end associate
          end do
          deallocate (point)
        end do
      end associate
    end do
    stress = 0.0_wp
    mises = 0.0_wp
    do a = 1, model%mesh%nnode
      if (total(NVALUE + 1, a) <= 0.0_wp) cycle
      stress(:, a) = total(:NVALUE, a)/total(NVALUE + 1, a)
      mises(1, a) = von_mises(stress(:, a))
    end do
  end subroutine project_stress

  !> Add the integrals of one element.
  subroutine add_element(point, finite, weight, node, total)
    type(recovered_t), intent(in) :: point(:)
    logical, intent(in) :: finite          !! integrate over the current volume
    real(wp), intent(in) :: weight(:, :)   !! (nen, nq)
    integer, intent(in) :: node(:)
    real(wp), intent(inout) :: total(:, :)
    real(wp) :: dv, value(NVALUE + 1)
    integer :: a, q

    do q = 1, size(point)
      dv = point(q)%volume
      if (finite) dv = dv*det3(point(q)%dg)
      if (dv <= 0.0_wp) cycle
      value = dv*[point(q)%sig, 1.0_wp]
      do a = 1, size(node)
        total(:, node(a)) = total(:, node(a)) + weight(a, q)*value
      end do
    end do
  end subroutine add_element

end module stress_projection
