!> BEXT 2.0 text files of extracted surfaces, in the format that *IGA_INCLUDE_BEZIER of LS-DYNA
!! reads.
!!
!! The reader uses the sizes, the control points, the elements (in groups with equal degrees and
!! numbers of functions), and the dense and sparse coefficient vectors that the elements share.
!! Everything after the vectors is ignored. Numbers are separated by blanks, and `$` starts a
!! comment. The element type (`etype`), which is 0 or 1 in files of tensor-product elements, is
!! ignored.
!! Source: LS-DYNA keyword manual, *IGA_INCLUDE_BEZIER
module format_bext
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp
  use base_text, only: to_text
  use format_text, only: text_t, fail_in_file, next_integer, next_count, next_real, next_reals, &
                         words_left, next_line
  use spline_surface, only: spline_surface_t, start_surface, add_point, check_sizes, &
                            finish_surface, add_element, MOST_COEFFICIENTS
  implicit none
  private
  public :: read_bext, BEXT_HEAD
  public :: vectors_t, elements_t, new_vector, new_element, add_elements ! for format_bext_json

  character(*), parameter :: BEXT_HEAD = 'B E X T 2.0'

  !> Coefficient vectors. Vector i is value(first(i) : first(i+1)-1).
  type :: vectors_t
    integer :: n = 0
    integer :: ndense = 0      !! vectors after these are sparse and end with their last entry
    integer, allocatable :: first(:)
    real(wp), allocatable :: value(:)
  end type vectors_t

  !> Elements. Element e has the control points node(first(e) : first(e+1)-1) and, in the same range
  !! of `vector`, their coefficient vectors.
  type :: elements_t
    integer :: n = 0
    integer, allocatable :: degree(:, :)     !! (2, >= n)
    integer, allocatable :: first(:)         !! (> n)
    integer, allocatable :: at(:)            !! (>= n) position in the file
    integer, allocatable :: node(:), vector(:)
  end type elements_t

