!> A spline surface in the form in which files of extracted splines describe it, namely by the
!! functions of each element.
module spline_surface
  use base_error, only: error_t
  use base_grow, only: grow
  use base_kinds, only: wp, i8
  use base_text, only: to_text
  use format_text, only: text_t, fail_in_file
  use mesh, only: operator_t
  use patch_nurbs, only: MAX_DEGREE
  implicit none
  private
  public :: spline_surface_t, spline_set_t, start_surface, add_point, check_sizes, add_element, &
            finish_surface, transpose_surface

  integer, parameter :: MOST_FUNCTIONS = 256 !! largest number of functions of an element
  !> Largest number of coefficients of a function.
  integer, parameter, public :: MOST_COEFFICIENTS = (MAX_DEGREE + 1)**2
  !> Tolerance for the sum of the functions. It is small, because files give the coefficients in
  !! full precision.
  real(wp), parameter :: UNITY = 1.0e-9_wp

  !> A named set of elements.
  type :: spline_set_t
    character(:), allocatable :: name
    integer, allocatable :: elem(:) !! indices, from 1
  end type spline_set_t

  !> A surface. The functions of element e, before they are weighted, are N = C B with C =
  !! op(iop(e)) and the Bernstein polynomials B on [-1,1]^2, the first direction fastest. They
  !! belong to the control points node(first(e) : first(e+1)-1).
  type :: spline_surface_t
    integer :: nnode = 0, nelem = 0
    real(wp), allocatable :: x(:, :)      !! (3, nnode) control points without weights [L]
    real(wp), allocatable :: w(:)         !! (nnode) weights
    logical :: rational = .false.         !! .true. if the weights differ
    integer, allocatable :: degree(:, :)  !! (2, nelem)
    integer, allocatable :: first(:)      !! (nelem+1)
    integer, allocatable :: node(:)       !! (>= first(nelem+1)-1)
    integer, allocatable :: iop(:)        !! (nelem)
    integer :: nop = 0
    type(operator_t), allocatable :: op(:) !! (>= nop) distinct operators
    integer, allocatable :: slot(:)       !! hash table of the operators
    type(spline_set_t), allocatable :: set(:) !! not allocated: the file has none
  end type spline_surface_t

