!> Chooses the batch kernel for this processor. The Makefile compiles solid_batch three times: under
!! its own name for any processor, as solid_batch_v3 for AVX2, and as solid_batch_v4 for AVX-512.
module solid_simd
  use base_cpu, only: vector_level
  use element_type, only: element_batch_i
  use solid_batch, only: form_batch
  use solid_batch_v3, only: form_batch_v3 => form_batch
  use solid_batch_v4, only: form_batch_v4 => form_batch
  implicit none
  private
  public :: choose_batch

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

end module solid_simd
