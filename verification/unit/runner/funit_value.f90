!> A value of any type and rank (up to 3) as one list: what the assertions compare and print.
module funit_value
  use, intrinsic :: iso_fortran_env, only: dp => real64, sp => real32, i8 => int64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  implicit none
  private
  public :: flat_t, prepare, take_0, take_1, take_2, take_3, length, entry, difference, place, shape_text, text_of, brief

  integer, parameter, public :: OTHER = 0, WHOLE = 1, REALS = 2, TRUTH = 3, WORDS = 4

  type :: text_t
    character(:), allocatable :: s
  end type text_t

  !> A value of any type and rank as one list of its type.
  type :: flat_t
    integer :: kind = OTHER
    integer, allocatable :: extent(:)       !! shape; size 0: a scalar
    integer(i8), allocatable :: n(:)        !! WHOLE
    real(dp), allocatable :: x(:)           !! REALS; whole numbers too
    logical, allocatable :: l(:)            !! TRUTH
    type(text_t), allocatable :: t(:)       !! WORDS
  end type flat_t

contains

  !> An empty list of values of that shape.
  subroutine prepare(f, extent)
    type(flat_t), intent(out) :: f
    integer, intent(in) :: extent(:)

    f%extent = extent
    allocate (f%n(0), f%x(0), f%l(0), f%t(0))
  end subroutine prepare

  subroutine take_3(value, f)
    class(*), intent(in) :: value(:, :, :)
    type(flat_t), intent(inout) :: f

    select type (value)
    type is (real(dp)); call take_1(pack(value, .true.), f)
    type is (real(sp)); call take_1(pack(value, .true.), f)
    type is (integer); call take_1(pack(value, .true.), f)
    type is (integer(i8)); call take_1(pack(value, .true.), f)
    type is (logical); call take_1(pack(value, .true.), f)
    type is (character(*)); call take_1(pack(value, .true.), f)
    end select
  end subroutine take_3

  subroutine take_2(value, f)
    class(*), intent(in) :: value(:, :)
    type(flat_t), intent(inout) :: f

    select type (value)
    type is (real(dp)); call take_1(pack(value, .true.), f)
    type is (real(sp)); call take_1(pack(value, .true.), f)
    type is (integer); call take_1(pack(value, .true.), f)
    type is (integer(i8)); call take_1(pack(value, .true.), f)
    type is (logical); call take_1(pack(value, .true.), f)
    type is (character(*)); call take_1(pack(value, .true.), f)
    end select
  end subroutine take_2

  !> Append a list.
  subroutine take_1(value, f)
    class(*), intent(in) :: value(:)
    type(flat_t), intent(inout) :: f
    type(text_t), allocatable :: grown(:)
    integer :: i

    select type (value)
    type is (real(dp)); f%kind = REALS; f%x = [f%x, value]
    type is (real(sp)); f%kind = REALS; f%x = [f%x, real(value, dp)]
    type is (integer); f%kind = WHOLE; f%n = [f%n, int(value, i8)]; f%x = real(f%n, dp)
    type is (integer(i8)); f%kind = WHOLE; f%n = [f%n, value]; f%x = real(f%n, dp)
    type is (logical); f%kind = TRUTH; f%l = [f%l, value]
    type is (character(*))
      f%kind = WORDS
      allocate (grown(size(f%t) + size(value)))
      do i = 1, size(grown)
        if (i <= size(f%t)) then
          grown(i)%s = f%t(i)%s
        else
          grown(i)%s = value(i - size(f%t))
        end if
      end do
      call move_alloc(grown, f%t)
    end select
  end subroutine take_1

  subroutine take_0(value, f)
    class(*), intent(in) :: value
    type(flat_t), intent(inout) :: f

    select type (value)
    type is (real(dp)); call take_1([value], f)
    type is (real(sp)); call take_1([value], f)
    type is (integer); call take_1([value], f)
    type is (integer(i8)); call take_1([value], f)
    type is (logical); call take_1([value], f)
    type is (character(*)); call take_1([value], f)
    end select
  end subroutine take_0

  integer function length(f)
    type(flat_t), intent(in) :: f

    length = max(size(f%x), size(f%l), size(f%t))
  end function length

  ! --- text ------------------------------------------------------------------------------------

  function entry(f, i) result(text)
    type(flat_t), intent(in) :: f
    integer, intent(in) :: i
    character(:), allocatable :: text

    select case (f%kind)
    case (WHOLE); text = text_of(f%n(i))
    case (REALS); text = text_of(f%x(i))
    case (TRUTH); text = trim(merge('true ', 'false', f%l(i)))
    case default; text = "'"//trim(f%t(i)%s)//"'"
    end select
  end function entry

  function difference(e, a, i, j) result(text)
    type(flat_t), intent(in) :: e, a
    integer, intent(in) :: i, j
    character(:), allocatable :: text

    text = ''
    if (a%kind > REALS) return
    if (ieee_is_finite(e%x(i)) .and. ieee_is_finite(a%x(j))) text = ', difference '//brief(a%x(j) - e%x(i))
  end function difference

  !> Indices of the i-th entry.
  function place(extent, i) result(text)
    integer, intent(in) :: extent(:), i
    character(:), allocatable :: text
    integer :: d, rest

    text = ''
    if (size(extent) == 0) return
    rest = i - 1
    do d = 1, size(extent)
      text = text//' '//text_of(mod(rest, extent(d)) + 1)
      rest = rest/extent(d)
    end do
    text = ', at'//text
  end function place

  function shape_text(extent) result(text)
    integer, intent(in) :: extent(:)
    character(:), allocatable :: text
    integer :: d

    text = ''
    do d = 1, size(extent)
      text = text//' '//text_of(extent(d))
    end do
  end function shape_text

  function text_of(value) result(text)
    class(*), intent(in) :: value
    character(:), allocatable :: text
    character(40) :: buffer

    buffer = ''
    select type (value)
    type is (integer); write (buffer, '(i0)') value
    type is (integer(i8)); write (buffer, '(i0)') value
    type is (real(dp)); write (buffer, '(g0)') value
    end select
    text = trim(adjustl(buffer))
  end function text_of

  function brief(x) result(text)
    real(dp), intent(in) :: x
    character(:), allocatable :: text
    character(12) :: buffer

    write (buffer, '(es12.2e3)') x
    text = trim(adjustl(buffer))
  end function brief

end module funit_value
