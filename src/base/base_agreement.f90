!> Agreement of all ranks on errors, so that no rank waits for one that has already stopped.
module base_agreement
  use base_comm, only: largest, rank_count, share, this_rank
  use base_error, only: error_t, fail, SYSTEM_ERROR
  implicit none
  private
  public :: agree

contains

  !> Copy the error of the first rank that has one to all ranks that have none.
  !!
  !! Call this after any work that only the first rank does, such as writing a file, and also after
  !! work that every rank repeats, such as reading the deck, which may fail on one rank only.
  subroutine agree(error)
    type(error_t), allocatable, intent(inout) :: error
    character(:), allocatable :: hint, message
    integer :: code(1), rank

    if (rank_count() == 1) return
    rank = rank_count() + 1 - largest(merge(rank_count() + 1 - this_rank(), 0, allocated(error)))
    if (rank > rank_count()) return
    code = SYSTEM_ERROR
    message = ''
    hint = ''
    if (this_rank() == rank) then
      code = error%code
      message = error%message
      if (allocated(error%hint)) hint = error%hint
    end if
    call share(code, rank)
    call share(message, rank)
    call share(hint, rank)
    if (allocated(error)) return
    call fail(error, code(1), message)
    if (len(hint) > 0) error%hint = hint
  end subroutine agree

end module base_agreement
