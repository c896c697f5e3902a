!> Fields that several records of a CURVe have: a direction, an axis.
module setup_curve_field
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use curve_type, only: quantity_t
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  implicit none
  private
  public :: read_direction, read_axis

contains

  !> A direction in the last field, i.
  subroutine read_direction(deck, line, i, usage, quantity, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: usage
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error

    call check_count(line, i, i, usage, error)
    if (.not. allocated(error)) call get_integer(deck, line, i, quantity%component, error)
    if (allocated(error)) return
    if (quantity%component >= 1 .and. quantity%component <= 3) return
    call fail(error, DECK_ERROR, 'direction '//to_text(quantity%component), line%place(i), &
              'directions are 1, 2 and 3')
  end subroutine read_direction

  !> px py pz  ax ay az in the last fields, from i on.
  subroutine read_axis(deck, line, i, usage, quantity, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: line
    integer, intent(in) :: i
    character(*), intent(in) :: usage
    type(quantity_t), intent(inout) :: quantity
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(6), length
    integer :: d

    call check_count(line, i + 5, i + 5, usage, error)
    do d = 1, 6
      if (allocated(error)) return
      call get_real(deck, line, i + d - 1, x(d), error)
    end do
    if (allocated(error)) return
    length = norm2(x(4:))
    if (.not. length > 0.0_wp) then
      call fail(error, DECK_ERROR, 'the axis of the torque has no length', line%place(i + 3), usage)
      return
    end if
    quantity%point = x(:3)
    quantity%axis = x(4:)/length
  end subroutine read_axis

end module setup_curve_field
