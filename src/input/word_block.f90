!> BLOCk: a mapped brick of 8-node or 27-node elements.
!!
!!   CARTesian r s t [node1 elmt1 mat type]
!!   [BRICk 8|27]  [MATErial m]
!!   i x y z                  master nodes 1 to 8, others of 9 to 27 where edges or faces curve
!!
!! r s t count increments of nodes; with 27-node elements each spans two, so they are even.
!! A negative elmt1 makes nodes only.
!!
!! Source: FEAPpv's manual
!!
!! Nodes and elements of a BLOCk: a mapped brick.
!!
!! Source: FEAPpv's manual
module word_block
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use input_draft, only: build_t, next_data
  use input_lists, only: add_place, MAX_NUMBER, grow_nodes, grow_elements
  use elmt_q2, only: FEAP27
  implicit none
  private
  public :: read_block, block_spec_t, make_nodes, make_elements

  integer, parameter, public :: BRICK_8 = 10, BRICK_27 = 12 !! FEAP's block types

  !> Position of FEAP's 27 master nodes in tensor order; its element nodes are counted another way.
  integer, parameter :: MASTER27(27) = [1, 3, 9, 7, 19, 21, 27, 25, 10, 12, 18, 16, 2, 6, 8, 4, 5, &
                                        20, 24, 26, 22, 23, 11, 15, 17, 13, 14]

  !> What a BLOCk says.
  type :: block_spec_t
    integer :: n(3) = 0              !! increments of nodes
    integer :: node = 0, element = 0, material = 0, type = 0
    logical :: given(27) = .false.   !! master nodes
    real(wp) :: x(3, 27) = 0.0_wp    !! (3, 27) in FEAP's master order [L]
  end type block_spec_t

