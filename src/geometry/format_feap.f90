!> Meshes of FEAP records in a file of their own: COORdinates and ELEMents, each up to a blank line.
!!
!!   n  0  x y z            e  0  material  n1 n2 ...
!!
!! Elements of material m are the group `m`. Nothing is generated.
module format_feap
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text, quoted, lower
  use elmt_q2, only: FEAP27
  use mesh_file, only: mesh_file_t, SHAPE, add_element, add_member, sort_nodes
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_reals
  implicit none
  private
  public :: read_feap

contains

  !> The whole file; the text stands at its beginning.
  subroutine read_feap(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word

    allocate (file%number(0), file%x(3, 0), file%node_spot(0))
    do
      call next_word(text, word)
      if (len(word) == 0) exit
      select case (lower(word(:min(4, len(word)))))
      case ('coor')
        call read_nodes(text, file, error)
      case ('elem')
        call read_elements(text, file, error)
      case default
        call fail_in_file(text, quoted(word)//' where COORdinates or ELEMents should stand', error, &
                      'a blank line ends their records; other records belong into the deck')
      end select
      if (allocated(error)) return
    end do
    if (file%nnode == 0) then
      call fail_in_file(text, 'the file has no COORdinates', error)
    else if (file%nelem == 0) then
      call fail_in_file(text, 'the file has no ELEMents', error)
    else
      call sort_nodes(file, text, error)
    end if
  end subroutine read_feap

  !> On to the next line; `n` words stand there before a comment.
  subroutine next_line(text, n)
    type(text_t), intent(inout) :: text
    integer, intent(out) :: n
    type(text_t) :: line
    character(:), allocatable :: word
    integer :: length

    n = 0
    length = index(text%all(text%at:), achar(10))
    if (length == 0) then
      text%at = len(text%all) + 1
      return
    end if
    text%at = text%at + length
    length = index(text%all(text%at:), achar(10))
    if (length == 0) length = len(text%all) - text%at + 2
    line%all = text%all(text%at:text%at + length - 2)
    line%comment = text%comment
    do
      call next_word(line, word)
      if (len(word) == 0) exit
      n = n + 1
    end do
  end subroutine next_line

  subroutine read_nodes(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: n, number
    real(wp) :: x(3)

    do
      call next_line(text, n)
      if (n == 0) exit
      call read_head(text, n, 5, 5, 'n 0 x y z', number, error)
      if (.not. allocated(error)) call next_reals(text, 'a coordinate', x, error)
      if (allocated(error)) return
      call append_node(file, number, x, text%at)
    end do
    file%number = file%number(:file%nnode)
    file%x = file%x(:, :file%nnode)
    file%node_spot = file%node_spot(:file%nnode)
  end subroutine read_nodes

  subroutine append_node(file, number, x, spot)
    type(mesh_file_t), intent(inout) :: file
    integer, intent(in) :: number, spot
    real(wp), intent(in) :: x(3)
    real(wp), allocatable :: longer(:, :)
    integer :: n

    n = file%nnode
    if (n == size(file%number)) then
      file%number = [file%number, spread(0, 1, n + 64)]
      file%node_spot = [file%node_spot, spread(0, 1, n + 64)]
      allocate (longer(3, size(file%number)))
      longer(:, :n) = file%x
      call move_alloc(longer, file%x)
    end if
    file%nnode = n + 1
    file%number(n + 1) = number
    file%x(:, n + 1) = x
    file%node_spot(n + 1) = spot
  end subroutine append_node

  !> Number and the increment of generation, which must be 0, of a record of n words.
  subroutine read_head(text, n, least, most, usage, number, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: n, least, most
    character(*), intent(in) :: usage
    integer, intent(out) :: number
    type(error_t), allocatable, intent(out) :: error
    integer :: increment

    number = 0
    if (n < least .or. n > most) then
      call fail_in_file(text, 'a record of '//to_text(n)//' numbers', error, 'records are '//usage)
      return
    end if
    call next_integer(text, 'a number', number, error)
    if (allocated(error)) return
    if (number < 1) then
      call fail_in_file(text, 'number '//to_text(number), error, 'numbers are positive')
      return
    end if
    call next_integer(text, 'the increment of generation', increment, error)
    if (allocated(error)) return
    if (increment /= 0) then
      call fail_in_file(text, 'generation by '//to_text(increment), error, &
                    'a mesh file lists all its nodes and elements; INCLude it to generate some')
    end if
  end subroutine read_head

  subroutine read_elements(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n, number, spot, material, kind, node(27)

    do
      call next_line(text, n)
      if (n == 0) return
      call read_head(text, n, 7, 30, 'e 0 material n1 n2 ...', number, error)
      if (.not. allocated(error)) call next_integer(text, 'a material', material, error)
      if (allocated(error)) return
      do kind = size(SHAPE), 1, -1
        if (SHAPE(kind)%nen == n - 3 .and. SHAPE(kind)%dim == 3) exit
      end do
      if (kind == 0) then
        call fail_in_file(text, 'an element of '//to_text(n - 3)//' nodes', error, &
                      'elements have 4, 5, 6, 8, 10 or 27 nodes')
        return
      end if
      spot = text%at
      do i = 1, n - 3
        call next_integer(text, 'a node', node(i), error)
        if (allocated(error)) return
      end do
      if (SHAPE(kind)%row == 'Q2') node(FEAP27) = node
      call add_element(file, kind, number, node(:n - 3), spot)
      call add_member(file, file%nelem, 3, material)
    end do
  end subroutine read_elements

end module format_feap
