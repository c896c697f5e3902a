!> Reads tables from separate files: the inner nodes of the layer below a spline surface, and
!! hanging nodes.
module spline_layer
  use base_error, only: error_t, place_t
  use base_kinds, only: wp
  use base_text, only: to_text
  use constraint, only: constraint_t, add_constraint
  use format_text, only: text_t, load_text, fail_in_file, next_integer, next_integers, next_real, &
                         next_line, words_left
  implicit none
  private
  public :: read_layer, read_constraints

  integer, parameter :: MOST_MASTERS = 256

contains

  !> Read the inner nodes. A record consists of an element number and the inner nodes at the corners
  !! (-,-) (+,-) (+,+) (-,+) of the element.
  subroutine read_layer(path, nelem, inner, place, error)
    character(*), intent(in) :: path
    integer, intent(in) :: nelem
    integer, allocatable, intent(out) :: inner(:, :) !! (4, nelem)
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: text
    integer :: e, i, node(4)

    call load_table(path, place, text, error)
    if (allocated(error)) return
    allocate (inner(4, nelem), source=0)
    do
      call next_line(text)
      if (words_left(text) == 0) exit
      if (words_left(text) /= 5) then
        call fail_in_file(text, 'expected 5 numbers in a record, found ' &
                          //to_text(words_left(text)), error, &
                          'a record consists of an element of the surface and its four inner nodes')
        return
      end if
      call next_integer(text, 'an element number', e, error)
      if (.not. allocated(error)) call next_integers(text, 'a node number', node, error)
      if (allocated(error)) return
      if (e < 1 .or. e > nelem) then
        call fail_in_file(text, 'element '//to_text(e)//' is not in the surface', error, &
                          'the elements of the surface are numbered 1 to '//to_text(nelem) &
                          //', in the order of its file')
      else if (any(node < 1)) then
        call fail_in_file(text, 'node number '//to_text(minval(node))//' is not positive', error)
      else if (inner(1, e) /= 0) then
        call fail_in_file(text, 'duplicate record of element '//to_text(e), error, &
                          'each element of the surface must have exactly one record')
      end if
      if (allocated(error)) return
      inner(:, e) = node
    end do
    text%at = 0
    do i = 1, nelem
      if (inner(1, i) /= 0) cycle
      call fail_in_file(text, 'element '//to_text(i)//' has no record', error, &
                        'each of the '//to_text(nelem)//' elements of the surface must have one ' &
                        //'record')
      return
    end do
  end subroutine read_layer

  !> Read hanging nodes. A record consists of the slave, the number of its masters, and each master
  !! with its coefficient. A negative master -k of a SPLIne is control point k of its surface.
  subroutine read_constraints(path, list, place, error)
    character(*), intent(in) :: path
    type(constraint_t), intent(inout) :: list
    type(place_t), intent(in) :: place
    type(error_t), allocatable, intent(out) :: error
    type(text_t) :: text
    integer :: slave, n, i
    integer, allocatable :: master(:)
    real(wp), allocatable :: c(:)

    call load_table(path, place, text, error)
    if (allocated(error)) return
    do
      call next_line(text)
      i = words_left(text)
      if (i == 0) exit
      call next_integer(text, 'a node number', slave, error)
      if (.not. allocated(error)) call next_integer(text, 'the number of masters', n, error)
      if (allocated(error)) return
      if (n < 1 .or. n > MOST_MASTERS .or. i /= 2 + 2*n) then
        call fail_in_file(text, 'the record has '//to_text(i)//' numbers, which do not fit ' &
                          //to_text(n)//' masters', error, 'a record consists of the slave, the ' &
                          //'number n of masters (1 to '//to_text(MOST_MASTERS)//'), and n ' &
                          //'pairs of a master and its coefficient')
        return
      end if
      master = [(0, i=1, n)]
      c = [(0.0_wp, i=1, n)]
      do i = 1, n
        call next_integer(text, 'a node number', master(i), error)
        if (.not. allocated(error)) call next_real(text, 'a coefficient', c(i), error)
        if (allocated(error)) return
      end do
      if (slave < 1 .or. any(master == 0)) then
        call fail_in_file(text, 'node number '//to_text(min(slave, 0))//' is not positive', error, &
                          'only masters of a SPLIne may have negative numbers: -k is control ' &
                          //'point k of its surface')
        return
      end if
      call add_constraint(list, slave, master, c, place)
    end do
  end subroutine read_constraints

  !> Load a file whose comments start with # or !.
  subroutine load_table(path, place, text, error)
    character(*), intent(in) :: path
    type(place_t), intent(in) :: place
    type(text_t), intent(out) :: text
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    call load_text(path, place, text, error)
    if (allocated(error)) return
    text%comment = '#'
    do i = 1, len(text%all)
      if (text%all(i:i) == '!') text%all(i:i) = '#'
    end do
  end subroutine load_table

end module spline_layer