contains

  subroutine read_block(build, deck, record, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(error_t), allocatable, intent(out) :: error
    type(block_spec_t) :: spec
    type(record_t) :: line
    logical :: more

    call check_count(record, 1, 1, 'BLOCk stands alone; CARTesian r s t follows', error)
    if (allocated(error)) return
    call next_data(build, deck, line, more, error)
    if (allocated(error)) return
    if (.not. more) then
      call fail(error, DECK_ERROR, 'BLOCk is empty', record%place(1), &
                'CARTesian r s t, then its master nodes')
      return
    end if
    call read_sizes(deck, line, spec, error)
    if (allocated(error)) return
    do
      call next_data(build, deck, line, more, error)
      if (allocated(error)) return
      if (.not. more) exit
      select case (line%key(1))
      case ('bric', 'hexa')
        call read_brick(deck, line, spec, error)
      case ('mate')
        call check_count(line, 2, 2, 'MATErial m', error)
        if (.not. allocated(error)) call get_integer(deck, line, 2, spec%material, error)
      case default
        call read_master(build, deck, line, spec, error)
      end select
      if (allocated(error)) return
      if (.not. build%in_set) exit
    end do
    call check_block(build, record, spec, error)
    if (allocated(error)) return
    call make_nodes(build, spec)
    if (spec%element < 0) return
    call add_place(build%places, record%place(1))
    call make_elements(build, spec)
  end subroutine read_block

  !> CARTesian r s t [node1 elmt1 mat type].
  subroutine read_sizes(deck, record, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: d

    if (record%key(1) /= 'cart') then
      call fail(error, DECK_ERROR, 'unknown kind of BLOCk '//quoted(record%text(1)), &
                record%place(1), &
                'CARTesian r s t [node1 elmt1 material]; other coordinates are not available')
      return
    end if
    call check_count(record, 4, 8, 'CARTesian r s t [node1 elmt1 material type]', error)
    do d = 1, 3
      if (allocated(error)) return
      call get_integer(deck, record, d + 1, spec%n(d), error)
      if (allocated(error)) return
      if (spec%n(d) < 1) then
        call fail(error, DECK_ERROR, 'BLOCk has '//to_text(spec%n(d))//' increments in direction ' &
                  //to_text(d), record%place(d + 1), 'increments are positive')
      end if
    end do
    if (.not. allocated(error)) call get_integer(deck, record, 5, spec%node, error, 0)
    if (.not. allocated(error)) call get_integer(deck, record, 6, spec%element, error, 0)
    if (.not. allocated(error)) call get_integer(deck, record, 7, spec%material, error, 0)
    if (.not. allocated(error)) call get_integer(deck, record, 8, spec%type, error, 0)
    if (allocated(error)) return
    if (spec%type == 0) spec%type = BRICK_8
    if (spec%type /= BRICK_8 .and. spec%type /= BRICK_27) then
      call fail(error, DECK_ERROR, 'BLOCk of type '//to_text(spec%type), record%place(8), &
                'types are 10 (8-node bricks) and 12 (27-node bricks)')
    end if
    if (allocated(error)) return
    if (spec%node < 0) then
      call fail(error, DECK_ERROR, 'BLOCk begins at node '//to_text(spec%node), record%place(5), &
                'node numbers are positive; 0 goes on behind the last one')
    end if
  end subroutine read_sizes

  subroutine read_brick(deck, record, spec, error)
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: n

    call check_count(record, 1, 2, 'BRICk 8 or BRICk 27', error)
    if (allocated(error)) return
    call get_integer(deck, record, 2, n, error, 8)
    if (allocated(error)) return
    select case (n)
    case (8)
      spec%type = BRICK_8
    case (27)
      spec%type = BRICK_27
    case default
      call fail(error, DECK_ERROR, 'BRICk with '//to_text(n)//' nodes', record%place(2), &
                'bricks have 8 or 27 nodes')
    end select
  end subroutine read_brick

  !> `i x y z`; i = 0 ends the data (FEAP).
  subroutine read_master(build, deck, record, spec, error)
    type(build_t), intent(inout) :: build
    type(deck_t), intent(inout) :: deck
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer :: i, d

    call get_integer(deck, record, 1, i, error)
    if (allocated(error)) then
      error%hint = 'a master node is: i x y z; other records are BRICk n and MATErial m'
      return
    end if
    if (i == 0) then
      build%in_set = .false.
      return
    end if
    call check_count(record, 2, 4, 'a master node is: i x y z', error)
    if (allocated(error)) return
    if (i < 1 .or. i > 27) then
      call fail(error, DECK_ERROR, 'master node '//to_text(i), record%place(1), &
                'master nodes are 1 to 27')
      return
    end if
    if (spec%given(i)) then
      call fail(error, DECK_ERROR, 'master node '//to_text(i)//' is given twice', record%place(1))
      return
    end if
    do d = 1, 3
      call get_real(deck, record, d + 1, spec%x(d, i), error, 0.0_wp)
      if (allocated(error)) return
    end do
    spec%given(i) = .true.
  end subroutine read_master

  !> Corners, even increments and sizes; FEAP's defaults of the numbers.
  subroutine check_block(build, record, spec, error)
    type(build_t), intent(inout) :: build
    type(record_t), intent(in) :: record
    type(block_spec_t), intent(inout) :: spec
    type(error_t), allocatable, intent(out) :: error
    integer(i8) :: nnode, nelem
    integer :: i, d

    do i = 1, 8
      if (spec%given(i)) cycle
      call fail(error, DECK_ERROR, 'BLOCk lacks its master node '//to_text(i), record%place(1), &
                'master nodes 1 to 8 are the corners and must be given')
      return
    end do
    if (spec%type == BRICK_27) then
      do d = 1, 3
        if (mod(spec%n(d), 2) == 0) cycle
        call fail(error, DECK_ERROR, 'BLOCk of 27-node bricks has '//to_text(spec%n(d)) &
                  //' increments in direction '//to_text(d), record%place(1), &
                  'each brick spans two increments: give even numbers')
        return
      end do
    end if
    if (spec%node == 0) spec%node = build%last_node + 1
    if (spec%element == 0) spec%element = build%last_element + 1
    if (spec%material == 0) spec%material = max(build%last_material, 1)
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
                //' x '//to_text(spec%n(3))//' increments has too many nodes', record%place(1), &
                'a mesh has at most '//to_text(MAX_NUMBER)//' nodes and elements')
    end if
  end subroutine check_block

  !> All 27 master nodes in tensor order: missing ones by FEAP's rules, straight edges first.
  pure subroutine fill_master(spec, x)
    type(block_spec_t), intent(in) :: spec
    real(wp), intent(out) :: x(3, 3, 3, 3) !! (3, i, j, k)
    real(wp) :: list(3, 27)
    logical :: given(27)
    integer :: i, j, k

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
    if (.not. given(14)) x(:, 2, 2, 2) = 0.25_wp*(sum_edges(x) - sum_corners(x))
  end subroutine fill_master

  !> Middle of a face: half the edges' middles less a quarter of the corners.
  pure subroutine fill_face(x)
    real(wp), intent(inout) :: x(3, 3, 3)

    x(:, 2, 2) = 0.5_wp*(x(:, 2, 1) + x(:, 1, 2) + x(:, 3, 2) + x(:, 2, 3)) &
                 - 0.25_wp*(x(:, 1, 1) + x(:, 3, 1) + x(:, 1, 3) + x(:, 3, 3))
  end subroutine fill_face

  !> Sum that FEAP takes for the middle of the block: edges of its lower and upper faces and the
  !! middles of the four side faces.
  pure function sum_edges(x) result(s)
    real(wp), intent(in) :: x(3, 3, 3, 3)
    real(wp) :: s(3)

    s = x(:, 2, 1, 1) + x(:, 3, 2, 1) + x(:, 2, 3, 1) + x(:, 1, 2, 1) &
        + x(:, 2, 1, 3) + x(:, 3, 2, 3) + x(:, 2, 3, 3) + x(:, 1, 2, 3) &
        + x(:, 2, 1, 2) + x(:, 3, 2, 2) + x(:, 2, 3, 2) + x(:, 1, 2, 2)
  end function sum_edges

  pure function sum_corners(x) result(s)
    real(wp), intent(in) :: x(3, 3, 3, 3)
    real(wp) :: s(3)

    s = sum(sum(sum(x(:, 1:3:2, 1:3:2, 1:3:2), 4), 3), 2)
  end function sum_corners

  !> Nodes on equal steps of the master's parameters, r fastest.
  subroutine make_nodes(build, spec)
    type(build_t), intent(inout) :: build
    type(block_spec_t), intent(in) :: spec
    real(wp) :: x(3, 3, 3, 3), f1(3), f2(3), f3(3), p(3)
    integer :: i, j, k, a, b, c, n

    call fill_master(spec, x)
    n = spec%node + product(spec%n + 1) - 1
    call grow_nodes(build%nodes, n)
    n = spec%node - 1
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
          build%nodes%x(:, n) = matmul(build%turn, p) + build%shift
          build%nodes%given(n) = .true.
          build%nodes%weight(n) = 0.0_wp
        end do
      end do
    end do
    build%nodes%top = max(build%nodes%top, n)
    build%last_node = n
  end subroutine make_nodes

  !> Quadratic functions at step i of n from -1 to 1.
  pure function functions(i, n) result(f)
    integer, intent(in) :: i, n
    real(wp) :: f(3), s

    s = (2*i - n)/real(n, wp)
    f = [0.5_wp*s*(s - 1.0_wp), 1.0_wp - s*s, 0.5_wp*s*(s + 1.0_wp)]
  end function functions

  !> Elements, r fastest; a mirroring TRANsform exchanges their lower and upper faces.
  subroutine make_elements(build, spec)
    type(build_t), intent(inout) :: build
    type(block_spec_t), intent(in) :: spec
    integer :: m, nen, i, j, k, a, b, c, e, at, box(27), node(27)

    m = merge(1, 2, spec%type == BRICK_8)
    nen = merge(8, 27, m == 1)
    call grow_elements(build%elements, spec%element + product(spec%n/m) - 1, nen)
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
          if (mirrored(build%turn)) node(:nen) = swapped(node(:nen))
          e = e + 1
          associate (list => build%elements)
            list%node(:, e) = 0
            list%node(:nen, e) = node(:nen)
            list%nen(e) = nen
            list%material(e) = spec%material
            list%place(e) = build%places%n
          end associate
        end do
      end do
    end do
    build%elements%top = max(build%elements%top, e)
    build%last_element = e
    build%last_material = spec%material
  end subroutine make_elements

  pure logical function mirrored(t)
    real(wp), intent(in) :: t(3, 3)

    mirrored = t(1, 1)*(t(2, 2)*t(3, 3) - t(2, 3)*t(3, 2)) &
               + t(1, 2)*(t(2, 3)*t(3, 1) - t(2, 1)*t(3, 3)) &
               + t(1, 3)*(t(2, 1)*t(3, 2) - t(2, 2)*t(3, 1)) < 0.0_wp
  end function mirrored

  !> Lower and upper face exchanged.
  pure function swapped(node) result(new)
    integer, intent(in) :: node(:)
    integer :: new(size(node))

    new = node
    new(:4) = node(5:8)
    new(5:8) = node(:4)
    if (size(node) == 8) return
    new(9:12) = node(13:16)
    new(13:16) = node(9:12)
    new(21) = node(22)
    new(22) = node(21)
  end function swapped

end module word_block
