!> ELEMents: connectivities by element number, with generation.
!!
!! A record is `n g m i j k ...`: number, increment of the node numbers for the elements generated
!! after it, material, nodes. With `ELEMents,OLD` the increment follows the nodes; `MATErial m`
!! after ELEMents overrides the material. FEAP reads 16 numbers from a record, so an element with
!! more than 13 nodes continues in a second record. The table of elements defines the possible
!! numbers of nodes.
!!
!! Source: FEAPpv's manual
module word_elements
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use element_table, only: load_elements
  use element_type, only: element_t
  use input_draft, only: draft_t, last_element_t, next_data, end_set, check_number, &
                         check_increment
  use input_lists, only: grow_elements, add_place
  use input_twice, only: replaced_t, note_replaced, warn_replaced
  use mesh_shape, only: node_counts
  implicit none
  private
  public :: read_elements

  integer, parameter :: FEAP_FIELDS = 16 !! numbers in a record of FEAP

  !> One record.
  type :: entry_t
    integer :: number = 0, increment = 0, material = 0, place = 0
    integer :: given = 0 !! the increment in the record
    integer, allocatable :: node(:)
  end type entry_t

contains

  !> Read ELEMents [OLD] [MATErial m] and its records.
  subroutine read_elements(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: line
    type(entry_t) :: e, last
    type(element_t), allocatable :: rows(:)
    type(replaced_t) :: replaced
    logical :: more, old
    integer :: i, material ! 0: not given

    call load_elements(rows)
    old = .false.
    material = 0
    i = 2
    do while (i <= record%n)
      select case (record%key(i))
      case ('old')
        old = .true.
      case ('mate')
        if (material > 0) then
          call fail(error, DECK_ERROR, 'duplicate option MATErial of ELEMents', record%place(i), &
                    'keep one of them')
          return
        end if
        i = i + 1
        call get_integer(deck, record, i, material, error)
        if (allocated(error)) return
        if (material < 1) then
          call fail(error, DECK_ERROR, 'material '//to_text(material)//' is not positive', &
                    record%place(i), 'ELEMents,MATErial,m gives all its elements the material m')
          return
        end if
      case default
        call fail(error, DECK_ERROR, 'unknown option '//quoted(record%text(i))//' of ELEMents', &
                  record%place(i), 'options are OLD and MATErial m')
        return
      end select
      i = i + 1
    end do
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      call read_entry(draft, deck, line, old, pack(rows%deck_nodes, rows%deck_nodes > 0), e, error)
      if (allocated(error)) return
      if (e%number == 0) exit
      if (material > 0) e%material = material
      if (e%number <= last%number) then
        call fail(error, DECK_ERROR, 'element '//to_text(e%number)//' follows element ' &
                  //to_text(last%number), line%place(1), 'list the elements in increasing order')
        return
      end if
      do while (last%number > 0 .and. last%number < e%number - 1) ! generate the elements in between
        last%number = last%number + 1
        where (last%node > 0) last%node = last%node + last%increment
        call store(draft, last, line, replaced, error)
        if (allocated(error)) return
      end do
      call store(draft, e, line, replaced, error)
      if (allocated(error)) return
      last = e
    end do
    if (last%given /= 0) then
      draft%last_of_set = [draft%last_of_set, last_element_t(last%number, last%given, last%place)]
    end if
    call warn_replaced('ELEMents', replaced, 'the later elements replace those with the same ' &
                       //'numbers: give them other numbers')
  end subroutine read_elements

  !> Read one element. The number 0 ends the data in the same way as a blank record (FEAP).
  subroutine read_entry(draft, deck, record, old, counts, e, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    logical, intent(in) :: old
    integer, intent(in) :: counts(:) !! possible numbers of nodes
    type(entry_t), intent(out) :: e
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: usage
    integer, allocatable :: field(:)
    integer :: n, nen

    call get_integer(deck, record, 1, e%number, error)
    if (allocated(error)) return
    if (e%number == 0) then
      call end_set(draft, deck, record, 'elements are numbered from 1', error)
      return
    end if
    call check_number('element', e%number, record%place(1), error)
    if (allocated(error)) return
    usage = "write an element as 'n g m' and its "//node_counts(counts)//' nodes'
    if (old) usage = "write an element as 'n m', its "//node_counts(counts)//' nodes and, if it ' &
                     //'is needed, the increment g'
    call collect_numbers(draft, deck, record, merge(2, 3, old) + minval(counts), &
                         4 + maxval(counts), usage, field, error)
    if (allocated(error)) return
    if (old) then ! n m nodes [g]: is the last number the increment?
      e%material = field(2)
      n = size(field) - 2
      nen = draft%control%nen ! 0: the control record does not give nen
      if (any(counts == n - 1) .and. (n == nen + 1 .or. .not. any(counts == n))) then
        e%increment = field(n + 2)
        n = n - 1
      else if (any(counts == n - 1) .and. nen == 0) then
        call fail(error, DECK_ERROR, 'the record may mean '//to_text(n)//' nodes, or ' &
                  //to_text(n - 1)//' nodes and an increment', record%place(1), &
                  "give nen in the control record, or remove OLD and write 'n g m' and the nodes")
        return
      end if
      field = field(3:n + 2)
    else
      e%increment = field(2)
      e%material = field(3)
      field = field(4:)
    end if
    n = findloc(field /= 0, .true., 1, back=.true.)
    if (.not. any(counts == n)) then
      call fail(error, DECK_ERROR, 'element '//to_text(e%number)//' has '//to_text(n)//' nodes', &
                record%place(1), usage)
      return
    end if
    e%node = field(:n)
    call check_increment(e%increment, record%place(merge(1, 2, old)), error)
    if (allocated(error)) return
    e%given = e%increment
    if (e%increment == 0) e%increment = 1
  end subroutine read_entry

  !> Collect all numbers of an element: those of its first record, and those of a second one if the
  !! first has 16 numbers or, as in FEAP, if `nen` of the control record is larger than 13 and the
  !! first has at most 16.
  subroutine collect_numbers(draft, deck, first, least, most, usage, field, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: first
    integer, intent(in) :: least, most !! fields of a record
    character(*), intent(in) :: usage
    integer, allocatable, intent(out) :: field(:)
    type(error_t), allocatable, intent(out) :: error
    type(record_t) :: second
    integer :: i
    logical :: more, continues

    call check_count(first, least, most, usage, error)
    if (allocated(error)) return
    allocate (field(first%n))
    do i = 1, first%n
      call get_integer(deck, first, i, field(i), error, 0)
      if (allocated(error)) return
    end do
    continues = first%n == FEAP_FIELDS
    if (draft%control%nen > FEAP_FIELDS - 3) continues = first%n <= FEAP_FIELDS
    if (.not. continues) return
    call next_data(draft, deck, second, more, error)
    if (allocated(error)) return
    draft%in_set = .true. ! a blank second record consists of zeros
    if (.not. more) return
    call check_count(second, 1, FEAP_FIELDS, &
                     'write the other nodes of the element in its second record', error)
    if (allocated(error)) return
    field = [field, [(0, i=first%n + 1, FEAP_FIELDS)], [(0, i=1, second%n)]]
    do i = 1, second%n
      call get_integer(deck, second, i, field(FEAP_FIELDS + i), error, 0)
      if (allocated(error)) return
    end do
  end subroutine collect_numbers

  !> Store an element in the list of the draft.
  subroutine store(draft, e, record, replaced, error)
    type(draft_t), intent(inout) :: draft
    type(entry_t), intent(inout) :: e
    type(record_t), intent(in) :: record
    type(replaced_t), intent(inout) :: replaced
    type(error_t), allocatable, intent(out) :: error
    integer :: i, nen

    nen = size(e%node)
    do i = 1, nen
      if (e%node(i) > 0) cycle
      call fail(error, DECK_ERROR, 'node '//to_text(i)//' of element '//to_text(e%number)//' is ' &
                //to_text(e%node(i)), record%place(1), 'node numbers must be positive')
      return
    end do
    if (e%place == 0) then
      call add_place(draft%places, record%place(1))
      e%place = draft%places%n
    end if
    call grow_elements(draft%elements, e%number, nen)
    call note_replaced(draft, e%number, record%place(1), replaced)
    associate (list => draft%elements)
      list%node(:, e%number) = 0
      list%node(:nen, e%number) = e%node
      list%nen(e%number) = nen
      list%material(e%number) = e%material
      list%place(e%number) = e%place
      list%top = max(list%top, e%number)
    end associate
    draft%last_element = max(draft%last_element, e%number)
  end subroutine store

end module word_elements
