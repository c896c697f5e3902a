!> BOOK in a CURVe: a column of the book of energies.
module setup_curve_book
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: key_of, lower, nearest, quoted
  use curve_type, only: quantity_t, Q_BOOK
  use deck_record, only: record_t, check_count
  implicit none
  private
  public :: read_book

  !> In the order of curve_type's B_WORK ...
  character(10), parameter :: WORD(11) = ['WORK      ', 'STORed    ', 'KINEtic   ', 'NORMal    ', &
                                          'FRICtion  ', 'COHEsive  ', 'INERtia   ', 'IMBAlance ', &
                                          'BONDs     ', 'DAMAge    ', 'VISCous   ']

contains

  !> BOOK quantity.
  subroutine read_book(line, quantity, error)
    type(record_t), intent(in) :: line
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = &
                               'BOOK WORK|STORed|KINEtic|NORMal|FRICtion|COHEsive|INERtia|' &
                               //'IMBAlance|BONDs|DAMAge|VISCous'
    integer :: i

    call check_count(line, 2, 2, USAGE, error)
    if (allocated(error)) return
    do i = 1, size(WORD)
      if (key_of(WORD(i)) == line%key(2)) exit
    end do
    if (i > size(WORD)) then
      call fail(error, DECK_ERROR, 'unknown energy '//quoted(line%text(2)), line%place(2), &
                'nearest known: '//nearest(line%text(2), WORD)//'; '//USAGE)
      return
    end if
    quantity%kind = Q_BOOK
    quantity%component = i
    quantity%column = 'book_'//trim(lower(WORD(i)))
  end subroutine read_book

end module setup_curve_book
