!> Words and numbers as text.
module base_text
  use base_kinds, only: wp, i8
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  implicit none
  private
  public :: lower, to_text, position_text, nearest, quoted, key_of, fits_name

  integer, parameter :: LONGEST = 64 !! most characters of a text that a message quotes

  !> A number as short text: an integer in full, a real with `digits` significant digits (default
  !! 6).
  interface to_text
    module procedure integer_text, long_text, real_text
  end interface to_text

  !> `nearest` is a generic name, because Fortran has an intrinsic function with this name.
  interface nearest
    module procedure nearest_word
  end interface nearest

contains

  !> The text in lower case (ASCII letters only).
  pure function lower(text) result(small)
    character(*), intent(in) :: text
    character(len(text)) :: small
    integer :: i, c

    do i = 1, len(text)
      c = iachar(text(i:i))
      if (c >= 65 .and. c <= 90) c = c + 32
      small(i:i) = achar(c)
    end do
  end function lower

  !> The significant part of a deck word: its first four letters, lower case.
  pure function key_of(word) result(key)
    character(*), intent(in) :: word
    character(4) :: key

    key = word
    key = lower(key)
  end function key_of

  !> Can the text be part of the name of a file or a column? It must consist of letters, digits,
  !! `_` and `-`.
  pure logical function fits_name(text, longest)
    character(*), intent(in) :: text
    integer, intent(in) :: longest !! characters

    fits_name = len(text) > 0 .and. len(text) <= longest &
                .and. verify(lower(text), 'abcdefghijklmnopqrstuvwxyz0123456789_-') == 0
  end function fits_name

  !> A text that the user has written, quoted for a message; a long text is truncated.
  pure function quoted(text) result(with_quotes)
    character(*), intent(in) :: text
    character(:), allocatable :: with_quotes

    if (len(text) > LONGEST) then
      with_quotes = "'"//text(:LONGEST - 3)//"...'"
    else
      with_quotes = "'"//text//"'"
    end if
  end function quoted

  pure function integer_text(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text

    text = long_text(int(n, i8))
  end function integer_text

  pure function long_text(n) result(text)
    integer(i8), intent(in) :: n
    character(:), allocatable :: text
    character(24) :: buffer

    write (buffer, '(i0)') n
    text = trim(buffer)
  end function long_text

  !> A real number as C's %g writes it: without trailing zeros, and without an exponent unless the
  !! number is very large or very small.
  pure function real_text(x, digits) result(text)
    real(wp), intent(in) :: x
    integer, intent(in), optional :: digits !! significant digits; default 6
    character(:), allocatable :: text
    character(48) :: buffer
    character(16) :: form
    integer :: n, power, at

    text = ''
    if (ieee_is_nan(x)) then ! x /= x would trap in the debug build
      text = 'NaN'
    else if (.not. ieee_is_finite(x)) then
      text = trim(merge('infinity ', '-infinity', x > 0.0_wp))
    else if (.not. abs(x) > 0.0_wp) then
      text = '0'
    end if
    if (text /= '') return
    n = 6
    if (present(digits)) n = max(1, min(digits, 17))
    write (form, '("(es40.", i0, "e3)")') n - 1
    write (buffer, form) x
    buffer = adjustl(buffer)
    at = index(buffer, 'E')
    read (buffer(at + 1:), *) power
    if (power >= -4 .and. power < max(n, 6)) then
      write (form, '("(f40.", i0, ")")') max(n - 1 - power, 0)
      write (buffer, form) x
      text = without_zeros(trim(adjustl(buffer)))
    else
      write (form, '(sp, i0.2)') power
      text = without_zeros(buffer(:at - 1))//'e'//trim(form)
    end if
  end function real_text

  !> A position as text: (1, 2.5, 0).
  pure function position_text(x) result(text)
    real(wp), intent(in) :: x(3)
    character(:), allocatable :: text

    text = '('//to_text(x(1), 4)//', '//to_text(x(2), 4)//', '//to_text(x(3), 4)//')'
  end function position_text

  !> A number without trailing zeros: 1.500 becomes 1.5, and 2.000 becomes 2.
  pure function without_zeros(number) result(text)
    character(*), intent(in) :: number
    character(:), allocatable :: text
    integer :: n

    n = len(number)
    if (index(number, '.') > 0) then
      n = verify(number, '0', back=.true.)
      if (number(n:n) == '.') n = n - 1
    end if
    text = number(:n)
  end function without_zeros

  !> The word in a list that is most similar to `word`, or the first of several such words. Case
  !! does not matter, and a word may be shortened to its first four letters.
  pure function nearest_word(word, list) result(found)
    character(*), intent(in) :: word
    character(*), intent(in) :: list(:)
    character(:), allocatable :: found
    integer :: i, n, best, here

    found = ''
    best = huge(best)
    n = min(len_trim(word), LONGEST)
    do i = 1, size(list)
      if (len_trim(list(i)) == 0) cycle
      here = 8*min(distance(lower(word(:n)), lower(trim(list(i)))), &
                   distance(lower(word(:min(n, 4))), lower(list(i) (:min(len_trim(list(i)), 4))))) &
             + min(7, distance(lower(word(:n)), lower(trim(list(i)))))
      if (here >= best) cycle
      best = here
      found = trim(list(i))
    end do
  end function nearest_word

  !> Smallest number of edits that turn a into b. An edit inserts, drops or changes a letter, or
  !! swaps two neighbouring letters.
  pure function distance(a, b) result(d)
    character(*), intent(in) :: a, b
    integer :: d, i, j
    integer :: row(0:len(b), 0:2) !! the row before the last, the last row, and the new row

    row(:, 0) = 0
    row(:, 1) = [(j, j=0, len(b))]
    do i = 1, len(a)
      row(0, 2) = i
      do j = 1, len(b)
        row(j, 2) = min(row(j, 1) + 1, row(j - 1, 2) + 1, row(j - 1, 1) + merge(0, 1, &
                                                                                a(i:i) == b(j:j)))
      end do
      do j = 2, merge(len(b), 0, i > 1)
        if (a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)) then
          row(j, 2) = min(row(j, 2), row(j - 2, 0) + 1)
        end if
      end do
      row(:, 0) = row(:, 1)
      row(:, 1) = row(:, 2)
    end do
    d = row(len(b), 1)
  end function distance

end module base_text
