!> Rows of the table of elements by name.
module patch_rows
  use base_error, only: error_t, fail, DECK_ERROR
  use element_type, only: element_t
  use element_table, only: load_elements
  use patch_spec, only: patch_spec_t
  implicit none
  private
  public :: find_row

contains

  !> The row of an element type that a patch uses.
  subroutine find_row(spec, name, row, error)
    type(patch_spec_t), intent(in) :: spec
    character(*), intent(in) :: name
    type(element_t), intent(out) :: row
    type(error_t), allocatable, intent(out) :: error
    type(element_t), allocatable :: table(:)
    integer :: i

    call load_elements(table)
    do i = 1, size(table)
      if (table(i)%name /= name) cycle
      row = table(i)
      return
    end do
    call fail(error, DECK_ERROR, "patch '"//spec%name//"' needs elements of type '"//trim(name) &
              //"', which this program does not have", spec%place)
  end subroutine find_row

end module patch_rows
