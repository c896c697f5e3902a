!> BEXT 2.0 files in JSON: nodes (the control points), elements in blocks, coefficient vectors, and
!! sets of elements. Nodes, elements and vectors are numbered from 0.
!!
!! A sparse vector has the positions of its entries, from 0, in `indices` and their values in
!! `components`.
!! Source: files of the package CoreformIGA.jl
module format_bext_json
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text, quoted
  use format_bext, only: vectors_t, elements_t, new_vector, new_element, add_elements
  use format_json, only: json_t, parse_json, member, first_of, get, get_integer, to_integer, &
                         get_reals, check_number, JSON_LIST, JSON_OBJECT, JSON_TRUE
  use format_text, only: text_t, fail_in_file
  use spline_set, only: read_sets
  use spline_surface, only: spline_surface_t, start_surface, add_point, check_sizes, &
                            finish_surface, MOST_COEFFICIENTS
  implicit none
  private
  public :: read_bext_json

contains

  !> Read the whole file.
  subroutine read_bext_json(text, surface, error)
    type(text_t), intent(inout) :: text
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(json_t) :: json
    type(elements_t) :: elements
    type(vectors_t) :: vectors
    integer :: blocks, dim, flag, i, list, node
    real(wp), allocatable :: x(:)

    call parse_json(text, json, error)
    if (.not. allocated(error)) call get_integer(text, json, 1, 'dim', dim, error)
    if (.not. allocated(error) .and. dim /= 2) then
      call fail_in_file(text, 'expected splines of 2 directions, found '//to_text(dim), error, &
                        'a surface has "dim": 2')
    end if
    if (.not. allocated(error)) call get(text, json, 1, 'nodes', JSON_LIST, list, error)
    if (.not. allocated(error)) call check_number(text, json, 1, 'num_nodes', json%length(list), &
                                                  error)
    if (.not. allocated(error)) call get_list(text, json, 'elements', 'element_blocks', blocks, &
                                              error)
    if (.not. allocated(error)) call check_number(text, json, 1, 'num_elems', &
                                                  json%length(blocks), error)
    if (allocated(error)) return
    flag = member(text, json, 1, 'is_rational')
    call start_surface(json%length(list), json%length(blocks), surface)
    node = first_of(json, list)
    do i = 1, json%length(list)
      call get_reals(text, json, node, 'nodes', x, error)
      if (allocated(error)) return
      text%at = json%at(node)
      if (size(x) /= 4) then
        call fail_in_file(text, 'expected 4 numbers for control point '//to_text(i - 1) &
                          //', found '//to_text(size(x)), error, 'give x, y, z and the weight')
      else if (abs(x(4) - 1.0_wp) > 0.0_wp .and. json%type(max(flag, 1)) /= JSON_TRUE) then
        call fail_in_file(text, 'control point '//to_text(i - 1)//' has the weight ' &
                          //to_text(x(4))//', but the surface is not rational', error, &
                          'write "is_rational": true if control points have weights')
      else
        call add_point(text, x, surface, error)
      end if
      if (allocated(error)) return
      node = json%next(node)
    end do
    call read_elements(text, json, elements, error)
    if (.not. allocated(error)) call read_vectors(text, json, vectors, error)
    if (.not. allocated(error)) call add_elements(text, elements, vectors, surface, error)
    if (.not. allocated(error)) call read_sets(text, json, surface, error)
    if (.not. allocated(error)) call finish_surface(text, surface, error)
  end subroutine read_bext_json

  !> Get the list `name` in the member `part` of the top-level object.
  subroutine get_list(text, json, part, name, list, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    character(*), intent(in) :: part, name
    integer, intent(out) :: list !! number of its JSON value
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    list = 0
    call get(text, json, 1, part, JSON_OBJECT, i, error)
    if (.not. allocated(error)) call get(text, json, i, name, JSON_LIST, list, error)
  end subroutine get_list

  !> Read the elements of all blocks; the sizes of the blocks are in a separate list.
  subroutine read_elements(text, json, elements, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    type(elements_t), intent(inout) :: elements
    type(error_t), allocatable, intent(out) :: error
    integer :: info, list, b, e, k, n, nf, degree(2)

    call get_list(text, json, 'elements', 'element_block_info', info, error)
    if (.not. allocated(error)) call get_list(text, json, 'elements', 'element_blocks', list, &
                                              error)
    if (allocated(error)) return
    e = first_of(json, list)
    b = first_of(json, info)
    do while (b > 0)
      call get_integer(text, json, b, 'num_elems', n, error)
      if (.not. allocated(error)) call get_integer(text, json, b, 'num_nodes', nf, error)
      if (.not. allocated(error)) call get_integer(text, json, b, 'deg_s', degree(1), error)
      if (.not. allocated(error)) call get_integer(text, json, b, 'deg_t', degree(2), error)
      if (.not. allocated(error)) call check_sizes(text, elements%n + 1, degree, nf, error)
      if (allocated(error)) return
      do k = 1, n
        if (e == 0) then
          call fail_in_file(text, 'the list of elements ends after entry ' &
                            //to_text(elements%n)//', but the blocks announce more', error)
          return
        end if
        call new_element(elements, degree, nf, json%at(e))
        associate (first => elements%first(elements%n), last => elements%first(elements%n + 1) - 1)
          call get_ids(text, json, e, 'node_ids', elements%node(first:last), error)
          if (.not. allocated(error)) call get_ids(text, json, e, 'coeff_vector_ids', &
                                                   elements%vector(first:last), error)
        end associate
        if (allocated(error)) return
        e = json%next(e)
      end do
      b = json%next(b)
    end do
    if (e > 0) call fail_in_file(text, 'the list of elements has more entries than the blocks ' &
                                 //'announce', error)
  end subroutine read_elements

  !> Get the numbers of the nodes or coefficient vectors of an element, which start at 0 in the file
  !! and at 1 here.
  subroutine get_ids(text, json, e, name, id, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    integer, intent(in) :: e
    character(*), intent(in) :: name
    integer, intent(out) :: id(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: list, i, j

    id = 0
    call get(text, json, e, name, JSON_LIST, list, error)
    if (allocated(error)) return
    if (json%length(list) /= size(id)) then
      call fail_in_file(text, 'expected '//to_text(size(id))//' numbers in '//quoted(name) &
                        //', found '//to_text(json%length(list)), error)
      return
    end if
    j = first_of(json, list)
    do i = 1, size(id)
      call to_integer(text, json, j, name, id(i), error)
      if (allocated(error)) return
      id(i) = id(i) + 1
      j = json%next(j)
    end do
  end subroutine get_ids

  !> Read the dense vectors, then the sparse ones.
  subroutine read_vectors(text, json, vectors, error)
    type(text_t), intent(inout) :: text
    type(json_t), intent(in) :: json
    type(vectors_t), intent(inout) :: vectors
    type(error_t), allocatable, intent(out) :: error
    integer :: i, j, list, part, places, v, values
    integer, allocatable :: at(:)
    real(wp), allocatable :: x(:)

    call get_list(text, json, 'coefficients', 'dense_coefficient_vectors', list, error)
    if (allocated(error)) return
    v = first_of(json, list)
    do while (v > 0)
      call get(text, json, v, 'components', JSON_LIST, values, error)
      if (.not. allocated(error)) call get_reals(text, json, values, 'components', x, error)
      if (allocated(error)) return
      call new_vector(vectors, size(x))
      vectors%value(vectors%first(vectors%n):vectors%first(vectors%n + 1) - 1) = x
      v = json%next(v)
    end do
    vectors%ndense = vectors%n
    part = member(text, json, 1, 'coefficients')
    v = first_of(json, member(text, json, part, 'sparse_coefficient_vectors'))
    do while (v > 0)
      call get(text, json, v, 'indices', JSON_LIST, places, error)
      if (.not. allocated(error)) call get(text, json, v, 'components', JSON_LIST, values, error)
      if (.not. allocated(error)) call get_reals(text, json, values, 'components', x, error)
      if (allocated(error)) return
      if (json%length(places) /= size(x)) then
        call fail_in_file(text, 'expected '//to_text(size(x))//' indices, one for each ' &
                          //'component, found '//to_text(json%length(places)), error)
        return
      end if
      at = [(0, i=1, size(x))]
      j = first_of(json, places)
      do i = 1, size(x)
        call to_integer(text, json, j, 'indices', at(i), error)
        if (allocated(error)) return
        if (at(i) < 0 .or. at(i) >= MOST_COEFFICIENTS) then
          call fail_in_file(text, 'a coefficient has the invalid position '//to_text(at(i)), &
                            error, 'positions range from 0 to '//to_text(MOST_COEFFICIENTS - 1))
          return
        end if
        j = json%next(j)
      end do
      call new_vector(vectors, maxval([0, at + 1]))
      vectors%value(vectors%first(vectors%n) + at) = x
      v = json%next(v)
    end do
    call check_number(text, json, 1, 'num_coeff_vecs', vectors%n, error)
  end subroutine read_vectors

end module format_bext_json
