!> The convergence test of Newton's iteration, the limits of this test, and the treatment of
!! iterations that oscillate.
!!
!! Positions are known with a relative error of epsilon, so a nodal force is known with an error of
!! epsilon times the stiffness of the node, times the sum of its displacement and the distance to
!! its nearest neighbour. This error is the rounding floor. Without this floor, a step in which
!! nothing changes (for example, if a load stays zero after unloading) would consist of rounding
!! errors only and never pass a relative test.
module convergence
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use base_kinds, only: wp
  use contact_assembly, only: has_stale_cells
  use contact_pair, only: MORTAR
  use csr, only: block_matrix_t, diagonal_block
  use mesh, only: mesh_t
  use model, only: model_t
  use newton_type, only: newton_t, pass_t, floor_t
  implicit none
  private
  public :: check_convergence, energy_tolerance, force_tolerance, find_largest_residual, &
            node_spacing, find_floor, needs_line_search, needs_signs, find_forcing, damping, &
            count_flips, turns_back, has_lost_balance

  !> Rounding error of an energy, relative to the sum of |f||u|.
  real(wp), parameter :: ROUNDING = (1.0e3_wp*epsilon(1.0_wp))**2
  real(wp), parameter :: RESIDUAL = 1.0e-9_wp !! largest residual, relative to the largest nodal
  !! force
  !> Largest residual of an increment whose energy passes the test, relative to the largest nodal
  !! force and to the square root of the tolerance. It matters only if the largest energy of the
  !! step belongs to an increment far away from the solution.
  real(wp), parameter :: ENOUGH = 1.0e4_wp
  !> The residual does not matter if the energy of the increment is at most this many times that of
  !! rounding errors, as where a tool pushes a free body and the force of contact vanishes.
  real(wp), parameter :: NEGLIGIBLE = 100.0_wp
  !> An iteration whose energy is within the rounding floor ends when its residual is small,
  !! relative to the largest nodal force or to the floor of forces, or when it has not decreased by
  !! IMPROVES in MOST_STALLS iterations. Under loads that are tiny compared with the stiffness, the
  !! energy alone would end it far too early.
  real(wp), parameter :: SMALL = 1.0e-6_wp, REACHED = 1.0_wp/16.0_wp, IMPROVES = 0.5_wp
  integer, parameter :: MOST_STALLS = 4
  !> Largest residual after the last increment, relative to the largest nodal force. A larger one
  !! means that contact has changed in this increment.
  real(wp), parameter :: LOST = 1.0e-3_wp
  real(wp), parameter :: FLOOR_OF_FORCE = 16.0_wp*epsilon(1.0_wp)
  !> Relative rounding error of displacements. It is larger than FLOOR_OF_FORCE because the softest
  !! motion of a slender body magnifies rounding errors of the forces.
  real(wp), parameter :: FLOOR_OF_MOTION = 1.0e3_wp*epsilon(1.0_wp)
  integer, parameter :: PATIENCE = 6 !! iterations of a step with contact before a line search is
  !! used
  !> An increment reverses the previous increment if the cosine of the angle between the two is
  !! below minus this.
  real(wp), parameter :: OPPOSITE = 0.7_wp
  real(wp), parameter :: LEAST_FRACTION = 0.2_wp !! smallest fraction of a shortened increment
  !> Relative residuals to which linear systems are solved. If factors are not kept, this is
  !! FORCING. With kept factors, an ordinary solve uses a value between FORCING_LEAST and FORCING
  !! (FORCING_CONTACT in a model with contact), and an increment with prescribed motion uses
  !! FORCING_MOVED. FORCING_LAST is for a solve that only confirms convergence, and FORCING_ALONE
  !! for a solve that is not repeated or in which only springs or anchors hold a body.
  real(wp), parameter :: FORCING = 1.0e-3_wp, FORCING_MOVED = 1.0e-4_wp, FORCING_LAST = 0.1_wp
  real(wp), parameter :: FORCING_CONTACT = 1.0e-4_wp
  real(wp), parameter :: FORCING_LEAST = 1.0e-8_wp, FORCING_ALONE = 1.0e-12_wp
  !> Largest relative residual of a solve whose increment counts as that of the whole tangent.
  real(wp), parameter :: FORCING_NEWTON = 1.0e-4_wp
  real(wp), parameter :: NEARLY = 3.0_wp !! a residual of up to this multiple of the expected one is
  !! as expected
  real(wp), parameter :: MARGIN = 0.2_wp !! permitted residual of a solve, relative to the tolerance
  integer, parameter :: MOST_FLIPS = 5 !! number of consecutive changes of sign that shows an
  !! alternation

