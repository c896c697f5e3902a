!> BEXT 2.0 text files of extracted surfaces, as LS-DYNA's *IGA_INCLUDE_BEZIER has them.
!!
!! Numbers are separated by blanks; `$` starts a comment. `etype` is not looked at: files of
!! tensor-product elements have 0 as well as 1. What follows the coefficient vectors is not read.
!!
!! Coefficient vectors of BEXT files, shared by elements, and the elements that name them.
module format_bext
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text
  use format_text, only: text_t, fail_in_file, next_integer, next_count, next_real, next_reals, &
      words_left, next_line
  use spline_surface, only: spline_surface_t, start_surface, add_point, check_sizes, &
      finish_surface, MOST_COEFFICIENTS, add_element
  implicit none
  private
  public :: read_bext, BEXT_HEAD, vectors_t, elements_t, new_vector, new_element, add_elements

  !> Vector i is value(first(i) : first(i+1)-1).
  type :: vectors_t
    integer :: n = 0
    integer :: ndense = 0      !! those behind are sparse: zeros at their end are left out
    integer, allocatable :: first(:)
    real(wp), allocatable :: value(:)
  end type vectors_t

  !> Element e has the control points node(first(e) : first(e+1)-1) and the same of `vector`.
  type :: elements_t
    integer :: n = 0
    integer, allocatable :: degree(:, :)     !! (2, >= n)
    integer, allocatable :: first(:)         !! (> n)
    integer, allocatable :: at(:)            !! (>= n) where it stands in the file
    integer, allocatable :: node(:), vector(:)
  end type elements_t

  character(*), parameter :: BEXT_HEAD = 'B E X T 2.0'

  !> Elements with the same sizes.
  type :: group_t
    integer :: nelem = 0, nf = 0, degree(2) = 0
  end type group_t

