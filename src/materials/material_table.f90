!> The only list of constitutive laws: a new law needs a new file and a line here.
module material_table
  use base_cpu, only: vector_level
  use material_type, only: material_t
  implicit none
  private
  public :: load_materials, find_material

contains

  !> Rows of all laws.
  subroutine load_materials(table)
    type(material_t), allocatable, intent(out) :: table(:)

    allocate (table(0))
    block; use mate_linear, only: describe; table = [table, describe()]; end block
    block; use mate_neohooke, only: describe; table = [table, describe()]; end block
    ! The batch procedure of the neo-Hookean law is compiled three times: for any processor, for
    ! AVX2, and for AVX-512.
    select case (vector_level())
    case (4)
      block; use mate_neohooke_v4, only: describe; call take_batch(table, describe()); end block
    case (3)
      block; use mate_neohooke_v3, only: describe; call take_batch(table, describe()); end block
    case default
      continue ! the table already has the procedure for any processor
    end select
  end subroutine load_materials

  subroutine take_batch(table, wide)
    type(material_t), intent(inout) :: table(:)
    type(material_t), intent(in) :: wide

    integer :: i

    do i = 1, size(table)
      if (table(i)%name == wide%name) table(i)%moduli_batch => wide%moduli_batch
    end do
  end subroutine take_batch

  !> The row that has a given name, or a row with an empty name if there is none.
  function find_material(name) result(law)
    character(*), intent(in) :: name
    type(material_t) :: law

    type(material_t), allocatable :: table(:)
    integer :: i

    call load_materials(table)
    do i = 1, size(table)
      if (table(i)%name == name) law = table(i)
    end do
  end function find_material

end module material_table
