!> BLOCk: a mapped block of 8-node or 27-node hexahedra.
!!
!!   CARTesian r s t [node1 elmt1 mat type]
!!   [BRICk 8|27]  [MATErial m]
!!   i x y z                  master nodes 1 to 8, and those of 9 to 27 on curved edges or faces
!!
!! r, s and t count the intervals between nodes. Each 27-node element spans two intervals, so these
!! numbers must be even for such elements. With a negative elmt1 only nodes are made.
!!
!! Source: FEAPpv's manual
module word_block
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_kinds, only: wp, i8
  use base_log, only: warn
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer
  use elmt_q2, only: FEAP27
  use input_doubts, only: twist, TURNED
  use input_draft, only: draft_t, next_data, end_set
  use input_fields, only: get_numbers
  use input_lists, only: add_place, MAX_NUMBER, grow_nodes, grow_elements
  use input_twice, only: replaced_t, note_replaced, warn_replaced, warn_node_twice
  use tensor, only: det3
  implicit none
  private
  public :: read_block

  character(12), parameter, public :: BLOCK_RECORDS(4) = ['CARTesian   ', 'BRICk       ', &
                                                          'HEXA        ', 'MATErial    ']
  integer, parameter :: BRICK_8 = 10, BRICK_27 = 12 !! FEAP's block types

  real(wp), parameter :: SAME = 1.0e-6_wp !! nodes closer than this times the size of the block are
  !! at the same position

  !> Positions of FEAP's 27 master nodes in tensor order; FEAP's element nodes have another order.
  integer, parameter :: MASTER27(27) = [1, 3, 9, 7, 19, 21, 27, 25, 10, 12, 18, 16, 2, 6, 8, 4, 5, &
                                        20, 24, 26, 22, 23, 11, 15, 17, 13, 14]
  !> Element nodes with the lower and the upper face exchanged; the first 8 also serve for 8-node
  !! elements.
  integer, parameter :: MIRRORED(27) = [5, 6, 7, 8, 1, 2, 3, 4, 13, 14, 15, 16, 9, 10, 11, 12, 17, &
                                        18, 19, 20, 22, 21, 23, 24, 25, 26, 27]

  !> Master nodes in the middle of the four edges along each direction.
  integer, parameter :: MIDDLE(4, 3) = reshape([13, 15, 18, 20, 14, 16, 19, 21, 9, 10, 11, 12], &
                                               [4, 3])

  type :: block_spec_t
    integer :: n(3) = 0              !! intervals between nodes
    integer :: node = 0, element = 0, material = 0, type = 0
    logical :: given(27) = .false.   !! master nodes that are given
    real(wp) :: x(3, 27) = 0.0_wp    !! (3, 27) master nodes in FEAP's order [L]
  end type block_spec_t

