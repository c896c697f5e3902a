!> Coefficient vectors of BEXT files, shared by elements, and the elements that name them.
module spline_vectors
  use base_kinds, only: wp
  use base_error, only: error_t
  use base_text, only: to_text
  use patch_text, only: text_t, complain
  use spline_surface, only: spline_surface_t, add_element
  implicit none
  private
  public :: vectors_t, elements_t, new_vector, new_element, add_elements

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

contains

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
        call complain(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                      //to_text(id(a))//' of '//to_text(vectors%n), error, &
                      'coefficient vectors are counted from 1 here, the dense ones first')
        return
      end if
      length = vectors%first(id(a) + 1) - vectors%first(id(a))
      if (length > nb .or. (length < nb .and. id(a) <= vectors%ndense)) then
        call complain(text, 'element '//to_text(e)//' refers to coefficient vector ' &
                      //to_text(id(a))//', which has '//to_text(length)//' numbers', error, &
                      'of its degrees it needs '//to_text(nb))
        return
      end if
      c(a, :length) = vectors%value(vectors%first(id(a)):vectors%first(id(a) + 1) - 1)
      c(a, length + 1:) = 0.0_wp
    end do
  end subroutine gather

end module spline_vectors
