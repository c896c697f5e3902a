!> Arrays that grow while they are filled; old entries are kept, and new ones are zero or false.
!!
!! The size at least doubles each time, so that, on average, an entry is copied about once while n
!! entries are added one by one. The caller keeps the number of entries in use. Arrays that grow at
!! the same time for the same numbers of entries have equal sizes.
module base_grow
  use base_error, only: place_t
  use base_kinds, only: wp
  implicit none
  private
  public :: grow

  !> `grow(a, n)` makes room for n entries, `grow(a, rows, n)` for n columns of at least `rows`
  !! rows.
  interface grow
    module procedure grow_integer, grow_real, grow_logical, grow_place, grow_integers, grow_reals
  end interface grow

  integer, parameter :: SMALLEST = 16

contains

  !> New size of an array of size `old` that must hold n entries.
  pure integer function next_size(old, n) result(new)
    integer, intent(in) :: old, n

    new = max(n, SMALLEST, old + min(old, huge(old) - old))
    if (n <= old) new = old
  end function next_size

  subroutine grow_integer(a, n)
    integer, allocatable, intent(inout) :: a(:)
    integer, intent(in) :: n
    integer, allocatable :: b(:)

    if (.not. allocated(a)) allocate (a(0))
    if (n <= size(a)) return
    allocate (b(next_size(size(a), n)), source=0)
    b(:size(a)) = a
    call move_alloc(b, a)
  end subroutine grow_integer

  subroutine grow_real(a, n)
    real(wp), allocatable, intent(inout) :: a(:)
    integer, intent(in) :: n
    real(wp), allocatable :: b(:)

    if (.not. allocated(a)) allocate (a(0))
    if (n <= size(a)) return
    allocate (b(next_size(size(a), n)), source=0.0_wp)
    b(:size(a)) = a
    call move_alloc(b, a)
  end subroutine grow_real

  subroutine grow_logical(a, n)
    logical, allocatable, intent(inout) :: a(:)
    integer, intent(in) :: n
    logical, allocatable :: b(:)

    if (.not. allocated(a)) allocate (a(0))
    if (n <= size(a)) return
    allocate (b(next_size(size(a), n)), source=.false.)
    b(:size(a)) = a
    call move_alloc(b, a)
  end subroutine grow_logical

  !> Make room for n places; their texts are moved, not copied.
  subroutine grow_place(a, n)
    type(place_t), allocatable, intent(inout) :: a(:)
    integer, intent(in) :: n
    type(place_t), allocatable :: b(:)
    integer :: i

    if (.not. allocated(a)) allocate (a(0))
    if (n <= size(a)) return
    allocate (b(next_size(size(a), n)))
    do i = 1, size(a)
      if (allocated(a(i)%file)) call move_alloc(a(i)%file, b(i)%file)
      if (allocated(a(i)%text)) call move_alloc(a(i)%text, b(i)%text)
      b(i)%line = a(i)%line
      b(i)%column = a(i)%column
      b(i)%width = a(i)%width
    end do
    call move_alloc(b, a)
  end subroutine grow_place

  subroutine grow_integers(a, rows, n)
    integer, allocatable, intent(inout) :: a(:, :)
    integer, intent(in) :: rows, n
    integer, allocatable :: b(:, :)

    if (.not. allocated(a)) allocate (a(rows, 0))
    if (rows <= size(a, 1) .and. n <= size(a, 2)) return
    allocate (b(max(rows, size(a, 1)), next_size(size(a, 2), n)), source=0)
    b(:size(a, 1), :size(a, 2)) = a
    call move_alloc(b, a)
  end subroutine grow_integers

  subroutine grow_reals(a, rows, n)
    real(wp), allocatable, intent(inout) :: a(:, :)
    integer, intent(in) :: rows, n
    real(wp), allocatable :: b(:, :)

    if (.not. allocated(a)) allocate (a(rows, 0))
    if (rows <= size(a, 1) .and. n <= size(a, 2)) return
    allocate (b(max(rows, size(a, 1)), next_size(size(a, 2), n)), source=0.0_wp)
    b(:size(a, 1), :size(a, 2)) = a
    call move_alloc(b, a)
  end subroutine grow_reals

end module base_grow
