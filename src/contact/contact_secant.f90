!> Cohesive tractions given by secants: the part that all cohesive laws share.
!!
!! With the normal n at the partner, the gap g is split into d_n = n.g and g_t = g - d_n n, and d_t
!! = |g_t|:
!!
!!   T = -s_n(k) d_n n - s_t(k) g_t.
!!
!! A law is defined by its two secants s_n, s_t as functions of the largest openings k so far: those
!! of the two modes, k = (max <d_n>, max d_t), or the largest opening of the whole vector, k_1 = max
!! sqrt(<d_n>^2 + d_t^2). Unloading and compression are linear, with the secant reached so far. A
!! reversible law uses the current opening instead.
!!
!! VISCous multiplies the traction by 1 + tau (D - D_0)/dt with the damage
!! D = 1 - (s_n/s_n(0) + s_t/s_t(0))/2 and its value D_0 at the start of the step.
!!
!! History of a point: 1, 2 largest openings [L]; 3, 4 d_n and d_t [L]; 5 work done without the
!! viscous part [F/L]; 6 viscous work [F/L]; 7 viscous factor of the previous step minus 1 [-].
module contact_secant
  use base_kinds, only: wp
  use contact_type, only: cohesion_t
  implicit none
  private
  public :: pull_by_secants, REVERSIBLE, WHOLE, MODES

  !> Opening on which the secants depend: the current opening, the largest opening so far, or the
  !! largest openings of both modes so far.
  integer, parameter :: REVERSIBLE = 0, WHOLE = 1, MODES = 2

  !> Number of intervals over which the work of a step is integrated: PER_SCALE for a change of the
  !! opening by `scale`, and at most MOST.
  integer, parameter :: PER_SCALE = 32, MOST = 512

  abstract interface
    !> Secants of both modes at the largest openings k, and their derivatives.
    pure subroutine secants_i(prop, k, s, ds)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:)
      real(wp), intent(in) :: k(2)          !! [L]
      real(wp), intent(out) :: s(2)         !! normal, shear [F/L^3]
      real(wp), intent(out) :: ds(2, 2)     !! ds_i/dk_j [F/L^4]
    end subroutine secants_i

    !> Energy that a reversible law stores at an opening k.
    pure function potential_i(prop, k) result(energy)
      import :: wp
      implicit none
      real(wp), intent(in) :: prop(:), k    !! [L]
      real(wp) :: energy                    !! [F/L]
    end function potential_i
  end interface

