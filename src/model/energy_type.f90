!> Energy balance since the start: the work done on the bodies, and the energies into which it was
!! converted.
module energy_type
  use base_kinds, only: wp
  implicit none
  private
  public :: energy_t, open_book, book_work

  !> Amounts of work are sums over the steps of mean force times displacement increment (trapezoidal
  !! rule). The energy that contact stores and dissipates is instead computed from the contact laws
  !! (contact_energy), and compared with the work of the contact forces.
  type :: energy_t
    real(wp) :: outer = 0.0_wp        !! work of loads and of moving supports [F L]
    real(wp) :: error = 0.0_wp        !! bound on the error of `outer` (error_of_step) [F L]
    real(wp) :: inertia = 0.0_wp      !! work against inertia, partly dissipated numerically [F L]
    real(wp) :: kinetic = 0.0_wp      !! current kinetic energy [F L]
    real(wp) :: contact = 0.0_wp      !! work against the contact forces [F L]
    real(wp) :: penetration = 0.0_wp  !! energy stored in penetration, see follow_penetration [F L]
    real(wp) :: penetration_share = 0.0_wp !! ratio of `penetration` to `outer` at that time [-]
    logical :: moving = .false.       !! the last step was one with inertia (energy_growth)
    !> Excess of the energies of bodies, contacts and motion over the work done by loads and
    !! supports, before the first step with inertia [F L].
    real(wp) :: excess_before = 0.0_wp
    !> Excess of the energies of contacts and motion over the work done against contact forces and
    !! inertia, at the same time [F L].
    real(wp) :: excess_without = 0.0_wp
    real(wp) :: largest = 0.0_wp      !! largest energy of bodies, contacts and motion [F L]
    real(wp) :: growth = 0.0_wp       !! largest rise of the excess above `excess_before` [F L]
    real(wp) :: growth_time = 0.0_wp  !! time at which `growth` was reached
    !> (3, nnode) Forces at the end of the previous step: of loads and supports, of inertia, and of
    !! contact [F].
    real(wp), allocatable :: f_outer(:, :), f_inert(:, :), f_contact(:, :)
    real(wp), allocatable :: rise(:, :) !! (3, nnode) change of f_outer in the previous step [F]
  end type energy_t

contains

  !> Set all amounts of work and all forces to zero.
  pure subroutine open_book(energy, nnode)
    type(energy_t), intent(out) :: energy
    integer, intent(in) :: nnode

    allocate (energy%f_outer(3, nnode), energy%f_inert(3, nnode), energy%f_contact(3, nnode), &
              energy%rise(3, nnode), source=0.0_wp)
  end subroutine open_book

  !> At the end of a step, add the work that the mean forces of the step do along du.
  pure subroutine book_work(energy, du, du_before, f_outer, f_inert, f_contact)
    type(energy_t), intent(inout) :: energy
    real(wp), intent(in) :: du(:, :), du_before(:, :) !! (3, nnode); previous step [L]
    real(wp), intent(in) :: f_outer(:, :), f_inert(:, :), f_contact(:, :) !! (3, nnode) [F]
    real(wp) :: rise(3, size(du, 2))

    rise = f_outer - energy%f_outer
    energy%error = energy%error + error_of_step(du, rise, du_before, energy%rise, &
                                                abs(f_outer) + abs(energy%f_outer) > 0.0_wp)
    energy%outer = energy%outer + 0.5_wp*sum((f_outer + energy%f_outer)*du)
    energy%inertia = energy%inertia + 0.5_wp*sum((f_inert + energy%f_inert)*du)
    energy%contact = energy%contact + 0.5_wp*sum((f_contact + energy%f_contact)*du)
    energy%rise = rise
    energy%f_outer = f_outer
    energy%f_inert = f_inert
    energy%f_contact = f_contact
  end subroutine book_work

  !> Bound on the error of the trapezoidal rule in a step, from the changes of displacement and
  !! force in this step and in the previous one.
  !!
  !! If the force varies monotonically, its work lies between the work of its first value and that
  !! of its last value, each taken as constant. The error is then at most half of |rise.du|, where
  !! rise is the change of the force. If the force is a convex or a concave function of the
  !! displacement over both steps, its work also lies between the works of two forces that vary
  !! linearly: one follows the chord of this step; the other one continues the chord of the previous
  !! step, and therefore changes by r rise_before, where r is the length of du divided by that of
  !! du_before. If the direction of motion changes, a further term is added to this second bound.
  !! The smaller one of the two bounds is used.
  pure real(wp) function error_of_step(du, rise, du_before, rise_before, loaded) result(error)
    real(wp), intent(in) :: du(:, :), rise(:, :), du_before(:, :), rise_before(:, :)
    logical, intent(in) :: loaded(:, :) !! (3, nnode) a support or load acts there
    real(wp) :: before, r

    error = 0.5_wp*abs(sum(rise*du))
    before = norm2(pack(du_before, loaded))
    if (.not. before > 0.0_wp) return
    r = norm2(pack(du, loaded))/before
    error = min(error, 0.5_wp*(abs(sum((rise - r*rise_before)*du)) &
                               + abs(sum(rise*(du - r*du_before)))))
  end function error_of_step

end module energy_type
