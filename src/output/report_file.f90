!> The report of a run: `<stem>.report.json`. The manual explains its keys on the page about the
!! program.
module report_file
  use base_error, only: error_t
  use base_kinds, only: wp
  use byte_file, only: write_whole
  use json_text, only: json_string, json_number, json_member, json_object
  implicit none
  private
  public :: report_t, message_row_t, write_report, add_count, add_real, add_curve

  !> This number is increased when a member changes its name or its meaning, but not when members
  !! are added.
  integer, parameter :: FORMAT = 1

  type :: named_count_t
    character(:), allocatable :: name
    integer :: n = 0
  end type named_count_t

  type :: named_real_t
    character(:), allocatable :: name
    real(wp) :: value = 0.0_wp
  end type named_real_t

  !> Last row of a curve.
  type :: curve_row_t
    character(:), allocatable :: name
    type(named_real_t), allocatable :: column(:)
  end type curve_row_t

  !> Final state of a contact.
  type :: contact_row_t
    character(:), allocatable :: name
    integer :: points = 0               !! number of integration points, both sides
    integer :: closed = 0               !! number of these that are in contact
    !> Largest values over all steps [-]: of the sum |F1 + F2| of the forces on both sides, relative
    !! to the larger force; and of the penetration, relative to the width of an element or to the
    !! thickness, whichever is smaller.
    real(wp) :: balance = 0.0_wp, largest_penetration = 0.0_wp
  end type contact_row_t

  type :: message_row_t
    character(:), allocatable :: text
  end type message_row_t

  type :: report_t
    character(:), allocatable :: version, deck
    character(12) :: status = 'failed'  !! done, no_solution, stopped or failed
    integer :: exit_code = 70
    integer :: steps = 0, iterations = 0, cutbacks = 0
    integer :: dofs = 0                 !! including constrained ones
    integer :: equations = 0
    integer :: negative_pivots = 0      !! negative pivots of the last converged state
    real(wp) :: peak_memory_mb = 0.0_wp
    type(named_count_t), allocatable :: element(:)
    type(named_real_t), allocatable :: seconds(:), cpu_seconds(:)
    type(curve_row_t), allocatable :: final(:)
    type(contact_row_t), allocatable :: contact(:)
    logical :: equilibrium = .true.     !! every state converged without inertia
    type(message_row_t), allocatable :: warning(:)
  end type report_t

contains

  subroutine write_report(path, report, error)
    character(*), intent(in) :: path
    type(report_t), intent(in) :: report
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: SEP = ','//new_line('a')//'  '
    character(:), allocatable :: text, elements, final
    integer :: i

    elements = ''
    if (allocated(report%element)) then
      do i = 1, size(report%element)
        if (i > 1) elements = elements//', '
        elements = elements//json_member(report%element(i)%name, json_number(report%element(i)%n))
      end do
    end if
    final = ''
    if (allocated(report%final)) then
      do i = 1, size(report%final)
        if (i > 1) final = final//', '
        final = final//json_member(report%final(i)%name, reals(report%final(i)%column))
      end do
    end if
    text = '{'//new_line('a')//'  '// &
           json_member('format', json_number(FORMAT))//SEP// &
           json_member('version', json_string(given(report%version)))//SEP// &
           json_member('deck', json_string(given(report%deck)))//SEP// &
           json_member('status', json_string(trim(report%status)))//SEP// &
           json_member('exit_code', json_number(report%exit_code))//SEP// &
           json_member('steps', json_number(report%steps))//SEP// &
           json_member('iterations', json_number(report%iterations))//SEP// &
           json_member('cutbacks', json_number(report%cutbacks))//SEP// &
           json_member('dofs', json_number(report%dofs))//SEP// &
           json_member('equations', json_number(report%equations))//SEP// &
           json_member('elements', json_object(elements))//SEP// &
           json_member('negative_pivots', json_number(report%negative_pivots))//SEP// &
           json_member('seconds', reals(report%seconds))//SEP// &
           json_member('cpu_seconds', reals(report%cpu_seconds))//SEP// &
           json_member('peak_memory_mb', json_number(report%peak_memory_mb))//SEP// &
           json_member('final', json_object(final))
    text = text//SEP//json_member('warnings', '['//messages(report)//']')//SEP// &
           json_member('equilibrium', trim(merge('true ', 'false', report%equilibrium)))
    if (allocated(report%contact)) then
      text = text//SEP//json_member('contacts', contacts(report%contact))
    end if
    text = text//new_line('a')//'}'//new_line('a')
    call write_whole(path, text, error)
  end subroutine write_report

  function messages(report) result(text)
    type(report_t), intent(in) :: report
    character(:), allocatable :: text
    integer :: i

    text = ''
    if (.not. allocated(report%warning)) return
    do i = 1, size(report%warning)
      if (i > 1) text = text//', '
      text = text//json_string(report%warning(i)%text)
    end do
  end function messages

  !> Count elements of a type. Counts with the same name are added up.
  subroutine add_count(list, name, n)
    type(named_count_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: name
    integer, intent(in) :: n
    type(named_count_t) :: row
    integer :: i

    if (.not. allocated(list)) allocate (list(0))
    do i = 1, size(list)
      if (list(i)%name == name) then
        list(i)%n = list(i)%n + n
        return
      end if
    end do
    row%name = name
    row%n = n
    list = [list, row]
  end subroutine add_count

  subroutine add_real(list, name, value)
    type(named_real_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: name
    real(wp), intent(in) :: value
    type(named_real_t) :: row

    if (.not. allocated(list)) allocate (list(0))
    row%name = name
    row%value = value
    list = [list, row]
  end subroutine add_real

  !> Add the last row of a curve with the names of its columns.
  subroutine add_curve(list, name, columns, values)
    type(curve_row_t), allocatable, intent(inout) :: list(:)
    character(*), intent(in) :: name
    character(*), intent(in) :: columns(:)
    real(wp), intent(in) :: values(:)
    type(curve_row_t) :: row
    integer :: i

    if (.not. allocated(list)) allocate (list(0))
    row%name = name
    do i = 1, size(columns)
      call add_real(row%column, trim(columns(i)), values(i))
    end do
    list = [list, row]
  end subroutine add_curve

  function contacts(contact) result(json)
    type(contact_row_t), intent(in) :: contact(:)
    character(:), allocatable :: json, row
    integer :: i

    json = ''
    do i = 1, size(contact)
      if (i > 1) json = json//', '
      row = json_member('points', json_number(contact(i)%points))//', '// &
            json_member('in_contact', json_number(contact(i)%closed))//', '// &
            json_member('balance', json_number(contact(i)%balance))//', '// &
            json_member('largest_penetration', json_number(contact(i)%largest_penetration))
      json = json//json_member(contact(i)%name, json_object(row))
    end do
    json = json_object(json)
  end function contacts

  !> Numbers with their names as members; empty if the list is not allocated.
  pure function reals(list) result(json)
    type(named_real_t), allocatable, intent(in) :: list(:)
    character(:), allocatable :: json
    integer :: i

    json = ''
    if (allocated(list)) then
      do i = 1, size(list)
        if (i > 1) json = json//', '
        json = json//json_member(list(i)%name, json_number(list(i)%value))
      end do
    end if
    json = json_object(json)
  end function reals

  !> The text; empty if it is not allocated.
  pure function given(text)
    character(:), allocatable, intent(in) :: text
    character(:), allocatable :: given

    given = ''
    if (allocated(text)) given = text
  end function given

end module report_file
