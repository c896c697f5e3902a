!> COORdinates and NURBs with generation, and TRANsform.
!!
!! Source: FEAPpv's manual; two records with numbers l and n, the first with increment g, make
!! l+g, l+2g, ... between them on a straight line.
module word_nodes
  use base_kinds, only: wp
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, next_data, check_number
  use input_lists, only: grow_nodes
  implicit none
  private
  public :: read_coordinates, read_nurbs, read_transform

contains

  !> COORdinates: `n g x y z`.
  subroutine read_coordinates(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, 'COORdinates stands alone; its data follow', error)
    if (allocated(error)) return
    call read_points(build, deck, .false., error)
  end subroutine read_coordinates

  !> NURBs: `n g x y z w`.
  subroutine read_nurbs(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, 'NURBs stands alone; its data follow: n g x y z w', error)
    if (allocated(error)) return
    call read_points(build, deck, .true., error)
  end subroutine read_nurbs

  !> Records of points up to the blank one.
  subroutine read_points(build, deck, weighted, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    logical, intent(in) :: weighted
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    logical :: more
    integer :: n, step, last, last_step
    real(wp) :: w

    n = 0
    step = 0
    do
      call next_data(build, deck, record, more, error)
      if (allocated(error) .or. .not. more) return
      last = n
      last_step = step
      call read_point(build, deck, record, weighted, n, step, w, error)
      if (allocated(error)) return
      if (n < 1) return
      if (n == last) then
        call fail(error, DECK_ERROR, 'node '//to_text(n)//' stands twice in succession', &
                  record%place(1))
        return
      end if
      if (last_step /= 0) call fill_between(build, last, n, sign(last_step, n - last), weighted)
    end do
  end subroutine read_points

  !> One point; n = 0 ends the data as a blank record does (FEAP).
  subroutine read_point(build, deck, record, weighted, n, step, w, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    logical, intent(in) :: weighted
    integer, intent(out) :: n, step
    real(wp), intent(out) :: w
    type(error_t), allocatable, intent(out) :: error
    real(wp) :: x(3)
    integer :: d

    w = 0.0_wp
    step = 0
    call get_integer(deck, record, 1, n, error)
    if (allocated(error)) return
    if (n == 0) then
      build%in_set = .false.
      return
    end if
    if (weighted) then
      call check_count(record, 3, 6, 'a control point is: n g x y z w', error)
    else
      call check_count(record, 3, 5, 'a node is: n g x y z', error)
    end if
    if (allocated(error)) return
    call check_number('node', n, record%place(1), error)
    if (allocated(error)) return
    call get_integer(deck, record, 2, step, error, 0)
    do d = 1, 3
      if (allocated(error)) return
      call get_real(deck, record, d + 2, x(d), error, 0.0_wp)
    end do
    if (allocated(error)) return
    if (weighted) then
      call get_real(deck, record, 6, w, error)
      if (allocated(error)) return
      if (.not. w > 0.0_wp) then
        call fail(error, DECK_ERROR, 'control point '//to_text(n)//' has the weight '//to_text(w), &
                  record%place(6), 'weights are positive')
        return
      end if
    end if
    call grow_nodes(build%nodes, n)
    call set_point(build, n, matmul(build%turn, x) + build%shift, w)
  end subroutine read_point

  subroutine set_point(build, n, x, w)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: n
    real(wp), intent(in) :: x(3), w

    build%nodes%x(:, n) = x
    build%nodes%given(n) = .true.
    build%nodes%weight(n) = w
    build%nodes%top = max(build%nodes%top, n)
    build%last_node = max(build%last_node, n)
  end subroutine set_point

  !> Points between a and b, each one increment behind the one before, as FEAP adds them up.
  subroutine fill_between(build, a, b, step, weighted)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: a, b, step
    logical, intent(in) :: weighted
    real(wp) :: dx(3), w
    integer :: n

    dx = (build%nodes%x(:, b) - build%nodes%x(:, a))/real((abs(b - a + step) - 1)/abs(step), wp)
    do n = a + step, b, step
      if (n == b) exit
      w = 0.0_wp
      if (weighted) w = merge(build%nodes%weight(n), 1.0_wp, build%nodes%weight(n) > 0.0_wp)
      call set_point(build, n, build%nodes%x(:, n - step) + dx, w)
    end do
  end subroutine fill_between

  !> TRANsform: three rows of a matrix and a vector; x -> T x + s for what is read after it.
  subroutine read_transform(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: row
    real(wp) :: t(3, 4), size, volume
    logical :: more
    integer :: i, j

    call check_count(record, 1, 1, &
                     'TRANsform stands alone; four records of three numbers follow', error)
    if (allocated(error)) return
    t = 0.0_wp
    do i = 1, 4
      call next_data(build, deck, row, more, error)
      if (allocated(error)) return
      if (.not. more) then
        if (i == 4) exit ! a blank vector is zero (FEAP)
        call fail(error, DECK_ERROR, 'TRANsform has '//to_text(i - 1)//' of its four records', &
                  record%place(1), 'three rows of the matrix, then the vector')
        return
      end if
      call check_count(row, 1, 3, 'a row of TRANsform is three numbers', error)
      do j = 1, 3
        if (allocated(error)) return
        call get_real(deck, row, j, t(j, i), error, 0.0_wp)
      end do
      if (allocated(error)) return
    end do
    build%in_set = .false.
    build%turn = transpose(t(:, :3))
    build%shift = t(:, 4)
    size = norm2(build%turn)
    volume = dot_product(t(:, 1), [t(2, 2)*t(3, 3) - t(3, 2)*t(2, 3), t(3, 2)*t(1, 3) &
                                   - t(1, 2)*t(3, 3), t(1, 2)*t(2, 3) - t(2, 2)*t(1, 3)])
    if (.not. abs(volume) > 1.0e-12_wp*size**3) then
      call fail(error, DECK_ERROR, 'the matrix of TRANsform is singular', record%place(1), &
                'its rows must not lie in one plane')
    end if
  end subroutine read_transform

end module word_nodes
