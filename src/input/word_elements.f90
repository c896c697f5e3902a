!> ELEMents: connections by number, with generation.
!!
!! A record is `n g m i j k ...`: number, increment of the node numbers for the elements generated
!! behind it, material, nodes. `ELEMents,OLD` puts the increment behind the nodes; `MATErial m`
!! behind ELEMents overrides the material. FEAP reads 16 numbers a record: 27 nodes go on in a
!! second one.
!!
!! Source: FEAPpv's manual
module word_elements
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use element_table, only: load_elements
  use element_type, only: element_t
  use input_draft, only: build_t, next_data, check_number
  use input_lists, only: grow_elements, add_place
  implicit none
  private
  public :: read_elements

  integer, parameter :: FEAP_FIELDS = 16 !! numbers of a record in FEAP
  character(*), parameter :: USAGE = 'an element is: n g m and its 4, 5, 6, 8, 10 or ' &
                             //'27 nodes'

  !> One record.
  type :: entry_t
    integer :: number = 0, step = 0, material = 0, nen = 0, place = 0
    integer :: node(27) = 0
  end type entry_t

contains

  !> ELEMents [OLD] [MATErial m].
  subroutine read_elements(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(entry_t) :: e, last
    type(element_t), allocatable :: rows(:)
    logical :: more, old
    integer :: material

    call load_elements(rows)
    call read_options(deck, record, old, material, error)
    if (allocated(error)) return
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error) .or. .not. more) return
      last = e
      call read_entry(build, deck, line, old, rows%deck_nodes, e, error)
      if (allocated(error) .or. e%number == 0) return
      if (material > 0) e%material = material
      if (e%number <= last%number) then
        call fail(error, DECK_ERROR, 'element '//to_text(e%number)//' stands behind element ' &
                  //to_text(last%number), line%place(1), 'list the elements in rising order')
        return
      end if
      if (last%number > 0) call generate(build, last, e%number, line, error)
      if (allocated(error)) return
      call store(build, e, line, error)
      if (allocated(error)) return
    end do
  end subroutine read_elements

  subroutine read_options(deck, record, old, material, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    logical, intent(out) :: old
    integer, intent(out) :: material
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    old = .false.
    material = 0
    i = 2
    do while (i <= record%n)
      select case (record%key(i))
      case ('old')
        old = .true.
      case ('mate')
        i = i + 1
        call get_integer(deck, record, i, material, error)
        if (allocated(error)) return
      case default
        call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(i))//' of ELEMents', &
                  record%place(i), 'options are OLD and MATErial m')
        return
      end select
      i = i + 1
    end do
  end subroutine read_options

  !> One element; number 0 ends the data as a blank record does (FEAP).
  subroutine read_entry(build, deck, record, old, allowed, e, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    logical, intent(in) :: old
    integer, intent(in) :: allowed(:) !! numbers of nodes that elements have
    type(entry_t), intent(out) :: e
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: field(:)
    integer :: i, n

    call get_integer(deck, record, 1, e%number, error)
    if (allocated(error)) return
    if (e%number == 0) then
      build%in_set = .false.
      return
    end if
    call check_number('element', e%number, record%place(1), error)
    if (allocated(error)) return
    call collect(build, deck, record, merge(2, 3, old) + minval(allowed, allowed > 0), field, error)
    if (allocated(error)) return
    if (old) then
      e%material = field(2)
      call split_old(build%control%nen, allowed, record, field, e%step, error)
      if (allocated(error)) return
    else
      e%step = field(2)
      e%material = field(3)
      field = field(4:)
    end if
    n = 0
    do i = 1, size(field)
      if (field(i) /= 0) n = i
    end do
    e%nen = n
    if (n == 0 .or. .not. any(allowed == n)) then
      call fail(error, DECK_ERROR, 'element '//to_text(e%number)//' has '//to_text(n)//' nodes', &
                record%place(1), USAGE)
      return
    end if
    e%node(:n) = field(:n)
    if (e%step == 0) e%step = 1
  end subroutine read_entry

  !> ELEMents,OLD has n m nodes g: is the last number that is there the increment?
  subroutine split_old(nen, allowed, record, field, step, error)
    integer, intent(in) :: nen                       !! of the control record; 0: it does not say
    integer, intent(in) :: allowed(:)
    type(record_t), intent(in) :: record
    integer, allocatable, intent(inout) :: field(:)  !! out: the nodes
    integer, intent(out) :: step                     !! 0: not there
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    step = 0
    n = size(field) - 2
    if (any(allowed == n - 1) .and. (n == nen + 1 .or. .not. any(allowed == n))) then
      step = field(n + 2)
      n = n - 1
    else if (any(allowed == n - 1) .and. nen == 0) then
      call fail(error, DECK_ERROR, to_text(n)//' nodes, or '//to_text(n - 1) &
                //' and an increment?', record%place(1), &
                'give the control record with nen, or n g m and the nodes without OLD')
    end if
    field = field(3:n + 2)
  end subroutine split_old

  !> All numbers of an element: those of its first record, and of a second where FEAP needs one.
  subroutine collect(build, deck, first, least, field, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: first
    integer, intent(in) :: least !! fields of a record
    integer, allocatable, intent(out) :: field(:)
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: second
    integer :: i
    logical :: more, goes_on

    call check_count(first, least, 31, USAGE, error)
    if (allocated(error)) return
    allocate (field(first%n))
    do i = 1, first%n
      call get_integer(deck, first, i, field(i), error, 0)
      if (allocated(error)) return
    end do
    goes_on = first%n == FEAP_FIELDS
    if (build%control%nen > 13) goes_on = first%n <= FEAP_FIELDS
    if (.not. goes_on) return
    call next_data(build, deck, second, more, error)
    if (allocated(error)) return
    build%in_set = .true. ! a blank second record is one of zeros
    if (.not. more) return
    call check_count(second, 1, FEAP_FIELDS, &
                     'the second record of an element holds its other nodes', error)
    if (allocated(error)) return
    field = [field, [(0, i=first%n + 1, FEAP_FIELDS)], [(0, i=1, second%n)]]
    do i = 1, second%n
      call get_integer(deck, second, i, field(FEAP_FIELDS + i), error, 0)
      if (allocated(error)) return
    end do
  end subroutine collect

  !> Elements between the last one and the next.
  subroutine generate(build, last, next, record, error)
    type(build_t), intent(inout) :: build
    type(entry_t), intent(in) :: last
    integer, intent(in) :: next
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(entry_t) :: e

    e = last
    do
      e%number = e%number + 1
      if (e%number >= next) exit
      where (e%node > 0) e%node = e%node + last%step
      call store(build, e, record, error)
      if (allocated(error)) return
    end do
  end subroutine generate

  subroutine store(build, e, record, error)
    type(build_t), intent(inout) :: build
    type(entry_t), intent(inout) :: e
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, e%nen
      if (e%node(i) > 0) cycle
      call fail(error, DECK_ERROR, 'node '//to_text(i)//' of element '//to_text(e%number)//' is ' &
                //to_text(e%node(i)), record%place(1), 'node numbers are positive')
      return
    end do
    if (e%place == 0) then
      call add_place(build%places, record%place(1))
      e%place = build%places%n
    end if
    call grow_elements(build%elements, e%number, e%nen)
    associate (list => build%elements)
      list%node(:, e%number) = 0
      list%node(:e%nen, e%number) = e%node(:e%nen)
      list%nen(e%number) = e%nen
      list%material(e%number) = e%material
      list%place(e%number) = e%place
      list%top = max(list%top, e%number)
    end associate
    build%last_element = max(build%last_element, e%number)
  end subroutine store

end module word_elements
