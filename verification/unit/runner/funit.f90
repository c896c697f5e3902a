!> The part of pFUnit's module that our unit tests use, with the same calls, and the loop that runs them.
!!
!! A failed assertion is remembered; the translated test returns right after it (anyExceptions).
!! Compiled with -std=gnu: `select rank` is Fortran 2018.
module funit
  use funit_value, only: flat_t, prepare, take_0, take_1, take_2, take_3, length, entry, difference, place, shape_text, text_of, brief, &
                         OTHER, WHOLE, REALS, TRUTH, WORDS
  use, intrinsic :: iso_fortran_env, only: dp => real64, sp => real32, i8 => int64, output_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_is_finite
  implicit none
  private
  public :: SourceLocation, anyExceptions, assertFail
  public :: assertTrue, assertFalse, assertAny, assertAll, assertNone, assertThat, assertIsNaN, assertIsFinite
  public :: start_tests, run_test, stop_tests, no_fixture

  real(dp), parameter :: SLOW = 1.0_dp !! a test above this many seconds is named

  type :: SourceLocation
    character(200) :: file = ''
    integer :: line = 0
  end type SourceLocation

  interface assertTrue
    module procedure true_0, true_1
  end interface assertTrue

  interface assertFalse
    module procedure false_0, false_1
  end interface assertFalse

  abstract interface
    subroutine test_i()
    end subroutine test_i
  end interface

  logical :: failed = .false.               !! in the test that runs
  integer :: npassed = 0, nfailed = 0
  logical :: verbose = .false., only_list = .false.
  character(:), allocatable :: name_now

