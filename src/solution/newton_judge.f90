!> When the iteration is done, what is said of a failure, and how much of an increment is taken.
module newton_judge
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use base_text, only: to_text
  use assembly, only: sweep_t
  use model, only: model_t
  use newton_type, only: newton_t, pass_t
  implicit none
  private
  public :: judge, energy_tolerance, force_tolerance, is_slow, damping, find_worst, name_element, &
            count_flips, turns_back

  real(wp), parameter :: ROUNDING = (1.0e3_wp*epsilon(1.0_wp))**2 !! of an energy, relative to sum
  !! |f||u|
  real(wp), parameter :: RESIDUAL = 1.0e-9_wp !! of the residual, relative to the largest nodal
  !! force
  real(wp), parameter :: BACK_AND_FORTH = 0.7_wp !! cosine beyond which an increment takes back the
  !! last one
  integer, parameter :: PATIENCE = 6 !! iterations of a step with contact without a line search
  real(wp), parameter :: LEAST_SHARE = 0.2_wp      !! of an increment that is damped

  integer, parameter :: TO_AND_FRO = 5 !! changes of sign in a row that are no accident

contains

  !> The convergence test (DECK.md, TOL).
  subroutine judge(newton, pass, moved)
    type(newton_t), intent(inout) :: newton
    type(pass_t), intent(inout) :: pass
    logical, intent(in) :: moved

    pass%ratio = 0.0_wp
    if (newton%largest_energy > 0.0_wp) pass%ratio = pass%energy/newton%largest_energy
    if (.not. ieee_is_finite(pass%energy)) then
      pass%ok = .false.
      pass%trouble = 'the energy of the increment is not a number'
      return
    end if
    newton%converged = .not. moved .and. pass%energy <= energy_tolerance(newton, pass)
    if (newton%converged .and. .not. newton%exact) then
      newton%converged = pass%residual <= force_tolerance(pass)
    end if
  end subroutine judge

  !> Largest |du.r| that passes the test.
  pure real(wp) function energy_tolerance(newton, pass) result(energy)
    type(newton_t), intent(in) :: newton
    type(pass_t), intent(in) :: pass

    energy = max(newton%tolerance*newton%largest_energy, ROUNDING*pass%sweep%rounding, &
                 pass%floor%energy)
  end function energy_tolerance

  !> Largest residual that passes the test.
  pure real(wp) function force_tolerance(pass) result(force)
    type(pass_t), intent(in) :: pass

    force = max(RESIDUAL*pass%sweep%largest, pass%floor%force)
  end function force_tolerance

  !> Contact that does not settle is looked for along the increments, asked for or not.
  pure logical function is_slow(newton, model)
    type(newton_t), intent(in) :: newton
    type(model_t), intent(in) :: model

    is_slow = size(model%contact) > 0 .and. newton%iterations - newton%before > PATIENCE
  end function is_slow

  !> Points that change between two states of contact in turn make Newton's iteration go to and fro
  !! for ever. Where an increment takes most of the last one back, Aitken's share of it is taken.
  function damping(newton) result(share)
    type(newton_t), intent(in) :: newton
    real(wp) :: share
    real(wp) :: back, both(newton%system%neq)

    share = 1.0_wp
    if (newton%iterations < 5 .or. .not. allocated(newton%last)) return
    back = -dot_product(newton%last, newton%dx)
    if (.not. back > BACK_AND_FORTH*norm2(newton%last)*norm2(newton%dx)) return
    both = newton%dx - newton%last
    share = min(1.0_wp, -dot_product(newton%last, both)/dot_product(both, both))
    if (.not. share > LEAST_SHARE) share = LEAST_SHARE
  end function damping

  !> Book the sign of a tangent's determinant, 0 where it is not known.
  pure subroutine count_flips(newton, sign)
    type(newton_t), intent(inout) :: newton
    integer, intent(in) :: sign

    newton%flips = merge(newton%flips + 1, 0, sign*newton%sign < 0)
    newton%sign = sign
  end subroutine count_flips

  !> Newton goes to and fro between two states of contact, each of which leads to the other, and
  !! their tangents differ in the sign of the determinant: the load has a maximum where a point
  !! changes its state, and no equilibrium is near beyond it.
  pure logical function turns_back(newton)
    type(newton_t), intent(in) :: newton

    turns_back = newton%flips >= TO_AND_FRO
  end function turns_back

  !> Largest residual over the free dofs.
  pure subroutine find_worst(model, reaction, pass)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: reaction(:, :)
    type(pass_t), intent(inout) :: pass
    integer :: i, n

    pass%residual = 0.0_wp
    do n = 1, size(model%eq, 2)
      do i = 1, 3
        if (model%eq(i, n) == 0) cycle
        if (.not. abs(reaction(i, n)) <= pass%residual) then
          pass%residual = abs(reaction(i, n))
          pass%worst = [i, n]
        end if
      end do
    end do
  end subroutine find_worst

  !> Which element failed, and of what.
  function name_element(model, sweep) result(text)
    type(model_t), intent(in) :: model
    type(sweep_t), intent(in) :: sweep
    character(:), allocatable :: text

    associate (block => model%mesh%block(sweep%block))
      text = trim(block%name)//' element '//to_text(block%number(sweep%elem))
      if (block%body > 0) text = text//" of '"//model%mesh%body(block%body)%name//"'"
      text = text//' is inverted'
      if (block%row%nmode > 0) text = text//', or its enhanced modes are singular'
    end associate
  end function name_element

end module newton_judge