contains

  !> Read BLOCk and its records. A master node 0 ends the records in the same way as a blank record
  !! (FEAP).
  subroutine read_block(draft, deck, record, error)
    type(draft_t), intent(inout) :: draft
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(block_spec_t) :: spec
    type(record_t) :: line
    logical :: more, twice
    integer :: given(2) ! numbers of the material and of the type that the records give; 0: none
    logical :: short(27)    ! coordinates of the master node are missing
    type(place_t) :: at(27) ! of each master node
    integer :: i

    short = .false.
    call check_count(record, 1, 1, "BLOCk has no options; a record 'CARTesian r s t' follows", &
                     error)
    if (.not. allocated(error)) call next_data(draft, deck, line, more, error)
    if (allocated(error)) return
    if (.not. more) then
      call fail(error, DECK_ERROR, 'BLOCk has no records', record%place(1), &
                "give 'CARTesian r s t', then the master nodes")
      return
    end if
    call read_sizes(deck, line, spec, error)
    if (allocated(error)) return
    given = [spec%material, 0]
    if (.not. line%is_empty(8)) given(2) = spec%type
    do
      call next_data(draft, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      select case (line%key(1))
      case ('bric', 'hexa')
        call check_count(line, 1, 2, 'BRICk 8 or BRICk 27', error)
        if (.not. allocated(error)) call get_integer(deck, line, 2, i, error, 8)
        if (allocated(error)) return
        spec%type = merge(BRICK_8, BRICK_27, i == 8)
        twice = given(2) > 0 .and. given(2) /= spec%type
        given(2) = spec%type
        if (twice) call fail_twice(line, 'type', error)
        if (i /= 8 .and. i /= 27) call fail(error, DECK_ERROR, 'BRICk has '//to_text(i) &
                                            //' nodes', line%place(2), &
                                            'give BRICk 8 or BRICk 27')
      case ('mate')
        call check_count(line, 2, 2, 'MATErial m', error)
        if (.not. allocated(error)) call get_integer(deck, line, 2, spec%material, error)
        if (allocated(error)) return
        twice = given(1) > 0 .and. given(1) /= spec%material
        given(1) = spec%material
        if (twice) call fail_twice(line, 'material', error)
      case default
        call get_integer(deck, line, 1, i, error)
        if (allocated(error)) error%hint = "write a master node as 'i x y z'; other records are " &
                                           //"'BRICk n' and 'MATErial m'"
        if (allocated(error)) return
        if (i == 0) then
          call end_set(draft, deck, line, 'master nodes are numbered from 1', error)
          if (allocated(error)) return
          exit
        end if
        call check_count(line, 2, 4, "write a master node as 'i x y z'", error)
        if (allocated(error)) return
        if (i < 1 .or. i > 27) then
          call fail(error, DECK_ERROR, 'unknown master node '//to_text(i), line%place(1), &
                    'master nodes are 1 to 27')
        else if (spec%given(i)) then
          call fail(error, DECK_ERROR, 'duplicate master node '//to_text(i), line%place(1), &
                    'keep one of them')
        else
          spec%given(i) = .true.
          short(i) = any([line%is_empty(2), line%is_empty(3), line%is_empty(4)])
          at(i) = line%place(1)
          call get_numbers(deck, line, 2, spec%x(:, i), error, 0.0_wp)
        end if
      end select
      if (allocated(error)) return
    end do
    call check_block(draft, record, spec, error)
    if (allocated(error)) return
    call warn_short(spec, short, at)
    call warn_twisted_block(spec, record%place(1))
    call make_nodes(draft, spec, record%place(1))
    if (spec%element < 0) return
    call add_place(draft%places, record%place(1))
    call make_elements(draft, spec)
  end subroutine read_block

  !> Fail because a record gives a block another material or type than an earlier one.
  subroutine fail_twice(line, what, error)
    type(record_t), intent(in) :: line
    character(*), intent(in) :: what
    type(error_t), allocatable, intent(out) :: error

    call fail(error, DECK_ERROR, 'the '//what//' of this BLOCk is given twice', line%place(1), &
              'keep one of the records, or the number in CARTesian')
  end subroutine fail_twice

  !> Read CARTesian r s t [node1 elmt1 mat type].
  subroutine read_sizes(deck, record, spec, error)
    type(deck_t), intent(in) :: deck
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    character(*), parameter :: USAGE = 'CARTesian r s t [node1 elmt1 material type]'
    integer :: d, n(4)

    if (record%key(1) /= 'cart') then
      call fail(error, DECK_ERROR, 'expected CARTesian, found '//quoted(record%text(1)), &
                record%place(1), USAGE//'; other coordinates are not available')
      return
    end if
    call check_count(record, 4, 8, USAGE, error)
    if (.not. allocated(error)) call get_numbers(deck, record, 2, spec%n, error)
    if (allocated(error)) return
    d = findloc(spec%n < 1, .true., 1)
    if (d > 0) then
      call fail(error, DECK_ERROR, 'BLOCk has '//to_text(spec%n(d))//' increments in direction ' &
                //to_text(d), record%place(d + 1), 'give at least 1 increment')
      return
    end if
    call get_numbers(deck, record, 5, n, error, 0)
    if (allocated(error)) return
    spec%node = n(1)
    spec%element = n(2)
    spec%material = n(3)
    spec%type = n(4)
    if (spec%type == 0) spec%type = BRICK_8
    if (spec%type /= BRICK_8 .and. spec%type /= BRICK_27) then
      call fail(error, DECK_ERROR, 'unknown type '//to_text(spec%type)//' of BLOCk', &
                record%place(8), 'types are 10 (8-node bricks) and 12 (27-node bricks)')
    else if (spec%node < 0) then
      call fail(error, DECK_ERROR, 'the first node of BLOCk is '//to_text(spec%node), &
                record%place(5), 'give a positive number, or 0 to continue after the last node')
    end if
  end subroutine read_sizes

  !> Check corners, intervals and size, and set FEAP's default numbers.
  subroutine check_block(draft, record, spec, error)
    type(draft_t), intent(inout) :: draft
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer(i8) :: nnode, nelem
    integer :: i, d

    do i = 1, 8
      if (spec%given(i)) cycle
      call fail(error, DECK_ERROR, 'BLOCk has no master node '//to_text(i), record%place(1), &
                'give master nodes 1 to 8, the corners')
      return
    end do
    if (spec%type == BRICK_27) then
      do d = 1, 3
        if (mod(spec%n(d), 2) == 0) cycle
        call fail(error, DECK_ERROR, 'the number of intervals of a BLOCk of 27-node bricks in ' &
                  //'direction '//to_text(d)//' is '//to_text(spec%n(d)), record%place(1), &
                  'give an even number: each brick spans two intervals')
        return
      end do
    end if
    if (spec%node == 0) spec%node = draft%last_node + 1
    if (spec%element == 0) spec%element = draft%last_element + 1
    if (spec%material == 0) spec%material = max(draft%last_material, 1)
    nnode = spec%node - 1_i8
    nelem = max(spec%element - 1_i8, 0_i8)
    if (product(real(spec%n, wp) + 1.0_wp) <= real(MAX_NUMBER, wp)) then
      nnode = nnode + product(int(spec%n, i8) + 1_i8)
      nelem = nelem + product(int(spec%n, i8))
    else
      nnode = MAX_NUMBER + 1_i8
    end if
    if (max(nnode, nelem) > MAX_NUMBER) then
      call fail(error, DECK_ERROR, 'BLOCk of '//to_text(spec%n(1))//' x '//to_text(spec%n(2)) &
                //' x '//to_text(spec%n(3))//' increments gives node or element numbers above ' &
                //to_text(MAX_NUMBER), record%place(1), 'use fewer increments, or smaller ' &
                //'numbers of the first node and element')
    end if
  end subroutine check_block

  !> Warn about a master node with missing coordinates, which are 0, at the position of another one.
  subroutine warn_short(spec, short, at)
    type(block_spec_t), intent(in) :: spec
    logical, intent(in) :: short(:)      !! coordinates of the master node are missing
    type(place_t), intent(in) :: at(:)   !! of each master node
    integer :: i, j

    do i = 1, size(short)
      if (.not. short(i)) cycle
      do j = 1, size(short)
        if (j == i .or. .not. spec%given(j)) cycle
        if (any(abs(spec%x(:, i) - spec%x(:, j)) > 0.0_wp)) cycle
        call warn('master node '//to_text(i)//' has fewer than three coordinates, and lies in ' &
                  //'the place of master node '//to_text(j), at(i), 'missing coordinates are 0: ' &
                  //'give all three of them')
        return
      end do
    end do
  end subroutine warn_short

  !> Warn about a block with opposite faces that are turned against each other by about 90 degrees.
  !! Since the edges between them are straight, the section in the middle has only about half of the
  !! area of the faces, whatever the number of elements is; nobody describes a twisted bar in this
  !! way. If there is only one element between the faces, warn_twisted names it.
  subroutine warn_twisted_block(spec, place)
    type(block_spec_t), intent(in) :: spec
    type(place_t), intent(in) :: place
    real(wp) :: angle(3)
    integer :: d

    angle = twist(spec%x(:, :8))
    do d = 1, 3
      if (any(spec%given(MIDDLE(:, d)))) angle(d) = 0.0_wp
      if (spec%n(d) == merge(1, 2, spec%type == BRICK_8)) angle(d) = 0.0_wp
    end do
    if (maxval(angle) < TURNED) return
    call warn('this block is twisted: opposite faces are rotated by '//to_text(maxval(angle), 3) &
              //' degrees relative to each other, and straight edges join them', place, &
              'list the corners of both faces in the same order: master node 5 must lie opposite ' &
              //'1, and 6 opposite 2; for a bar that is twisted, give the middles of its edges')
  end subroutine warn_twisted_block

  !> Make nodes at equal intervals of the parameters of the master block; r varies fastest. Missing
  !! master nodes follow FEAP's rules: edges are straight, and the centres of the faces
  !! and of the block are interpolated.
  subroutine make_nodes(draft, spec, place)
    type(draft_t), intent(inout) :: draft
    type(block_spec_t), intent(in) :: spec
    type(place_t), intent(in) :: place !! of BLOCk
    real(wp) :: list(3, 27), x(3, 3, 3, 3), edges(3), corners(3), f1(3), f2(3), f3(3), p(3)
    real(wp) :: corner(3, 8), extent
    logical :: given(27)
    integer :: i, j, k, a, b, c, n

    list(:, MASTER27) = spec%x
    given(MASTER27) = spec%given
    x = reshape(list, [3, 3, 3, 3])
    do k = 1, 3
      do j = 1, 3
        do i = 1, 3
          if (count([i, j, k] == 2) /= 1 .or. given(i + 3*(j - 1) + 9*(k - 1))) cycle
          if (i == 2) x(:, 2, j, k) = 0.5_wp*(x(:, 1, j, k) + x(:, 3, j, k))
          if (j == 2) x(:, i, 2, k) = 0.5_wp*(x(:, i, 1, k) + x(:, i, 3, k))
          if (k == 2) x(:, i, j, 2) = 0.5_wp*(x(:, i, j, 1) + x(:, i, j, 3))
        end do
      end do
    end do
    do i = 1, 3, 2
      if (.not. given(i + 12)) call fill_face(x(:, i, :, :))
      if (.not. given(3*i + 8)) call fill_face(x(:, :, i, :))
      if (.not. given(9*i - 4)) call fill_face(x(:, :, :, i))
    end do
    if (.not. given(14)) then ! FEAP: mid-edges of faces 3- and 3+, centres of the others
      edges = x(:, 2, 1, 1) + x(:, 3, 2, 1) + x(:, 2, 3, 1) + x(:, 1, 2, 1) &
              + x(:, 2, 1, 3) + x(:, 3, 2, 3) + x(:, 2, 3, 3) + x(:, 1, 2, 3) &
              + x(:, 2, 1, 2) + x(:, 3, 2, 2) + x(:, 2, 3, 2) + x(:, 1, 2, 2)
      corners = sum(sum(sum(x(:, 1:3:2, 1:3:2, 1:3:2), 4), 3), 2)
      x(:, 2, 2, 2) = 0.25_wp*(edges - corners)
    end if
    call grow_nodes(draft%nodes, spec%node + product(spec%n + 1) - 1)
    n = spec%node - 1
    corner = reshape(x(:, 1:3:2, 1:3:2, 1:3:2), [3, 8])
    extent = norm2(draft%turn)*maxval(maxval(corner, 2) - minval(corner, 2))
    if (allocated(draft%idle_transform)) deallocate (draft%idle_transform)
    do k = 0, spec%n(3)
      f3 = functions(k, spec%n(3))
      do j = 0, spec%n(2)
        f2 = functions(j, spec%n(2))
        do i = 0, spec%n(1)
          f1 = functions(i, spec%n(1))
          p = 0.0_wp
          do c = 1, 3
            do b = 1, 3
              do a = 1, 3
                p = p + f1(a)*f2(b)*f3(c)*x(:, a, b, c)
              end do
            end do
          end do
          n = n + 1
          p = matmul(draft%turn, p) + draft%shift
          if (norm2(draft%nodes%x(:, n) - p) > SAME*extent) then ! blocks may share nodes
            call warn_node_twice(draft, place, n, 'BLOCk replaces the earlier nodes: give ' &
                                 //'another node1, or 0 to continue after the last node')
          end if
          draft%nodes%x(:, n) = p
          draft%nodes%given(n) = .true.
          draft%nodes%weight(n) = 0.0_wp
        end do
      end do
    end do
    draft%nodes%top = max(draft%nodes%top, n)
    draft%last_node = n
  end subroutine make_nodes

  !> Set the centre of a face: half the sum of its mid-edge nodes minus a quarter of the sum of its
  !! corners.
  pure subroutine fill_face(x)
    real(wp), intent(inout) :: x(3, 3, 3)

    x(:, 2, 2) = 0.5_wp*(x(:, 2, 1) + x(:, 1, 2) + x(:, 3, 2) + x(:, 2, 3)) &
                 - 0.25_wp*(x(:, 1, 1) + x(:, 3, 1) + x(:, 1, 3) + x(:, 3, 3))
  end subroutine fill_face

  !> Quadratic functions at point i of the n+1 points from -1 to 1.
  pure function functions(i, n) result(f)
    integer, intent(in) :: i, n
    real(wp) :: f(3), s

    s = (2*i - n)/real(n, wp)
    f = [0.5_wp*s*(s - 1.0_wp), 1.0_wp - s*s, 0.5_wp*s*(s + 1.0_wp)]
  end function functions

  !> Make the elements; r varies fastest. If TRANsform is a reflection, their lower and upper faces
  !! are exchanged.
  subroutine make_elements(draft, spec)
    type(draft_t), intent(inout) :: draft
    type(block_spec_t), intent(in) :: spec
    type(replaced_t) :: replaced
    integer :: m, nen, i, j, k, a, b, c, e, at, box(27), node(27)

    m = merge(1, 2, spec%type == BRICK_8)
    nen = merge(8, 27, m == 1)
    call grow_elements(draft%elements, spec%element + product(spec%n/m) - 1, nen)
    e = spec%element - 1
    do k = 0, spec%n(3) - m, m
      do j = 0, spec%n(2) - m, m
        do i = 0, spec%n(1) - m, m
          at = 0
          do c = k, k + m
            do b = j, j + m
              do a = i, i + m
                at = at + 1
                box(at) = spec%node + a + (spec%n(1) + 1)*(b + (spec%n(2) + 1)*c)
              end do
            end do
          end do
          if (m == 1) then
            node(:8) = box([1, 2, 4, 3, 5, 6, 8, 7])
          else
            node = box(FEAP27)
          end if
          if (det3(draft%turn) < 0.0_wp) node(:nen) = node(MIRRORED(:nen))
          e = e + 1
          call note_replaced(draft, e, draft%places%at(draft%places%n), replaced)
          associate (list => draft%elements)
            list%node(:, e) = 0
            list%node(:nen, e) = node(:nen)
            list%nen(e) = nen
            list%material(e) = spec%material
            list%place(e) = draft%places%n
          end associate
        end do
      end do
    end do
    call warn_replaced('BLOCk', replaced, 'the later elements replace those with the same ' &
                       //'numbers: give another elmt1, or 0 to continue after the last element')
    draft%elements%top = max(draft%elements%top, e)
    draft%last_element = e
    draft%last_material = spec%material
  end subroutine make_elements

end module word_block
