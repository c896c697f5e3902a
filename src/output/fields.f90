!> The fields of a result: their names and their values at the points of the view.
!!
!! Fields of contact are smoothed to nodes and control points. They are zero at all points of the
!! view that are not on a surface over which a contact integrates.
module fields
  use base_kinds, only: wp
  use base_text, only: lower, key_of
  use model, only: model_t, state_t
  use nodal_contact, only: nodal_contact_t, gather_contact
  use stress_projection, only: project_stress
  use view, only: view_t, map_field, map_surface_field
  implicit none
  private
  public :: field_t, known_fields, default_fields, named_fields, describe_field, collect_fields

  !> One field. At the points of Bezier cells, its values are control values of the field, just as
  !! the positions are control points.
  type :: field_t
    character(16) :: name = ''
    character(90) :: description = ''
    character(8) :: dimension = '-'
    integer :: ncomp = 1
    real(wp), allocatable :: values(:, :) !! (ncomp, npoint)
  end type field_t

  integer, parameter :: NAME = 16, NBODY = 5 !! length of a name; number of fields of bodies

contains

  !> All fields in the order in which they are written: first those of bodies, then those of
  !! contacts.
  pure function known_fields() result(names)
    character(NAME) :: names(NBODY + 6)

    names = [character(NAME) :: 'displacement', 'stress', 'mises', 'pressure', 'reaction', &
             'contact_pressure', 'contact_traction', 'contact_friction', 'contact_gap', &
             'contact_slip', 'contact_state']
  end function known_fields

  !> The fields that are written if the deck names none.
  pure function default_fields(model) result(names)
    type(model_t), intent(in) :: model
    character(NAME), allocatable :: names(:)

    names = known_fields()
    if (size(model%contact) == 0) names = names(:NBODY)
  end function default_fields

  !> Find the known fields that a word of the deck selects. A field of bodies is recognised by its
  !! first four letters, a field of contacts by its whole name; CONTact, or any other word that
  !! begins with these four letters, selects all fields of contacts.
  pure function named_fields(word) result(named)
    character(*), intent(in) :: word
    logical :: named(size(known_fields()))
    character(NAME) :: known(size(known_fields()))

    known = known_fields()
    named = known == lower(word)
    if (.not. any(named)) named = known(:) (:4) == key_of(word)
  end function named_fields

  !> Describe a field, without its values.
  subroutine describe_field(word, field)
    character(*), intent(in) :: word
    type(field_t), intent(out) :: field

    field%name = word
    select case (word)
    case ('displacement')
      call set(3, 'L', 'displacement; add it to the points for the current shape')
    case ('stress')
      call set(6, 'F/L^2', 'Cauchy stress 11 22 33 12 23 31, smoothed from the integration points')
    case ('mises')
      call set(1, 'F/L^2', 'von Mises stress, smoothed from the integration points')
    case ('pressure')
      call set(1, 'F/L^2', 'minus a third of the trace of the smoothed Cauchy stress')
    case ('reaction')
      call set(3, 'F', 'internal minus external nodal force; for sums use CURVe')
    case ('contact_pressure')
      call set(1, 'F/L^2', 'contact pressure, smoothed from the integration points')
    case ('contact_traction')
      call set(3, 'F/L^2', &
               'contact traction on the surface, smoothed from the integration points')
    case ('contact_friction')
      call set(3, 'F/L^2', 'frictional part of the contact traction, smoothed separately')
    case ('contact_gap')
      call set(1, 'L', 'normal gap, smoothed; negative where surfaces penetrate')
    case ('contact_slip')
      call set(3, 'L', 'elastic part of the tangential displacement, smoothed')
    case ('contact_state')
      call set(1, '-', '0 open, 1 stick (or contact without friction), 2 slip; smoothed mean')
    case default
      call set(1, '-', '') ! unknown: collect_fields gives zeros
    end select

  contains

    subroutine set(ncomp, dimension, description)
      integer, intent(in) :: ncomp
      character(*), intent(in) :: dimension, description

      field%ncomp = ncomp
      field%dimension = dimension
      field%description = description
    end subroutine set

  end subroutine describe_field

  !> Collect the fields of the given names with their values.
  subroutine collect_fields(model, state, view, names, field)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    type(view_t), intent(in) :: view
    character(*), intent(in) :: names(:)
    type(field_t), allocatable, intent(out) :: field(:)
    real(wp), allocatable :: stress(:, :), mises(:, :), pressure(:, :)
    type(nodal_contact_t) :: contact
    integer :: i, n

    n = model%mesh%nnode
    if (any(names == 'stress' .or. names == 'mises' .or. names == 'pressure')) then
      allocate (stress(6, n), mises(1, n))
      call project_stress(model, state, stress, mises)
      allocate (pressure(1, n))
      pressure(1, :) = -(stress(1, :) + stress(2, :) + stress(3, :))/3.0_wp
    end if
    if (any(names(:) (:8) == 'contact_')) then
      call gather_contact(model%contact, state%contact, n, contact)
    end if
    allocate (field(size(names)))
    do i = 1, size(names)
      call describe_field(names(i), field(i))
      allocate (field(i)%values(field(i)%ncomp, view%npoint))
      select case (names(i))
      case ('displacement')
        call map_field(view, state%u, field(i)%values)
      case ('stress')
        call map_field(view, stress, field(i)%values)
      case ('mises')
        call map_field(view, mises, field(i)%values)
      case ('pressure')
        call map_field(view, pressure, field(i)%values)
      case ('contact_pressure')
        call map_surface_field(view, contact%met, contact%pressure, field(i)%values)
      case ('contact_traction')
        call map_surface_field(view, contact%met, contact%traction, field(i)%values)
      case ('contact_friction')
        call map_surface_field(view, contact%met, contact%friction, field(i)%values)
      case ('contact_gap')
        call map_surface_field(view, contact%met, contact%gap, field(i)%values)
      case ('contact_slip')
        call map_surface_field(view, contact%met, contact%slip, field(i)%values)
      case ('contact_state')
        call map_surface_field(view, contact%met, contact%state, field(i)%values)
      case ('reaction')
        call map_field(view, state%reaction, field(i)%values)
      case default
        field(i)%values = 0.0_wp
      end select
    end do
  end subroutine collect_fields

end module fields
