!> KNOTs and NPATch of igaFEAP.
!!
!!   KNOTs                          NPATch
!!     open id len k1 k2 ...          solid ma n1 n2 n3 k1 k2 k3
!!                                    control point numbers: a row runs along direction 3;
!!                                    from row to row, direction 1 varies fastest, then 2
!!
!! Long lists continue in further records, as FEAP's limit of 16 numbers in a record requires.
module word_npatch
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: draft_t, npatch_entry_t, knot_vector_t, next_data, check_number
  use input_fields, only: get_numbers
  use input_lists, only: MAX_NUMBER
  use input_record, only: word_index
  implicit none
  private
  public :: read_knots, read_npatch

  character(12), parameter, public :: KNOT_RECORDS(2) = ['OPEN        ', 'KNOT        ']
  character(12), parameter, public :: NPATCH_RECORDS(1) = ['SOLId       ']
  integer, parameter :: MAX_KNOT = 1000000

contains

  !> Read KNOTs: one vector after another, each of which may continue in further records.
  subroutine read_knots(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'open id len k1 k2 ...'
    type(record_t) :: line
    type(knot_vector_t) :: v
    type(place_t) :: place_of_count
    logical :: more
    integer :: n, i, at

    call check_count(record, 1, 1, "KNOTs has no options; records '"//USAGE//"' follow", error)
    if (allocated(error)) return
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      if (word_index(KNOT_RECORDS, line%key(1)) == 0) then
        call fail(error, DECK_ERROR, 'expected open, found '//quoted(line%text(1)), &
                  line%place(1), USAGE)
        return
      end if
      call check_count(line, 4, huge(1), USAGE, error)
      if (.not. allocated(error)) call get_integer(deck, line, 2, v%number, error)
      if (.not. allocated(error)) call check_number('knot vector', v%number, line%place(2), error)
      if (.not. allocated(error)) call get_integer(deck, line, 3, n, error)
      if (allocated(error)) return
      if (n < 4 .or. n > MAX_KNOT) then
        call fail(error, DECK_ERROR, 'the knot vector has '//to_text(n)//' knots', line%place(3), &
                  'give 4 to '//to_text(MAX_KNOT)//' knots')
        return
      end if
      v%place = line%place(2)
      place_of_count = line%place(3)
      if (any(draft%knots%number == v%number)) then
        call fail(error, DECK_ERROR, 'duplicate knot vector '//to_text(v%number), v%place, &
                  'give each knot vector a number of its own')
        return
      end if
      if (allocated(v%u)) deallocate (v%u)
      allocate (v%u(n))
      at = 3
      do i = 1, n
        at = at + 1
        if (at > line%n) then
          call next_data(draft, deck, line, more, error)
          if (allocated(error)) return
          at = 1
        end if
        if (more) then
          call get_real(deck, line, at, v%u(i), error)
        else
          call fail(error, DECK_ERROR, 'expected '//to_text(n)//' knots, found '//to_text(i - 1), &
                    place_of_count, USAGE)
        end if
        if (allocated(error)) return
      end do
      if (at < line%n) then
        call fail(error, DECK_ERROR, 'expected '//to_text(n)//' knots, found more', &
                  line%place(at + 1), USAGE)
        return
      end if
      draft%knots = [draft%knots, v]
    end do
  end subroutine read_knots

  !> Read NPATch and its solids.
  subroutine read_npatch(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'solid ma n1 n2 n3 k1 k2 k3'
    type(record_t) :: line
    type(npatch_entry_t) :: p
    type(npatch_entry_t), allocatable :: longer(:)
    logical :: more
    integer :: d, n

    call check_count(record, 1, 1, "NPATch has no options; a record '"//USAGE//"' follows", error)
    if (allocated(error)) return
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      if (word_index(NPATCH_RECORDS, line%key(1)) == 0) then
        call fail(error, DECK_ERROR, 'expected solid, found '//quoted(line%text(1)), &
                  line%place(1), USAGE)
        return
      end if
      call check_count(line, 8, 8, USAGE, error)
      p%place = line%place(1)
      if (.not. allocated(error)) call get_integer(deck, line, 2, p%material, error)
      if (.not. allocated(error)) call get_numbers(deck, line, 3, p%n, error)
      if (.not. allocated(error)) call get_numbers(deck, line, 6, p%knot, error)
      if (allocated(error)) return
      d = findloc(p%n < 2, .true., 1)
      if (d > 0) then
        call fail(error, DECK_ERROR, 'the number of control points in direction ' &
                  //to_text(d)//' is '//to_text(p%n(d)), line%place(d + 2), 'give at least 2')
        return
      end if
      if (product(int(p%n, i8)) > MAX_NUMBER .or. maxval(p%n) > MAX_KNOT) then
        call fail(error, DECK_ERROR, 'NPATch has too many control points', line%place(3), &
                  'give at most '//to_text(MAX_KNOT)//' in one direction and ' &
                  //to_text(MAX_NUMBER)//' in all')
        return
      end if
      call read_rows(draft, deck, p, error)
      if (allocated(error)) return
      n = size(draft%npatch)
      allocate (longer(n + 1))
      longer(:n) = draft%npatch
      longer(n + 1) = p
      call move_alloc(longer, draft%npatch)
    end do
  end subroutine read_npatch

  !> Read the control point numbers; each row begins with a new record.
  subroutine read_rows(draft, deck, p, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(npatch_entry_t), intent(inout) :: p
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
            call next_data(draft, deck, line, more, error)
            if (allocated(error)) return
            if (.not. more) then
              call fail(error, DECK_ERROR, 'row '//to_text(i + p%n(1)*(j - 1))//' of ' &
                        //to_text(p%n(1)*p%n(2))//' of the NPATch is missing or incomplete', &
                        p%place, 'give '//to_text(p%n(3)) &
                        //' control points in each row, along direction 3')
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
          call fail(error, DECK_ERROR, 'a row of the NPATch has more than '//to_text(p%n(3)) &
                    //' control points', line%place(at + 1), 'each row runs along direction 3')
          return
        end if
      end do
    end do
  end subroutine read_rows

end module word_npatch
