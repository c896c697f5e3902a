!> The only list of elements: a new element needs a new file and a line here.
module element_table
  use element_type, only: element_t
  use solid_simd, only: choose_forms
  implicit none
  private
  public :: load_elements, find_element

contains

  !> Rows of all elements.
  subroutine load_elements(table)
    type(element_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use elmt_q1, only: describe; table = [table, describe()]; end block
    block; use elmt_q1e9, only: describe; table = [table, describe()]; end block
    block; use elmt_q2, only: describe; table = [table, describe()]; end block
    block; use elmt_iga, only: describe; table = [table, describe()]; end block
    block; use elmt_q1n2, only: describe; table = [table, describe()]; end block
    block; use elmt_q1e9n2, only: describe; table = [table, describe()]; end block
    block; use elmt_q1e9n2, only: describe_tapered; table = [table, describe_tapered()]; end block
    block; use elmt_q2n2, only: describe; table = [table, describe()]; end block
    block; use elmt_tet4, only: describe; table = [table, describe()]; end block
    block; use elmt_pyramid5, only: describe; table = [table, describe()]; end block
    block; use elmt_wedge6, only: describe; table = [table, describe()]; end block
    block; use elmt_tet10, only: describe; table = [table, describe()]; end block
    call choose_forms(table)
  end subroutine load_elements

  !> The row that has a given name, or a row with an empty name if there is none.
  function find_element(name) result(row)
    character(*), intent(in) :: name
    type(element_t) :: row

    type(element_t), allocatable :: table(:)
    integer :: i

    call load_elements(table)
    do i = 1, size(table)
      if (table(i)%name == name) row = table(i)
    end do
  end function find_element

end module element_table
