!> The fields of a result: what they are called, and their values at the points of the picture.
module fields
  use base_kinds, only: wp
  use model, only: model_t, state_t
  use view, only: view_t, map_field
  use stress_projection, only: project_stress
  implicit none
  private
  public :: field_t, known_fields, is_field, describe_field, collect_fields

  !> One field. Its values at Bezier cells are coefficients, like the positions.
  type :: field_t
    character(16) :: name = ''
    character(90) :: description = ''
    character(8) :: dimension = '-'
    integer :: ncomp = 1
    real(wp), allocatable :: values(:, :) !! (ncomp, npoint)
  end type field_t

  integer, parameter :: NAME = 16

contains

  !> All fields, in the order in which they are written.
  pure function known_fields() result(names)
    character(NAME) :: names(5)

    names = [character(NAME) :: 'displacement', 'stress', 'mises', 'pressure', 'reaction']
  end function known_fields

  pure function is_field(word)
    character(*), intent(in) :: word
    logical :: is_field

    is_field = any(known_fields() == word)
  end function is_field

  !> A field without its values.
  pure subroutine describe_field(word, field)
    character(*), intent(in) :: word
    type(field_t), intent(out) :: field

    field%name = word
    select case (word)
    case ('displacement')
      field%description = 'displacement; add it to the points for the current shape'
      field%dimension = 'L'
      field%ncomp = 3
    case ('stress')
      field%description = 'Cauchy stress 11 22 33 12 23 31, smoothed from the integration points'
      field%dimension = 'F/L^2'
      field%ncomp = 6
    case ('mises')
      field%description = 'von Mises stress, smoothed from the integration points'
      field%dimension = 'F/L^2'
    case ('pressure')
      field%description = 'minus a third of the trace of the smoothed Cauchy stress'
      field%dimension = 'F/L^2'
    case ('reaction')
      field%description = 'internal minus external nodal force; sums belong to the curves'
      field%dimension = 'F'
      field%ncomp = 3
    end select
  end subroutine describe_field

  !> Values of the wanted fields.
  subroutine collect_fields(model, state, view, wanted, field)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(view_t), intent(in) :: view
    character(*), intent(in) :: wanted(:)
    type(field_t), allocatable, intent(out) :: field(:)
    real(wp), allocatable :: stress(:, :), mises(:, :), pressure(:, :)
    integer :: i, n

    n = model%mesh%nnode
    if (any(wanted == 'stress' .or. wanted == 'mises' .or. wanted == 'pressure')) then
      allocate (stress(6, n), mises(1, n))
      call project_stress(model, state, stress, mises)
      allocate (pressure(1, n))
      pressure(1, :) = -(stress(1, :) + stress(2, :) + stress(3, :))/3.0_wp
    end if
    allocate (field(size(wanted)))
    do i = 1, size(wanted)
      call describe_field(wanted(i), field(i))
      allocate (field(i)%values(field(i)%ncomp, view%npoint))
      select case (wanted(i))
      case ('displacement')
        call map_field(view, state%u, field(i)%values)
      case ('stress')
        call map_field(view, stress, field(i)%values)
      case ('mises')
        call map_field(view, mises, field(i)%values)
      case ('pressure')
        call map_field(view, pressure, field(i)%values)
      case ('reaction')
        call map_field(view, state%reaction, field(i)%values)
      end select
    end do
  end subroutine collect_fields

end module fields
