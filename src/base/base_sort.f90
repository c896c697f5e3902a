!> Sorting and searching.
module base_sort
  use base_kinds, only: wp, i8
  implicit none
  private
  public :: sort, sort_index, unique, find, hash

  !> Permutation that sorts the keys in ascending order; equal keys keep their order.
  interface sort_index
    module procedure sort_index_integer, sort_index_long, sort_index_real
  end interface sort_index

  !> Sort a list in place, in ascending order.
  interface sort
    module procedure sort_integer, sort_real
  end interface sort

contains

  pure subroutine sort_index_integer(key, order)
    integer, intent(in) :: key(:)
    integer, intent(out) :: order(:) !! (size(key)) key(order) is in ascending order

    call sort_index_long(int(key, i8), order)
  end subroutine sort_index_integer

  !> Merge sort, bottom up.
  pure subroutine sort_index_long(key, order)
    integer(i8), intent(in) :: key(:)
    integer, intent(out) :: order(:)
    integer, allocatable :: other(:)
    integer :: n, width, left, middle, right, a, b, i
    logical :: take_left

    n = size(key)
    order = [(i, i=1, n)]
    if (n < 2) return
    allocate (other(n))
    width = 1
    do while (width < n)
      do left = 1, n, 2*width
        middle = min(left + width, n + 1)
        right = min(middle + width, n + 1)
        a = left
        b = middle
        do i = left, right - 1
          take_left = a < middle
          if (take_left .and. b < right) take_left = key(order(a)) <= key(order(b))
          if (take_left) then
            other(i) = order(a)
            a = a + 1
          else
            other(i) = order(b)
            b = b + 1
          end if
        end do
      end do
      order = other
      width = 2*width
    end do
  end subroutine sort_index_long

  !> Sort reals like the integers that have the same bits. For negative reals, all bits except the
  !! sign are inverted first.
  pure subroutine sort_index_real(key, order)
    real(wp), intent(in) :: key(:)
    integer, intent(out) :: order(:)
    integer(i8), allocatable :: bits(:)

    allocate (bits(size(key)))
    bits = transfer(key + 0.0_wp, bits, size(key))
    where (bits < 0) bits = ieor(bits, huge(0_i8))
    call sort_index_long(bits, order)
  end subroutine sort_index_real

  pure subroutine sort_integer(list)
    integer, intent(inout) :: list(:)
    integer, allocatable :: order(:)

    allocate (order(size(list)))
    call sort_index(list, order)
    list = list(order)
  end subroutine sort_integer

  pure subroutine sort_real(list)
    real(wp), intent(inout) :: list(:)
    integer, allocatable :: order(:)

    allocate (order(size(list)))
    call sort_index(list, order)
    list = list(order)
  end subroutine sort_real

  !> The distinct values of a list, in ascending order.
  pure function unique(list) result(values)
    integer, intent(in) :: list(:)
    integer, allocatable :: values(:)
    integer :: i, n

    values = list
    call sort(values)
    n = min(1, size(values))
    do i = 2, size(values)
      if (values(i) == values(n)) cycle
      n = n + 1
      values(n) = values(i)
    end do
    values = values(:n)
  end function unique

  !> Position of a value in an ascending list, or 0 if the list does not contain it.
  pure function find(list, value) result(at)
    integer, intent(in) :: list(:), value
    integer :: at, low, high

    low = 1
    high = size(list)
    do while (low <= high)
      at = low + (high - low)/2
      if (list(at) == value) return
      if (list(at) < value) low = at + 1
      if (list(at) > value) high = at - 1
    end do
    at = 0
  end function find

  !> A key by which lists can be sorted. Equal lists have equal keys, and different lists usually
  !! have different keys.
  pure integer(i8) function hash(list)
    integer, intent(in) :: list(:)
    integer(i8), parameter :: FACTOR = 1000003_i8, MODULUS = 2147483647_i8
    integer :: i

    hash = size(list)
    do i = 1, size(list)
      hash = mod(hash*FACTOR + list(i), MODULUS)
    end do
  end function hash

end module base_sort