contains

  ! --- running ---------------------------------------------------------------------------------

  !> Arguments: -v names each test as it starts, -l lists them, words choose tests whose file or name has one of them.
  subroutine start_tests()
    character(200) :: word
    integer :: i

    do i = 1, command_argument_count()
      call get_command_argument(i, word)
      if (word == '-v') verbose = .true.
      if (word == '-l') only_list = .true.
    end do
  end subroutine start_tests

  subroutine run_test(file, name, test, before, after)
    character(*), intent(in) :: file, name
    procedure(test_i) :: test, before, after
    integer(i8) :: tick, tock, rate

    if (.not. chosen(file//' '//name)) return
    if (verbose .or. only_list) call say(file//': '//name)
    if (only_list) return
    failed = .false.
    name_now = name
    call system_clock(tick, rate)
    call before()
    if (.not. failed) call test()
    call after()
    call system_clock(tock)
    if (real(tock - tick, dp) > SLOW*real(rate, dp)) then
      call say('slow: '//file//': '//name//' took '//text_of(real(tock - tick, dp)/real(rate, dp))//' s')
    end if
    if (failed) then
      nfailed = nfailed + 1
    else
      npassed = npassed + 1
    end if
  end subroutine run_test

  subroutine stop_tests()
    if (only_list) return
    call say(text_of(npassed)//' passed, '//text_of(nfailed)//' failed')
    if (nfailed > 0 .or. npassed == 0) stop 1, quiet=.true.
  end subroutine stop_tests

  subroutine no_fixture()
  end subroutine no_fixture

  logical function chosen(text)
    character(*), intent(in) :: text
    character(200) :: word
    logical :: any_word
    integer :: i

    chosen = .false.
    any_word = .false.
    do i = 1, command_argument_count()
      call get_command_argument(i, word)
      if (word(1:1) == '-') cycle
      any_word = .true.
      chosen = chosen .or. index(text, trim(word)) > 0
    end do
    chosen = chosen .or. .not. any_word
  end function chosen

  !> Flushed at once: the last line is there when a test takes the program down.
  subroutine say(text)
    character(*), intent(in) :: text

    write (output_unit, '(a)') text
    flush (output_unit)
  end subroutine say

  logical function anyExceptions()
    anyExceptions = failed
  end function anyExceptions

  subroutine fail(text, message, location)
    character(*), intent(in) :: text
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    character(:), allocatable :: note

    failed = .true.
    note = ''
    if (present(message)) then
      if (len(message) > 0) note = ' ['//message//']'
    end if
    call say(trim(location%file)//':'//text_of(location%line)//': '//name_now//': '//text//note)
  end subroutine fail

  ! --- assertions ------------------------------------------------------------------------------

  subroutine assertFail(message, location)
    character(*), intent(in) :: message
    type(SourceLocation), intent(in) :: location

    call fail(message, location=location)
  end subroutine assertFail

  subroutine true_0(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. condition) call fail('not true', message, location)
  end subroutine true_0

  subroutine true_1(condition, message, location)
    logical, intent(in) :: condition(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. all(condition)) call fail('not true', message, location)
  end subroutine true_1

  subroutine false_0(condition, message, location)
    logical, intent(in) :: condition
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (condition) call fail('not false', message, location)
  end subroutine false_0

  subroutine false_1(condition, message, location)
    logical, intent(in) :: condition(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (any(condition)) call fail('not false', message, location)
  end subroutine false_1

  subroutine assertAll(conditions, message, location)
    logical, intent(in) :: conditions(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. all(conditions)) call fail('not all are true', message, location)
  end subroutine assertAll

  subroutine assertAny(conditions, message, location)
    logical, intent(in) :: conditions(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. any(conditions)) call fail('none is true', message, location)
  end subroutine assertAny

  subroutine assertNone(conditions, message, location)
    logical, intent(in) :: conditions(:)
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (any(conditions)) call fail('one is true', message, location)
  end subroutine assertNone

  subroutine assertIsNaN(x, message, location)
    real(dp), intent(in) :: x
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. ieee_is_nan(x)) call fail(text_of(x)//' is not NaN', message, location)
  end subroutine assertIsNaN

  subroutine assertIsFinite(x, message, location)
    real(dp), intent(in) :: x
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location

    if (.not. ieee_is_finite(x)) call fail(text_of(x)//' is not finite', message, location)
  end subroutine assertIsFinite

  !> @assertEqual, @assertLessThan and their like, by the relation that must hold.
  !!
  !! equal, other than: expected, found; < <= > >=: left and right side. The third argument is a
  !! tolerance (real numbers) or, when it is text, the message.
  !! Assumed-rank arguments are taken apart here: gfortran 12 copies too much when they are passed on.
  subroutine assertThat(relation, one, two, tolerance, message, location)
    character(*), intent(in) :: relation
    class(*), intent(in) :: one(..), two(..)
    class(*), intent(in), optional :: tolerance
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    type(flat_t) :: a, b

    call prepare(a, shape(one))
    if (size(one) > 0) then ! else there may be no storage
      select rank (one)
      rank (0); call take_0(one, a)
      rank (1); call take_1(one, a)
      rank (2); call take_2(one, a)
      rank (3); call take_3(one, a)
      end select
    end if
    call prepare(b, shape(two))
    if (size(two) > 0) then
      select rank (two)
      rank (0); call take_0(two, b)
      rank (1); call take_1(two, b)
      rank (2); call take_2(two, b)
      rank (3); call take_3(two, b)
      end select
    end if
    if (relation == 'equal' .or. relation == 'other than') then
      call compare(relation, a, b, tolerance, message, location)
    else
      call compare(relation, b, a, tolerance, message, location)
    end if
  end subroutine assertThat

  !> Find the first entry that is not as wanted; `third` is a tolerance or a message.
  subroutine compare(relation, e, a, third, message, location)
    character(*), intent(in) :: relation
    type(flat_t), intent(in) :: e, a  !! wanted and found
    class(*), intent(in), optional :: third
    character(*), intent(in), optional :: message
    type(SourceLocation), intent(in) :: location
    character(:), allocatable :: note, bound
    real(dp) :: tolerance
    integer :: i

    tolerance = 0.0_dp
    note = ''
    if (present(message)) note = message
    if (present(third)) then
      select type (third)
      type is (real(dp)); tolerance = third
      type is (real(sp)); tolerance = real(third, dp)
      type is (character(*)); note = third
      end select
    end if
    if (product(e%extent)*product(a%extent) > 0 .and. & ! the type of an empty array is not looked at
        (e%kind == OTHER .or. max(e%kind, REALS) /= max(a%kind, REALS))) then
      call fail('values of two types, or of a type that cannot be compared', note, location)
      return
    end if
    if (size(e%extent) > 0) then
      if (size(e%extent) /= size(a%extent)) then
        call fail('rank '//text_of(size(a%extent))//' instead of '//text_of(size(e%extent)), note, location)
        return
      else if (any(e%extent /= a%extent)) then
        call fail('shape'//shape_text(a%extent)//' instead of'//shape_text(e%extent), note, location)
        return
      end if
    end if
    bound = ''
    if (tolerance > 0.0_dp) bound = ', tolerance '//brief(tolerance)
    do i = 1, length(a)
      if (holds(relation, e, a, merge(1, i, size(e%extent) == 0), i, tolerance)) cycle
      call fail('expected '//relation//' '//entry(e, merge(1, i, size(e%extent) == 0))//', found '//entry(a, i)// &
                difference(e, a, merge(1, i, size(e%extent) == 0), i)//bound//place(a%extent, i), note, location)
      return
    end do
  end subroutine compare

  logical function holds(relation, e, a, i, j, tolerance)
    character(*), intent(in) :: relation
    type(flat_t), intent(in) :: e, a
    integer, intent(in) :: i, j
    real(dp), intent(in) :: tolerance
    logical :: same

    same = .false.
    select case (a%kind)
    case (TRUTH)
      same = e%l(i) .eqv. a%l(j)
    case (WORDS)
      same = trim(adjustl(e%t(i)%s)) == trim(adjustl(a%t(j)%s))
    case default
      if (e%kind == WHOLE .and. a%kind == WHOLE) then
        same = e%n(i) == a%n(j)
      else if (e%x(i) == a%x(j)) then
        same = .true.
      else if (ieee_is_finite(e%x(i)) .and. ieee_is_finite(a%x(j))) then
        same = abs(e%x(i) - a%x(j)) <= tolerance
      end if
    end select
    holds = .false.
    select case (relation)
    case ('equal'); holds = same
    case ('other than'); holds = .not. same
    case default
      if (a%kind > REALS) return
      if (ieee_is_nan(a%x(j)) .or. ieee_is_nan(e%x(i))) return
      if (relation == '<') holds = a%x(j) < e%x(i)
      if (relation == '<=') holds = a%x(j) <= e%x(i)
      if (relation == '>') holds = a%x(j) > e%x(i)
      if (relation == '>=') holds = a%x(j) >= e%x(i)
    end select
  end function holds

end module funit
