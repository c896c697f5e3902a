!> Values by node number, with generation: BOUNdary, FORCe, DISPlacement, FPROportional.
!!
!! FEAP's ways of generation, in which the increment of a record serves the nodes before the next
!! one: FORC and DISP interpolate, FPRO repeats, BOUN repeats negative codes only.
!!
!! Source: FEAPpv's manual
module word_nodal
  use base_kinds, only: wp
  use base_error, only: error_t, place_t
  use boundary, only: note_load_number
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, next_data, check_number
  use input_lists, only: grow_nodes, add_mention
  implicit none
  private
  public :: read_boundary, read_forces, read_displacements, read_load_numbers

contains

  !> BOUNdary: `n g code1 code2 code3`.
  subroutine read_boundary(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    integer :: n, step, last, last_step, code(3)

    call check_count(record, 1, 1, &
                     'BOUNdary stands alone; its data follow: n g code1 code2 code3', error)
    if (allocated(error)) return
    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_integers(build, deck, 'a restraint is: n g code1 code2 code3', n, step, code, error)
      if (allocated(error) .or. n == 0) return
      associate (all => build%nodes%code)
        if (last > 0) where (code == 0 .and. all(:, last) < 0) code = -1
        all(:, n) = code
      end associate
      if (last > 0 .and. last_step /= 0) call repeat_negative(build, last, n, sign(last_step, &
                                                                                   n - last))
    end do
  end subroutine read_boundary

  !> Negative codes go on to the nodes in between.
  subroutine repeat_negative(build, a, b, step)
    type(build_t), intent(inout) :: build
    integer, intent(in) :: a, b, step
    integer :: n

    do n = a + step, b, step
      if (n == b) exit
      where (build%nodes%code(:, n - step) < 0) build%nodes%code(:, n) = -1
    end do
  end subroutine repeat_negative

  !> FPROportional: `n g k1 k2 k3`.
  subroutine read_load_numbers(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(place_t) :: place
    integer :: n, step, last, last_step, number(3), i

    call check_count(record, 1, 1, 'FPROportional stands alone; its data follow: n g k1 k2 k3', &
                     error)
    if (allocated(error)) return
    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_integers(build, deck, 'load numbers are: n g k1 k2 k3', n, step, number, error, &
                         place)
      if (allocated(error) .or. n == 0) return
      do i = 1, 3
        call note_load_number(build%model%bc, abs(number(i)), place)
      end do
      build%nodes%table(:, n) = abs(number)
      if (last == 0 .or. last_step == 0) cycle
      do i = last + sign(last_step, n - last), n, sign(last_step, n - last)
        if (i /= n) build%nodes%table(:, i) = build%nodes%table(:, last)
      end do
    end do
  end subroutine read_load_numbers

  !> One record of whole numbers; n = 0 at the end of the data.
  subroutine read_integers(build, deck, usage, n, step, value, error, place)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    character(*), intent(in) :: usage
    integer, intent(out) :: n, step, value(3)
    type(error_t), allocatable, intent(out) :: error
    type(place_t), intent(out), optional :: place
    type(record_t) :: record
    integer :: d

    value = 0
    call read_head(build, deck, usage, record, n, step, error)
    if (n == 0) return
    if (present(place)) place = record%place(1)
    do d = 1, 3
      if (allocated(error)) return
      call get_integer(deck, record, d + 2, value(d), error, 0)
    end do
  end subroutine read_integers

  !> Number and increment of a record; n = 0 at the end of the data (a blank record, or a
  !! node 0 as in FEAP).
  subroutine read_head(build, deck, usage, record, n, step, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    character(*), intent(in) :: usage
    type(record_t), intent(out) :: record
    integer, intent(out) :: n, step
    type(error_t), allocatable, intent(out) :: error
    logical :: more

    n = 0
    step = 0
    call next_data(build, deck, record, more, error)
    if (allocated(error) .or. .not. more) return
    call get_integer(deck, record, 1, n, error)
    if (allocated(error)) return
    if (n == 0) then
      build%in_set = .false.
      return
    end if
    call check_count(record, 3, 5, usage, error)
    if (allocated(error)) return
    call check_number('node', n, record%place(1), error)
    if (allocated(error)) return
    call get_integer(deck, record, 2, step, error, 0)
    if (allocated(error)) return
    call grow_nodes(build%nodes, n)
    if (.not. build%nodes%given(n)) call add_mention(build%mention, n, record%place(1))
  end subroutine read_head

  !> FORCe: `n g f1 f2 f3`.
  subroutine read_forces(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, 'FORCe stands alone; its data follow: n g f1 f2 f3', error)
    if (.not. allocated(error)) call read_reals(build, deck, 'a force is: n g f1 f2 f3', .true., &
                                                error)
  end subroutine read_forces

  !> DISPlacement: `n g u1 u2 u3`.
  subroutine read_displacements(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error

    call check_count(record, 1, 1, 'DISPlacement stands alone; its data follow: n g u1 u2 u3', &
                     error)
    if (.not. allocated(error)) call read_reals(build, deck, 'a displacement is: n g u1 u2 u3', &
                                                .false., error)
  end subroutine read_displacements

  !> Records of vectors, turned by TRANsform; those in between lie on a straight line.
  subroutine read_reals(build, deck, usage, is_force, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    character(*), intent(in) :: usage
    logical, intent(in) :: is_force
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: record
    integer :: n, step, last, last_step, d
    real(wp) :: x(3)

    n = 0
    step = 0
    do
      last = n
      last_step = step
      call read_head(build, deck, usage, record, n, step, error)
      if (allocated(error) .or. n == 0) return
      do d = 1, 3
        call get_real(deck, record, d + 2, x(d), error, 0.0_wp)
        if (allocated(error)) return
      end do
      x = matmul(build%turn, x)
      if (is_force) then
        build%nodes%force(:, n) = x
      else
        build%nodes%value(:, n) = x
        if (.not. allocated(build%nodes%disp%file)) build%nodes%disp = record%place(1)
      end if
      if (last == 0 .or. last == n .or. last_step == 0) cycle
      if (is_force) then
        call interpolate_between(build%nodes%force, last, n, sign(last_step, n - last))
      else
        call interpolate_between(build%nodes%value, last, n, sign(last_step, n - last))
      end if
    end do
  end subroutine read_reals

  pure subroutine interpolate_between(x, a, b, step)
    real(wp), intent(inout) :: x(:, :)
    integer, intent(in) :: a, b, step
    real(wp) :: dx(3)
    integer :: n

    dx = (x(:, b) - x(:, a))/real((abs(b - a + step) - 1)/abs(step), wp)
    do n = a + step, b, step
      if (n == b) exit
      x(:, n) = x(:, n - step) + dx
    end do
  end subroutine interpolate_between

end module word_nodal
