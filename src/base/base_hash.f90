!> Hashes of texts, numbers and files, written as 16 hexadecimal digits.
module base_hash
  use base_error, only: error_t, fail, SYSTEM_ERROR
  use base_kinds, only: wp, i8
  implicit none
  private
  public :: hash_t, text_hash, file_hash

  !> Hash of all data added so far; it depends on the order in which they were added.
  type :: hash_t
    private
    integer(i8) :: h(2) = [7_i8, 11_i8]
  contains
    procedure, private :: add_text, add_integers, add_reals
    generic :: add => add_text, add_integers, add_reals
    procedure :: digits => digits_of
  end type hash_t

contains

  pure subroutine add_word(h, word)
    integer(i8), intent(inout) :: h(2)
    integer(i8), intent(in) :: word !! 0 <= word < 2**32

    h(1) = modulo(h(1)*131_i8 + word + 1, 2147483647_i8)
    h(2) = modulo(h(2)*257_i8 + word + 1, 2147483629_i8)
  end subroutine add_word

  pure subroutine add_text(hash, text)
    class(hash_t), intent(inout) :: hash
    character(*), intent(in) :: text
    integer :: i

    do i = 1, len(text)
      call add_word(hash%h, int(iachar(text(i:i)), i8))
    end do
  end subroutine add_text

  pure subroutine add_integers(hash, values)
    class(hash_t), intent(inout) :: hash
    integer, intent(in) :: values(:)
    integer :: i

    call add_word(hash%h, size(values, kind=i8))
    do i = 1, size(values)
      call add_word(hash%h, iand(int(values(i), i8), 4294967295_i8))
    end do
  end subroutine add_integers

  !> Add all bits of real numbers.
  pure subroutine add_reals(hash, values)
    class(hash_t), intent(inout) :: hash
    real(wp), intent(in) :: values(:)
    integer :: i

    call add_word(hash%h, size(values, kind=i8))
    do i = 1, size(values)
      call add_bits(hash%h, transfer(values(i), 0_i8))
    end do
  end subroutine add_reals

  pure subroutine add_bits(h, bits)
    integer(i8), intent(inout) :: h(2)
    integer(i8), intent(in) :: bits

    call add_word(h, iand(bits, 4294967295_i8))
    call add_word(h, ishft(bits, -32))
  end subroutine add_bits

  pure function digits_of(hash) result(text)
    class(hash_t), intent(in) :: hash
    character(16) :: text

    write (text, '(2z8.8)') hash%h
  end function digits_of

  pure function text_hash(text) result(digits)
    character(*), intent(in) :: text
    character(16) :: digits
    type(hash_t) :: hash

    call hash%add(text)
    digits = hash%digits()
  end function text_hash

  !> Hash of the first `length` bytes of a file.
  subroutine file_hash(path, length, digits, error)
    character(*), intent(in) :: path
    integer(i8), intent(in) :: length
    character(16), intent(out) :: digits
    type(error_t), allocatable, intent(out) :: error
    integer, parameter :: AT_ONCE = 131072 !! words
    integer(i8), allocatable :: words(:)
    character, allocatable :: rest(:)
    type(hash_t) :: hash
    integer(i8) :: left
    integer :: i, n, unit, status

    digits = ''
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
          action='read', iostat=status)
    if (status == 0) then
      allocate (words(AT_ONCE))
      left = length
      do while (left >= 8 .and. status == 0)
        n = int(min(left/8, int(AT_ONCE, i8)))
        read (unit, iostat=status) words(:n)
        do i = 1, n
          call add_bits(hash%h, words(i))
        end do
        left = left - 8_i8*n
      end do
      allocate (rest(left))
      if (status == 0 .and. left > 0) read (unit, iostat=status) rest
      do i = 1, int(left)
        call hash%add(rest(i))
      end do
      close (unit)
    end if
    digits = hash%digits()
    if (status /= 0) call fail(error, SYSTEM_ERROR, 'cannot read '''//path//'''')
  end subroutine file_hash

end module base_hash
