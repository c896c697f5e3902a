!> Meshes in separate files of FEAP records: the lists of COORdinates and of ELEMents, each of which
!! ends with a blank line.
!!
!!   n  0  x y z            e  0  material  n1 n2 ...
!!
!! The elements of material m form the group `m`. Records with an increment for generation are
!! rejected.
!! Source: FEAPpv's manual
module format_feap
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp
  use base_text, only: to_text, quoted, lower
  use mesh_file, only: mesh_file_t, start_mesh, add_element, add_member, sort_nodes
  use mesh_shape, only: solid_shape, node_counts
  use format_text, only: text_t, fail_in_file, next_word, next_integer, next_reals, words_left
  implicit none
  private
  public :: read_feap

contains

  !> Read the whole file; the current position must be its beginning.
  subroutine read_feap(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(out) :: file
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: word

    call start_mesh(file)
    allocate (file%number(0), file%x(3, 0), file%node_spot(0))
    do
      call next_word(text, word)
      if (len(word) == 0) exit
      if (words_left(text) > 0 .or. index(word, ',') > 0) then
        call fail_in_file(text, 'only the word itself is expected in the line of '//quoted(word), &
                          error, 'write the records in the lines after it; options belong in ' &
                          //'the deck')
        return
      end if
      select case (lower(word(:min(4, len(word)))))
      case ('coor')
        call read_nodes(text, file, error)
      case ('elem')
        call read_elements(text, file, error)
      case default
        call fail_in_file(text, 'expected COORdinates or ELEMents, found '//quoted(word), error, &
                          'a blank line ends the list of nodes and that of elements; all ' &
                          //'other records belong in the deck')
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

  !> Go to the beginning of the next line, and count its words before a comment.
  subroutine next_line(text, n)
    type(text_t), intent(inout) :: text
    integer, intent(out) :: n
    integer :: length

    length = index(text%all(text%at:), achar(10))
    if (length == 0) length = len(text%all) - text%at + 1
    text%at = text%at + length
    n = words_left(text)
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
      n = file%nnode + 1
      call grow(file%number, n)
      call grow(file%x, 3, n)
      call grow(file%node_spot, n)
      file%nnode = n
      file%number(n) = number
      file%x(:, n) = x
      file%node_spot(n) = text%at
    end do
    file%number = file%number(:file%nnode)
    file%x = file%x(:, :file%nnode)
    file%node_spot = file%node_spot(:file%nnode)
  end subroutine read_nodes

  !> Read the first two numbers of a record of n words: its own number, and the increment of
  !! generation, which must be 0. The record must have `least` to `most` words.
  subroutine read_head(text, n, least, most, usage, number, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: n, least, most
    character(*), intent(in) :: usage
    integer, intent(out) :: number
    type(error_t), allocatable, intent(out) :: error
    integer :: increment

    number = 0
    if (n < least .or. n > most) then
      call fail_in_file(text, 'the record has the wrong number of words ('//to_text(n)//')', &
                        error, 'write records in the form '''//usage//'''; a blank line ends ' &
                        //'the list')
      return
    end if
    call next_integer(text, 'a number', number, error)
    if (allocated(error)) return
    if (number < 1) then
      call fail_in_file(text, 'number '//to_text(number)//' is not positive', error, &
                        'nodes and elements are numbered from 1')
      return
    end if
    call next_integer(text, 'the increment of generation', increment, error)
    if (allocated(error)) return
    if (increment /= 0) then
      call fail_in_file(text, 'expected 0 as the increment of generation, found ' &
                        //to_text(increment), error, 'list all nodes and elements, or INCLude ' &
                        //'the file in the deck')
    end if
  end subroutine read_head

  subroutine read_elements(text, file, error)
    type(text_t), intent(inout) :: text
    type(mesh_file_t), intent(inout) :: file
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n, number, spot, material, s
    integer, allocatable :: node(:), own(:)

    do
      call next_line(text, n)
      if (n == 0) return
      call read_head(text, n, 4, huge(1), 'e 0 material n1 n2 ...', number, error)
      if (.not. allocated(error)) call next_integer(text, 'a material', material, error)
      if (allocated(error)) return
      s = solid_shape(file%shapes, n - 3)
      if (s == 0) then
        call fail_in_file(text, 'the element has '//to_text(n - 3) &
                          //trim(merge(' node ', ' nodes', n == 4)), error, &
                          'known elements have '//node_counts(file%shapes%row%deck_nodes)//' nodes')
        return
      end if
      spot = text%at
      node = [(0, i=4, n)]
      do i = 1, n - 3
        call next_integer(text, 'a node', node(i), error)
        if (allocated(error)) return
      end do
      own = node
      associate (order => file%shapes(s)%row%deck_order)
        if (order(1) > 0) own(order(:n - 3)) = node
      end associate
      call add_element(file, s, number, own, spot)
      call add_member(file, 3, material)
    end do
  end subroutine read_elements

end module format_feap
