!> The one list of contact laws: a new law is a new file and a line here.
module contact_table
  use contact_type, only: contact_law_t
  implicit none
  private
  public :: load_contact_laws

contains

  !> Rows of all laws.
  subroutine load_contact_laws(table)
    type(contact_law_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use contact_normal, only: describe; table = [table, describe()]; end block
    block; use contact_fric, only: describe; table = [table, describe()]; end block
    block; use contact_cz, only: describe; table = [table, describe()]; end block
    block; use contact_cz_irr, only: describe; table = [table, describe()]; end block
    block; use contact_cz_mixed, only: describe; table = [table, describe()]; end block
    block; use contact_ppr, only: describe; table = [table, describe()]; end block
  end subroutine load_contact_laws

end module contact_table
