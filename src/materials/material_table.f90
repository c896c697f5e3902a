!> The one list of constitutive laws: a new law is a new file and a line here.
module material_table
  use material_simd, only: widen
  use material_type, only: material_t
  implicit none
  private
  public :: load_materials

contains

  !> Rows of all laws.
  subroutine load_materials(table)
    type(material_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use mate_linear, only: describe; table = [table, describe()]; end block
    block; use mate_neohooke, only: describe; table = [table, describe()]; end block
    call widen(table)
  end subroutine load_materials

end module material_table
