!> COORdinates and NURBs with generation, and TRANsform.
!!
!! Source: FEAPpv's manual. Two successive records with numbers l and n, the first with increment g,
!! generate the nodes l+g, l+2g, ... between them on a straight line. The weights of control points
!! are interpolated like the coordinates.
module word_nodes
  use base_error, only: error_t, fail, DECK_ERROR
  use base_kinds, only: wp
  use base_text, only: to_text
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, next_data, end_set, check_number, check_increment
  use input_fields, only: get_numbers
  use input_idle, only: warn_idle_transform
  use input_lists, only: grow_nodes
  use input_twice, only: warn_node_twice
  use tensor, only: det3
  implicit none
  private
  public :: read_points, read_transform

contains

  !> Read COORdinates: `n g x y z`, or NURBs: `n g x y z w`; n = 0 ends the data in the same way as
  !! a blank record (FEAP).
  subroutine read_points(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: fields
    type(record_t) :: line
    logical :: more, weighted
    integer :: n, step, last, last_step, i
    real(wp) :: x(3), dx(3), w, dw

    weighted = record%key(1) == 'nurb'
    fields = "'n g x y z'"
    if (weighted) fields = "'n g x y z w'"
    call check_count(record, 1, 1, record%text(1)//' has no options; records '//fields//' follow', &
                     error)
    if (allocated(error)) return
    n = 0
    step = 0
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      last = n
      last_step = step
      call get_integer(deck, line, 1, n, error)
      if (allocated(error)) return
      if (n == 0) then
        call end_set(draft, deck, line, 'nodes are numbered from 1', error)
        return
      end if
      call check_count(line, 3, merge(6, 5, weighted), 'write a point as '//fields, error)
      if (.not. allocated(error)) call check_number('node', n, line%place(1), error)
      if (.not. allocated(error)) call get_integer(deck, line, 2, step, error, 0)
      if (.not. allocated(error)) call check_increment(step, line%place(2), error)
      if (.not. allocated(error)) call get_numbers(deck, line, 3, x, error, 0.0_wp)
      w = 0.0_wp
      if (weighted .and. .not. allocated(error)) call get_real(deck, line, 6, w, error)
      if (allocated(error)) return
      if (weighted .and. .not. w > 0.0_wp) then
        call fail(error, DECK_ERROR, 'control point '//to_text(n)//' has weight '//to_text(w), &
                  line%place(6), 'give a positive weight')
        return
      end if
      call grow_nodes(draft%nodes, n)
      if (n /= last) call warn_node_twice(draft, line%place(1), n, 'the later record replaces ' &
                                          //'the earlier one: remove one of them')
      call set_point(n, matmul(draft%turn, x) + draft%shift, w)
      if (allocated(draft%idle_transform)) deallocate (draft%idle_transform)
      if (n == last) then
        call fail(error, DECK_ERROR, 'node '//to_text(n)//' is given twice in succession', &
                  line%place(1), 'keep one of the two records')
        return
      end if
      if (last_step == 0) cycle
      last_step = sign(last_step, n - last)
      i = (abs(n - last + last_step) - 1)/abs(last_step) ! number of intervals
      dx = (draft%nodes%x(:, n) - draft%nodes%x(:, last))/real(i, wp)
      dw = (draft%nodes%weight(n) - draft%nodes%weight(last))/real(i, wp)
      do i = last + last_step, n, last_step
        if (i == n) exit
        if (draft%nodes%given(i)) then
          call warn_node_twice(draft, line%place(1), i, 'the increment ' &
                               //to_text(abs(last_step))//' of node '//to_text(last) &
                               //' generates it again: give the last record of a line the ' &
                               //'increment 0')
        end if
        call set_point(i, draft%nodes%x(:, i - last_step) + dx, & ! FEAP adds up the increments
                       draft%nodes%weight(i - last_step) + dw)
      end do
    end do

  contains

    subroutine set_point(number, position, weight)
      integer, intent(in) :: number
      real(wp), intent(in) :: position(3), weight

      draft%nodes%x(:, number) = position
      draft%nodes%given(number) = .true.
      draft%nodes%weight(number) = weight
      draft%nodes%top = max(draft%nodes%top, number)
      draft%last_node = max(draft%last_node, number)
    end subroutine set_point
  end subroutine read_points

  !> Read TRANsform: three rows of a matrix T and a vector s; positions x read after it become T x +
  !! s.
  subroutine read_transform(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: row
    real(wp) :: t(3, 4)
    logical :: more
    integer :: i

    call warn_idle_transform(draft)
    call check_count(record, 1, 1, &
                     'TRANsform has no options; four records of three numbers follow', error)
    if (allocated(error)) return
    t = 0.0_wp
    do i = 1, 4
      call next_data(draft, deck, row, more, error)
      if (allocated(error)) return
      if (.not. more) then
        if (i == 4) exit ! a blank vector is zero (FEAP)
        call fail(error, DECK_ERROR, 'TRANsform has only '//to_text(i - 1)//' of its four ' &
                  //'records', record%place(1), 'give three rows of the matrix, then the vector')
        return
      end if
      call check_count(row, 1, 3, 'a row of TRANsform has three numbers', error)
      if (.not. allocated(error)) call get_numbers(deck, row, 1, t(:, i), error, 0.0_wp)
      if (allocated(error)) return
    end do
    draft%in_set = .false.
    draft%turn = transpose(t(:, :3))
    draft%shift = t(:, 4)
    if (.not. abs(det3(draft%turn)) > 1.0e-12_wp*norm2(draft%turn)**3) then
      call fail(error, DECK_ERROR, 'the matrix of TRANsform is singular', record%place(1), &
                'give three rows that do not lie in one plane')
      return
    end if
    t(:, :3) = t(:, :3) - reshape([1, 0, 0, 0, 1, 0, 0, 0, 1]*1.0_wp, [3, 3])
    if (any(abs(t) > 0.0_wp)) draft%idle_transform = record%place(1)
  end subroutine read_transform

end module word_nodes
