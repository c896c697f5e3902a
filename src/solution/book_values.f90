!> Columns of the book of energies.
module book_values
  use base_kinds, only: wp
  use contact_pair, only: contact_points_t
  use curve_type, only: B_WORK, B_STORED, B_KINETIC, B_NORMAL, B_FRICTION, B_COHESIVE, B_INERTIA, &
                        B_BONDS, B_DAMAGE, B_VISCOUS
  use model, only: model_t, state_t
  use point_values, only: body_energy
  implicit none
  private
  public :: book_value

contains

  !> One entry. What the supports and loads have given is found again in the others; IMBAlance is
  !! what is not: the error of the trapezoidal rule over the steps [F L].
  real(wp) function book_value(model, state, entry) result(value)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: entry

    associate (book => state%energy)
      select case (entry)
      case (B_WORK)
        value = book%outer
      case (B_STORED)
        value = body_energy(model, state, 0)
      case (B_KINETIC)
        value = book%kinetic
      case (B_NORMAL, B_FRICTION, B_COHESIVE)
        value = book%contact(entry - B_NORMAL + 1)
      case (B_INERTIA)
        value = book%inertia - book%kinetic
      case (B_BONDS, B_DAMAGE, B_VISCOUS)
        value = bond_energy(model, state, entry - B_BONDS + 1)
      case default
        value = book%outer - body_energy(model, state, 0) - book%inertia - sum(book%contact)
      end select
    end associate
  end function book_value

  !> Energy of all bonds by their laws: 1 held, 2 spent by damage, 3 by viscosity. Each of the two
  !! sides tells of the whole interface, hence their mean; a rigid one has no points.
  pure real(wp) function bond_energy(model, state, part) result(energy)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: part
    integer :: c

    energy = 0.0_wp
    do c = 1, size(model%contact)
      if (.not. model%contact(c)%has_cohesive) cycle
      associate (side => state%contact(c)%side, rigid => model%contact(c)%side%rigid)
        energy = energy + (of_side(side(1)) + of_side(side(2)))/count(.not. rigid)
      end associate
    end do

  contains

    pure real(wp) function of_side(points)
      type(contact_points_t), intent(in) :: points

      of_side = sum(points%area0*points%energy(part, :), mask=points%bond > 0)
    end function of_side
  end function bond_energy

end module book_values
