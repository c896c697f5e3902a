!> Values by node number, with generation: BOUNdary, FORCe, DISPlacement, FPROportional.
!!
!! As in FEAP, the increment of a record applies to the nodes between those of this record and the
!! next one: FORCe and DISPlacement interpolate, FPROportional repeats the numbers, and BOUNdary
!! repeats only negative codes. A negative code also replaces a 0 in the next record of BOUNdary.
!!
!! Source: FEAPpv's manual
module word_nodal
  use base_error, only: error_t, place_t
  use base_kinds, only: wp
  use base_log, only: warn
  use base_text, only: to_text
  use boundary, only: note_load_number
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use input_draft, only: draft_t, next_data, end_set, check_number, check_increment, C_FIXED, &
                         C_VALUE, C_FORCE, C_TABLE
  use input_fields, only: get_numbers
  use input_lists, only: grow_nodes, add_named_node
  implicit none
  private
  public :: read_boundary, read_load_numbers, read_vectors

  real(wp), parameter :: ROUNDING = 1.0e-9_wp !! vectors whose relative difference is less are equal

contains

  !> Read BOUNdary: `n g code1 code2 code3`.
  subroutine read_boundary(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: n, step, last, last_step, code(3), i
    logical :: told    ! a warning about generation was issued
    logical :: ends    ! the last record ends a generation
    logical :: zero    ! all codes are 0, and none of them frees a direction
    logical :: given(3)
    type(place_t) :: at ! the first record

    call check_count(record, 1, 1, "BOUNdary has no options; records 'n g code1 code2 code3' " &
                     //'follow', error)
    if (allocated(error)) return
    n = 0
    step = 0
    told = .false.
    ends = .false.
    zero = .true.
    do
      last = n
      last_step = step
      call read_head(draft, deck, "write restraints as 'n g code1 code2 code3'", line, n, step, &
                     error)
      if (allocated(error)) return
      if (n == 0) exit
      if (last == 0) at = line%place(1)
      call get_numbers(deck, line, 3, code, error, 0)
      if (allocated(error)) return
      associate (codes => draft%nodes%code)
        given = code /= 0
        zero = zero .and. .not. any(given .or. codes(:, n) /= 0) .and. line%has_digits_only(3)
        if (last > 0) where (code == 0 .and. codes(:, last) < 0) code = -1
        call warn_freed(draft, line, n, codes(:, n) /= 0 .and. code == 0)
        codes(:, n) = code
        draft%nodes%named(n) = ibset(draft%nodes%named(n), C_FIXED)
        call note_order(draft, C_FIXED, n, any(code /= 0))
        if (last == 0) cycle
        if (.not. told) call warn_generation(line, last, n, last_step, codes(:, last), &
                                             merge(code, 0, given), ends, told)
        ends = last_step /= 0 .and. any(codes(:, last) < 0)
        if (last_step == 0) cycle
        last_step = sign(last_step, n - last)
        do i = last + last_step, n, last_step
          if (i == n) exit
          where (codes(:, i - last_step) < 0) codes(:, i) = -1
          if (any(codes(:, i - last_step) < 0)) call note_order(draft, C_FIXED, i, .true.)
        end do
      end associate
    end do
    if (last > 0 .and. zero) call warn_zero('all codes of this BOUNdary are 0', at, &
                                            'n g code1 code2 code3')
  end subroutine read_boundary

  !> Warn about a word whose values are all zero.
  subroutine warn_zero(text, place, fields)
    character(*), intent(in) :: text
    type(place_t), intent(in) :: place
    character(*), intent(in) :: fields   !! of its records

    call warn(text, place, "write a record as '"//fields//"': without the increment g, the first " &
              //'value counts as g')
  end subroutine warn_zero

  !> Warn, once, if a record of BOUNdary frees directions of its node that earlier ones restrain.
  subroutine warn_freed(draft, line, n, freed)
    type(draft_t), intent(inout) :: draft
    type(record_t), intent(in) :: line
    integer, intent(in) :: n
    logical, intent(in) :: freed(3)
    character(:), allocatable :: text
    integer :: d

    if (draft%twice(C_FIXED) .or. .not. any(freed)) return
    draft%twice(C_FIXED) = .true.
    text = ''
    do d = 1, 3
      if (.not. freed(d)) cycle
      if (len(text) > 0) text = text//' and '
      text = text//to_text(d)
    end do
    text = trim(merge('direction ', 'directions', count(freed) == 1))//' '//text
    call warn('BOUNdary is given twice at node '//to_text(n)//', and this record frees '//text &
              //' again; further such nodes are not reported', line%place(1), &
              'the later record replaces all codes of the node (FEAP): give them in one record, ' &
              //'or add codes with EBOUndary or FIX')
  end subroutine warn_freed

  !> Warn if a restraint that is meant for the nodes between two records of BOUNdary does not act
  !! there, or if an increment generates restraints backwards.
  subroutine warn_generation(line, last, n, step, code, next, ends, told)
    type(record_t), intent(in) :: line
    integer, intent(in) :: last, n, step !! nodes of the two records, increment of the first one
    integer, intent(in) :: code(3), next(3) !! codes of the two records
    logical, intent(in) :: ends          !! the first record ends a generation
    logical, intent(out) :: told
    character(:), allocatable :: text, otherwise

    told = .false.
    if (any(code < 0)) call warn_backwards(line, last, n, step, 'restraints', told)
    if (told) return
    if (step == 0) then
      told = any(code < 0 .and. next < 0) .and. abs(n - last) > 1 .and. .not. ends
      text = 'the negative code of node '//to_text(last)//' restrains no nodes up to node ' &
             //to_text(n)//', because its increment is 0'
      otherwise = 'a positive code'
    else
      told = any(code > 0) .and. all(code >= 0 .and. next >= 0) .and. abs(n - last) > abs(step) &
             .and. (n > last .or. step < 0)
      text = 'the increment '//to_text(step)//' of node '//to_text(last)//' restrains no nodes ' &
             //'up to node '//to_text(n)//', because none of its codes is negative'
      otherwise = 'the increment 0'
    end if
    if (.not. told) return
    call warn(text//'; further such records are not reported', line%place(1), &
              'for the nodes in between, give node '//to_text(last)//' an increment and a ' &
              //'negative code; otherwise give it '//otherwise)
  end subroutine warn_generation

  !> Warn if a positive increment generates values backwards, because it is left over from the last
  !! record of a line of nodes and the next line begins at a lower node.
  subroutine warn_backwards(line, last, n, step, what, told)
    type(record_t), intent(in) :: line
    integer, intent(in) :: last, n, step !! nodes of two records, increment of the first one
    character(*), intent(in) :: what     !! what is generated
    logical, intent(out) :: told

    told = step > 0 .and. last - n > step
    if (.not. told) return
    call warn('the increment '//to_text(step)//' of node '//to_text(last)//' generates '//what &
              //' backwards, from node '//to_text(last - step)//' down to node ' &
              //to_text(last - step*((last - n - 1)/step))//'; further such records are not ' &
              //'reported', line%place(1), 'give the last record of a line the increment 0; if ' &
              //'these nodes are meant, write a negative increment')
  end subroutine warn_backwards

  !> Read FPROportional: `n g k1 k2 k3`.
  subroutine read_load_numbers(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    integer :: again   ! a node whose other numbers generation replaces; 0: none
    logical :: acts    ! generation changes numbers of nodes
    logical :: told    ! a warning about generation was issued
    logical :: zero    ! all numbers are 0, and replace no others
    logical :: stray   ! some increment generates nothing
    type(place_t) :: at ! the first record
    type(place_t) :: last_at ! the last record so far
    logical :: ends    ! the last record has the increment of the one before
    integer :: n, step, last, last_step, number(3), i

    call check_count(record, 1, 1, "FPROportional has no options; records 'n g k1 k2 k3' follow", &
                     error)
    if (allocated(error)) return
    n = 0
    step = 0
    told = .false.
    zero = .true.
    stray = .false.
    do
      last = n
      last_step = step
      call read_head(draft, deck, "write load numbers as 'n g k1 k2 k3'", line, n, step, error)
      if (allocated(error)) return
      if (n == 0) exit
      if (last == 0) at = line%place(1)
      last_at = line%place(1)
      ends = last > 0 .and. last_step == step
      call get_numbers(deck, line, 3, number, error, 0)
      if (allocated(error)) return
      stray = stray .or. (last_step > 0 .and. abs(n - last) <= last_step)
      do i = 1, 3
        call note_load_number(draft%model%bc, abs(number(i)), line%place(1))
      end do
      associate (table => draft%nodes%table)
        zero = zero .and. all(number == 0 .and. table(:, n) == 0) .and. line%has_digits_only(3)
        table(:, n) = abs(number)
        draft%nodes%numbered(n) = .true.
        draft%nodes%named(n) = ibset(draft%nodes%named(n), C_TABLE)
        call note_order(draft, C_TABLE, n, any(number /= 0))
        if (last == 0 .or. last_step == 0) cycle
        again = 0
        acts = .false.
        do i = last + sign(last_step, n - last), n, sign(last_step, n - last)
          if (i == n) exit
          if (any(table(:, i) /= table(:, last))) then
            acts = .true.
            if (again == 0 .and. any(table(:, i) > 0)) again = i
          end if
          table(:, i) = table(:, last)
          draft%nodes%numbered(i) = .true.
          call note_order(draft, C_TABLE, i, any(table(:, i) > 0))
        end do
        if (again > 0) then
          call warn_replaced(draft, line, C_TABLE, again, generated_again(last, last_step))
        else if (acts .and. .not. told) then
          call warn_backwards(line, last, n, last_step, 'load numbers', told)
        end if
      end associate
    end do
    stray = stray .or. last_step > 0 ! the increment of the last record
    if (last > 0 .and. zero .and. stray) then
      call warn_zero('all load numbers of this FPROportional are 0', at, 'n g k1 k2 k3')
    else if (last > 0 .and. last_step /= 0) then
      if (any(draft%nodes%table(:, last) /= 0) .and. .not. ends) then
        call warn_last(last, last_step, 'load numbers', 'FPROportional', 'n g k1 k2 k3', last_at)
      end if
    end if
  end subroutine read_load_numbers

  !> Read FORCe: `n g f1 f2 f3`, or DISPlacement: `n g u1 u2 u3`. TRANsform rotates the vectors.
  subroutine read_vectors(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: fields, hint
    type(record_t) :: line
    logical :: is_force
    logical :: twice   ! the record replaces the vector of its node
    logical :: acts    ! the vector of this record or that of the last one is not zero
    logical :: told    ! a warning about generation was issued
    logical :: zero    ! all records have only zeros, and replace no other values
    logical :: stray   ! some increment generates nothing
    type(place_t) :: at ! the first record
    type(place_t) :: last_at ! the last record so far
    logical :: ends    ! the last record has the increment of the one before
    integer :: again   ! a node whose vector generation replaces; 0: none
    integer :: n, step, last, last_step, kind, i
    real(wp) :: x(3)

    is_force = record%key(1) == 'forc'
    fields = "'n g u1 u2 u3'"
    if (is_force) fields = "'n g f1 f2 f3'"
    call check_count(record, 1, 1, record%text(1)//' has no options; records '//fields//' follow', &
                     error)
    if (allocated(error)) return
    kind = merge(C_FORCE, C_VALUE, is_force)
    n = 0
    step = 0
    told = .false.
    zero = .true.
    stray = .false.
    do
      last = n
      last_step = step
      call read_head(draft, deck, 'write a vector as '//fields, line, n, step, error)
      if (allocated(error)) return
      if (n == 0) exit
      if (last == 0) at = line%place(1)
      last_at = line%place(1)
      ends = last > 0 .and. last_step == step
      call get_numbers(deck, line, 3, x, error, 0.0_wp)
      if (allocated(error)) return
      zero = zero .and. .not. any(abs(x) > 0.0_wp) .and. line%has_digits_only(3)
      stray = stray .or. (last_step > 0 .and. abs(n - last) <= last_step)
      x = matmul(draft%turn, x)
      if (allocated(draft%idle_transform)) deallocate (draft%idle_transform)
      if (last == n) last_step = 0
      if (is_force) then
        twice = any(abs(draft%nodes%force(:, n)) > 0.0_wp) .and. &
                (btest(draft%nodes%named(n), C_FORCE) .or. is_lost(draft%nodes%force(:, n), x))
        draft%nodes%force(:, n) = x
        call interpolate_between(draft%nodes%force, last, n, last_step, again)
        acts = any(abs(draft%nodes%force(:, [max(last, 1), n])) > 0.0_wp)
      else
        twice = is_lost(draft%nodes%value(:, n), x)
        draft%nodes%value(:, n) = x
        if (.not. allocated(draft%nodes%disp%file)) draft%nodes%disp = line%place(1)
        call interpolate_between(draft%nodes%value, last, n, last_step, again)
        acts = any(abs(draft%nodes%value(:, [max(last, 1), n])) > 0.0_wp)
      end if
      zero = zero .and. .not. twice .and. again == 0
      draft%nodes%named(n) = ibset(draft%nodes%named(n), kind)
      call note_order(draft, kind, n, any(abs(x) > 0.0_wp))
      if (last > 0 .and. last_step /= 0) then
        do i = last + sign(last_step, n - last), n, sign(last_step, n - last)
          if (i == n) exit
          if (is_force) x = draft%nodes%force(:, i)
          if (.not. is_force) x = draft%nodes%value(:, i)
          call note_order(draft, kind, i, any(abs(x) > 0.0_wp))
        end do
      end if
      if (twice .and. .not. (n == last .and. step /= 0)) then
        hint = 'the later record replaces the earlier one (FEAP): remove one of them'
        if (is_force) hint = 'the later record replaces the earlier one (FEAP): give the sum, or ' &
                             //'use CFORce,ADD'
        call warn_replaced(draft, line, kind, n, hint)
      else if (again > 0) then
        call warn_replaced(draft, line, kind, again, generated_again(last, last_step))
      else if (last > 0 .and. acts .and. .not. told) then
        call warn_backwards(line, last, n, last_step, &
                            trim(merge('forces       ', 'displacements', is_force)), told)
      end if
    end do
    stray = stray .or. last_step > 0 ! the increment of the last record
    if (last > 0 .and. zero .and. (is_force .or. stray)) then
      call warn_zero('all values of this '//trim(merge('FORCe       ', 'DISPlacement', is_force)) &
                     //' are zero', at, fields(2:len(fields) - 1))
    else if (last > 0 .and. last_step /= 0 .and. .not. ends) then
      if (is_force) then
        if (any(abs(draft%nodes%force(:, last)) > 0.0_wp)) then
          call warn_last(last, last_step, 'forces', 'FORCe', 'n g f1 f2 f3', last_at)
        end if
      else if (any(abs(draft%nodes%value(:, last)) > 0.0_wp)) then
        call warn_last(last, last_step, 'displacements', 'DISPlacement', 'n g u1 u2 u3', last_at)
      end if
    end if
  end subroutine read_vectors

  !> Warn about the increment of the last record, which generates nothing. It is not reported if the
  !! record ends a generation that has the same increment.
  subroutine warn_last(n, step, what, word, fields, place)
    integer, intent(in) :: n, step       !! node and increment of the last record
    character(*), intent(in) :: what     !! what is not generated
    character(*), intent(in) :: word, fields
    type(place_t), intent(in) :: place

    call warn('the increment '//to_text(step)//' of node '//to_text(n)//' generates no '//what &
              //', because no other record follows in its '//word, place, 'give the last node ' &
              //'of the line, too, or give this one the increment 0; records are '//fields)
  end subroutine warn_last

  !> Hint for a value that generation replaces.
  function generated_again(last, step) result(hint)
    integer, intent(in) :: last, step    !! node and increment of the record that generates
    character(:), allocatable :: hint

    hint = 'the increment '//to_text(step)//' of node '//to_text(last)//' generates it again ' &
           //'and replaces the earlier value (FEAP): give the last record of a line the increment 0'
  end function generated_again

  !> Warn, once for each word, if a record of FORCe, DISPlacement or FPROportional replaces what an
  !! earlier one gives to a node.
  subroutine warn_replaced(draft, line, kind, n, hint)
    type(draft_t), intent(inout) :: draft
    type(record_t), intent(in) :: line
    integer, intent(in) :: kind !! C_FORCE, C_VALUE or C_TABLE
    integer, intent(in) :: n
    character(*), intent(in) :: hint
    character(:), allocatable :: word

    if (draft%twice(kind)) return
    draft%twice(kind) = .true.
    word = 'FPROportional'
    if (kind == C_FORCE) word = 'FORCe'
    if (kind == C_VALUE) word = 'DISPlacement'
    call warn(word//' is given twice at node '//to_text(n)//'; further such nodes are not ' &
              //'reported', line%place(1), hint)
  end subroutine warn_replaced

  !> Does a vector replace an earlier one that is not zero and not equal to it?
  pure logical function is_lost(earlier, later)
    real(wp), intent(in) :: earlier(3), later(3)

    is_lost = any(abs(earlier) > 0.0_wp) .and. &
              norm2(later - earlier) > ROUNDING*max(norm2(later), norm2(earlier))
  end function is_lost

  !> Record how many conditions by position precede a record that sets the values of node n.
  pure subroutine note_order(draft, kind, n, acts)
    type(draft_t), intent(inout) :: draft
    integer, intent(in) :: kind !! C_FIXED ...
    integer, intent(in) :: n
    logical, intent(in) :: acts !! the values are not all 0; otherwise none of them can be lost

    draft%nodes%after(kind, n) = merge(draft%ncondition, 0, acts)
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
      call end_set(draft, deck, record, 'nodes are numbered from 1', error)
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
  pure subroutine interpolate_between(x, a, b, increment, again)
    real(wp), intent(inout) :: x(:, :) !! (3, >= max(a, b))
    integer, intent(in) :: a, b, increment
    integer, intent(out) :: again      !! the first column whose earlier value is lost; 0: none
    real(wp) :: dx(3), next(3)
    integer :: n, step

    again = 0
    if (a == 0 .or. increment == 0) return
    step = sign(increment, b - a)
    dx = (x(:, b) - x(:, a))/real((abs(b - a + step) - 1)/abs(step), wp)
    do n = a + step, b, step
      if (n == b) exit
      next = x(:, n - step) + dx
      if (again == 0 .and. is_lost(x(:, n), next)) again = n
      x(:, n) = next
    end do
  end subroutine interpolate_between

end module word_nodal