contains

  !> From the first line on.
  subroutine read_bext(text, surface, error)
    type(text_t), intent(inout) :: text
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    type(group_t), allocatable :: group(:)
    type(elements_t) :: elements
    type(vectors_t) :: vectors
    integer :: nvector, nelem, at

    text%comment = '$'
    text%at = len(BEXT_HEAD) + 1
    call read_points(text, nelem, nvector, surface, error)
    if (.not. allocated(error)) call read_groups(text, nelem, group, error)
    if (.not. allocated(error)) call read_elements(text, group, elements, error)
    if (.not. allocated(error)) call read_vectors(text, nvector, vectors, error)
    if (allocated(error)) return
    at = text%at
    call add_elements(text, elements, vectors, surface, error)
    if (allocated(error)) return
    text%at = at
    call finish_surface(text, surface, error)
  end subroutine read_bext

  !> pid nn ne ncv wfl, and the control points.
  subroutine read_points(text, nelem, nvector, surface, error)
    type(text_t), intent(inout) :: text
    integer, intent(out) :: nelem, nvector
    type(spline_surface_t), intent(out) :: surface
    type(error_t), allocatable, intent(out) :: error
    integer :: i, id, nnode, rational
    real(wp) :: x(4)

    nelem = 0
    nvector = 0
    call next_integer(text, 'the number of the patch', id, error)
    if (.not. allocated(error)) call next_count(text, 'a number of control points', nnode, error)
    if (.not. allocated(error)) call next_count(text, 'a number of elements', nelem, error)
    if (.not. allocated(error)) call next_count(text, 'a number of vectors', nvector, error)
    if (.not. allocated(error)) call next_integer(text, 'the flag of weights', rational, error)
    if (allocated(error)) return
    call start_surface(nnode, nelem, surface)
    do i = 1, nnode
      call next_reals(text, 'a coordinate or weight', x, error)
      if (allocated(error)) return
      if (rational == 0 .and. abs(x(4) - 1.0_wp) > 0.0_wp) then
        call fail_in_file(text, 'control point '//to_text(i)//' has the weight '//to_text(x(4)) &
                      //', but the file says that it has none', error, &
                      'the fifth number of the file is 1 where weights count')
      else
        call add_point(text, x, surface, error)
      end if
      if (allocated(error)) return
    end do
  end subroutine read_points

  !> neb, and etype ne nn ncv pr ps of each group.
  subroutine read_groups(text, nelem, group, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: nelem
    type(group_t), allocatable, intent(out) :: group(:)
    type(error_t), allocatable, intent(out) :: error
    integer :: g, n, nvector, etype

    call next_count(text, 'a number of groups of elements', n, error)
    if (allocated(error)) return
    allocate (group(n))
    do g = 1, n
      call next_line(text)
      if (words_left(text) /= 6) then
        call fail_in_file(text, 'a group of elements with '//to_text(words_left(text)) &
                      //' numbers', error, &
                      'a surface has six: etype ne nn ncv and two degrees; seven are a solid''s')
        return
      end if
      call next_integer(text, 'a type of elements', etype, error)
      if (.not. allocated(error)) call next_count(text, 'a number of elements', group(g)%nelem, &
                                                  error)
      if (.not. allocated(error)) call next_integer(text, 'a number of functions', group(g)%nf, &
                                                    error)
      if (.not. allocated(error)) call next_integer(text, 'a number of vectors', nvector, error)
      if (.not. allocated(error)) call next_integer(text, 'a degree', group(g)%degree(1), error)
      if (.not. allocated(error)) call next_integer(text, 'a degree', group(g)%degree(2), error)
      if (.not. allocated(error)) call check_sizes(text, sum(group(:g - 1)%nelem) + 1, &
                                                   group(g)%degree, group(g)%nf, error)
      if (allocated(error)) return
      if (nvector /= group(g)%nf) then
        call fail_in_file(text, 'elements with '//to_text(group(g)%nf)//' control points and ' &
                      //to_text(nvector)//' coefficient vectors', error, &
                      'each control point has one vector')
        return
      end if
    end do
    if (sum(group%nelem) == nelem) return
    call fail_in_file(text, 'the groups have '//to_text(sum(group%nelem))//' elements, the file says ' &
                  //to_text(nelem), error)
  end subroutine read_groups

  !> Control points and coefficient vectors of each element.
  subroutine read_elements(text, group, elements, error)
    type(text_t), intent(inout) :: text
    type(group_t), intent(in) :: group(:)
    type(elements_t), intent(inout) :: elements
    type(error_t), allocatable, intent(out) :: error
    integer :: g, e, i

    do g = 1, size(group)
      do e = 1, group(g)%nelem
        call next_line(text)
        call new_element(elements, group(g)%degree, group(g)%nf, text%at)
        associate (first => elements%first(elements%n), last => elements%first(elements%n + 1) - 1)
          do i = first, last
            call next_integer(text, 'the number of a control point', elements%node(i), error)
            if (allocated(error)) return
          end do
          do i = first, last
            call next_integer(text, 'the number of a vector', elements%vector(i), error)
            if (allocated(error)) return
          end do
        end associate
      end do
    end do
  end subroutine read_elements

  !> ndcvb nscvb; number and length of the vectors of each block; the dense ones, then the sparse
  !! ones: `length` is their number of entries there, which follow as positions and then values.
  subroutine read_vectors(text, nvector, vectors, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: nvector
    type(vectors_t), intent(inout) :: vectors
    type(error_t), allocatable, intent(out) :: error
    integer :: n(2), i, v
    integer, allocatable :: number(:), length(:)

    call next_count(text, 'a number of blocks of dense vectors', n(1), error)
    if (.not. allocated(error)) call next_count(text, 'a number of blocks of sparse vectors', &
                                                n(2), error)
    if (allocated(error)) return
    if (sum(real(n, wp)) > len(text%all)) then
      call fail_in_file(text, to_text(n(1))//' and '//to_text(n(2))//' blocks of vectors', error)
      return
    end if
    allocate (number(sum(n)), length(sum(n)))
    do i = 1, sum(n)
      call next_count(text, 'a number of vectors', number(i), error)
      if (.not. allocated(error)) call next_count(text, 'a length of vectors', length(i), error)
      if (allocated(error)) return
    end do
    do i = 1, sum(n)
      do v = 1, number(i)
        if (i <= n(1)) then
          call read_dense(text, length(i), vectors, error)
          vectors%ndense = vectors%n
        else
          call read_sparse(text, length(i), vectors, error)
        end if
        if (allocated(error)) return
      end do
    end do
    if (vectors%n /= nvector) call fail_in_file(text, 'the file has '//to_text(vectors%n) &
                                            //' coefficient vectors, but says '//to_text(nvector), &
                                            error)
  end subroutine read_vectors

  subroutine read_dense(text, length, vectors, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: length
    type(vectors_t), intent(inout) :: vectors
    type(error_t), allocatable, intent(out) :: error

    call new_vector(vectors, length)
    associate (first => vectors%first(vectors%n))
      call next_reals(text, 'a coefficient', vectors%value(first:first + length - 1), error)
    end associate
  end subroutine read_dense

  !> Positions from 1, then values. How long the vector is only its elements know.
  subroutine read_sparse(text, length, vectors, error)
    type(text_t), intent(inout) :: text
    integer, intent(in) :: length
    type(vectors_t), intent(inout) :: vectors
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: at(:)
    integer :: i

    allocate (at(length))
    do i = 1, length
      call next_integer(text, 'the position of a coefficient', at(i), error)
      if (allocated(error)) return
      if (at(i) >= 1 .and. at(i) <= MOST_COEFFICIENTS) cycle
      call fail_in_file(text, 'a coefficient at position '//to_text(at(i)), error, &
                    'positions are counted from 1')
      return
    end do
    call new_vector(vectors, maxval([0, at]))
    do i = 1, length
      call next_real(text, 'a coefficient', vectors%value(vectors%first(vectors%n) + at(i) - 1), &
                     error)
      if (allocated(error)) return
    end do
  end subroutine read_sparse

  !> Room for one more vector of a length; the caller fills its place.
  subroutine new_vector(list, length)
    type(vectors_t), intent(inout) :: list
    integer, intent(in) :: length
    real(wp), allocatable :: longer(:)
    integer :: last

    if (.not. allocated(list%first)) then
      allocate (list%first(64), list%value(1024))
      list%first(1) = 1
    else if (list%n + 1 == size(list%first)) then
      list%first = [list%first, list%first]
    end if
    last = list%first(list%n + 1) + length - 1
    if (last > size(list%value)) then
      allocate (longer(2*last), source=0.0_wp)
      longer(:list%first(list%n + 1) - 1) = list%value(:list%first(list%n + 1) - 1)
      call move_alloc(longer, list%value)
    end if
    list%n = list%n + 1
    list%first(list%n + 1) = last + 1
    list%value(list%first(list%n):last) = 0.0_wp
  end subroutine new_vector

  !> Room for one more element with so many functions.
  subroutine new_element(list, degree, nf, at)
    type(elements_t), intent(inout) :: list
    integer, intent(in) :: degree(2), nf, at
    integer, allocatable :: twice(:, :)
    integer :: last, n

    if (.not. allocated(list%first)) then
      allocate (list%first(64), list%degree(2, 64), list%at(64), list%node(1024), &
                list%vector(1024))
      list%first(1) = 1
    else if (list%n + 1 == size(list%first)) then
      n = size(list%first)
      allocate (twice(2, 2*n))
      twice(:, :n) = list%degree
      call move_alloc(twice, list%degree)
      list%first = [list%first, list%first]
      list%at = [list%at, list%at]
    end if
    last = list%first(list%n + 1) + nf - 1
    do while (last > size(list%node))
      list%node = [list%node, list%node]
      list%vector = [list%vector, list%vector]
    end do
    list%n = list%n + 1
    list%first(list%n + 1) = last + 1
    list%degree(:, list%n) = degree
    list%at(list%n) = at
  end subroutine new_element

  !> All elements to the surface.
  subroutine add_elements(text, list, vectors, surface, error)
    type(text_t), intent(inout) :: text
    type(elements_t), intent(in) :: list
    type(vectors_t), intent(in) :: vectors
    type(spline_surface_t), intent(inout) :: surface
    type(error_t), allocatable, intent(out) :: error
    real(wp), allocatable :: c(:, :)
    integer :: e

    do e = 1, list%n
      text%at = list%at(e)
      associate (first => list%first(e), last => list%first(e + 1) - 1)
        call gather(text, e, product(list%degree(:, e) + 1), list%vector(first:last), vectors, c, &
                    error)
        if (allocated(error)) return
        call add_element(text, list%degree(:, e), list%node(first:last), c, surface, error)
        if (allocated(error)) return
      end associate
    end do
  end subroutine add_elements

  !> The operator of one element.
  subroutine gather(text, e, nb, id, vectors, c, error)
    type(text_t), intent(in) :: text
    integer, intent(in) :: e, nb
    integer, intent(in) :: id(:)
    type(vectors_t), intent(in) :: vectors
    real(wp), allocatable, intent(out) :: c(:, :) !! (size(id), nb)
    type(error_t), allocatable, intent(out) :: error
    integer :: a, length

    allocate (c(size(id), nb))
    do a = 1, size(id)
      if (id(a) < 1 .or. id(a) > vectors%n) then
        call fail_in_file(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                      //to_text(id(a))//' of '//to_text(vectors%n), error, &
                      'coefficient vectors are counted from 1 here, the dense ones first')
        return
      end if
      length = vectors%first(id(a) + 1) - vectors%first(id(a))
      if (length > nb .or. (length < nb .and. id(a) <= vectors%ndense)) then
        call fail_in_file(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                      //to_text(id(a))//', which has '//to_text(length)//' numbers', error, &
                      'of its degrees it needs '//to_text(nb))
        return
      end if
      c(a, :length) = vectors%value(vectors%first(id(a)):vectors%first(id(a) + 1) - 1)
      c(a, length + 1:) = 0.0_wp
    end do
  end subroutine gather

end module format_bext
