!> Groups of fields that occur in several records: rows of numbers, a direction, an axis.
module input_fields
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text
  use deck_record, only: record_t
  use deck_stream, only: deck_t, get_integer, get_real
  implicit none
  private
  public :: get_numbers, get_direction, get_axis

  !> Read as many numbers as the array has entries, beginning at field `first`.
  interface get_numbers
    module procedure get_reals, get_integers
  end interface get_numbers

contains

  subroutine get_reals(deck, record, first, x, error, default)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    real(wp), intent(inout) :: x(:) !! if an entry fails, later ones keep their values
    type(error_t), allocatable, intent(out) :: error
    real(wp), intent(in), optional :: default !! value of empty and missing fields
    integer :: i

    do i = 1, size(x)
      call get_real(deck, record, first + i - 1, x(i), error, default)
      if (allocated(error)) return
    end do
  end subroutine get_reals

  subroutine get_integers(deck, record, first, n, error, default)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    integer, intent(inout) :: n(:)
    type(error_t), allocatable, intent(out) :: error
    integer, intent(in), optional :: default
    integer :: i

    do i = 1, size(n)
      call get_integer(deck, record, first + i - 1, n(i), error, default)
      if (allocated(error)) return
    end do
  end subroutine get_integers

  !> Read a coordinate direction, 1 to 3, from field i.
  subroutine get_direction(deck, record, i, d, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: i
    integer, intent(out) :: d
    type(error_t), allocatable, intent(out) :: error

    call get_integer(deck, record, i, d, error)
    if (allocated(error)) return
    if (d < 1 .or. d > 3) call fail(error, DECK_ERROR, 'unknown direction '//to_text(d), &
                                    record%place(i), 'directions are 1, 2 and 3')
  end subroutine get_direction

  !> Read a point and a unit vector, `px py pz  ax ay az`, beginning with field `first`.
  subroutine get_axis(deck, record, first, usage, point, axis, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    integer, intent(in) :: first
    character(*), intent(in) :: usage !! the form of the record, for messages
    real(wp), intent(out) :: point(3) !! a point of the axis [L]
    real(wp), intent(out) :: axis(3)  !! unit vector
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: length

    point = 0.0_wp
    axis = 0.0_wp
    call get_numbers(deck, record, first, point, error)
    if (.not. allocated(error)) call get_numbers(deck, record, first + 3, axis, error)
    if (allocated(error)) return
    length = norm2(axis)
    if (length > 0.0_wp) then
      axis = axis/length
    else
      call fail(error, DECK_ERROR, 'the axis has zero length', record%place(first + 3), usage)
    end if
  end subroutine get_axis

end module input_fields
