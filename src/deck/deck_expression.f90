!> Expressions wherever a number may stand; deck_parser has their grammar.
module deck_expression
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use deck_cursor, only: parser_t, trouble_t, check_end
  use deck_number, only: scan_number
  use deck_params, only: params_t, set_parameter
  use deck_parser, only: parse_sum
  use, intrinsic :: ieee_exceptions, only: ieee_get_status, ieee_set_status, ieee_set_halting_mode
  use, intrinsic :: ieee_exceptions, only: ieee_status_type, ieee_usual
  implicit none
  private
  public :: evaluate, compute, trouble_t
  public :: params_t, set_parameter

contains

  !> Value of the expression `text`, which stands at `place`.
  subroutine evaluate(params, text, value, place, error)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    type(trouble_t), allocatable :: trouble
    type(place_t) :: spot

    call compute(params, text, value, trouble)
    if (.not. allocated(trouble)) return
    spot = place
    if (spot%column > 0) then
      spot%column = place%column + trouble%at - 1
      spot%width = trouble%width
    end if
    if (allocated(trouble%hint)) then
      call fail(error, DECK_ERROR, trouble%message, spot, trouble%hint)
    else
      call fail(error, DECK_ERROR, trouble%message, spot)
    end if
  end subroutine evaluate

  !> Value of an expression; what is wrong with it is told by position.
  subroutine compute(params, text, value, trouble)
    type(params_t), intent(in) :: params
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    type(trouble_t), allocatable, intent(out) :: trouble
    type(parser_t) :: parser
    type(ieee_status_type) :: status
    logical :: done

    call read_plain(text, value, done)
    if (done) return
    ! Overflow and the like are found by their results, so no trap may fire meanwhile.
    call ieee_get_status(status)
    call ieee_set_halting_mode(ieee_usual, .false.)
    parser%text = text
    call parse_sum(parser, params, value)
    if (.not. allocated(parser%trouble)) call check_end(parser)
    call ieee_set_status(status)
    if (.not. allocated(parser%trouble)) return
    value = 0.0_wp
    call move_alloc(parser%trouble, trouble)
  end subroutine compute

  !> The common case fast: up to 15 digits with at most a sign in front.
  subroutine read_plain(text, value, done)
    character(*), intent(in) :: text
    real(wp), intent(out) :: value
    logical, intent(out) :: done
    character(:), allocatable :: trouble
    integer :: n, first

    value = 0.0_wp
    done = .false.
    if (len(text) == 0 .or. len(text) > 16 .or. scan(text, 'eEdD') > 0) return
    first = merge(2, 1, scan(text(1:1), '+-') > 0)
    call scan_number(text(first:), n, value, trouble)
    done = n > 0 .and. n == len(text) - first + 1 .and. .not. allocated(trouble)
    if (text(1:1) == '-') value = -value
  end subroutine read_plain

end module deck_expression