contains

  !> Find traction, derivatives and energies at the gap g.
  pure subroutine pull_by_secants(secants, memory, prop, scale, lag, g, n, past, now, c, potential)
    procedure(secants_i) :: secants
    integer, intent(in) :: memory           !! REVERSIBLE, WHOLE or MODES
    real(wp), intent(in) :: prop(:)
    real(wp), intent(in) :: scale           !! opening over which the secants change [L]
    real(wp), intent(in) :: lag             !! tau/dt of VISCous [-]
    real(wp), intent(in) :: g(3), n(3)      !! [L]; unit normal, zero if the law does not need it
    real(wp), intent(in) :: past(:)         !! history of the point at the start of the step
    real(wp), intent(out) :: now(:)         !! history at the end of the step
    type(cohesion_t), intent(out) :: c
    procedure(potential_i), optional :: potential !! energy of a reversible law
    real(wp) :: d(2), gt(3), k(2), s(2), ds(2, 2), work

    d(1) = dot_product(n, g)
    gt = g - d(1)*n
    d(2) = norm2(gt)
    call find_largest(memory, d, past, k)
    call secants(prop, k, s, ds)
    now = past
    now(1:2) = k
    now(3:4) = d
    if (present(potential)) then
      now(5) = potential(prop, k(1))
      c%stored = now(5)
    else
      call integrate_work(secants, memory, prop, scale, past, d, work)
      now(5) = past(5) + work
      c%stored = 0.5_wp*sum(s*d**2)
    end if
    c%spent = now(5) - c%stored
    if (lag > 0.0_wp) call add_viscosity(secants, prop, lag, past, s, ds, now)
    c%viscous = now(6)
    call set_traction(memory, d, k, gt, g, n, s, ds, c)
  end subroutine pull_by_secants

  !> Find the largest openings so far, including the current d = (d_n, d_t).
  pure subroutine find_largest(memory, d, past, k)
    integer, intent(in) :: memory
    real(wp), intent(in) :: d(2), past(:)
    real(wp), intent(out) :: k(2)

    k = [max(d(1), 0.0_wp), d(2)]
    if (memory == MODES) then
      k = max(k, past(1:2))
    else
      k = [norm2(k), 0.0_wp]
      if (memory == WHOLE) k(1) = max(k(1), past(1))
    end if
  end subroutine find_largest

  !> Set the traction and its derivatives, dT = -d(s_n d_n n) - d(s_t g_t) with d(d_n) = n.dg + g.dn
  !! and dg_t = dg - d(d_n) n - d_n dn. The largest openings vary with g and n only if they are the
  !! current ones.
  pure subroutine set_traction(memory, d, k, gt, g, n, s, ds, c)
    integer, intent(in) :: memory
    real(wp), intent(in) :: d(2), k(2), gt(3), g(3), n(3), s(2), ds(2, 2)
    type(cohesion_t), intent(inout) :: c
    real(wp) :: dkdg(3, 2), dkdn(3, 2), open, a(3), b(3)
    integer :: i

    dkdg = 0.0_wp
    dkdn = 0.0_wp
    open = max(d(1), 0.0_wp)
    if (memory == MODES) then
      if (open > 0.0_wp .and. open >= k(1)) then
        dkdg(:, 1) = n
        dkdn(:, 1) = g
      end if
      if (d(2) > 0.0_wp .and. d(2) >= k(2)) then
        dkdg(:, 2) = gt/d(2)
        dkdn(:, 2) = -d(1)*gt/d(2)
      end if
    else if (k(1) > 0.0_wp .and. norm2([open, d(2)]) >= k(1)) then
      dkdg(:, 1) = (open*n + gt)/k(1)
      dkdn(:, 1) = (open*g - d(1)*gt)/k(1)
    end if
    c%t = -s(1)*d(1)*n - s(2)*gt
    a = matmul(dkdg, ds(1, :))*d(1) + (s(1) - s(2))*n
    b = matmul(dkdg, ds(2, :))
    do i = 1, 3
      c%dtdg(:, i) = -n*a(i) - gt*b(i)
      c%dtdg(i, i) = c%dtdg(i, i) - s(2)
    end do
    a = matmul(dkdn, ds(1, :))*d(1) + (s(1) - s(2))*g
    b = matmul(dkdn, ds(2, :))
    do i = 1, 3
      c%dtdn(:, i) = -n*a(i) - gt*b(i)
      c%dtdn(i, i) = c%dtdn(i, i) - (s(1) - s(2))*d(1)
    end do
  end subroutine set_traction

  !> Multiply the secants by the viscous factor, and add the viscous work: the work of the step
  !! times the mean of the factor minus 1 at the start and at the end of the step.
  pure subroutine add_viscosity(secants, prop, lag, past, s, ds, now)
    procedure(secants_i) :: secants
    real(wp), intent(in) :: prop(:), lag, past(:)
    real(wp), intent(inout) :: s(2), ds(2, 2), now(:)
    real(wp) :: undamaged(2), before(2), unused(2, 2), dd(2), factor
    integer :: j

    call secants(prop, [0.0_wp, 0.0_wp], undamaged, unused)
    call secants(prop, past(1:2), before, unused)
    factor = 1.0_wp + 0.5_wp*lag*sum((before - s)/undamaged)
    dd = -0.5_wp*lag*matmul(1.0_wp/undamaged, ds)
    do j = 1, 2
      ds(:, j) = factor*ds(:, j) + s*dd(j)
    end do
    s = factor*s
    now(7) = factor - 1.0_wp
    now(6) = past(6) + 0.5_wp*(past(7) + now(7))*(now(5) - past(5))
  end subroutine add_viscosity

  !> Integrate the work along the straight line from the opening at the start of the step to d, by
  !! Simpson's rule on intervals.
  pure subroutine integrate_work(secants, memory, prop, scale, past, d, work)
    procedure(secants_i) :: secants
    integer, intent(in) :: memory
    real(wp), intent(in) :: prop(:), scale, past(:), d(2)
    real(wp), intent(out) :: work
    real(wp) :: change(2), at(2), k(2), s(2), ds(2, 2), weight
    integer :: i, n

    work = 0.0_wp
    change = d - past(3:4)
    if (all(abs(change) <= 0.0_wp)) return
    n = 1 + int(min(real(MOST - 1, wp), PER_SCALE*norm2(change)/scale))
    do i = 0, 2*n
      at = past(3:4) + (0.5_wp*i/n)*change
      call find_largest(memory, at, past, k)
      call secants(prop, k, s, ds)
      weight = merge(4.0_wp, 2.0_wp, mod(i, 2) == 1)
      if (i == 0 .or. i == 2*n) weight = 1.0_wp
      work = work + weight*sum(s*at*change)
    end do
    work = work/(6*n)
  end subroutine integrate_work

end module contact_secant
