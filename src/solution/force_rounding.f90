!> Rounding errors of the internal forces, compared with the loads that the forces balance.
!!
!! Displacements are known with a relative error of epsilon. The internal force of a node is
!! therefore known with an error of epsilon times the stiffness that couples the node with its
!! neighbours, times their displacements. If a part is very stiff or moves far in comparison with
!! its strain, this error can be as large as the loads. The same holds for contact under loads that
!! are tiny compared with the stiffness, because gaps are differences of positions. The convergence
!! test accepts such a state once the residual no longer decreases.
!!
!! Errors and loads are compared at the end of a run, and each of them is the largest one of the
!! run: a step in which loads vanish, or in which surfaces only begin to touch, consists of rounding
!! errors and is nevertheless accurate. If all bonds break within one step, no step ends with the
!! forces that they bore, so their strength counts as a load.
module force_rounding
  use base_comm, only: total_of => total
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use contact_bond, only: released_force
  use csr, only: block_matrix_t, diagonal_block
  use model, only: model_t, state_t
  use newton_type, only: pass_t
  use step_type, only: step_t
  implicit none
  private
  public :: follow_rounding, warn_rounding, rounding_of_forces

  real(wp), parameter :: SHARE = 1.0e-3_wp !! error that causes a warning, relative to the loads
  !> A reaction or a force of contact is a load only if it exceeds this many times its own rounding
  !! error. Otherwise it may consist of this error, as in a rigid motion without loads.
  real(wp), parameter :: CERTAIN = 100.0_wp

contains

  !> Before a step is accepted, keep the largest rounding error and the largest load so far. The
  !! tangent and the forces are those of the converged displacements.
  subroutine follow_rounding(step, model, state, pass)
    type(step_t), intent(inout) :: step
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(pass_t), intent(in) :: pass
    real(wp), allocatable :: length(:), error(:, :), doubt(:, :)
    real(wp) :: largest
    integer :: c

    allocate (length, source=norm2(state%u, 1))
    allocate (error(3, model%mesh%nnode), doubt(3, model%mesh%nnode))
    associate (asm => step%newton%asm, total => step%total)
      call rounding_of_forces(asm%k, length, error)
      doubt = error
      ! gaps are differences of positions, which have rounding errors without any displacement
      if (size(model%contact) > 0) then
        call rounding_of_forces(asm%k, length + step%newton%spacing, doubt)
      end if
      total%load = max(total%load, maxval(abs(asm%f_ext)), &
                       maxval(abs(state%reaction), &
                              model%eq == 0 .and. abs(state%reaction) > CERTAIN*doubt), &
                       maxval(abs(asm%f_contact), abs(asm%f_contact) > CERTAIN*doubt), &
                       maxval([(released_force(model%contact(c), state%contact(c)), &
                                c=1, size(model%contact))]))
      if (.not. step%newton%converged) return
      largest = maxval(error)
      if (pass%residual <= pass%floor%force .or. step%newton%at_floor) then
        largest = max(largest, pass%residual)
      end if
      if (largest <= total%rounding) return
      total%rounding = largest
      total%rounding_step = state%step
    end associate
  end subroutine follow_rounding

  !> Estimate the rounding errors of the internal forces for given lengths whose relative error is
  !! epsilon/2. The errors of different nodes are independent of each other, so their squares are
  !! added, relative to the largest one, so that they do not overflow.
  subroutine rounding_of_forces(k, length, error)
    type(block_matrix_t), intent(in) :: k
    real(wp), intent(in) :: length(:)    !! (nnode) displacements of the nodes [L]
    real(wp), intent(out), contiguous :: error(:, :) !! (3, nnode) [F]
    real(wp) :: stiffest, longest
    integer :: i, j, p

    error = 0.0_wp
    longest = maxval(length)
    stiffest = 0.0_wp
    do i = 1, k%nnode
      stiffest = max(stiffest, maxval(abs(diagonal_block(k, i))))
    end do
    if (.not. (longest > 0.0_wp .and. stiffest > 0.0_wp)) return
    do i = 1, k%nnode
      do p = k%row(i), k%row(i + 1) - 1
        j = k%col(p)
        error(:, i) = error(:, i) + sum((k%val(:, :, p)/stiffest*(length(j)/longest))**2, 2)
        if (k%symmetric .and. j /= i) then ! only the upper blocks are stored
          error(:, j) = error(:, j) + sum((k%val(:, :, p)/stiffest*(length(i)/longest))**2, 1)
        end if
      end do
    end do
    if (k%shared) call total_of(error)
    error = 0.5_wp*epsilon(1.0_wp)*sqrt(error)*stiffest*longest
  end subroutine rounding_of_forces

  !> At the end of a run, warn if rounding errors have reached a part of the loads.
  subroutine warn_rounding(step)
    type(step_t), intent(in) :: step

    associate (total => step%total)
      if (.not. (total%load > 0.0_wp .and. total%rounding > SHARE*total%load)) return
      call warn('rounding errors of the internal forces reach ' &
                //to_text(100.0_wp*total%rounding/total%load, 2) &
                //' % of the largest load or reaction (in step '//to_text(total%rounding_step) &
                //'), because a part is very stiff or moves far in comparison with its strain, ' &
                //'or because loads are tiny compared with the stiffness: forces, and the ' &
                //'stresses of this part, may be wrong by as much', &
                hint='give a stiff part a smaller modulus, such as 1e6 times that of its ' &
                //'neighbours, or replace it by a rigid surface (TYPE RIGId) or by FIX and MOVE; ' &
                //'if the loads are tiny, increase them, since small strains are proportional to ' &
                //'them')
    end associate
  end subroutine warn_rounding

end module force_rounding