contains

  !> Apply the convergence test (doc/manual/TOL.md).
  subroutine check_convergence(newton, pass, moved)
    type(newton_t), intent(inout) :: newton
    type(pass_t), intent(inout) :: pass
    logical, intent(in) :: moved       !! the increment contains prescribed motion

    pass%ratio = 0.0_wp
    if (newton%largest_energy > 0.0_wp) pass%ratio = pass%energy/newton%largest_energy
    if (.not. ieee_is_finite(pass%energy)) then
      pass%ok = .false.
      pass%trouble = 'the energy of the increment is infinite or not a number'
      return
    end if
    if (.not. (moved .or. newton%largest_energy > 0.0_wp)) then
      if (pass%residual > force_tolerance(pass)) then
        pass%ok = .false.
        pass%trouble = 'the energy of the increment is too small to be represented; ' &
                       //'choose units in which lengths and stiffnesses are larger'
        return
      end if
    end if
    newton%converged = .not. moved .and. pass%energy <= energy_tolerance(newton, pass)
    if (newton%converged .and. .not. is_newton_increment(newton)) then
      newton%converged = pass%residual <= force_tolerance(pass)
    else if (newton%converged .and. pass%energy > NEGLIGIBLE*energy_floor(pass)) then
      newton%converged = pass%residual <= max(force_tolerance(pass), ENOUGH &
                                              *sqrt(newton%tolerance)*pass%sweep%largest)
    end if
    newton%converged = newton%converged .and. .not. has_stale_cells(newton%asm%contact)
    newton%at_floor = newton%converged .and. &
                      pass%energy > newton%tolerance*newton%largest_energy
    if (moved) return
    if (newton%at_floor .and. pass%residual > IMPROVES*newton%least_residual) then
      newton%stalls = newton%stalls + 1
    end if
    newton%least_residual = min(newton%least_residual, pass%residual)
    if (newton%at_floor) then
      newton%converged = newton%stalls >= MOST_STALLS .or. &
                         pass%residual <= max(SMALL*pass%sweep%largest, REACHED*pass%floor%force)
    end if
  end subroutine check_convergence

  !> Have the forces of contact changed so much in the last increment, which passed the test, that
  !! they are not in equilibrium any more? `newton%dx` is this increment, and `newton%rhs` belongs
  !! to the positions after it.
  pure logical function has_lost_balance(newton, pass) result(yes)
    type(newton_t), intent(in) :: newton
    type(pass_t), intent(in) :: pass

    yes = size(newton%asm%contact) > 0 .and. &
          pass%residual > max(force_tolerance(pass), LOST*pass%sweep%largest) .and. &
          abs(dot_product(newton%dx, newton%rhs)) > NEGLIGIBLE*energy_floor(pass)
  end function has_lost_balance

  !> Was the increment computed with the whole tangent, up to a small error?
  pure logical function is_newton_increment(newton)
    type(newton_t), intent(in) :: newton

    is_newton_increment = newton%exact
    if (newton%system%keeps_factors()) then
      is_newton_increment = newton%exact .and. newton%forcing <= FORCING_NEWTON
    end if
  end function is_newton_increment

  !> Is a body held only by springs or anchors, or was it since friction last held all bodies
  !! throughout a step?
  pure logical function is_held(newton)
    type(newton_t), intent(in) :: newton

    is_held = newton%hold%active .or. allocated(newton%asm%anchors%dv)
  end function is_held

  !> Largest |du.r| that passes the test.
  pure real(wp) function energy_tolerance(newton, pass) result(energy)
    type(newton_t), intent(in) :: newton
    type(pass_t), intent(in) :: pass

    energy = max(newton%tolerance*newton%largest_energy, energy_floor(pass))
  end function energy_tolerance

  !> The part of |du.r| that is due to rounding alone.
  pure real(wp) function energy_floor(pass) result(energy)
    type(pass_t), intent(in) :: pass

    energy = max(ROUNDING*pass%sweep%rounding, pass%floor%energy)
  end function energy_floor

  !> Largest residual that passes the test.
  pure real(wp) function force_tolerance(pass) result(force)
    type(pass_t), intent(in) :: pass

    force = max(RESIDUAL*pass%sweep%largest, pass%floor%force)
  end function force_tolerance

  !> Find the largest residual of the free dofs and its node and direction.
  pure subroutine find_largest_residual(model, reaction, pass)
    type(model_t), intent(in) :: model
    real(wp), intent(in) :: reaction(:, :) !! (3, nnode) [F]
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
  end subroutine find_largest_residual

  !> Distance of every node to the nearest other node of its elements; 0: the node has no element.
  pure function node_spacing(mesh) result(spacing)
    type(mesh_t), intent(in) :: mesh
    real(wp) :: spacing(mesh%nnode)    !! [L]
    real(wp) :: d
    integer :: b, e, i, j

    spacing = huge(1.0_wp)
    do b = 1, size(mesh%block)
      associate (conn => mesh%block(b)%conn)
        do e = 1, mesh%block(b)%nelem
          do i = 1, mesh%block(b)%nen
            do j = 1, i - 1
              d = norm2(mesh%xr(:, conn(i, e)) - mesh%xr(:, conn(j, e)))
              if (.not. d > 0.0_wp) cycle    ! a collapsed element
              spacing(conn(i, e)) = min(spacing(conn(i, e)), d)
              spacing(conn(j, e)) = min(spacing(conn(j, e)), d)
            end do
          end do
        end do
      end associate
    end do
    where (spacing >= huge(1.0_wp)) spacing = 0.0_wp
  end function node_spacing

  !> Find the rounding floor for the given tangent and the current displacements.
  pure function find_floor(k, spacing, u) result(floor)
    type(block_matrix_t), intent(in) :: k
    real(wp), intent(in) :: spacing(:)   !! (nnode) [L]
    real(wp), intent(in) :: u(:, :)      !! (3, nnode) [L]
    type(floor_t) :: floor
    real(wp) :: block(3, 3), length
    integer :: i, n

    do n = 1, k%nnode
      block = diagonal_block(k, n)
      length = norm2(u(:, n)) + spacing(n)
      do i = 1, 3
        floor%force = max(floor%force, FLOOR_OF_FORCE*abs(block(i, i))*length)
        floor%energy = floor%energy + abs(block(i, i))*(FLOOR_OF_MOTION*length)**2
      end do
    end do
  end function find_floor

  !> Is a line search used although the deck does not request it? This is the case after PATIENCE
  !! iterations in a model with contact, where the state of contact probably keeps changing. With
  !! the mortar scheme, `retreat` of line_search makes the same test after each increment.
  pure logical function needs_line_search(newton, model)
    type(newton_t), intent(in) :: newton
    type(model_t), intent(in) :: model

    needs_line_search = .not. all(model%contact%scheme == MORTAR) &
                        .and. newton%iterations - newton%before - newton%secant%count > PATIENCE
  end function needs_line_search

  !> Relative residual to which a linear system is solved (inexact Newton).
  !!
  !! Exact factors give a far smaller residual. With kept factors, every digit costs an iteration of
  !! the linear solver, and more digits than Newton's iteration can use are wasted: where Newton's
  !! iteration converges quadratically, the residual decreases by the square of its last ratio. Nor
  !! does the residual need to fall far below the tolerance. If the last solve reduced the residual
  !! as it would have in a linear problem, this solve continues to the tolerance.
  !!
  !! Source: Eisenstat and Walker 1996 [bib: eisenstat1996]
  pure real(wp) function find_forcing(newton, pass) result(eta)
    type(newton_t), intent(in) :: newton
    type(pass_t), intent(in) :: pass
    real(wp) :: gain

    eta = FORCING
    if (.not. newton%system%keeps_factors()) return
    if (newton%alone .or. is_held(newton)) then
      eta = FORCING_ALONE
    else if (newton%moves) then
      eta = FORCING_MOVED
    else if (pass%residual <= force_tolerance(pass)) then
      eta = FORCING_LAST
    else
      if (size(newton%asm%contact) > 0) eta = FORCING_CONTACT
      gain = 1.0_wp
      if (pass%residual <= NEARLY*newton%expected) then
        gain = 0.0_wp
      else if (newton%before_solve > 0.0_wp) then
        gain = (pass%residual/newton%before_solve)**2
      end if
      gain = max(gain, MARGIN*force_tolerance(pass)/pass%residual)
      eta = max(FORCING_LEAST, min(eta, gain))
    end if
  end function find_forcing

  !> Are the signs of the pivots needed in this solve? They show whether a converged state is
  !! stable, and are used for bodies that contact does not hold and for steps that do not converge.
  pure logical function needs_signs(newton, pass) result(yes)
    type(newton_t), intent(in) :: newton
    type(pass_t), intent(in) :: pass

    yes = .false.
    if (newton%secant%on) return ! the tangent with secants is not that of the model
    yes = is_held(newton) .or. newton%iterations - newton%before - newton%secant%count > PATIENCE &
          .or. (pass%residual <= force_tolerance(pass) .and. .not. newton%moves)
  end function needs_signs

  !> Fraction of an increment that is taken. Points that alternate between two states of contact
  !! make Newton's iteration oscillate. From the fifth iteration, an increment that reverses most of
  !! the previous one is multiplied by Aitken's factor.
  function damping(newton) result(fraction)
    type(newton_t), intent(in) :: newton
    real(wp) :: fraction
    real(wp) :: back, both(newton%system%neq)

    fraction = 1.0_wp
    if (newton%iterations < 5 .or. .not. allocated(newton%last)) return
    back = -dot_product(newton%last, newton%dx)
    if (.not. back > OPPOSITE*norm2(newton%last)*norm2(newton%dx)) return
    both = newton%dx - newton%last
    fraction = min(1.0_wp, -dot_product(newton%last, both)/dot_product(both, both))
    if (.not. fraction > LEAST_FRACTION) fraction = LEAST_FRACTION
  end function damping

  !> Record the sign of the tangent's determinant, or 0 if it is not known, and count the
  !! consecutive iterations that changed it.
  pure subroutine count_flips(newton, sign)
    type(newton_t), intent(inout) :: newton
    integer, intent(in) :: sign

    newton%flips = merge(newton%flips + 1, 0, sign*newton%sign < 0)
    newton%sign = sign
  end subroutine count_flips

  !> Does Newton's iteration alternate between two states of contact whose tangents have
  !! determinants of opposite sign? The load then has a maximum at which a point changes its state,
  !! and beyond it there is no equilibrium nearby.
  pure logical function turns_back(newton)
    type(newton_t), intent(in) :: newton

    turns_back = newton%flips >= MOST_FLIPS
  end function turns_back

end module convergence
