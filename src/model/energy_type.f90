!> Energy balance since the start: work done on the bodies, and the energies into which it went.
module energy_type
  use base_kinds, only: wp
  implicit none
  private
  public :: energy_t, open_book, book_work

  !> Works are sums over the steps of mean force times displacement increment (trapezoidal rule).
  type :: energy_t
    logical :: on = .false.
    real(wp) :: outer = 0.0_wp        !! work of loads and of moving supports [F L]
    real(wp) :: inertia = 0.0_wp      !! work against inertia, partly dissipated in time [F L]
    real(wp) :: kinetic = 0.0_wp      !! current kinetic energy [F L]
    real(wp) :: contact(3) = 0.0_wp   !! work against pressure, friction and cohesion [F L]
    !> The largest work against the pressure so far, and its fraction of `outer` at that time.
    real(wp) :: penetration = 0.0_wp, penetration_share = 0.0_wp
    !> Forces at the end of the last step.
    real(wp), allocatable :: f_outer(:, :), f_inert(:, :) !! (3, nnode) [F]
    real(wp), allocatable :: f_contact(:, :, :)           !! (3, nnode, 3)
  end type energy_t

contains

  !> Set all works and forces to zero.
  pure subroutine open_book(energy, nnode)
    type(energy_t), intent(out) :: energy
    integer, intent(in) :: nnode

    allocate (energy%f_outer(3, nnode), energy%f_inert(3, nnode), source=0.0_wp)
    allocate (energy%f_contact(3, nnode, 3), source=0.0_wp)
    energy%on = .true.
  end subroutine open_book

  !> End a step: add the work that its mean forces do along du.
  pure subroutine book_work(energy, du, f_outer, f_inert, f_contact)
    type(energy_t), intent(inout) :: energy
    real(wp), intent(in) :: du(:, :)               !! (3, nnode) [L]
    real(wp), intent(in) :: f_outer(:, :), f_inert(:, :), f_contact(:, :, :)
    integer :: i

    if (.not. energy%on) return
    energy%outer = energy%outer + 0.5_wp*sum((f_outer + energy%f_outer)*du)
    energy%inertia = energy%inertia + 0.5_wp*sum((f_inert + energy%f_inert)*du)
    do i = 1, 3
      energy%contact(i) = energy%contact(i) &
                          + 0.5_wp*sum((f_contact(:, :, i) + energy%f_contact(:, :, i))*du)
    end do
    energy%f_outer = f_outer
    energy%f_inert = f_inert
    energy%f_contact = f_contact
  end subroutine book_work

end module energy_type
