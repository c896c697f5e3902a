!> Laws for NB points at a time, for the vector registers of this processor: the Makefile compiles
!! mate_neohooke three times, see solid_simd.
module material_simd
  use base_cpu, only: vector_level
  use material_type, only: material_t
  use mate_neohooke_v3, only: describe_v3 => describe
  use mate_neohooke_v4, only: describe_v4 => describe
  implicit none
  private
  public :: widen

contains

  !> Take the widest `moduli_batch` that runs here, where there are several.
  subroutine widen(table)
    type(material_t), intent(inout) :: table(:)

    select case (vector_level())
    case (4)
      call replace(table, describe_v4())
    case (3)
      call replace(table, describe_v3())
    case default ! what the table has runs anywhere
    end select
  end subroutine widen

  subroutine replace(table, wide)
    type(material_t), intent(inout) :: table(:)
    type(material_t), intent(in) :: wide

    integer :: i

    do i = 1, size(table)
      if (table(i)%name == wide%name) table(i)%moduli_batch => wide%moduli_batch
    end do
  end subroutine replace

end module material_simd
