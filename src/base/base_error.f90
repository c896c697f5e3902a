!> Failures as values: what went wrong, where in the deck, and what to do about it.
module base_error
  implicit none
  private
  public :: place_t, error_t, fail

  integer, parameter, public :: DECK_ERROR = 1    !! the deck is wrong; nothing is written
  integer, parameter, public :: NO_SOLUTION = 2   !! the solution failed
  integer, parameter, public :: SYSTEM_ERROR = 3  !! library, memory or disk
  integer, parameter, public :: STOPPED = 4       !! stopped with a checkpoint
  integer, parameter, public :: BUG = 70          !! our fault

  !> A spot in a deck.
  type :: place_t
    character(:), allocatable :: file !! path as the user wrote it; not allocated: no place
    character(:), allocatable :: text !! the line as it stands in the file
    integer :: line = 0   !! line number, from 1
    integer :: column = 0 !! first character, from 1; 0: the whole line
    integer :: width = 0  !! characters to underline
  end type place_t

  !> A failure.
  type :: error_t
    integer :: code = 0                   !! exit code of the program
    character(:), allocatable :: message  !! one sentence, lower case, no full stop
    character(:), allocatable :: hint     !! what to do; not allocated: no hint
    type(place_t) :: place
  end type error_t

contains

  !> Make an error.
  subroutine fail(error, code, message, place, hint)
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in) :: code
    character(*), intent(in) :: message
    type(place_t), intent(in), optional :: place
    character(*), intent(in), optional :: hint

    allocate (error)
    error%code = code
    error%message = message
    if (present(hint)) error%hint = hint
    if (present(place)) error%place = place
  end subroutine fail

end module base_error
