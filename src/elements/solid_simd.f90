!> Chooses the kernels for this processor. The Makefile compiles solid_batch and solid_form three
!! times: under their own names for any processor, as solid_batch_v3 and solid_form_v3 for AVX2, and
!! as solid_batch_v4 and solid_form_v4 for AVX-512.
module solid_simd
  use base_cpu, only: vector_level
  use element_type, only: element_t, element_form_i, element_batch_i
  use solid_batch, only: form_batch
  use solid_batch_v3, only: form_batch_v3 => form_batch
  use solid_batch_v4, only: form_batch_v4 => form_batch
  use solid_form, only: form
  use solid_form_v3, only: form_v3 => form
  use solid_form_v4, only: form_v4 => form
  implicit none
  private
  public :: choose_batch, choose_forms

contains

  !> Choose the kernel for the widest vector registers of this processor.
  subroutine choose_batch(batch)
    procedure(element_batch_i), pointer, intent(out) :: batch

    select case (vector_level())
    case (4)
      batch => form_batch_v4
    case (3)
      batch => form_batch_v3
    case default
      batch => form_batch
    end select
  end subroutine choose_batch

  !> Replace the `form` of solid_form by its copy for the widest vector registers of this processor.
  subroutine choose_forms(table)
    type(element_t), intent(inout) :: table(:)

    procedure(element_form_i), pointer :: widest
    integer :: i

    select case (vector_level())
    case (4)
      widest => form_v4
    case (3)
      widest => form_v3
    case default
      widest => form
    end select
    do i = 1, size(table)
      if (associated(table(i)%form, form)) table(i)%form => widest
    end do
  end subroutine choose_forms

end module solid_simd
