!> Columns of the book of energies.
module book_values
  use base_kinds, only: wp
  use curve_type, only: B_WORK, B_STORED, B_KINETIC, B_NORMAL, B_FRICTION, B_COHESIVE, B_INERTIA
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
      case default
        value = book%outer - body_energy(model, state, 0) - book%inertia - sum(book%contact)
      end select
    end associate
  end function book_value

end module book_values
