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
module setup_block
  use base_kinds, only: wp, i8
  use base_error, only: error_t, fail, DECK_ERROR
  use base_text, only: to_text, quoted
  use deck_record, only: record_t, check_count
  use deck_stream, only: deck_t, get_integer, get_real
  use setup_block_mesh, only: block_spec_t, make_nodes, make_elements, BRICK_8, BRICK_27
  use setup_build, only: build_t, next_data
  use setup_lists, only: add_place, MAX_NUMBER
  implicit none
  private
  public :: read_block

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

end module setup_block
