!> The table of contact laws: a new law needs a new file and a line here.
!!
!! See also contact_type (definition of a row), contact_normal (PENAlty), contact_fric (COULomb),
!! contact_secant (the part that cohesive laws share) with contact_cz (EXPOnential),
!! contact_cz_mixed (MIXEd) and contact_ppr (PPR); contact_point and contact_bond call the laws.
module contact_table
  use contact_type, only: contact_law_t
  implicit none
  private
  public :: load_contact_laws, find_contact_law

contains

  !> Load the rows of all laws.
  subroutine load_contact_laws(table)
    type(contact_law_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use contact_normal, only: describe; table = [table, describe()]; end block
    block; use contact_fric, only: describe; table = [table, describe()]; end block
    block; use contact_cz, only: describe; table = [table, describe()]; end block
    block; use contact_cz, only: irreversible; table = [table, irreversible()]; end block
    block; use contact_cz_mixed, only: describe; table = [table, describe()]; end block
    block; use contact_ppr, only: describe; table = [table, describe()]; end block
  end subroutine load_contact_laws

  !> The row with this name and option; a row without a name if there is none.
  function find_contact_law(name, option) result(row)
    character(*), intent(in) :: name             !! in full, such as PENAlty
    character(*), intent(in), optional :: option !! in full, such as IRREversible
    type(contact_law_t) :: row
    type(contact_law_t), allocatable :: table(:)
    character(len(row%option)) :: wanted
    integer :: i

    wanted = ''
    if (present(option)) wanted = option
    call load_contact_laws(table)
    do i = 1, size(table)
      if (table(i)%name == name .and. table(i)%option == wanted) row = table(i)
    end do
  end function find_contact_law

end module contact_table
