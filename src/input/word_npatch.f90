!> igaFEAP's KNOTs and NPATch.
!!
!!   KNOTs                          NPATch
!!     open id len k1 k2 ...          solid ma n1 n2 n3 k1 k2 k3
!!                                    control point numbers: a row runs along direction 3;
!!                                    rows go direction 1 fastest, then 2
!!
!! Long lists go on in further records, as FEAP's 16 numbers a record make them.
module word_npatch
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, npatch_t, knot_vector_t, next_data, check_number
  use input_lists, only: MAX_NUMBER
  implicit none
  private
  public :: read_knots, read_npatch

  integer, parameter :: MAX_KNOT = 1000000

contains

  !> KNOTs: one vector after the other.
  subroutine read_knots(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(knot_vector_t) :: v
    logical :: more
    integer :: n, used

    call check_count(record, 1, 1, 'KNOTs stands alone; open id len k1 k2 ... follow', error)
    if (allocated(error)) return
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      if (line%key(1) /= 'open' .and. line%key(1) /= 'knot') then
        call fail(error, DECK_ERROR, 'unknown kind of knot vector '//quoted(line%text(1)), &
                  line%place(1), &
                  'open id len k1 k2 ...')
        return
      end if
      call check_count(line, 4, huge(1), 'open id len k1 k2 ...', error)
      if (.not. allocated(error)) call get_integer(deck, line, 2, v%number, error)
      if (.not. allocated(error)) call check_number('knot vector', v%number, line%place(2), error)
      if (.not. allocated(error)) call get_integer(deck, line, 3, n, error)
      if (allocated(error)) return
      if (n < 4 .or. n > MAX_KNOT) then
        call fail(error, DECK_ERROR, 'a knot vector of '//to_text(n)//' knots', line%place(3), &
                  'an open knot vector has at least 4 knots, and here at most '//to_text(MAX_KNOT))
        return
      end if
      v%place = line%place(2)
      if (any(build%knots%number == v%number)) then
        call fail(error, DECK_ERROR, 'knot vector '//to_text(v%number)//' is defined twice', &
                  v%place)
        return
      end if
      call read_values(build, deck, line, n, v%u, error)
      if (allocated(error)) return
      used = count(build%knots%number > 0)
      if (used == size(build%knots)) call grow_knots(build%knots)
      build%knots(used + 1) = v
    end do
  end subroutine read_knots

  !> Room for as many vectors again; those that are not given have the number 0.
  subroutine grow_knots(list)
    type(knot_vector_t), allocatable, intent(inout) :: list(:)
    type(knot_vector_t), allocatable :: longer(:)

    allocate (longer(2*size(list) + 8))
    longer(:size(list)) = list
    call move_alloc(longer, list)
  end subroutine grow_knots

  !> n numbers from field 4 of a record on, going on in the next ones.
  subroutine read_values(build, deck, first, n, x, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: first
    integer, intent(in) :: n
    real(wp), allocatable, intent(out) :: x(:)
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: i, at
    logical :: more

    allocate (x(n))
    line = first
    at = 3
    do i = 1, n
      at = at + 1
      if (at > line%n) then
        call next_data(build, deck, line, more, error)
        if (allocated(error)) return
        if (.not. more) then
          call fail(error, DECK_ERROR, to_text(i - 1)//' of '//to_text(n)//' knots are given', &
                    first%place(3))
          return
        end if
        at = 1
      end if
      call get_real(deck, line, at, x(i), error)
      if (allocated(error)) return
    end do
    if (at < line%n) call fail(error, DECK_ERROR, 'more than '//to_text(n)//' knots are given', &
                               line%place(at + 1))
  end subroutine read_values

  !> NPATch: solids.
  subroutine read_npatch(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(npatch_t) :: p
    type(npatch_t), allocatable :: longer(:)
    logical :: more
    integer :: d

    call check_count(record, 1, 1, 'NPATch stands alone; solid ma n1 n2 n3 k1 k2 k3 follows', error)
    if (allocated(error)) return
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      if (line%key(1) /= 'soli') then
        call fail(error, DECK_ERROR, 'unknown kind of NPATch '//quoted(line%text(1)), &
                  line%place(1), &
                  'solid ma n1 n2 n3 k1 k2 k3')
        return
      end if
      call check_count(line, 8, 8, 'solid ma n1 n2 n3 k1 k2 k3', error)
      if (allocated(error)) return
      p%place = line%place(1)
      call get_integer(deck, line, 2, p%material, error)
      do d = 1, 3
        if (.not. allocated(error)) call get_integer(deck, line, d + 2, p%n(d), error)
        if (.not. allocated(error)) call get_integer(deck, line, d + 5, p%knot(d), error)
        if (allocated(error)) return
        if (p%n(d) < 2) call fail(error, DECK_ERROR, to_text(p%n(d)) &
                                  //' control points in direction ' &
                                  //to_text(d), line%place(d + 2), 'at least 2')
        if (allocated(error)) return
      end do
      if (product(int(p%n, i8)) > MAX_NUMBER .or. maxval(p%n) > MAX_KNOT) then
        call fail(error, DECK_ERROR, 'NPATch has too many control points', line%place(3), &
                  'a mesh has at most '//to_text(MAX_NUMBER)//' nodes')
        return
      end if
      call read_rows(build, deck, p, error)
      if (allocated(error)) return
      allocate (longer(size(build%npatch) + 1))
      longer(:size(build%npatch)) = build%npatch
      longer(size(longer)) = p
      call move_alloc(longer, build%npatch)
    end do
  end subroutine read_npatch

  !> Control point numbers, a row at a time.
  subroutine read_rows(build, deck, p, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(npatch_t), intent(inout) :: p
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: i, j, k, at
    logical :: more

    if (allocated(p%node)) deallocate (p%node)
    allocate (p%node(p%n(1), p%n(2), p%n(3)))
    do j = 1, p%n(2)
      do i = 1, p%n(1)
        at = 0
        do k = 1, p%n(3)
          if (k == 1 .or. at >= line%n) then
            call next_data(build, deck, line, more, error)
            if (allocated(error)) return
            if (.not. more) then
              call fail(error, DECK_ERROR, 'row '//to_text(i + p%n(1)*(j - 1))//' of ' &
                        //to_text(p%n(1)*p%n(2))//' of the NPATch is missing or short', p%place, &
                        'each row holds '//to_text(p%n(3))//' control points, along direction 3')
              return
            end if
            at = 0
          end if
          at = at + 1
          call get_integer(deck, line, at, p%node(i, j, k), error)
          if (.not. allocated(error)) call check_number('control point', p%node(i, j, k), &
                                                        line%place(at), error)
          if (allocated(error)) return
        end do
        if (at < line%n) then
          call fail(error, DECK_ERROR, 'a row of the NPATch holds more than '//to_text(p%n(3)) &
                    //' control points', line%place(at + 1), 'each row runs along direction 3')
          return
        end if
      end do
    end do
  end subroutine read_rows

end module word_npatch