contains

  !> Make an empty surface with room for control points and elements.
  subroutine start_surface(nnode, nelem, s)
    integer, intent(in) :: nnode, nelem
    type(spline_surface_t), intent(out) :: s

    allocate (s%x(3, nnode), s%w(nnode), s%degree(2, nelem), s%first(nelem + 1), s%iop(nelem))
    allocate (s%op(16), s%node(16*nelem + 1), s%slot(2*nelem + 1))
    s%slot = 0
    s%first(1) = 1
  end subroutine start_surface

  !> Append a control point: x, y, z and its weight.
  subroutine add_point(text, x, s, error)
    type(text_t), intent(in) :: text
    real(wp), intent(in) :: x(4)
    type(spline_surface_t), intent(inout) :: s
    type(error_t), allocatable, intent(out) :: error

    if (.not. x(4) > 0.0_wp) then
      call fail_in_file(text, 'control point '//to_text(s%nnode + 1)//' has the weight ' &
                        //to_text(x(4)), error, 'weights must be positive; control points are ' &
                        //'counted from 1 in this message')
      return
    end if
    s%nnode = s%nnode + 1
    s%x(:, s%nnode) = x(:3)
    s%w(s%nnode) = x(4)
  end subroutine add_point

  !> Append an element; its control points must exist, and its functions must sum to one.
  subroutine add_element(text, degree, node, c, s, error)
    type(text_t), intent(in) :: text     !! positioned at the element, for error messages
    integer, intent(in) :: degree(2)
    integer, intent(in) :: node(:)       !! (nf) control points from 1
    real(wp), intent(in) :: c(:, :)      !! (nf, nb)
    type(spline_surface_t), intent(inout) :: s
    type(error_t), allocatable, intent(out) :: error
    integer :: a, b, e, first, last

    e = s%nelem + 1
    do a = 1, size(node)
      if (node(a) >= 1 .and. node(a) <= s%nnode) cycle
      call fail_in_file(text, 'element '//to_text(e)//' refers to control point ' &
                        //to_text(node(a))//', but the surface has control points 1 to ' &
                        //to_text(s%nnode), error, &
                        'elements and control points are counted from 1 in this message')
      return
    end do
    do b = 1, size(c, 2)
      if (abs(sum(c(:, b)) - 1.0_wp) <= UNITY) cycle
      call fail_in_file(text, 'the coefficients of Bernstein polynomial '//to_text(b)//' in the ' &
                        //'functions of element '//to_text(e)//' sum to '//to_text(sum(c(:, b))), &
                        error, 'the sum must be 1 for each polynomial; a coefficient may be ' &
                        //'missing or have too few digits')
      return
    end do
    first = s%first(e)
    last = first + size(node) - 1
    call grow(s%node, last)
    s%node(first:last) = node
    s%first(e + 1) = last + 1
    s%degree(:, e) = degree
    call find_operator(s, c, s%iop(e))
    s%nelem = e
  end subroutine add_element

  !> Check the degrees and the number of functions of an element before anything is allocated for
  !! it.
  subroutine check_sizes(text, e, degree, nf, error)
    type(text_t), intent(in) :: text
    integer, intent(in) :: e, degree(2), nf
    type(error_t), allocatable, intent(out) :: error

    if (any(degree < 1 .or. degree > MAX_DEGREE)) then
      call fail_in_file(text, 'element '//to_text(e)//' has degrees '//to_text(degree(1))//' and ' &
                        //to_text(degree(2)), error, 'degrees must be from 1 to ' &
                        //to_text(MAX_DEGREE))
    else if (nf < 1 .or. nf > MOST_FUNCTIONS) then
      call fail_in_file(text, 'element '//to_text(e)//' has '//to_text(nf)//' functions', error, &
                        'an element may have 1 to '//to_text(MOST_FUNCTIONS)//' functions')
    end if
  end subroutine check_sizes

  !> Find the index of operator c, and store c if it is new; equal operators are stored once.
  subroutine find_operator(s, c, iop)
    type(spline_surface_t), intent(inout) :: s
    real(wp), intent(in) :: c(:, :)
    integer, intent(out) :: iop
    type(operator_t), allocatable :: more(:)
    integer :: i, k

    k = int(mod(hash(c), int(size(s%slot), i8))) + 1
    do
      iop = s%slot(k)
      if (iop == 0) exit
      if (all(shape(s%op(iop)%c) == shape(c))) then
        if (.not. any(abs(s%op(iop)%c - c) > 0.0_wp)) return
      end if
      k = mod(k, size(s%slot)) + 1
    end do
    if (s%nop == size(s%op)) then
      allocate (more(2*s%nop))
      do i = 1, s%nop
        call move_alloc(s%op(i)%c, more(i)%c)
      end do
      call move_alloc(more, s%op)
    end if
    s%nop = s%nop + 1
    s%op(s%nop)%c = c
    s%slot(k) = s%nop
    iop = s%nop
  end subroutine find_operator

  !> A hash key, which is the same for equal operators.
  pure integer(i8) function hash(c)
    real(wp), intent(in) :: c(:, :)
    integer(i8), parameter :: FACTOR = 1000003_i8, MODULUS = 2147483647_i8
    integer(i8) :: bits
    integer :: a, b

    hash = size(c, 1)
    do b = 1, size(c, 2)
      do a = 1, size(c, 1)
        bits = transfer(c(a, b) + 0.0_wp, bits) ! adding zero gives both zeros the same bits
        bits = iand(ieor(bits, ishft(bits, -31)), MODULUS)
        hash = mod(hash*FACTOR + bits, MODULUS)
      end do
    end do
  end function hash

  !> Check that the surface has elements, and find out whether it is rational.
  subroutine finish_surface(text, s, error)
    type(text_t), intent(in) :: text
    type(spline_surface_t), intent(inout) :: s
    type(error_t), allocatable, intent(out) :: error
    real(wp), parameter :: ALIKE = 10*epsilon(1.0_wp)

    if (s%nelem == 0) then
      call fail_in_file(text, 'the surface has no elements', error)
      return
    end if
    s%rational = maxval(s%w) - minval(s%w) > ALIKE*maxval(s%w)
    deallocate (s%slot)
  end subroutine finish_surface

  !> Exchange the two directions of all elements, which reverses the normals.
  subroutine transpose_surface(s)
    type(spline_surface_t), intent(inout) :: s
    type(spline_surface_t) :: t
    real(wp), allocatable :: c(:, :)
    integer :: e, i, j, p, q

    call start_surface(0, s%nelem, t)
    do e = 1, s%nelem
      p = s%degree(1, e)
      q = s%degree(2, e)
      associate (old => s%op(s%iop(e))%c)
        allocate (c, mold=old)
        do j = 0, q
          do i = 0, p
            c(:, 1 + j + (q + 1)*i) = old(:, 1 + i + (p + 1)*j)
          end do
        end do
      end associate
      call find_operator(t, c, t%iop(e))
      deallocate (c)
    end do
    s%degree = s%degree([2, 1], :)
    s%nop = t%nop
    call move_alloc(t%iop, s%iop)
    call move_alloc(t%op, s%op)
  end subroutine transpose_surface

end module spline_surface