contains

  !> Read the whole file: after the head, the number of the patch, the numbers of control points,
  !! elements and vectors, and the weight flag; then the control points, elements and vectors.
  subroutine read_bext(text, surface, error)
    type(text_t), intent(inout) :: text
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(elements_t) :: elements
    type(vectors_t) :: vectors
    integer :: at, i, id, nelem, nnode, nvector, rational
    real(wp) :: x(4)

    text%comment = '$'
    text%at = len(BEXT_HEAD) + 1
    call next_integer(text, 'the number of the patch', id, error)
    if (.not. allocated(error)) call next_count(text, 'the number of control points', nnode, error)
    if (.not. allocated(error)) call next_count(text, 'the number of elements', nelem, error)
    if (.not. allocated(error)) call next_count(text, 'the number of vectors', nvector, error)
    if (.not. allocated(error)) call next_integer(text, 'the weight flag', rational, error)
    if (allocated(error)) return
    call start_surface(nnode, nelem, surface)
    do i = 1, nnode
      call next_reals(text, 'a coordinate or weight', x, error)
      if (allocated(error)) return
      if (rational == 0 .and. abs(x(4) - 1.0_wp) > 0.0_wp) then
        call fail_in_file(text, 'control point '//to_text(i)//' has the weight '//to_text(x(4)) &
                          //', but the weight flag is 0', error, 'the weight flag, the fifth ' &
                          //'number after '''//BEXT_HEAD//''', must be 1 if weights differ from 1')
      else
        call add_point(text, x, surface, error)
      end if
      if (allocated(error)) return
    end do
    call read_elements(text, nelem, elements, error)
    if (.not. allocated(error)) call read_vectors(text, nvector, vectors, error)
    if (allocated(error)) return
    at = text%at
    call add_elements(text, elements, vectors, surface, error)
    if (allocated(error)) return
    text%at = at
    call finish_surface(text, surface, error)
  end subroutine read_bext

  !> Read the number of groups; then, for each group, the element type, the number of elements,
  !! their numbers of control points and vectors, and their two degrees; then the numbers of the
  !! control points and vectors of each element.
  subroutine read_elements(text, nelem, elements, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: nelem           !! expected number
    type(elements_t), intent(inout) :: elements
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: number(:), nf(:), degree(:, :) !! values of each group
    integer :: g, e, i, n, nvector, etype

    call next_count(text, 'the number of groups of elements', n, error)
    if (allocated(error)) return
    allocate (number(n), nf(n), degree(2, n))
    do g = 1, n
      call next_line(text)
      if (words_left(text) /= 6) then
        call fail_in_file(text, 'expected 6 numbers for a group of elements, found ' &
                          //to_text(words_left(text)), error, &
                          'expected the type and number of elements, their numbers of control ' &
                          //'points and vectors, and their two degrees')
        return
      end if
      call next_integer(text, 'an element type', etype, error)
      if (.not. allocated(error)) call next_count(text, 'the number of elements', number(g), error)
      if (.not. allocated(error)) call next_integer(text, 'the number of control points', nf(g), &
                                                    error)
      if (.not. allocated(error)) call next_integer(text, 'the number of vectors', nvector, error)
      if (.not. allocated(error)) call next_integer(text, 'a degree', degree(1, g), error)
      if (.not. allocated(error)) call next_integer(text, 'a degree', degree(2, g), error)
      if (.not. allocated(error)) call check_sizes(text, sum(number(:g - 1)) + 1, degree(:, g), &
                                                   nf(g), error)
      if (allocated(error)) return
      if (nvector /= nf(g)) then
        call fail_in_file(text, 'elements have '//to_text(nf(g))//' control points, but ' &
                          //to_text(nvector)//' coefficient vectors', error, &
                          'the numbers must be equal, because each control point has one vector')
        return
      end if
    end do
    if (sum(number) /= nelem) then
      call fail_in_file(text, 'expected '//to_text(nelem)//' elements in the groups, found ' &
                        //to_text(sum(number)), error)
      return
    end if
    do g = 1, n
      do e = 1, number(g)
        call next_line(text)
        call new_element(elements, degree(:, g), nf(g), text%at)
        associate (first => elements%first(elements%n), last => elements%first(elements%n + 1) - 1)
          do i = first, last
            call next_integer(text, 'a control point number', elements%node(i), error)
            if (allocated(error)) return
          end do
          do i = first, last
            call next_integer(text, 'a vector number', elements%vector(i), error)
            if (allocated(error)) return
          end do
        end associate
      end do
    end do
  end subroutine read_elements

  !> Read the number of blocks of dense vectors and that of sparse ones; then the number and length
  !! of the vectors of each block; then the dense vectors, and the sparse ones. For a sparse vector,
  !! `length` is the number of its entries, and the file gives their positions and then their
  !! values. The full length of a sparse vector is known only from the elements that use it.
  subroutine read_vectors(text, nvector, vectors, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: nvector      !! expected number
    type(vectors_t), intent(inout) :: vectors
    type(error_t), allocatable, intent(out) :: error
    integer :: n(2), b, i, v
    integer, allocatable :: number(:), length(:), at(:)

    call next_count(text, 'the number of blocks of dense vectors', n(1), error)
    if (.not. allocated(error)) call next_count(text, 'the number of blocks of sparse vectors', &
                                                n(2), error)
    if (allocated(error)) return
    if (sum(real(n, wp)) > len(text%all)) then
      call fail_in_file(text, 'the file is too short for '//to_text(n(1))//' and ' &
                        //to_text(n(2))//' blocks of vectors', error)
      return
    end if
    allocate (number(sum(n)), length(sum(n)))
    do b = 1, sum(n)
      call next_count(text, 'the number of vectors', number(b), error)
      if (.not. allocated(error)) call next_count(text, 'the length of vectors', length(b), error)
      if (allocated(error)) return
    end do
    do b = 1, sum(n)
      do v = 1, number(b)
        if (b <= n(1)) then
          call new_vector(vectors, length(b))
          vectors%ndense = vectors%n
          at = [(i, i=1, length(b))]
        else
          at = [(0, i=1, length(b))]
          do i = 1, length(b)
            call next_integer(text, 'the position of a coefficient', at(i), error)
            if (allocated(error)) return
            if (at(i) >= 1 .and. at(i) <= MOST_COEFFICIENTS) cycle
            call fail_in_file(text, 'a coefficient has the invalid position '//to_text(at(i)), &
                              error, 'positions range from 1 to '//to_text(MOST_COEFFICIENTS))
            return
          end do
          call new_vector(vectors, maxval([0, at]))
        end if
        do i = 1, length(b)
          call next_real(text, 'a coefficient', &
                         vectors%value(vectors%first(vectors%n) + at(i) - 1), error)
          if (allocated(error)) return
        end do
      end do
    end do
    if (vectors%n /= nvector) call fail_in_file(text, 'expected '//to_text(nvector) &
                                                //' coefficient vectors, found ' &
                                                //to_text(vectors%n), error)
  end subroutine read_vectors

  !> Append a vector of zeros.
  subroutine new_vector(list, length)
    type(vectors_t), intent(inout) :: list
    integer, intent(in) :: length
    integer :: last

    if (list%n == 0) list%first = [1]
    last = list%first(list%n + 1) + length - 1
    list%n = list%n + 1
    call grow(list%first, list%n + 1)
    call grow(list%value, last)
    list%first(list%n + 1) = last + 1
    list%value(list%first(list%n):last) = 0.0_wp
  end subroutine new_vector

  !> Append an element with nf functions; the caller sets the numbers of its nodes and vectors.
  subroutine new_element(list, degree, nf, at)
    type(elements_t), intent(inout) :: list
    integer, intent(in) :: degree(2), nf, at
    integer :: last

    if (list%n == 0) list%first = [1]
    last = list%first(list%n + 1) + nf - 1
    list%n = list%n + 1
    call grow(list%first, list%n + 1)
    call grow(list%degree, 2, list%n)
    call grow(list%at, list%n)
    call grow(list%node, last)
    call grow(list%vector, last)
    list%first(list%n + 1) = last + 1
    list%degree(:, list%n) = degree
    list%at(list%n) = at
  end subroutine new_element

  !> Add all elements to the surface; the rows of the operator of an element are its vectors.
  subroutine add_elements(text, list, vectors, surface, error)
    type(text_t), intent(inout) :: text
    type(elements_t), intent(in) :: list
    type(vectors_t), intent(in) :: vectors
    type(spline_surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: c(:, :) !! (functions, Bernstein polynomials)
    integer :: a, e, first, last, length, nb, v

    do e = 1, list%n
      text%at = list%at(e)
      first = list%first(e)
      last = list%first(e + 1) - 1
      nb = product(list%degree(:, e) + 1)
      allocate (c(last - first + 1, nb))
      do a = 1, size(c, 1)
        v = list%vector(first + a - 1)
        if (v < 1 .or. v > vectors%n) then
          call fail_in_file(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                            //to_text(v)//', but there are vectors 1 to ' &
                            //to_text(vectors%n), error, &
                            'elements and vectors are counted from 1 in this message: first ' &
                            //'the dense vectors, then the sparse ones')
          return
        end if
        length = vectors%first(v + 1) - vectors%first(v)
        if (length > nb .or. (length < nb .and. v <= vectors%ndense)) then
          call fail_in_file(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                            //to_text(v)//', whose last coefficient has position ' &
                            //to_text(length), error, 'a vector of an element of these degrees ' &
                            //'has '//to_text(nb)//' coefficients; elements, vectors and ' &
                            //'positions are counted from 1 in this message')
          return
        end if
        c(a, :length) = vectors%value(vectors%first(v):vectors%first(v + 1) - 1)
        c(a, length + 1:) = 0.0_wp
      end do
      call add_element(text, list%degree(:, e), list%node(first:last), c, surface, error)
      if (allocated(error)) return
      deallocate (c)
    end do
  end subroutine add_elements

end module format_bext
