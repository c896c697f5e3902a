!> Values by node number, with generation: BOUNdary, FORCe, DISPlacement, FPROportional.
!!
!! As in FEAP, the increment of a record applies to the nodes between those of this record and the
!! next one: FORCe and DISPlacement interpolate, FPROportional repeats the numbers, and BOUNdary
!! repeats only negative codes. A negative code also replaces a 0 in the next record of BOUNdary.
!!
!! Source: FEAPpv's manual
module word_nodal
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: note_load_number
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use input_draft, only: draft_t, next_data, check_number, check_increment, C_FIXED, &
                         C_VALUE, C_FORCE, C_TABLE
  use input_fields, only: get_numbers
  use input_lists, only: grow_nodes, add_named_node
  implicit none
  private
  public :: read_boundary, read_load_numbers, read_vectors

contains

  !> Read BOUNdary: `n g code1 code2 code3`.
  subroutine read_boundary(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: n, step, last, last_step, code(3), i

    call check_count(record, 1, 1, "BOUNdary has no options; records 'n g code1 code2 code3' " &
                     //'follow', error)
    if (allocated(error)) return
    call note_order(draft, C_FIXED)
    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_head(draft, deck, "write restraints as 'n g code1 code2 code3'", line, n, step, &
                     error)
      if (allocated(error) .or. n == 0) return
      call get_numbers(deck, line, 3, code, error, 0)
      if (allocated(error)) return
      associate (codes => draft%nodes%code)
        if (last > 0) where (code == 0 .and. codes(:, last) < 0) code = -1
        codes(:, n) = code
        if (last == 0 .or. last_step == 0) cycle
        last_step = sign(last_step, n - last)
        do i = last + last_step, n, last_step
          if (i == n) exit
          where (codes(:, i - last_step) < 0) codes(:, i) = -1
        end do
      end associate
    end do
  end subroutine read_boundary

  !> Read FPROportional: `n g k1 k2 k3`.
  subroutine read_load_numbers(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: n, step, last, last_step, number(3), i

    call check_count(record, 1, 1, "FPROportional has no options; records 'n g k1 k2 k3' follow", &
                     error)
    if (allocated(error)) return
    call note_order(draft, C_TABLE)
    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_head(draft, deck, "write load numbers as 'n g k1 k2 k3'", line, n, step, error)
      if (allocated(error) .or. n == 0) return
      call get_numbers(deck, line, 3, number, error, 0)
      if (allocated(error)) return
      do i = 1, 3
        call note_load_number(draft%model%bc, abs(number(i)), line%place(1))
      end do
      associate (table => draft%nodes%table)
        table(:, n) = abs(number)
        if (last == 0 .or. last_step == 0) cycle
        last_step = sign(last_step, n - last)
        do i = last + last_step, n, last_step
          if (i /= n) table(:, i) = table(:, last)
        end do
      end associate
    end do
  end subroutine read_load_numbers

  !> Read FORCe: `n g f1 f2 f3`, or DISPlacement: `n g u1 u2 u3`. TRANsform rotates the vectors.
  subroutine read_vectors(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: fields
    type(record_t) :: line
    logical :: is_force
    integer :: n, step, last, last_step
    real(wp) :: x(3)

    is_force = record%key(1) == 'forc'
    fields = "'n g u1 u2 u3'"
    if (is_force) fields = "'n g f1 f2 f3'"
    call check_count(record, 1, 1, record%text(1)//' has no options; records '//fields//' follow', &
                     error)
    if (allocated(error)) return
    call note_order(draft, merge(C_FORCE, C_VALUE, is_force))
    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_head(draft, deck, 'write a vector as '//fields, line, n, step, error)
      if (allocated(error) .or. n == 0) return
      call get_numbers(deck, line, 3, x, error, 0.0_wp)
      if (allocated(error)) return
      x = matmul(draft%turn, x)
      if (last == n) last_step = 0
      if (is_force) then
        if (.not. (n == last .and. step /= 0)) call warn_replaced(draft, line, n)
        draft%nodes%forced(n) = .true.
        draft%nodes%force(:, n) = x
        call interpolate_between(draft%nodes%force, last, n, last_step)
      else
        draft%nodes%value(:, n) = x
        if (.not. allocated(draft%nodes%disp%file)) draft%nodes%disp = line%place(1)
        call interpolate_between(draft%nodes%value, last, n, last_step)
      end if
    end do
  end subroutine read_vectors

  !> Warn, once, if a record of FORCe replaces the force that an earlier one gives to its node.
  subroutine warn_replaced(draft, line, n)
    type(draft_t), intent(inout) :: draft
    type(record_t), intent(in) :: line
    integer, intent(in) :: n

    if (draft%force_twice .or. .not. draft%nodes%forced(n)) return
    if (.not. any(abs(draft%nodes%force(:, n)) > 0.0_wp)) return
    draft%force_twice = .true.
    call warn('FORCe is given twice at node '//to_text(n)//'; further such nodes are not ' &
              //'reported', line%place(1), 'the later record replaces the earlier one (FEAP): ' &
              //'give the sum, or use CFORce,ADD')
  end subroutine warn_replaced

  !> Record how many conditions by position precede the first record of this kind.
  pure subroutine note_order(draft, kind)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: kind !! C_FIXED ...

    if (draft%nodes%after(kind) < 0) draft%nodes%after(kind) = draft%ncondition
  end subroutine note_order

  !> Read the next record with its node number and increment; n = 0 at the end of the data (a blank
  !! record, or node 0 as in FEAP).
  subroutine read_head(draft, deck, usage, record, n, step, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    character(*), intent(in) :: usage
    type(record_t), intent(out) :: record
    integer, intent(out) :: n, step
    type(error_t), allocatable, intent(out) :: error
    logical :: more

    n = 0
    step = 0
    call next_data(draft, deck, record, more, error)
    if (allocated(error) .or. .not. more) return
    call get_integer(deck, record, 1, n, error)
    if (allocated(error)) return
    if (n == 0) then
      draft%in_set = .false.
      return
    end if
    call check_count(record, 3, 5, usage, error)
    if (.not. allocated(error)) call check_number('node', n, record%place(1), error)
    if (.not. allocated(error)) call get_integer(deck, record, 2, step, error, 0)
    if (.not. allocated(error)) call check_increment(step, record%place(2), error)
    if (allocated(error)) return
    call grow_nodes(draft%nodes, n)
    if (.not. draft%nodes%given(n)) call add_named_node(draft%named_nodes, n, record%place(1))
  end subroutine read_head

  !> Interpolate the columns between a and b linearly; do nothing if a or the increment is 0.
  pure subroutine interpolate_between(x, a, b, increment)
    real(wp), intent(inout) :: x(:, :) !! (3, >= max(a, b))
    integer, intent(in) :: a, b, increment
    real(wp) :: dx(3)
    integer :: n, step

    if (a == 0 .or. increment == 0) return
    step = sign(increment, b - a)
    dx = (x(:, b) - x(:, a))/real((abs(b - a + step) - 1)/abs(step), wp)
    do n = a + step, b, step
      if (n == b) exit
      x(:, n) = x(:, n - step) + dx
    end do
  end subroutine interpolate_between

end module word_nodal
