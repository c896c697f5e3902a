!> Points of the view as linear combinations of nodes. Equal combinations become one point.
module view_points
  use base_kinds, only: wp, i8
  implicit none
  private
  public :: point_list_t, add_point, finish_points

  real(wp), parameter :: SAME = 1.0e-10_wp !! largest difference between equal coefficients [-]
  real(wp), parameter :: ROUNDING = 1.0e-12_wp !! a coefficient counts as zero below this, relative
  !! to the largest [-]

  type :: point_list_t
    integer :: npoint = 0
    integer, allocatable :: first(:)   !! (npoint+1) first entry of each point
    integer, allocatable :: node(:)    !! ascending within a point
    real(wp), allocatable :: coef(:)   !! coefficients of the nodes [-]
    real(wp), allocatable :: weight(:) !! (npoint) rational weight [-]
    integer, allocatable, private :: next(:), head(:) !! linked lists of points with the same hash
    !! value
  end type point_list_t

contains

  !> Find the number of the point with this combination, which is added if it is new.
  subroutine add_point(list, node, coef, weight, id)
    type(point_list_t), intent(inout) :: list
    integer, intent(in) :: node(:)     !! a node may occur twice
    real(wp), intent(in) :: coef(:)
    real(wp), intent(in) :: weight
    integer, intent(out) :: id
    integer :: i, n, slot, room
    integer :: nodes(size(node))
    real(wp) :: coefs(size(node))

    call simplify(node, coef, nodes, coefs, n)
    if (.not. allocated(list%first)) call start(list)
    slot = hash(nodes(:n), size(list%head))
    id = list%head(slot)
    do while (id > 0)
      if (is_same(list, id, nodes(:n), coefs(:n), weight)) return
      id = list%next(id)
    end do
    if (list%npoint + 2 > size(list%first)) then ! double the space and the number of linked lists
      room = 2*size(list%first)
      list%first = [list%first, list%first]
      list%weight = [list%weight, list%weight]
      list%next = [list%next, list%next]
      deallocate (list%head)
      allocate (list%head(room), source=0)
      do id = 1, list%npoint
        slot = hash(list%node(list%first(id):list%first(id + 1) - 1), room)
        list%next(id) = list%head(slot)
        list%head(slot) = id
      end do
    end if
    slot = hash(nodes(:n), size(list%head))
    id = list%npoint + 1
    list%npoint = id
    list%first(id + 1) = list%first(id) + n
    if (list%first(id + 1) > size(list%node)) then
      list%node = [list%node(:list%first(id) - 1), (0, i=1, 2*n + list%first(id))]
      list%coef = [list%coef(:list%first(id) - 1), (0.0_wp, i=1, 2*n + list%first(id))]
    end if
    list%node(list%first(id):list%first(id + 1) - 1) = nodes(:n)
    list%coef(list%first(id):list%first(id + 1) - 1) = coefs(:n)
    list%weight(id) = weight
    list%next(id) = list%head(slot)
    list%head(slot) = id
  end subroutine add_point

  !> Reduce the arrays to their contents.
  subroutine finish_points(list)
    type(point_list_t), intent(inout) :: list

    if (.not. allocated(list%first)) call start(list)
    list%first = list%first(:list%npoint + 1)
    list%node = list%node(:list%first(list%npoint + 1) - 1)
    list%coef = list%coef(:list%first(list%npoint + 1) - 1)
    list%weight = list%weight(:list%npoint)
    deallocate (list%next, list%head)
  end subroutine finish_points

  !> Sort the nodes, add the coefficients of equal nodes, and drop coefficients that are only
  !! rounding errors.
  pure subroutine simplify(node, coef, nodes, coefs, n)
    integer, intent(in) :: node(:)
    real(wp), intent(in) :: coef(:)
    integer, intent(out) :: nodes(:)
    real(wp), intent(out) :: coefs(:)
    integer, intent(out) :: n
    real(wp) :: limit
    integer :: i, j

    limit = ROUNDING*maxval(abs(coef))
    n = 0
    do i = 1, size(node)
      if (abs(coef(i)) <= limit) cycle
      j = n
      do while (j > 0)
        if (nodes(j) <= node(i)) exit
        j = j - 1
      end do
      if (j > 0) then
        if (nodes(j) == node(i)) then
          coefs(j) = coefs(j) + coef(i)
          cycle
        end if
      end if
      nodes(j + 2:n + 1) = nodes(j + 1:n)
      coefs(j + 2:n + 1) = coefs(j + 1:n)
      nodes(j + 1) = node(i)
      coefs(j + 1) = coef(i)
      n = n + 1
    end do
  end subroutine simplify

  pure function hash(node, nslot) result(slot)
    integer, intent(in) :: node(:)
    integer, intent(in) :: nslot
    integer :: slot
    integer(i8) :: h
    integer :: i

    h = 17
    do i = 1, size(node)
      h = modulo(h*131071_i8 + node(i), 2147483629_i8)
    end do
    slot = 1 + int(modulo(h, int(nslot, i8)))
  end function hash

  pure function is_same(list, id, node, coef, weight)
    type(point_list_t), intent(in) :: list
    integer, intent(in) :: id
    integer, intent(in) :: node(:)
    real(wp), intent(in) :: coef(:)
    real(wp), intent(in) :: weight
    logical :: is_same
    integer :: i, n

    i = list%first(id)
    n = list%first(id + 1) - i
    is_same = n == size(node)
    if (is_same) is_same = all(list%node(i:i + n - 1) == node)
    if (is_same) is_same = all(abs(list%coef(i:i + n - 1) - coef) <= SAME)
    if (is_same) is_same = abs(list%weight(id) - weight) <= SAME*abs(weight)
  end function is_same

  subroutine start(list)
    type(point_list_t), intent(inout) :: list

    allocate (list%first(1024), list%weight(1024), list%next(1024), list%head(1024))
    allocate (list%node(8192), list%coef(8192))
    list%first(1) = 1
    list%head = 0
  end subroutine start

end module view_points
